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
EARLY, FIVE_SECONDS = (  # likewise, over the first 2 s and 5 s
    tuple((f"{REPLAY}_{horizon}_{name}_divergence", unit) for name, unit in COMPONENTS)
    for horizon in ("early", "early_5s")
)
STOPPED = "Nothing that compares a divergence with that tee holds in a run that may stop early."
UNTRAINED = "fresh-untrained"
PLAYED_ONCE = (
    "Policy or loop draws random numbers, and each start was played once: how much is chance is "
    "not known."
)
CAUTION = [
    "Neither simulator is the truth. The gap says how far they agree, not which of them is right.",
    "Intervals speak of further starts like these, under this policy. They say nothing of others.",
]


def sentences(run: Run) -> List[str]:
    """Sentences on what the figures say, and on what each does not show."""
    m = run.metrics
    reference, engine = in_sentence(run.title("reference")), in_sentence(run.name)
    difference = interval(m["success_difference_interval"], RATE_DIGITS)
    means = " and ".join(figure(m, key, unit) for key, unit in MEANS)
    nulls = _null_model(m, "null")
    sentences = [
        f"In closed loop, policy {m['policy']} succeeds in {rate(m, 'reference')} of "
        f"{m['episodes']} episodes in {reference} and in {rate(m, 'engine')} of the same episodes "
        f"in {engine}: {signed(m['success_difference'], RATE_DIGITS)}{difference}"
        # The answer above has the one interval that holds in a run that may stop early.
        + ("." if "decision" in m else f"{_mcnemar(m)}. Transfer: {transfer(m)}."),
        f"{_over_two_seconds(m, reference, engine)} Over the whole episode it is {means}. A tee "
        f"that never moves would be {nulls} away.",
    ]
    if "decision" in m:
        sentences.insert(0, _decision(m, engine))
    return sentences + _noise(run) + _doubts(m)


def _mcnemar(m: Json) -> str:
    """Empty where there is no test, as of few starts with repeats."""
    p = probability(m["success_difference_p"])
    return p and f", McNemar {p}"


def _noise(run: Run) -> List[str]:
    """Sentences on repeats, or on random numbers of policy or loop without."""
    m = run.metrics
    if m.get("repeats", 1) == 1:
        noisy_loop = any(
            name.startswith("loop.") and "noise" in name
            for simulator in m["simulators"].values()
            for name in simulator["changed"]
        )
        stochastic = run.provenance.get("policy", {}).get("noise") is not None
        return [PLAYED_ONCE] if stochastic or noisy_loop else []
    starts, repeats = (m[f"engine_success_variance_{source}"] for source in ("starts", "repeats"))
    whole = (starts or 0) + (repeats or 0)
    share = f" {100 * repeats / whole:.0f} % of the engine's variance is noise." if whole else ""
    return [
        f"Each of {m['number_of_starts']} starts was played {m['repeats']} times, with other noise "
        f"of policy and loop. Intervals and tests are by start.{share}"
    ]


def _null_model(m: Json, name: str) -> str:
    """Mean divergences of a tee that never moves: "0.1015 m and 0.8662 rad"."""
    keys = [(f"{REPLAY}_{name}_{component}_divergence", unit) for component, unit in COMPONENTS]
    return " and ".join(figure(m, key, unit, with_interval=False) for key, unit in keys)


def _over_two_seconds(m: Json, reference: str, engine: str) -> str:
    """The divergence over the horizon that leads: nearly all episodes have it."""
    episodes = m[f"{EARLY[0][0]}_episodes"]
    if episodes == 0:
        return f"The engine is given the exact actions of {reference}; no episode lasts 2 s."
    some = "" if episodes == m["episodes"] else f" of the {episodes} episodes that last as long"
    means = " and ".join(figure(m, key, unit) for key, unit in EARLY)
    return (
        f"Given the exact actions of {reference}, the tee in {engine} is {means} from where it is "
        f"in {reference}, on average over the first 2 s{some}; a tee that never moves would be "
        f"{_null_model(m, 'early_null')} away."
    )


def _decision(m: Json, engine: str) -> str:
    decision = m["decision"]
    kept = f"{100 * decision['share']:.6g} % of the success in the reference"
    if decision["episodes"] is None:
        return f"It was not decided after {m['episodes']} episodes whether {engine} keeps {kept}."
    return f"Decided after {decision['episodes']} episodes: {engine} {decision['verdict']} {kept}."


def _doubts(m: Json) -> List[str]:
    """Sentences on what each divergence does not show."""
    if "decision" in m:
        return [f"{TOO_FEW} {STOPPED}"]
    doubts = []
    for horizon, means in (("the first 2 s", EARLY), ("the whole episode", MEANS)):
        for (name, _), (key, unit) in zip(COMPONENTS, means):
            beats = m[f"{key}_beats_null"]
            ends = m[f"{key}_minus_null_interval_{unit}"]
            of = f"In {name}, over {horizon},"
            if m[f"{key}_episodes"] == 0 or beats:
                continue
            if beats is None:
                doubts.append(
                    f"{TOO_FEW} {of} there are too few episodes to compare it with that tee."
                )
            elif ends[0] > 0:
                doubts.append(f"{NOT_SHOWN} {of} it is farther away than that tee.")
            else:
                doubts.append(f"{NOT_SHOWN} {of} it is not shown to be nearer than that tee.")
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
            "checkpoint, and is its normalization inside?"
        )
    if any("decision" in metrics for metrics in runs):
        caution.append(
            "The run was to end when it is decided. The interval of the answer above holds all the "
            "same. Other intervals and tests are made for a fixed length, and are left out."
        )
    return caution + CAUTION


def first_divergence(run: Run) -> str:
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
