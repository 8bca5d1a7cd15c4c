# SPDX-License-Identifier: BSD-3-Clause
"""The page: what results say, in words and figures. It computes nothing; it rounds and arranges."""

import base64
import json
import re
import shlex
import tempfile
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

import jinja2
import numpy as np
import rospkg  # type: ignore[import]
from pusht_task import task
from pusht_task.command import Refusal
from pusht_task.exit_codes import ExitCode

from sim2sim_eval.command import rosrun
from sim2sim_eval.report import figures
from sim2sim_eval.report.attribution import Attribution, read_attribution
from sim2sim_eval.report.attribution import draw as draw_attribution
from sim2sim_eval.report.curves import draw as draw_sweep
from sim2sim_eval.report.figures import COMPONENTS
from sim2sim_eval.report.results import (
    ENGINE,
    KINDS,
    MODES,
    REFERENCE,
    REPLAY,
    Episode,
    Json,
    Run,
    Traces,
    contrast,
    read_json,
    read_sweep,
)

RATE_DIGITS, DIVERGENCE_DIGITS = 3, 4  # as in the table that the commands print
SIGNIFICANT = 0.05  # after Holm
MEANS = (("mean_pos_divergence", "m"), ("mean_ang_divergence", "rad"))  # keys of metrics.json
REANCHORED = "engine_reanchored_"
UNTRAINED = "fresh-untrained"
FEWEST_PAIRS = 20  # episodes, below which shares have no intervals
MOST_ANIMATED = 200  # episodes, unless more are asked for
CONTRASTED = {
    "engine_success_rate": ("success rate", RATE_DIGITS),
    "mean_pos_divergence_m": ("position divergence", DIVERGENCE_DIGITS),
    "mean_ang_divergence_rad": ("angle divergence", DIVERGENCE_DIGITS),
}
WORDS = (
    *("Reference", "Closed loop", "Open loop", "Success", "Tolerance", "Transfer", "Divergence"),
    *("Null model", "Floor", "Parting", "Band", "Holm", "Control step", "Spawn seed", "Tee"),
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
        self.environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "sort_keys": True}
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
            headline=(
                comparison(contrasts, runs[0].name) if contrasts else verdict(runs[0])["headline"]
            ),
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
        rows = read_sweep(folder)["rows"]
        curves, pairs = draw_sweep(folder)
        with tempfile.TemporaryDirectory() as scratch:
            out = Path(scratch, "contrast.json")
            rosrun("contrast", str(folder), "--against", "0", "--out", str(out))
            contrasts = read_json(out)
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            headline=comparison(contrasts["contrasts"], contrasts["baseline"]["title"]),
            rates=None,
            contrasts=[_contrast(c) for c in contrasts["contrasts"]],
            baseline=contrasts["baseline"]["title"],
            runs=[],
            sweep={
                "curves": curves,
                "pairs": pairs,
                "summary": _sweep_summary(rows[0]),
                "rows": [_sweep_row(row) for row in rows],
                "caution": CAUTION,
            },
        )

    def of_attribution(self, folder: Path) -> str:
        """A sweep over switches of which the cause of the gap is known."""
        attribution = read_attribution(folder)
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            headline=cause(attribution),
            rates=None,
            contrasts=[],
            baseline="",
            runs=[],
            sweep=None,
            attribution=_attribution(attribution),
        )

    def _render(self, **context: Any) -> str:
        context.setdefault("attribution", None)
        return self.environment.get_template("page.html.j2").render(**self.shared, **context)


def glossary() -> List[Dict[str, str]]:
    """The words of docs/glossary.md that a report uses."""
    try:
        package = Path(rospkg.RosPack().get_path("sim2sim_eval"))
    except rospkg.ResourceNotFound:
        raise Refusal(
            "sim2sim_eval: not found; source the workspace's setup.bash", ExitCode.BAD_DEPENDENCY
        ) from None
    places = (package / "glossary.md", package.parent.parent / "docs" / "glossary.md")
    path = next((place for place in places if place.exists()), None)
    if path is None:
        raise Refusal(f"{places[0]}: no such file; it comes with the suite")
    entries = re.findall(
        r"^\*\*(.+?)\*\*([^:]*): (.+?)(?=\n\n|\Z)", path.read_text("utf-8"), re.M | re.S
    )
    meanings = {word: _plain(meaning) for word, _, meaning in entries}
    return [{"word": word, "meaning": meanings[word]} for word in WORDS]


