"""The contenders of the comparison: what each is, its options, and how many scenarios it solves in one repetition."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Entry:
    """One line of the comparison."""

    name: str
    group: str  # "ours", "ours, more", "peer", "whole"
    program: str
    options: dict
    rows: int
    study: str = "sealed"
    note: str = ""


ALL = 1 << 17

# The studies beside the sealed one, and what their rows have.
EFFECTS = {
    "flows": "leakage and inflow",
    "natural_convection": "natural convection",
    "wall_heating": "wall heating",
    "gas_column": "gas column length",
}


def ours(name, group="ours", study="sealed", **options):
    return Entry(name, group, "ours", {"passes": 4, **options}, ALL, study)


def heyoka(note, name, form, study="sealed", batch=128, tolerance=1e-8):
    options = {"form": form, "batch": batch, "tolerance": tolerance}
    return Entry(f"heyoka, {name}", "peer", "heyoka_batch.py", options, ALL, study, note)


def with_effect(study):
    """Ours as it comes and by the full equations, at two tolerances each, and diffsol's, with the effects of a study."""
    effect = EFFECTS[study]
    as_it_comes = [
        ours(f"{effect}, as it comes, rtol 1e-8", study=study, auto=True, tolerance=1e-8, passes=1),
        ours(f"{effect}, as it comes, rtol 1e-10", study=study, auto=True, tolerance=1e-10, passes=1),
    ]
    return [
        # Rows with flows come as full equations; those with a closed form have no tolerance.
        *([] if study in ("flows", "gas_column") else as_it_comes),
        ours(f"{effect}, full equations, rtol 1e-8", study=study, tolerance=1e-8, passes=1),
        ours(f"{effect}, full equations, rtol 1e-10", study=study, tolerance=1e-10, passes=1),
        Entry(
            f"diffsol, {effect}",
            "peer",
            "diffsol",
            {"equations": study, "tolerance": 1e-9, "width": 128},
            1 << 15,
            study,
            "Tsitouras 5(4), 128 as one system, sorted, common steps",
        ),
    ]


CONTENDERS = [
    ours("full equations, rtol 1e-8", tolerance=1e-8),
    ours("full equations, rtol 5e-10", tolerance=5e-10),
    ours("full equations, rtol 1e-10 (the default)", tolerance=1e-10),
    ours("exact solution", auto=True, passes=16),
    ours("full equations and the paper's regression, rtol 1e-10", "ours, more", tolerance=1e-10, fit=True, passes=1),
    ours("exact solution and the paper's regression", "ours, more", auto=True, fit=True, passes=1),
    heyoka("plain equations, batches of the SIMD width", "plain, 8 wide", "Plain", batch=8),
    heyoka("plain equations", "plain, 64 wide", "Plain", batch=64),
    heyoka("root of the volume as independent variable", "transformed, 64 wide", "Root", batch=64),
    heyoka("the same", "transformed, 128 wide", "Root"),
    heyoka("the same", "transformed, 128 wide, tighter", "Root", tolerance=1e-9),
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
    *with_effect("flows"),
    heyoka("roots of the volume, temperature and mass; events", "leakage and inflow", "FlowsRoot", "flows"),
    *with_effect("natural_convection"),
    heyoka("hold with the logarithm of T − Tw", "natural convection", "NaturalTime", "natural_convection"),
    heyoka("hold with a power of T − Tw", "natural convection, transformed", "NaturalInverse", "natural_convection"),
    *with_effect("wall_heating"),
    ours("wall heating, as it comes, rtol 5e-10", study="wall_heating", auto=True, tolerance=5e-10, passes=1),
    ours("wall heating, full equations, rtol 5e-10", study="wall_heating", tolerance=5e-10, passes=1),
    heyoka("plain equations", "wall heating", "WallPlain", "wall_heating"),
    heyoka("root of the volume as independent variable", "wall heating, transformed", "WallRoot", "wall_heating"),
    *with_effect("gas_column"),
    ours("gas column length, as it comes", study="gas_column", auto=True),
    heyoka("plain equations", "gas column length", "ColumnPlain", "gas_column"),
    heyoka("ln V as independent variable", "gas column length, ln V", "ColumnLog", "gas_column"),
    heyoka("the same, exponentials as states", "gas column length, exponentials as states", "ColumnStates", "gas_column"),
    heyoka("the same, 1/T as state", "gas column length, 1/T", "ColumnReciprocal", "gas_column"),
]

WHOLE_PROCESS = [
    Entry("whole process, full equations, rtol 5e-9", "whole", "pneutherm", {"solver": "adaptive", "tolerance": 5e-9}, 1 << 21),
    Entry("whole process, as it comes", "whole", "pneutherm", {"solver": "auto"}, 1 << 21, note="exact where sealed"),
]
