#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two engines over the same starts: pair by pair, and how many episodes a difference takes."""

import sim2sim

first = sim2sim.compare("bc", engine="two_mass", episodes=20, floor=False)
other = sim2sim.compare("bc", engine="chipmunk", episodes=20, floor=False)
found = sim2sim.contrast(first, other)
print(found.figures["headline"]["answer"])
shown = found.columns["adjusted_p"] <= 0.05  # found.frame() has these columns in pandas
print(shown.sum(), "of", len(shown), "figures differ")
print(sim2sim.plan(first, other, success=0.2))
