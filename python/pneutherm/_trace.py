"""Traces from what Python reads: tables in memory, MATLAB, Parquet and Excel files."""

from __future__ import annotations

import contextlib
import csv
import os
import pathlib
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Optional, Union

from ._native import Error

Path = Union[str, "os.PathLike[str]"]


def write_trace(
    source: Any, path: Path, *, columns: Optional[Union[Sequence[str], Mapping[str, str]]] = None, sheet: Union[int, str] = 0
) -> pathlib.Path:
    """Writes a trace file (CSV) that the program reads, and returns its path.

    The columns keep their names and numbers; the rig file's ``[columns]`` says which is what, in which unit, and
    ``pneutherm look`` writes a rig file for it.

    Args:
        source: a pandas or polars DataFrame, a pyarrow Table, a mapping of names to values; or the path of a file:
            ``.parquet``, ``.feather``, ``.xlsx`` (needs pandas and openpyxl), ``.mat`` (needs scipy; of version 7.3, h5py).
        path: the file to write.
        columns: which columns, or a mapping of new names to those of the source, such as ``{"time_s": "record.t"}``; all
            numbers and times unless given. Of a MATLAB file, variables; ``record.t`` is a structure's field, ``data(:,1)`` a
            matrix's column.
        sheet: name or number of an Excel file's sheet.
    """
    table = _table(source, sheet)
    if columns is not None:
        names = dict(columns) if isinstance(columns, Mapping) else {name: name for name in columns}
        absent = [name for name in names.values() if name not in table]
        if absent:
            raise Error(f"{_said(source)}: has no column `{absent[0]}`; it has {_listed(table)}")
        table = {new: table[old] for new, old in names.items()}
    lengths = {name: len(values) for name, values in table.items()}
    if not table:
        raise Error(f"{_said(source)}: has no column of numbers or times")
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} ({length})" for name, length in lengths.items())
        raise Error(f"{_said(source)}: its columns differ in length: {told}; say by `columns` which ones make the trace")
    path = pathlib.Path(path)
    # Under another name until it is whole: a failure leaves what stood there before.
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with open(partial, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(table)
            writer.writerows(zip(*(map(_text, values) for values in table.values())))
        os.replace(partial, path)
    except OSError as error:
        raise Error(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        partial.unlink(missing_ok=True)
    return path


@contextlib.contextmanager
def as_trace(source: Any) -> Iterator[Path]:
    """The path of a trace file: the source itself, or a temporary file where the program cannot read the source."""
    if is_text_file(source):
        yield source
        return
    with tempfile.TemporaryDirectory() as folder:
        name = pathlib.Path(os.fspath(source)).stem if isinstance(source, (str, os.PathLike)) else "table"
        yield write_trace(source, pathlib.Path(folder) / f"{name}.csv")


def is_text_file(source: Any) -> bool:
    """Whether it is the path of a file that the program reads as it is."""
    return isinstance(source, (str, os.PathLike)) and _suffix(source) not in _READERS


def _suffix(path: Any) -> str:
    return pathlib.Path(os.fspath(path)).suffix.lower()


def _said(source: Any) -> str:
    return os.fspath(source) if isinstance(source, (str, os.PathLike)) else "the table"


def _listed(table: Mapping[str, Any]) -> str:
    return ", ".join(f"`{name}`" for name in table)


def _text(value: Any) -> str:
    """A cell: the shortest text that reads back the same, empty where there is nothing."""
    if value is None or value != value:
        return ""
    if hasattr(value, "isoformat"):
        return str(value.isoformat())
    return repr(value)


def _table(source: Any, sheet: Union[int, str]) -> dict[str, list[Any]]:
    """Columns of numbers and times, by name."""
    if isinstance(source, (str, os.PathLike)):
        suffix = _suffix(source)
        if suffix not in _READERS:
            kinds = ", ".join(sorted(_READERS))
            raise Error(f"{os.fspath(source)}: is none of {kinds}; text files are read as they are")
        try:
            return _READERS[suffix](source, sheet)
        except ImportError as missing:
            raise Error(f"{os.fspath(source)}: {suffix} files need the package {missing.name}: pip install {missing.name}") from missing
        except (OSError, ValueError, KeyError) as wrong:
            raise Error(f"{os.fspath(source)}: cannot be read: {wrong}") from wrong
    return _of_arrow(source)


def _of_arrow(source: Any) -> dict[str, list[Any]]:
    """Of anything that pyarrow takes: its own tables, pandas, polars, a mapping of names to values."""
    import pyarrow
    import pyarrow.types as types

    try:
        table = source if isinstance(source, pyarrow.Table) else pyarrow.table(source)
    except (TypeError, ValueError, pyarrow.ArrowInvalid) as wrong:
        raise Error(f"the table: {type(source).__name__} is no table: {wrong}") from wrong
    columns: dict[str, list[Any]] = {}
    for field, column in zip(table.schema, table.columns):
        kind = field.type
        if types.is_integer(kind) or types.is_floating(kind):
            columns[field.name] = column.cast(pyarrow.float64()).to_pylist()
        elif types.is_timestamp(kind):
            columns[field.name] = column.cast(pyarrow.timestamp("us", kind.tz)).to_pylist()
        elif types.is_duration(kind):
            nanoseconds = column.cast(pyarrow.duration("ns")).cast(pyarrow.int64()).to_pylist()
            columns[field.name] = [None if value is None else value * 1e-9 for value in nanoseconds]
    return columns


def _parquet(path: Path, _sheet: Any) -> dict[str, list[Any]]:
    import pyarrow.parquet

    return _of_arrow(pyarrow.parquet.read_table(path))


def _feather(path: Path, _sheet: Any) -> dict[str, list[Any]]:
    import pyarrow.feather

    return _of_arrow(pyarrow.feather.read_table(path))


def _excel(path: Path, sheet: Any) -> dict[str, list[Any]]:
    import pandas

    # A line of units below the names makes a column of texts: what is no number there is left out.
    frame = pandas.read_excel(path, sheet_name=sheet)
    for name in frame.columns:
        if frame[name].dtype == object or str(frame[name].dtype).startswith("str"):
            numbers = pandas.to_numeric(frame[name], errors="coerce")
            if numbers.notna().sum() > 0.5 * len(numbers):
                frame[name] = numbers
    frame.columns = [str(name) for name in frame.columns]
    return _of_arrow(frame.dropna(how="all", subset=frame.select_dtypes("number").columns).reset_index(drop=True))


def _matlab(path: Path, _sheet: Any) -> dict[str, list[Any]]:
    import scipy.io

    with open(path, "rb") as file:
        # Version 7.3 is HDF5, with or without MATLAB's own header before it.
        hdf5 = any(b"\x89HDF\r\n" in file.read(512) for _ in range(2))
    if hdf5:
        return _matlab_hdf5(path)
    try:
        content = scipy.io.loadmat(path, simplify_cells=True)
    except scipy.io.matlab.MatReadError as wrong:
        raise ValueError(wrong) from wrong
    columns: dict[str, list[Any]] = {}
    for name, value in content.items():
        if not name.startswith("__"):
            _collect(name, value, columns)
    return columns


def _matlab_hdf5(path: Path) -> dict[str, list[Any]]:
    """Of version 7.3: HDF5, its matrices with rows and columns exchanged."""
    import h5py

    columns: dict[str, list[Any]] = {}
    with h5py.File(path, "r") as file:

        def collect(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and not name.startswith("#"):
                _collect(name.replace("/", "."), item[()].T.squeeze(), columns)

        file.visititems(collect)
    return columns


def _collect(name: str, value: Any, columns: dict[str, list[Any]]) -> None:
    """Vectors, matrices column by column, and the fields of structures."""
    import numpy

    if isinstance(value, Mapping):
        for key, field in value.items():
            _collect(f"{name}.{key}", field, columns)
        return
    array = numpy.asarray(value)
    if array.dtype.kind not in "fiu" or array.size < 2:
        return
    if array.ndim == 1:
        columns[name] = array.astype(float).tolist()
    elif array.ndim == 2:
        for i in range(array.shape[1]):
            columns[f"{name}(:,{i + 1})"] = array[:, i].astype(float).tolist()


_READERS = {".parquet": _parquet, ".feather": _feather, ".arrow": _feather, ".xlsx": _excel, ".xls": _excel, ".mat": _matlab}
