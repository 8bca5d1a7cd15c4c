# SPDX-License-Identifier: BSD-3-Clause
"""The rows of a sweep: which parameters vary, and which rows make a line in a figure."""

import json
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Sequence, Set, Tuple

from pusht_task.error import Error
from sim2sim_protocol.result_files import name_of

from sim2sim_report.results import REPLAY, read_sweep
from sim2sim_report.suite import Suite

Row = Dict[str, Any]  # the metrics.json of one parameter setting
Setting = Tuple[str, Tuple[Tuple[str, Any], ...]]  # engine; parameters and their values
Words = Dict[str, List[str]]  # values of parameters that take words, or true and false, by place

LOOP = "loop."  # begins the names of the parameters of a loop
AGAINST = "against"  # key in a row: number of the row that it is held against
ENGINE = "engine"  # stands for a parameter where only the kinds of engine vary


class Panel(NamedTuple):
    """A row of panels: its label, and the keys of the metrics that it shows."""

    label: str
    value: str  # keys of the metrics
    interval: str
    beats_null: str = ""
    null: str = ""


SUCCESS = Panel("success rate", "engine_success_rate", "engine_success_interval")
PANELS = [
    SUCCESS,
    Panel(
        "position divergence [m]",
        "mean_pos_divergence_m",
        "mean_pos_divergence_interval_m",
        "mean_pos_divergence_beats_null",
        f"{REPLAY}_null_position_divergence_m",
    ),
    Panel(
        "angle divergence [rad]",
        "mean_ang_divergence_rad",
        "mean_ang_divergence_interval_rad",
        "mean_ang_divergence_beats_null",
        f"{REPLAY}_null_angle_divergence_rad",
    ),
]
# Where the loop of both roles varies, success says what the loop costs; the share that the engine
# keeps says what the engine does.
TRANSFER = Panel("transfer", "transfer", "transfer_interval")
OTHER_KEYS = [
    "confidence",
    "engine_simulator",
    "episodes",
    "knobs",
    "policy",
    "reference_success_interval",
    "reference_success_rate",
    "seed",
    "simulators",
]


def read_rows(folder: Path) -> Tuple[List[Row], int]:
    """The rows of a sweep.json, checked, and how many a whole sweep has."""
    path = folder / name_of("sweep")
    content = read_sweep(folder)
    rows: List[Row] = content["rows"]
    needed = OTHER_KEYS + [key for panel in [*PANELS, TRANSFER] for key in panel[1:] if key]
    for number, row in enumerate(rows):
        missing = [key for key in needed if not isinstance(row, dict) or key not in row]
        if missing:
            raise Error(f"{path}: row {number}: no key {missing[0]}; it is needed")
        for what, of_row in (
            ("policy", lambda r: r["policy"]),
            ("reference", lambda r: without_loop(r["simulators"]["reference"])),
        ):
            if of_row(row) != of_row(rows[0]):
                raise Error(
                    f"{path}: row {number}: its {what} is not that of row 0; it must be "
                    "(`matrix` shows sweeps over policies)"
                )
        first = next(r for r in rows if r["engine_simulator"] == row["engine_simulator"])
        if row["knobs"].keys() != first["knobs"].keys():
            raise Error(
                f"{path}: row {number}: must have the parameters of the rows of its engine "
                "(`equivalent` takes errors of several parameters)"
            )
    try:
        return rows, len(content["sweep"]["rows"])
    except (KeyError, TypeError):
        raise Error(f"{path}: no list of rows under sweep; it is needed") from None


def without_loop(simulator: Any) -> Any:
    """A simulator of a row, whatever the loop that its policy is in."""
    kept = {name for name in simulator["parameters"] if not name.startswith(LOOP)}
    plain: Dict[str, Any] = {
        **simulator,
        "changed": [name for name in simulator["changed"] if name in kept],
    }
    for key in ("parameters", "units"):
        plain[key] = {name: value for name, value in simulator[key].items() if name in kept}
    return plain


def panels_of(rows: Sequence[Row]) -> List[Panel]:
    """The panels of a figure: with transfer in place of success where the reference's loop
    varies."""
    first = rows[0]["simulators"]["reference"]
    same = all(row["simulators"]["reference"] == first for row in rows)
    return PANELS if same else [TRANSFER, *PANELS[1:]]


