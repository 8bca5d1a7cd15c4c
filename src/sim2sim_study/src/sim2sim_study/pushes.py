# SPDX-License-Identifier: BSD-3-Clause
"""Pushes: what an engine makes of windows of a few control steps in which MuJoCo's tee moves.
docs/study/noise/plan.md has the definitions."""

import csv
import io
import lzma
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
import sim2sim
from pusht_task import task
from pusht_task.files import write_file

from sim2sim_study.crossed import Numbers
from sim2sim_study.plan import Plan

# [m] the tee's radius of gyration about its center of mass, for yaw in the norm of a displacement;
# and how far that center is from the origin, along body -y.
GYRATION, CENTER = 0.044, task.STEM_OFFSET * 0.045 / 0.105
MISSED = 0.25  # share of the reference's displacement below which a push is missed
LEAST_RATIO = 1 / 20  # of displacements, in the mean logarithm
FIGURES = ("position_error", "missed", "other_way", "direction", "size", "weak")
COUNT = "pushes"
SUMS = ("policy", "engine", "figure", "sums_by_start")  # columns of pushes.csv.xz
SEED = 20261127


class Rollouts(NamedTuple):
    """Closed loops of a policy in MuJoCo: states [step, episode, field] and actions [step, episode,
    2]; `steps` has the length of each."""

    states: Numbers
    actions: Numbers
    steps: Numbers


class Pushes(NamedTuple):
    """Windows in which the tee moves: start, the reference's actions, the tee at both ends."""

    episode: Numbers
    start: Numbers  # [push, field]
    actions: Numbers  # [push, step, 2]
    end: Numbers  # [push, field]


def population(plan: Plan) -> List[str]:
    """The engines: drawn subsets of the rigid body's switches, and those that the plan lists."""
    switches = [one["name"] for one in sim2sim.parameters("rigid_body") if one["type"] == "boolean"]
    switches.remove("continuous")
    generator = np.random.default_rng(SEED)
    drawn: List[str] = []
    while len(drawn) < plan["switches"]:
        on = generator.random(len(switches)) < 0.5
        words = [f"{name}={str(bool(value)).lower()}" for name, value in zip(switches, on)]
        text = ":".join(["rigid_body", *words])
        if text not in drawn and 0 < on.sum() < len(switches):
            drawn.append(text)
    return [*drawn, *plan["engines"]]


def displacement(a: Numbers, b: Numbers) -> Numbers:
    """From tee poses a to b, in meters: x and y of the center of mass, and yaw times the radius of
    gyration. Its norm is how far the tee's points move, root mean square by mass."""
    yaw = np.mod(b[..., 2] - a[..., 2] + np.pi, 2 * np.pi) - np.pi
    x = b[..., 0] - a[..., 0] + CENTER * (np.sin(b[..., 2]) - np.sin(a[..., 2]))
    y = b[..., 1] - a[..., 1] - CENTER * (np.cos(b[..., 2]) - np.cos(a[..., 2]))
    return np.stack([x, y, GYRATION * yaw], axis=-1)


def tee_of(states: Numbers) -> Numbers:
    return states[..., [sim2sim.STATE_FIELDS.index(name) for name in ("tee_x", "tee_y", "tee_yaw")]]


def roll_out(policy: Any, seeds: Sequence[int]) -> Rollouts:
    """The policy in MuJoCo, in a plain loop, until each episode ends."""
    worlds = sim2sim.make_vec("mujoco", len(seeds))
    observations, info = worlds.reset(seed=list(seeds))
    memories = [policy.begin(seed) for seed in seeds]
    states, actions = [info["state"].copy()], []
    steps = np.full(len(seeds), task.HORIZON)
    for step in range(task.HORIZON):
        answer = np.clip(policy.act(observations, memories), -1.0, 1.0)
        observations, _, terminated, _, info = worlds.step(answer)
        actions.append(answer.copy())
        states.append(info["state"].copy())
        steps = np.where(terminated & (steps == task.HORIZON), step + 1, steps)
        if np.all(steps <= step + 1):
            break
    return Rollouts(np.array(states), np.array(actions), np.minimum(steps, len(actions)))


def pushes_in(rollouts: Rollouts, window: int, least: float) -> Pushes:
    """Windows that begin at multiples of `window` [control steps] and move the tee by more than
    `least` [m]."""
    found: List[Tuple[int, int]] = []
    for number, steps in enumerate(rollouts.steps):
        begins = np.arange(0, steps - window + 1, window)
        tees = tee_of(rollouts.states[:, number])
        moves = np.linalg.norm(displacement(tees[begins], tees[begins + window]), axis=-1)
        found += [(number, int(begin)) for begin in begins[moves > least]]
    places: Numbers = np.array(found, dtype=int).reshape(-1, 2)
    episode, begin = places[:, 0], places[:, 1]
    ahead = begin[:, None] + np.arange(window)
    return Pushes(
        episode,
        rollouts.states[begin, episode],
        rollouts.actions[ahead, episode[:, None]],
        rollouts.states[begin + window, episode],
    )


