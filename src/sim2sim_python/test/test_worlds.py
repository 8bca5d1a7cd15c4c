#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Worlds in Python: the interface of Gymnasium over the suite's own worlds."""

import math
import subprocess
import sys
import unittest
from typing import Any, Dict, Tuple

import numpy as np
import sim2sim
from numpy.testing import assert_allclose, assert_array_equal
from pusht_task.task import spawn

KINDS = ("box2d", "bullet", "chipmunk", "mujoco", "rigid_body", "two_mass")
SMALL_STEPS = {"bound_position": 1.0, "bound_angle": math.pi}


def episode_of(world: sim2sim.World, policy: sim2sim.Policy, seed: int) -> Tuple[int, Any]:
    """Steps and last info of an episode that a policy drives."""
    observation, info = world.reset(seed=seed)
    memory = policy.begin(0)
    ended = False
    while not ended:
        action = policy.act(observation[np.newaxis], [memory])[0]
        observation, _, terminated, truncated, info = world.step(action)
        ended = terminated or truncated
    return info["steps"], info


class OneWorld(unittest.TestCase):
    def test_kinds_are_the_installed_ones(self) -> None:
        self.assertLessEqual(set(KINDS), set(sim2sim.kinds()))

    def test_reset_starts_from_the_spawn_of_the_seed(self) -> None:
        start = spawn(10007)
        for kind in set(sim2sim.kinds()) - {"gym_pusht"}:  # which is of another task
            with self.subTest(kind):
                observation, info = sim2sim.make(kind).reset(seed=10007)
                self.assertEqual((observation.dtype, observation.shape), (np.float32, (10,)))
                wanted = [getattr(start, name) for name in sim2sim.STATE_FIELDS]
                np.testing.assert_allclose(info["state"], wanted, rtol=0, atol=1e-6)
                yaw = info["state"][sim2sim.STATE_FIELDS.index("tee_yaw")]
                target = (0.0, 0.0, 0.0, 1.0)
                x_y = (start.pusher_x, start.pusher_y, start.tee_x, start.tee_y)
                wanted = [*x_y, math.sin(yaw), math.cos(yaw), *target]
                np.testing.assert_allclose(observation, wanted, rtol=0, atol=2e-6)
                self.assertEqual(info["seed"], 10007)
                self.assertFalse(info["success"])

    def test_episodes_are_those_of_a_comparison_to_the_last_bit(self) -> None:
        policy = sim2sim.load_policy("expert")
        for kind in KINDS:
            with self.subTest(kind):
                columns = sim2sim.compare("expert", engine=kind, episodes=3, floor=False).episodes
                world = sim2sim.make(kind)
                for row in np.flatnonzero(columns["mode"] == "engine_closed"):
                    steps, info = episode_of(world, policy, int(columns["seed"][row]))
                    self.assertEqual(steps, columns["steps"][row])
                    self.assertEqual(info["success"], columns["success"][row])
                    self.assertEqual(
                        (info["position_error"], info["angle_error"]),
                        (
                            columns["final_position_error_m"][row],
                            columns["final_angle_error_rad"][row],
                        ),
                    )

    def test_episodes_in_gym_pushts_world_are_those_of_a_comparison_too(self) -> None:
        options: Dict[str, Any] = {"task": "gym_pusht", "horizon": 60}
        run = sim2sim.compare(
            "expert", reference="gym_pusht", engine="none", episodes=3, floor=False, **options
        )
        policy = sim2sim.load_policy("expert", task="gym_pusht")
        world = sim2sim.make("gym_pusht", **options)
        far = []
        for row, seed in enumerate(run.episodes["seed"]):
            _, info = episode_of(world, policy, int(seed))
            start = world.reset(seed=int(seed))[1]
            far.append(info["position_error"] != start["position_error"])
            self.assertEqual(info["position_error"], run.episodes["final_position_error_m"][row])
            self.assertEqual(info["angle_error"], run.episodes["final_angle_error_rad"][row])
        self.assertIn(True, far, "no tee has moved")

    def test_success_terminates_and_the_horizon_truncates(self) -> None:
        on_target = {"pusher_x": 0.3, "pusher_y": 0.3, "tee_x": 0.0, "tee_y": 0.0, "tee_yaw": 0.0}
        world = sim2sim.make("mujoco", horizon=7)
        world.reset(options={"state": on_target})
        ends = []
        for _ in range(5):  # success is five steps in tolerance
            _, reward, terminated, truncated, info = world.step([0.0, 0.0])
            ends.append((terminated, truncated))
            shaping = -0.5 * (info["position_error"] / 0.5 + info["angle_error"] / math.pi)
            self.assertEqual(reward, shaping + (1.0 if terminated else 0.0))
        self.assertEqual(ends, [(False, False)] * 4 + [(True, False)])
        with self.assertRaisesRegex(sim2sim.InvalidInput, "^step: the episode has ended"):
            world.step([0.0, 0.0])
        world.reset(seed=0)
        ends = [world.step([0.0, 0.0])[2:4] for _ in range(7)]
        self.assertEqual(ends, [(False, False)] * 6 + [(False, True)])

    def test_state_is_given_by_name_or_as_an_array(self) -> None:
        world = sim2sim.make("two_mass")
        _, info = world.reset(seed=3)
        for _ in range(3):
            _, _, _, _, info = world.step([0.3, -0.2])
        for state in (info["state"], dict(zip(sim2sim.STATE_FIELDS, info["state"]))):
            _, again = world.reset(options={"state": state})
            assert_array_equal(again["state"], info["state"])
            self.assertNotIn("seed", again)

    def test_each_field_of_a_state_is_its_own(self) -> None:
        values = (0.3, 0.25, 0.02, 0.03, -0.1, -0.05, 0.4, 0.05, -0.06, 0.07)
        state = dict(zip(sim2sim.STATE_FIELDS, values))
        _, info = sim2sim.make("two_mass").reset(options={"state": state})
        assert_allclose(info["state"], values, rtol=0.0, atol=1e-12)

    def test_resets_without_a_seed_follow_from_the_last_seed(self) -> None:
        def drawn() -> Any:
            world = sim2sim.make("two_mass")
            return [world.reset(seed=5)[1]["seed"], *(world.reset()[1]["seed"] for _ in range(50))]

        seeds = drawn()
        self.assertEqual(seeds, drawn())
        self.assertGreater(len(set(seeds)), 40)
        self.assertLess(max(seeds), sim2sim.FIRST_SPAWN_SEED)  # the others are for comparisons

    def test_worlds_without_any_seed_differ(self) -> None:
        seeds = {sim2sim.make("two_mass").reset()[1]["seed"] for _ in range(10)}
        self.assertGreater(len(seeds), 5)

    def test_parameters_by_keyword(self) -> None:
        def after_a_push(**parameters: Any) -> Any:
            world = sim2sim.make("two_mass", **parameters)
            world.reset(options={"state": [-0.2, 0, 0, 0, -0.1, 0, 0.3, 0.5, 0, 0]})
            return world.step([1.0, 0.0])[4]["state"]

        assert_array_equal(after_a_push(), after_a_push(block_damp=6))
        self.assertFalse((after_a_push() == after_a_push(block_damp=20.0)).all())
        names = [parameter["name"] for parameter in sim2sim.parameters("two_mass")]
        self.assertIn("block_damp", names)

    def test_bad_input_is_one_line_and_leaves_the_world(self) -> None:
        world = sim2sim.make("two_mass")
        with self.assertRaisesRegex(sim2sim.InvalidInput, "^step: the episode .* reset the world$"):
            world.step([0, 0])
        _, info = world.reset(seed=1)
        refused = (
            (lambda: world.step([math.nan, 0.0]), "action .*must be finite"),
            (lambda: world.step([0.0, 0.0, 0.0]), r"^action float64 of shape \(3,\): must be real"),
            (lambda: world.step("up"), "^action <U2 of shape"),
            (lambda: world.step([[0.0], []]), "^action .*inhomogeneous"),  # type: ignore
            (lambda: world.reset(seed=-1), "^seed -1: must be from 0 to 18446744073709551615$"),
            (lambda: world.reset(seed=1.5), "^seed 1.5: must be an integer$"),  # type: ignore
            (lambda: world.reset(options=3), "^options 3: must be a dict$"),  # type: ignore
            (lambda: sim2sim.make(3), "^kind 3: must be text"),  # type: ignore[call-overload]
            (lambda: world.reset(options={"tee": 1}), r"^options \['tee'\]: unknown; known: state"),
            (
                lambda: world.reset(options={"state": {"x": 1}}),
                "^state x: unknown; known: pusher_x",
            ),
            (lambda: world.reset(options={"state": {}}), "^state: pusher_x is missing"),
            (lambda: world.reset(options={"state": [math.nan] * 10}), "must be finite"),
            (
                lambda: sim2sim.make("two_mas"),
                "^simulator 'two_mas': unknown; known: box2d, bullet, chipmunk, ",
            ),
            (lambda: sim2sim.make("two_mass", block_damp=110), "^block_damp 110.0: must be from"),
            (lambda: sim2sim.make("two_mass", damp=1), "^parameter 'damp': unknown; known: "),
            (lambda: sim2sim.make("two_mass", horizon=0), "^horizon 0: must be from 1 to"),
            (lambda: sim2sim.make_vec("two_mass", 0), "^num_envs 0: must be from 1 to"),
        )
        for call, line in refused:
            with self.subTest(line):
                with self.assertRaisesRegex(sim2sim.InvalidInput, line) as caught:
                    call()  # type: ignore[no-untyped-call]
                self.assertEqual(caught.exception.exit_code, 2)
                self.assertNotIn("\n", str(caught.exception))
        assert_array_equal(world.step([0.0, 0.0])[4]["steps"], 1)

    def test_a_world_that_fails_says_so(self) -> None:
        """A soft link does not survive a tee that is hit at full speed."""
        world = sim2sim.make("two_mass", baumgarte=10)
        observation, _ = world.reset(seed=10003)
        with self.assertRaisesRegex(sim2sim.SimulationFault, "must be within") as caught:
            for _ in range(sim2sim.HORIZON):
                charge = np.clip(100.0 * (observation[2:4] - observation[0:2]), -1.0, 1.0)
                observation = world.step(charge)[0]
        self.assertEqual(caught.exception.exit_code, 4)
        self.assertIsInstance(caught.exception, sim2sim.RuntimeFault)
        world.reset(seed=10003)
        world.step([0.0, 0.0])

    def test_spaces(self) -> None:
        world = sim2sim.make("two_mass")
        world.action_space.seed(0)
        action = world.action_space.sample()
        self.assertTrue(world.action_space.contains(action))
        self.assertFalse(world.action_space.contains(2 * np.ones(2)))
        self.assertEqual(world.observation_space.shape, (10,))
        self.assertIs(world.unwrapped, world)
        self.assertEqual(repr(world.action_space), "Box(-1.0, 1.0, (2,), float32)")


