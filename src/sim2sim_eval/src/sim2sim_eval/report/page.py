# SPDX-License-Identifier: BSD-3-Clause
"""The page: what results say, in words and figures. It computes nothing; it rounds and arranges."""

import base64
import json
import re
import shlex
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

import jinja2
import numpy as np
import rospkg  # type: ignore[import]
from pusht_task import task

from sim2sim_eval.report import figures
from sim2sim_eval.report.results import (
    ENGINE,
    KINDS,
    MODES,
    REFERENCE,
    REPLAY,
    Json,
    Refusal,
    Run,
    Traces,
    contrast,
    rosrun,
)

RATE_DIGITS, DIVERGENCE_DIGITS = 3, 4  # as in the table that the commands print
LENGTH_UNIT, ANGLE_UNIT, SPEED_UNIT = 1e-4, 1e-4, 1e-4  # [m, rad, m/s] of one step of an int16
MOST_ANIMATED = 200  # episodes, unless more are asked for
CONTRASTED = {
    "engine_success_rate": ("success rate", RATE_DIGITS),
    "mean_pos_divergence_m": ("position divergence", DIVERGENCE_DIGITS),
    "mean_ang_divergence_rad": ("angle divergence", DIVERGENCE_DIGITS),
}
WORDS = (
    *("Reference", "Closed loop", "Open loop", "Success", "Tolerance", "Transfer", "Divergence"),
    *("Null model", "Floor", "Parting", "Band", "Control step", "Spawn seed", "Tee"),
)
CAUTION = [
    "Neither simulator is the truth. The gap says how far they agree, not which of them is right.",
    "Intervals speak of further starts like these, under this policy. They say nothing of others.",
]


class Page:
    """Templates and what every page shares."""

    def __init__(self) -> None:
        here = Path(__file__).parent
        self.environment = jinja2.Environment(
            autoescape=True,
            loader=jinja2.FileSystemLoader(str(here)),
            trim_blocks=True,
            lstrip_blocks=True,
            undefined=jinja2.StrictUndefined,
        )
        self.environment.filters["signed"] = _signed
        self.shared = {
            "css": jinja2.utils.markupsafe.Markup((here / "page.css").read_text("utf-8")),
            "script": jinja2.utils.markupsafe.Markup((here / "page.js").read_text("utf-8")),
            "words": glossary(),
            "geometry": _GEOMETRY,
        }

    def of_runs(
        self, runs: Sequence[Run], traces: Sequence[Optional[Traces]], animate: Sequence[int]
    ) -> str:
        """One run, or several over the same episodes; the first is what the others are held to."""
        contrasts = contrast(runs[0], runs[1:]) if len(runs) > 1 else []
        engines = runs[0].name if len(runs) == 1 else f"{len(runs)} engines, pair by pair"
        title = f"{runs[0].title('reference')} to {engines}"
        return self._render(
            title=title,
            rates=figures.draw_rates(runs),
            contrasts=[_contrast(c) for c in contrasts],
            baseline=runs[0].name,
            runs=[
                _section(run, number, shown, animate)
                for number, (run, shown) in enumerate(zip(runs, traces))
            ],
            sweep=None,
        )

    def of_sweep(self, folder: Path) -> str:
        """Curves over every parameter that varies, and every row against the first."""
        with tempfile.TemporaryDirectory() as scratch:
            curves = _plot_sweep(folder, Path(scratch, "curves.svg"))
            pairs = _plot_sweep(folder, Path(scratch, "pairs.svg"), "--against", "0")
            out = Path(scratch, "contrast.json")
            rosrun("contrast", str(folder), "--against", "0", "--out", str(out))
            contrasts = json.loads(out.read_text(encoding="utf-8"))
        rows = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))["rows"]
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            rates=None,
            contrasts=[_contrast(c) for c in contrasts["contrasts"]],
            baseline="row 0",
            runs=[],
            sweep={"curves": curves, "pairs": pairs, "rows": rows},
        )

    def _render(self, **context: Any) -> str:
        return self.environment.get_template("page.html.j2").render(**self.shared, **context)