def verdict(run: Run) -> Dict[str, Any]:
    """What the figures say in a line, in sentences, and what they do not say."""
    m = run.metrics
    reference, engine = run.title("reference"), run.name
    difference = m["success_difference_interval"]
    mean_position = _figure(m, "mean_pos_divergence", "m")
    mean_angle = _figure(m, "mean_ang_divergence", "rad")
    null_position = _figure(m, f"{REPLAY}_null_position_divergence", "m", interval=False)
    null_angle = _figure(m, f"{REPLAY}_null_angle_divergence", "rad", interval=False)
    sentences = [
        f"In closed loop, policy {m['policy']} succeeds in {_rate(m, 'reference')} of "
        f"{m['episodes']} episodes in {reference} and in {_rate(m, 'engine')} of the same episodes "
        f"in {engine}: {_signed(m['success_difference'], RATE_DIGITS)}"
        f"{_interval(difference, RATE_DIGITS)}, McNemar {_probability(m['success_difference_p'])}. "
        f"Transfer: {_transfer(m)}.",
        f"Given the exact actions of {reference}, the tee in {engine} is {mean_position} and "
        f"{mean_angle} from where it is in {reference}, on average over the episode. A tee that "
        f"never moves would be {null_position} and {null_angle} away.",
    ]
    if "decision" in m:
        sentences.insert(0, _decision(m, engine))
    return {
        "headline": _headline(m, reference, engine),
        "sentences": sentences + _doubts(m),
        "caution": _caution(m, reference),
    }


def comparison(contrasts: Sequence[Json], baseline: str) -> str:
    """What the pairs say of success, in a line. It names one or two, and counts more."""
    more: List[str] = []
    less: List[str] = []
    alike: List[str] = []
    for pair in contrasts:
        success = pair["figures"]["engine_success_rate"]
        found = (more if success["difference"] > 0 else less) if _is_finding(success) else alike
        found.append(pair["title"])

    def several(names: Sequence[str]) -> str:
        if len(names) < 3:
            return " and ".join(names)
        return f"all {len(names)}" if len(names) == len(contrasts) else f"{len(names)} others"

    def succeed(names: Sequence[str], how: str) -> List[str]:
        verb = "succeeds" if len(names) == 1 else "succeed"
        return [f"{several(names)} {verb} {how} often than {baseline}"] if names else []

    clauses = succeed(more, "more") + succeed(less, "less")
    if alike:
        clauses.append(f"no difference from {baseline} in success is shown of {several(alike)}")
    line = "; ".join(clauses) or f"Only {baseline}: nothing to compare it with"
    return line[0].upper() + line[1:]


def cause(attribution: Attribution) -> str:
    """Who closes most of the gap in position, in open loop."""
    gap = attribution.gaps("position")[0]
    if gap["all_off"] <= gap["all_on"]:
        return "Together the switches close no gap"
    ranked = attribution.ranked(gap)[:3]
    most = [f"{name} {100 * part:.0f}\u00a0%" for name, part in ranked if part > 0]
    return f"What closes the gap in position: {', '.join(most)}"


def _attribution(attribution: Attribution) -> Json:
    content = attribution.content
    position = attribution.gaps("position")[0]
    angle = attribution.gaps("angle")[0]
    success = attribution.success
    return {
        "sentences": [
            f"{content['engine']} against {content['reference']}, policy {content['policy']}, "
            f"{content['episodes']} episodes, {_combinations(attribution)}.",
            f"In open loop the tees are {position['all_off']:.4f} m and {angle['all_off']:.4f} rad "
            f"apart with all switches off, and {position['all_on']:.4f} m and "
            f"{angle['all_on']:.4f} rad with all on. In closed loop the engine lacks "
            f"{success['all_off']:.3f} of success with all off, and {success['all_on']:.3f} with "
            "all on.",
        ],
        "drawings": draw_attribution(attribution),
        "exact": attribution.is_exact,
        "few": content["episodes"] < FEWEST_PAIRS,
        "gaps": [_gap_table(attribution, content["gaps"][name]) for name in content["order"]],
        "pairs": [
            {
                "title": gap["title"],
                "rows": [
                    {
                        "names": " and ".join(pair["switches"]),
                        "value": f"{_signed(pair['value'], DIVERGENCE_DIGITS)} {gap['unit']}"
                        f"{_interval(pair['interval'], DIVERGENCE_DIGITS)}",
                    }
                    for pair in sorted(gap["interactions"], key=lambda p: -abs(p["value"]))[:5]
                ],
            }
            for gap in (position, angle)
            if gap["interactions"]
        ],
        "caution": [
            "A share depends on the horizon, and on what a switch means while others are off "
            "(docs/ladder.md).",
            "Closed loops are chaotic: simulators that agree in all but the last bit may differ in "
            "success.",
            *CAUTION,
        ],
    }


