#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws docs/missed_push.svg: three pushes of one episode in MuJoCo, and what the two-mass engine
makes of them. Prints how frequent each kind is, over 200 episodes. In a workspace that is built:

    source devel/setup.bash; python3 -m sim2sim_study.missed_push
"""

from typing import Dict, List, NamedTuple, Tuple

import numpy as np
from pusht_task import task
from pusht_task.command import OneLineParser, run_command
from pusht_task.files import write_file
from pusht_task.palette import DARK, LIGHT

from sim2sim_study.plan import ROOT
from sim2sim_study.pushes import (
    MISSED,
    SEED,
    Engine,
    Numbers,
    Pushes,
    Rollouts,
    displacement,
    figures_of,
    pushes_in,
    roll_out,
    tee_of,
)

PICTURE = ROOT / "docs" / "missed_push.svg"
POLICY, ENGINE = "bc", "two_mass"
FIRST_SEED, EPISODES = 10000, 200  # those of a comparison with seed 0
WINDOW = 5  # control steps
LEAST_MOVE = 0.002  # [m] of the tee in MuJoCo, as in the study's plan
ALIKE = 0.5  # distance of the tees at the end, as a share of the move in MuJoCo
LEAST_TURN = np.radians(2.0)  # of both tees, where they turn opposite ways
KINDS = ("alike", "farther off", "turns the other way", "missed")

EPISODE = 30
SHOWN = {"alike": 5, "turns the other way": 25, "missed": 40}  # by kind: control step of the start

WIDTH, HEIGHT = 880, 566
MARGIN, GAP, TOP = 32, 12, 118
SIDE = (WIDTH - 2 * MARGIN - 2 * GAP) / 3  # [px] of a panel
SCENE = 262  # [px] its height
SCALE = 880.0  # [px/m]
ROLES = {"reference": "MuJoCo", "replay": "engine"}  # names by class
SEGMENTS = (("reference", 1), ("rest", 1), ("replay", 0.55), ("replay", 1))  # by kind
BOLD, LEFT = ' font-weight="bold"', ' text-anchor="start"'
MEANINGS = (
    "alike: in the end the tees are apart by less than half of MuJoCo&#8217;s move; missed: the "
    "engine&#8217;s move is below a quarter of it;",
    "the other way: the tees turn opposite ways, by more than 2&#176; each. mm: how far the "
    "tee&#8217;s points move, root mean square by mass.",
)
FILLS = ("paper", "card", "ink", "dim", "reference", "replay")


class Measured(NamedTuple):
    """Pushes with the engine's answers. Moves [m] and turns [rad] have MuJoCo's first."""

    rollouts: Rollouts
    pushes: Pushes
    ends: Numbers  # of the engine [push, field]
    moves: Tuple[Numbers, Numbers]
    turns: Tuple[Numbers, Numbers]
    kinds: List[str]


def measure() -> Measured:
    import sim2sim

    seeds = range(FIRST_SEED, FIRST_SEED + EPISODES)
    rollouts = roll_out(sim2sim.load_policy(POLICY), seeds)
    pushes = pushes_in(rollouts, WINDOW, LEAST_MOVE)
    ends = Engine(ENGINE).answers(pushes)
    start = tee_of(pushes.start)
    ways = [displacement(start, tee_of(states)) for states in (pushes.end, ends)]
    there, here = (np.linalg.norm(way, axis=-1) for way in ways)
    turns = [
        np.mod(tee_of(states)[:, 2] - start[:, 2] + np.pi, 2 * np.pi) - np.pi
        for states in (pushes.end, ends)
    ]
    is_opposite = (turns[0] * turns[1] < 0.0) & (np.abs(turns).min(axis=0) > LEAST_TURN)
    error = figures_of(pushes, ends)["position_error"]
    kinds = np.select(
        [here < MISSED * there, error < ALIKE * there, is_opposite],
        [KINDS[3], KINDS[0], KINDS[2]],
        KINDS[1],
    )
    return Measured(rollouts, pushes, ends, (there, here), (turns[0], turns[1]), list(kinds))


def shares_of(found: Measured) -> Dict[str, Tuple[float, float, float]]:
    """Share of each kind, with the percentile interval of a bootstrap over episodes."""
    counts = np.zeros((EPISODES, len(KINDS)))
    kinds = np.array([KINDS.index(kind) for kind in found.kinds])
    np.add.at(counts, (found.pushes.episode, kinds), 1.0)
    drawn = np.random.default_rng(SEED).integers(0, EPISODES, (2000, EPISODES))
    sums = counts[drawn].sum(axis=1)
    low, high = np.quantile(sums / sums.sum(axis=1, keepdims=True), (0.025, 0.975), axis=0)
    shares = counts.sum(axis=0) / counts.sum()
    return {kind: (shares[i], low[i], high[i]) for i, kind in enumerate(KINDS)}


def number_of(found: Measured, step: int) -> int:
    """Index of the push of EPISODE that begins at a control step."""
    same = (found.pushes.start == found.rollouts.states[step, EPISODE]).all(axis=1)
    (number,) = np.flatnonzero(same & (found.pushes.episode == EPISODE))
    return int(number)


def pusher_in(kind: str, pushes: Pushes, number: int) -> Numbers:
    """Places of the pusher [step, 2] in a push, the start included."""
    import sim2sim

    world = sim2sim.make(kind)
    _, info = world.reset(options={"state": pushes.start[number]})
    states = [info["state"]]
    states += [world.step(action)[4]["state"] for action in pushes.actions[number]]
    fields = [sim2sim.STATE_FIELDS.index(name) for name in ("pusher_x", "pusher_y")]
    return np.array(states)[:, fields]


def corners(tee: Numbers) -> Numbers:
    """Outline of a tee [corner, 2]."""
    half, bar = task.TEE_HALF_WIDTH, task.BAR_HALF_LENGTH
    end = task.STEM_OFFSET + task.STEM_HALF_LENGTH
    right = np.array([(bar, half), (bar, -half), (half, -half), (half, -end)])
    left = right[::-1] * (-1.0, 1.0)
    cos, sin = np.cos(tee[2]), np.sin(tee[2])
    moved: Numbers = np.vstack([right, left]) @ np.array([[cos, sin], [-sin, cos]]) + tee[:2]
    return moved


def points(places: Numbers) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in places)


def text(x: float, y: float, words: str, look: str, size: int, extra: str = "") -> str:
    return f'<text class="{look}" x="{x:.1f}" y="{y}" font-size="{size}"{extra}>{words}</text>'


def in_words(move: float, turn: float) -> str:
    if move < 0.0005:
        return "does not move"
    side = "left" if turn > 0.0 else "right"
    return f"{1e3 * move:.0f} mm, turns {abs(np.degrees(turn)):.0f}&#176; {side}"


def panel(found: Measured, kind: str, step: int, left: float) -> List[str]:
    number = number_of(found, step)
    if found.kinds[number] != kind:
        raise ValueError(f"step {step}: the push is {found.kinds[number]}, not {kind}")
    start, *tees = (
        corners(tee_of(states)[number])
        for states in (found.pushes.start, found.pushes.end, found.ends)
    )
    ways = [pusher_in(world, found.pushes, number) for world in ("mujoco", ENGINE)]
    everything = np.vstack([start, *tees, *ways])
    middle = (everything.min(axis=0) + everything.max(axis=0)) / 2
    center = left + SIDE / 2

    def drawn(places: Numbers) -> Numbers:
        on_panel: Numbers = (places - middle) * (SCALE, -SCALE) + (center, TOP + SCENE / 2)
        return on_panel

    begin, end = step * task.CONTROL_STEP, (step + WINDOW) * task.CONTROL_STEP
    lines = [
        f'<rect class="card" x="{left:.1f}" y="{TOP}" width="{SIDE:.1f}" height="{SCENE}" rx="6"/>',
        text(center, TOP - 14, kind, "ink", 18, BOLD),
        text(left + 10, TOP + 20, f"{begin:.1f} to {end:.1f} s", "dim", 13, LEFT),
    ]
    for role, tee in zip(ROLES, tees):
        lines.append(f'<polygon class="{role}" opacity="0.8" points="{points(drawn(tee))}"/>')
    lines.append(f'<polygon class="start" points="{points(drawn(start))}"/>')
    for role, way in zip(ROLES, ways):
        lines.append(f'<polyline class="{role}-line" points="{points(drawn(way))}"/>')
        lines.append(pusher(drawn(way)[-1], f"{role}-line"))
    lines.append(pusher(drawn(ways[0])[0], "start"))
    for row, (role, name) in enumerate(ROLES.items()):
        words = in_words(found.moves[row][number], found.turns[row][number])
        lines.append(text(center, TOP + SCENE + 24 + 22 * row, f"{name}: {words}", role, 15, BOLD))
    return lines


def pusher(place: Numbers, look: str) -> str:
    x, y = place
    radius = task.PUSHER_RADIUS * SCALE
    return f'<circle class="{look}" cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}"/>'


def scale_bar() -> List[str]:
    x, y, width = MARGIN + 10, TOP + SCENE - 12, 0.05 * SCALE
    return [
        f'<rect class="dim" x="{x}" y="{y}" width="{width:.1f}" height="2"/>',
        text(x, y - 6, "50 mm", "dim", 13, LEFT),
    ]


def bar(found: Measured) -> List[str]:
    """Shares of all pushes, as segments of one bar, and what the words mean."""
    y, x = TOP + SCENE + 94, float(MARGIN)
    pushes = f"All {len(found.kinds)} pushes of {EPISODES} episodes"
    lines = [text(x, y - 12, pushes, "ink", 15, LEFT)]
    for (kind, (share, _, _)), (look, opacity) in zip(shares_of(found).items(), SEGMENTS):
        width = share * (WIDTH - 2 * MARGIN)
        lines.append(
            f'<rect class="{look}" opacity="{opacity}" x="{x:.1f}" y="{y}" '
            f'width="{width - 2:.1f}" height="14"/>'
        )
        lines.append(text(x, y + 32, f"{100 * share:.0f} % {kind}", "ink", 14, LEFT))
        x += width
    for row, words in enumerate(MEANINGS):
        lines.append(text(MARGIN, y + 58 + 18 * row, words, "dim", 13, LEFT))
    return lines


def style() -> str:
    """Classes in the light colors, and in the dark ones where those are preferred."""
    themes = []
    for palette in (LIGHT, DARK):
        rules = [f".{name} {{ fill: {palette[name]}; }}" for name in FILLS]
        rules.append(f".rest {{ fill: {palette['grid']}; }}")
        rules += [
            f".{role}-line {{ fill: none; stroke: {palette[role]}; stroke-width: 2.5; }}"
            for role in ROLES
        ]
        rules.append(
            f".start {{ fill: none; stroke: {palette['ink']}; stroke-width: 1.5; "
            "stroke-dasharray: 4, 3; }"
        )
        themes.append(" ".join(rules))
    return f"{themes[0]} @media (prefers-color-scheme: dark) {{ {themes[1]} }}"


def picture(found: Measured) -> str:
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
        f'viewBox="0 0 {WIDTH} {HEIGHT}" text-anchor="middle" stroke-linejoin="round" '
        "font-family=\"Arial, Helvetica, 'Liberation Sans', sans-serif\">",
        "<title>Three pushes in MuJoCo and in the two-mass engine</title>",
        f"<style>{style()}</style>",
        f'<rect class="paper" width="{WIDTH}" height="{HEIGHT}" rx="10"/>',
        text(WIDTH / 2, 36, "The same push in MuJoCo and in the two-mass engine", "ink", 22, BOLD),
        text(
            WIDTH / 2,
            62,
            f"the same state and the same {WINDOW} actions, half a second; policy {POLICY}, "
            f"episode {EPISODE}; dashed: the start",
            "dim",
            15,
        ),
    ]
    for place, (kind, step) in enumerate(SHOWN.items()):
        lines += panel(found, kind, step, MARGIN + place * (SIDE + GAP))
    return "\n".join([*lines, *scale_bar(), *bar(found), "</svg>", ""])


def draw() -> None:
    found = measure()
    write_file(PICTURE, picture(found).encode())
    print(f"{len(found.kinds)} pushes of {EPISODES} episodes")
    for kind, (share, low, high) in shares_of(found).items():
        print(f"{kind}: {100 * share:.1f} % [{100 * low:.1f}, {100 * high:.1f}]")


def main() -> int:
    parser = OneLineParser(prog="missed_push", description=(__doc__ or "").split("\n\n")[0])
    parser.parse_args()
    return run_command("missed_push", draw)


if __name__ == "__main__":
    raise SystemExit(main())
