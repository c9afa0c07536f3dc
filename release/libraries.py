#!/usr/bin/env python3
"""Builds the FMU's library for every platform into fmu/binaries/; the next build of the program puts them into its FMUs.

    python3 release/libraries.py                      # all five
    python3 release/libraries.py win64 aarch64-linux  # these

Needs Rust with `rustup`, Python and the package registries; no other compiler and no SDK. Linux (for glibc 2.17 and
later) and Windows are linked by Zig through cargo-zigbuild, macOS by the LLD that comes with Rust. A platform that cannot
be built here is left out with a sentence that says why; the others are built all the same. The same sources and the same
Rust give the same bytes.
"""

import dataclasses
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
OUT = ROOT / "fmu" / "binaries"
WORK = ROOT / "target" / "libraries"
TOOLS = ("ziglang==0.17.1", "cargo-zigbuild==0.24.0")
# What a library is made of: `build.rs` takes one for another platform only if it is of these very files.
SOURCES = ("chamber/src", "fmu/cdylib/src", "fmu/src", "modelDescription/guid.txt")


class Missing(Exception):
    """Why a platform is left out: one sentence."""


@dataclasses.dataclass(frozen=True)
class Platform:
    """FMI's name of a platform, its library's extension, and Rust's targets in it."""

    name: str
    extension: str
    targets: tuple[str, ...]


PLATFORMS = [
    Platform("linux64", "so", ("x86_64-unknown-linux-gnu",)),
    Platform("win64", "dll", ("x86_64-pc-windows-gnu",)),
    Platform("darwin64", "dylib", ("x86_64-apple-darwin", "aarch64-apple-darwin")),
    Platform("aarch64-linux", "so", ("aarch64-unknown-linux-gnu",)),
    Platform("aarch64-darwin", "dylib", ("aarch64-apple-darwin",)),
]


