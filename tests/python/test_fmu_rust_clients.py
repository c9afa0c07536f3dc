"""The FMU in third-party importers written in Rust: `fmi`, `fmi-rs`; and the official header, through `fmi-sys`."""

import glob
import os
import shutil
import struct
import subprocess

import pytest

pytest.importorskip("fmpy", reason="FMPy is not installed")
from test_fmu_clients import Slave, fmu  # noqa: E402, F401


def libclang():
    """Whether bindgen can find libclang."""
    if "LIBCLANG_PATH" in os.environ:
        return True
    places = ["/usr/lib/llvm-*/lib", "/usr/lib/*-linux-gnu", "/usr/lib64", "/usr/local/lib", "/opt/homebrew/opt/llvm/lib"]
    return any(glob.glob(f"{place}/libclang[-.][0-9sd]*") for place in places)


def bits(value):
    return struct.pack(">d", value).hex()


def push_and_hold(fmu, steps=100, h=0.01):
    """Inputs before and outputs after each step: a push of 0.2 s, then a hold."""
    slave = Slave(fmu)
    for k in range(steps):
        position, velocity = (0.1 - 0.0025 * k, -0.25) if k < 20 else (0.05, 0.0)
        slave.set("position", position)
        slave.set("velocity", velocity)
        slave.step(k * h, h)
        yield k * h, position, velocity, slave.get("pressure"), slave.get("temperature"), slave.get("heatFlow")
    slave.close()


def test_importers_in_rust_accept_the_fmu_and_give_the_same_digits(fmu, root, tmp_path):  # noqa: F811
    if shutil.which("cargo") is None or not libclang():
        pytest.skip("fmi-sys needs Cargo and libclang (Debian: libclang-dev)")
    digits = tmp_path / "digits"
    digits.write_text("\n".join(" ".join(map(bits, row)) for row in push_and_hold(fmu)))
    environment = {**os.environ, "CHAMBER_FMU": str(fmu), "CHAMBER_DIGITS": str(digits), "CARGO_INCREMENTAL": "0"}
    command = ["cargo", "test", "--locked", "--target-dir", str(root / "target" / "clients")]
    run = subprocess.run(command, cwd=root / "tests" / "clients", env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.count("... ok") == 6, run.stdout
