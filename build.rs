//! Builds the FMU's shared library and hands it to the program, which carries it inside (`src/commands/fmu.rs`).
//!
//! A library must be a `cdylib` of its own, optimised as a whole; Cargo builds none for a dependency. So this runs Cargo
//! once more, for `fmu/cdylib`, into a target folder of its own under `OUT_DIR`. Libraries for other platforms, and one
//! for older glibc, are taken from `fmu/binaries/` where they lie ready: see the page there.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// FMI's names of platforms, and what their libraries end in.
const PLATFORMS: [(&str, &str); 5] =
    [("linux64", "so"), ("win64", "dll"), ("darwin64", "dylib"), ("aarch64-linux", "so"), ("aarch64-darwin", "dylib")];

fn main() {
    let root = PathBuf::from(variable("CARGO_MANIFEST_DIR"));
    for source in [
        "build.rs",
        "fmu/src",
        "fmu/cdylib",
        "fmu/binaries",
        "fmu/Cargo.toml",
        "chamber/src",
        "chamber/Cargo.toml",
        "modelDescription/guid.txt",
    ] {
        println!("cargo::rerun-if-changed={source}");
    }
    let out = PathBuf::from(variable("OUT_DIR"));
    let mut libraries = Vec::new();
    for (platform, extension) in PLATFORMS {
        let ready = root.join("fmu/binaries").join(platform).join(format!("Chamber.{extension}"));
        if ready.is_file() {
            libraries.push((platform, extension, ready));
        }
    }
    if let Some((platform, extension)) = own_platform()
        && !libraries.iter().any(|(ready, _, _)| *ready == platform)
    {
        libraries.push((platform, extension, build_library(&root, &out, extension)));
    }
    fs::write(out.join("libraries.rs"), table(&libraries)).expect("OUT_DIR can be written");
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
    let status = Command::new(variable("CARGO"))
        .args(["build", "--release", "--locked", "--package", "pneutherm-fmu-cdylib", "--target", &target])
        .args(["--config", "profile.release.lto='fat'", "--config", "profile.release.codegen-units=1"])
        .args(["--config", "profile.release.strip='symbols'"])
        .arg("--manifest-path")
        .arg(root.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(&target_folder)
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_MAKEFLAGS")
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .status()
        .expect("Cargo can be run");
    assert!(status.success(), "the FMU's library could not be built: see Cargo's message above");
    let prefix = if extension == "dll" { "" } else { "lib" };
    target_folder.join(target).join("release").join(format!("{prefix}Chamber.{extension}"))
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
