"""heyoka: Taylor integrators in batch mode, compiled once, one for the push and one for the hold.

Options: `tolerance`, `batch` (scenarios side by side) and `form`, how the push is written:
"time": V = V0 + V' t inside the equation; "root": the square root of the volume as the independent variable,
dT/ds = T ((2/V') (c a1 s² + c a0) (Tw − T) − 2 (γ − 1)/s), which leaves one division and no root.
"""

import contender
import heyoka as hy
import numpy as np
from scenario import AMBIENT_TEMPERATURE as TW
from scenario import GAMMA, Sealed

T = hy.make_vars("T")


def push(form):
    p = hy.par
    if form == "root":
        return [(T, T * ((p[0] * hy.time * hy.time + p[1]) * (TW - T) - 2 * (GAMMA - 1) / hy.time))]
    volume = p[0] + p[1] * hy.time
    root, per_volume = hy.sqrt(volume), 1.0 / volume
    return [(T, T * ((p[2] * volume + p[3]) * root * (TW - T) - p[4]) * per_volume)]


def data(form, s):
    """Parameters, begin and end of the independent variable."""
    if form == "root":
        return [2 / s.volume_rate * s.lateral, 2 / s.volume_rate * s.faces], np.sqrt(s.volume), np.sqrt(s.held_volume)
    zero = np.zeros_like(s.volume)
    return [s.volume, s.volume_rate, s.lateral, s.faces, (GAMMA - 1) * s.volume_rate], zero, s.push_time


def prepare(form="root", batch=64, tolerance=1e-8):
    build = lambda system: hy.taylor_adaptive_batch(
        system, state=np.ones((1, batch)), tol=tolerance, force_avx512=True, fast_math=True
    )
    pushed, held = build(push(form)), build([(T, hy.par[0] * T * (TW - T))])

    def solve(cases):
        s = Sealed.of(cases)
        # Those alike in stiffness go together, so that a batch's lanes end at about the same step.
        order = np.argsort(s.held_exchange)
        order = np.concatenate([order, np.repeat(order[-1:], -len(order) % batch)])
        blocks = lambda column: column[order].reshape(-1, batch)
        parameters, begins, ends = data(form, s)
        parameters = np.stack([blocks(column) for column in parameters], axis=1)
        begins, ends, exchange, hold = map(blocks, (begins, ends, s.held_exchange, s.hold_time))
        peaks, finals = np.empty_like(begins), np.empty_like(begins)
        zero = np.zeros(batch)
        for i in range(len(begins)):
            pushed.pars[:] = parameters[i]
            pushed.state[:] = TW
            pushed.set_time(begins[i])
            pushed.propagate_until(ends[i])
            peaks[i] = pushed.state[0]
            held.pars[0] = exchange[i]
            held.state[0] = peaks[i]
            held.set_time(zero)
            held.propagate_until(hold[i])
            finals[i] = held.state[0]
        peak, final = np.empty(len(cases)), np.empty(len(cases))
        peak[order], final[order] = peaks.ravel(), finals.ravel()
        return s.pressures(peak, final)

    return solve


if __name__ == "__main__":
    contender.serve(prepare)