def glossary() -> List[Dict[str, str]]:
    """The words of docs/glossary.md that a report uses."""
    package = Path(rospkg.RosPack().get_path("sim2sim_eval"))
    places = (package / "glossary.md", package.parent.parent / "docs" / "glossary.md")
    path = next((place for place in places if place.exists()), None)
    if path is None:
        raise Refusal(f"{places[0]}: no such file; it comes with the suite")
    entries = re.findall(
        r"^\*\*(.+?)\*\*([^:]*): (.+?)(?=\n\n|\Z)", path.read_text("utf-8"), re.M | re.S
    )
    meanings = {word: _plain(meaning) for word, _, meaning in entries}
    return [{"word": w, "meaning": meanings[w]} for w in WORDS if w in meanings]


def verdict(run: Run) -> Dict[str, Any]:
    """What the figures say in a line, in sentences, and what they do not say."""
    m = run.metrics
    reference, engine = run.title("reference"), run.name
    difference = m["success_difference_interval"]
    rates = (
        f"{m['reference_success_rate']:.{RATE_DIGITS}f} of the episodes succeed in {reference}, "
        f"{m['engine_success_rate']:.{RATE_DIGITS}f} in {engine}"
    )
    if difference is None:
        headline = f"Too few episodes to tell: {rates}"
    elif difference[1] < 0:
        headline = f"The skill transfers only in part: {rates}"
    elif difference[0] > 0:
        headline = f"The skill transfers, and more: {rates}"
    else:
        headline = f"No loss of skill is shown: {rates}"
    mean_position = _figure(m, "mean_pos_divergence", "m")
    mean_angle = _figure(m, "mean_ang_divergence", "rad")
    null_position = _figure(m, f"{REPLAY}_null_position_divergence", "m", interval=False)
    null_angle = _figure(m, f"{REPLAY}_null_angle_divergence", "rad", interval=False)
    sentences = [
        f"In closed loop, policy {m['policy']} succeeds in {_rate(m, 'reference')} of "
        f"{m['episodes']} episodes in {reference} and in {_rate(m, 'engine')} of the same episodes "
        f"in {engine}: {_signed(m['success_difference'], RATE_DIGITS)}"
        f"{_interval(difference, RATE_DIGITS)}, {_probability(m['success_difference_p'])}. "
        f"Transfer: {_transfer(m)}.",
        f"Given the actions that {reference} saw, the tee in {engine} is {mean_position} and "
        f"{mean_angle} from where it is in {reference}, on average over the episode. A tee that never "
        f"moves would be {null_position} and {null_angle} away.",
    ]
    doubts = [
        name
        for name, key in (("position", "mean_pos_divergence"), ("angle", "mean_ang_divergence"))
        if m[f"{key}_beats_null"] is not True
    ]
    if doubts:
        sentences.append(
            f"(!) In {' and '.join(doubts)} the engine is not surely better than that tee: it "
            "predicts nothing there over whole episodes."
        )
    caution = list(CAUTION)
    if m["smoke"]:
        caution.insert(
            0, "This is a smoke run of an untrained policy: it only shows that all works."
        )
    return {"headline": headline, "sentences": sentences, "caution": caution}


def command_of(run: Run) -> str:
    """The command that makes the run again. A run over nodes is made by its launch file."""
    c = run.provenance["configuration"]
    words = ["rosrun", "sim2sim_eval", "compare"]
    if c["smoke"]:
        return " ".join([*words, "--smoke"])
    words += ["--policy", str(c["policy"]), "--episodes", str(c["episodes"])]
    if c["first_episode"]:
        words += ["--first-episode", str(c["first_episode"])]
    words += ["--starts", "STARTS.csv"] if "starts" in c else ["--seed", str(c["seed"])]
    for role, option in (("reference", "--set-reference"), ("engine", "--set")):
        simulator = c["simulators"][role]
        words += [f"--{role}", simulator["name"]]
        for name in simulator["changed"]:
            words += [option, f"{name}={simulator['parameters'][name]}"]
    anchors = [p.rsplit("_", 1)[1] for p in c["probes"] if p.startswith("engine_reanchored_")]
    if anchors:
        words += ["--reanchor", ",".join(anchors)]
    if not any(p.startswith("floor_") for p in c["probes"]):
        words.append("--no-floor")
    words += ["--bound-position", f"{c['bound']['position_m']:g}"]
    words += ["--bound-angle", f"{c['bound']['angle_rad']:g}"]
    return " ".join(shlex.quote(word) for word in words)


