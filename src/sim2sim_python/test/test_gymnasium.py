#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Worlds as environments of Gymnasium, where it can be imported: its checker, wrappers and names,
and the same bits in each way to step them."""

import unittest
import warnings
from typing import Any, List, Tuple

import numpy as np
import sim2sim
from numpy.testing import assert_array_equal

try:
    import gymnasium  # type: ignore[import]
    import gymnasium.vector  # type: ignore[import]

    needs_gymnasium = unittest.skipIf(False, "")
except ImportError:
    needs_gymnasium = unittest.skip("Gymnasium cannot be imported here")

KINDS = ("box2d", "bullet", "chipmunk", "mujoco", "rigid_body", "two_mass")
WORLDS, HORIZON, STEPS = 3, 12, 40


def name_of(kind: str) -> str:
    return f"sim2sim/PushT-{kind}-v0"


@needs_gymnasium
class OneWorld(unittest.TestCase):
    def test_classes_and_spaces_are_gymnasiums(self) -> None:
        world, worlds = sim2sim.make("two_mass"), sim2sim.make_vec("two_mass", 2)
        self.assertIsInstance(world, gymnasium.Env)
        self.assertIsInstance(worlds, gymnasium.vector.VectorEnv)
        Box = gymnasium.spaces.Box
        self.assertEqual(world.action_space, Box(-1.0, 1.0, (2,), np.float32))
        self.assertEqual(world.observation_space, Box(-np.inf, np.inf, (10,), np.float32))
        self.assertEqual(worlds.single_action_space, world.action_space)
        batched = gymnasium.vector.utils.batch_space(world.observation_space, 2)
        self.assertEqual(worlds.observation_space, batched)
        next_step = gymnasium.vector.AutoresetMode.NEXT_STEP
        self.assertIs(worlds.metadata["autoreset_mode"], next_step)

    def test_the_checker_passes(self) -> None:
        from gymnasium.utils.env_checker import check_env  # type: ignore[import]

        for kind in KINDS:
            with self.subTest(kind), warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                world = gymnasium.make(name_of(kind), disable_env_checker=True)
                check_env(world.unwrapped)
                said = {str(warning.message) for warning in caught}
                self.assertEqual(len(said), 2, said)  # an observation has no bounds
                self.assertTrue(all("observation space m" in words for words in said), said)

    def test_names(self) -> None:
        for kind in sim2sim.kinds():
            self.assertIn(name_of(kind), gymnasium.registry)
        world = gymnasium.make(name_of("mujoco"), timestep=0.005, horizon=7)
        self.assertEqual((world.unwrapped.kind, world.unwrapped.horizon), ("mujoco", 7))
        with self.assertRaisesRegex(sim2sim.InvalidInput, "^parameter 'step': unknown"):
            gymnasium.make(name_of("mujoco"), step=1)
        worlds = gymnasium.make_vec(name_of("mujoco"), num_envs=2, timestep=0.005)
        self.assertIsInstance(worlds, sim2sim.VectorWorld)
        self.assertEqual(worlds.num_envs, 2)

    def test_wrappers(self) -> None:
        wrappers = gymnasium.wrappers
        world = wrappers.RecordEpisodeStatistics(wrappers.TimeLimit(sim2sim.make("two_mass"), 5))
        world = wrappers.RescaleAction(wrappers.FlattenObservation(world), -2.0, 2.0)
        self.assertIsInstance(world.unwrapped, sim2sim.World)
        world.reset(seed=1)
        rewards = []
        for _ in range(5):
            _, reward, _, truncated, info = world.step(np.full(2, 2.0, np.float32))
            rewards.append(reward)
        self.assertTrue(truncated)
        self.assertEqual(info["episode"]["l"], 5)
        self.assertAlmostEqual(info["episode"]["r"], sum(rewards), 5)


def actions_of(step: int) -> Any:
    return np.random.default_rng(step).uniform(-1.0, 1.0, (WORLDS, 2)).astype(np.float32)


def stepped(worlds: Any) -> List[Tuple[Any, ...]]:
    """What a vector environment gives, over ends of episodes."""
    observations, info = worlds.reset(seed=20)
    found: List[Tuple[Any, ...]] = [(observations, info["state"], info["seed"])]
    for step in range(STEPS):
        observations, rewards, terminated, truncated, info = worlds.step(actions_of(step))
        found.append((observations, rewards, terminated, truncated, info["state"], info["steps"]))
    return [tuple(np.array(part) for part in parts) for parts in found]


def stepped_one_by_one() -> List[Tuple[Any, ...]]:
    """Likewise, of single worlds, each of which is reset in the step after its end."""
    worlds = [gymnasium.make(name_of("two_mass"), horizon=HORIZON) for _ in range(WORLDS)]
    starts = [world.reset(seed=20 + i) for i, world in enumerate(worlds)]
    found: List[Tuple[Any, ...]] = [
        (
            np.array([observation for observation, _ in starts]),
            np.array([info["state"] for _, info in starts]),
            np.array([info["seed"] for _, info in starts]),
        )
    ]
    ended = [False] * WORLDS
    for step in range(STEPS):
        rows: List[Tuple[Any, ...]] = []
        for i, (world, action) in enumerate(zip(worlds, actions_of(step))):
            if ended[i]:
                observation, info = world.reset()
                reward, terminated, truncated = 0.0, False, False
            else:
                observation, reward, terminated, truncated, info = world.step(action)
            ended[i] = terminated or truncated
            rows.append((observation, reward, terminated, truncated, info["state"], info["steps"]))
        found.append(tuple(np.array(column) for column in zip(*rows)))
    return found


@needs_gymnasium
class ManyWorlds(unittest.TestCase):
    def test_same_seeds_same_bits_in_all_three(self) -> None:
        def make() -> Any:
            return gymnasium.make(name_of("two_mass"), horizon=HORIZON)

        singles = stepped_one_by_one()
        synchronous = stepped(gymnasium.vector.SyncVectorEnv([make] * WORLDS))
        own = stepped(gymnasium.make_vec(name_of("two_mass"), WORLDS, horizon=HORIZON))
        self.assertTrue(any(step[3].any() for step in own[1:]))
        for number, rows in enumerate(zip(singles, synchronous, own)):
            for one, other, third in zip(*rows):
                assert_array_equal(one, other, str(number))
                assert_array_equal(one, third, str(number))

    def test_wrappers(self) -> None:
        wrappers = gymnasium.wrappers.vector
        worlds = wrappers.RecordEpisodeStatistics(sim2sim.make_vec("two_mass", 2, horizon=4))
        worlds = wrappers.DictInfoToList(wrappers.ClipReward(worlds, -1.0, 1.0))
        worlds.reset(seed=0)
        for _ in range(4):
            infos = worlds.step(worlds.action_space.sample())[4]
        self.assertEqual([info["episode"]["l"] for info in infos], [4, 4])
        worlds.close()


if __name__ == "__main__":
    unittest.main()
