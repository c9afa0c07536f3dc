"""The FMU in `fmusim`, the Modelica Association's own importer: the embedded experiment, in both versions and both kinds.

Its C version is in the history of the Reference-FMUs (last at 7b3fc08's parent) and builds with CMake, or with one call of a C
compiler, SUNDIALS, libxml2, zlib and minizip. `PNEUTHERM_FMUSIM` names the program if it is not on the path.
"""

import os
import shutil
import subprocess
import zipfile

import numpy as np
import pytest

pytest.importorskip("fmpy", reason="FMPy is not installed")
from test_fmu_clients import fmu  # noqa: E402, F401

FMUSIM = os.environ.get("PNEUTHERM_FMUSIM") or shutil.which("fmusim")
pytestmark = pytest.mark.skipif(FMUSIM is None, reason="fmusim is not here: build it and set PNEUTHERM_FMUSIM")


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize(("kind", "options", "tolerance"), [("cs", [], 1e-9), ("me", ["--solver", "cvode", "--tolerance", "1e-10"], 1e-7)])
def test_fmusim_shows_the_experiment_inside(fmu, pneutherm, tmp_path, version, kind, options, tolerance):  # noqa: F811
    pneutherm("fmu", fmu.parent / "model.toml", "--fmi", version, "-o", tmp_path / "Chamber.fmu")
    with zipfile.ZipFile(tmp_path / "Chamber.fmu") as archive:
        result = archive.read("extra/org.fmi-standard.fmi-ls-ref/push_and_hold_out.csv").decode()
    expected = np.genfromtxt(result.splitlines(), delimiter=",", names=True)
    command = [FMUSIM, "--interface-type", kind, *options, "--stop-time", "2", "--output-interval", "0.01",
               "--output-variable", "pressure", "--output-variable", "temperature", "--output-file", "out.csv", "Chamber.fmu"]  # fmt: skip
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stdout + run.stderr
    found = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    for row in expected[::10]:
        at = found[np.isclose(found["time"], row["time"], atol=1e-9)][-1]
        for name in ("pressure", "temperature"):
            assert at[name] == pytest.approx(row[name], rel=tolerance), (name, row["time"])
