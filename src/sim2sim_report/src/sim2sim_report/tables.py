# SPDX-License-Identifier: BSD-3-Clause
"""The rows of a page's tables."""

from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

from pusht_task.json_file import Json, read_json
from sim2sim_protocol.result_files import name_of, row_folder

from sim2sim_report.again import CLOSED_VARIANT, REANCHORED, VARIANT
from sim2sim_report.figures import COMPONENTS
from sim2sim_report.results import ENGINE, KINDS, MODES, REFERENCE, Episode, Run
from sim2sim_report.sentences import EARLY, FIVE_SECONDS, MEANS
from sim2sim_report.words import (
    DIVERGENCE_DIGITS,
    FEWEST_PAIRS,
    RATE_DIGITS,
    figure,
    in_sentence,
    interval,
    mark,
    probability,
    rate,
    signed,
    times,
)

SIGNIFICANT = 0.05  # after Holm
MOST = 0.5  # share of a mean that the table of the commands names (isMostlyOfLargest())
HORIZONS = (  # as in the table of the commands
    ("first 2 s", EARLY),
    ("first 5 s", FIVE_SECONDS),
    ("whole episode", MEANS),
)
MOST_EPISODES = 40  # whose numbers are listed
CONTRASTED = {
    "reference_success_rate": ("success rate, reference", RATE_DIGITS),
    "engine_success_rate": ("success rate", RATE_DIGITS),
    "transfer": ("transfer", RATE_DIGITS),
    "mean_pos_divergence_m": ("position divergence", DIVERGENCE_DIGITS),
    "mean_ang_divergence_rad": ("angle divergence", DIVERGENCE_DIGITS),
}


def episode_row(episode: Episode) -> List[Any]:
    reference, engine, replay = (episode.modes[mode] for mode in MODES)

    def number(text: str) -> Optional[float]:
        return round(float(text), DIVERGENCE_DIGITS) if text else None

    return [
        episode.index,
        reference.get("seed", ""),
        list(KINDS.values()).index(episode.kind),
        episode.steps(REFERENCE),
        episode.steps(ENGINE),
        episode.ending(REFERENCE),
        episode.ending(ENGINE),
        number(replay["mean_position_divergence_m"]),
        number(replay["mean_angle_divergence_rad"]),
        int(replay["parting_step"]) if replay["parting_step"] else None,
        replay["parting_cause"].replace("_", " "),
    ]


def stuck_texts(episodes: Sequence[Episode]) -> Dict[str, str]:
    """How many of a kind of episodes end stuck: "engine stuck: 62"; "" where none fails."""
    failing: Dict[str, Dict[str, str]] = {
        "both_succeed": {},
        "only_reference_succeeds": {"engine": ENGINE},
        "only_engine_succeeds": {"reference": REFERENCE},
        "neither_succeeds": {"reference": REFERENCE, "engine": ENGINE},
    }
    texts = {}
    for kind, roles in failing.items():
        of_kind = [episode for episode in episodes if episode.kind == kind]
        counts = [
            f"{role} stuck: {sum(e.ending(mode) == 'stuck' for e in of_kind)}"
            for role, mode in roles.items()
        ]
        texts[kind] = ", ".join(counts) if of_kind else ""
    return texts


def divergences(run: Run) -> List[Json]:
    """The lines of the table that the commands print, as they print them."""
    m = run.metrics

    def line(head: str, quantities: Sequence[Any], **style: Any) -> Json:
        return {"head": head, "cells": [figure(m, key, unit, **style) for key, unit in quantities]}

    resets = [probe[len(REANCHORED) :] for probe in m["probes"] if probe.startswith(REANCHORED)]
    lines = [pushes for every in resets for pushes in _pushes(run, every)]
    for title, means in HORIZONS:
        episodes = m[f"{means[0][0]}_episodes"]
        if episodes == 0:
            continue
        count = "" if episodes == m["episodes"] else f" (n {episodes})"
        lines.append({"head": title + count, "cells": _means(m, means)})
        carried = [_carried(m[f"{key}_share_of_largest"]) for key, _ in means]
        if any(carried) and episodes >= FEWEST_PAIRS:
            lines.append({"head": "largest 5 % carry", "cells": carried})
        if means == MEANS:
            lines.append(line("median", [(f"{key}_median", unit) for key, unit in means]))
        less_null = [(f"{key}_minus_null", unit) for key, unit in means]
        lines.append(line("less null model", less_null, with_sign=True))
        multiples = [f"{key}_over_variants" for key, _ in means]
        if multiples[0] in m:
            cells = [times(m[key], m[f"{key}_interval"]) for key in multiples]
            lines.append({"head": "over the largest model variant", "cells": cells})
    if m[f"{MEANS[0][0]}_over_floor"] is not None:
        cells = [times(m[f"{key}_over_floor"], m[f"{key}_over_floor_interval"]) for key, _ in MEANS]
        lines.append({"head": "over the floor (1e-6 m)", "cells": cells})
    absorbed = [(f"{ENGINE}_absorbed_{name}_divergence", unit) for name, unit in COMPONENTS]
    lines.append(line("less in closed loop", absorbed, with_sign=True))
    for every in resets:
        errors = [(f"{REANCHORED}{every}_anchor_{name}_error", unit) for name, unit in COMPONENTS]
        lines.append(line(f"made in {_steps(every)}", errors))
    for probe in m["probes"]:
        if probe.startswith(VARIANT):
            own = [(f"{probe}_mean_{name}_divergence", unit) for name, unit in COMPONENTS]
            lines.append(line(f"reference with {probe[len(VARIANT) :]}, whole episode", own))
        if probe.startswith(CLOSED_VARIANT):
            lines.append(_closed_variant(m, probe))
    return lines


