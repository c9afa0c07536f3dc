"""Heat transfer in pneumatic cylinder chambers, from Python.

The functions take the same files as the commands of the program `pneutherm`, or their content as keyword arguments and
dictionaries, and return pyarrow tables. Units are SI; the name and the metadata of each column state them. Pressure is absolute. Wrong input raises `Error` with the sentence that the program
would print. The rows of `simulate` and `sweep` are passed without a copy.

    >>> import pneutherm
    >>> pneutherm.identify("examples/cylinder").parameters.to_pandas()  # doctest: +SKIP
    >>> pneutherm.identify(  # doctest: +SKIP
    ...     cylinder={"bore_m": 0.032}, experiment=[{"name": "push", "traces": ["push-1.csv", "push-2.csv"]}]
    ... )
"""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Optional, Union, overload

from . import _native
from ._content import ModelTables, Path, RigTables, Table, as_json, given_model, given_rig
from ._native import Error
from ._trace import as_trace, write_trace

if TYPE_CHECKING:
    import pyarrow
    import pyarrow.dataset
    from typing_extensions import Unpack

__all__ = [
    "Diagnosis",
    "Error",
    "Identification",
    "ModelTables",
    "RigTables",
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

@dataclasses.dataclass(frozen=True)
class Identification:
    """The result of `identify`.

    Attributes:
        method: ``"exact"`` or ``"time-constant"``.
        parameters: name, value, ci95_low, ci95_high, unit; one row per parameter.
        experiments: final pressure, pressure rise, time constant and so on; one row per experiment.
        rmse_pa: root mean square error against the recorded pressure, Pa: ``fit`` and, on left-out data, ``held_out``.
        raw: everything, as ``pneutherm identify --json`` writes it.
    """

    method: str
    parameters: pyarrow.Table
    experiments: pyarrow.Table
    rmse_pa: dict[str, Optional[float]]
    raw: dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Diagnosis:
    """The result of `diagnose`.

    Attributes:
        verdict: ``"adequate"``, ``"explained"``, ``"improved"`` or ``"unexplained"``.
        effects: the effects in the model; empty if the verdict is adequate or unexplained.
        balance: ``"none"``, ``"mass"``, ``"energy"``, ``"volume"`` or ``"sensor"``: the balance that the evidence points to.
        indistinguishable: sets of effects that the data cannot distinguish.
        noise_pa: the noise of the recording, Pa.
        before: parameters of the paper's model, as `Identification.parameters`.
        after: parameters of the diagnosed model; equals `before` when `effects` is empty.
        rmse_before_pa: error of the paper's model, Pa: ``fit`` and ``held_out``.
        rmse_after_pa: error of the diagnosed model.
        candidates: effect, delta_bic (positive values favour it), held_out_rmse_pa; one row per candidate.
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
    """The result of `validate`.

    Attributes:
        rmse_pa: error over all compared rows, Pa rms.
        noise_pa: the noise of the recording, Pa.
        systematic_pa: the systematic part of the error, Pa, if whole records are compared.
        records: trace, rmse_pa, judged_from_s, rows and the record's own parameters (JSON); one row per record.
        raw: everything, as ``pneutherm validate --json`` writes it.
    """

    rmse_pa: float
    noise_pa: float
    systematic_pa: Optional[float]
    records: pyarrow.Table
    raw: dict[str, Any]


def identify(
    rig: Union[Path, Table, None] = None,
    *,
    method: Literal["exact", "time-constant"] = "exact",
    model: Optional[Path] = None,
    **tables: Unpack[RigTables],
) -> Identification:
    """Identifies heat transfer coefficient, dead volume and mass, with 95 % intervals, from measured traces.

    The other keyword arguments are the tables of a rig file (`RigTables`): ``cylinder={"bore_m": 0.032}``. Beside a rig file
    they replace what it says, key by key; without one they are the rig. The traces of an experiment may be what
    `write_trace` takes.

    Args:
        rig: the rig file, the folder with a ``rig.toml``, or a dictionary with the content of one.
        method: a fit of all traces at once, or the paper's thermal time constant method on each trace.
        model: where to write the model file, if anywhere.
    """
    with given_rig(rig, tables) as given:
        raw = json.loads(_native.identify(given, method, model))
    return Identification(
        method=raw["method"],
        parameters=_parameters(raw["parameters"]),
        experiments=_rows([_flat(experiment) for experiment in raw["experiments"]]),
        rmse_pa=raw["rmse_pa"],
        raw=raw,
    )


def diagnose(
    rig: Union[Path, Table, None] = None,
    *,
    model: Optional[Path] = None,
    report: Optional[Path] = None,
    **tables: Unpack[RigTables],
) -> Diagnosis:
    """Finds which effects the paper's model lacks, with the error before and after on left-out records.

    The other keyword arguments are the tables of a rig file, as for `identify`.

    Args:
        rig: the rig file, the folder with a ``rig.toml``, or a dictionary with the content of one.
        model: where to write the diagnosed model file, if anywhere.
        report: where to write the report (HTML), if anywhere.
    """
    with given_rig(rig, tables) as given:
        raw = json.loads(_native.diagnose(given, model, report))
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


def validate(
    model: Union[Path, Table],
    rig: Union[Path, Table, None] = None,
    *,
    whole_record: bool = False,
    **tables: Unpack[RigTables],
) -> Validation:
    """Tests a model on records that took no part in its identification.

    The other keyword arguments are the tables of a rig file, as for `identify`.

    Args:
        model: the model file, or a dictionary with the content of one.
        rig: the rig file of the records, the folder with a ``rig.toml``, or a dictionary with the content of one.
        whole_record: fit the records' own parameters (initial pressure, delays, offset) to the whole of each record, not
            only to its rest and first move.
    """
    with given_rig(rig, tables) as given:
        raw = json.loads(_native.validate(given_model(model, {}), given, whole_record))
    return Validation(
        rmse_pa=raw["rmse_pa"],
        noise_pa=raw["noise_pa"],
        systematic_pa=raw["systematic_pa"],
        records=_rows([_flat(record) for record in raw["records"]]),
        raw=raw,
    )


def simulate(
    model: Union[Path, Table, None],
    motion: Union[Path, Any],
    *,
    rig: Union[Path, Table, None] = None,
    initial_pressure_pa: Optional[float] = None,
    raw_positions: bool = False,
    samples: Optional[int] = None,
    level: float = 0.95,
    seed: int = 0,
    columns: Optional[Table] = None,
    format: Optional[Table] = None,
    **tables: Unpack[ModelTables],
) -> pyarrow.Table:
    """Simulates the chamber along a measured or planned stroke; one row per row of the motion.

    The other keyword arguments are the tables of a model file (`ModelTables`), such as
    ``effect={"leakage": {"conductance_m3_per_s_pa": 1e-11}}``. Beside a model file they replace what it says, key by key; with
    ``None`` as the model they are the model.

    Args:
        model: the model file, or a dictionary with the content of one.
        motion: the trace file with the motion, or what `write_trace` takes: a table, a MATLAB, Parquet or Excel file.
        rig: a rig file, or a dictionary with the content of one, whose columns and format describe the motion file.
        initial_pressure_pa: initial gas pressure, Pa; by default from the motion's pressure before the first movement.
        raw_positions: take noisy positions as they are, linear between rows. Otherwise, where they scatter at rest, the piston is
            held there and moves along smooth curves through the rows.
        samples: also compute a prediction band from this many draws of the identified parameters: ``pressure_low_pa``,
            ``pressure_high_pa`` and so on.
        level: coverage probability of the band.
        seed: seed of the random draws.
        columns: the ``[columns]`` of a rig file, for the motion.
        format: the ``[format]`` of a rig file, for the motion.
    """
    import pyarrow

    layout: RigTables = {"columns": columns, "format": format}
    with as_trace(motion) as path, given_rig(rig, layout) as given:
        native = _native.simulate(
            given_model(model, tables), path, given, initial_pressure_pa, raw_positions, samples, level, seed
        )
    return pyarrow.table(native)


@dataclasses.dataclass(frozen=True)
class StudyFolder:
    """The folder of a study, and what `sweep` did in it.

    Attributes:
        path: the folder.
        rows_written: rows that this run computed; parts that existed already were kept.
        rows_taken: rows that it took from the smaller study in `extend`.
        statuses: rows of this run's shard by status.
        complete: whether the rows of all shards are complete.
    """

    path: pathlib.Path
    rows_written: int
    rows_taken: int
    statuses: dict[str, int]
    complete: bool

    @property
    def rows(self) -> pyarrow.dataset.Dataset:
        """The rows as a dataset, to filter and read in pieces: with ``.to_table()``, DuckDB or polars."""
        import pyarrow.dataset

        return pyarrow.dataset.dataset(self.path / "rows", format="parquet")

    @property
    def statistics(self) -> Optional[dict[str, Any]]:
        """``statistics.json``, if the study requests statistics or keeps no rows."""
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
    """Runs a parameter study: returns all rows as one table, or writes a folder like ``pneutherm sweep``.

    For studies larger than memory use a folder or `batches`.

    Args:
        study: the study file, or a dictionary with its content: ``{"study": {"model": ..., "design": ...}, "test": {...},
            "vary": {...}}``, with paths relative to the working folder. NumPy numbers and arrays are allowed.
        out: the folder. An interrupted study continues where it ended.
        shard: ``"I/N"`` computes only the parts i with i mod N = I.
        rows: False keeps no rows, only `StudyFolder.statistics`.
        extend: the folder of a smaller study of the same sequence, whose rows are taken instead of solved again.
        progress: called regularly with the number of rows done and of all rows.
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
    """Computes the rows of a study, batch by batch, while they are read by DuckDB, polars or a loop.

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
    """Computes statistics of a study like ``statistics.json``. It keeps no rows, so the study may have any size.

    Args:
        study: as for `sweep`; columns and quantiles override its ``[statistics]``.
        columns: the results to use; all by default.
        quantiles: probabilities of the quantiles.
        progress: called regularly with the number of rows done and of all rows.
    """
    native = _study(study)
    names = None if columns is None else list(columns)
    shares = None if quantiles is None else [float(share) for share in quantiles]
    return json.loads(native.statistics(names, shares, _telling(progress, len(native))))


def _study(study: Union[Path, Mapping[str, Any]]) -> _native.Study:
    if isinstance(study, Mapping):
        return _native.Study((None, as_json(study)))
    return _native.Study((study, None))


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
