# SPDX-License-Identifier: BSD-3-Clause
"""Exercise 2, solved."""

import math
from typing import List, Sequence


def yaw_of(bar: Sequence[float], stem: Sequence[float]) -> float:
    line = math.atan2(stem[1] - bar[1], stem[0] - bar[0])  # which is yaw - pi/2
    return (line + 1.5 * math.pi) % (2.0 * math.pi) - math.pi


def observation_of(pusher: Sequence[float], bar: Sequence[float], yaw: float) -> List[float]:
    return [*pusher, *bar, math.sin(yaw), math.cos(yaw), 0.0, 0.0, 0.0, 1.0]
