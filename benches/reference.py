"""Independent integrations of single scenarios: scipy's DOP853 at its tightest, on the equations that
tests/python/reference.py states from the documentation, any effect included."""

import importlib.util
import multiprocessing
import pathlib
import sys

import numpy as np
import scenario
from scenario import AMBIENT_PRESSURE, AMBIENT_TEMPERATURE, GAS_CONSTANT
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

_path = pathlib.Path(__file__).resolve().parents[1] / "tests" / "python" / "reference.py"
_spec = importlib.util.spec_from_file_location("independent", _path)
independent = importlib.util.module_from_spec(_spec)
sys.modules["independent"] = independent
_spec.loader.exec_module(independent)

# s: left to itself, scipy begins with a step that does not notice |T - Tw|^n at T = Tw, and errs by 2e-7.
FIRST_STEP = 1e-6


def chamber(case):
    """The chamber of a scenario, with the effects that are on."""
    effects = {}
    for name, value in zip(scenario.COLUMNS, case.tolist()):
        effect, _, parameter = name.rpartition(".")
        if effect and value:
            effects.setdefault(effect, {})[parameter] = value
    return independent.Chamber(
        bore=case[0],
        dead_volume=case[1],
        lambda0=case[5],
        ambient_temperature=AMBIENT_TEMPERATURE,
        ambient_pressure=AMBIENT_PRESSURE,
        effects=effects,
    )


def integrate(case, rtol=1e-12):
    """Peak pressure from the end of the push on, final pressure, and the pressure at the end of the push."""
    c = chamber(case)
    pressure, begin, end, push, duration = case[2], case[3], case[4], case[6], case[7]
    inflow = float(scenario.column(case, "mass_flow_in_kg_per_s"))
    mass = pressure * c.volume(begin) / (GAS_CONSTANT * AMBIENT_TEMPERATURE)

    def run(y, span, position, speed):
        def rates(t, y):
            return c.rates(y, position + speed * t, speed, inflow)[0]

        return solve_ivp(rates, (0, span), y, method="DOP853", rtol=rtol, atol=1e-16 * np.abs(y), dense_output=True, first_step=FIRST_STEP)

    pushed = run(c.at_rest(pressure, mass, AMBIENT_TEMPERATURE)[0], push, begin, (end - begin) / push)
    held = run(pushed.y[:, -1], duration - push, end, 0.0)
    # With an inflow the largest pressure may come after the push.
    highest = int(np.argmax(held.y[0]))
    peak = held.y[0, highest]
    if 0 < highest < len(held.t) - 1:
        around = (held.t[highest - 1], held.t[highest + 1])
        found = minimize_scalar(lambda t: -held.sol(t)[0], bounds=around, method="bounded", options={"xatol": 1e-9})
        peak = max(peak, -found.fun)
    return peak, held.y[0, -1], held.y[0, 0]


def integrate_all(cases):
    """`integrate` for each scenario, on all cores."""
    with multiprocessing.Pool() as pool:
        return np.array(pool.map(integrate, cases, chunksize=4))
