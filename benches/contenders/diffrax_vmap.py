"""diffrax: `vmap` over scenarios, 64-bit floats, compiled before the clock starts; one XLA thread in each process.

Options: `tolerance`, `batch` and `method` ("Dopri8" or "Tsit5").
"""

import os

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"

import contender
import numpy as np
from scenario import AMBIENT_TEMPERATURE as TW
from scenario import GAMMA, Sealed


def prepare(method="Dopri8", batch=1024, tolerance=1e-8):
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    solver = getattr(diffrax, method)()
    steps = diffrax.PIDController(rtol=tolerance, atol=tolerance * 1e-3)
    options = dict(stepsize_controller=steps, saveat=diffrax.SaveAt(t1=True), adjoint=diffrax.ForwardMode(), max_steps=4096)

    def pushed(t, temperature, p):
        volume = p[0] + p[1] * t
        exchange = (p[2] * volume + p[3]) / jnp.sqrt(volume)
        return temperature * (exchange * (TW - temperature) - (GAMMA - 1) * p[1] / volume)

    def held(t, temperature, k):
        return k * temperature * (TW - temperature)

    def one(p, push_time, exchange, hold_time):
        peak = diffrax.diffeqsolve(
            diffrax.ODETerm(pushed), solver, 0.0, push_time, push_time / 4, TW, args=p, **options
        ).ys[0]
        final = diffrax.diffeqsolve(
            diffrax.ODETerm(held), solver, 0.0, hold_time, 0.05 / (TW * exchange), peak, args=exchange, **options
        ).ys[0]
        return peak, final

    many = jax.jit(jax.vmap(one))

    def solve(cases):
        s = Sealed.of(cases)
        order = np.argsort(s.held_exchange)
        order = np.concatenate([order, np.repeat(order[-1:], -len(order) % batch)])
        parameters = np.stack([s.volume, s.volume_rate, s.lateral, s.faces], axis=1)[order]
        columns = [parameters, s.push_time[order], s.held_exchange[order], s.hold_time[order]]
        answers = [many(*(c[i : i + batch] for c in columns)) for i in range(0, len(order), batch)]
        peak, final = np.empty(len(cases)), np.empty(len(cases))
        peak[order] = np.concatenate([np.asarray(a) for a, _ in answers])
        final[order] = np.concatenate([np.asarray(b) for _, b in answers])
        return s.pressures(peak, final)

    return solve


if __name__ == "__main__":
    contender.serve(prepare)
