"""The extension module, written in Rust (`python/src`)."""

from collections.abc import Callable
from os import PathLike
from typing import Any, Optional, Union

_Path = Union[str, PathLike[str]]
_Given = tuple[Optional[_Path], Optional[str]]  # a file, its content as JSON, or both

class Error(Exception):
    """What is wrong, in the program's sentence."""

class Table:
    """A result with rows and columns in the Arrow PyCapsule interface: `pyarrow.table(it)`."""

    def __arrow_c_stream__(self, requested_schema: Optional[object] = None) -> Any: ...
    def __len__(self) -> int: ...

def run(arguments: list[str]) -> int: ...
def identify(rig: _Given, method: str, model: Optional[_Path]) -> str: ...
def diagnose(rig: _Given, model: Optional[_Path], report: Optional[_Path]) -> str: ...
def validate(model: _Given, rig: _Given, whole_record: bool) -> str: ...
def simulate(
    model: _Given,
    motion: _Path,
    rig: _Given,
    initial_pressure_pa: Optional[float],
    raw_positions: bool,
    samples: Optional[int],
    level: float,
    seed: int,
) -> Table: ...

class Batches:
    """The rows of a study in the Arrow PyCapsule interface, computed as they are read."""

    def __arrow_c_stream__(self, requested_schema: Optional[object] = None) -> Any: ...

class Study:
    """A study: its file, or its content as JSON."""

    def __init__(self, study: _Given) -> None: ...
    def __len__(self) -> int: ...
    def table(self) -> Table: ...
    def batches(self) -> Batches: ...
    def statistics(
        self,
        columns: Optional[list[str]],
        quantiles: Optional[list[float]],
        progress: Optional[Callable[[int], object]],
    ) -> str: ...
    def write_folder(
        self,
        folder: _Path,
        shard: str,
        rows: bool,
        extend: Optional[_Path],
        progress: Optional[Callable[[int], object]],
    ) -> str: ...
