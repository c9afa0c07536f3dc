"""Rigs and models as files, as dictionaries with the content of one, or as files with some of their content replaced."""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Optional, TypedDict, Union

from ._native import Error
from ._trace import Path, is_text_file, write_trace

Table = Mapping[str, Any]
Given = tuple[Optional[Path], Optional[str]]
"""What the extension module takes: a file, its content as JSON, or both."""


class RigTables(TypedDict, total=False):
    """The tables of a rig file, as keyword arguments: what they hold is on the page "Files" of the guide."""

    cylinder: Optional[Table]
    ambient: Optional[Table]
    gas: Optional[Table]
    sensor: Optional[Table]
    accuracy: Optional[Table]
    tolerance: Optional[Table]
    experiment: Optional[Sequence[Table]]
    columns: Optional[Table]
    format: Optional[Table]


class ModelTables(TypedDict, total=False):
    """The tables of a model file that make a chamber, as keyword arguments."""

    chamber: Optional[Table]
    heat_transfer: Optional[Table]
    effect: Optional[Table]
    gas: Optional[Table]
    ambient: Optional[Table]


def given_model(model: Union[Path, Table, None], tables: ModelTables) -> Given:
    path, content = _split(model, tables, ModelTables)
    return path, as_json(content) if content else None


@contextlib.contextmanager
def given_rig(rig: Union[Path, Table, None], tables: RigTables) -> Iterator[Given]:
    """While the extension module reads it: traces that are no text files are written to a temporary folder."""
    path, content = _split(rig, tables, RigTables)
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(content.get("experiment"), Sequence) and not isinstance(content["experiment"], str):
            content["experiment"] = [
                _with_text_files(experiment, pathlib.Path(folder) / str(number), path is not None)
                for number, experiment in enumerate(content["experiment"], 1)
            ]
        yield path, as_json(content) if content else None


def _split(
    source: Union[Path, Table, None], tables: Mapping[str, Any], known: type
) -> tuple[Optional[Path], dict[str, Any]]:
    for name in tables:
        if name not in known.__annotations__:
            raise TypeError(f"got an unexpected keyword argument {name!r}; expected one of: {', '.join(known.__annotations__)}")
    content = {key: value for key, value in tables.items() if value is not None}
    if isinstance(source, Mapping):
        return None, {**source, **content}
    return source, content


def _with_text_files(experiment: Any, folder: pathlib.Path, beside_a_file: bool) -> Any:
    """Beside a rig file, paths relative to the working folder become absolute: the file's own count from its folder."""
    if not isinstance(experiment, Mapping) or "traces" not in experiment:
        return experiment
    traces = experiment["traces"]
    if isinstance(traces, (str, os.PathLike, Mapping)) or not isinstance(traces, Sequence):
        traces = [traces]
    files = []
    for number, trace in enumerate(traces, 1):
        if is_text_file(trace):
            files.append(os.path.abspath(trace) if beside_a_file else os.fspath(trace))
        else:
            folder.mkdir(exist_ok=True)
            files.append(str(write_trace(trace, folder / f"trace-{number}.csv")))
    return {**experiment, "traces": files}


def as_json(content: Table) -> str:
    """The content of a file as JSON."""
    try:
        return json.dumps(content, default=_plain, allow_nan=False)
    except ValueError as wrong:
        raise Error("a number that is not finite is not allowed in a study, rig or model") from wrong


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays and other mappings and paths as JSON knows them."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise Error(f"a value of type {type(value).__name__} is not allowed in a study, rig or model")
