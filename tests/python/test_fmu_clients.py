"""The FMU in third-party clients, and compared with SciPy. Tests of missing clients are skipped with a message."""

import ctypes
import html
import os
import platform
import re
import shutil
import subprocess
import sys
import time
import tomllib
import zipfile

import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
from fmpy import extract, read_model_description, simulate_fmu  # noqa: E402
from fmpy.fmi2 import FMU2Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

MODEL = """
[gas]
name = "air"
gas_constant_j_per_kg_k = 287.0
heat_capacity_ratio = 1.4
[chamber]
bore_m = 0.025
rod_m = 0.01
dead_volume_m3 = 2e-6
area_law = "total"
[heat_transfer]
coefficient_w_per_m2_k = 30.0
reference_pressure_pa = 5.65e5
reference_temperature_k = 293.0
[effect.leakage]
conductance_m3_per_s_pa = 1e-13
[ambient]
temperature_k = 295.0
pressure_pa = 1.01e5
"""
R, GAMMA, LAMBDA0, P0, T0 = 287.0, 1.4, 30.0, 5.65e5, 293.0
BORE, ROD, DEAD = 0.025, 0.01, 2e-6
AREA = np.pi / 4 * (BORE**2 - ROD**2)


def wall_area(volume):
    """Barrel, rod and the two annular faces: Aq = 4 V/(bore - rod) + pi (bore^2 - rod^2)/2."""
    return 4 * volume / (BORE - ROD) + 2 * AREA


@pytest.fixture(scope="module")
def fmu(tmp_path_factory, pneutherm):
    folder = tmp_path_factory.mktemp("an fmu with spaces")
    (folder / "model.toml").write_text(MODEL)
    pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=folder)
    return folder / "Chamber.fmu"


class Slave:
    """An instance in FMPy, with access by variable names."""

    def __init__(self, fmu, name="slave", **start):
        self.description = read_model_description(str(fmu))
        self.folder = extract(str(fmu))
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmu.instantiate()
        self.start(**start)

    def start(self, **start):
        self.fmu.setupExperiment(startTime=0.0)
        for name, value in start.items():
            self.set(name, value)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, name, value):
        self.fmu.setReal([self.references[name]], [value])

    def get(self, name):
        return self.fmu.getReal([self.references[name]])[0]

    def step(self, t, h):
        self.fmu.doStep(t, h)

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def test_fmpy_finds_no_fault(fmu):
    assert validate_fmu(str(fmu)) == []


def test_start_values_in_the_library_are_those_in_the_description(fmu):
    slave = Slave(fmu)
    for v in slave.description.modelVariables:
        if v.type == "Real" and v.start is not None:
            assert slave.get(v.name) == float(v.start), v.name
    assert slave.get("bore") == BORE and slave.get("leakage.conductance") == 1e-13
    slave.close()


def test_the_held_piston_follows_the_exact_solution(fmu):
    start = {"initialPressure": 3e5, "initialTemperature": 350.0, "leakage.conductance": 0.0, "position": 0.05}
    volume = DEAD + AREA * 0.05
    mass = 3e5 * volume / (R * 350.0)
    cv = R / (GAMMA - 1)
    area = wall_area(volume)
    k = 295.0 * LAMBDA0 * np.sqrt(mass * R / (P0 * T0)) / (mass * cv) * area / np.sqrt(volume)
    for h in (1e-3, 0.1):
        result = simulate_fmu(str(fmu), stop_time=1.0, output_interval=h, step_size=h, start_values=start)
        exact = 295.0 / (1 - (1 - 295.0 / 350.0) * np.exp(-k * result["time"]))
        assert np.max(np.abs(result["temperature"] / exact - 1)) < 1e-9


