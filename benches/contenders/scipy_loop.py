"""scipy: `solve_ivp`, DOP853, one scenario after the other."""

import contender
import numpy as np
from scenario import AMBIENT_TEMPERATURE as TW
from scenario import GAMMA, Sealed
from scipy.integrate import solve_ivp


def prepare(tolerance=1e-8):
    from math import sqrt

    def solve(cases):
        s = Sealed.of(cases)
        answers = np.empty((len(cases), 2))
        columns = (s.volume, s.volume_rate, s.lateral, s.faces, s.held_exchange, s.push_time, s.hold_time)
        options = dict(method="DOP853", rtol=tolerance, atol=tolerance * 1e-3)
        for i, (v0, rate, lateral, faces, exchange, push, hold) in enumerate(zip(*(c.tolist() for c in columns))):

            def pushed(t, y):
                v = v0 + rate * t
                temperature = y[0]
                return (temperature * ((lateral * v + faces) / sqrt(v) * (TW - temperature) - (GAMMA - 1) * rate / v),)

            def held(_, y):
                return (exchange * y[0] * (TW - y[0]),)

            peak = solve_ivp(pushed, (0, push), (TW,), **options).y[0, -1]
            answers[i] = peak, solve_ivp(held, (0, hold), (peak,), **options).y[0, -1]
        return s.pressures(*answers.T)

    return solve


if __name__ == "__main__":
    contender.serve(prepare)
