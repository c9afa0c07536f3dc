//! Builds the FMU's shared library and hands it to the program, which carries it inside (`src/fmu_of_model.rs`).
//!
//! A library must be a `cdylib` of its own, optimised as a whole; Cargo builds none for a dependency. So this runs Cargo
//! once more, for `fmu/cdylib`, into a target folder of its own under `OUT_DIR`. Libraries for other platforms, and one
//! for older glibc, are taken from `fmu/binaries/` where `release/libraries.py` has put them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// FMI's names of platforms, and what their libraries end in.
const PLATFORMS: [(&str, &str); 5] =
    [("linux64", "so"), ("win64", "dll"), ("darwin64", "dylib"), ("aarch64-linux", "so"), ("aarch64-darwin", "dylib")];

/// What a library is made of; `release/libraries.py` has the same list.
const SOURCES: [&str; 4] = ["chamber/src", "fmu/cdylib/src", "fmu/src", "modelDescription/guid.txt"];

fn main() {
    let root = PathBuf::from(variable("CARGO_MANIFEST_DIR"));
    for source in SOURCES.iter().chain(&[
        "build.rs", "Cargo.toml", "fmu/binaries", "fmu/Cargo.toml", "fmu/cdylib/Cargo.toml", "chamber/Cargo.toml",
    ]) {
        println!("cargo::rerun-if-changed={source}");
    }
    let out = PathBuf::from(variable("OUT_DIR"));
    let fingerprint = fingerprint(&root).expect("the sources can be read");
    let mut libraries = Vec::new();
    for (platform, extension) in PLATFORMS {
        let folder = root.join("fmu/binaries").join(platform);
        let ready = folder.join(format!("Chamber.{extension}"));
        if !ready.is_file() {
            continue;
        }
        if fs::read_to_string(folder.join("sources")).is_ok_and(|made_of| made_of.trim() == fingerprint) {
            libraries.push((platform, extension, ready));
        } else {
            println!(
                "cargo::warning={} is not of the present sources and left out of the FMU: run release/libraries.py {platform}",
                ready.display()
            );
        }
    }
    if let Some((platform, extension)) = own_platform()
        && !libraries.iter().any(|(ready, _, _)| *ready == platform)
    {
        libraries.push((platform, extension, build_library(&root, &out, extension)));
    }
    fs::write(out.join("libraries.rs"), table(&libraries)).expect("OUT_DIR can be written");
}

/// FNV-1a of names and contents of the sources, as `release/libraries.py` computes it.
fn fingerprint(root: &Path) -> io::Result<String> {
    fn collect(path: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
        if path.is_file() {
            files.push(path.into());
            return Ok(());
        }
        fs::read_dir(path)?.try_for_each(|entry| collect(&entry?.path(), files))
    }
    let mut files = Vec::new();
    SOURCES.iter().try_for_each(|source| collect(&root.join(source), &mut files))?;
    let name = |file: &PathBuf| file.strip_prefix(root).unwrap_or(file).to_string_lossy().replace('\\', "/");
    files.sort_by_key(name);
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in &files {
        for byte in [name(file).as_bytes(), b"\0", &fs::read(file)?, b"\0"].concat() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    Ok(format!("{hash:016x}"))
}

/// The platform this program is built for, in FMI's terms.
fn own_platform() -> Option<(&'static str, &'static str)> {
    let name = match (variable("CARGO_CFG_TARGET_OS").as_str(), variable("CARGO_CFG_TARGET_ARCH").as_str()) {
        ("linux", "x86_64") => "linux64",
        ("windows", "x86_64") => "win64",
        ("macos", "x86_64") => "darwin64",
        ("linux", "aarch64") => "aarch64-linux",
        ("macos", "aarch64") => "aarch64-darwin",
        _ => return None,
    };
    PLATFORMS.into_iter().find(|(platform, _)| *platform == name)
}

/// Runs Cargo for `fmu/cdylib`; returns the library's path.
fn build_library(root: &Path, out: &Path, extension: &str) -> PathBuf {
    let target_folder = out.join("fmu");
    let target = variable("TARGET");
    let flags = if variable("CARGO_CFG_TARGET_OS") == "linux" { static_libgcc(out) } else { None };
    let status = Command::new(variable("CARGO"))
        .args(["build", "--profile", "fmu", "--locked", "--package", "pneutherm-fmu-cdylib", "--target", &target])
        .arg("--manifest-path")
        .arg(root.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(&target_folder)
        .env_remove("RUSTFLAGS")
        .env("CARGO_ENCODED_RUSTFLAGS", flags.unwrap_or_default())
        .env_remove("CARGO_MAKEFLAGS")
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .status()
        .expect("Cargo can be run");
    assert!(status.success(), "the FMU's library could not be built: see Cargo's message above");
    let prefix = if extension == "dll" { "" } else { "lib" };
    target_folder.join(target).join("fmu").join(format!("{prefix}Chamber.{extension}"))
}

/// Flags with which GCC's runtime is linked into the library, so that a machine without `libgcc_s` can load it; `None` where
/// the C compiler has none to link. Rust asks for `-lgcc_s` by name, which `-static-libgcc` leaves as it is: so a linker
/// script of that name stands before it and means the static one.
fn static_libgcc(out: &Path) -> Option<String> {
    let compiler = env::var("CC").unwrap_or_else(|_| "cc".into());
    let found = Command::new(compiler).arg("-print-file-name=libgcc_eh.a").output().ok()?;
    let library = PathBuf::from(String::from_utf8(found.stdout).ok()?.trim());
    if !library.is_absolute() || !library.is_file() {
        println!("cargo::warning=no libgcc_eh.a: the FMU's library needs libgcc_s where it is loaded");
        return None;
    }
    let folder = out.join("static-libgcc");
    fs::create_dir_all(&folder).expect("OUT_DIR can be written");
    fs::write(folder.join("libgcc_s.so"), "INPUT(-lgcc_eh -lgcc)\n").expect("OUT_DIR can be written");
    Some(format!("-Lnative={}", folder.display()))
}

/// Source text of the table of libraries.
fn table(libraries: &[(&str, &str, PathBuf)]) -> String {
    let mut text = String::from("&[\n");
    for (platform, extension, path) in libraries {
        let _ = writeln!(
            text,
            "    fmu::package::Library {{ platform: {platform:?}, extension: {extension:?}, bytes: include_bytes!({path:?}) }},"
        );
    }
    text + "]\n"
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("Cargo sets {name}"))
}