def _combinations(attribution: Attribution) -> str:
    content = attribution.content
    count = len(attribution.switches)
    switches = f"{count} switch{'' if count == 1 else 'es'}"
    if attribution.is_exact:
        return f"every one of {content['combinations']} combinations of {switches}"
    orders = f"along {content['orders']} random orders of switching on"
    return f"{content['combinations']} combinations of {switches}, {orders}"


def _gap_table(attribution: Attribution, gap: Json) -> Json:
    rows = []
    for name in attribution.switches:
        found = gap["switches"][name]
        part = found["part"]
        rows.append(
            {
                "name": name,
                "cells": [
                    _signed(found["share"], DIVERGENCE_DIGITS)
                    + _interval(found["share_interval"], DIVERGENCE_DIGITS),
                    "" if part is None else f"{100 * part:.0f} %",
                    *(
                        _signed(found[effect]["value"], DIVERGENCE_DIGITS)
                        for effect in ("alone", "leave_one_out")
                        if attribution.is_exact
                    ),
                ],
            }
        )
    return {"title": gap["title"], "unit": gap["unit"], "rows": rows}


def _headline(m: Json, reference: str, engine: str) -> str:
    rates = (
        f"{m['reference_success_rate']:.{RATE_DIGITS}f} of the episodes succeed in {reference}, "
        f"{m['engine_success_rate']:.{RATE_DIGITS}f} in {engine}"
    )
    if m["reference_successes"] == 0:
        return f"Nothing to transfer: the policy never succeeds in {reference}"
    difference = m["success_difference_interval"]
    if difference is None:
        return f"Too few episodes to tell: {rates}"
    if difference[1] < 0:
        kept = "only in part" if m["engine_successes"] else "not at all"
        return f"The skill transfers {kept}: {rates}"
    if difference[0] > 0:
        return f"The skill transfers, and more: {rates}"
    return f"No loss of skill is shown: {rates}"


def _decision(m: Json, engine: str) -> str:
    decision = m["decision"]
    kept = f"{100 * decision['share']:.0f} % of the success in the reference"
    if decision["episodes"] is None:
        return f"It was not decided after {m['episodes']} episodes whether {engine} keeps {kept}."
    return f"Decided after {decision['episodes']} episodes: {engine} {decision['verdict']} {kept}."


def _doubts(m: Json) -> List[str]:
    """What each divergence does not show."""
    doubts = []
    for (name, _), (key, unit) in zip(COMPONENTS, MEANS):
        beats = m[f"{key}_beats_null"]
        interval = m[f"{key}_minus_null_interval_{unit}"]
        if beats is None:
            doubts.append(f"(!) In {name} there are too few episodes to tell it from that tee.")
        elif not beats and interval[0] > 0:
            doubts.append(f"(!) In {name} it is further away than that tee.")
        elif not beats:
            doubts.append(f"(!) In {name} it is not shown to be nearer than that tee.")
    return doubts


def _caution(m: Json, reference: str) -> List[str]:
    caution = list(CAUTION)
    if "decision" in m:
        caution.insert(
            0,
            "The run ended when it was decided. The intervals are those of a run of fixed length, "
            "and hold less often here.",
        )
    if m["policy"] == UNTRAINED:
        caution.insert(0, "The policy is untrained: success and transfer say nothing.")
    elif m["reference_successes"] == 0:
        caution.insert(
            0,
            f"The policy never succeeds in {reference}. A trained one does: is this the right "
            "checkpoint, and is its normalisation inside?",
        )
    return caution


