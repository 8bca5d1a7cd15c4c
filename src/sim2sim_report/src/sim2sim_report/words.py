# SPDX-License-Identifier: BSD-3-Clause
"""Numbers as the commands print them, and the words of the glossary."""

import re
from decimal import Decimal
from pathlib import Path
from typing import Dict, List, Optional, Sequence

import rospkg  # type: ignore[import]
from pusht_task.error import Error, ExitCode
from pusht_task.json_file import Json

RATE_DIGITS, DIVERGENCE_DIGITS = 3, 4  # digits in the table that the commands print
FEWEST_PAIRS = 20  # episodes, below which divergences and differences have no intervals
NOT_SHOWN, TOO_FEW = "(!)", "(?)"  # marks of a divergence beside that of a tee that never moves
WORD_BOUNDS = (0.5, 0.9, 1.1)  # transfers at which the words of the headline change
WORDS = (
    *("Reference", "Closed loop", "Open loop", "Success", "Tolerance", "Transfer", "Divergence"),
    *("Null model", "Floor", "First divergence", "Band", "Holm", "Control step"),
    *("Spawn seed", "Tee"),
)


def glossary() -> List[Dict[str, str]]:
    """The words of docs/glossary.md that a report uses."""
    try:
        package = Path(rospkg.RosPack().get_path("sim2sim_report"))
    except rospkg.ResourceNotFound:
        raise Error(
            "sim2sim_report: not found; source the workspace's setup.bash", ExitCode.BAD_DEPENDENCY
        ) from None
    places = (package / "glossary.md", package.parent.parent / "docs" / "glossary.md")
    path = next((place for place in places if place.exists()), None)
    if path is None:
        raise Error(f"{places[0]}: no such file; it comes with the suite")
    entries = re.findall(
        r"^\*\*(.+?)\*\*([^:]*): (.+?)(?=\n\n|\Z)", path.read_text("utf-8"), re.M | re.S
    )
    meanings = {word: plain(meaning) for word, _, meaning in entries}
    return [{"word": word, "meaning": meanings[word]} for word in WORDS]


def rate(metrics: Json, role: str) -> str:
    ends = interval(metrics[f"{role}_success_interval"], RATE_DIGITS)
    return f"{metrics[f'{role}_success_rate']:.{RATE_DIGITS}f}{ends}"


def figure(
    metrics: Json, key: str, unit: str, *, with_sign: bool = False, with_interval: bool = True
) -> str:
    value = metrics[f"{key}_{unit}"]
    if value is None:
        return "none"  # the word of the commands
    text = signed(value, DIVERGENCE_DIGITS) if with_sign else f"{value:.{DIVERGENCE_DIGITS}f}"
    rest = interval(metrics[f"{key}_interval_{unit}"], DIVERGENCE_DIGITS) if with_interval else ""
    return f"{text} {unit}{rest}"


def transfer_percent(share: float) -> str:
    """A share in per cent with the digits that keep it on its side of each bound: "49.96 %"."""
    text = ""
    for digits in range(5):
        text = f"{100 * share:.{digits}f}"
        shown = float(text) / 100
        if all((shown < end, shown > end) == (share < end, share > end) for end in WORD_BOUNDS):
            break
    return text + " %"


def transfer(metrics: Json) -> str:
    if metrics["transfer"] is None:
        return "undefined, since the policy never succeeds in the reference"
    found = metrics["transfer_interval"]
    ends = ["any" if end is None else transfer_percent(end) for end in found or []]
    return transfer_percent(metrics["transfer"]) + (f" [{', '.join(ends)}]" if ends else "")


def readable(value: float) -> float:
    """The number rounded as metrics.json has it; a figure of that file stays as it is."""
    return round(value, 6) if value == 0 or abs(value) >= 1e-3 else float(f"{value:.6g}")


def signed(value: float, digits: int) -> str:
    return ("+" if value > 0 else "") + f"{readable(value):.{digits}f}"


def interval(found: Optional[Sequence[float]], digits: int) -> str:
    ends = [f"{readable(end):.{digits}f}" for end in found or []]
    return f" [{', '.join(ends)}]" if ends else ""


def in_sentence(title: str) -> str:
    """A simulator's title with its article: "the two-mass engine", "Chipmunk"."""
    kind = title.split(",")[0].split(" with ")[0]  # without parameters
    return f"the {title}" if kind.endswith(" engine") else title


def probability(p: Optional[float]) -> str:
    if p is None:
        return ""
    return "p < 0.0001" if p < 1e-4 else f"p {readable(p):.4f}"


def plain(markdown: str) -> str:
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", markdown).replace("`", "").replace("**", "")
    return " ".join(text.split())


def mark(beats_null: Optional[bool]) -> str:
    """Mark of a divergence that is not shown to be less than that of a tee that never moves."""
    if beats_null is None:
        return " " + TOO_FEW
    return "" if beats_null else " " + NOT_SHOWN


def times(factor: Optional[float], ends: Optional[Sequence[float]]) -> str:
    """Two digits, as the commands print them: "1.3 times", "68 times [9.3, 420]"."""
    if factor is None:
        return "undefined"
    found = [_multiple(end) for end in ends or []]
    return f"{_multiple(factor)} times" + (f" [{', '.join(found)}]" if found else "")


def _multiple(factor: float) -> str:
    return f"{Decimal(f'{factor:.2g}'):f}"  # without an exponent
