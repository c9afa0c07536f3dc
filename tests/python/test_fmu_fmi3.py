"""The FMU of FMI 3.0 in FMPy: valid, bit-identical with that of FMI 2.0, and with early return at events."""

import os
import random
import shutil
import struct
import subprocess
import zipfile

import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
from fmpy import extract, read_model_description, simulate_fmu  # noqa: E402
from fmpy.fmi3 import FMU3Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402
from test_fmu_clients import Slave, fmu  # noqa: E402, F401


@pytest.fixture(scope="module")
def fmu3(fmu, pneutherm):  # noqa: F811
    folder = fmu.parent / "of FMI 3"
    folder.mkdir()
    pneutherm("fmu", fmu.parent / "model.toml", "--fmi", "3", "-o", folder / "Chamber.fmu")
    return folder / "Chamber.fmu"


class Slave3:
    """An instance of FMI 3.0 in FMPy, with access by variable names."""

    def __init__(self, path, early=False, **start):
        self.description = read_model_description(str(path))
        self.folder = extract(str(path))
        self.fmu = FMU3Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="three",
        )
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmu.instantiate(eventModeUsed=early, earlyReturnAllowed=early)
        for name, value in start.items():
            self.set(name, value)
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()
        if early:
            self.fmu.enterStepMode()

    def set(self, name, value):
        self.fmu.setFloat64([self.references[name]], [value])

    def get(self, name):
        return self.fmu.getFloat64([self.references[name]])[0]

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def test_fmpy_and_the_schemas_find_no_fault(fmu3, tmp_path):
    assert validate_fmu(str(fmu3)) == []
    if shutil.which("xmllint") is None:
        pytest.skip("xmllint is not installed (Debian: libxml2-utils)")
    schemas = os.path.join(os.path.dirname(fmpy.__file__), "schema", "fmi3")
    with zipfile.ZipFile(fmu3) as archive:
        archive.extractall(tmp_path)
    for schema, file in (
        ("fmi3ModelDescription.xsd", "modelDescription.xml"),
        ("fmi3TerminalsAndIcons.xsd", "terminalsAndIcons/terminalsAndIcons.xml"),
    ):
        subprocess.run(["xmllint", "--noout", "--schema", os.path.join(schemas, schema), tmp_path / file], check=True)


def bits(values):
    return struct.pack(f"{len(values)}d", *values)


def test_both_versions_are_equal_bit_by_bit_over_random_steps(fmu, fmu3):  # noqa: F811
    start = {"initialPressure": 2e5, "wallHeating.capacity": 2.0, "recordDelay.delay": 0.02, "stroke": 0.15}
    two, three = Slave(fmu, **start), Slave3(fmu3, **start)
    outputs = [v.name for v in two.description.modelVariables if v.causality in ("output", "local") and v.type == "Real"]
    references = [two.references[name] for name in outputs]
    assert references == [three.references[name] for name in outputs]
    draw, t = random.Random(7), 0.0
    for _ in range(10_000):
        h = 10 ** draw.uniform(-5, -2.5)
        for name, low, high in (
            ("position", 0.02, 0.16), ("velocity", -0.5, 0.5), ("massFlowIn", -1e-5, 2e-5), ("supplyPortConductance", 0.0, 1e-9),
            ("supplyPortPressure", 1e5, 7e5), ("exhaustPortConductance", 0.0, 1e-9),
        ):  # fmt: skip
            if draw.random() < 0.4:
                value = draw.uniform(low, high)
                two.set(name, value)
                three.set(name, value)
        two.step(t, h)
        three.fmu.doStep(t, h)
        assert bits(two.fmu.getReal(references)) == bits(three.fmu.getFloat64(references)), t
        t += h
    two.close()
    three.close()


def test_model_exchange_is_the_same_in_both_versions(fmu, fmu3):  # noqa: F811
    push = np.array([(0, -0.5), (0.1, -0.5), (0.1, 0), (1, 0)], dtype=[("time", float), ("velocity", float)])
    settings = dict(fmi_type="ModelExchange", start_values={"strokeInput": 2, "externalWall": True}, input=push, stop_time=1.0,
                    output=["pressure", "heatReceived"], output_interval=0.01, relative_tolerance=1e-8)  # fmt: skip
    two, three = simulate_fmu(str(fmu), **settings), simulate_fmu(str(fmu3), **settings)
    assert two.tolist() == three.tolist()


def test_a_step_returns_early_at_an_event(fmu3):
    start = {"initialPressure": 5e5, "leakage.conductance": 2e-9, "leakage.criticalPressureRatio": 0.4}
    slave = Slave3(fmu3, early=True, **start)
    t, events = 0.0, []
    while t < 1.0:
        event, terminate, early, reached = slave.fmu.doStep(t, min(0.05, 1.0 - t))
        assert not terminate and event == early and t < reached <= t + 0.05 + 1e-12
        t = reached
        assert slave.get("time") == reached
        if early:
            events.append(slave.get("ambientPressure") / slave.get("pressure"))
            slave.fmu.enterEventMode()
            slave.fmu.updateDiscreteStates()
            slave.fmu.enterStepMode()
    slave.close()
    assert abs(events[0] - 0.4) < 1e-6 and abs(events[1] - 0.999) < 1e-6, events
