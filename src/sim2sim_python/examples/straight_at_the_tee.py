#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A plain function as a policy, compared in two simulators."""

import numpy as np
import sim2sim


def straight_at_the_tee(observations: np.ndarray) -> np.ndarray:
    """Velocity [m/s]: the way from the pusher to the tee [m], five times a second."""
    return 5.0 * (observations[:, 2:4] - observations[:, 0:2])


results = sim2sim.compare(straight_at_the_tee, engine="chipmunk", episodes=20)
print(results)
print(results.summary["mj_success_rate"], results.episodes["final_angle_error_rad"].mean())
