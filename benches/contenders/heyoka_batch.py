"""heyoka: Taylor integrators in batch mode, compiled once, one for the push and one for the hold.

Options: `tolerance`, `batch` (scenarios side by side) and `form`, a class of heyoka_equations.py: which equations, and
how they are written.
"""

import contender
import heyoka as hy
import heyoka_equations
import numpy as np


def run(integrator, stretch):
    """The states that a stretch of the tests ends with; rows alike in stiffness go together, so that a batch's lanes end
    at about the same step."""
    batch = integrator.batch_size
    order = np.argsort(stretch.stiffness)
    padded = np.concatenate([order, np.repeat(order[-1:], -len(order) % batch)])
    blocks = lambda columns: np.stack([c[padded].reshape(-1, batch) for c in columns], axis=1)
    parameters, states, times = blocks(stretch.parameters), blocks(stretch.start), blocks([stretch.begin, stretch.end])
    for i in range(len(states)):
        integrator.pars[:] = parameters[i]
        integrator.state[:] = states[i]
        integrator.set_time(times[i, 0])
        integrator.propagate_until(times[i, 1])
        states[i] = integrator.state
    found = np.empty((states.shape[1], len(order)))
    found[:, order] = states.transpose(1, 0, 2).reshape(states.shape[1], -1)[:, : len(order)]
    return found


def prepare(form, batch=128, tolerance=1e-8):
    equations = getattr(heyoka_equations, form)
    build = lambda system: hy.taylor_adaptive_batch(
        system, state=np.ones((len(system), batch)), tol=tolerance, force_avx512=True, fast_math=True
    )
    pushed, held = build(equations.PUSH), build(equations.HOLD)

    def solve(cases):
        rows = equations(cases)
        middle = run(pushed, rows.push())
        final = run(held, rows.hold(middle))
        return np.stack([rows.pressure(middle, "push"), rows.pressure(final, "hold")], axis=1)

    return solve


if __name__ == "__main__":
    contender.serve(prepare)