def _section(run: Run, number: int, traces: Optional[Traces], animate: Sequence[int]) -> Json:
    m = run.metrics
    animated = _animated(run, animate) if traces is not None else []
    return {
        "id": f"run{number}",
        "name": run.name,
        "reference": run.title("reference"),
        "engine": run.name,
        "folder": run.folder.resolve().name,
        "metrics": m,
        "verdict": verdict(run),
        "figures": _figures(run),
        "drawings": figures.draw(run, f"run{number}-"),
        "parting": _parting(run),
        "parameters": _parameters(run),
        "provenance": json.dumps(run.provenance, indent=2, sort_keys=True),
        "command": command_of(run),
        "first": run.first_of_each_kind(),
        "animated": len(animated),
        "player": {
            "titles": {"reference": run.title("reference"), "engine": run.name},
            "bound": m["bound"],
            "first": [i for i in run.first_of_each_kind() if i in animated],
            "episodes": [_animation(e, traces) for e in run.episodes if e.index in animated],
        }
        if traces is not None
        else None,
        "table": [_row(e) for e in run.episodes],
    }


def _animated(run: Run, asked: Sequence[int]) -> List[int]:
    """Of a large run: the first ones, those that are asked for, and one of each kind."""
    known = [episode.index for episode in run.episodes]
    for index in asked:
        if index not in known:
            raise Refusal(f"animate {index}: must be from {known[0]} to {known[-1]}")
    return sorted({*known[:MOST_ANIMATED], *asked, *run.first_of_each_kind()})


def _animation(episode: Any, traces: Optional[Traces]) -> Json:
    assert traces is not None
    states = {mode: _packed(traces[episode.index, mode]) for mode in MODES}
    return {"episode": episode.index, "kind": episode.kind, "states": states}


def _packed(trace: Any) -> str:
    """Five numbers and the action of every state, as int16."""
    columns = [(name, LENGTH_UNIT) for name in ("pusher_x", "pusher_y", "tee_x", "tee_y")]
    columns += [("tee_yaw", ANGLE_UNIT), ("action_x", SPEED_UNIT), ("action_y", SPEED_UNIT)]
    limit = np.iinfo(np.int16).max
    table = np.stack([np.nan_to_num(trace[name]) / unit for name, unit in columns], axis=1)
    steps = np.clip(np.rint(table), -limit, limit).astype("<i2")
    return base64.b64encode(steps.tobytes()).decode("ascii")


def _row(episode: Any) -> List[Any]:
    reference, engine, replay = (episode.modes[mode] for mode in MODES)
    number = lambda text: float(f"{float(text):.4f}") if text else None  # noqa: E731
    return [
        episode.index,
        reference.get("seed", ""),
        list(KINDS.values()).index(episode.kind),
        episode.steps(REFERENCE),
        episode.steps(ENGINE),
        number(replay["mean_position_divergence_m"]),
        number(replay["mean_angle_divergence_rad"]),
        int(replay["parting_step"]) if replay["parting_step"] else None,
        replay["parting_cause"].replace("_", " "),
    ]


def _figures(run: Run) -> List[Json]:
    """The lines of the table that the commands print, as they print them."""
    m = run.metrics
    lines = [
        {"head": "success, closed loop", "cells": [_rate(m, "reference"), _rate(m, "engine")]},
    ]
    names = {"mean": "", "median": "_median", "less null model": "_minus_null"}
    divergences = []
    for name, suffix in names.items():
        cells = []
        for key, unit in (("mean_pos_divergence", "m"), ("mean_ang_divergence", "rad")):
            text = _figure(m, key + suffix, unit, signed=suffix == "_minus_null")
            doubted = name == "mean" and m[f"{key}_beats_null"] is not True
            cells.append(text + (" (!)" if doubted else ""))
        divergences.append({"head": name, "cells": cells})
    return [{"success": lines, "divergence": divergences}]


def _parting(run: Run) -> str:
    m = run.metrics
    median = m["median_parting_step"]
    half = "" if median is None else f", half of them by {median * task.CONTROL_STEP:.1f} s"
    bound = f"{m['bound']['position_m']:g} m or {m['bound']['angle_rad']:g} rad"
    return f"{m['parted']} of {m['episodes']} episodes leave the bound of {bound}{half}."


