# SPDX-License-Identifier: BSD-3-Clause
"""How figures are made: their style, panels, titles and legends, for the page (SVG that follows its
theme) and for papers (PNG, PDF)."""

import functools
import io
import logging
import re
import textwrap
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

from pusht_task.error import Error

from sim2sim_report.colors import DIM, GRID, INK, VARIABLES

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
OWN_STYLE: Dict[str, Any] = {  # of a picture that stands alone
    **STYLE,
    "font.size": 14,
    "axes.labelsize": 15,
    "axes.grid.axis": "y",
    "legend.fontsize": 13,
    "lines.linewidth": 2.2,
    "lines.markersize": 8,
}
MARKERS = "os^DvPX"  # of lines, with the colors of SERIES
POINTS = 72  # of an inch
CHARACTER = 0.62  # width of one in a title or a legend, in font sizes
LEGEND_LINE, LEGEND_HANDLE = 1.57, 4.0  # height of a line, width of a handle, in font sizes
COMPONENTS = (("position", "m"), ("angle", "rad"))

Size = Tuple[float, float]  # width and height


@dataclass(frozen=True)
class Drawing:
    """A figure with its name for files and what it shows, in words. `build` makes the wide figure
    (False) or the narrow one when asked for."""

    name: str
    alt: str
    build: Callable[[bool], Any]
    style: Dict[str, Any] = field(default_factory=lambda: STYLE)

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


def require_picture_format(out: Path) -> None:
    """Refuses a name that does not end with a format of pictures."""
    kinds = FigureCanvasAgg.get_supported_filetypes()
    if out.suffix[1:] not in kinds:
        names = ", ".join(sorted(kinds))
        raise Error(f"out {out}: must end with the name of a format, one of {names}")


def panels(
    narrow: bool,
    shape: Tuple[int, int],
    size: Size,
    panel: Size,
    by_column: bool = False,
    **options: Any,
) -> Tuple[Any, Any]:
    """A figure of a size [in] and its panels by row and column.

    In a narrow figure panels of the size `panel` [in] stand below each other, row by row or column
    by column. `options` are those of Figure.subplots.
    """
    rows, columns = shape
    if narrow:
        size = (panel[0], panel[1] * rows * columns)
        rows, columns = rows * columns, 1
    figure = Figure(figsize=size, constrained_layout=True)
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, axes.reshape(shape, order="F" if by_column else "C")


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


def box(place: Any, size: Dict[str, float], color: str, opacity: Optional[float]) -> Any:
    """A rectangle from its lower left corner: filled, or a frame if `opacity` is None."""
    if opacity is None:
        return Rectangle(place, fill=False, edgecolor=color, linewidth=2, **size)
    return Rectangle(place, facecolor=color, alpha=opacity, edgecolor="none", **size)


def disc(place: Any, radius: float, color: str, opacity: float) -> Any:
    """A disc in the units of the axes."""
    return Circle(tuple(place), radius, facecolor=color, alpha=opacity, edgecolor="none")


def entitle(figure: Any, lines: Sequence[str], size: float) -> None:
    """The title of a figure, in lines that are no wider than it is. Empty lines are left out."""
    width = figure.get_figwidth()
    shown = [fitted(line, width, size) for line in lines if line]
    figure.suptitle("\n".join(shown), fontsize=size)


def entitle_axes(axes: Any, text: str, size: float) -> None:
    """The title of axes, in lines that are no wider than they are."""
    axes.set_title(fitted(text, width_of(axes), size), fontsize=size)


def width_of(axes: Any) -> float:
    """Their share of the figure's width [in]."""
    return axes.figure.get_figwidth() / axes.get_subplotspec().get_gridspec().ncols


def add_legend(figure: Any, place: str, across: int) -> None:
    """Adds a legend of all axes over the whole width, "upper" or "lower", by which the figure
    grows, with `across` entries in a line."""
    handles = labeled(figure.axes)
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


def labeled(all_axes: Iterable[Any]) -> Dict[str, Any]:
    """What has a label, by label."""
    return {
        label: handle
        for axes in all_axes
        for handle, label in zip(*axes.get_legend_handles_labels())
    }


def legend_labels(labels: Iterable[str], width: float, size: float) -> List[str]:
    """Labels of a legend with columns of a width [in], in a font of a size [pt]."""
    return [fitted(label, width - LEGEND_HANDLE * size / POINTS, size) for label in labels]


def fitted(text: str, width: float, size: float) -> str:
    """Text in lines of a width [in] at most, in a font of a size [pt]."""
    return wrapped(text, int(width * POINTS / (CHARACTER * size)))


def wrapped(text: str, width: int) -> str:
    """Text in lines of a width [characters] at most. It is no mathematics.

    A word that is too long breaks behind its signs: "rigid_body:", "preset=shaped".
    """
    lines = textwrap.TextWrapper(width)
    if any(len(word) > width for word in text.split()):
        lines.wordsep_re = re.compile(r"(\s+|(?<=[:=,])(?=\S))")
    return lines.fill(text).replace("$", r"\$")


def name_rows(axes: Any, names: Sequence[str]) -> None:
    """Rows from top to bottom, with their names on the left."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(1, len(names)) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0, pad=7, labelcolor=INK)  # a dot may stand at 0
    axes.grid(axis="y", visible=False)


def name_cells(axes: Any, rows: Sequence[str], columns: Sequence[str], **style: Any) -> None:
    """Rows and columns of cells with their names, whose texts have the style, and without lines."""
    name_rows(axes, rows)
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_xticks(range(len(columns)), columns, **style)
    axes.tick_params(axis="x", length=0, labelcolor=INK)
    axes.grid(visible=False)
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


def draw_interval(
    axes: Any,
    ends: Optional[Sequence[float]],
    at: float,
    scale: float = 1.0,
    upright: bool = False,
    **style: Any,
) -> None:
    """A line between the ends, times a scale, in the row `at`, or upright at that x; none without
    an interval."""
    if ends is not None:
        along, across = [scale * end for end in ends], [at, at]
        axes.plot(*((across, along) if upright else (along, across)), **style)
