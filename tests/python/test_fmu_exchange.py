"""The FMU in FMPy's Model Exchange: CVode and Euler compared with co-simulation, the exact solution and SciPy."""

import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
integrate = pytest.importorskip("scipy.integrate", reason="SciPy is not installed")
from fmpy import read_model_description, simulate_fmu  # noqa: E402
from test_fmu_clients import AREA, DEAD, GAMMA, LAMBDA0, P0, R, T0, fmu, wall_area  # noqa: E402, F401

AMBIENT = 295.0
START = {"strokeInput": 2, "initialPressure": 1.2e5, "initialTemperature": AMBIENT, "leakage.conductance": 0.0, "position": 0.1}
PUSH = np.array([(0, -0.5), (0.1, -0.5), (0.1, 0), (1, 0)], dtype=[("time", float), ("velocity", float)])
OUTPUT = ["pressure", "temperature", "heatReceived", "workDone", "internalEnergy", "pistonPosition"]


def run(fmu, kind, **settings):
    settings = {"start_values": START, "input": PUSH, "output": OUTPUT, "stop_time": 1.0, "output_interval": 0.01} | settings
    return simulate_fmu(str(fmu), fmi_type=kind, **settings)


def exact_pressure(times):
    """Ramp and hold: the paper's equations are linear in 1/T (Bernoulli)."""
    v0, rate = DEAD + AREA * 0.1, -0.5 * AREA
    mass_r = 1.2e5 * v0 / AMBIENT
    c = LAMBDA0 * np.sqrt(mass_r / (P0 * T0)) * (GAMMA - 1) / mass_r
    b = lambda v: c * wall_area(v) / np.sqrt(v)  # noqa: E731
    volume = lambda t: v0 + rate * min(t, 0.1)  # noqa: E731
    slope = lambda t, u: b(volume(t)) - (b(volume(t)) * AMBIENT - (GAMMA - 1) * (rate if t < 0.1 else 0) / volume(t)) * u  # noqa: E731
    u, result = 1 / AMBIENT, []
    for start, end in zip(times, times[1:]):
        result.append(mass_r / u / volume(start))
        u = integrate.solve_ivp(slope, (start, end - 1e-15), [u], "DOP853", rtol=1e-12, atol=1e-16).y[0, -1]
    return np.array([*result, mass_r / u / volume(times[-1])])


def test_cvode_agrees_with_co_simulation_and_the_exact_ramp_and_hold(fmu):  # noqa: F811
    together = run(fmu, "CoSimulation", relative_tolerance=1e-11)
    # CVODE's tolerance applies to the mean over all states; those of inactive effects have no error.
    apart = run(fmu, "ModelExchange", relative_tolerance=5e-10)
    exact = exact_pressure(together["time"])
    assert np.max(np.abs(together["pressure"] / exact - 1)) < 1e-8
    for row, truth in zip(together, exact):
        here = apart[np.isclose(apart["time"], row["time"], atol=1e-9)]
        assert len(here) and abs(here["pressure"][-1] / truth - 1) < 1e-7, row["time"]
        for name in ("heatReceived", "workDone"):
            assert abs(here[name][-1] - row[name]) < 1e-7 * row["internalEnergy"], (name, row["time"])
    assert abs(apart["pistonPosition"][-1] - 0.05) < 1e-7


def test_euler_converges_as_its_order_says(fmu):  # noqa: F811
    still = np.array([(0, 0), (1, 0)], dtype=PUSH.dtype)
    start = START | {"initialTemperature": 350.0}
    exact = run(fmu, "CoSimulation", input=still, start_values=start)["pressure"][20]
    errors = []
    for h in (1e-3, 5e-4):
        result = run(fmu, "ModelExchange", solver="Euler", output_interval=h, step_size=h, input=still, start_values=start)
        errors.append(abs(result["pressure"][np.isclose(result["time"], 0.2)][0] / exact - 1))
    assert errors[0] < 2e-3 and 1.8 < errors[0] / errors[1] < 2.2, errors


def test_no_step_straddles_choking_or_the_turn_of_a_flow(fmu):  # noqa: F811
    # The leak stops choking and reverses twice; the flow reverses at a time that is no multiple of the output interval.
    start = START | {"initialPressure": 6e5, "leakage.conductance": 2e-9, "leakage.criticalPressureRatio": 0.4}
    flow = np.array([(0, 0, 0), (0.5, 0, 0), (1, 0, -1e-4), (1.5, 0, 1.3e-4)], dtype=[("time", float), ("velocity", float), ("massFlowIn", float)])
    result = run(fmu, "ModelExchange", start_values=start, input=flow, stop_time=1.5, relative_tolerance=1e-8, record_events=True,
                 output=["pressure", "massFlowIn"])
    ambient = float(next(v.start for v in read_model_description(str(fmu)).modelVariables if v.name == "ambientPressure"))
    after = result["time"] > 0.6
    for what, side, times in (
        ("choking", ambient / result["pressure"] - 0.4, 1),
        ("the leak's direction", result["pressure"] / ambient - 1, 2),
        ("the flow's direction", np.where(after, result["massFlowIn"], -1e-4) / 1e-4, 1),
    ):
        crossings = np.flatnonzero(np.diff(side > 0))
        assert len(crossings) == times, (what, result["time"][crossings])
        for k in crossings:
            assert np.min(np.abs(side[k : k + 2])) < 1e-6, (what, result["time"][k : k + 2], side[k : k + 2])
    turned = 1 + 0.5 * 1 / 2.3
    assert np.min(np.abs(result["time"] - turned)) < 1e-8


def test_port_into_a_small_volume_at_a_coarse_step_is_that_of_scipy(fmu):  # noqa: F811
    # 4 l/(s bar) into 3 cm3, 10 ms steps.
    position = 1e-6 / AREA
    volume, cv, cp = DEAD + AREA * position, R / (GAMMA - 1), GAMMA * R / (GAMMA - 1)
    area = wall_area(volume)

    def rates(_, y):
        m, u = y
        p, t = (GAMMA - 1) * u / volume, u / (m * cv)
        up, down, t_up = (7e5, p, AMBIENT) if p < 7e5 else (p, 7e5, t)
        r = down / up
        psi = np.sqrt(max(0.0, 1 - max(0.0, (min(r, 0.999) - 0.3) / 0.7) ** 2)) * min(1.0, (1 - r) / 0.001)
        flow = np.sign(7e5 - p) * 4e-8 * up * 1.185 * np.sqrt(293.15 / t_up) * psi
        return [flow, flow * cp * t_up + LAMBDA0 * np.sqrt(p * t / (P0 * T0)) * area * (AMBIENT - t)]

    start = START | {"position": position, "supplyPortPressure": 7e5, "supplyPortConductance": 4e-8, "supplyPortTemperature": AMBIENT}
    result = simulate_fmu(str(fmu), start_values=start, output=["pressure", "mass"], stop_time=0.1, output_interval=0.01, step_size=0.01)
    y0 = [1.2e5 * volume / (R * AMBIENT), 1.2e5 * volume / (GAMMA - 1)]
    truth = integrate.solve_ivp(rates, (0, 0.1), y0, "Radau", rtol=1e-11, atol=1e-16, t_eval=result["time"].clip(0, 0.1))
    pressure = (GAMMA - 1) * truth.y[1] / volume
    assert np.max(np.abs(result["pressure"] - pressure)) < 1e-4 * 1e5