def _parameters(run: Run) -> List[Json]:
    rows = []
    for role in ("reference", "engine"):
        simulator = run.metrics["simulators"][role]
        for name, value in simulator["parameters"].items():
            rows.append(
                {
                    "simulator": simulator["title"],
                    "name": name,
                    "value": value,
                    "unit": simulator["units"].get(name, ""),
                    "changed": name in simulator["changed"],
                }
            )
    return rows


def _contrast(content: Json) -> Json:
    rows = []
    for key, (name, digits) in CONTRASTED.items():
        figure = content["figures"].get(key)
        if figure is None:
            continue
        text = _signed(figure["difference"], digits) + (
            f" {figure['unit']}" if figure["unit"] else ""
        )
        rows.append(
            {
                "name": name,
                "difference": text + _interval(figure["interval"], digits),
                "p": _probability(figure["p"]),
                "adjusted": _probability(figure["adjusted_p"]),
                "finding": figure["adjusted_p"] is not None
                and figure["adjusted_p"] <= 1.0 - _CONFIDENCE,
            }
        )
    return {"title": content["title"], "rows": rows}


def _plot_sweep(folder: Path, out: Path, *arguments: str) -> Any:
    process = subprocess.run(
        ["rosrun", "sim2sim_eval", "plot_sweep", str(folder), "--out", str(out), *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    if process.returncode != 0:
        raise Refusal(process.stderr.strip().splitlines()[-1], process.returncode)
    svg = out.read_text(encoding="utf-8")
    return svg[svg.index("<svg") :]


def _rate(metrics: Json, role: str) -> str:
    interval = _interval(metrics[f"{role}_success_interval"], RATE_DIGITS)
    return f"{metrics[f'{role}_success_rate']:.{RATE_DIGITS}f}{interval}"


def _figure(
    metrics: Json, key: str, unit: str, *, signed: bool = False, interval: bool = True
) -> str:
    value = metrics[f"{key}_{unit}"]
    if value is None:
        return "none"
    text = _signed(value, DIVERGENCE_DIGITS) if signed else f"{value:.{DIVERGENCE_DIGITS}f}"
    rest = _interval(metrics[f"{key}_interval_{unit}"], DIVERGENCE_DIGITS) if interval else ""
    return f"{text} {unit}{rest}"


def _transfer(metrics: Json) -> str:
    if metrics["transfer"] is None:
        return "undefined, since the policy never succeeds in the reference"
    interval = metrics["transfer_interval"]
    ends = (
        [] if interval is None else ["any" if e is None else f"{100 * e:.0f} %" for e in interval]
    )
    return f"{100 * metrics['transfer']:.0f} %" + (f" [{', '.join(ends)}]" if ends else "")


def _readable(value: float) -> float:
    """As in metrics.json; its figures stay as they are."""
    return round(value, 6) if value == 0 or abs(value) >= 1e-3 else float(f"{value:.6g}")


def _signed(value: float, digits: int) -> str:
    return ("+" if value > 0 else "") + f"{_readable(value):.{digits}f}"


def _interval(interval: Optional[Sequence[float]], digits: int) -> str:
    ends = [f"{_readable(end):.{digits}f}" for end in interval or []]
    return f" [{', '.join(ends)}]" if ends else ""


def _probability(p: Optional[float]) -> str:
    if p is None:
        return ""
    return "p < 0.0001" if p < 1e-4 else f"p {_readable(p):.4f}"


def _plain(markdown: str) -> str:
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", markdown).replace("`", "").replace("**", "")
    return " ".join(text.split())


_CONFIDENCE = 0.95
_GEOMETRY = {
    "barHalfLength": task.BAR_HALF_LENGTH,
    "stemHalfLength": task.STEM_HALF_LENGTH,
    "halfWidth": task.TEE_HALF_WIDTH,
    "stemOffset": task.STEM_OFFSET,
    "pusherRadius": task.PUSHER_RADIUS,
    "wall": task.WALL_INNER_FACE,
    "controlStep": task.CONTROL_STEP,
    "units": [LENGTH_UNIT, ANGLE_UNIT, SPEED_UNIT],
}
