# SPDX-License-Identifier: BSD-3-Clause
"""Draws docs/statistics/coverage.svg from coverage.csv beside it, and prints the table of
docs/statistics.md. With --from it first makes the CSV files of what `coverage` has printed.

Source the workspace first.
"""

import statistics
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Sequence, Tuple

import numpy as np
from pusht_task.command import OneLineParser, run_command
from pusht_task.error import Error
from pusht_task.files import read_file, write_file
from sim2sim_report.colors import COLORS, DIM, INK
from sim2sim_report.figures import NARROW, Drawing, add_legend, entitle, name_rows, panels
from sim2sim_report.results import REPLAY

import coverage_data as data
from coverage_data import Row

PICTURE = data.FOLDER / "coverage.svg"
MARK = "sim2sim coverage"  # in the metadata of the picture
NOMINAL = 95.0  # [%]
WIDTH = 2.0  # [%] around it, beyond which the axis is nearly logarithmic
MOST_ERROR = 5.0  # [%] largest standard error with which a share may be the least of its group
DOT = {"linestyle": "", "marker": "o", "markeredgewidth": 0}
DOTS: Dict[str, Dict[str, Any]] = {
    "95 within two standard errors, or more": (
        {**DOT, "color": COLORS["reference"], "markersize": 4.0, "alpha": 0.45}
    ),
    "too seldom by more than that": (
        {**DOT, "color": COLORS[REPLAY], "markersize": 5.0, "alpha": 0.7}
    ),
}
INSTEAD = "instead: "  # begins the name of a method that is counted for comparison, not printed


class Group(NamedTuple):
    """A row of the picture: methods that belong together."""

    name: str
    experiments: Tuple[str, ...]
    methods: Tuple[str, ...] = ("",)  # beginnings of their names

    def has(self, row: Row) -> bool:
        return row["experiment"] in self.experiments and row["method"].startswith(self.methods)


ONE, DIFFERENCE = ("one policy",), ("difference of divergences",)
TESTS, WATCHING = ("tests",), ("watching",)
REPEATS, RANKINGS = ("repeats",), ("rankings",)
ONE_POLICY = (
    Group("success rate: Wilson", ONE, ("Wilson",)),
    Group("difference of success: Tango", ONE, ("difference of rates",)),
    Group("transfer: Tang", ONE, ("transfer",)),
    Group("median: order statistics", (*ONE, "median divergence"), ("median",)),
    Group("mean of common errors: log-t", ONE, ("mean, log-t",)),
    Group("mean divergence: Gaffke", ("mean divergence",), ("mean, Gaffke",)),
    Group(f"{INSTEAD}log-t", ("mean divergence",), ("mean, log-t",)),
    Group("ratio of divergences: Gaffke", ("ratio of divergences",)),
    Group(
        "difference of divergences: t, Gaffke",
        (*ONE, *DIFFERENCE),
        ("paired difference, t", "difference, as printed"),
    ),
    Group(f"{INSTEAD}always t", DIFFERENCE, ("difference, t",)),
    Group(f"{INSTEAD}always Gaffke", DIFFERENCE, ("difference, Gaffke",)),
    Group("equivalent error: from Tango", ("equivalent errors",)),
    Group("difference of transfers: from Tang", ("two policies",)),
)
POLICIES = (
    Group("success: t, Fieller", ("success of policies",)),
    Group("mean divergence: t", ("divergence of policies",), ("mean",)),
    Group("two recipes' divergence: t", ("divergence of policies",), ("difference", "the same")),
)
ONCE_OR_WATCHED = (
    Group("success: McNemar", TESTS, ("McNemar",)),
    Group("divergence: t", TESTS, ("paired difference, t",)),
    Group("20 rows: Holm, Bonferroni", TESTS, ("t, Holm", "t, Bonferroni")),
    Group(f"{INSTEAD}no correction", TESTS, ("t, not corrected",)),
    Group("watched success: bets", WATCHING, ("keeps", "transfer", "any")),
    Group(f"{INSTEAD}McNemar each time", WATCHING, ("McNemar",)),
    Group("watched divergence: sequence", WATCHING, ("sign",)),
)
BY_START = (
    Group("success: Wilson, Tango, Tang", REPEATS, ("success rate", "difference", "transfer")),
    Group(f"{INSTEAD}by episode", ("repeats as episodes",)),
    Group("variances of success: Gaffke", REPEATS, ("variance",)),
    Group("mean divergence: Gaffke", REPEATS, ("mean divergence",)),
    Group("equal success: McNemar", REPEATS, ("McNemar",)),
)
BY_RANK = (
    Group("Kendall", RANKINGS, ("Kendall",)),
    Group("Spearman", RANKINGS, ("Spearman",)),
    Group("Pearson", RANKINGS, ("Pearson",)),
    Group("rank violation", RANKINGS, ("rank violation",)),
    Group("agreement of pairs", RANKINGS, ("agreement",)),
)
LEFT = {"one policy": ONE_POLICY, "policies and starts": POLICIES}
RIGHT = {"tests and verdicts": ONCE_OR_WATCHED, "repeats, by start": BY_START, "rankings": BY_RANK}


