# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a report, for the page (SVG that follows its theme) and for papers (PNG, PDF)."""

import io
import re
import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, Optional, Sequence, Tuple

import matplotlib  # type: ignore[import]
from pusht_task.task import CONTROL_STEP

from sim2sim_eval.report.results import ENGINE, REPLAY, Json, Run

matplotlib.use("Agg")
from matplotlib.figure import Figure  # type: ignore[import]  # noqa: E402

# The hues of rviz, dark enough for white paper. In the page each is a variable that a theme sets.
INK, DIM, GRID = "#1d2430", "#5c6676", "#d9dee7"
COLORS = {"reference": "#1467b8", ENGINE: "#8a6d00", REPLAY: "#c2334d"}
VARIABLES = {
    INK: "var(--ink)",
    DIM: "var(--dim)",
    GRID: "var(--grid)",
    COLORS["reference"]: "var(--reference)",
    COLORS[ENGINE]: "var(--engine)",
    COLORS[REPLAY]: "var(--replay)",
}
STYLE: Dict[str, Any] = {
    "axes.edgecolor": DIM,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.facecolor": "none",
    "font.family": "sans-serif",
    "font.size": 11,
    "grid.color": GRID,
    "legend.frameon": False,
    "lines.linewidth": 2,
    "svg.fonttype": "none",
    "text.color": INK,
    "xtick.color": DIM,
    "ytick.color": DIM,
}
LONGEST_LINE = 26  # characters of a name beside its bar
COMPONENTS = (("position", "m"), ("angle", "rad"))
_LEVELS = ("0.05", "0.25", "0.50", "0.75", "0.95")  # of the bands


@dataclass(frozen=True)
class Drawing:
    """A figure with its name for files and what it shows, in words."""

    name: str
    alt: str
    figure: Any

    @property
    def width(self) -> int:
        """[px] on the page, at which its letters are as large as those of the text."""
        return round(self.figure.get_figwidth() * 120)

    def svg(self) -> str:
        """Inline SVG: its colours are those of the page, its ids its own; the same bytes again."""
        text = io.StringIO()
        with matplotlib.rc_context({**STYLE, "svg.hashsalt": self.name}):
            self.figure.savefig(text, format="svg", metadata={"Date": None})
        return inline(text.getvalue(), self.name)

    def save(self, folder: Path) -> Iterator[Tuple[Path, bytes]]:
        """The files for papers."""
        for kind in ("png", "pdf"):
            content = io.BytesIO()
            metadata = {"CreationDate": None} if kind == "pdf" else {"Software": None}
            with matplotlib.rc_context(STYLE):
                self.figure.savefig(
                    content, format=kind, dpi=200, facecolor="white", metadata=metadata
                )
            yield folder / f"{self.name}.{kind}", content.getvalue()


def inline(svg: str, name: str) -> str:
    """An SVG file as a part of a page: with the page's colours, and ids of its own."""
    svg = svg[svg.index("<svg") :]
    for color, variable in VARIABLES.items():
        svg = svg.replace(color, variable)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    ids = set(re.findall(r'id="([^"]+)"', svg))
    svg = re.sub(
        r'(id="|href="#|url\(#)([^")]+)',
        lambda m: f"{m[1]}{name}-{m[2]}" if m[2] in ids else m[0],
        svg,
    )
    return re.sub(r' width="[\d.]+pt" height="[\d.]+pt"', "", svg, count=1)


def draw(run: Run, prefix: str) -> Dict[str, Drawing]:
    """All figures of a run; `prefix` tells runs apart."""
    with matplotlib.rc_context(STYLE):
        drawings = [_yardsticks(run), _bands(run), _causes(run)]
    return {d.name: Drawing(f"{prefix}{d.name}", d.alt, d.figure) for d in drawings}


def draw_rates(runs: Sequence[Run]) -> Drawing:
    """Success with intervals: the reference, and the engine of each run."""
    with matplotlib.rc_context(STYLE):
        first = runs[0].metrics
        bars = [(f"{runs[0].title('reference')}", first, "reference")]
        bars += [(run.name, run.metrics, "engine") for run in runs]
        # Names are text, not mathematics.
        names = [textwrap.fill(name, LONGEST_LINE).replace("$", r"\$") for name, _, _ in bars]
        lines = sum(name.count("\n") + 1 for name in names)
        size = (5.6, 0.75 + 0.3 * len(bars) + 0.2 * lines)
        figure = Figure(figsize=size, constrained_layout=True)
        axes = figure.subplots()
        for row, (_, metrics, role) in enumerate(bars):
            color = COLORS["reference"] if role == "reference" else COLORS[ENGINE]
            rate = metrics[f"{role}_success_rate"]
            low, high = metrics[f"{role}_success_interval"]
            _draw_share(axes, row, rate, (low, high), color)
        name_rows(axes, names)
        axes.set_xlim(0, 1)
        axes.set_xlabel("success rate, closed loop")
    texts = [f"{name} {m[f'{role}_success_rate']:.3f}" for name, m, role in bars]
    return Drawing("success", "Success rates: " + ", ".join(texts), figure)


