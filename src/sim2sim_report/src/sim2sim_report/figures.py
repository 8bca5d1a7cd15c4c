# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a report, for the page (SVG that follows its theme) and for papers (PNG, PDF)."""

import functools
import io
import logging
import re
import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

from pusht_task.error import Error
from pusht_task.json_file import Json
from pusht_task.task import CONTROL_STEP

from sim2sim_report.colors import COLORS, DIM, GRID, INK, VARIABLES
from sim2sim_report.results import ENGINE, REPLAY, Run

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # before it reports on its cache
import matplotlib  # type: ignore[import]  # noqa: E402

matplotlib.use("Agg")
from matplotlib.backends.backend_agg import FigureCanvasAgg  # type: ignore[import]  # noqa: E402
from matplotlib.figure import Figure  # type: ignore[import]  # noqa: E402
from matplotlib.font_manager import FontProperties  # type: ignore[import]  # noqa: E402
from matplotlib.patches import Circle, Rectangle  # type: ignore[import]  # noqa: E402

MARK = b"sim2sim report"  # in the page and the metadata of images, by which they are known as ours
PAPER_KINDS = ("png", "pdf")
PIXELS = 120  # of an inch of a figure on the page
NARROW = 4.3  # [in] width of a figure on a phone
STYLE: Dict[str, Any] = {
    "axes.axisbelow": True,
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
    "text.color": INK,
    "xtick.color": DIM,
    "ytick.color": DIM,
}
LONGEST_LINE = 26  # characters of a name beside its bar
POINTS = 72  # of an inch
CHARACTER = 0.62  # width of one in a title or a legend, in font sizes
LEGEND_LINE, LEGEND_HANDLE = 1.57, 4.0  # height of a line, width of a handle, in font sizes
COMPONENTS = (("position", "m"), ("angle", "rad"))
_LEVELS = ("0.05", "0.25", "0.50", "0.75", "0.95")  # levels of the bands


@dataclass(frozen=True)
class Drawing:
    """A figure with its name for files and what it shows, in words. It is built when asked for."""

    name: str
    alt: str
    build: Callable[[bool], Any]
    style: Dict[str, Any]

    @functools.cached_property
    def wide(self) -> Any:
        """The figure for screens and papers."""
        return self._built(False)

    @functools.cached_property
    def narrow(self) -> Any:
        """The figure for phones: its panels stand below each other."""
        return self._built(True)

    def _built(self, narrow: bool) -> Any:
        with matplotlib.rc_context(self.style):
            return self.build(narrow)

    @property
    def width(self) -> int:
        """[px] on the page, at which its letters are as large as those of the text."""
        return round(self.wide.get_figwidth() * PIXELS)

    def svg(self, narrow: bool = False) -> str:
        """Inline SVG: its colors are those of the page, its ids its own; the same bytes again."""
        name = f"narrow-{self.name}" if narrow else self.name
        text = io.StringIO()
        style = {**self.style, "svg.fonttype": "none", "svg.hashsalt": name}
        with matplotlib.rc_context(style):
            figure = self.narrow if narrow else self.wide
            figure.savefig(text, format="svg", metadata={"Date": None})
        return inline(text.getvalue(), name)

    def file(self, kind: str, mark: str) -> bytes:
        """The bytes of a picture, the same again, with `mark` in its metadata."""
        content = io.BytesIO()
        metadata = {
            "png": {"Software": mark},
            "svg": {"Date": None, "Creator": mark},
            "pdf": {"CreationDate": None, "Creator": mark},
        }
        with matplotlib.rc_context({**self.style, "svg.hashsalt": self.name}):
            self.wide.savefig(
                content, format=kind, dpi=200, facecolor="white", metadata=metadata.get(kind, {})
            )
        return content.getvalue()

    def paths(self, folder: Path) -> List[Path]:
        """Where save() writes."""
        return [folder / f"{self.name}.{kind}" for kind in PAPER_KINDS]

    def save(self, folder: Path) -> Iterator[Tuple[Path, bytes]]:
        """The files for papers."""
        for path, kind in zip(self.paths(folder), PAPER_KINDS):
            yield path, self.file(kind, MARK.decode())


