# SPDX-License-Identifier: BSD-3-Clause
"""Episodes to play: what the player on the page gets, and frames that show one without it."""

import base64
import math
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
from pusht_task import task
from pusht_task.error import Error
from pusht_task.json_file import Json
from pusht_task.palette import DARK

from sim2sim_report.colors import ON_TABLE
from sim2sim_report.results import ENGINE, MODES, REPLAY, Episode, Run, Traces

MOST_ANIMATED = 200  # episodes, unless more are asked for
GEOMETRY = {
    "barHalfLength": task.BAR_HALF_LENGTH,
    "stemHalfLength": task.STEM_HALF_LENGTH,
    "halfWidth": task.TEE_HALF_WIDTH,
    "stemOffset": task.STEM_OFFSET,
    "pusherRadius": task.PUSHER_RADIUS,
    "wall": task.WALL_INNER_FACE,
    "controlStep": task.CONTROL_STEP,
}


def animated(run: Run, asked: Sequence[int]) -> List[int]:
    """Episodes to play: of a large run the first, those asked for, and one of each kind."""
    known = [episode.index for episode in run.episodes]
    for index in asked:
        if index not in known:
            raise Error(f"animate {index}: must be from {known[0]} to {known[-1]}")
    return sorted({*known[:MOST_ANIMATED], *asked, *run.first_of_each_kind()})


def player(run: Run, traces: Traces, shown: Sequence[int]) -> Json:
    """The data that page.js plays."""
    return {
        "titles": {"reference": run.title("reference"), "engine": run.name},
        "bound": run.metrics["bound"],
        "first": run.first_of_each_kind(),
        "episodes": [_animation(e, traces) for e in run.episodes if e.index in shown],
    }


def _animation(episode: Episode, traces: Traces) -> Json:
    return {
        "episode": episode.index,
        "kind": episode.kind,
        "states": {mode: _packed(traces[episode.index, mode]) for mode in MODES},
        "succeeds": {mode: episode.succeeds(mode) for mode in MODES},
        "stuck": {
            mode: episode.still(mode) if episode.ending(mode) == "stuck" else None for mode in MODES
        },
        "first_divergence": {mode: episode.first_divergence(mode) for mode in (ENGINE, REPLAY)},
    }


def _packed(trace: Any) -> str:
    """Seven float32 of every state; the last action, which there is none of, is 0."""
    names = ("pusher_x", "pusher_y", "tee_x", "tee_y", "tee_yaw", "action_x", "action_y")
    table = np.stack([np.nan_to_num(trace[name]) for name in names], axis=1)
    return base64.b64encode(table.astype("<f4").tobytes()).decode("ascii")


def poster(run: Run, traces: Traces) -> Json:
    """Frames of one episode, side by side: at its start, when the replay parts, and at the end."""
    episode = _telling(run)
    steps = {"at the start": 0}
    left = episode.first_divergence(REPLAY)
    if left is not None:
        steps[f"first beyond the bound, {left * task.CONTROL_STEP:.1f} s"] = left
    last = max(episode.steps(mode) for mode in MODES)
    steps[f"at the end, {last * task.CONTROL_STEP:.1f} s"] = last
    frames = []
    for name, step in steps.items():
        worlds = {mode: _at(traces[episode.index, mode], step) for mode in MODES}
        frames.append({"name": name, "svg": _frame(worlds, traces, episode.index, step)})
    return {"episode": episode.index, "frames": frames}


def _telling(run: Run) -> Episode:
    """The first episode of the first kind that there is: if possible one that is lost."""
    first = run.first_of_each_kind()[0]
    return next(episode for episode in run.episodes if episode.index == first)


def _at(trace: Any, step: int) -> Any:
    return trace[min(step, len(trace) - 1)]


def _frame(worlds: Dict[str, Any], traces: Traces, episode: int, step: int) -> str:
    """A table from above, 0.8 m wide, in units of 1 mm, with the tees of all worlds."""
    inner = 1000 * GEOMETRY["wall"]
    edge = inner + 12
    parts = [
        f'<svg viewBox="{-edge:g} {-edge:g} {2 * edge:g} {2 * edge:g}" role="img">',
        f'<rect x="{-edge:g}" y="{-edge:g}" width="{2 * edge:g}" height="{2 * edge:g}" '
        f'fill="{DARK["walls"]}"/>',
        f'<rect x="{-inner:g}" y="{-inner:g}" width="{2 * inner:g}" height="{2 * inner:g}" '
        f'fill="{DARK["table"]}"/>',
        _tee((0.0, 0.0, 0.0), f'fill="none" stroke="{DARK["ink"]}" stroke-width="4" opacity="0.7"'),
    ]
    for mode, state in worlds.items():
        color = ON_TABLE[mode]
        trace = traces[episode, mode][: step + 1]
        points = " ".join(f"{1000 * s['tee_x']:.0f},{-1000 * s['tee_y']:.0f}" for s in trace)
        parts.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="3"/>')
        pose = (state["tee_x"], state["tee_y"], state["tee_yaw"])
        parts.append(
            _tee(pose, f'fill="{color}" fill-opacity="0.35" stroke="{color}" stroke-width="4"')
        )
    for mode, state in worlds.items():
        radius = 1000 * GEOMETRY["pusherRadius"]
        parts.append(
            f'<circle cx="{1000 * state["pusher_x"]:.0f}" cy="{-1000 * state["pusher_y"]:.0f}" '
            f'r="{radius:g}" fill="{ON_TABLE[mode]}" stroke="{DARK["ink"]}" stroke-width="3"/>'
        )
    return "".join([*parts, "</svg>"])


def _tee(pose: Tuple[float, float, float], style: str) -> str:
    a, w = GEOMETRY["barHalfLength"], GEOMETRY["halfWidth"]
    s, o = GEOMETRY["stemHalfLength"], GEOMETRY["stemOffset"]
    outline = ((-a, w), (a, w), (a, -w), (w, -w), (w, -o - s), (-w, -o - s), (-w, -w), (-a, -w))
    x, y, yaw = map(float, pose)
    sin, cos = math.sin(yaw), math.cos(yaw)
    points = " ".join(
        f"{1000 * (x + cos * u - sin * v):.0f},{-1000 * (y + sin * u + cos * v):.0f}"
        for u, v in outline
    )
    return f'<polygon points="{points}" {style}/>'
