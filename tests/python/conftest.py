"""Shared by all Python tests: the program under test and a way to call it."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def target() -> pathlib.Path:
    """Cargo's target folder, as set by CARGO_TARGET_DIR or a configuration file."""
    command = ["cargo", "metadata", "--no-deps", "--format-version", "1", "--offline"]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ROOT / "target"
    return pathlib.Path(json.loads(found.stdout)["target_directory"])


PROGRAM = pathlib.Path(os.environ.get("PNEUTHERM") or target() / "release" / "pneutherm")
if not PROGRAM.exists():
    pytest.exit(f"{PROGRAM} is not there: build it (cargo build --workspace --release), or name it in PNEUTHERM", 1)


def pytest_configure(config):
    config.addinivalue_line("markers", "alone: measures time, and so runs without other tests beside it (tests/run)")


def library() -> pathlib.Path:
    """The extension module of the Python package, from the tests' build of the workspace."""
    name = {"win32": "pneutherm_native.dll", "darwin": "libpneutherm_native.dylib"}.get(sys.platform, "libpneutherm_native.so")
    built = [path for path in (PROGRAM.parent / name, PROGRAM.parent / "deps" / name) if path.exists()]
    assert built, f"{name} is not in {PROGRAM.parent}: cargo build --workspace --release"
    return max(built, key=lambda path: path.stat().st_mtime)


@pytest.fixture(scope="session")
def package(tmp_path_factory) -> pathlib.Path:
    """A folder for PYTHONPATH that contains the package `pneutherm` as installed by `pip install .`."""
    folder = tmp_path_factory.mktemp("packages")
    (folder / "pneutherm").mkdir()
    for source in (ROOT / "python/pneutherm").glob("*.py*"):
        shutil.copy(source, folder / "pneutherm")
    shutil.copy(library(), folder / "pneutherm" / ("_native.pyd" if sys.platform == "win32" else "_native.abi3.so"))
    return folder


@pytest.fixture(scope="session")
def root() -> pathlib.Path:
    """The project's root."""
    return ROOT


@pytest.fixture(scope="session")
def pneutherm():
    """Calls the program and returns the completed process; fails the test if its exit code is not `code`."""

    def call(*arguments, cwd=None, code=0):
        process = subprocess.run([PROGRAM, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=600)
        assert process.returncode == code, f"{arguments}: exit {process.returncode}\n{process.stdout}\n{process.stderr}"
        return process

    return call