def test_charging_and_discharging_agree_with_scipy(fmu):
    integrate = pytest.importorskip("scipy.integrate", reason="SciPy is not installed")
    cv, cp = R / (GAMMA - 1), GAMMA * R / (GAMMA - 1)

    def leak(p, t):
        up, down, t_up = (p, 1.01e5, t) if p > 1.01e5 else (1.01e5, p, 295.0)
        r = down / up
        psi = np.sqrt(max(0.0, 1 - max(0.0, (min(r, 0.999) - 0.3) / 0.7) ** 2)) * min(1.0, (1 - r) / 0.001)
        flow = 2e-11 * up * 1.185 * np.sqrt(293.15 / t_up) * psi
        return (flow, 0.0) if p > 1.01e5 else (0.0, flow)

    def rates(t, y, x, v, inflow, outflow):
        m, u = y
        volume = DEAD + AREA * (x + v * t)
        p, temperature = (GAMMA - 1) * u / volume, u / (m * cv)
        out, back = leak(p, temperature)
        coefficient = LAMBDA0 * np.sqrt(p * temperature / (P0 * T0))
        heat = coefficient * (wall_area(volume)) * (295.0 - temperature)
        enthalpy = cp * (inflow * 280.0 + back * 295.0 - (outflow + out) * temperature)
        return [inflow + back - outflow - out, heat + enthalpy - p * AREA * v]

    for h in (1e-3, 0.05):
        slave = Slave(fmu, **{"initialPressure": 2e5, "leakage.conductance": 2e-11, "temperatureIn": 280.0, "position": 0.08})
        y = [slave.get("mass"), slave.get("internalEnergy")]
        worst, t = 0.0, 0.0
        for step in range(round(0.5 / h)):
            t = step * h
            x, v = 0.08 + 0.02 * np.sin(9 * t), 0.18 * np.cos(9 * t)
            inflow, outflow = 3e-4 * (1 + np.sin(5 * t)), 2e-4 * (1 - np.cos(11 * t))
            if step:
                # The jump between position and integrated velocity is applied adiabatically.
                y[1] *= ((DEAD + AREA * reached) / (DEAD + AREA * x)) ** (GAMMA - 1)
            for name, value in (("position", x), ("velocity", v), ("massFlowIn", inflow), ("massFlowOut", outflow)):
                slave.set(name, value)
            slave.step(t, h)
            run = integrate.solve_ivp(rates, (0, h), y, "DOP853", args=(x, v, inflow, outflow), rtol=1e-11, atol=1e-15)
            y, reached = list(run.y[:, -1]), x + v * h
            pressure = (GAMMA - 1) * y[1] / (DEAD + AREA * reached)
            worst = max(worst, abs(slave.get("pressure") / pressure - 1), abs(slave.get("mass") / y[0] - 1))
        slave.close()
        assert worst < 1e-6, (h, worst)


def test_a_state_saved_by_one_process_continues_in_another(fmu, tmp_path):
    child = """
import sys
sys.path.insert(0, sys.argv[1])
from test_fmu_clients import Slave, continued
slave = Slave(sys.argv[2])
state = slave.fmu.deSerializeFMUstate(open(sys.argv[3], "rb").read())
slave.fmu.setFMUState(state)
print(*[value.hex() for value in continued(slave)])
"""
    slave = Slave(fmu, **{"recordDelay.delay": 0.02, "wallHeating.capacity": 2.0})
    slave.set("massFlowIn", 1e-4)
    for k in range(20):
        slave.step(k * 0.01, 0.01)
    (tmp_path / "state").write_bytes(slave.fmu.serializeFMUState(slave.fmu.getFMUState()))
    here = [value.hex() for value in continued(slave)]
    slave.close()
    arguments = [os.path.dirname(__file__), str(fmu), str(tmp_path / "state")]
    there = subprocess.run([sys.executable, "-c", child, *arguments], capture_output=True, text=True, check=True)
    assert there.stdout.split() == here


def continued(slave):
    values = []
    for k in range(20, 40):
        slave.set("velocity", -0.1)
        slave.set("position", 0.1 - 0.001 * (k - 20))
        slave.step(k * 0.01, 0.01)
        values += [slave.get("measuredPressure"), slave.get("temperature")]
    return values


def test_the_schema_accepts_the_description(fmu, tmp_path):
    if shutil.which("xmllint") is None:
        pytest.skip("xmllint is not installed (Debian: libxml2-utils)")
    schema = os.path.join(os.path.dirname(fmpy.__file__), "schema", "fmi2", "fmi2ModelDescription.xsd")
    with zipfile.ZipFile(fmu) as archive:
        archive.extract("modelDescription.xml", tmp_path)
    subprocess.run(["xmllint", "--noout", "--schema", schema, tmp_path / "modelDescription.xml"], check=True)


def test_fmutool_finds_it_compliant(fmu):
    tool = os.path.join(os.path.dirname(sys.executable), "fmutool")
    if not os.path.exists(tool):
        pytest.skip("fmutool (fmu-manipulation-toolbox) is not installed")
    run = subprocess.run([tool, "-input", fmu, "-check"], capture_output=True, text=True, check=True)
    report = run.stdout + run.stderr
    assert "seems to be compliant with FMI-2.0" in report and "No semantic error" in report, report
    assert "ERROR" not in report and "WARNING" not in report, report


