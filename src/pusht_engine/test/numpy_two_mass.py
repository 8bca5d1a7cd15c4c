#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The two-mass engine in plain numpy: a slow, independent reference, and the speed of such code.

Three planar point masses: the pusher, and bar and stem of the tee, which a link holds together.
The laws and the order of operations are those of two_mass_dynamics.hpp, the code is not.
Units are SI.
"""
import argparse
import json
import math
import sys
import time
from dataclasses import replace
from typing import Callable, List, NamedTuple, NoReturn

import numpy as np

from pusht_task import task

PUSHER, BAR, STEM = range(3)
BLOCKS = [BAR, STEM]

RADII = np.array([task.PUSHER_RADIUS, 0.032, 0.026])  # [m]
SERVO_GAIN = 20.0  # [1/s]
RESTITUTION = 0.0
CONTACT_BAUMGARTE = 0.2  # share of the overlap removed in one substep
CONTACT_MARGIN = 1e-3  # [m] discs closer than this touch
COINCIDENT = 1e-12  # [m] discs closer than this have no normal
SWEEPS = 10


class Contact(NamedTuple):
    """The pusher against one mass of the tee."""

    block: int
    normal: np.ndarray  # from the mass to the pusher, of length 1
    depth: float  # [m] overlap


def link_force(q: np.ndarray, v: np.ndarray, m: np.ndarray, baumgarte: float) -> np.ndarray:
    """Force [N] on each body, [3, 2], that holds the link's length: a stabilized multiplier."""
    d, d_rate = q[BAR] - q[STEM], v[BAR] - v[STEM]
    error = 0.5 * (d @ d - task.STEM_OFFSET**2)
    error_rate = d @ d_rate
    wanted = -d_rate @ d_rate - (2 * baumgarte * error_rate + baumgarte**2 * error)
    on_bar = d * (wanted / ((1 / m[BAR] + 1 / m[STEM]) * (d @ d)))
    return np.array([[0.0, 0.0], on_bar, -on_bar])


def find_contacts(q: np.ndarray) -> List[Contact]:
    """Contacts of the pusher with bar, then stem."""
    contacts = []
    for block in BLOCKS:
        d = q[PUSHER] - q[block]
        distance = float(np.linalg.norm(d))
        depth = RADII[PUSHER] + RADII[block] - distance
        if depth > -CONTACT_MARGIN and distance > COINCIDENT:
            contacts.append(Contact(block, d / distance, depth))
    return contacts


def solve_contacts(contacts: List[Contact], m: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Velocities after projected Gauss-Seidel on the accumulated normal impulses, frictionless."""
    v = v.copy()

    def separation(contact: Contact) -> float:  # [m/s] negative while they approach
        return float((v[PUSHER] - v[contact.block]) @ contact.normal)

    targets = [
        -RESTITUTION * min(separation(c), 0.0) + CONTACT_BAUMGARTE / task.SUBSTEP * c.depth
        for c in contacts
    ]
    impulses = [0.0] * len(contacts)  # [N s]
    for _ in range(SWEEPS):
        for i, c in enumerate(contacts):
            wanted = (targets[i] - separation(c)) / (1 / m[PUSHER] + 1 / m[c.block])
            before, impulses[i] = impulses[i], max(0.0, impulses[i] + wanted)
            change = (impulses[i] - before) * c.normal
            v[PUSHER] += change / m[PUSHER]
            v[c.block] -= change / m[c.block]
    return v


class NumpyTwoMass:
    """One world; `q` [m] and `v` [m/s] are [3, 2]: pusher, bar, stem."""

    def __init__(
        self, pusher_mass: float = 4.0, block_damp: float = 6.0, baumgarte: float = 40.0
    ) -> None:  # [kg], [1/s], [rad/s]
        self.m = np.array([pusher_mass, task.BAR_MASS, task.STEM_MASS])
        self.block_damp = block_damp
        self.baumgarte = baumgarte
        self.q = np.zeros((3, 2))
        self.v = np.zeros((3, 2))

    def reset(self, start: task.WorldState) -> None:
        arm = task.STEM_OFFSET * np.array([math.sin(start.tee_yaw), -math.cos(start.tee_yaw)])
        turning = start.tee_yaw_rate * np.array([-arm[1], arm[0]])
        tee, tee_v = np.array([start.tee_x, start.tee_y]), np.array([start.tee_vx, start.tee_vy])
        self.q = np.array([[start.pusher_x, start.pusher_y], tee, tee + arm])
        self.v = np.array([[start.pusher_vx, start.pusher_vy], tee_v, tee_v + turning])

    def step(self, action: np.ndarray) -> None:
        """One control step with the commanded pusher velocity [m/s]."""
        command = np.clip(action, -task.ACTION_LIMIT, task.ACTION_LIMIT)
        for _ in range(task.SUBSTEPS_PER_CONTROL_STEP):
            self._substep(command)

    def _substep(self, command: np.ndarray) -> None:
        force = link_force(self.q, self.v, self.m, self.baumgarte)
        drag = self.block_damp * self.m[:, None] * self.v
        self.v[BLOCKS] += task.SUBSTEP * ((force - drag) / self.m[:, None])[BLOCKS]
        self.v[PUSHER] += task.SUBSTEP * SERVO_GAIN * (command - self.v[PUSHER])
        self.v = solve_contacts(find_contacts(self.q), self.m, self.v)
        self.q = self.q + task.SUBSTEP * self.v

    @property
    def yaw(self) -> float:
        """[rad] in [-pi, pi), read from the line bar to stem, which is body -y."""
        d = self.q[STEM] - self.q[BAR]
        return task.wrap_angle(math.atan2(d[1], d[0]) + math.pi / 2)


def push(world: NumpyTwoMass) -> np.ndarray:
    """Into the notch between bar and stem, where the pusher stays: two contacts, nearly always."""
    way = world.m[BLOCKS] @ world.q[BLOCKS] / world.m[BLOCKS].sum() - world.q[PUSHER]
    return way / np.linalg.norm(way)


def rest(_world: NumpyTwoMass) -> np.ndarray:
    return np.zeros(2)


def control_steps_per_second(seconds: float, contact: bool) -> float:
    """Steps for at least `seconds`, in whole episodes from spawns 0, 1, ..."""
    act: Callable[[NumpyTwoMass], np.ndarray] = push if contact else rest
    world = NumpyTwoMass()
    begin, elapsed, episodes = time.perf_counter(), 0.0, 0
    while elapsed < seconds:
        start = task.spawn(episodes)
        world.reset(start if contact else replace(start, pusher_x=10.0))  # [m] out of reach
        for _ in range(task.HORIZON):
            world.step(act(world))
        episodes += 1
        elapsed = time.perf_counter() - begin
    return episodes * task.HORIZON / elapsed


class OneLineParser(argparse.ArgumentParser):
    """Bad arguments are one line on stderr and exit code 2."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def positive_seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number > 0 [s]")
    return seconds


def main() -> int:
    parser = OneLineParser(prog="numpy_two_mass", description=__doc__)
    parser.add_argument("--seconds", type=positive_seconds, default=2.0, help="[s] to measure for")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--contact", action="store_true", help="the pusher pushes the tee")
    where.add_argument("--free", action="store_true", help="the pusher is far away, at rest")
    args = parser.parse_args()
    rate = control_steps_per_second(args.seconds, args.contact)
    print(json.dumps({"control_steps_per_second": rate}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
