"""Hostile files and environments: an error message within bounded time and memory, and never a partial file under a result's
name."""

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile

import pytest

from conftest import PROGRAM

if sys.platform == "win32":
    pytest.skip("signals, devices and mounts as POSIX has them", allow_module_level=True)

MEMORY = 256 << 20
SECONDS = 20.0

STUDY = """
[study]
name = "abuse"
model = "model.toml"
design = "factorial"
[test]
initial_pressure_pa = 1.01e5
initial_stroke_m = 0.1
final_stroke_m = 0.05
push_time_s = 0.04
duration_s = 10.0
[vary]
bore_m = { from = 0.016, to = 0.063, count = 40, scale = "log" }
initial_pressure_pa = { from = 1.0e5, to = 7.0e5, count = 40 }
final_stroke_m = { from = 0.02, to = 0.09, count = 20 }
"""


@pytest.fixture
def rig(root, tmp_path):
    """The example's rig with one short experiment, in a separate folder."""
    folder = tmp_path / "rig"
    folder.mkdir()
    lines = (root / "examples/cylinder/compress-ambient-1.csv").read_text().splitlines(keepends=True)
    (folder / "one.csv").write_text("".join(lines))
    head = (root / "examples/cylinder/rig.toml").read_text().split("[[experiment]]")[0]
    (folder / "rig.toml").write_text(head + '[[experiment]]\nname = "one"\ntraces = ["one.csv"]\n')
    shutil.copy(root / "fuzz/corpus/model/leaking.toml", folder / "model.toml")
    (folder / "study.toml").write_text(STUDY)
    return folder


# A process's peak memory includes its parent's before exec: so the program's parent is a small process, independent of pytest's
# memory.
RUNNER = """
import os, resource, sys
code = os.spawnv(os.P_WAIT, sys.argv[2], sys.argv[2:])
with open(sys.argv[1], "w") as file:
    file.write(str(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss))
sys.exit(code if code >= 0 else 128 - code)
"""


def bounded(arguments, cwd):
    """Runs the program; returns exit code, standard error, peak memory (bytes) and seconds."""
    with tempfile.NamedTemporaryFile("r") as peak:
        begin = time.monotonic()
        process = subprocess.run(
            [sys.executable, "-S", "-E", "-c", RUNNER, peak.name, str(PROGRAM), *map(str, arguments)],
            cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )
        seconds = time.monotonic() - begin
        return process.returncode, process.stderr, int(peak.read()) * 1024, seconds


def assert_is_refused(arguments, cwd, *parts):
    code, message, memory, seconds = bounded(arguments, cwd)
    assert code == 1, message
    assert message.startswith("error: ") and message.count("\n") == 1, message
    for part in parts:
        assert part in message, message
    assert memory < MEMORY, f"{memory >> 20} MB"
    assert seconds < SECONDS, f"{seconds} s"


HOSTILE = {
    "empty": (lambda file: file.write(b""), "one.csv"),
    "a header alone": (lambda file: file.write(b"time_s,pressure_pa,position_m\n"), "no row"),
    "one row": (lambda file: file.write(b"time_s,pressure_pa,position_m\n0,1e5,0.1\n"), "1 row"),
    "two rows": (lambda file: file.write(b"time_s,pressure_pa,position_m\n0,1e5,0.1\n1,1e5,0.1\n"), "2 rows"),
    "binary": (lambda file: file.write(random.Random(1).randbytes(1 << 20)), "line 1"),
    "a program": (lambda file: file.write(PROGRAM.read_bytes()[: 1 << 22]), "line 1"),
    "2 GB of nothing": (lambda file: file.truncate(2 << 30), "MB"),
    "one line of 400 MB": (lambda file: (file.write(b"time_s"), file.truncate(400 << 20)), "line 1"),
    "decimal commas": (
        lambda file: file.write(b"time_s,pressure_pa,position_m\n0,00,1e5,0,1\n0,01,1e5,0,1\n0,02,1e5,0,1\n"),
        "comma",
    ),
    "decimal commas in a semicolon file": (lambda file: file.write(b"time_s;pressure_pa;position_m\n0,0;1e5;0,1\n"), ""),
}


@pytest.mark.parametrize("command", ["identify", "diagnose", "simulate"])
@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_trace_ends_in_a_sentence_and_writes_nothing(kind, command, rig):
    write, part = HOSTILE[kind]
    with open(rig / "one.csv", "wb") as file:
        write(file)
    before = sorted(rig.iterdir())
    arguments = ["model.toml", "--motion", "one.csv"] if command == "simulate" else ["rig.toml"]
    assert_is_refused([command, *arguments, "-o", "out"], rig, "one.csv", part)
    assert sorted(rig.iterdir()) == before