def _steps(number: str) -> str:
    return f"{number} step{'' if number == '1' else 's'}"


def _pushes(run: Run, every: str) -> List[Json]:
    """The pushes of the state-reset replay of so many steps, as pushText() has them; none without
    a push."""
    m, probe = run.metrics, f"{REANCHORED}{every}"

    def share(name: str) -> str:
        ends = [f"{100 * end:.0f}" for end in m[f"{probe}_{name}_interval_share"] or []]
        return f"{100 * m[f'{probe}_{name}_share']:.0f} %" + (
            f" [{', '.join(ends)}]" if ends else ""
        )

    if m.get(f"{probe}_pushes_missed_share") is None:
        return []
    reference = in_sentence(run.title("reference"))
    missed = share("pushes_missed")
    text = f"in the mean episode {missed} of those that move {reference}'s tee miss here"
    if m[f"{probe}_pushes_turned_share"] is not None:
        text += f"; of the others {share('pushes_turned')} move it the other way"
    error = figure(m, f"{probe}_push_direction_error", "rad")
    return [
        {"head": f"direction error of pushes in {_steps(every)}", "cells": ["", error]},
        {"head": "pushes missed", "cells": [text]},
    ]


def _closed_variant(metrics: Json, probe: str) -> Json:
    """Success of the policy in a model variant of the reference, less that in the reference."""
    ends = interval(metrics[f"{probe}_success_difference_interval"], RATE_DIGITS)
    difference = signed(metrics[f"{probe}_success_difference"], RATE_DIGITS) + ends
    return {
        "head": f"success with {probe[len(CLOSED_VARIANT) :]}",
        "cells": [rate(metrics, probe), f"less the reference {difference}"],
    }


def _carried(share: Optional[float]) -> str:
    """Empty if the largest 5 % of the episodes do not carry most of the mean."""
    return f"{100 * share:.0f} % of the mean" if share is not None and share > MOST else ""


def _means(metrics: Json, means: Sequence[Tuple[str, str]]) -> List[str]:
    """Mean divergences, marked where they are not shown to be less than the null model's."""
    return [figure(metrics, *mean) + mark(metrics[f"{mean[0]}_beats_null"]) for mean in means]


def parameters(run: Run) -> List[Json]:
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


def sweep_row(folder: Path, number: int, row: Json) -> Json:
    engine = row["simulators"]["engine"]
    values = ", ".join(f"{name} {engine['parameters'][name]}" for name in engine["changed"])
    statistics = read_json(row_folder(folder, number) / name_of("statistics"))
    return {
        "engine": engine["title"],
        "changed": values or "as shipped",
        "success": rate(row, "engine"),
        "divergences": _means(row, MEANS),
        "answer": statistics["headline"]["answer"],
    }


def contrast_rows(content: Json) -> Json:
    rows = []
    for key, (name, digits) in CONTRASTED.items():
        figure = content["figures"].get(key)
        if figure is None:
            continue
        if "policy" in content and key == "engine_success_rate":
            name += ", engine"
        text = "none"
        if figure["difference"] is not None:
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
    return {"title": content["title"], "rows": rows, "alone": _alone(content)}


def _alone(content: Json) -> List[Json]:
    """Episodes in which only one of two policies succeeds, by simulator; none of two engines."""
    if "policy" not in content:
        return []
    return [
        {
            "simulator": simulator,
            "baseline": episodes_text(of["only_baseline_succeeds"]),
            "other": episodes_text(of["only_other_succeeds"]),
        }
        for simulator, of in (("reference", content["reference"]), ("engine", content))
    ]


def episodes_text(episodes: Sequence[int]) -> str:
    """Numbers of episodes with how many there are: "3: 1, 5, 8"."""
    shown = ", ".join(map(str, episodes[:MOST_EPISODES]))
    more = ", ..." if len(episodes) > MOST_EPISODES else ""
    return f"{len(episodes)}: {shown}{more}" if episodes else "none"


def _is_finding(figure: Json) -> bool:
    return figure["adjusted_p"] is not None and figure["adjusted_p"] <= SIGNIFICANT
