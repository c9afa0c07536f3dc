"""Heat transfer in pneumatic cylinder chambers, from Python.

The functions take the files that the commands of the program `pneutherm` take, and return pyarrow tables. Units are SI and
stand in each column's name and metadata; pressure is absolute. What is wrong with an input is raised as `Error`, with
the sentence that the program would print.

    >>> import pneutherm
    >>> pneutherm.identify("examples/cylinder").parameters.to_pandas()  # doctest: +SKIP
"""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import shutil
import subprocess
import sysconfig
import tempfile
from typing import Any, Literal, Optional, Union

import pyarrow
import pyarrow.csv
import pyarrow.parquet

__all__ = ["Diagnosis", "Error", "Identification", "diagnose", "identify", "program", "simulate", "sweep"]

Path = Union[str, "os.PathLike[str]"]

_PARAMETERS = pyarrow.schema(
    [
        pyarrow.field("name", pyarrow.string()),
        pyarrow.field("value", pyarrow.float64()),
        pyarrow.field("ci95_low", pyarrow.float64()),
        pyarrow.field("ci95_high", pyarrow.float64()),
        pyarrow.field("unit", pyarrow.string()),
    ]
)


_UNITS = {"_s": "s", "_pa": "Pa", "_k": "K", "_kg": "kg", "_m3": "m3", "_w": "W"}


class Error(Exception):
    """What is wrong, in the sentence that the program prints."""


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
        verdict: ``"adequate"``, ``"explained"`` or ``"unexplained"``.
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
    raw = _json("identify", os.fspath(rig), "--method", method, *_option("-o", model))
    return Identification(
        method=raw["method"],
        parameters=_parameters(raw["parameters"]),
        experiments=pyarrow.Table.from_pylist([_flat(experiment) for experiment in raw["experiments"]]),
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
    raw = _json("diagnose", os.fspath(rig), *_option("-o", model), *_option("--report", report))
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
        candidates=pyarrow.Table.from_pylist(candidates),
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
    start = [] if initial_pressure_pa is None else ["--initial-pressure", repr(float(initial_pressure_pa))]
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "simulated.csv")
        _call("simulate", os.fspath(model), "--motion", os.fspath(motion), *_option("--rig", rig), *start, "-o", file)
        table = pyarrow.csv.read_csv(file)
    return table.cast(pyarrow.schema([pyarrow.field(name, "double", False, _unit(name)) for name in table.column_names]))


def sweep(study: Path) -> pyarrow.Table:
    """All rows of a study as one table. For studies larger than memory use ``pneutherm sweep`` and read its Parquet.

    Args:
        study: the study file.
    """
    with tempfile.TemporaryDirectory() as folder:
        _call("sweep", os.fspath(study), "-o", os.path.join(folder, "study"))
        parts = sorted(pathlib.Path(folder, "study").glob("*.parquet"))
        return pyarrow.concat_tables([pyarrow.parquet.read_table(part) for part in parts], promote_options="default")


def program() -> str:
    """The program that does the work: ``PNEUTHERM`` of the environment, that of this installation, or that on the path.

    Raises:
        Error: where there is none.
    """
    installed = shutil.which("pneutherm", path=sysconfig.get_path("scripts"))
    found = os.environ.get("PNEUTHERM") or installed or shutil.which("pneutherm")
    if not found:
        raise Error("the program `pneutherm` is not installed: pip install . in its folder, or set PNEUTHERM to its path")
    return found


def _call(*arguments: str) -> None:
    """Runs the program; raises what it says is wrong."""
    command = [program(), *arguments]
    try:
        done = subprocess.run(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8", errors="replace"
        )
    except OSError as error:
        raise Error(f"{command[0]}: cannot be run: {error.strerror}") from error
    if done.returncode != 0:
        raise Error(done.stderr.strip().removeprefix("error: ") or f"pneutherm ended with code {done.returncode}")


def _json(command: str, *arguments: str) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "result.json")
        _call(command, *arguments, "--json", file)
        with open(file, encoding="utf-8") as text:
            return json.load(text)


def _option(name: str, value: Optional[Path]) -> list[str]:
    return [] if value is None else [name, os.fspath(value)]


def _unit(column: str) -> dict[str, str]:
    return {"unit": next(unit for ending, unit in _UNITS.items() if column.endswith(ending))}


def _parameters(parameters: dict[str, Any]) -> pyarrow.Table:
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
    return pyarrow.Table.from_pylist(rows, schema=_PARAMETERS)


def _flat(entry: dict[str, Any]) -> dict[str, Any]:
    """Nested tables and lists as JSON text, so that each row is one row."""
    return {key: json.dumps(value) if isinstance(value, (dict, list)) else value for key, value in entry.items()}