def run(command, what, **environment):
    """Runs a command; its output goes to a log, its last error line into the sentence."""
    log = WORK / "log.txt"
    with log.open("a") as out:
        out.write(f"$ {' '.join(map(str, command))}\n")
    try:
        process = subprocess.run(
            command, cwd=ROOT, env={**os.environ, **environment}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
    except OSError as error:
        raise Missing(f"{what}: {command[0]} cannot be run ({error.strerror})") from error
    with log.open("a") as out:
        out.write(process.stdout)
    if process.returncode != 0:
        errors = [line for line in process.stdout.splitlines() if re.match(r"\s*(error|ERROR)", line)]
        raise Missing(f"{what}: {(errors or ['no message'])[0].strip()} (see {log.relative_to(ROOT)})")
    return process.stdout


def tools():
    """The folder of Zig's and cargo-zigbuild's programs, installed from PyPI at the first use."""
    folder = WORK / "tools"
    stamp = folder / "installed"
    if not stamp.exists() or stamp.read_text() != " ".join(TOOLS):
        shutil.rmtree(folder, ignore_errors=True)
        run([sys.executable, "-m", "venv", folder], "Zig needs a Python environment")
        run([next(folder.glob("*/pip*")), "install", "--quiet", *TOOLS], "Zig is not to be had from PyPI")
        stamp.write_text(" ".join(TOOLS))
    return next(folder.glob("*/pip*")).parent


def zig_libraries():
    """Zig's description of macOS's system library."""
    python = next(tools().glob("python*"))
    where = run([python, "-c", "import ziglang; print(ziglang.__path__[0])"], "Zig").strip()
    return pathlib.Path(where) / "lib" / "libc" / "darwin" / "libSystem.tbd"


def exports():
    """A module definition with the functions of FMI: on Windows all else would be exported too."""
    sources = [path.read_text() for version in ("fmi2", "fmi3") for path in sorted((ROOT / "fmu/src" / version / "abi").glob("*.rs"))]
    functions = [name for source in sources for name in re.findall(r'extern "C" fn (fmi\w+)', source)]
    path = WORK / "exports.def"
    path.write_text("\n".join(["EXPORTS", *functions, ""]))
    return path


def mac_sdk():
    """A folder with what LLD must know of macOS: the names in its system library."""
    sdk = WORK / "macos"
    folder = sdk / "usr" / "lib"
    folder.mkdir(parents=True, exist_ok=True)
    # LLD reads no name of an architecture that is newer than itself.
    text = re.sub(r"arm64e\.\w+-", "arm64-", zig_libraries().read_text())
    for name in ("System", "c", "m", "iconv"):
        (folder / f"lib{name}.tbd").write_text(text)
    return sdk


def build(target):
    """Builds the library for one of Rust's targets; returns its path."""
    if shutil.which("rustup"):
        run(["rustup", "target", "add", target], f"Rust's standard library for {target} is not to be had")
    folder = WORK / "target"
    command = ["--profile", "fmu", "--locked", "--package", "pneutherm-fmu-cdylib", "--target-dir", folder]
    flags = []
    environment = {"CARGO_INCREMENTAL": "0"}
    if "apple" in target:
        host = re.search(r"host: (\S+)", run(["rustc", "-vV"], "Rust"))[1]
        sysroot = run(["rustc", "--print", "sysroot"], "Rust").strip()
        linker = next(pathlib.Path(sysroot, "lib", "rustlib", host, "bin").glob("rust-lld*"), None)
        if linker is None:
            raise Missing("this Rust comes without LLD (rust-lld), which links for macOS")
        environment["SDKROOT"] = str(mac_sdk())
        environment[f"CARGO_TARGET_{target.upper().replace('-', '_')}_LINKER"] = str(linker)
        flags += ["-Clinker-flavor=ld64.lld", "-Clink-arg=-install_name", "-Clink-arg=@rpath/Chamber.dylib"]
        command = ["cargo", "build", *command, "--target", target]
    else:
        environment["PATH"] = f"{tools()}{os.pathsep}{os.environ['PATH']}"
        if "windows" in target:
            flags += [f"-Clink-arg={exports()}", "-Clink-arg=-Wl,-Brepro"]
        version = ".2.17" if "linux" in target else ""
        command = ["cargo", "zigbuild", *command, "--target", target + version]
    environment["CARGO_ENCODED_RUSTFLAGS"] = "\x1f".join(flags)
    run(command, f"Cargo could not build for {target}", **environment)
    return next(path for path in (folder / target / "fmu").glob("*Chamber.*") if path.suffix in (".so", ".dll", ".dylib"))


def universal(slices):
    """A Mach-O universal file: each architecture's library at a multiple of 16 KiB."""
    align = 14
    header = struct.pack(">II", 0xCAFEBABE, len(slices))
    body, at = b"", 1 << align
    for library in slices:
        kind, subkind = struct.unpack_from("<II", library, 4)
        header += struct.pack(">IIIII", kind, subkind, at, len(library), align)
        body += library + bytes(-len(library) % (1 << align))
        at = (1 << align) + len(body)
    return header.ljust(1 << align, b"\0") + body if len(slices) > 1 else slices[0]


def fingerprint():
    """FNV-1a of names and contents of the sources, as `build.rs` computes it."""
    files = []
    for source in SOURCES:
        path = ROOT / source
        files += [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
    value = 0xCBF29CE484222325
    for name in sorted(file.relative_to(ROOT).as_posix() for file in files):
        for byte in name.encode() + b"\0" + (ROOT / name).read_bytes() + b"\0":
            value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}"


def main(names):
    wanted = [platform for platform in PLATFORMS if not names or platform.name in names]
    unknown = set(names) - {platform.name for platform in PLATFORMS}
    if unknown:
        print(f"no such platform: {', '.join(sorted(unknown))}; there are {', '.join(p.name for p in PLATFORMS)}", file=sys.stderr)
        return 2
    WORK.mkdir(parents=True, exist_ok=True)
    (WORK / "log.txt").unlink(missing_ok=True)
    for platform in wanted:
        made_of = fingerprint()
        try:
            library = universal([build(target).read_bytes() for target in platform.targets])
            if fingerprint() != made_of:
                raise Missing("the sources were changed while it was built")
        except Missing as reason:
            print(f"{platform.name}: left out. {reason}")
            continue
        folder = OUT / platform.name
        folder.mkdir(exist_ok=True)
        (folder / f"Chamber.{platform.extension}").write_bytes(library)
        (folder / "sources").write_text(made_of + "\n")
        print(f"{platform.name}: {len(library) / 1e3:.0f} kB")
    print("`cargo build --release` takes them into the program.")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
