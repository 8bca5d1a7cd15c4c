# SPDX-License-Identifier: BSD-3-Clause
"""Results as a program reads them: figures, and tables as arrays or as a data frame."""

import csv
import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Optional

import numpy as np
from numpy.typing import NDArray

from pusht_task.files import read_text
from sim2sim import _sim2sim
from sim2sim.checks import checked_path
from sim2sim.errors import BadDependency, InvalidInput
from sim2sim_protocol.result_files import name_of, row_folder

Columns = Dict[str, NDArray[Any]]

INTEGERS = {"episode": np.int64, "seed": np.uint64, "steps": np.int64, "repeat": np.int64}
TEXTS = ("mode", "parting_cause", "parting_first", "ending", "pusher_ending")


def frame_of(columns: Mapping[str, Any]) -> Any:
    try:
        import pandas  # type: ignore[import]
    except ImportError:
        raise BadDependency(
            "pandas: not found; a data frame needs it; the same columns are there as arrays"
        ) from None
    return pandas.DataFrame(columns)


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison: what its files say."""

    episodes: Columns = field(repr=False)  # columns of episodes.csv; units stand in their names
    summary: Dict[str, Any] = field(repr=False)  # metrics.json
    provenance: Dict[str, Any] = field(repr=False)  # provenance.json
    text: str  # the table that the command prints
    folder: Optional[Path]  # the files of the run; None: there are none
    files: Dict[str, str] = field(repr=False, compare=False)  # what other commands read of a run
    # Seconds of a run in this process: "all", and the parts "observations" (images) and "policy".
    seconds: Dict[str, float] = field(repr=False, compare=False, default_factory=dict)

    def __str__(self) -> str:
        return self.text

    def frame(self) -> Any:
        """The episodes as a pandas.DataFrame: a row for each rollout, the columns of `episodes`."""
        return frame_of(self.episodes)


@dataclass(frozen=True)
class Findings:
    """What a command has found."""

    figures: Dict[str, Any] = field(repr=False)  # as in its JSON file
    columns: Columns = field(repr=False)  # the table of the figures, as arrays
    text: str  # what the command prints
    folder: Optional[Path] = None  # the files; None: there are none

    def __str__(self) -> str:
        return self.text

    def frame(self) -> Any:
        """The columns as a pandas.DataFrame."""
        return frame_of(self.columns)


@dataclass(frozen=True)
class Sweep(Findings):
    """Results of a sweep. `columns` are those of sweep.csv."""

    def rows(self) -> List[Comparison]:
        """The results of each row, read from its folder."""
        assert self.folder
        folders = [row_folder(self.folder, row) for row in range(len(self.figures["rows"]))]
        return [loaded_run(folder, self.folder) for folder in folders]


def load(folder: Any) -> Any:
    """The results in a folder: a Comparison of a run, a Sweep of a sweep.

    Raises InvalidInput if it holds neither, or files of another format.
    """
    folder = Path(checked_path("results", folder))
    if (folder / name_of("sweep")).is_file():
        return loaded_sweep(folder, "")
    return loaded_run(folder, folder)


def loaded_run(folder: Path, origin: Path) -> Comparison:
    """A run, or a row of a sweep; `origin` has its provenance."""
    return comparison_of(_sim2sim.load(str(folder), str(origin / name_of("provenance"))))


def loaded_sweep(folder: Path, text: str) -> Sweep:
    try:
        description = json.loads(read_text(folder / name_of("sweep")))["sweep"]
        columns = table_of(read_text(folder / name_of("sweep_table")))
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise InvalidInput(f"results {folder}: must be those of a sweep: {error}") from None
    return Sweep(description, columns, text, folder)


def comparison_of(texts: Mapping[str, str]) -> Comparison:
    """A comparison from the texts of its files."""
    return Comparison(
        columns_of(texts["episodes"]),
        json.loads(texts["metrics"]),
        json.loads(texts["provenance"]),
        texts["text"],
        Path(texts["folder"]) if texts["folder"] else None,
        {name_of("metrics"): texts["metrics"], name_of("episodes"): texts["episodes"]},
    )


def columns_of(text: str) -> Columns:
    """The columns of episodes.csv, a row for each rollout.

    A number that a rollout has not is NaN. Given starts have no seeds, hence no such column.
    """
    columns = _cells_of(text)
    if not all(columns["seed"]):
        del columns["seed"]
    return {name: _column(name, cells) for name, cells in columns.items()}


def table_of(text: str) -> Columns:
    """The columns of another table: integers, numbers (NaN: there is none), truths or texts."""
    return {name: _guessed(cells) for name, cells in _cells_of(text).items()}


def columns_from(rows: Iterable[Mapping[str, Any]]) -> Columns:
    """The columns of rows that have the same keys; None is NaN."""
    rows = list(rows)
    names = list(rows[0]) if rows else []
    return {name: _array([row[name] for row in rows]) for name in names}


def _cells_of(text: str) -> Dict[str, List[str]]:
    names, *rows = csv.reader(text.splitlines())
    return {name: [row[i] for row in rows] for i, name in enumerate(names)}


def _column(name: str, cells: List[str]) -> NDArray[Any]:
    if name in TEXTS:
        return np.array(cells)
    if name == "success":
        return np.array([cell == "true" for cell in cells])
    if name in INTEGERS:
        return np.array([int(cell) for cell in cells], INTEGERS[name])
    return _numbers(cells)


def _guessed(cells: List[str]) -> NDArray[Any]:
    if cells and set(cells) <= {"true", "false"}:
        return np.array([cell == "true" for cell in cells])
    if all(re.fullmatch(r"-?\d{1,18}", cell) for cell in cells):
        return np.array([int(cell) for cell in cells], np.int64)
    try:
        return _numbers(cells)
    except ValueError:
        return np.array(cells)


def _numbers(cells: List[str]) -> NDArray[np.float64]:
    return np.array([float(cell or "nan") for cell in cells])


def _array(values: List[Any]) -> NDArray[Any]:
    missing = any(value is None for value in values)
    return np.array([np.nan if value is None else value for value in values] if missing else values)
