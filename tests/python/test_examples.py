"""The scripts in `examples/` not run by the tutorial. The DuckDB query is in the tutorial, Dask in `test_sweep.py`."""

import pathlib
import re
import subprocess
import sys
import zipfile

import numpy as np
import pytest

pytest.importorskip("fmpy")


@pytest.fixture(scope="module")
def fmu(pneutherm, root, tmp_path_factory):
    """The FMU of the diagnosed example, in a separate folder."""
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
    # The trajectory is possible with air: neither vacuum nor more than the supply pressure.
    pressures = [float(p) for line in re.findall(r"p = *([\d. |]+) bar", said) for p in line.split("|")]
    assert len(pressures) == 20 and all(0.9 < p < 7.1 for p in pressures), said


def test_the_error_of_the_coupling_falls_with_the_step(fmu, root):
    sys.path.insert(0, str(root / "examples/fmu"))
    import servo_cylinder

    sides = [str(fmu.with_name(name)) for name in ("CapSide.fmu", "RodSide.fmu")]
    fine, *coarse = (servo_cylinder.run(*sides, step) for step in (1e-4, 1e-3, 5e-3))
    errors = [max(abs(a[0] - b[0]) for a, b in zip(course, fine)) for course in coarse]
    assert errors[0] < 0.2e-3 and 3.0 < errors[1] / errors[0] < 8.0, errors
    # The README's table states them relative to a step half as long.
    table = (root / "examples/fmu/README.md").read_text()
    for step, error in zip((1, 5), errors, strict=True):
        stated = float(re.search(rf"^\| {step} ms \| ([\d.]+) mm", table, re.M)[1])
        assert stated == pytest.approx(1e3 * error, rel=0.15), (step, error)


