# SPDX-License-Identifier: BSD-3-Clause
"""The results of runs, as the commands have written them, checked."""

import csv
import io
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from pusht_task.error import Error
from pusht_task.files import read_file, read_text
from pusht_task.json_file import Json, read_json, require_format
from sim2sim_protocol.result_files import format_of, name_of

if TYPE_CHECKING:
    from sim2sim_report.suite import Suite

REFERENCE, ENGINE, REPLAY = MODES = ("reference_closed", "engine_closed", "engine_replay")
METRICS_FORMAT = format_of("metrics")
NO_ENGINE = "none"  # name of the engine of a run that has none
QUESTION = "Does the skill transfer?"
KINDS = {  # kind of an episode by success (in the reference, in the engine)
    (True, False): "only_reference_succeeds",
    (True, True): "both_succeed",
    (False, False): "neither_succeeds",
    (False, True): "only_engine_succeeds",
}
LARGEST_HEAD, LARGEST_RECORD = 4096, 256  # [bytes] of a file of traces
TRACE_FIELDS = (
    *("episode", "mode", "step", "pusher_x", "pusher_y", "tee_x", "tee_y", "tee_yaw"),
    *("action_x", "action_y"),
)

Traces = Dict[Tuple[int, str], Any]  # array of records by episode and mode


@dataclass(frozen=True)
class Episode:
    """A row of the table: the rows of an episode's modes in episodes.csv, by mode."""

    index: int
    modes: Dict[str, Dict[str, str]]

    def succeeds(self, mode: str) -> bool:
        return self.modes[mode]["success"] == "true"

    def steps(self, mode: str) -> int:
        return int(self.modes[mode]["steps"])

    def first_divergence(self, mode: str) -> Optional[int]:
        """The control step at which this mode first leaves the bound around the reference."""
        text = self.modes[mode]["parting_step"]
        return int(text) if text else None

    def ending(self, mode: str) -> str:
        """How a closed loop ends: "success", "stuck", "moving" or "lost"; "" of others."""
        return self.modes[mode]["ending"]

    def still(self, mode: str) -> int:
        """The control step from which on the tee of a closed loop stays where it ends."""
        return int(self.modes[mode]["still_step"])

    @property
    def kind(self) -> str:
        return KINDS[self.succeeds(REFERENCE), self.succeeds(ENGINE)]


@dataclass(frozen=True)
class Run:
    """The content of a run's folder."""

    folder: Path
    metrics: Json
    statistics: Json
    provenance: Json
    episodes: List[Episode]
    bands: Dict[str, Dict[str, Any]]  # columns of divergence.csv by mode

    @property
    def question(self) -> str:
        """The question of the headline."""
        return str(self.statistics["headline"]["question"])

    @property
    def caveat(self) -> str:
        """What to know before the answer; empty: nothing."""
        return str(self.statistics["headline"]["caveat"])

    @property
    def answer(self) -> str:
        """The answer of the headline."""
        return str(self.statistics["headline"]["answer"])

    def title(self, role: str) -> str:
        """The title of a simulator."""
        title: str = self.metrics["simulators"][role]["title"]
        return title

    @property
    def changed(self) -> str:
        """The parameters of the engine that are not the defaults: "block_damp 20"."""
        engine = self.metrics["simulators"]["engine"]
        return ", ".join(f"{name} {engine['parameters'][name]}" for name in engine["changed"])

    @property
    def name(self) -> str:
        """The engine, and what is changed of it."""
        return " with ".join(filter(None, [self.title("engine"), self.changed]))

    def first_of_each_kind(self) -> List[int]:
        first: Dict[str, int] = {}
        for episode in self.episodes:
            first.setdefault(episode.kind, episode.index)
        return [first[kind] for kind in KINDS.values() if kind in first]


@dataclass(frozen=True)
class Partial:
    """The finished episodes of a run that has not ended well."""

    folder: Path
    status: Json
    provenance: Json
    episodes: List[Episode]

    def title(self, role: str) -> str:
        title: str = self.provenance["configuration"]["simulators"][role]["title"]
        return title

    @property
    def counts(self) -> Dict[str, int]:
        """Number of finished episodes of each kind."""
        return {kind: sum(e.kind == kind for e in self.episodes) for kind in KINDS.values()}


def is_partial(folder: Path) -> bool:
    return (folder / name_of("status")).exists() and not (folder / name_of("metrics")).exists()