def by_fmpy(fmu, steps, h):
    """The default push and hold of the FMU, whose host sets nothing."""
    slave = Slave(fmu)
    values = []
    for k in range(steps):
        slave.step(k * h, h)
        values.append((slave.get("pressure"), slave.get("temperature"), slave.get("heatFlow")))
    slave.close()
    return np.array(values)


def test_libcosimpy_gives_the_same_digits(fmu):
    cosim = pytest.importorskip("libcosimpy.CosimExecution", reason="libcosimpy is not installed")
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    steps, h = 50, 0.01
    execution = cosim.CosimExecution.from_step_size(round(h * 1e9))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="chamber"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    manipulator = CosimManipulator.create_override()
    execution.add_manipulator(manipulator)
    references = {v.name: v.valueReference for v in read_model_description(str(fmu)).modelVariables}
    names = ["pressure", "temperature", "heatFlow"]
    hot = np.array(by_fmpy(fmu, steps, h))
    for k in range(steps):
        execution.step()
        values = observer.last_real_values(index, [references[name] for name in names])
        # The clients' clocks, and hence the end of the push, differ in the last bit.
        assert list(values) == pytest.approx(list(hot[k]), rel=1e-12, abs=1e-12), k


def test_ecos_gives_the_same_digits(fmu):
    try:
        from ecospy import EcosSimulation, EcosSimulationStructure
    except (ImportError, OSError) as error:
        pytest.skip(f"ecospy cannot be loaded (it needs Debian's libtbb12): {error}")
    steps, h = 50, 0.01
    structure = EcosSimulationStructure()
    structure.add_model("chamber", str(fmu))
    simulation = EcosSimulation(step_size=h, structure=structure)
    simulation.init()
    expected = by_fmpy(fmu, steps, h)
    for k in range(steps):
        simulation.step(1)
        found = [simulation.get_real(f"chamber::{name}") for name in ("pressure", "temperature")]
        assert found == pytest.approx(list(expected[k, :2]), rel=1e-12), k
    simulation.terminate()


def test_only_the_interface_is_exported_and_old_systems_can_load_it(fmu, tmp_path):
    if platform.system() != "Linux" or shutil.which("nm") is None:
        pytest.skip("reads the ELF library with nm")
    name = "linux64" if platform.machine() == "x86_64" else "aarch64-linux"
    with zipfile.ZipFile(fmu) as archive:
        library = archive.extract(f"binaries/{name}/Chamber.so", tmp_path)
        entries = archive.namelist()
    assert entries[0] == "modelDescription.xml" and "documentation/index.html" in entries and "model.png" in entries
    symbols = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True)
    exported = [line.split()[-1] for line in symbols.stdout.splitlines()]
    of_version = {version: [symbol for symbol in exported if symbol.startswith(version)] for version in ("fmi2", "fmi3")}
    assert len(exported) == 119 and [len(symbols) for symbols in of_version.values()] == [44, 75], exported
    assert ctypes.CDLL(library).fmi2GetVersion


def test_the_same_model_gives_the_same_bytes(fmu, pneutherm, tmp_path):
    pneutherm("fmu", fmu.parent / "model.toml", "-o", tmp_path / "Chamber.fmu")
    assert (tmp_path / "Chamber.fmu").read_bytes() == fmu.read_bytes()


def test_source_date_epoch_dates_the_description(fmu, tmp_path, pneutherm, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "951827696")
    pneutherm("fmu", fmu.parent / "model.toml", "-o", tmp_path / "dated.fmu")
    assert read_model_description(str(tmp_path / "dated.fmu")).generationDateAndTime == "2000-02-29T12:34:56Z"
    assert read_model_description(str(tmp_path / "dated.fmu")).guid != read_model_description(str(fmu)).guid


