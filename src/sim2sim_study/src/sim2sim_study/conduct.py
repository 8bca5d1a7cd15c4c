# SPDX-License-Identifier: BSD-3-Clause
"""How policies act in the study: time in contact and sharpness of actions, from traces.

Both are of the first 5 s of an episode. Over whole episodes they would say how long an episode is:
one that fails lasts to the horizon, and its policy often stands still.
"""

import io
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, Tuple

import numpy as np
from pusht_task import task
from pusht_task.files import read_file
from sim2sim_protocol.result_files import name_of
from sim2sim_report.results import read_rows

from sim2sim_study.plan import Plan, seeds_of, training_of

HOME = "mujoco"
STEPS = 50  # control steps: 5 s
TOUCHING = (
    1e-3  # [m] widest gap of a contact: the margin within which the two-mass engine makes one
)
BAR_RADIUS, STEM_RADIUS = 0.032, 0.026  # [m] discs of the two-mass engine: two_mass_dynamics.hpp
SLOWER = "slower"  # name of the policies whose actions are multiplied by a factor


def box_gap(trace: Any) -> Any:
    """Gap between the pusher and the tee's two boxes, at each state [m]; below 0 they overlap."""
    x, y = _in_tee(trace)

    def gap(center_y: float, half_x: float, half_y: float) -> Any:
        out = np.stack([np.abs(x) - half_x, np.abs(y - center_y) - half_y])
        return np.hypot(*np.maximum(out, 0.0)) + np.minimum(out.max(axis=0), 0.0)

    bar = gap(0.0, task.BAR_HALF_LENGTH, task.TEE_HALF_WIDTH)
    stem = gap(-task.STEM_OFFSET, task.TEE_HALF_WIDTH, task.STEM_HALF_LENGTH)
    return np.minimum(bar, stem) - task.PUSHER_RADIUS


def disc_gap(trace: Any) -> Any:
    """Gap between the pusher and the two discs that are the tee in the two-mass engine [m]."""
    x, y = _in_tee(trace)
    bar = np.hypot(x, y) - BAR_RADIUS
    stem = np.hypot(x, y + task.STEM_OFFSET) - STEM_RADIUS
    return np.minimum(bar, stem) - task.PUSHER_RADIUS


GAPS: Dict[str, Callable[[Any], Any]] = {HOME: box_gap, "two_mass": disc_gap}


def _in_tee(trace: Any) -> Tuple[Any, Any]:
    """The pusher's center in the tee's frame [m]."""
    x, y = trace["pusher_x"] - trace["tee_x"], trace["pusher_y"] - trace["tee_y"]
    cos, sin = np.cos(trace["tee_yaw"]), np.sin(trace["tee_yaw"])
    return cos * x + sin * y, cos * y - sin * x


def contact(trace: Any, gap: Callable[[Any], Any]) -> float:
    """Share of the first control steps at whose end pusher and tee touch."""
    return float(np.mean(gap(trace[1 : STEPS + 1]) <= TOUCHING))


def sharpness(trace: Any) -> float:
    """Mean length of the change of the action from one of the first control steps to the next
    [m/s]."""
    actions = np.stack([trace["action_x"], trace["action_y"]], axis=1).astype(float)
    actions = actions[:-1][:STEPS]  # the last state has no action
    return float(np.mean(np.hypot(*np.diff(actions, axis=0).T)))


def policy_conduct(folder: Path, engine: str) -> Dict[Tuple[str, str], float]:
    """Means over the episodes of a run, in closed loop, by simulator and figure."""
    records = np.load(io.BytesIO(read_file(folder / name_of("traces"))))
    episodes = read_rows(folder / name_of("episodes"))
    found: Dict[Tuple[str, str], float] = {}
    for simulator, mode in ((HOME, "reference_closed"), (engine, "engine_closed")):
        of_mode = records[records["mode"] == mode.encode()]
        traces = np.split(of_mode, np.flatnonzero(of_mode["step"] == 0)[1:])
        won = [episode["success"] == "true" for episode in episodes if episode["mode"] == mode]
        if len(traces) != len(won):
            raise ValueError(f"{folder}: traces.npy and episodes.csv must be of one run")
        found[simulator, "contact"] = float(np.mean([contact(t, GAPS[simulator]) for t in traces]))
        found[simulator, "sharpness"] = float(np.mean([sharpness(trace) for trace in traces]))
        found[simulator, "success"] = float(np.mean(won))
    return found


def conduct_runs(plan: Plan) -> Iterator[Tuple[str, int, str]]:
    """Group, training seed and name of each policy whose conduct is measured."""
    part = plan["conduct"]
    for group in [*part["groups"], f"{SLOWER}-{part['slower']['group']}"]:
        for seed in seeds_of(plan, training_of(plan, group)):
            yield group, seed, f"{group}-{seed}"


def write_slower(policy: Path, slower: Path, factor: float) -> None:
    """Writes a policy that does what another one does, times a factor."""
    import torch  # here, as it takes seconds, and only this needs it

    class Slower(torch.nn.Module):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.policy = torch.jit.load(str(policy))
            self.limit = task.ACTION_LIMIT
            self.factor = factor

        def forward(self, observations: torch.Tensor) -> torch.Tensor:
            actions = torch.clamp(self.policy(observations), -self.limit, self.limit)
            return actions * self.factor

    partial = slower.with_suffix(".partial")
    torch.jit.save(torch.jit.script(Slower()), str(partial))
    partial.replace(slower)
