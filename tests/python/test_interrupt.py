"""An interrupted command leaves nothing behind."""

import os
import signal
import subprocess

import pytest

from conftest import PROGRAM

MODEL = "[chamber]\nbore_m = 0.02\ndead_volume_m3 = 1e-6\n[heat_transfer]\ncoefficient_w_per_m2_k = 30.0\n"
ROWS = 300_000
TRIES = 5


def is_being_written(folder):
    """Whether the temporary file of `out.csv` has been started; it may disappear during the check."""
    try:
        return any(path.stat().st_size > 0 for path in folder.glob(".out.csv.*.tmp"))
    except FileNotFoundError:
        return False


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interrupt_while_a_file_is_written_leaves_no_half_written_one(tmp_path):
    (tmp_path / "model.toml").write_text(MODEL)
    rows = (f"{0.001 * k:.3f},{0.1 if k < 1000 else 0.05}\n" for k in range(ROWS))
    (tmp_path / "plan.csv").write_text("time_s,position_m\n" + "".join(rows))
    before = sorted(os.listdir(tmp_path))
    command = [PROGRAM, "simulate", "model.toml", "--motion", "plan.csv", "--initial-pressure", "1e5", "-o", "out.csv"]
    for _ in range(TRIES):
        # As in a shell's foreground: interrupts are not ignored.
        process = subprocess.Popen(
            command, cwd=tmp_path, stderr=subprocess.PIPE, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler)
        )
        while process.poll() is None:
            if is_being_written(tmp_path):
                process.send_signal(signal.SIGINT)
                break
        said = process.communicate(timeout=60)[1]
        if process.returncode == 0:
            # It finished before the interrupt.
            (tmp_path / "out.csv").unlink()
            continue
        assert process.returncode == -signal.SIGINT and said == b""
        assert sorted(os.listdir(tmp_path)) == before
        return
    pytest.skip("each file was written before it could be interrupted")