def styled(
    name: str, alt: str, build: Callable[[bool], Any], style: Optional[Dict[str, Any]] = None
) -> Drawing:
    """The drawing whose figures `build` makes: the wide one (False) and the narrow one."""
    return Drawing(name, alt, build, style or STYLE)


def require_picture_format(out: Path) -> None:
    """Refuses a name that does not end with a format of pictures."""
    kinds = FigureCanvasAgg.get_supported_filetypes()
    if out.suffix[1:] not in kinds:
        names = ", ".join(sorted(kinds))
        raise Error(f"out {out}: must end with the name of a format, one of {names}")


def panels(narrow: bool, width: float, height: float, **options: Any) -> Tuple[Any, Any]:
    """A figure of two panels: beside each other, or below each other. Sizes [in] are of both beside
    each other."""
    if narrow:
        figure = Figure(figsize=(NARROW, 2 * height), constrained_layout=True)
        return figure, figure.subplots(2, 1, **options)
    figure = Figure(figsize=(width, height), constrained_layout=True)
    return figure, figure.subplots(1, 2, **options)


def inline(svg: str, name: str) -> str:
    """An SVG file as a part of a page: with the page's colors, and ids of its own.

    It has attributes in place of styles, which a build server may forbid.
    """
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' style="([^"]*)"', lambda m: _attributes(m[1]), svg)
    for color, variable in VARIABLES.items():
        svg = svg.replace(color, variable)
    ids = set(re.findall(r'id="([^"]+)"', svg))
    svg = re.sub(
        r'(id="|href="#|url\(#)([^")]+)',
        lambda m: f"{m[1]}{name}-{m[2]}" if m[2] in ids else m[0],
        svg,
    )
    svg = re.sub(r'( (?:width|height)=")([\d.]+)pt', lambda m: m[1] + _pixels(m[2]), svg, count=2)
    # Matplotlib's style, which is left out, says it of every line.
    return svg.replace("<svg", '<svg stroke-linejoin="round"', 1)


def _attributes(style: str) -> str:
    """Attributes for the properties of a style. A font keeps its size; its family is the page's."""
    texts = []
    for prop, value in (part.split(": ", 1) for part in style.split("; ")):
        if prop == "font":
            size = next(word for word in value.split() if word.endswith("px"))
            texts += [f'font-size="{size}"', 'font-family="sans-serif"']
        else:
            texts.append(f'{prop}="{value}"')
    return "".join(f" {text}" for text in texts)


def _pixels(points: str) -> str:
    return str(round(float(points) / 72 * PIXELS))


def draw(run: Run, prefix: str) -> Dict[str, Drawing]:
    """The figures of a run by name; `prefix` tells runs apart."""
    drawings = {}
    for name, alt, build in (
        ("yardsticks", _baselines_in_words(run), _baselines),
        ("divergence", "Quantiles of the divergence over time, with the bound", _bands),
        ("causes", "First causes: " + ", ".join(_named_causes(run)), _causes),
    ):
        drawings[name] = styled(f"{prefix}{name}", alt, functools.partial(build, run))
    return drawings


def draw_rates(runs: Sequence[Run]) -> Drawing:
    """Success with intervals: the reference, and the engine of each run."""
    first = runs[0].metrics
    bars = [(f"{runs[0].title('reference')}", first, "reference")]
    bars += [(run.name, run.metrics, "engine") for run in runs]
    texts = [f"{name} {m[f'{role}_success_rate']:.3f}" for name, m, role in bars]

    def build(narrow: bool) -> Any:
        # Names are text, not mathematics.
        names = [textwrap.fill(name, LONGEST_LINE).replace("$", r"\$") for name, _, _ in bars]
        lines = sum(name.count("\n") + 1 for name in names)
        height = 0.75 + 0.3 * len(bars) + 0.2 * lines
        figure = Figure(figsize=(NARROW if narrow else 5.6, height), constrained_layout=True)
        axes = figure.subplots()
        for row, (_, metrics, role) in enumerate(bars):
            color = COLORS["reference"] if role == "reference" else COLORS[ENGINE]
            rate = metrics[f"{role}_success_rate"]
            _draw_share(axes, row, rate, metrics[f"{role}_success_interval"], color)
        name_rows(axes, names)
        axes.set_xlim(0, 1)
        axes.set_xlabel("success rate, closed loop")
        return figure

    return styled("success", "Success rates: " + ", ".join(texts), build)