def test_a_piston_comes_to_rest_by_each_stable_coupling_and_not_by_a_force_that_is_late(fmu, root):
    sys.path.insert(0, str(root / "examples/fmu"))
    import couplings

    swings = {}
    for coupling, late in couplings.COUPLINGS:
        course = couplings.run(str(fmu), coupling, late=late)
        first = course[: len(course) // 4]
        swings[coupling, late] = couplings.swing(course) / (max(first) - min(first))
    assert len(swings) == 5
    assert all(swing < 0.1 for (_, late), swing in swings.items() if late == 0), swings
    assert swings["position and velocity", 1] > 0.2 and swings["position and velocity", 2] > 2.0, swings


def test_the_readme_states_what_the_couplings_and_the_program_come_to(fmu, root, pneutherm, tmp_path):
    readme = (root / "examples/fmu/README.md").read_text()
    printed = run(root / "examples/fmu/couplings.py", fmu, cwd=tmp_path)
    found = [float(swing) for swing in re.findall(r"swings by ([\d.]+) mm", printed)]
    stable, *late = (float(swing) for swing in re.findall(r"^\| (?:each of|position and).*\| ([\d.]+) mm", readme, re.M))
    assert found == pytest.approx([stable] * 3 + late, rel=0.1), printed
    validation = root / "examples/cylinder/validation.toml"
    said = pneutherm("fmu", fmu.with_name("model.toml"), "-o", tmp_path / "Chamber.fmu", "--validation", validation).stdout
    (line,) = re.findall(r"^reference experiment.*", readme, re.M)
    assert line in said, said


def test_the_modelica_example_is_modelica(root):
    parser = pytest.importorskip("pymoca.parser", reason="pymoca, which parses Modelica, is not installed")
    text = (root / "examples/fmu/ServoCylinder.mo").read_text()
    cylinder = parser.parse(text).classes["ServoCylinder"]
    # All inputs of an imported chamber are connected, on both sides.
    set_by_equations = {str(equation.left) for equation in cylinder.equations}
    assert len(cylinder.equations) == len(set_by_equations) == 30
    with pytest.raises(parser.ModelicaSyntaxError):
        parser.parse(text.replace("der(x) = v;", "der(x) = = v;"))


STEP_S, STEPS = 1e-3, 2000
WATCHED = [("CapSide", "pistonPosition"), ("CapSide", "pressure"), ("RodSide", "pressure"), ("Piston", "capVelocity")]


@pytest.fixture(scope="module")
def ssp(fmu, root):
    """The SSP of the servo cylinder, written by its example."""
    pytest.importorskip("pythonfmu", reason="pythonfmu, which makes the piston's FMU, is not installed")
    run(root / "examples/fmu/servo_ssp.py", "CapSide.fmu", "RodSide.fmu", "-o", "ServoCylinder.ssp", cwd=fmu.parent)
    return fmu.with_name("ServoCylinder.ssp")


@pytest.fixture(scope="module")
def by_hand(ssp, root):
    """The observed values, step by step, with FMPy as the master: all step, then outputs become inputs."""
    sys.path.insert(0, str(root / "examples/fmu"))
    import servo_ssp
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    slaves = {}
    for name, start in servo_ssp.START.items():
        with zipfile.ZipFile(ssp) as archive:
            path = archive.extract(f"resources/{name}.fmu", ssp.parent / "by hand")
        description = read_model_description(path)
        places = {variable.name: variable.valueReference for variable in description.modelVariables}
        slave = FMU2Slave(
            guid=description.guid, unzipDirectory=extract(path), instanceName=name, modelIdentifier=description.coSimulation.modelIdentifier,
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.setReal([places[variable] for variable in start], list(start.values()))
        slaves[name] = (slave, places)

    def get(name, variable):
        return slaves[name][0].getReal([slaves[name][1][variable]])[0]

    def connect():
        values = [get(*output.split(".")) for output, _ in servo_ssp.CONNECTIONS]
        for (_, taken), value in zip(servo_ssp.CONNECTIONS, values, strict=True):
            name, variable = taken.split(".")
            slaves[name][0].setReal([slaves[name][1][variable]], [value])

    for slave, _ in slaves.values():
        slave.enterInitializationMode()
    connect()
    for slave, _ in slaves.values():
        slave.exitInitializationMode()
    rows = []
    for k in range(STEPS):
        connect()
        for slave, _ in slaves.values():
            slave.doStep(k * STEP_S, STEP_S)
        rows.append([get(*watched) for watched in WATCHED])
    for slave, _ in slaves.values():
        slave.terminate()
        slave.freeInstance()
    return np.array(rows)


def test_the_servo_cylinder_of_the_archive_goes_where_that_of_the_script_goes(by_hand, fmu):
    import servo_cylinder

    script = np.array(servo_cylinder.run(*(str(fmu.with_name(name)) for name in ("CapSide.fmu", "RodSide.fmu")), STEP_S))
    archive = by_hand[19::20, :3]
    # The archive's master exchanges once per step, the script splits the push: the difference is the coupling error.
    assert abs(script - archive)[:, 0].max() < 1e-3 and abs(script - archive)[:, 1:].max() < 5e3
    assert abs(archive[-1, 0] - servo_cylinder.TARGET_M) < 1e-3


def test_the_archive_is_what_the_schemas_of_ssp_say(ssp):
    import fmpy.ssp
    from lxml import etree

    folder = pathlib.Path(fmpy.ssp.__file__).parent / "schema"
    with zipfile.ZipFile(ssp) as archive:
        sets = [name for name in archive.namelist() if name.endswith(".ssv")]
        assert len(sets) == 3
        for name, schema in [("SystemStructure.ssd", "Description"), *((name, "ParameterValues") for name in sets)]:
            etree.XMLSchema(file=str(folder / f"SystemStructure{schema}.xsd")).assertValid(etree.fromstring(archive.read(name)))


def test_ecos_runs_the_archive_with_its_parameters(ssp, by_hand):
    try:
        from ecospy import EcosSimulation
    except (ImportError, OSError) as error:
        pytest.skip(f"ecospy cannot be loaded (it needs Debian's libtbb12): {error}")
    simulation = EcosSimulation(step_size=STEP_S, ssp_path=str(ssp))
    simulation.init(parameter_set="initialValues")
    for k in range(STEPS):
        simulation.step(1)
        found = [simulation.get_real(f"{name}::{variable}") for name, variable in WATCHED]
        assert found == pytest.approx(by_hand[k], rel=1e-9, abs=1e-12), k
    simulation.terminate()


def test_libcosim_runs_the_archive_with_its_parameters(ssp, by_hand):
    cosim = pytest.importorskip("libcosimpy.CosimExecution", reason="libcosimpy is not installed")
    from fmpy import read_model_description
    from libcosimpy.CosimObserver import CosimObserver

    execution = cosim.CosimExecution.from_ssp_file(ssp_path=str(ssp), step_size=round(STEP_S * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    components = {name: execution.slave_index_from_instance_name(name) for name, _ in WATCHED}
    wanted = {}
    for name in ("CapSide", "RodSide", "Piston"):
        variables = read_model_description(str(ssp.parent / "by hand" / "resources" / f"{name}.fmu")).modelVariables
        wanted.update({(name, v.name): v.valueReference for v in variables})
    for k in range(STEPS):
        execution.step()
        found = [observer.last_real_values(components[name], [wanted[name, variable]])[0] for name, variable in WATCHED]
        assert found == pytest.approx(by_hand[k], rel=1e-9, abs=1e-12), k
