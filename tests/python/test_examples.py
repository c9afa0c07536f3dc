"""The scripts in `examples/` that the tutorial does not run. The DuckDB query is in the tutorial, Dask in `test_sweep.py`."""

import re
import subprocess
import sys

import pytest

pytest.importorskip("fmpy")


@pytest.fixture(scope="module")
def fmu(pneutherm, root, tmp_path_factory):
    """The FMU of the diagnosed example, in a folder of its own."""
    folder = tmp_path_factory.mktemp("examples")
    pneutherm("diagnose", root / "examples/cylinder", "-o", folder / "model.toml")
    pneutherm("fmu", folder / "model.toml", "-o", folder / "Chamber.fmu")
    pneutherm("fmu", folder / "model.toml", "-o", folder / "CapSide.fmu")
    rod_side = re.sub(r"rod_m = \S+", "rod_m = 0.008", (folder / "model.toml").read_text())
    (folder / "rod_side.toml").write_text(rod_side)
    pneutherm("fmu", folder / "rod_side.toml", "-o", folder / "RodSide.fmu")
    return folder / "Chamber.fmu"


def run(script, *arguments, cwd):
    command = [sys.executable, str(script), *map(str, arguments)]
    process = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300)
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stdout


def test_the_prediction_is_drawn_and_as_good_as_the_sensor(fmu, root, tmp_path):
    pytest.importorskip("matplotlib")
    image = pytest.importorskip("PIL.Image")
    record = root / "examples/cylinder/validation.csv"
    said = run(root / "examples/fmu/predict_and_plot.py", fmu, record, tmp_path / "p.png", cwd=tmp_path)
    assert float(re.search(r"(\d+) Pa rms", said)[1]) < 1.2 * 150.0, said
    with image.open(tmp_path / "p.png") as picture:
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 100


def test_the_servo_cylinder_of_two_chambers_reaches_its_place(fmu, root, tmp_path):
    said = run(root / "examples/fmu/servo_cylinder.py", fmu.with_name("CapSide.fmu"), fmu.with_name("RodSide.fmu"), cwd=tmp_path)
    reached, wanted = map(float, re.search(r"reached ([\d.]+) mm of ([\d.]+) mm", said).groups())
    assert abs(reached - wanted) < 1.0, said
    # The way there is one that air allows: neither vacuum nor more than the supply.
    pressures = [float(p) for line in re.findall(r"p = *([\d. |]+) bar", said) for p in line.split("|")]
    assert len(pressures) == 20 and all(0.9 < p < 7.1 for p in pressures), said


def test_the_error_of_the_coupling_falls_with_the_step(fmu, root):
    sys.path.insert(0, str(root / "examples/fmu"))
    import servo_cylinder

    sides = [str(fmu.with_name(name)) for name in ("CapSide.fmu", "RodSide.fmu")]
    fine, *coarse = (servo_cylinder.run(*sides, step) for step in (1e-4, 1e-3, 5e-3))
    errors = [max(abs(a[0] - b[0]) for a, b in zip(course, fine)) for course in coarse]
    assert errors[0] < 0.2e-3 and 3.0 < errors[1] / errors[0] < 8.0, errors


def test_the_modelica_example_is_modelica(root):
    parser = pytest.importorskip("pymoca.parser", reason="pymoca, which parses Modelica, is not installed")
    text = (root / "examples/fmu/ServoCylinder.mo").read_text()
    cylinder = parser.parse(text).classes["ServoCylinder"]
    # All that an imported chamber asks its host for is connected, on both sides.
    set_by_equations = {str(equation.left) for equation in cylinder.equations}
    assert len(cylinder.equations) == len(set_by_equations) == 30
    with pytest.raises(parser.ModelicaSyntaxError):
        parser.parse(text.replace("der(x) = v;", "der(x) = = v;"))