def _baseline_rows(run: Run) -> List[Tuple[str, str, str, str]]:
    """Mean divergences and their baselines: name, mode, quantity, color."""
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
    return rows


def _baselines_in_words(run: Run) -> str:
    parts = []
    for name, mode, quantity, _ in _baseline_rows(run):
        mean = run.statistics["rollouts"][mode][f"{quantity.format('position')}_m"]["mean"]
        parts.append(f"{name} {'none' if mean is None else format(mean, '.4f')} m")
    return "Mean divergences with null model and floor: " + ", ".join(parts)


def _baselines(run: Run, narrow: bool) -> Any:
    """Mean divergences beside their baselines, from zero, with their values."""
    rows = _baseline_rows(run)
    figure, both = panels(narrow, 8.6, 0.8 + 0.32 * len(rows), sharey=True)
    for axes, (component, unit) in zip(both, COMPONENTS):
        end = 0.0
        for row, (_, mode, quantity, color) in enumerate(rows):
            figures = run.statistics["rollouts"][mode][f"{quantity.format(component)}_{unit}"]
            if figures["mean"] is None:
                continue
            right = figures["mean"]
            if figures["mean_interval"] is not None:
                axes.plot(figures["mean_interval"], [row, row], color=color, linewidth=3)
                right = max(right, figures["mean_interval"][1])
            axes.plot(figures["mean"], row, "o", color=color, markersize=7, clip_on=False)
            text = (6, 0)  # [points] to the right of the interval
            axes.annotate(
                f"{figures['mean']:.4f}",
                (right, row),
                text,
                va="center",
                fontsize=10,
                textcoords="offset points",
                color=INK,
            )
            end = max(end, right)
        axes.set_xlim(0, 1.25 * (end or 1.0))
        axes.locator_params(axis="x", nbins=5)
        axes.set_xlabel(f"{component} [{unit}]")
        name_rows(axes, [row[0] for row in rows])
    return figure


def _bands(run: Run, narrow: bool) -> Any:
    """Quantiles of the divergence over time, and how many episodes they are of."""
    size = (NARROW, 8.6) if narrow else (8.6, 5.0)
    figure = Figure(figsize=size, constrained_layout=True)
    shape = {"height_ratios": [3, 3, 1.2] * (2 if narrow else 1)}
    if narrow:
        grid = figure.subplots(6, 1, sharex=True, **shape).reshape(2, 3).T
    else:
        grid = figure.subplots(3, 2, sharex=True, sharey="row", **shape)
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
            if column == 0 or narrow:
                axes.set_ylabel(f"{component} [{unit}]")
        running = grid[2, column]
        running.fill_between(seconds, band["episodes"], step="post", color=DIM, alpha=0.4)
        running.set_ylim(bottom=0)
        running.locator_params(axis="y", nbins=2, integer=True)
        if column == 0 or narrow:
            running.set_ylabel("episodes")
        if column == 1 or not narrow:
            running.set_xlabel("time [s]")
    return figure


def _causes_of(run: Run) -> List[Tuple[str, Json]]:
    """Causes of first divergence in open loop, the most frequent first."""
    causes: Json = run.statistics["rollouts"][REPLAY]["parting"]["causes"]
    return sorted(
        ((name, cause) for name, cause in causes.items() if cause["episodes"]),
        key=lambda item: (-int(item[1]["episodes"]), item[0]),
    )


def _named_causes(run: Run) -> List[str]:
    return [f"{name.replace('_', ' ')}: {cause['episodes']}" for name, cause in _causes_of(run)]


