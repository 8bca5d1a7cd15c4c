# SPDX-License-Identifier: BSD-3-Clause
"""Exercise 2: what a policy sees of the two-mass engine. Fill in the two blanks."""

from typing import List, Sequence


def yaw_of(bar: Sequence[float], stem: Sequence[float]) -> float:
    """The tee's yaw [rad] in [-pi, pi), from where its two masses are (x, y) [m].

    The engine has no variable for the yaw. At yaw 0 the stem's mass lies below the bar's:
    stem - bar = (0, -0.06).
    """
    raise NotImplementedError("yaw_of")


def observation_of(pusher: Sequence[float], bar: Sequence[float], yaw: float) -> List[float]:
    """The ten numbers that every policy gets, in their order.

    Pusher x, y; tee x, y (the tee's origin is the middle of its bar); sine and cosine of the tee's
    yaw; then the same three for the target, which is at (0, 0) with yaw 0.
    """
    raise NotImplementedError("observation_of")
