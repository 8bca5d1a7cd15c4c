# SPDX-License-Identifier: BSD-3-Clause
"""The page: what results say, in words and figures. It computes nothing; it rounds and arranges."""

import json
from pathlib import Path
from typing import Any, List, Optional, Sequence

import jinja2
from pusht_task import task
from pusht_task.command import Refusal

from sim2sim_report import colors, figures
from sim2sim_report.again import REANCHORED, command_of, notes_on_command
from sim2sim_report.animation import GEOMETRY, animated, player, poster
from sim2sim_report.attribution import read_attribution
from sim2sim_report.cause import section as attribution_section
from sim2sim_report.curves import draw as draw_sweep
from sim2sim_report.figures import COMPONENTS
from sim2sim_report.results import (
    ENGINE,
    KINDS,
    MODES,
    QUESTION,
    REFERENCE,
    REPLAY,
    Episode,
    Json,
    Partial,
    Run,
    Traces,
    read_json,
    read_sweep,
)
from sim2sim_report.suite import Suite
from sim2sim_report.words import (
    DIVERGENCE_DIGITS,
    NOT_SHOWN,
    RATE_DIGITS,
    TOO_FEW,
    figure,
    glossary,
    in_sentence,
    interval,
    mark,
    probability,
    rate,
    signed,
    times,
    transfer,
)

SIGNIFICANT = 0.05  # after Holm
MEANS = (("mean_pos_divergence", "m"), ("mean_ang_divergence", "rad"))  # keys of metrics.json
UNTRAINED = "fresh-untrained"
ROWS_WITHOUT_SCRIPT = 100  # episodes in the table of a page in which no script runs
KIND_NAMES = {
    "only_reference_succeeds": "reference only",
    "both_succeed": "both",
    "neither_succeeds": "neither",
    "only_engine_succeeds": "engine only",
}
CONTRASTED = {
    "engine_success_rate": ("success rate", RATE_DIGITS),
    "mean_pos_divergence_m": ("position divergence", DIVERGENCE_DIGITS),
    "mean_ang_divergence_rad": ("angle divergence", DIVERGENCE_DIGITS),
}
CAUTION = [
    "Neither simulator is the truth. The gap says how far they agree, not which of them is right.",
    "Intervals speak of further starts like these, under this policy. They say nothing of others.",
]


class Page:
    """Templates and what every page shares."""

    def __init__(self, suite: Suite) -> None:
        self.suite = suite
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
            "css": jinja2.utils.markupsafe.Markup(
                colors.css() + (here / "page.css").read_text("utf-8")
            ),
            "script": jinja2.utils.markupsafe.Markup((here / "page.js").read_text("utf-8")),
            "words": glossary(),
            "geometry": GEOMETRY,
            "kind_names": KIND_NAMES,
        }

    def of_runs(
        self, runs: Sequence[Run], traces: Sequence[Optional[Traces]], animate: Sequence[int]
    ) -> str:
        """One run, or several over the same episodes; the first is what the others are held to."""
        folders = [run.folder for run in runs]
        compared = self.suite.contrast(folders) if len(runs) > 1 else {}
        engines = runs[0].name if len(runs) == 1 else f"{len(runs)} engines, pair by pair"
        answers = [{"name": run.name, "answer": run.answer} for run in runs]
        return self._render(
            title=f"{runs[0].title('reference')} to {engines}",
            question=compared["headline"]["question"] if compared else runs[0].question,
            headline=compared["headline"]["answer"] if compared else runs[0].answer,
            answers=answers if len(runs) > 1 else [],
            caution=_caution([run.metrics for run in runs]),
            rates=figures.draw_rates(runs),
            contrasts=[_contrast(c) for c in compared.get("contrasts", [])],
            baseline=runs[0].name,
            runs=[
                _section(run, number, shown, animate)
                for number, (run, shown) in enumerate(zip(runs, traces))
            ],
        )

    def of_sweep(self, folder: Path) -> str:
        """Curves over every parameter that varies, and every row against the first."""
        content = read_sweep(folder)
        rows, whole = content["rows"], len(content["sweep"]["rows"])
        if len(rows) < whole:
            unfinished = f"is unfinished: {len(rows)} of {whole} rows; `sweep` goes on with it"
            raise Refusal(f"{folder}: {unfinished}")
        curves, pairs = draw_sweep(folder, self.suite)
        compared = self.suite.contrast([folder])
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            question=compared["headline"]["question"],
            headline=compared["headline"]["answer"],
            caution=_caution(rows),
            contrasts=[_contrast(c) for c in compared["contrasts"]],
            baseline=compared["baseline"]["title"],
            sweep={
                "curves": curves,
                "pairs": pairs,
                "summary": _sweep_summary(rows[0]),
                "rows": [_sweep_row(folder, number, row) for number, row in enumerate(rows)],
                "attribute": _suggested_attribution(folder, rows),
            },
        )

    def of_attribution(self, folder: Path) -> str:
        """A sweep over switches of which the cause of the gap is known."""
        attribution = read_attribution(folder)
        section = attribution_section(attribution)
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            question="What causes the gap?",
            headline=section["headline"],
            caution=[*section["caution"], *CAUTION],
            attribution=section,
        )

    def of_partial(self, partial: Partial) -> str:
        """A run that was interrupted, or failed: its episodes, without figures."""
        status, configuration = partial.status, partial.provenance["configuration"]
        count = f"{len(partial.episodes)} of {status['episodes']} episodes"
        return self._render(
            title=f"{partial.title('reference')} to {partial.title('engine')}",
            question=QUESTION,
            headline="Cannot say yet: the run has not finished.",
            unfinished=f"{count}; {status['reason']}",
            caution=[
                "A part of a run has no figures here: which episodes have finished may hang on how "
                "long they are.",
                *CAUTION,
            ],
            partial={
                "id": "run0",
                "policy": configuration["policy"],
                "reference": partial.title("reference"),
                "engine": partial.title("engine"),
                "counts": partial.counts,
                "episodes": len(partial.episodes),
                "table": [_row(e) for e in partial.episodes],
                "player": None,
                "command": command_of(partial),
                "notes": notes_on_command(partial),
                "provenance": json.dumps(partial.provenance, indent=2, sort_keys=True),
            },
        )

    def _render(self, **context: Any) -> str:
        for name in ("rates", "sweep", "attribution", "partial", "unfinished"):
            context.setdefault(name, None)
        for name in ("answers", "contrasts", "runs"):
            context.setdefault(name, [])
        context.setdefault("baseline", "")
        rows = ROWS_WITHOUT_SCRIPT
        template = self.environment.get_template("page.html.j2")
        return template.render(rows_without_script=rows, **self.shared, **context)


