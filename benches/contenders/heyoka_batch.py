"""heyoka: Taylor integrators in batch mode, compiled once, one for the push and one for the hold.

Options: `tolerance`, `batch` (scenarios side by side) and `form`, a class of heyoka_equations.py: which equations, and
how they are written.
"""

import contender
import heyoka as hy
import heyoka_equations
import numpy as np


def run(integrators, stretch):
    """The states that a stretch of the tests ends with, each row by the integrator it asks for."""
    found = np.empty((len(stretch.start), len(stretch.begin)))
    for number, integrator in enumerate(integrators):
        rows = np.arange(len(stretch.begin)) if stretch.which is None else np.flatnonzero(stretch.which == number)
        if len(rows):
            propagate(integrator, stretch, rows[np.argsort(stretch.stiffness[rows])], found)
    return found


def propagate(integrator, stretch, rows, found):
    """Solves rows in this order: those alike in stiffness go together, so that a batch's lanes end at about the same step."""
    batch = integrator.batch_size
    padded = np.concatenate([rows, np.repeat(rows[-1:], -len(rows) % batch)])
    blocks = lambda columns: np.stack([c[padded].reshape(-1, batch) for c in columns], axis=1)
    parameters, states, times = blocks(stretch.parameters), blocks(stretch.start), blocks([stretch.begin, stretch.end])
    for i in range(len(states)):
        integrator.pars[:] = parameters[i]
        integrator.state[:] = states[i]
        integrator.set_time(times[i, 0])
        integrator.propagate_until(times[i, 1])
        states[i] = integrator.state
    found[:, rows] = states.transpose(1, 0, 2).reshape(len(found), -1)[:, : len(rows)]


def prepare(form, batch=128, tolerance=1e-8):
    equations = getattr(heyoka_equations, form)
    options = dict(tol=tolerance, force_avx512=True, fast_math=True)
    build = lambda system: hy.taylor_adaptive_batch(
        system.equations, state=np.ones((len(system.equations), batch)), t_events=system.events, **options
    )
    pushed, held = list(map(build, equations.PUSH)), list(map(build, equations.HOLD))

    def solve(cases):
        rows = equations(cases)
        middle = run(pushed, rows.push())
        final = run(held, rows.hold(middle))
        return np.stack([rows.pressure(middle, "push"), rows.pressure(final, "hold")], axis=1)

    return solve


if __name__ == "__main__":
    contender.serve(prepare)