def contrasted(folder: Path, rows: Sequence[Row], against: int, suite: Suite) -> List[Row]:
    """The rows with what differs from row `against`, pair by pair, in place of their figures."""
    contrasts = suite.contrast([folder], against)["contrasts"]
    same = {"difference": 0.0, "interval": None}
    figures = [contrast["figures"] for contrast in contrasts]
    figures.insert(against, {panel.value: same for panel in PANELS})
    changed = []
    for row, figure in zip(rows, figures):
        row = {**row, AGAINST: against}
        for panel in PANELS:
            row[panel.value] = figure[panel.value]["difference"]
            row[panel.interval] = figure[panel.value]["interval"]
            if panel.beats_null:
                row[panel.beats_null] = True  # a difference has no null model
        changed.append(row)
    return changed


def engines_of(rows: Sequence[Row]) -> List[str]:
    """The kinds of engines, in the order of the file."""
    return list(dict.fromkeys(row["engine_simulator"] for row in rows))


def varied_parameters(rows: Sequence[Row]) -> List[str]:
    """The parameters that take more than one value with one engine, in the order of the file."""
    values: Dict[Tuple[str, str], Set[Any]] = {}
    for row in rows:
        for name, value in row["knobs"].items():
            values.setdefault((row["engine_simulator"], name), set()).add(value)
    return list(dict.fromkeys(name for (_, name), taken in values.items() if len(taken) > 1))


def follows(parameter: str, leader: str, rows: Sequence[Row]) -> bool:
    """True if `leader` takes words, and each of them sets `parameter`, as a preset does."""
    led = [row["knobs"] for row in rows if leader in row["knobs"]]
    pairs = {(taken[leader], taken.get(parameter)) for taken in led}
    words = {word for word, _ in pairs}
    return len(words) == len(pairs) and all(isinstance(word, str) for word in words)


def without_followers(parameters: Sequence[str], rows: Sequence[Row]) -> List[str]:
    """The parameters but for those that follow another one."""

    def takes_words(parameter: str) -> bool:
        return any(isinstance(row["knobs"].get(parameter), str) for row in rows)

    leaders: List[str] = []
    for parameter in sorted(parameters, key=takes_words, reverse=True):
        if not any(follows(parameter, leader, rows) for leader in leaders):
            leaders.append(parameter)
    return [parameter for parameter in parameters if parameter in leaders]


def with_engine_as_parameter(rows: Sequence[Row]) -> List[Row]:
    """The engine is what varies."""
    return [{**row, "knobs": {ENGINE: title_of_role(row, "engine")}} for row in rows]


def with_places(rows: Sequence[Row], parameters: Sequence[str]) -> Tuple[List[Row], Words]:
    """The rows with places in place of words, in the order in which the words come."""
    taken = {
        name: list(dict.fromkeys(row["knobs"][name] for row in rows if name in row["knobs"]))
        for name in parameters
    }
    words = {
        parameter: [value if isinstance(value, str) else json.dumps(value) for value in values]
        for parameter, values in taken.items()
        if any(isinstance(value, (str, bool)) for value in values)
    }
    placed = []
    for row in rows:
        there = words.keys() & row["knobs"]
        places = {parameter: taken[parameter].index(row["knobs"][parameter]) for parameter in there}
        placed.append({**row, "knobs": {**row["knobs"], **places}})
    return placed, words


def lines_over(
    parameter: str, parameters: Sequence[str], rows: Sequence[Row]
) -> Dict[Setting, List[Row]]:
    """Lines by growing value of `parameter`, one for each engine and setting of the others."""
    several = len(engines_of(rows)) > 1 and parameter != ENGINE
    lines: Dict[Setting, List[Row]] = {}
    for row in sorted(rows, key=lambda row: row["knobs"][parameter]):
        taken = row["knobs"]
        others = tuple(
            (name, taken[name]) for name in parameters if name != parameter and name in taken
        )
        lines.setdefault((title_of_role(row, "engine") if several else "", others), []).append(row)
    return dict(sorted(lines.items()))


def title_of_role(row: Row, role: str) -> str:
    """The title of a simulator."""
    title: str = row["simulators"][role]["title"]
    return title


def unit_of(parameter: str, rows: Sequence[Row]) -> str:
    units = (row["simulators"]["engine"]["units"].get(parameter) for row in rows)
    return next(filter(None, units), "")


def label_of(setting: Setting, rows: Sequence[Row], words: Words) -> str:
    engine, parameters = setting
    values = [
        f"{parameter} {words[parameter][value] if parameter in words else format(value, 'g')} "
        f"{unit_of(parameter, rows)}".strip()
        for parameter, value in parameters
    ]
    return ", ".join(filter(None, [engine, *values]))