class Share(NamedTuple):
    """How often a method is right in one case."""

    percent: float
    error: float  # [%] standard error
    row: Row

    @property
    def is_too_seldom(self) -> bool:
        return self.row["differs"] == "worse"

    @property
    def case(self) -> str:
        counts = " x ".join(self.row[name] for name in data.SHAPE if self.row[name] != "1")
        return f"{self.row['population']}; {counts}"


Shares = Dict[Group, List[Share]]


def shares_of(rows: Sequence[Row]) -> Shares:
    """The shares of each group. Raises Error for a row that is in no group, or in two."""
    shares: Shares = {
        group: [] for side in (LEFT, RIGHT) for part in side.values() for group in part
    }
    for row in rows:
        if not row["nominal"]:
            continue  # how often there is an answer, not how often it is right
        groups = [group for group in shares if group.has(row)]
        if len(groups) != 1:
            raise Error(f"{row['experiment']}, {row['method']}: must be in one group")
        if row["percent"]:
            percent = float(row["percent"])
            right = percent if row["quantity"] == "holds" else 100.0 - percent
            shares[groups[0]].append(Share(right, float(row["standard_error"]), row))
    return shares


def table(shares: Shares) -> Iterator[str]:
    """The lines of the table of docs/statistics.md."""
    yield "| method | cases | typical | least | where it is the least |"
    yield "|---|---|---|---|---|"
    for side in (LEFT, RIGHT):
        for title, groups in side.items():
            yield f"| *{title}* |||||"
            for group in groups:
                typical = statistics.median(share.percent for share in shares[group])
                sure = [share for share in shares[group] if share.error <= MOST_ERROR]
                if not sure:
                    raise Error(
                        f"{group.name}: the standard error of every case is above {MOST_ERROR} %; "
                        "run coverage with more repetitions"
                    )
                least = min(sure, key=lambda share: share.percent)
                figures = f"{len(shares[group])} | {typical:.1f} | {least.percent:.1f}"
                yield f"| {group.name} | {figures} | {least.case} |"


def picture(shares: Shares) -> Drawing:
    """Every share, in a row for each group."""
    count = sum(map(len, shares.values()))
    title = f"How often is each method right? {count} cases whose truth is known"

    def build(narrow: bool) -> Any:
        figure, [both] = panels(narrow, (1, 2), (13.3, 7.5), (NARROW, 7.5))
        for axes, side in zip(both, (LEFT, RIGHT)):
            _draw_side(axes, side, shares)
        entitle(figure, [title], 16)
        for name, style in DOTS.items():
            both[0].plot([], [], label=name, **style)
        both[0].plot([], [], "|", label="median", color=INK, markersize=14, markeredgewidth=2.5)
        add_legend(figure, "lower", 1 if narrow else 3)
        return figure

    return Drawing("coverage", title, build)


def _draw_side(axes: Any, side: Dict[str, Tuple[Group, ...]], shares: Shares) -> None:
    names: List[str] = []
    for title, groups in side.items():
        names.append(title)
        for group in groups:
            _draw_row(axes, len(names), shares[group])
            names.append(group.name)
    name_rows(axes, names)
    for label in axes.get_yticklabels():
        if label.get_text() in side:
            label.set_fontweight("bold")
        elif label.get_text().startswith(INSTEAD):
            label.set_color(DIM)
    axes.axvline(NOMINAL, color=INK, linewidth=1)
    axes.set_xscale("function", functions=(_stretched, _back))
    axes.set_xlim(15, 100.4)
    ticks = (20, 50, 80, 90, 95, 98, 100)
    axes.set_xticks(ticks, ticks)
    axes.set_xlabel("right in so many of 100 repetitions; nominal: 95")


def _stretched(percent: Any) -> Any:
    """Place on the axis, on which what is near the nominal share has most of the room."""
    return np.arcsinh((percent - NOMINAL) / WIDTH)


def _back(place: Any) -> Any:
    return NOMINAL + WIDTH * np.sinh(place)


def _draw_row(axes: Any, place: int, shares: Sequence[Share]) -> None:
    golden = 0.618034  # spreads any number of dots evenly
    for is_too_seldom, style in zip((False, True), DOTS.values()):
        chosen = [share.percent for share in shares if share.is_too_seldom == is_too_seldom]
        ups = [place + 0.35 * (2.0 * (golden * i % 1.0) - 1.0) for i in range(len(chosen))]
        axes.plot(chosen, ups, **style)
    middle = statistics.median(share.percent for share in shares)
    axes.plot([middle, middle], [place - 0.42, place + 0.42], color=INK, linewidth=2.5)


def draw(arguments: Any) -> None:
    files: Dict[Path, bytes] = {}
    if arguments.printed:
        rows, widths = data.rows_of(read_file(Path(arguments.printed)).decode())
        files[data.COVERAGE] = data.written(data.COLUMNS, rows)
        files[data.WIDTHS] = data.written(data.WIDTH_COLUMNS, widths)
    else:
        rows = data.read(data.COVERAGE)
    shares = shares_of(rows)
    lines = list(table(shares))
    files[PICTURE] = picture(shares).file("svg", MARK)
    for path, contents in files.items():
        write_file(path, contents)
    print("\n".join(lines))


def main() -> int:
    parser = OneLineParser(prog="coverage_figure", description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--from", dest="printed", metavar="FILE", help="output of coverage")
    arguments = parser.parse_args()
    return run_command("coverage_figure", lambda: draw(arguments))


if __name__ == "__main__":
    raise SystemExit(main())
