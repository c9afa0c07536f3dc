"""The FMU's library for each platform: its exports and dependencies, its signature and, where there is an emulator, its
results.

`release/libraries.py` builds the libraries for other platforms; those not in the FMU are skipped.
"""

import hashlib
import os
import pathlib
import re
import runpy
import shutil
import struct
import subprocess
import sys
import zipfile

import pytest

lief = pytest.importorskip("lief", reason="lief is not installed")
fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
from test_fmu_clients import fmu  # noqa: E402, F401
from test_fmu_rust_clients import push_and_hold  # noqa: E402

FUNCTIONS = {"fmi2": 44, "fmi3": 75}  # both standards, complete
OLDEST_GLIBC = (2, 17)


@pytest.fixture
def library(fmu, tmp_path):  # noqa: F811
    def unpack(name):
        with zipfile.ZipFile(fmu) as archive:
            found = [entry for entry in archive.namelist() if entry.startswith(f"binaries/{name}/")]
            if not found:
                pytest.skip(f"this FMU has no library for {name}: run release/libraries.py {name}, then cargo build --release")
            assert len(found) == 1, found
            return pathlib.Path(archive.extract(found[0], tmp_path))

    return unpack


def only_fmi(names):
    names = [str(name) for name in names]
    assert {prefix: sum(name.startswith(prefix) for name in names) for prefix in FUNCTIONS} == FUNCTIONS, names
    assert len(names) == sum(FUNCTIONS.values()), names


@pytest.mark.parametrize("name", ["linux64", "aarch64-linux"])
def test_the_library_for_linux_needs_the_c_library_alone(library, name):
    """GCC's runtime, which small containers lack, is linked statically."""
    needed = lief.ELF.parse(str(library(name))).libraries
    assert needed and all(re.match(r"lib(m|c|dl|pthread)\.so|ld-linux", lib) for lib in needed), needed


@pytest.mark.parametrize("name", ["linux64", "aarch64-linux"])
def test_the_library_for_linux_exports_fmi_alone_and_runs_with_old_glibc(library, root, name):
    path = library(name)
    binary = lief.ELF.parse(str(path))
    assert binary.header.machine_type.name == {"linux64": "X86_64", "aarch64-linux": "AARCH64"}[name]
    only_fmi(symbol.name for symbol in binary.dynamic_symbols if symbol.exported)
    assert not re.search(rb"/(root|home|work|tmp)/", path.read_bytes()), "a path of the machine that built it"
    versions = [aux.name for needed in binary.symbols_version_requirement for aux in needed.get_auxiliary_symbols()]
    versions = [tuple(map(int, version[6:].split("."))) for version in versions if version.startswith("GLIBC_2")]
    made_of = root / "fmu" / "binaries" / name / "sources"
    libraries = runpy.run_path(str(root / "release" / "libraries.py"))
    if not made_of.exists() or made_of.read_text().strip() != libraries["fingerprint"]():
        pytest.skip(f"built for this machine's glibc (needs {max(versions)}): release/libraries.py {name} is for 2.17")
    assert max(versions) <= OLDEST_GLIBC, versions


def test_the_library_for_windows_exports_fmi_alone(library):
    path = library("win64")
    binary = lief.PE.parse(str(path))
    assert binary.header.machine.name == "AMD64"
    only_fmi(function.name for function in binary.exported_functions)
    assert all(re.match(r"(?i)(kernel32|ntdll|bcryptprimitives|api-ms-win-.*)\.dll", i.name) for i in binary.imports)
    assert not re.search(rb"/(root|home|work|tmp)/", path.read_bytes()), "a path of the machine that built it"


@pytest.mark.parametrize(("name", "kinds"), [("darwin64", ["X86_64", "ARM64"]), ("aarch64-darwin", ["ARM64"])])
def test_the_library_for_macos_exports_fmi_alone_and_its_signature_holds(library, name, kinds):
    path = library(name)
    universal = lief.MachO.parse(str(path))  # owns its parts
    binaries = [universal.at(i) for i in range(universal.size)]
    assert [binary.header.cpu_type.name for binary in binaries] == kinds
    for binary in binaries:
        only_fmi(symbol.name.removeprefix("_") for symbol in binary.exported_symbols)
        assert {lib.name for lib in binary.libraries} == {"@rpath/Chamber.dylib", "/usr/lib/libSystem.B.dylib"}
        content = path.read_bytes()[binary.fat_offset :][: binary.original_size]
        if binary.has_code_signature:
            check_signature(content, binary.code_signature.data_offset)
        # Intel processors run unsigned code, Apple's do not.
        assert binary.has_code_signature or binary.header.cpu_type.name == "X86_64"


