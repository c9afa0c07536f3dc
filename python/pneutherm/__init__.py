"""Heat transfer in pneumatic cylinder chambers, from Python.

The functions take the files that the commands of the program `pneutherm` take, and return pyarrow tables. Units are SI and
stand in each column's name and metadata; pressure is absolute. What is wrong with an input is raised as `Error`, with
the sentence that the program would print. The rows of `simulate` and `sweep` lie where Rust wrote them; they are not copied.

    >>> import pneutherm
    >>> pneutherm.identify("examples/cylinder").parameters.to_pandas()  # doctest: +SKIP
"""

from __future__ import annotations

import dataclasses
import json
import os
from typing import TYPE_CHECKING, Any, Literal, Optional, Union

from . import _native
from ._native import Error

if TYPE_CHECKING:
    import pyarrow

__all__ = ["Diagnosis", "Error", "Identification", "diagnose", "identify", "simulate", "sweep"]

Path = Union[str, "os.PathLike[str]"]


@dataclasses.dataclass(frozen=True)
class Identification:
    """What `identify` found.

    Attributes:
        method: ``"exact"`` or ``"time-constant"``.
        parameters: name, value, ci95_low, ci95_high, unit: one row a parameter.
        experiments: final pressure, pressure rise, time constant and the like: one row an experiment.
        rmse_pa: root mean square error against what the sensor recorded, Pa: ``fit`` and ``held_out``.
        raw: everything, as ``pneutherm identify --json`` writes it.
    """

    method: str
    parameters: pyarrow.Table
    experiments: pyarrow.Table
    rmse_pa: dict[str, Optional[float]]
    raw: dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Diagnosis:
    """What `diagnose` found.

    Attributes:
        verdict: ``"adequate"``, ``"explained"``, ``"improved"`` or ``"unexplained"``.
        effects: the effects that explain the residual; empty unless explained.
        balance: ``"none"``, ``"mass"``, ``"energy"``, ``"volume"`` or ``"sensor"``: where the evidence points.
        indistinguishable: sets of effects that the data cannot tell apart.
        noise_pa: the sensor's noise, Pa.
        before: parameters of the paper's model, as `Identification.parameters`.
        after: parameters of the diagnosed model; equals `before` when `effects` is empty.
        rmse_before_pa: error of the paper's model, Pa: ``fit`` and ``held_out``.
        rmse_after_pa: error of the diagnosed model.
        candidates: effect, delta_bic (positive speaks for it), held_out_rmse_pa: one row a candidate.
        raw: everything, as ``pneutherm diagnose --json`` writes it.
    """

    verdict: str
    effects: list[str]
    balance: str
    indistinguishable: list[list[str]]
    noise_pa: Optional[float]
    before: pyarrow.Table
    after: pyarrow.Table
    rmse_before_pa: dict[str, Optional[float]]
    rmse_after_pa: dict[str, Optional[float]]
    candidates: pyarrow.Table
    raw: dict[str, Any]


def identify(
    rig: Path, *, method: Literal["exact", "time-constant"] = "exact", model: Optional[Path] = None
) -> Identification:
    """Heat transfer coefficient, dead volume and mass, with 95 % intervals, from measured traces.

    Args:
        rig: the rig file, or the folder with a ``rig.toml``.
        method: the exact regression, or the paper's thermal time constant method.
        model: where to write the model file, if anywhere.
    """
    raw = json.loads(_native.identify(rig, method, model))
    return Identification(
        method=raw["method"],
        parameters=_parameters(raw["parameters"]),
        experiments=_rows([_flat(experiment) for experiment in raw["experiments"]]),
        rmse_pa=raw["rmse_pa"],
        raw=raw,
    )


def diagnose(rig: Path, *, model: Optional[Path] = None, report: Optional[Path] = None) -> Diagnosis:
    """Which effect the paper's model misses, and the error before and after on held-out traces.

    Args:
        rig: the rig file, or the folder with a ``rig.toml``.
        model: where to write the diagnosed model file, if anywhere.
        report: where to write the report (HTML), if anywhere.
    """
    raw = json.loads(_native.diagnose(rig, model, report))
    candidates = [
        {key: candidate[key] for key in ("effect", "delta_bic", "held_out_rmse_pa")} for candidate in raw["candidates"]
    ]
    return Diagnosis(
        verdict=raw["verdict"],
        effects=raw["effects"],
        balance=raw["balance"],
        indistinguishable=raw["indistinguishable"],
        noise_pa=raw["noise_pa"],
        before=_parameters(raw["before"]["parameters"]),
        after=_parameters(raw["after"]["parameters"]),
        rmse_before_pa=raw["before"]["rmse_pa"],
        rmse_after_pa=raw["after"]["rmse_pa"],
        candidates=_rows(candidates),
        raw=raw,
    )


def simulate(
    model: Path, motion: Path, *, rig: Optional[Path] = None, initial_pressure_pa: Optional[float] = None
) -> pyarrow.Table:
    """The chamber along a measured or planned stroke: one row for each row of the motion.

    Args:
        model: the model file.
        motion: the trace file with the motion.
        rig: a rig file whose columns and format are the motion's.
        initial_pressure_pa: gas pressure at the start, Pa; otherwise from the motion's pressure before the first
            movement.
    """
    import pyarrow

    return pyarrow.table(_native.simulate(model, motion, rig, initial_pressure_pa))


def sweep(study: Path) -> pyarrow.Table:
    """All rows of a study as one table. For studies larger than memory use ``pneutherm sweep`` and read its Parquet.

    Args:
        study: the study file.
    """
    import pyarrow

    return pyarrow.table(_native.sweep(study))


def _parameters(parameters: dict[str, Any]) -> pyarrow.Table:
    import pyarrow

    rows = [
        {
            "name": name,
            "value": entry["value"],
            "ci95_low": (entry.get("ci95") or [None, None])[0],
            "ci95_high": (entry.get("ci95") or [None, None])[1],
            "unit": entry.get("unit"),
        }
        for name, entry in parameters.items()
    ]
    numbers = [(name, pyarrow.float64()) for name in ("value", "ci95_low", "ci95_high")]
    return _rows(rows, pyarrow.schema([("name", pyarrow.string()), *numbers, ("unit", pyarrow.string())]))


def _rows(rows: list[dict[str, Any]], schema: Optional[pyarrow.Schema] = None) -> pyarrow.Table:
    import pyarrow

    return pyarrow.Table.from_pylist(rows, schema=schema)


def _flat(entry: dict[str, Any]) -> dict[str, Any]:
    """Nested tables and lists as JSON text, so that each row is one row."""
    return {key: json.dumps(value) if isinstance(value, (dict, list)) else value for key, value in entry.items()}