@pytest.mark.parametrize(
    "command", [["identify", "it"], ["simulate", "it", "--motion", "one.csv"], ["sweep", "it", "-o", "o"], ["fmu", "it"]]
)
@pytest.mark.parametrize("size", [2 << 30, 1 << 20], ids=["2 GB", "1 MB"])
def test_a_huge_or_binary_settings_file_ends_in_a_sentence(command, size, rig):
    with open(rig / "it", "wb") as file:
        file.write(random.Random(2).randbytes(1000))
        file.truncate(size)
    assert_is_refused(command, rig, "it: ")


@pytest.mark.parametrize("command", [["identify", "/dev/zero"], ["fmu", "/dev/zero"], ["sweep", "/dev/zero", "-o", "o"]])
def test_an_endless_settings_file_ends_in_a_sentence(command, rig):
    if not os.path.exists("/dev/zero"):
        pytest.skip("there is no /dev/zero here")
    assert_is_refused(command, rig, "/dev/zero")


def test_an_endless_trace_ends_in_a_sentence(rig):
    if not os.path.exists("/dev/zero"):
        pytest.skip("there is no /dev/zero here")
    assert_is_refused(["simulate", "model.toml", "--motion", "/dev/zero"], rig, "/dev/zero")


def complete(path):
    """Checks that a result file is complete."""
    if path.suffix == ".json":
        json.loads(path.read_text())
    elif path.suffix == ".fmu":
        with zipfile.ZipFile(path) as archive:
            assert archive.testzip() is None
    elif path.suffix in (".html", ".svg"):
        assert path.read_text().rstrip().endswith(f"</{path.suffix[1:]}>")
    elif path.suffix == ".toml":
        text = path.read_text()
        assert ("[heat_transfer]" in text or "[study]" in text) and text.endswith("\n")
    elif path.suffix in (".csv", ".md"):
        assert path.read_text().endswith("\n")
    elif path.suffix == ".parquet":
        import pyarrow.parquet

        pyarrow.parquet.read_metadata(path)
    else:
        raise AssertionError(f"{path.name} has an unknown ending")


KILLED = {
    "identify": ["identify", "rig.toml", "-o", "out/model.toml", "--json", "out/result.json"],
    "diagnose": ["diagnose", "rig.toml", "-o", "out/m.toml", "--json", "out/r.json", "--report", "out/r.html"],
    "simulate": ["simulate", "model.toml", "--motion", "one.csv", "-o", "out/table.csv"],
    "fmu": ["fmu", "model.toml", "-o", "out/Chamber.fmu"],
    "sweep": ["sweep", "study.toml", "-o", "out"],
    "reproduce": ["reproduce", "-o", "out"],
}


def results(out):
    """The results in a folder by name; unfinished files have names with a leading dot or are in a study's `parts`."""
    files = {str(path.relative_to(out)): path for path in out.rglob("*") if path.is_file()}
    return {name: path for name, path in files.items() if not path.name.startswith(".") and not name.startswith("parts/")}