def _causes(run: Run, narrow: bool) -> Any:
    """Causes of first divergence, with the share of episodes that each has."""
    shown = _causes_of(run)
    size = (NARROW if narrow else 6.2, 0.9 + 0.36 * max(1, len(shown)))
    figure = Figure(figsize=size, constrained_layout=True)
    axes = figure.subplots()
    for row, (_, cause) in enumerate(shown):
        _draw_share(axes, row, cause["share"], cause.get("interval"), COLORS[REPLAY])
    name_rows(axes, _named_causes(run))
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of the partings" if narrow else "share of the partings, open loop")
    return figure


def causes_have_intervals(run: Run) -> bool:
    return any(cause.get("interval") is not None for _, cause in _causes_of(run))


def _draw_share(
    axes: Any, row: int, share: float, interval: Optional[Sequence[float]], color: str
) -> None:
    axes.barh(row, share, height=0.55, color=color, alpha=0.85)
    if interval is not None:
        axes.plot(interval, [row, row], color=INK, linewidth=2.5, solid_capstyle="butt")


def box(place: Any, size: Dict[str, float], color: str, opacity: Optional[float]) -> Any:
    """A rectangle from its lower left corner: filled, or a frame if `opacity` is None."""
    if opacity is None:
        return Rectangle(place, fill=False, edgecolor=color, linewidth=2, **size)
    return Rectangle(place, facecolor=color, alpha=opacity, edgecolor="none", **size)


def disc(place: Any, radius: float, color: str, opacity: float) -> Any:
    """A disc in the units of the axes."""
    return Circle(tuple(place), radius, facecolor=color, alpha=opacity, edgecolor="none")


def entitle(figure: Any, lines: Sequence[str], size: float) -> None:
    """The title of a figure, in lines that are no wider than it is."""
    width = figure.get_figwidth()
    figure.suptitle("\n".join(fitted(line, width, size) for line in lines), fontsize=size)


def entitle_axes(axes: Any, text: str, size: float) -> None:
    """The title of axes, in lines that are no wider than their share of the figure."""
    across = axes.get_subplotspec().get_gridspec().ncols
    axes.set_title(fitted(text, axes.figure.get_figwidth() / across, size), fontsize=size)


def add_legend(figure: Any, place: str, handles: Dict[str, Any], across: int) -> None:
    """Adds a legend over the whole width, "upper" or "lower", by which the figure grows: handles by
    label, `across` in a line."""
    size = FontProperties(size=matplotlib.rcParams["legend.fontsize"]).get_size_in_points()
    labels = legend_labels(handles, figure.get_figwidth() / across, size)
    lines = [1 + label.count("\n") for label in labels]
    column = -(-len(lines) // across)  # entries; Matplotlib fills columns one by one
    most = max(sum(lines[begin : begin + column]) for begin in range(0, len(lines), column))
    inches = 0.1 + LEGEND_LINE * size / POINTS * most
    figure.set_figheight(figure.get_figheight() + inches)
    share = inches / figure.get_figheight()
    begin = share if place == "lower" else 0.0
    figure.get_layout_engine().set(rect=(0.0, begin, 1.0, 1.0 - share))
    figure.legend(handles.values(), labels, loc=f"{place} center", ncols=across)


def legend_labels(labels: Iterable[str], width: float, size: float) -> List[str]:
    """Labels of a legend with columns of a width [in], in a font of a size [pt]."""
    return [fitted(label, width - LEGEND_HANDLE * size / POINTS, size) for label in labels]


def fitted(text: str, width: float, size: float) -> str:
    """Text in lines of a width [in] at most, in a font of a size [pt]. It is no mathematics."""
    return textwrap.fill(text, int(width * POINTS / (CHARACTER * size))).replace("$", r"\$")


def name_rows(axes: Any, names: Sequence[str]) -> None:
    """Rows from top to bottom, with their names on the left."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(1, len(names)) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0, pad=7, labelcolor=INK)  # a dot may stand at 0
    axes.grid(axis="y", visible=False)
