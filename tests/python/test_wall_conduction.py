"""The sum of modes that `wall_conduction` integrates, against exact solutions of the semi-infinite wall.

That the program integrates these modes is tested in test_simulate.py; here, how well they represent the wall.
"""

import numpy as np
from scipy.linalg import expm
from scipy.special import erfcx

import reference
from test_simulate import simulated, stroke

INVERSE = 2e-3  # 1/effusivity of a plastic wall, m2 K/(W s^0.5)


def test_a_wall_beside_gas_of_constant_temperature_warms_as_the_error_function_says():
    """Carslaw and Jaeger (1959), section 2.7: surface over gas = 1 - exp(x^2) erfc(x), x = lambda sqrt(t)/e."""
    rates, weights = reference.MODE_RATES, reference.MODE_WEIGHTS
    for conductance in [10.0, 100.0, 1000.0]:
        # dx/dt = (c/e) lambda (1 - sum x) - mu x, with the 1 appended as a constant state.
        drive = INVERSE * conductance * weights
        system = np.zeros((len(rates) + 1, len(rates) + 1))
        system[:-1, :-1] = -np.diag(rates) - np.outer(drive, np.ones(len(rates)))
        system[:-1, -1] = drive
        for time, within in [(0.03, 0.03), (0.2, 2e-3), (1.0, 1e-3), (60.0, 1e-3), (2400.0, 1e-3)]:
            surface = expm(system * time)[:-1, -1].sum()
            exact = 1 - erfcx(INVERSE * conductance * np.sqrt(time))
            assert abs(surface / exact - 1) < within, (conductance, time, surface, exact)


def exact_pressures(chamber, inverse, times, positions, pressure, dt):
    """The sealed chamber with the wall's surface from the convolution itself: flux linear over steps of `dt`, integrated
    exactly against 1/sqrt(pi t), and the gas by the trapezoidal rule in T V^(gamma - 1)."""
    steps = round(times[-1] / dt)
    t = np.arange(steps + 1) * dt
    x = np.interp(t, times, positions)
    volume, area = chamber.volume(x), np.array([chamber.heat_area(one) for one in x])
    ambient, r, gamma = chamber.ambient_temperature, chamber.gas_constant, chamber.gamma
    mass = pressure * volume[0] / (r * ambient)
    capacity = mass * r / (gamma - 1)
    power = np.arange(steps + 2) ** 1.5
    hats = np.concatenate([[1.0], power[2:] - 2 * power[1:-1] + power[:-2]]) * 4 / 3 * np.sqrt(dt / np.pi) * inverse
    stiffened = volume ** (gamma - 1)
    temperature, flux = np.full(steps + 1, ambient), np.zeros(steps + 1)
    invariant = ambient * stiffened[0]
    for n in range(1, steps + 1):
        # The flux is zero at the start, so the oldest half hat is omitted.
        memory = hats[1:n] @ flux[n - 1 : 0 : -1]
        flux[n], temperature[n] = flux[n - 1], temperature[n - 1]
        for _ in range(6):
            cooling = [flux[k] * area[k] * stiffened[k] / capacity for k in (n - 1, n)]
            temperature[n] = (invariant - dt * sum(cooling) / 2) / stiffened[n]
            p = mass * r * temperature[n] / volume[n]
            law = chamber.coefficient(p, temperature[n], ambient, x[n], 0.0)
            flux[n] = law * (temperature[n] - ambient - memory - hats[0] * flux[n])
        invariant = temperature[n] * stiffened[n]
    return t, mass * r * temperature / volume


def test_the_pressure_is_that_of_a_wall_that_heat_diffuses_into(pneutherm, tmp_path):
    chamber = reference.Chamber(
        lambda0=60.0, effects={"wall_conduction": {"inverse_effusivity_m2_k_per_w_s05": INVERSE}}
    )
    times, positions = stroke()
    ours = simulated(chamber, pneutherm, tmp_path, times, positions)["pressure_pa"]
    exact, coarse = [
        np.interp(times, *exact_pressures(chamber, INVERSE, times, positions, 150000.0, dt)) for dt in (5e-4, 1e-3)
    ]
    without = np.interp(times, *exact_pressures(chamber, 0.0, times, positions, 150000.0, 1e-3))
    by_wall = np.abs(without - exact).max()
    assert np.abs(coarse - exact).max() < 2e-4 * by_wall, "the reference is good enough"
    assert by_wall > 1500.0
    # The modes miss a little of a push of 50 ms; 0.2 s later the error is negligible.
    error = np.abs(ours - exact)
    assert error.max() < 0.015 * by_wall, (error.max(), by_wall)
    assert error[(times > 0.35) & (times < 0.9)].max() < 0.003 * by_wall