def _sentences(run: Run) -> List[str]:
    """What the figures say, and what each does not show."""
    m = run.metrics
    reference, engine = in_sentence(run.title("reference")), in_sentence(run.name)
    difference = interval(m["success_difference_interval"], RATE_DIGITS)
    mean_position = figure(m, "mean_pos_divergence", "m")
    mean_angle = figure(m, "mean_ang_divergence", "rad")
    null_position = figure(m, f"{REPLAY}_null_position_divergence", "m", with_interval=False)
    null_angle = figure(m, f"{REPLAY}_null_angle_divergence", "rad", with_interval=False)
    sentences = [
        f"In closed loop, policy {m['policy']} succeeds in {rate(m, 'reference')} of "
        f"{m['episodes']} episodes in {reference} and in {rate(m, 'engine')} of the same episodes "
        f"in {engine}: {signed(m['success_difference'], RATE_DIGITS)}{difference}, "
        f"McNemar {probability(m['success_difference_p'])}."
        # The answer above has the one interval of transfer that holds in a run that was stopped.
        + ("" if "decision" in m else f" Transfer: {transfer(m)}."),
        f"Given the exact actions of {reference}, the tee in {engine} is {mean_position} and "
        f"{mean_angle} from where it is in {reference}, on average over the episode. A tee that "
        f"never moves would be {null_position} and {null_angle} away.",
    ]
    if "decision" in m:
        sentences.insert(0, _decision(m, engine))
    return sentences + _doubts(m)


def _decision(m: Json, engine: str) -> str:
    decision = m["decision"]
    kept = f"{100 * decision['share']:.6g} % of the success in the reference"
    if decision["episodes"] is None:
        return f"It was not decided after {m['episodes']} episodes whether {engine} keeps {kept}."
    return f"Decided after {decision['episodes']} episodes: {engine} {decision['verdict']} {kept}."


def _doubts(m: Json) -> List[str]:
    """What each divergence does not show."""
    doubts = []
    for (name, _), (key, unit) in zip(COMPONENTS, MEANS):
        beats = m[f"{key}_beats_null"]
        ends = m[f"{key}_minus_null_interval_{unit}"]
        if beats is None:
            doubts.append(
                f"{TOO_FEW} In {name} there are too few episodes to compare it with that tee."
            )
        elif not beats and ends[0] > 0:
            doubts.append(f"{NOT_SHOWN} In {name} it is further away than that tee.")
        elif not beats:
            doubts.append(f"{NOT_SHOWN} In {name} it is not shown to be nearer than that tee.")
    return doubts