def _yardsticks(run: Run) -> Drawing:
    """Mean divergences beside what they must be read against."""
    rows = [
        ("open loop", REPLAY, "mean_{}_divergence", COLORS[REPLAY]),
        ("its null model", REPLAY, "null_{}_divergence", DIM),
        ("closed loop", ENGINE, "mean_{}_divergence", COLORS[ENGINE]),
        ("its null model", ENGINE, "null_{}_divergence", DIM),
    ]
    rows += [
        (f"floor, {name[len('floor_'):]} m", name, "mean_{}_divergence", COLORS["reference"])
        for name in reversed(run.metrics["probes"])
        if name.startswith("floor_")
    ]
    figure = Figure(figsize=(6.2, 0.8 + 0.28 * len(rows)), constrained_layout=True)
    for axes, (component, unit) in zip(figure.subplots(1, 2, sharey=True), COMPONENTS):
        for row, (_, mode, quantity, color) in enumerate(rows):
            figures = run.statistics["rollouts"][mode][f"{quantity.format(component)}_{unit}"]
            if not figures["mean"]:  # none, or 0, which has no place on this axis
                continue
            if figures["mean_interval"] is not None:
                axes.plot(figures["mean_interval"], [row, row], color=color, linewidth=3)
            axes.plot(figures["mean"], row, "o", color=color, markersize=7)
        axes.set_xscale("log")
        axes.set_xlabel(f"{component} [{unit}]")
        name_rows(axes, [row[0] for row in rows])
    return Drawing("yardsticks", "Mean divergences with null model and floor", figure)


def _bands(run: Run) -> Drawing:
    """Quantiles of the divergence over time, and how many episodes they are of."""
    figure = Figure(figsize=(6.2, 5.0), constrained_layout=True)
    grid = figure.subplots(3, 2, sharex=True, sharey="row", height_ratios=[3, 3, 1.2])
    bound = run.metrics["bound"]
    limits = {"position": bound["position_m"], "angle": bound["angle_rad"]}
    for column, (mode, name) in enumerate(((REPLAY, "open loop"), (ENGINE, "closed loop"))):
        band, color = run.bands[mode], COLORS[mode]
        seconds = band["step"] * CONTROL_STEP
        grid[0, column].set_title(name, color=INK, fontsize=12, loc="left")
        for axes, (component, unit) in zip(grid[:, column], COMPONENTS):
            levels = [band[f"{component}_{level}_{unit}"] for level in _LEVELS]
            axes.fill_between(seconds, levels[0], levels[4], color=color, alpha=0.15, linewidth=0)
            axes.fill_between(seconds, levels[1], levels[3], color=color, alpha=0.3, linewidth=0)
            axes.plot(seconds, levels[2], color=color)
            axes.axhline(limits[component], color=INK, linewidth=1, linestyle="--")
            axes.set_ylim(bottom=0)
            if column == 0:
                axes.set_ylabel(f"{component} [{unit}]")
        running = grid[2, column]
        running.fill_between(seconds, band["episodes"], step="post", color=DIM, alpha=0.4)
        running.set_ylim(bottom=0)
        running.set_xlabel("time [s]")
    grid[2, 0].set_ylabel("episodes")
    return Drawing("divergence", "Quantiles of the divergence over time, with the bound", figure)


def _causes(run: Run) -> Drawing:
    """At what episodes part."""
    causes: Json = run.statistics["rollouts"][REPLAY]["parting"]["causes"]
    shown = sorted(
        ((name, cause) for name, cause in causes.items() if cause["episodes"]),
        key=lambda item: (-int(item[1]["episodes"]), item[0]),
    )
    figure = Figure(figsize=(5.6, 0.9 + 0.36 * max(1, len(shown))), constrained_layout=True)
    axes = figure.subplots()
    for row, (_, cause) in enumerate(shown):
        _draw_share(axes, row, cause["share"], cause.get("interval"), COLORS[REPLAY])
    names = [f"{name.replace('_', ' ')}  {cause['episodes']}" for name, cause in shown]
    name_rows(axes, names)
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of the episodes that leave the bound, open loop")
    return Drawing("causes", "First causes: " + ", ".join(names), figure)


def _draw_share(
    axes: Any, row: int, share: float, interval: Optional[Sequence[float]], color: str
) -> None:
    axes.barh(row, share, height=0.55, color=color, alpha=0.85)
    if interval is not None:
        axes.plot(interval, [row, row], color=INK, linewidth=2.5, solid_capstyle="butt")


def name_rows(axes: Any, names: Sequence[str]) -> None:
    """Rows from top to bottom, with their names on the left."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(1, len(names)) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0, labelcolor=INK)
    axes.grid(axis="y", visible=False)
