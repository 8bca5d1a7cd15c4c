# SPDX-License-Identifier: BSD-3-Clause
"""The task PushT, as far as Python needs it, with the numbers of constants.hpp in SI units."""

import json
import math
from dataclasses import dataclass
from typing import Optional

import numpy as np

from pusht_task.error import Error, clipped

CONTROL_STEP = 0.1  # [s] an action is held for ten substeps
SUBSTEP = 0.01  # [s]
SUBSTEPS_PER_CONTROL_STEP = 10
HORIZON = 300  # control steps after which an episode ends
ACTION_LIMIT = 1.0  # [m/s] per axis
FULL_CIRCLE = "full_circle"  # the task whose numbers these are
ACTION_LIMITS = {FULL_CIRCLE: ACTION_LIMIT, "gym_pusht": None}  # None: actions are not clipped

SPAWN_RADIUS_MIN = 0.10  # [m]
SPAWN_RADIUS_MAX = 0.24  # [m]
SPAWN_PUSHER_BOUND = 0.32  # [m] per axis
SPAWN_PUSHER_CLEARANCE = 0.13  # [m] from the tee origin

# The tee is a bar, centered on the tee origin, and a stem below it (body frame: stem along -y).
PUSHER_RADIUS = 0.015  # [m]
BAR_HALF_LENGTH = 0.06  # [m] along body x
STEM_HALF_LENGTH = 0.045  # [m] along body y
TEE_HALF_WIDTH = 0.015  # [m] the other half-size of bar and stem
STEM_OFFSET = 0.06  # [m] from the bar's center to the stem's, along body -y
BAR_MASS = 0.06  # [kg]
STEM_MASS = 0.045  # [kg]
CENTER_OF_MASS_OFFSET = STEM_OFFSET * STEM_MASS / (BAR_MASS + STEM_MASS)  # [m] along body -y
WALL_INNER_FACE = 0.39  # [m] |x| or |y|

# Trust in a simulator.
START_TOLERANCE = 1e-6  # [m, rad, m/s, rad/s] how far a world may be from the start it was reset to
PLAUSIBLE_DISTANCE = 1000.0  # [m] per axis; what lies beyond is a simulation that has failed
PLAUSIBLE_SPEED = 100000.0  # [m/s] per axis
PLAUSIBLE_YAW = 1000.0  # [rad] of an initial state, before it is wrapped to [-pi, pi)
PLAUSIBLE_YAW_RATE = 1000000.0  # [rad/s]

# Frames above the table: the middles of the bodies.
TEE_FRAME_HEIGHT = 0.015  # [m]
PUSHER_FRAME_HEIGHT = 0.02  # [m]


@dataclass(frozen=True)
class WorldState:
    """Poses and velocities in the table frame: origin at the target, z up. As in the message."""

    pusher_x: float = 0.0  # [m]
    pusher_y: float = 0.0  # [m]
    pusher_vx: float = 0.0  # [m/s]
    pusher_vy: float = 0.0  # [m/s]
    tee_x: float = 0.0  # [m] tee origin: the center of the bar
    tee_y: float = 0.0  # [m]
    tee_yaw: float = 0.0  # [rad] in [-pi, pi), about z
    tee_vx: float = 0.0  # [m/s] of the tee origin
    tee_vy: float = 0.0  # [m/s]
    tee_yaw_rate: float = 0.0  # [rad/s]


def action_limit_of(task: str) -> Optional[float]:
    """[m/s, or unit of the task's frame] Greatest action per axis of a task, from its name or the
    JSON that a run carries; None: actions are not clipped. Raises Error for another text."""
    if task in ACTION_LIMITS:
        return ACTION_LIMITS[task]
    try:
        limit = json.loads(task)["action_limit"]
        return None if limit is None else float(limit)
    except (ValueError, TypeError, KeyError, RecursionError):
        known = ", ".join(ACTION_LIMITS)
        raise Error(
            f"task '{clipped(task, 40)}': must be one of {known}, or a task's JSON"
        ) from None


def wrap_angle(angle: float) -> float:
    """`angle` [rad] wrapped to [-pi, pi); one that lies there already keeps its bits."""
    if -math.pi <= angle < math.pi:
        return angle
    wrapped = math.remainder(angle, 2.0 * math.pi)  # exact, in [-pi, pi]
    return wrapped if wrapped < math.pi else -math.pi


def spawn(seed: int) -> WorldState:
    """The start drawn from a seed: tee on a ring around the target, pusher clear of it, at rest."""
    generator = np.random.default_rng(seed)
    radius = generator.uniform(SPAWN_RADIUS_MIN, SPAWN_RADIUS_MAX)
    bearing = generator.uniform(0.0, 2.0 * math.pi)
    tee = radius * np.array([np.cos(bearing), np.sin(bearing)])
    yaw = generator.uniform(-math.pi, math.pi)
    while True:
        pusher = generator.uniform(-SPAWN_PUSHER_BOUND, SPAWN_PUSHER_BOUND, size=2)
        if np.linalg.norm(pusher - tee) > SPAWN_PUSHER_CLEARANCE:
            return WorldState(
                pusher_x=float(pusher[0]),
                pusher_y=float(pusher[1]),
                tee_x=float(tee[0]),
                tee_y=float(tee[1]),
                tee_yaw=yaw,
            )