class EndOfTheInterpreter(unittest.TestCase):
    """Daemon threads that are within C++ then do not end the process."""

    def assert_ends(self, work: str) -> None:
        program = (
            "import numpy, sim2sim, threading\n"
            "begun = threading.Semaphore(0)\n"
            "def run():\n"
            f"    {work}\n"
            "for _ in range(3):\n"
            "    threading.Thread(target=run, daemon=True).start()\n"
            "    begun.acquire()\n"
        )
        for _ in range(5):
            process = subprocess.run(
                [sys.executable, "-c", program], capture_output=True, timeout=60, text=True
            )
            self.assertEqual((process.returncode, process.stderr), (0, ""))

    def test_steps_of_a_world(self) -> None:
        self.assert_ends(
            "world = sim2sim.make('two_mass'); world.reset(seed=0); begun.release()\n"
            "    while True: world.step(numpy.zeros(2)) if world.reset(seed=1) else 0"
        )

    def test_answers_of_a_policy(self) -> None:
        self.assert_ends(
            "policy = sim2sim.load_policy('expert'); begun.release()\n"
            "    rows = numpy.zeros((16, 10), numpy.float32)\n"
            "    memories = [policy.begin(row) for row in range(16)]\n"
            "    while True: policy.act(rows, memories)"
        )