def test_two_models_run_in_one_process_in_every_client(pneutherm, tmp_path):
    for name, bore in (("RodSide", "0.03"), ("CapSide", "0.05")):
        (tmp_path / f"{name}.toml").write_text(MODEL.replace("bore_m = 0.025", f"bore_m = {bore}"))
        pneutherm("fmu", f"{name}.toml", "-o", f"{name}.fmu", cwd=tmp_path)
    sides = [tmp_path / "RodSide.fmu", tmp_path / "CapSide.fmu"]
    slaves = [Slave(side) for side in sides]
    assert [slave.description.modelName for slave in slaves] == ["RodSide", "CapSide"]
    assert [slave.get("bore") for slave in slaves] == [0.03, 0.05]
    steps, h = 20, 0.01
    begin = [slave.get("volume") for slave in slaves]
    for slave in slaves:
        for k in range(steps):
            slave.step(k * h, h)
    volumes = [slave.get("volume") for slave in slaves]
    assert all(volume < 0.6 * before for volume, before in zip(volumes, begin))
    for slave in slaves:
        slave.close()
    cosim = pytest.importorskip("libcosimpy.CosimExecution", reason="libcosimpy is not installed")
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = cosim.CosimExecution.from_step_size(round(h * 1e9))
    indices = [execution.add_local_slave(CosimLocalSlave(fmu_path=str(side), instance_name=side.stem)) for side in sides]
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    volume = next(v.valueReference for v in read_model_description(str(sides[0])).modelVariables if v.name == "volume")
    for _ in range(steps):
        execution.step()
    assert [observer.last_real_values(index, [volume])[0] for index in indices] == pytest.approx(volumes, rel=1e-12)
    try:
        from ecospy import EcosSimulation, EcosSimulationStructure
    except (ImportError, OSError) as error:
        pytest.skip(f"ecospy cannot be loaded (it needs Debian's libtbb12): {error}")
    structure = EcosSimulationStructure()
    for side in sides:
        structure.add_model(side.stem, str(side))
    simulation = EcosSimulation(step_size=h, structure=structure)
    simulation.init()
    simulation.step(steps)
    assert [simulation.get_real(f"{side.stem}::volume") for side in sides] == pytest.approx(volumes, rel=1e-12)
    simulation.terminate()


def test_a_model_that_leaves_more_than_noise_says_so_in_one_line(pneutherm, tmp_path):
    for verdict, told in (("adequate", 0), ("explained", 0), ("improved", 1), ("unexplained", 1)):
        (tmp_path / "model.toml").write_text(MODEL + f'[provenance]\nverdict = "{verdict}"\n')
        said = pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=tmp_path).stdout
        assert said.count("\n") == 1 + told and said.count(f"`{verdict}`") == told, said
        with zipfile.ZipFile(tmp_path / "Chamber.fmu") as archive:
            assert "Diagnosis: " in archive.read("documentation/index.html").decode()


def test_the_documentation_has_this_model_s_values_and_intervals(pneutherm, tmp_path):
    known = '[uncertainty]\nparameters = ["lambda0_w_per_m2_k"]\nci95 = [[28.5, 31.5]]\ncovariance = [[0.58]]\n'
    (tmp_path / "model.toml").write_text(MODEL + known)
    pneutherm("fmu", "model.toml", "-o", "My cylinder.fmu", cwd=tmp_path)
    with zipfile.ZipFile(tmp_path / "My cylinder.fmu") as archive:
        page = archive.read("documentation/index.html").decode()
        assert any(name.startswith("binaries/") and "/My_cylinder." in name for name in archive.namelist())
    row = next(line for line in page.splitlines() if "<code>lambda0</code>" in line)
    assert "<td>30<br>2.850e1 to 3.150e1 (95&nbsp;%)</td>" in row, row
    assert "<h1>My cylinder</h1>" in page and "<td>0.025</td>" in page