@pytest.mark.parametrize("command", KILLED)
def test_what_is_killed_at_a_random_moment_leaves_no_half_written_result(command, rig):
    seed = random.randrange(1 << 30)
    print(f"seed {seed}")
    moments = random.Random(seed)
    out = rig / "out"
    out.mkdir()
    begin = time.monotonic()
    subprocess.run([PROGRAM, *KILLED[command]], cwd=rig, check=True, capture_output=True, timeout=300)
    whole = time.monotonic() - begin
    names = set(results(out))
    rounds = max(4, min(20, int(4.0 / whole)))
    for _ in range(rounds):
        shutil.rmtree(out)
        out.mkdir()
        process = subprocess.Popen(
            [PROGRAM, *KILLED[command]], cwd=rig, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(moments.uniform(0.0, 1.1 * whole))
        process.send_signal(signal.SIGKILL)
        process.wait()
        for name, path in results(out).items():
            assert name in names
            complete(path)
    if command == "sweep":
        # The leftovers can be continued to the same study.
        subprocess.run([PROGRAM, *KILLED[command]], cwd=rig, check=True, capture_output=True, timeout=300)
        assert set(results(out)) == names
        assert not [path for path in out.rglob(".*") if path.is_file()], "temporary files of killed runs remain"


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 64 kB."""
    folder = tmp_path / "small disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    if os.geteuid() != 0 or not shutil.which("mount") or subprocess.run(mount, capture_output=True).returncode != 0:
        pytest.skip("a small disk needs root and leave to mount")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


# The output of each command, into a folder given later.
WRITING = {
    "identify": lambda out: ["identify", "rig.toml", "-o", out],
    "identify --json": lambda out: ["identify", "rig.toml", "--json", out],
    "diagnose": lambda out: ["diagnose", "rig.toml", "-o", out],
    "diagnose --report": lambda out: ["diagnose", "rig.toml", "--report", out],
    "simulate": lambda out: ["simulate", "model.toml", "--motion", "one.csv", "-o", out],
    "fmu": lambda out: ["fmu", "model.toml", "-o", out],
    "sweep": lambda out: ["sweep", "study.toml", "-o", out],
    "reproduce": lambda out: ["reproduce", "-o", out],
}
INTO_A_FOLDER = ("sweep", "reproduce")


def fill(disk):
    """Fills the disk completely."""
    with open(disk / "filler", "wb", buffering=0) as file:
        try:
            while file.write(bytes(4096)):
                pass
        except OSError:
            pass


@pytest.mark.parametrize("command", WRITING)
def test_a_full_disk_is_named_and_what_stood_there_still_stands(command, rig, small_disk):
    out = small_disk / "out"
    if command in INTO_A_FOLDER:
        out.mkdir()
    else:
        out.write_text("old")
    fill(small_disk)
    code, message, _, _ = bounded(WRITING[command](out), rig)
    assert code == 1 and "No space left" in message and str(small_disk) in message, message
    *notes, error = message.splitlines()
    assert error.startswith("error: ") and all(note.startswith("note: ") for note in notes), message
    if command in INTO_A_FOLDER:
        assert not results(out)
    else:
        assert out.read_text() == "old"
    assert sorted(path.name for path in small_disk.iterdir()) == ["filler", "out"]


@pytest.mark.parametrize("command", WRITING)
def test_a_read_only_disk_is_named(command, rig, small_disk):
    (small_disk / "old").write_text("old")
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    code, message, _, _ = bounded(WRITING[command](small_disk / "out"), rig)
    assert code == 1 and "Read-only file system" in message and str(small_disk) in message, message
    assert message.startswith("error: ") and message.count("\n") == 1, message


@pytest.mark.parametrize("place", ["a folder", "write-protected", "absent/out"])
@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_a_place_where_no_result_can_go_is_named_before_the_work(command, place, rig):
    out = rig / place
    if place == "a folder":
        out.mkdir()
    elif place == "write-protected":
        out.write_text("kept")
        out.chmod(0o444)
    # Without the check, the work would end with the refusal of a record.
    (rig / "one.csv").write_text("time_s,pressure_pa,position_m\n" + "".join(f"{k / 100},1e5,0.1\n" for k in range(100)))
    before = sorted(rig.iterdir())
    code, message, _, _ = bounded([command, "rig.toml", "-o", out], rig)
    assert code == 1 and message.startswith(f"error: {out}: cannot be written: ") and message.count("\n") == 1, message
    assert sorted(rig.iterdir()) == before and (place != "write-protected" or out.read_text() == "kept")


def test_a_study_for_standard_output_is_refused(rig):
    assert_is_refused(["sweep", "study.toml", "-o", "-"], rig, "name a folder")
    assert not (rig / "-").exists()


def test_names_with_spaces_umlauts_and_bytes_that_are_no_text_are_names(rig):
    folder = os.fsencode(rig.parent) + b"/Pr\xfcfstand 3, \xe2\x82\xac"
    os.rename(rig, folder)
    model = os.path.join(folder, b"my \xff model.toml")
    for arguments in [
        [b"identify", folder, b"-o", model, b"--json", os.path.join(folder, b"r.json")],
        [b"simulate", model, b"--motion", os.path.join(folder, b"one.csv"), b"-o", os.path.join(folder, b"o \xfe.csv")],
        [b"fmu", model, b"-o", os.path.join(folder, b"C \xfe.fmu")],
        [b"diagnose", folder, b"--report", os.path.join(folder, b"R \xfe.html")],
        [b"sweep", os.path.join(folder, b"study.toml"), b"-o", os.path.join(folder, b"S \xfe")],
        [b"reproduce", b"-o", os.path.join(folder, b"P \xfe")],
    ]:
        process = subprocess.run([os.fsencode(PROGRAM), *arguments], capture_output=True, timeout=300)
        assert process.returncode == 0, process.stderr
    written = {b"my \xff model.toml", b"o \xfe.csv", b"C \xfe.fmu", b"R \xfe.html", b"S \xfe", b"P \xfe"}
    assert written <= set(os.listdir(folder))


def test_little_memory_ends_in_a_sentence_or_success(rig):
    """An address space of 1 GB suffices for the largest file accepted."""
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))  # noqa: E731
    process = subprocess.run(
        [PROGRAM, "identify", "rig.toml"], cwd=rig, capture_output=True, text=True, preexec_fn=limit, timeout=300
    )
    assert process.returncode == 0, process.stderr
