"""What all Python tests share: the program under test and a way to call it."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("PNEUTHERM", ROOT / "target" / "release" / "pneutherm"))


@pytest.fixture(scope="session")
def root() -> pathlib.Path:
    """The project's root."""
    return ROOT


@pytest.fixture(scope="session")
def pneutherm():
    """Calls the program and returns the completed process; fails the test when it exits other than with `code`."""

    def call(*arguments, cwd=None, code=0):
        process = subprocess.run([PROGRAM, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=600)
        assert process.returncode == code, f"{arguments}: exit {process.returncode}\n{process.stdout}\n{process.stderr}"
        return process

    return call
