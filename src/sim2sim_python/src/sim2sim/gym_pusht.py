# SPDX-License-Identifier: BSD-3-Clause
"""gym-pusht's environment. In a program that was written for gym-pusht the import is all that
changes: `import sim2sim.gym_pusht` for `import gym_pusht`, and

    from sim2sim.gym_pusht import PushTEnv

for `from gym_pusht.envs import PushTEnv`.
"""

from sim2sim.gym import register_gym_pusht
from sim2sim.pixel_world import PushTEnv, PushTVectorEnv
from sim2sim.sight import Sight

__all__ = ["PushTEnv", "PushTVectorEnv", "Sight"]

register_gym_pusht("gym_pusht/PushT-v0")
