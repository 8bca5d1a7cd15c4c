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
GEOMETRY: Json = {  # of the course's task [m, s, rad]
    "barHalfLength": task.BAR_HALF_LENGTH,
    "stemHalfLength": task.STEM_HALF_LENGTH,
    "barHalfWidth": task.TEE_HALF_WIDTH,
    "stemHalfWidth": task.TEE_HALF_WIDTH,
    "stemOffset": task.STEM_OFFSET,
    "pusherRadius": task.PUSHER_RADIUS,
    "wall": task.WALL_INNER_FACE,
    "wallMiddle": [0.0, 0.0],
    "target": [0.0, 0.0, 0.0],
    "controlStep": task.CONTROL_STEP,
    "arrow": "the commanded velocity",
}


def geometry_of(run: Run) -> Json:
    """Sizes, walls and target of a run's task."""
    described = run.provenance.get("task")
    if described is None:
        return GEOMETRY
    sizes, walls = described["sizes"], described["walls"]
    return {
        **GEOMETRY,
        "barHalfLength": sizes["bar_half_length"],
        "stemHalfLength": sizes["stem_half_length"],
        "barHalfWidth": sizes["bar_half_width"],
        "stemHalfWidth": sizes["stem_half_width"],
        "stemOffset": sizes["stem_offset"],
        "pusherRadius": sizes["pusher_radius"],
        "wall": walls["inner_face"],
        "wallMiddle": walls["middle"],
        "target": described["target"],
        "arrow": f"to the commanded {described['physics']['drive']}",
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
        "episodes": [_animation(run, e, traces) for e in run.episodes if e.index in shown],
    }


def _animation(run: Run, episode: Episode, traces: Traces) -> Json:
    return {
        "episode": episode.index,
        "kind": episode.kind,
        "states": {mode: _packed(run, traces[episode.index, mode]) for mode in MODES},
        "succeeds": {mode: episode.succeeds(mode) for mode in MODES},
        "stuck": {
            mode: episode.still(mode) if episode.ending(mode) == "stuck" else None for mode in MODES
        },
        "first_divergence": {mode: episode.first_divergence(mode) for mode in (ENGINE, REPLAY)},
    }


def _packed(run: Run, trace: Any) -> str:
    """Seven float32 of every state; the last action, which there is none of, is 0."""
    names = ("pusher_x", "pusher_y", "tee_x", "tee_y", "tee_yaw")
    numbers = [trace[name] for name in names] + _ways(run, trace)
    table = np.stack([np.nan_to_num(number) for number in numbers], axis=1)
    return base64.b64encode(table.astype("<f4").tobytes()).decode("ascii")


def _ways(run: Run, trace: Any) -> List[Any]:
    """Arrows of the actions along x and y, which page.js draws 0.1 m long for 1 m/s: velocities,
    or, so long that they end there, the ways to positions."""
    described = run.provenance.get("task")
    if described is None or described["physics"]["drive"] == "velocity":
        return [trace["action_x"], trace["action_y"]]
    frame = described["frame"]
    x = (trace["action_x"] - frame["middle"][0]) / frame["per_meter"]
    y = (trace["action_y"] - frame["middle"][1]) / frame["per_meter"]
    y = -y if frame["y_down"] else y
    return [10 * (x - trace["pusher_x"]), 10 * (y - trace["pusher_y"])]


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
        frames.append({"name": name, "svg": _frame(run, worlds, traces, episode.index, step)})
    return {"episode": episode.index, "frames": frames}


def _telling(run: Run) -> Episode:
    """The first episode of the first kind that there is: if possible one that is lost."""
    first = run.first_of_each_kind()[0]
    return next(episode for episode in run.episodes if episode.index == first)


def _at(trace: Any, step: int) -> Any:
    return trace[min(step, len(trace) - 1)]


def _frame(run: Run, worlds: Dict[str, Any], traces: Traces, episode: int, step: int) -> str:
    """A table from above, in units of 1 mm, with the tees of all worlds."""
    geometry = geometry_of(run)

    def square(half: float) -> Tuple[float, float, float]:
        x, y = geometry["wallMiddle"]
        return 1000 * x - half, -1000 * y - half, 2 * half

    left, top, width = square(1000 * geometry["wall"] + 12)
    inner_left, inner_top, inner_width = square(1000 * geometry["wall"])
    parts = [
        f'<svg viewBox="{left:g} {top:g} {width:g} {width:g}" role="img">',
        f'<rect x="{left:g}" y="{top:g}" width="{width:g}" height="{width:g}" '
        f'fill="{DARK["walls"]}"/>',
        f'<rect x="{inner_left:g}" y="{inner_top:g}" width="{inner_width:g}" '
        f'height="{inner_width:g}" fill="{DARK["table"]}"/>',
        _tee(
            geometry,
            geometry["target"],
            f'fill="none" stroke="{DARK["ink"]}" stroke-width="4" opacity="0.7"',
        ),
    ]
    for mode, state in worlds.items():
        color = ON_TABLE[mode]
        trace = traces[episode, mode][: step + 1]
        points = " ".join(f"{1000 * s['tee_x']:.0f},{-1000 * s['tee_y']:.0f}" for s in trace)
        parts.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="3"/>')
        pose = (state["tee_x"], state["tee_y"], state["tee_yaw"])
        parts.append(
            _tee(
                geometry,
                pose,
                f'fill="{color}" fill-opacity="0.35" stroke="{color}" stroke-width="4"',
            )
        )
    for mode, state in worlds.items():
        radius = 1000 * geometry["pusherRadius"]
        parts.append(
            f'<circle cx="{1000 * state["pusher_x"]:.0f}" cy="{-1000 * state["pusher_y"]:.0f}" '
            f'r="{radius:g}" fill="{ON_TABLE[mode]}" stroke="{DARK["ink"]}" stroke-width="3"/>'
        )
    return "".join([*parts, "</svg>"])


def _tee(geometry: Json, pose: Sequence[float], style: str) -> str:
    a, w = geometry["barHalfLength"], geometry["barHalfWidth"]
    v, end = geometry["stemHalfWidth"], -geometry["stemOffset"] - geometry["stemHalfLength"]
    outline = ((-a, w), (a, w), (a, -w), (v, -w), (v, end), (-v, end), (-v, -w), (-a, -w))
    x, y, yaw = map(float, pose)
    sin, cos = math.sin(yaw), math.cos(yaw)
    points = " ".join(
        f"{1000 * (x + cos * u - sin * w):.0f},{-1000 * (y + sin * u + cos * w):.0f}"
        for u, w in outline
    )
    return f'<polygon points="{points}" {style}/>'