class ManyWorlds(unittest.TestCase):
    def test_each_row_is_a_single_world_to_the_last_bit(self) -> None:
        for kind in KINDS:
            with self.subTest(kind):
                worlds = sim2sim.make_vec(kind, 5)
                singles = [sim2sim.make(kind) for _ in range(5)]
                observations, _ = worlds.reset(seed=20)
                rows = [world.reset(seed=20 + i)[0] for i, world in enumerate(singles)]
                assert_array_equal(observations, rows)
                random = np.random.default_rng(0)
                for _ in range(30):
                    actions = random.uniform(-1.0, 1.0, (5, 2))
                    found: Any = worlds.step(actions)
                    wanted: Any = [world.step(one) for world, one in zip(singles, actions)]
                    for i in range(4):
                        assert_array_equal(found[i], [step[i] for step in wanted])
                    assert_array_equal(found[4]["state"], [step[4]["state"] for step in wanted])

    def test_step_after_an_end_begins_the_next_episode(self) -> None:
        worlds = sim2sim.make_vec("two_mass", 2, horizon=3)
        mode = worlds.metadata["autoreset_mode"]  # of Gymnasium, where it can be imported
        self.assertEqual((worlds.num_envs, getattr(mode, "value", mode)), (2, "NextStep"))
        worlds.reset(seed=[5, None])
        for _ in range(2):
            _, _, terminated, truncated, _ = worlds.step(np.ones((2, 2)))
            self.assertFalse((terminated | truncated).any())
        last, _, _, truncated, info = worlds.step(np.ones((2, 2)))
        self.assertTrue(truncated.all())
        first, rewards, terminated, truncated, info = worlds.step(np.full((2, 2), 1.0))
        self.assertFalse((terminated | truncated).any())
        assert_array_equal(rewards, [0.0, 0.0])
        assert_array_equal(info["steps"], [0, 0])
        single = sim2sim.make("two_mass")
        single.reset(seed=5)
        observation, of_single = single.reset()  # what follows from seed 5
        assert_array_equal(first[0], observation)
        self.assertNotEqual(of_single["seed"], 5)
        self.assertEqual(int(info["seed"][0]), of_single["seed"])
        self.assertEqual(info["_seed"].tolist(), [True, True])
        self.assertFalse((first == last).all())
        info = worlds.step(np.ones((2, 2)))[4]
        assert_array_equal(info["steps"], [1, 1])
        self.assertNotIn("seed", info, "no episode has begun")

    def test_one_world_that_ends_leaves_the_others(self) -> None:
        on_target = [0.3, 0.3, 0, 0, 0, 0, 0, 0, 0, 0]
        elsewhere = [0.3, 0.3, 0, 0, -0.1, 0, 1, 0, 0, 0]
        worlds = sim2sim.make_vec("mujoco", 2)
        _, info = worlds.reset(options={"state": [on_target, elsewhere]})
        still = np.zeros((2, 2))
        for _ in range(5):
            _, rewards, terminated, _, _ = worlds.step(still)
        assert_array_equal(terminated, [True, False])
        self.assertGreater(rewards[0], 0.9)
        _, _, terminated, _, info = worlds.step(still)
        assert_array_equal(terminated, [False, False])
        assert_array_equal(info["steps"], [0, 6])

    def test_bad_input_is_one_line(self) -> None:
        worlds = sim2sim.make_vec("two_mass", 3)
        with self.assertRaisesRegex(sim2sim.InvalidInput, "^step: no episode has begun"):
            worlds.step(np.zeros((3, 2)))
        worlds.reset(seed=0)
        nan = np.zeros((3, 2))
        nan[1, 0] = math.nan
        for call, line in (
            (lambda: worlds.step(nan), "^world 1: step: action .*must be finite"),
            (lambda: worlds.step(np.zeros((2, 2))), r"^actions float64 of shape \(2, 2\): must be"),
            (lambda: worlds.reset(seed=[1, 2]), "^seed: 2 seeds; must be 3, or one$"),
            (
                lambda: worlds.reset(seed=2**64 - 2),
                "^seed 18446744073709551614: must be from 0 to 18446744073709551613$",
            ),
        ):
            with self.subTest(line), self.assertRaisesRegex(sim2sim.InvalidInput, line):
                call()  # type: ignore[no-untyped-call]


if __name__ == "__main__":
    unittest.main()