def check_signature(content, at):
    """Every page's hash matches the page: what macOS checks before it runs code."""
    magic, _, count = struct.unpack_from(">III", content, at)
    assert magic == 0xFADE0CC0
    blobs = [at + struct.unpack_from(">II", content, at + 12 + 8 * i)[1] for i in range(count)]
    directory = next(blob for blob in blobs if struct.unpack_from(">I", content, blob)[0] == 0xFADE0C02)
    flags, hashes, _, _, slots, limit = struct.unpack_from(">IIIIII", content, directory + 12)
    size, kind, _, page = struct.unpack_from("BBBB", content, directory + 36)
    assert flags & 2 and (size, kind) == (32, 2) and limit == at, "ad hoc, SHA-256, all that precedes it"
    found = [content[directory + hashes + 32 * i :][:32] for i in range(slots)]
    step = 1 << page
    assert found == [hashlib.sha256(content[i : min(i + step, limit)]).digest() for i in range(0, limit, step)]


EMULATORS = {
    "linux64": (None, "x86_64-linux-gnu", []),
    "aarch64-linux": ("qemu-aarch64", "aarch64-linux-gnu", ["-L", "/usr/aarch64-linux-gnu"]),
    "win64": ("wine64", "x86_64-windows-gnu", []),
}


@pytest.mark.parametrize("name", EMULATORS)
def test_a_host_in_c_reads_the_same_numbers_on_every_platform(fmu, library, root, tmp_path, name):  # noqa: F811
    emulator, target, options = EMULATORS[name]
    path = library(name)
    program = emulator and (shutil.which(emulator) or shutil.which(emulator, path="/usr/lib/wine"))
    if emulator and not program:
        pytest.skip(f"{emulator} is not installed: the library for {name} is checked without running it")
    if emulator == "qemu-aarch64" and not pathlib.Path(options[1]).exists():
        pytest.skip("the C library for aarch64 is not installed (Debian: libc6-arm64-cross)")
    zig = next(root.glob("target/libraries/tools/[bS]*/python*"), None)
    compiler = [str(zig), "-m", "ziglang", "cc", "-target", target] if zig else ["cc"]
    if emulator and not zig:
        pytest.skip("Zig, with which release/libraries.py builds, is not here to compile a host")
    host = tmp_path / "host.exe"
    source = root / "tests" / "clients" / "host.c"
    subprocess.run([*compiler, "-O1", "-o", host, source, *([] if name == "win64" else ["-ldl"])], check=True)
    description = fmpy.read_model_description(str(fmu))
    references = {v.name: str(v.valueReference) for v in description.modelVariables}
    names = ["position", "velocity", "pressure", "temperature", "heatFlow"]
    environment = {**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    command = [*([program, *options] if emulator else []), host, path.relative_to(tmp_path), description.guid,
               *(references[name] for name in names)]
    run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    rows = [[struct.unpack(">d", bytes.fromhex(word))[0] for word in line.split()] for line in run.stdout.splitlines()]
    expected = [row[3:] for row in push_and_hold(fmu)]
    assert len(rows) == len(expected) and "position" in run.stderr, run.stderr
    for k, (found, reference) in enumerate(zip(rows, expected, strict=True)):
        # The same code with the exp and pow of another C library.
        assert found == pytest.approx(reference, rel=1e-12, abs=1e-9), k


def test_what_cannot_be_built_is_left_out_with_a_reason(root):
    def libraries(*names):
        command = [sys.executable, root / "release" / "libraries.py", *names]
        return subprocess.run(command, env={"PATH": "/nowhere"}, capture_output=True, text=True)

    run = libraries("aarch64-darwin")
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("aarch64-darwin: left out. Rust: rustc cannot be run (No such file or directory)\n")
    run = libraries("solaris")
    assert run.returncode == 2 and "no such platform: solaris; there are linux64, win64" in run.stderr
