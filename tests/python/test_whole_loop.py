"""From measured traces with an undeclared effect to an FMU running in another tool: what remains is the sensor's noise."""

import csv
import json

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

import reference

NOISE_PA = 150.0
RATE_HZ = 100.0
AMBIENT_K = 296.0

# name: initial pressure, and (time, position) of the stroke
EXPERIMENTS = {
    "compress-ambient": (1.013e5, [(0, 0.1), (0.5, 0.1), (0.55, 0.05), (6, 0.05)]),
    "compress-3bar": (3.2e5, [(0, 0.1), (0.5, 0.1), (0.56, 0.05), (6, 0.05)]),
    "expand-5bar": (5e5, [(0, 0.05), (0.5, 0.05), (0.6, 0.1), (6, 0.1)]),
    "expand-ambient": (1.013e5, [(0, 0.05), (0.5, 0.05), (0.55, 0.1), (6, 0.1)]),
}
VALIDATION = (2.5e5, [(0, 0.1), (0.4, 0.1), (0.6, 0.06), (2, 0.06), (2.1, 0.09), (4, 0.09), (4.3, 0.04), (6, 0.04)])

UNDECLARED = {
    "leakage": {"leakage": {"conductance_m3_per_s_pa": 4e-12}},
    "tube_volume": {"tube_volume": {"volume_m3": 2e-6}},
    "sensor_lag": {"sensor_lag": {"time_constant_s": 0.03}},
}


def record(chamber, pressure, stroke, generator):
    """Rows of a trace as written by a logger."""
    times, positions = np.array(stroke, float).T
    rows = np.arange(0, times[-1] + 1e-9, 1 / RATE_HZ)
    truth = reference.simulate(chamber, times, positions, pressure, rows=rows)
    measured = truth["pressure_pa"] + generator.normal(0, NOISE_PA, len(rows))
    position = np.interp(rows, times, positions) + generator.normal(0, 2e-6, len(rows))
    return rows, measured, position


def write_trace(path, rows, measured, position):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "pressure_pa", "position_m"])
        writer.writerows((f"{t:.3f}", f"{p:.1f}", f"{x:.6f}") for t, p, x in zip(rows, measured, position))


def write_rig(folder, chamber, generator):
    lines = [f"[cylinder]\nbore_m = {chamber.bore}\nrod_m = 0.0"]
    lines.append(f"[ambient]\ntemperature_k = {AMBIENT_K}\npressure_pa = {chamber.ambient_pressure}")
    lines.append('[gas]\nname = "air"')
    for name, (pressure, stroke) in EXPERIMENTS.items():
        traces = []
        for repeat in (1, 2):
            traces.append(f"{name}-{repeat}.csv")
            start = pressure * generator.normal(1, 0.003)
            write_trace(folder / traces[-1], *record(chamber, start, stroke, generator))
        lines.append(f'[[experiment]]\nname = "{name}"\ntraces = {json.dumps(traces)}')
    (folder / "rig.toml").write_text("\n".join(lines) + "\n")


def run_fmu(path, rows, position, pressure):
    """`measuredPressure` at each row, with the position and its difference quotient as inputs, as a host would set them."""
    description = fmpy.read_model_description(path)
    references = {v.name: v.valueReference for v in description.modelVariables}
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="validation",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.setReal([references["initialPressure"], references["position"]], [pressure, position[0]])
    slave.exitInitializationMode()
    inputs = [references["position"], references["velocity"]]
    output = [references["measuredPressure"]]
    shown = slave.getReal(output)
    for k, step in enumerate(np.diff(rows)):
        slave.setReal(inputs, [position[k], (position[k + 1] - position[k]) / step])
        slave.doStep(rows[k], step)
        shown += slave.getReal(output)
    slave.terminate()
    slave.freeInstance()
    return np.array(shown)


@pytest.mark.parametrize("effect", UNDECLARED)
def test_an_undeclared_effect_is_found_and_its_fmu_leaves_only_noise_on_another_motion(effect, pneutherm, tmp_path):
    generator = np.random.default_rng(sum(map(ord, effect)))
    chamber = reference.Chamber(
        bore=0.025, dead_volume=6e-6, lambda0=35.0, ambient_temperature=AMBIENT_K, effects=UNDECLARED[effect]
    )
    write_rig(tmp_path, chamber, generator)
    pneutherm("diagnose", "rig.toml", "-o", "model.toml", "--json", "diagnosis.json", cwd=tmp_path)
    diagnosis = json.loads((tmp_path / "diagnosis.json").read_text())
    assert (diagnosis["verdict"], diagnosis["effects"]) == ("explained", [effect])
    assert diagnosis["after"]["rmse_pa"]["held_out"] < 0.5 * diagnosis["before"]["rmse_pa"]["held_out"]
    found = diagnosis["after"]["parameters"]
    assert found["lambda0_w_per_m2_k"]["value"] == pytest.approx(chamber.lambda0, rel=0.02)
    for key, value in UNDECLARED[effect][effect].items():
        assert found[f"{effect}.{key}"]["value"] == pytest.approx(value, rel=0.05)

    pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=tmp_path)
    rows, measured, position = record(chamber, *VALIDATION, generator)
    shown = run_fmu(str(tmp_path / "Chamber.fmu"), rows, position, VALIDATION[0])
    error = float(np.sqrt(np.mean((shown - measured) ** 2)))
    assert error < 1.1 * NOISE_PA, f"{error:.0f} Pa on the validation motion, noise {NOISE_PA:.0f} Pa"