def test_the_program_in_the_documentation_runs(fmu):
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()
    program = html.unescape(re.search(r"<pre>\n(import numpy.*?)</pre>", page, re.S)[1])
    run = subprocess.run([sys.executable, "-c", program], cwd=fmu.parent, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    highest, last = map(float, run.stdout.split()[-2:])
    assert highest > 1.2 * last > 1e5


def test_the_commands_that_readmes_give_for_fmpy_run(fmu, root, tmp_path):
    pytest.importorskip("plotly", reason="Plotly, which draws FMPy's plots, is not installed")
    with zipfile.ZipFile(fmu) as archive:
        inside = "extra/org.fmi-standard.fmi-ls-ref/push_and_hold_in.csv"
        (tmp_path / "push_and_hold_in.csv").write_bytes(archive.read(inside))
    shutil.copy(fmu, tmp_path)
    pages = "".join((root / page).read_text() for page in ("README.md", "examples/fmu/README.md"))
    commands = re.findall(r"^\$ (fmpy simulate .*)$", pages, re.M)
    assert len(commands) == 3, commands
    # The browser that displays a plot: it stores the page.
    (tmp_path / "browser.py").write_text("import sys, urllib.request as r\nopen('plot.html', 'wb').write(r.urlopen(sys.argv[1]).read())\n")
    environment = {**os.environ, "PLOTLY_RENDERER": "browser", "BROWSER": f"{sys.executable} browser.py %s &"}
    for command in commands:
        run = subprocess.run([sys.executable, "-m", *command.split()], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
        assert run.returncode == 0, (command, run.stderr)
        page = tmp_path / "plot.html"
        end = time.monotonic() + 30
        while not (page.exists() and "</html>" in page.read_text()):
            assert time.monotonic() < end, (command, run.stdout, run.stderr)
            time.sleep(0.05)
        assert "Plotly.newPlot" in page.read_text() and "pressure" in page.read_text(), command
        page.unlink()


def test_the_notices_of_the_crates_in_the_library_are_inside(fmu, root):
    with zipfile.ZipFile(fmu) as archive:
        notices = archive.read("documentation/licenses/THIRD-PARTY.md").decode()
        assert archive.read("documentation/licenses/LICENSE-MIT.txt") == (root / "LICENSE-MIT").read_bytes()
    command = ["cargo", "tree", "--package", "pneutherm-fmu-cdylib", "--edges", "normal", "--prefix", "none", "--format", "{p}", "--locked", "--offline"]
    tree = subprocess.run(command, cwd=root, capture_output=True, text=True)
    assert tree.returncode == 0, tree.stderr
    crates = {line.split()[0] for line in tree.stdout.splitlines() if line.strip() and not line.startswith("pneutherm")}
    missing = [crate for crate in crates if crate not in notices]
    assert {"crc32fast", "thiserror"} <= crates and not missing, missing


def test_the_experiment_inside_is_replayed_to_its_own_result(fmu, tmp_path):
    from xml.etree import ElementTree

    folder = "extra/org.fmi-standard.fmi-ls-ref/"
    with zipfile.ZipFile(fmu) as archive:
        manifest = ElementTree.fromstring(archive.read(folder + "fmi-ls-manifest.xml"))
        names = {related.get("role"): related.get("source") for related in manifest.iter("Related")}
        archive.extractall(tmp_path, [folder + name for name in names.values()])
    space = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert manifest.tag == "fmiReferences" and manifest.get(space + "fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    assert set(names) == {"experiment", "result"} and manifest.get(space + "fmi-ls-version")
    for related in manifest.iter("Related"):
        assert all(related.get(attribute) for attribute in ("type", "source", "role", "description")), related.attrib
    expected = np.genfromtxt(tmp_path / folder / names["result"], delimiter=",", names=True)
    command = [sys.executable, "-m", "fmpy", "simulate", fmu, "--interface-type", "CoSimulation", "--stop-time", "2",
               "--output-interval", "0.01", "--input-file", tmp_path / folder / names["experiment"],
               "--output-variables", "pressure", "temperature", "force", "heatFlow", "--output-file", tmp_path / "out.csv"]
    run = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    found = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    assert len(found) == len(expected) == 201
    assert np.ptp(expected["pressure"]) > 1e5, "the pressure moves"
    for name in expected.dtype.names[1:]:
        assert np.allclose(found[name], expected[name], rtol=1e-7, atol=1e-6), name


@pytest.mark.parametrize("version", ["2", "3"])
def test_a_measured_record_inside_is_replayed_within_the_error_that_is_stated(pneutherm, root, tmp_path, version):
    from xml.etree import ElementTree

    cylinder = root / "examples/cylinder"
    pneutherm("diagnose", cylinder, "-o", tmp_path / "model.toml")
    said = pneutherm("fmu", "model.toml", "--fmi", version, "--validation", cylinder / "validation.toml", "-o", "V.fmu", cwd=tmp_path)
    stated = r"validation.csv: error of the model ([\d.]+) Pa rms; it took no part in the identification"
    error = float(re.search("reference experiment " + stated, said.stdout)[1])
    folder = "extra/org.fmi-standard.fmi-ls-ref/"
    with zipfile.ZipFile(tmp_path / "V.fmu") as archive:
        archive.extractall(tmp_path)
        related = list(ElementTree.fromstring(archive.read(folder + "fmi-ls-manifest.xml")).iter("Related"))
        inside = {name.removeprefix(folder) for name in archive.namelist() if name.startswith(folder)}
        assert re.search(stated, archive.read("documentation/index.html").decode())
    assert {r.get("source") for r in related} | {"fmi-ls-manifest.xml"} == inside
    of_record = {r.get("role"): r for r in related if r.get("source").startswith("validation_1_")}
    assert set(of_record) == {"experiment/validation", "parameter", "result"}
    assert float(re.search(stated, of_record["result"].get("description"))[1]) == error

    def table(role):
        return np.genfromtxt(tmp_path / folder / of_record[role].get("source"), delimiter=",", names=True)

    measured, record = table("result"), np.genfromtxt(cylinder / "validation.csv", delimiter=",", names=True)
    assert np.array_equal(measured["measuredPressure"], record["pressure_pa"])
    start = ElementTree.parse(tmp_path / folder / of_record["parameter"].get("source")).getroot()
    values = {p.get("name"): float(p[0].get("value")) for p in start.iter() if p.tag.endswith("}Parameter")}
    assert set(values) == {"initialPressure", "initialTemperature"}
    found = simulate_fmu(str(tmp_path / "V.fmu"), fmi_type="CoSimulation", start_values=values, output=["measuredPressure"],
                         input=table("experiment/validation"), stop_time=measured["time"][-1], output_interval=0.01)  # fmt: skip
    assert np.allclose(found["time"], measured["time"], atol=1e-9)
    residual = found["measuredPressure"] - measured["measuredPressure"]
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(error, rel=1e-2)
    # The error of the model on left-out records, as stated in its file.
    model = tomllib.loads((tmp_path / "model.toml").read_text())
    assert error < 1.1 * model["provenance"]["rmse_after_pa"]["held_out"]


def test_a_record_that_the_model_was_identified_from_is_called_so(pneutherm, root, tmp_path):
    cylinder = root / "examples/cylinder"
    pneutherm("identify", cylinder, "-o", tmp_path / "model.toml")
    said = pneutherm("fmu", "model.toml", "--validation", cylinder, "-o", "V.fmu", cwd=tmp_path).stdout
    assert said.count("the model was identified from it") == 15, said
    process = pneutherm("fmu", "model.toml", "--validation", "nowhere.toml", "-o", "W.fmu", cwd=tmp_path, code=1)
    assert "nowhere.toml" in process.stderr and not (tmp_path / "W.fmu").exists()


@pytest.mark.parametrize(("version", "kind"), [("2", "CoSimulation"), ("2", "ModelExchange"), ("3", "CoSimulation"), ("3", "ModelExchange")])
def test_a_first_run_with_nothing_connected_shows_the_experiment_inside(fmu, pneutherm, tmp_path, version, kind):
    pneutherm("fmu", fmu.parent / "model.toml", "--fmi", version, "-o", tmp_path / "Chamber.fmu")
    with zipfile.ZipFile(fmu) as archive:
        result = archive.read("extra/org.fmi-standard.fmi-ls-ref/push_and_hold_out.csv").decode()
    expected = np.genfromtxt(result.splitlines(), delimiter=",", names=True)
    settings = {} if kind == "CoSimulation" else {"relative_tolerance": 1e-10, "output_interval": 0.01}
    found = simulate_fmu(str(tmp_path / "Chamber.fmu"), fmi_type=kind, output=["pressure", "temperature"], **settings)
    assert found["time"][-1] == pytest.approx(2.0) and np.ptp(found["pressure"]) > 1e5
    for row in expected[::10]:
        at = found[np.isclose(found["time"], row["time"], atol=1e-9)][-1]
        assert at["pressure"] == pytest.approx(row["pressure"], rel=1e-7), row["time"]
        assert at["temperature"] == pytest.approx(row["temperature"], rel=1e-7), row["time"]


def test_a_model_that_no_fmu_can_hold_is_refused_by_name(pneutherm, tmp_path):
    (tmp_path / "model.toml").write_text(MODEL.replace("coefficient_w_per_m2_k = 30.0", "coefficient_w_per_m2_k = 3e9"))
    process = pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=tmp_path, code=1)
    assert "line 12: heat_transfer.coefficient_w_per_m2_k" in process.stderr
    assert not (tmp_path / "Chamber.fmu").exists()