def _caution(runs: Sequence[Json]) -> List[str]:
    """What the figures do not say."""
    caution = []
    first = runs[0]
    reference = first["simulators"]["reference"]["title"]
    if first["policy"] == UNTRAINED:
        caution.append("The policy is untrained: success and transfer say nothing.")
    elif first["reference_successes"] == 0:
        caution.append(
            f"The policy never succeeds in {reference}. A trained one does: is this the right "
            "checkpoint, and is its normalisation inside?"
        )
    if any("decision" in metrics for metrics in runs):
        caution.append(
            "The run was to end when it is decided. The answer above holds all the same; the other "
            "intervals are those of a run of fixed length, and hold less often here."
        )
    return caution + CAUTION


def _sweep_summary(row: Json) -> str:
    reference = row["simulators"]["reference"]["title"]
    starts = "given starts" if "starts" in row else f"seed {row['seed']}"
    return (
        f"Policy {row['policy']}, {row['episodes']} episodes for every row, {starts}. In "
        f"{reference}, the reference of all rows, it succeeds in {rate(row, 'reference')}."
    )


def _sweep_row(folder: Path, number: int, row: Json) -> Json:
    engine = row["simulators"]["engine"]
    values = ", ".join(f"{name} {engine['parameters'][name]}" for name in engine["changed"])
    statistics = read_json(folder / "rows" / f"{number:03d}" / "statistics.json")
    return {
        "engine": engine["title"],
        "changed": values or "as shipped",
        "success": rate(row, "engine"),
        "divergences": _means(row),
        "answer": statistics["headline"]["answer"],
    }


def _suggested_attribution(folder: Path, rows: Sequence[Json]) -> str:
    """The command that finds the cause, if all that varies in a sweep is switches."""
    taken = [row["simulators"]["engine"]["parameters"] for row in rows]
    names = [name for name in taken[0] if len({json.dumps(one.get(name)) for one in taken}) > 1]
    switches = all(isinstance(one.get(name), bool) for name in names for one in taken)
    return f"rosrun sim2sim_eval attribute {folder.name}" if len(names) > 1 and switches else ""


def _means(metrics: Json) -> List[str]:
    """The mean divergences, marked where they are not shown to be less than the null model's."""
    return [figure(metrics, *mean) + mark(metrics[f"{mean[0]}_beats_null"]) for mean in MEANS]


def _section(run: Run, number: int, traces: Optional[Traces], animate: Sequence[int]) -> Json:
    shown = animated(run, animate)
    return {
        "id": f"run{number}",
        "folder": run.folder.resolve().name,
        "reference": run.title("reference"),
        "engine": run.name,
        "metrics": run.metrics,
        "counts": {kind: run.metrics[kind] for kind in KINDS.values()},
        "episodes": run.metrics["episodes"],
        "answer": run.answer,
        "sentences": _sentences(run),
        "divergences": _divergences(run),
        "has_intervals": run.metrics["mean_pos_divergence_interval_m"] is not None,
        "drawings": figures.draw(run, f"run{number}-"),
        "causes_have_intervals": figures.causes_have_intervals(run),
        "parting": _parting(run),
        "parameters": _parameters(run),
        "provenance": json.dumps(run.provenance, indent=2, sort_keys=True),
        "command": command_of(run),
        "notes": notes_on_command(run),
        "animated": len(shown),
        "player": None if traces is None else player(run, traces, shown),
        "poster": None if traces is None else poster(run, traces),
        "table": [_row(e) for e in run.episodes],
    }


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
        return {"head": head, "cells": [figure(m, key, unit, **style) for key, unit in quantities]}

    lines = [{"head": "mean", "cells": _means(m)}]
    lines.append(line("median", [(f"{key}_median", unit) for key, unit in MEANS]))
    less_null = [(f"{key}_minus_null", unit) for key, unit in MEANS]
    lines.append(line("less null model", less_null, with_sign=True))
    factors = [m[f"{key}_over_floor"] for key, _ in MEANS]
    if factors[0] is not None:
        cells = [times(factor) for factor in factors]
        lines.append({"head": "over the floor (1e-6 m), roughly", "cells": cells})
    absorbed = [(f"{ENGINE}_absorbed_{name}_divergence", unit) for name, unit in COMPONENTS]
    lines.append(line("less in closed loop", absorbed, with_sign=True))
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
        text = signed(figure["difference"], digits) + (
            f" {figure['unit']}" if figure["unit"] else ""
        )
        rows.append(
            {
                "name": name,
                "difference": text + interval(figure["interval"], digits),
                "p": probability(figure["p"]),
                "adjusted": probability(figure["adjusted_p"]),
                "finding": _is_finding(figure),
            }
        )
    return {"title": content["title"], "rows": rows}


def _is_finding(figure: Json) -> bool:
    return figure["adjusted_p"] is not None and figure["adjusted_p"] <= SIGNIFICANT