def read_partial(folder: Path) -> Partial:
    """Refuses a folder in which no episode has finished."""
    status = read_json(folder / name_of("status"))
    require_format(folder / name_of("status"), status, format_of("status"))
    if status.get("beside_earlier_results"):
        raise Error(f"{folder}: holds files of an earlier run; the folder of one run is needed")
    finished = status.get("episodes_finished", 0)
    if not finished or not (folder / name_of("episodes")).exists():
        if (folder / name_of("journal")).exists():  # killed: its command has not written them out
            raise Error(f"{folder}: was killed; run the same command again, it goes on")
        raise Error(f"{folder}: no episode has finished ({status.get('reason')}); one must have")
    provenance = read_json(folder / name_of("provenance"))
    return Partial(folder, status, provenance, _episodes(folder / name_of("episodes"), finished))


def is_sweep(folder: Path) -> bool:
    return (folder / name_of("sweep")).exists()


def read_run(folder: Path) -> Run:
    """Refuses what is no whole run of this version."""
    if is_sweep(folder):
        raise Error(f"{folder}: is a sweep; it must stand alone")
    metrics = read_json(folder / name_of("metrics"), "the folder of a whole run is needed")
    require_format(folder / name_of("metrics"), metrics, METRICS_FORMAT)
    if metrics.get("engine_simulator") == NO_ENGINE:
        raise Error(f"{folder}: has no engine; a page compares two simulators")
    statistics = read_json(folder / name_of("statistics"))
    require_format(folder / name_of("statistics"), statistics, format_of("statistics"))
    provenance = read_json(folder / name_of("provenance"))
    try:
        _require_one_run(folder, metrics, statistics, provenance)
        run = Run(
            folder=folder,
            metrics=metrics,
            statistics=statistics,
            provenance=provenance,
            episodes=_episodes(folder / name_of("episodes"), metrics["episodes"]),
            bands=_bands(folder / name_of("bands")),
        )
        counts = {kind: metrics[kind] for kind in KINDS.values()}
    except (KeyError, TypeError) as error:
        raise Error(f"{folder}: is not as a run of this version has it: {error!r}") from None
    if counts != {kind: sum(e.kind == kind for e in run.episodes) for kind in counts}:
        raise Error(f"{folder}: metrics.json and episodes.csv must be of one run")
    for mode in (ENGINE, REPLAY):
        if list(run.bands[mode]["episodes"]) != _still_running(run.episodes, mode):
            raise Error(f"{folder}: divergence.csv and episodes.csv must be of one run")
    return run


def read_sweep(folder: Path) -> Json:
    """The content of sweep.json. Raises Error if it has no rows or is of another version."""
    path = folder / name_of("sweep")
    content = read_json(path, "the folder of a sweep is needed")
    sweep, rows = content.get("sweep"), content.get("rows")
    require_format(path, sweep if isinstance(sweep, dict) else {}, METRICS_FORMAT)
    if not isinstance(rows, list) or not rows:
        raise Error(f"{path}: no rows; they are needed")
    return content


def read_traces(run: Run, suite: "Suite") -> Optional[Traces]:
    """The traces of a run, from traces.npy, or else from the bag; None where there is neither."""
    path, bag = run.folder / name_of("traces"), run.folder / name_of("bag")
    if path.exists():
        return _traces(path, run)
    if not bag.exists():
        return None
    with tempfile.TemporaryDirectory() as scratch:
        again = Path(scratch, "again")
        suite.recompute(bag, again)
        metrics = name_of("metrics")
        if read_file(again / metrics) != read_file(run.folder / metrics):
            raise Error(f"{bag}: must be of the run of the metrics.json beside it")
        return _traces(again / name_of("traces"), run)


def _require_one_run(folder: Path, metrics: Json, statistics: Json, provenance: Json) -> None:
    """Raises Error where two files of a run disagree."""
    for key, value in provenance["configuration"].items():
        if key in metrics and key != "episodes" and metrics[key] != value:
            raise Error(f"{folder}: metrics.json and provenance.json differ in {key}")
    for name, unit, key in (("position", "m", "pos"), ("angle", "rad", "ang")):
        figures = statistics["rollouts"][REPLAY][f"mean_{name}_divergence_{unit}"]
        mean = metrics[f"mean_{key}_divergence_{unit}"]  # to six decimals
        if abs(figures["mean"] - mean) > 1e-6:
            raise Error(f"{folder}: metrics.json and statistics.json must be of one run")