class Engine:
    """Worlds of an engine, made once: a world of MuJoCo takes 9 ms to make."""

    AT_ONCE = 100

    def __init__(self, text: str) -> None:
        kind, *settings = text.split(":")
        parameters = dict(setting.split("=") for setting in settings)
        self._worlds = sim2sim.make_vec(kind, self.AT_ONCE, **_typed(kind, parameters))

    def answers(self, pushes: Pushes) -> Numbers:
        """The state of the engine at the end of each push, from its start and with its actions."""
        ends = [pushes.end[:0]]
        for begin in range(0, len(pushes.start), self.AT_ONCE):
            part = np.arange(begin, min(begin + self.AT_ONCE, len(pushes.start)))
            ends.append(self._ends(pushes, np.resize(part, self.AT_ONCE))[: len(part)])
        return np.concatenate(ends)

    def _ends(self, pushes: Pushes, part: Numbers) -> Numbers:
        self._worlds.reset(options={"state": pushes.start[part]})
        last = np.empty_like(pushes.end[part])
        going = np.ones(len(last), dtype=bool)  # a world begins anew after a success
        for action in np.moveaxis(pushes.actions[part], 1, 0):
            _, _, terminated, _, info = self._worlds.step(action)
            last[going] = info["state"][going]
            going &= ~terminated
        return last


def _typed(kind: str, parameters: Dict[str, str]) -> Dict[str, Any]:
    """Parameters as Python's values, by their types."""
    types = {one["name"]: one["type"] for one in sim2sim.parameters(kind)}
    read: Dict[str, Callable[[str], Any]] = {
        "boolean": lambda text: text == "true",
        "real": float,
        "integer": int,
        "text": str,
    }
    return {name: read[types[name]](text) for name, text in parameters.items()}


def figures_of(pushes: Pushes, ends: Numbers) -> Dict[str, Numbers]:
    """Each figure of each push; NaN where a push has none."""
    start, reference, engine = (tee_of(s) for s in (pushes.start, pushes.end, ends))
    there, here = displacement(start, reference), displacement(start, engine)
    far, near = np.linalg.norm(there, axis=-1), np.linalg.norm(here, axis=-1)
    ratio = near / far
    missed = ratio < MISSED
    inner = np.sum(there * here, axis=-1)
    angle = np.degrees(np.arccos(np.clip(inner / np.maximum(far * near, 1e-300), -1.0, 1.0)))
    return {
        "position_error": np.linalg.norm(displacement(reference, engine), axis=-1),
        "missed": missed.astype(float),
        "other_way": np.where(missed, np.nan, inner < 0.0),
        "direction": np.where(missed, 90.0, angle),
        "size": np.log(np.clip(ratio, LEAST_RATIO, 1 / LEAST_RATIO)),
        "weak": np.maximum(0.0, 1.0 - ratio),
    }


def measure(
    policies: Sequence[str], engines: Sequence[str], plan: Plan, seeds: Sequence[int]
) -> Any:
    """Figures by window, policy and engine, each push with its episode."""
    pushed: Dict[Any, Dict[str, Pushes]] = {window: {} for window in plan["windows"]}
    for name in policies:
        rollouts = roll_out(sim2sim.load_policy(name), seeds)
        for window, of_window in pushed.items():
            least = plan["least_move"] * (1.0 if window == 5 else 0.2)
            of_window[name] = pushes_in(rollouts, window, least)
    found: Dict[Any, Any] = {window: {name: {} for name in policies} for window in pushed}
    for text in engines:
        engine = Engine(text)
        for window, of_window in pushed.items():
            for name, pushes in of_window.items():
                figures = figures_of(pushes, engine.answers(pushes))
                found[window][name][text] = {"episode": pushes.episode, **figures}
    return found


def _mean(values: Numbers) -> float:
    """Mean over the pushes that have a figure; NaN without any."""
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else np.nan


def write_pushes(path: Path, found: Any) -> None:
    """A row for each window, policy and engine: means over pushes, and their number."""
    lines = [",".join(["window", "policy", "engine", "pushes", *FIGURES])]
    for window, of_window in found.items():
        for policy, of_policy in of_window.items():
            for engine, pushes in of_policy.items():
                means = [f"{_mean(pushes[figure]):.6g}" for figure in FIGURES]
                count = str(len(pushes["episode"]))
                lines.append(",".join([str(window), Path(policy).name, engine, count, *means]))
    write_file(path, ("\n".join(lines) + "\n").encode())


def write_sums(path: Path, of_window: Any, starts: int) -> None:
    """Writes for each policy and engine the number of pushes by start, and the sums of each figure
    over the pushes that have it; so any resample of starts can be judged without the policies."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(SUMS)
    for policy, of_policy in of_window.items():
        for engine, pushes in of_policy.items():
            ones = np.ones(len(pushes["episode"]))
            for figure in (COUNT, *FIGURES):
                values = np.nan_to_num(ones if figure == COUNT else pushes[figure])
                sums = np.bincount(pushes["episode"], values, minlength=starts)
                by_start = " ".join(f"{value:.5g}" for value in sums)
                writer.writerow([Path(policy).name.partition(".")[0], engine, figure, by_start])
    write_file(path, lzma.compress(text.getvalue().encode(), preset=9))