def command_of(run: Run) -> str:
    """The command that makes the run again; one over nodes is made by its launch file."""
    c = run.provenance["configuration"]
    live = "nodes" in run.provenance
    program = ("roslaunch", "compare.launch") if live else ("rosrun", "compare")
    words = [program[0], "sim2sim_eval", program[1]]

    def add(name: str, value: Any) -> None:
        text = value if isinstance(value, str) else json.dumps(value)
        if live:
            words.append(f"{name}:={text}")
        else:
            words.extend([f"--{name.replace('_', '-')}", text])

    for name in ("policy", "episodes", "first_episode"):
        add(name, c[name])
    add(*(("starts", "STARTS.csv") if "starts" in c else ("seed", c["seed"])))
    for role, option in (("reference", "--set-reference"), ("engine", "--set")):
        simulator = c["simulators"][role]
        add(role, simulator["name"])
        values = {name: _given(run, role, name) for name in simulator["changed"]}
        settings = [f"{k}={v if isinstance(v, str) else json.dumps(v)}" for k, v in values.items()]
        if live and settings:
            add(f"{role}_parameters", " ".join(settings))
        for setting in [] if live else settings:
            words.extend([option, setting])
    anchors = [p[len(REANCHORED) :] for p in c["probes"] if p.startswith(REANCHORED)]
    if anchors:
        add("reanchor", ",".join(anchors))
    if not any(p.startswith("floor_") for p in c["probes"]):
        words.append("floor:=false" if live else "--no-floor")
    add("bound_position", c["bound"]["position_m"])
    add("bound_angle", c["bound"]["angle_rad"])
    if c.get("until_decided"):
        add("until_decided", c["until_decided"])
    if live:
        add("horizon", c["horizon"])
    if c["smoke"]:
        words = words[:3] + ["smoke:=true" if live else "--smoke"]
    return " ".join(shlex.quote(word) for word in words)


def _given(run: Run, role: str, parameter: str) -> Any:
    """What the parameter was set to: where results have a file's checksum, that is its name."""
    value = run.provenance["configuration"]["simulators"][role]["parameters"][parameter]
    if not str(value).startswith("sha256:"):
        return value
    return run.provenance[role][parameter].get("file", value)


def notes_on_command(run: Run) -> List[str]:
    """What the command alone does not bring."""
    c = run.provenance["configuration"]
    notes = []
    if "starts" in c:
        notes.append("STARTS.csv is the text under starts in the provenance.")
    if "nodes" in run.provenance:
        notes.append("The provenance names the nodes. Those of others must be started again, too.")
    for role, simulator in c["simulators"].items():
        for name in simulator["changed"]:
            given, value = _given(run, role, name), simulator["parameters"][name]
            if given != value:
                notes.append(f"{name} {given} had the checksum {value}.")
    return notes


def _sweep_summary(row: Json) -> str:
    reference = row["simulators"]["reference"]["title"]
    starts = "given starts" if "starts" in row else f"seed {row['seed']}"
    return (
        f"Policy {row['policy']}, {row['episodes']} episodes for every row, {starts}. In "
        f"{reference}, the reference of all rows, it succeeds in {_rate(row, 'reference')}."
    )


def _sweep_row(row: Json) -> Json:
    engine = row["simulators"]["engine"]
    values = ", ".join(f"{name} {engine['parameters'][name]}" for name in engine["changed"])
    return {
        "engine": engine["title"],
        "changed": values or "as shipped",
        "success": _rate(row, "engine"),
        "divergences": _means(row),
    }


def _means(metrics: Json) -> List[str]:
    """The mean divergences, marked where they do not surely beat the null model."""
    marks = ["" if metrics[f"{key}_beats_null"] is True else " (!)" for key, _ in MEANS]
    return [_figure(metrics, *mean) + mark for mean, mark in zip(MEANS, marks)]


def _section(run: Run, number: int, traces: Optional[Traces], animate: Sequence[int]) -> Json:
    animated = _animated(run, animate)
    player = None
    if traces is not None:
        player = {
            "titles": {"reference": run.title("reference"), "engine": run.name},
            "bound": run.metrics["bound"],
            "first": run.first_of_each_kind(),
            "episodes": [_animation(e, traces) for e in run.episodes if e.index in animated],
        }
    return {
        "id": f"run{number}",
        "folder": run.folder.resolve().name,
        "reference": run.title("reference"),
        "engine": run.name,
        "metrics": run.metrics,
        "verdict": verdict(run),
        "divergences": _divergences(run),
        "drawings": figures.draw(run, f"run{number}-"),
        "parting": _parting(run),
        "parameters": _parameters(run),
        "provenance": json.dumps(run.provenance, indent=2, sort_keys=True),
        "command": command_of(run),
        "notes": notes_on_command(run),
        "animated": len(animated),
        "player": player,
        "table": [_row(e) for e in run.episodes],
    }


