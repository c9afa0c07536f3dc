"""Independent integrations of single scenarios: scipy's DOP853 at its tightest, on pressure (sealed) or on pressure and
mass with the flows, written from the documentation in tests/python/reference.py."""

import pathlib
import sys

import numpy as np
from scenario import AMBIENT_PRESSURE, AMBIENT_TEMPERATURE, GAMMA, GAS_CONSTANT
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "python"))
import importlib.util

_spec = importlib.util.spec_from_file_location("independent", pathlib.Path(sys.path[-1]) / "reference.py")
independent = importlib.util.module_from_spec(_spec)
sys.modules["independent"] = independent
_spec.loader.exec_module(independent)


def chamber(case):
    leak = {"leakage": {"conductance_m3_per_s_pa": case[8]}} if case[8] else {}
    return independent.Chamber(
        bore=case[0], dead_volume=case[1], lambda0=case[5], ambient_temperature=AMBIENT_TEMPERATURE, ambient_pressure=AMBIENT_PRESSURE, effects=leak
    )


def integrate(case, rtol):
    """Peak and final pressure of states pressure and mass (equations (1) and (2) of the paper with mass flows)."""
    c = chamber(case)
    pressure, begin, end, push, duration = case[2], case[3], case[4], case[6], case[7]
    mass = pressure * c.volume(begin) / (GAS_CONSTANT * AMBIENT_TEMPERATURE)

    def rates(t, y, position, speed):
        p, m = y
        x = position + speed * t
        volume = c.volume(x)
        temperature = p * volume / (m * GAS_CONSTANT)
        leaked_in, leaked_out = c.leak(p, temperature)
        inflow, outflow = case[9] + leaked_in, leaked_out
        heat = c.coefficient(p, temperature, AMBIENT_TEMPERATURE, x, speed) * c.heat_area(x) * (AMBIENT_TEMPERATURE - temperature)
        enthalpy = GAMMA * GAS_CONSTANT * (inflow * AMBIENT_TEMPERATURE - outflow * temperature)
        return (enthalpy + (GAMMA - 1) * heat - GAMMA * p * c.piston_area * speed) / volume, inflow - outflow

    def run(y, span, position, speed):
        options = dict(method="DOP853", rtol=rtol, atol=1e-16 * np.abs(y), dense_output=True)
        return solve_ivp(rates, (0, span), y, args=(position, speed), **options)

    pushed = run(np.array([pressure, mass]), push, begin, (end - begin) / push)
    held = run(pushed.y[:, -1], duration - push, end, 0.0)
    # With an inflow the largest pressure may come after the push.
    highest = int(np.argmax(held.y[0]))
    peak = held.y[0, highest]
    if 0 < highest < len(held.t) - 1:
        around = (held.t[highest - 1], held.t[highest + 1])
        found = minimize_scalar(lambda t: -held.sol(t)[0], bounds=around, method="bounded", options={"xatol": 1e-9})
        peak = max(peak, -found.fun)
    return peak, held.y[0, -1]


def sealed(case):
    """Without flows, at rtol 1e-13."""
    return integrate(case, 1e-13)


def with_flows(case):
    """With leakage and inflow, at rtol 1e-12."""
    return integrate(case, 1e-12)
