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
import pathlib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Optional, Union, overload

from . import _native
from ._native import Error
from ._trace import as_trace, write_trace

if TYPE_CHECKING:
    import pyarrow
    import pyarrow.dataset

__all__ = [
    "Diagnosis",
    "Error",
    "Identification",
    "StudyFolder",
    "Validation",
    "batches",
    "diagnose",
    "identify",
    "simulate",
    "statistics",
    "sweep",
    "validate",
    "write_trace",
]

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


@dataclasses.dataclass(frozen=True)
class Validation:
    """What `validate` found.

    Attributes:
        rmse_pa: error over all rows judged, Pa rms.
        noise_pa: the recording's noise, Pa.
        systematic_pa: what is systematic in the error, Pa, where whole records are judged.
        records: trace, rmse_pa, judged_from_s, rows and the record's own numbers (JSON): one row a record.
        raw: everything, as ``pneutherm validate --json`` writes it.
    """

    rmse_pa: float
    noise_pa: float
    systematic_pa: Optional[float]
    records: pyarrow.Table
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


def validate(model: Path, rig: Path, *, whole_record: bool = False) -> Validation:
    """How well a model predicts records that took no part in finding it.

    Args:
        model: the model file.
        rig: the rig file of the records, or the folder with a ``rig.toml``.
        whole_record: fit the records' own numbers (initial pressure, delay, offsets) to all of each record, not only to its
            rest and first move.
    """
    raw = json.loads(_native.validate(model, rig, whole_record))
    return Validation(
        rmse_pa=raw["rmse_pa"],
        noise_pa=raw["noise_pa"],
        systematic_pa=raw["systematic_pa"],
        records=_rows([_flat(record) for record in raw["records"]]),
        raw=raw,
    )


def simulate(
    model: Path,
    motion: Union[Path, Any],
    *,
    rig: Optional[Path] = None,
    initial_pressure_pa: Optional[float] = None,
    samples: Optional[int] = None,
    level: float = 0.95,
    seed: int = 0,
) -> pyarrow.Table:
    """The chamber along a measured or planned stroke: one row for each row of the motion.

    Args:
        model: the model file.
        motion: the trace file with the motion, or what `write_trace` takes: a table, a MATLAB, Parquet or Excel file.
        rig: a rig file whose columns and format are the motion's.
        initial_pressure_pa: gas pressure at the start, Pa; otherwise from the motion's pressure before the first
            movement.
        samples: also give a predictive band from so many draws of the identified parameters: ``pressure_low_pa``,
            ``pressure_high_pa`` and so on.
        level: probability of the band.
        seed: seed of the draws.
    """
    import pyarrow

    with as_trace(motion) as path:
        return pyarrow.table(_native.simulate(model, path, rig, initial_pressure_pa, samples, level, seed))


@dataclasses.dataclass(frozen=True)
class StudyFolder:
    """What `sweep` did in a folder, and what is in it.

    Attributes:
        path: the folder.
        rows_written: rows that this run computed; those that were there already stayed.
        rows_taken: rows that it took from the smaller study in `extend`.
        statuses: rows of this run's shard by status.
        complete: whether the rows of all shards are there.
    """

    path: pathlib.Path
    rows_written: int
    rows_taken: int
    statuses: dict[str, int]
    complete: bool

    @property
    def rows(self) -> pyarrow.dataset.Dataset:
        """The rows, to be filtered and read piece by piece: ``.to_table()``, or for DuckDB and polars as it is."""
        import pyarrow.dataset

        return pyarrow.dataset.dataset(self.path / "rows", format="parquet")

    @property
    def statistics(self) -> Optional[dict[str, Any]]:
        """``statistics.json``, where the study asks for statistics or keeps no rows."""
        return self._json("statistics.json")

    @property
    def sensitivity(self) -> Optional[dict[str, Any]]:
        """``sensitivity.json`` of a Saltelli study."""
        return self._json("sensitivity.json")

    def _json(self, name: str) -> Optional[dict[str, Any]]:
        path = self.path / name
        return json.loads(path.read_text()) if path.exists() else None


@overload
def sweep(study: Union[Path, Mapping[str, Any]], out: None = None) -> pyarrow.Table: ...
@overload
def sweep(
    study: Union[Path, Mapping[str, Any]],
    out: Path,
    *,
    shard: str = "0/1",
    rows: bool = True,
    extend: Optional[Path] = None,
    progress: Optional[Callable[[int, int], object]] = None,
) -> StudyFolder: ...
def sweep(
    study: Union[Path, Mapping[str, Any]],
    out: Optional[Path] = None,
    *,
    shard: str = "0/1",
    rows: bool = True,
    extend: Optional[Path] = None,
    progress: Optional[Callable[[int, int], object]] = None,
) -> Union[pyarrow.Table, StudyFolder]:
    """A parameter study: all its rows as one table, or into a folder as ``pneutherm sweep`` writes it.

    For studies larger than memory give a folder, or read `batches`.

    Args:
        study: the study file, or what it would say: ``{"study": {"model": ..., "design": ...}, "test": {...},
            "vary": {...}}``, with paths relative to the working folder. NumPy's numbers and arrays will do.
        out: the folder. A study that was interrupted goes on where it ended.
        shard: only the parts i with i mod N = I, as ``"I/N"``.
        rows: False keeps no rows, only `StudyFolder.statistics`.
        extend: the folder of a smaller study of the same sequence, whose rows are taken instead of solved again.
        progress: called now and then with the rows done and all rows.
    """
    import pyarrow

    native = _study(study)
    if out is None:
        return pyarrow.table(native.table())
    raw = json.loads(native.write_folder(out, shard, rows, extend, _telling(progress, len(native))))
    return StudyFolder(
        pathlib.Path(out), raw["rows_written"], raw["rows_taken"], raw["statuses"], raw["complete"]
    )


def batches(study: Union[Path, Mapping[str, Any]]) -> pyarrow.RecordBatchReader:
    """The rows of a study, batch after batch, computed as they are read: for DuckDB, polars or a loop.

    Args:
        study: as for `sweep`.
    """
    import pyarrow

    return pyarrow.RecordBatchReader.from_stream(_study(study).batches())


def statistics(
    study: Union[Path, Mapping[str, Any]],
    *,
    columns: Optional[Sequence[str]] = None,
    quantiles: Optional[Sequence[float]] = None,
    progress: Optional[Callable[[int, int], object]] = None,
) -> dict[str, Any]:
    """What the rows of a study come to, as ``statistics.json`` has it; no row is kept, so a study may have any size.

    Args:
        study: as for `sweep`; its ``[statistics]`` holds unless columns or quantiles are given.
        columns: which results; all unless given.
        quantiles: probabilities of the quantiles.
        progress: called now and then with the rows done and all rows.
    """
    native = _study(study)
    names = None if columns is None else list(columns)
    shares = None if quantiles is None else [float(share) for share in quantiles]
    return json.loads(native.statistics(names, shares, _telling(progress, len(native))))


def _study(study: Union[Path, Mapping[str, Any]]) -> _native.Study:
    if isinstance(study, Mapping):
        return _native.Study("study", json.dumps(study, default=_plain))
    return _native.Study(study)


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays and other mappings and paths as JSON knows them."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise Error(f"study: {type(value).__name__} is nothing that a study file can say")


def _telling(progress: Optional[Callable[[int, int], object]], rows: int) -> Optional[Callable[[int], object]]:
    return None if progress is None else lambda done: progress(done, rows)


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