def _animated(run: Run, asked: Sequence[int]) -> List[int]:
    """Of a large run: the first ones, those that are asked for, and one of each kind."""
    known = [episode.index for episode in run.episodes]
    for index in asked:
        if index not in known:
            raise Refusal(f"animate {index}: must be from {known[0]} to {known[-1]}")
    return sorted({*known[:MOST_ANIMATED], *asked, *run.first_of_each_kind()})


def _animation(episode: Episode, traces: Traces) -> Json:
    states = {mode: _packed(traces[episode.index, mode]) for mode in MODES}
    return {"episode": episode.index, "kind": episode.kind, "states": states}


def _packed(trace: Any) -> str:
    """Seven float32 of every state; the last action, which there is none of, is 0."""
    names = ("pusher_x", "pusher_y", "tee_x", "tee_y", "tee_yaw", "action_x", "action_y")
    table = np.stack([np.nan_to_num(trace[name]) for name in names], axis=1)
    return base64.b64encode(table.astype("<f4").tobytes()).decode("ascii")


def _row(episode: Episode) -> List[Any]:
    reference, engine, replay = (episode.modes[mode] for mode in MODES)

    def number(text: str) -> Optional[float]:
        return round(float(text), DIVERGENCE_DIGITS) if text else None

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


def _divergences(run: Run) -> List[Json]:
    """The lines of the table that the commands print, as they print them."""
    m = run.metrics

    def line(head: str, quantities: Sequence[Any], **style: Any) -> Json:
        return {"head": head, "cells": [_figure(m, key, unit, **style) for key, unit in quantities]}

    lines = [{"head": "mean", "cells": _means(m)}]
    lines.append(line("median", [(f"{key}_median", unit) for key, unit in MEANS]))
    less_null = [(f"{key}_minus_null", unit) for key, unit in MEANS]
    lines.append(line("less null model", less_null, signed=True))
    factors = [m[f"{key}_over_floor"] for key, _ in MEANS]
    if factors[0] is not None:
        cells = ["undefined" if f is None else f"{f:.2g} times" for f in factors]
        lines.append({"head": "over the floor (1e-6 m)", "cells": cells})
    absorbed = [(f"{ENGINE}_absorbed_{name}_divergence", unit) for name, unit in COMPONENTS]
    lines.append(line("less in closed loop", absorbed, signed=True))
    for probe in m["probes"]:
        every = probe[len(REANCHORED) :] if probe.startswith(REANCHORED) else None
        if every:
            errors = [(f"{probe}_anchor_{name}_error", unit) for name, unit in COMPONENTS]
            lines.append(line(f"made in {every} step{'' if every == '1' else 's'}", errors))
    return lines


def _parting(run: Run) -> str:
    m = run.metrics
    bound = f"{m['bound']['position_m']:g} m or {m['bound']['angle_rad']:g} rad"
    parted = f"In open loop {m['parted']} of {m['episodes']} episodes leave the bound of {bound}"
    median = m["median_parting_step"]
    if median is None:
        return f"{parted}."
    return f"{parted}. Half of all have left it by {median * task.CONTROL_STEP:.1f} s."


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
                "finding": _is_finding(figure),
            }
        )
    return {"title": content["title"], "rows": rows}


def _is_finding(figure: Json) -> bool:
    return figure["adjusted_p"] is not None and figure["adjusted_p"] <= SIGNIFICANT


def _rate(metrics: Json, role: str) -> str:
    interval = _interval(metrics[f"{role}_success_interval"], RATE_DIGITS)
    return f"{metrics[f'{role}_success_rate']:.{RATE_DIGITS}f}{interval}"


def _figure(
    metrics: Json, key: str, unit: str, *, signed: bool = False, interval: bool = True
) -> str:
    value = metrics[f"{key}_{unit}"]
    if value is None:
        return "none"  # as the commands say it
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


_GEOMETRY = {
    "barHalfLength": task.BAR_HALF_LENGTH,
    "stemHalfLength": task.STEM_HALF_LENGTH,
    "halfWidth": task.TEE_HALF_WIDTH,
    "stemOffset": task.STEM_OFFSET,
    "pusherRadius": task.PUSHER_RADIUS,
    "wall": task.WALL_INNER_FACE,
    "controlStep": task.CONTROL_STEP,
}
