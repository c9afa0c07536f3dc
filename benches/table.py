"""The contenders of the comparison: what each is, its options, and how many scenarios it solves in one repetition."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Entry:
    """One line of the comparison."""

    name: str
    group: str  # "ours", "ours, more", "peer"
    program: str
    options: dict
    rows: int
    study: str = "sealed"
    note: str = ""


ALL = 1 << 17


def ours(name, group="ours", study="sealed", **options):
    return Entry(name, group, "ours", {"passes": 4, **options}, ALL, study)


def heyoka(note, name, **options):
    return Entry(f"heyoka, {name}", "peer", "heyoka_batch.py", options, ALL, note=note)


CONTENDERS = [
    ours("full equations, rtol 1e-8", tolerance=1e-8),
    ours("full equations, rtol 5e-10", tolerance=5e-10),
    ours("full equations, rtol 1e-10 (the default)", tolerance=1e-10),
    ours("exact solution", exact=True, passes=16),
    ours("full equations and the paper's regression, rtol 1e-10", "ours, more", tolerance=1e-10, fit=True, passes=1),
    ours("exact solution and the paper's regression", "ours, more", exact=True, fit=True, passes=1),
    ours("leakage and inflow on, rtol 1e-8", "ours, more", "flows", tolerance=1e-8, passes=1),
    ours("leakage and inflow on, rtol 1e-10", "ours, more", "flows", tolerance=1e-10, passes=1),
    heyoka("plain equations, batches of the SIMD width", "plain, 8 wide", form="time", batch=8, tolerance=1e-8),
    heyoka("plain equations", "plain, 64 wide", form="time", batch=64, tolerance=1e-8),
    heyoka("root of the volume as independent variable", "transformed, 64 wide", form="root", batch=64, tolerance=1e-8),
    heyoka("the same", "transformed, 128 wide", form="root", batch=128, tolerance=1e-8),
    heyoka("the same", "transformed, 128 wide, tighter", form="root", batch=128, tolerance=1e-9),
    Entry("diffsol, one at a time", "peer", "diffsol", {"tolerance": 1e-8, "width": 1}, 1 << 14, note="Tsitouras 5(4)"),
    Entry("diffsol, 128 as one system", "peer", "diffsol", {"tolerance": 2e-9, "width": 128}, ALL, note="sorted, common steps"),
    Entry("diffsol, 128 as one system, tighter", "peer", "diffsol", {"tolerance": 5e-11, "width": 128}, ALL, note="sorted, common steps"),
    Entry("differential-equations, one at a time", "peer", "dop853", {"tolerance": 1e-8, "width": 1}, 1 << 16, note="DOP853"),
    Entry("differential-equations, 8 as one system", "peer", "dop853", {"tolerance": 1e-8, "width": 8}, ALL, note="DOP853, sorted, common steps"),
    Entry("differential-equations, 8 as one system, tighter", "peer", "dop853", {"tolerance": 2e-10, "width": 8}, ALL, note="DOP853, sorted, common steps"),
    Entry("diffrax, vmap", "peer", "diffrax_vmap.py", {"method": "Dopri8", "batch": 256, "tolerance": 1e-8}, 1 << 16, note="Dopri8, sorted"),
    Entry("scipy, solve_ivp", "peer", "scipy_loop.py", {"tolerance": 1e-8}, 1 << 10, note="DOP853"),
    Entry("FMPy, a trace of 100 Hz", "peer", "fmpy_reused.py", {"fmu": "{fmu}", "form": "trace", "tolerance": 1e-9}, 1 << 7, note="simulate_fmu, our FMU, instance reused"),
    Entry("FMPy, push and hold only", "peer", "fmpy_reused.py", {"fmu": "{fmu}", "form": "simulate", "tolerance": 1e-9}, 1 << 10, note="simulate_fmu, our FMU, instance reused"),
    Entry("FMPy, FMI calls by hand", "peer", "fmpy_reused.py", {"fmu": "{fmu}", "form": "steps", "tolerance": 1e-9}, 1 << 14, note="our FMU, two steps a scenario"),
]

WHOLE_PROCESS = [
    Entry("whole process, full equations, rtol 1e-8", "whole", "pneutherm", {"solver": "adaptive", "tolerance": 1e-8}, 1 << 21),
    Entry("whole process, as it comes", "whole", "pneutherm", {"solver": "auto"}, 1 << 21, note="exact where sealed"),
]
