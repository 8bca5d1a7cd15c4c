# SPDX-License-Identifier: BSD-3-Clause
"""The sentences of a page: what figures say, and what they do not show."""

from typing import List, Sequence

from pusht_task import task
from pusht_task.json_file import Json

from sim2sim_report.figures import COMPONENTS
from sim2sim_report.results import REPLAY, Run
from sim2sim_report.words import (
    NOT_SHOWN,
    RATE_DIGITS,
    TOO_FEW,
    figure,
    in_sentence,
    interval,
    probability,
    rate,
    signed,
    transfer,
)

MEANS = (("mean_pos_divergence", "m"), ("mean_ang_divergence", "rad"))  # keys of metrics.json
UNTRAINED = "fresh-untrained"
CAUTION = [
    "Neither simulator is the truth. The gap says how far they agree, not which of them is right.",
    "Intervals speak of further starts like these, under this policy. They say nothing of others.",
]


def sentences(run: Run) -> List[str]:
    """Sentences on what the figures say, and on what each does not show."""
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
    """Sentences on what each divergence does not show."""
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


def cautions(runs: Sequence[Json]) -> List[str]:
    """Sentences on what the figures do not say."""
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


def parting(run: Run) -> str:
    m = run.metrics
    bound = f"{m['bound']['position_m']:g} m or {m['bound']['angle_rad']:g} rad"
    parted = f"In open loop {m['parted']} of {m['episodes']} episodes leave the bound of {bound}"
    median = m["median_parting_step"]
    if median is None:
        return f"{parted}."
    return f"{parted}. Half of all have left it by {median * task.CONTROL_STEP:.1f} s."


def sweep_summary(row: Json) -> str:
    reference = row["simulators"]["reference"]["title"]
    starts = "given starts" if "starts" in row else f"seed {row['seed']}"
    return (
        f"Policy {row['policy']}, {row['episodes']} episodes for every row, {starts}. In "
        f"{reference}, the reference of all rows, it succeeds in {rate(row, 'reference')}."
    )