def _still_running(episodes: Sequence[Episode], mode: str) -> List[int]:
    """Number of episodes that last at each step, in this mode and in the reference."""
    lasts = [min(episode.steps(mode), episode.steps(REFERENCE)) for episode in episodes]
    return [sum(last >= step for last in lasts) for step in range(max(lasts) + 1)]


def read_rows(path: Path) -> List[Dict[str, str]]:
    """Rows of a table in CSV, by their columns. Raises Error for anything else in the file, and for
    numbers that are not finite."""
    try:
        rows = list(csv.DictReader(io.StringIO(read_text(path), newline="")))
    except FileNotFoundError:
        raise Error(f"{path}: no such file; it is needed") from None
    except (csv.Error, ValueError) as error:
        raise Error(f"{path}: must be CSV: {error}") from None
    if any(None in row or None in row.values() for row in rows):
        raise Error(f"{path}: every row must have as many columns as the first line")
    if any(text in ("inf", "-inf", "nan") for row in rows for text in row.values()):
        raise Error(f"{path}: every number must be finite")
    return rows


def _episodes(path: Path, count: int) -> List[Episode]:
    modes: Dict[int, Dict[str, Dict[str, str]]] = {}
    try:
        for row in read_rows(path):
            modes.setdefault(int(row["episode"]), {})[row["mode"]] = row
        episodes = [Episode(index, modes[index]) for index in sorted(modes)]
        for episode in episodes:
            for mode in MODES:
                episode.steps(mode)
    except (KeyError, ValueError) as error:
        raise Error(f"{path}: must be the episodes of a run: {error!r}") from None
    if len(episodes) != count:
        raise Error(f"{path}: has {len(episodes)} episodes: must be {count}")
    return episodes


def _bands(path: Path) -> Dict[str, Dict[str, Any]]:
    bands: Dict[str, Dict[str, List[float]]] = {}
    try:
        for row in read_rows(path):
            columns = bands.setdefault(row.pop("mode"), {name: [] for name in row if name})
            for name, text in row.items():
                columns[name].append(float(text))
    except (KeyError, ValueError) as error:
        raise Error(f"{path}: must be the divergence of a run: {error!r}") from None
    if not {ENGINE, REPLAY} <= bands.keys():
        raise Error(f"{path}: must have the modes {ENGINE} and {REPLAY}")
    return {mode: {k: np.array(v) for k, v in columns.items()} for mode, columns in bands.items()}


def _traces(path: Path, run: Run) -> Traces:
    wanted = {(e.index, mode): e.steps(mode) + 1 for e in run.episodes for mode in MODES}
    content = io.BytesIO(read_file(path, LARGEST_HEAD + LARGEST_RECORD * sum(wanted.values())))
    try:
        records = np.load(content, allow_pickle=False)
    except (EOFError, ValueError) as error:
        raise Error(f"{path}: must be a NumPy array: {error}") from None
    if not isinstance(records, np.ndarray) or records.dtype.names != TRACE_FIELDS:
        raise Error(f"{path}: must be one array with the fields {', '.join(TRACE_FIELDS)}")
    if content.read(1):
        raise Error(f"{path}: must end after its array")
    _require_finite(path, records)
    begins = np.flatnonzero(records["step"] == 0)
    traces = {
        (int(trace["episode"][0]), trace["mode"][0].decode("ascii", "replace")): trace
        for trace in np.split(records, begins[1:])
        if len(trace)
    }
    if {key: len(trace) for key, trace in traces.items()} != wanted:
        raise Error(f"{path}: must have the steps of episodes.csv beside it")
    target = run.provenance.get("task", {"target": (0.0, 0.0)})["target"]
    for episode in run.episodes:
        for mode in MODES:
            last = traces[episode.index, mode][-1]
            away = float(episode.modes[mode]["final_position_error_m"])
            x, y = last["tee_x"] - target[0], last["tee_y"] - target[1]
            if not math.isclose(math.hypot(x, y), away, abs_tol=1e-9):
                raise Error(f"{path}: must end episode {episode.index} as episodes.csv does")
    return traces


def _require_finite(path: Path, records: Any) -> None:
    """Refuses NaN and infinity. The last step of a rollout has no action: NaN stands for it."""
    last = np.append(records["step"][1:] == 0, True)
    for name in TRACE_FIELDS[3:]:
        bad = ~np.isfinite(records[name])
        if name.startswith("action"):
            bad &= ~(last & np.isnan(records[name]))
        if bad.any():
            record = records[int(np.argmax(bad))]
            where = f"episode {record['episode']}, step {record['step']}"
            raise Error(f"{path}: {where}: {name} {record[name]}: must be finite")
