#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""gym-pusht's environment: its arrays to the last bit, on its own physics and on other engines."""

import json
import os
import select
import signal
import subprocess
import sys
import unittest
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Tuple
from unittest import mock

import numpy as np
import sim2sim
from numpy.testing import assert_array_equal
from sim2sim import renderers
from sim2sim.gym_pusht import PushTEnv, Sight

try:
    import gymnasium  # type: ignore[import]
    import gymnasium.vector  # type: ignore[import]

    needs_gymnasium = unittest.skipIf(False, "")
except ImportError:
    needs_gymnasium = unittest.skip("Gymnasium cannot be imported here")
try:
    import cv2  # type: ignore[import]
    import pygame  # type: ignore[import]
    from sim2sim import pictures

    DRAWS_AS_RECORDED = pygame.version.ver == "2.1.2" and cv2.__version__.startswith("4.6.")
    needs_pictures = unittest.skipIf(False, "")
except ImportError:
    DRAWS_AS_RECORDED = False
    needs_pictures = unittest.skip("pygame or OpenCV cannot be imported here")

DATA = Path(__file__).resolve().parents[2] / "pusht_testing" / "data"
NUMBERS = np.random.default_rng(2).uniform(50, 450, (48, 18))  # of images
MOST = 30.0  # [s] that a process may take to start or end
OBS_TYPES = ("state", "environment_state_agent_pos", "pixels", "pixels_agent_pos")
TURN = 2.0 * np.pi


def golden(name: str) -> Dict[str, Any]:
    """What gym-pusht 0.1.5 has recorded."""
    return dict(json.loads((DATA / name).read_text()))


def assert_same(one: Any, other: Any) -> None:
    """Equal arrays, or dicts of equal arrays, with equal types."""
    if isinstance(one, dict):
        assert set(one) == set(other), (set(one), set(other))
        for name, array in one.items():
            assert_same(array, other[name])
    else:
        assert_array_equal(one, other)
        assert np.asarray(one).dtype == np.asarray(other).dtype


@contextmanager
def two_renderers() -> Iterator[renderers.Renderers]:
    """Two processes beside this one, which draw."""
    with mock.patch.object(os, "sched_getaffinity", return_value={0, 1, 2}):
        drawing = renderers.Renderers()
    try:
        drawing.images(NUMBERS, 96, 96)
        assert len(drawing.others) == 2
        assert all(renderer.is_ready(patience=MOST) for renderer in drawing.others)
        with mock.patch.object(renderers, "images", drawing.images):
            yield drawing
    finally:
        drawing.end()


class AsRecorded(unittest.TestCase):
    def test_every_control_step_of_the_recorded_episodes(self) -> None:
        recorded = golden("gym_pusht.json")
        names = recorded["columns"]
        env = sim2sim.make("gym_pusht", obs_type="environment_state_agent_pos")
        steps = 0
        for episode in recorded["episodes"]:
            env.reset(seed=episode["seed"])
            for numbers in episode["rows"]:
                row = dict(zip(names, numbers))
                action = np.array([row["action_x"], row["action_y"]])
                observation, reward, terminated, truncated, info = env.step(action)
                assert_array_equal(info["pos_agent"], [row["agent_x"], row["agent_y"]])
                assert_array_equal(info["vel_agent"], [row["agent_vx"], row["agent_vy"]])
                pose = [row["block_x"], row["block_y"], row["block_angle"]]
                assert_array_equal(info["block_pose"], pose)
                assert_array_equal(observation["agent_pos"], info["pos_agent"])
                self.assertAlmostEqual(info["coverage"], row["coverage"], delta=1e-9)
                self.assertAlmostEqual(reward, row["reward"], delta=1e-9)
                self.assertEqual(terminated, row["coverage"] > 0.95)
                self.assertFalse(truncated)
                steps += 1
            assert_array_equal(observation["environment_state"], episode["keypoints_at_end"])
        self.assertEqual(steps, 960)

    def test_resets_to_states_and_from_seeds(self) -> None:
        recorded = golden("gym_pusht_resets.json")
        env = PushTEnv()
        for reset in recorded["given"]:
            observation, info = env.reset(options={"reset_to_state": reset["asked"]})
            assert_array_equal(observation, reset["observed"])
            self.assertEqual(info["is_success"], False)
        for reset in recorded["seeds"]:
            observation, info = env.reset(seed=reset["seed"])
            self.assertEqual(observation.dtype, np.float64)
            assert_array_equal(observation[:4], reset["observed"][:4])
            self.assertEqual(info["block_pose"][2], reset["block_angle"])
            self.assertEqual(observation[4], reset["block_angle"] % TURN)

    @needs_pictures
    @unittest.skipUnless(DRAWS_AS_RECORDED, "the bytes are those of pygame 2.1.2 and OpenCV 4.6")
    def test_images(self) -> None:
        with np.load(DATA / "gym_pusht_images.npz") as recorded:
            states, images = recorded["states"], recorded["images"]
        with_velocity = np.insert(states, [2, 2], 0.0, axis=1)
        drawn = Sight("pixels").of(with_velocity)
        assert_same(drawn, images)

    def test_contacts_are_counted(self) -> None:
        """One in a thousand points, rounded up, as gym-pusht divides them."""
        env = PushTEnv()
        _, info = env.reset(options={"reset_to_state": [100, 100, 300, 300, 0]})
        self.assertEqual(info["n_contacts"], 0)
        *_, info = env.step([300.0, 300.0])
        self.assertEqual(info["n_contacts"], 0)
        for _ in range(10):
            *_, info = env.step([300.0, 300.0])
        self.assertEqual(info["n_contacts"], 1)


class Environment(unittest.TestCase):
    def test_arguments_change_the_world(self) -> None:
        def end(**arguments: Any) -> List[float]:
            env = PushTEnv(**arguments)
            _, info = env.reset(seed=1)
            for _ in range(30):
                *_, info = env.step(info["block_pose"][:2] + [40.0, 20.0])
            return list(info["block_pose"])

        usual = end()
        self.assertEqual(end(damping=0.0), usual)
        each: Tuple[Dict[str, Any], ...] = (
            {"damping": 0.5},
            {"block_cog": (0.0, 30.0)},
            {"engine": "chipmunk"},
        )
        for changed in each:
            self.assertNotEqual(end(**changed), usual, changed)

    def test_damping_is_the_share_that_is_left_after_a_second(self) -> None:
        """A tee that was hit coasts: from step to step its way shrinks by damping^0.1."""
        for damping in (0.2, 0.5):
            env = PushTEnv(damping=damping)
            env.reset(options={"reset_to_state": [256, 100, 256, 200, 0]})
            ways = []
            before = np.zeros(2)
            for step in range(12):
                *_, info = env.step([256.0, 205.0 if step < 5 else 100.0])
                ways.append(info["block_pose"][1] - before[1])
                before = info["block_pose"]
            ratios = np.array(ways[9:]) / np.array(ways[8:-1])
            np.testing.assert_allclose(ratios, damping**0.1, rtol=1e-6)

    def test_other_engines_have_the_same_reset(self) -> None:
        given = {"reset_to_state": [100.0, 120.0, 300.0, 280.0, 7.5]}
        expected, _ = PushTEnv().reset(options=given)
        for engine in ("mujoco", "rigid_body", "chipmunk", "box2d", "bullet"):
            with self.subTest(engine):
                env = sim2sim.make("gym_pusht", obs_type="state", engine=engine)
                observation, info = env.reset(options=given)
                np.testing.assert_allclose(observation, expected, atol=1e-4)
                self.assertAlmostEqual(info["block_pose"][2], 7.5, places=6)
                moved, *_, info = [env.step([300.0, 300.0]) for _ in range(20)][-1]
                self.assertGreater(float(np.abs(moved - observation)[2:].max()), 1.0)
                self.assertAlmostEqual(info["block_pose"][2] - moved[4], TURN, places=9)
        by_kind = sim2sim.make("mujoco", obs_type="state", timestep=0.005)
        self.assertEqual(by_kind.engine, "mujoco")

    def test_a_reset_without_a_seed_follows_from_the_last_one(self) -> None:
        def draws() -> List[List[float]]:
            env = PushTEnv()
            env.reset(seed=5)
            return [list(env.reset()[0]) for _ in range(3)]

        self.assertEqual(draws(), draws())
        self.assertEqual(len({tuple(start) for start in draws()}), 3)

    def test_made_by_name_it_ends_at_the_horizon(self) -> None:
        env = sim2sim.make("gym_pusht", obs_type="state", horizon=3)
        env.reset(seed=1)
        self.assertEqual([env.step([256, 256])[3] for _ in range(3)], [False, False, True])

    def test_observations_are_in_their_spaces(self) -> None:
        for obs_type in OBS_TYPES if DRAWS_AS_RECORDED else OBS_TYPES[:2]:
            with self.subTest(obs_type):
                env = PushTEnv(obs_type=obs_type)
                observation, _ = env.reset(seed=2)
                self.assertTrue(env.observation_space.contains(observation))
                self.assertTrue(env.observation_space.contains(env.observation_space.sample()))
                self.assertFalse(env.observation_space.contains({}))
                assert_same(env.get_obs(), observation)

    def test_a_refused_state_leaves_vectors_to_be_reset(self) -> None:
        vector = sim2sim.make_vec("gym_pusht", 2, obs_type="state")
        vector.reset(seed=1)
        states = [[100.0, 100.0, 300.0, 300.0, 0.0], [1e300, 0.0, 0.0, 0.0, 0.0]]
        with self.assertRaisesRegex(sim2sim.InvalidInput, "reset_to_state"):
            vector.reset(options={"reset_to_state": states})
        with self.assertRaisesRegex(sim2sim.InvalidInput, "no episode has begun"):
            vector.step(np.zeros((2, 2)))

    @needs_pictures
    def test_a_window_shows_the_world(self) -> None:
        with mock.patch.dict(os.environ, SDL_VIDEODRIVER="dummy"):
            env = PushTEnv(render_mode="human")
            env.reset(seed=1)
            shown = pygame.surfarray.array3d(pygame.display.get_surface())
            self.assertIsNone(env.render())
            env.close()
        self.assertFalse(pygame.display.get_init())
        self.assertEqual(shown.shape, (512, 512, 3))
        pusher = env.get_obs()[:2].astype(int)
        self.assertEqual(tuple(shown[tuple(pusher)]), (78, 126, 255), "lighter than its rim")

    @needs_pictures
    def test_pictures_have_the_sizes_that_were_asked_for(self) -> None:
        sizes: Dict[str, Any] = {"observation_width": 64, "observation_height": 48}
        env = PushTEnv(obs_type="pixels_agent_pos", **sizes, visualization_width=320)
        observation, _ = env.reset(seed=1)
        self.assertEqual(observation["pixels"].shape, (48, 64, 3))
        self.assertEqual(env.render().shape, (680, 320, 3))

    @needs_pictures
    def test_an_image_of_the_past_is_the_one_that_was_drawn(self) -> None:
        states = np.random.default_rng(1).uniform(50, 450, (5, 7))
        sight = Sight("pixels")
        alone = [Sight("pixels").of(state[np.newaxis])[0] for state in states]
        for step in range(4):
            past = sight.with_past(states[np.newaxis, [max(step - 1, 0), step]])
            assert_array_equal(past[0], [alone[max(step - 1, 0)], alone[step]])

    @needs_pictures
    def test_a_picture_for_people_marks_the_action(self) -> None:
        env = PushTEnv()
        env.reset(seed=1)
        row, column = (int(number / 512 * 680) for number in (100, 256))
        self.assertNotEqual(list(env.render()[row, column]), [255, 0, 0])
        env.step([256.0, 100.0])
        self.assertEqual(list(env.render()[row, column]), [255, 0, 0])

    def test_bad_input_is_named(self) -> None:
        no_seed: Any = "a"
        env = PushTEnv()
        with self.assertRaisesRegex(sim2sim.InvalidInput, "no episode has begun"):
            env.step([1.0, 1.0])
        env.reset(seed=0)
        cases: Tuple[Tuple[Callable[[], Any], str], ...] = (
            (lambda: PushTEnv(obs_type="keypoints"), "obs_type 'keypoints': must be one of state,"),
            (lambda: PushTEnv(observation_width=0), "observation_width 0: must be from 1"),
            (lambda: PushTEnv(render_mode="ansi"), "render_mode 'ansi': must be one of human,"),
            (lambda: PushTEnv(damping=2.0), "damping 2.0: must be from 0 to 1"),
            (lambda: PushTEnv(engine="box2d", damping=0.5), "damping: must be left out with"),
            (lambda: PushTEnv(engine="two_mass"), "task gym_pusht: the kind two_mass holds only"),
            (lambda: env.step([np.nan, 1.0]), r"action \[nan, 1.0\]: must be finite"),
            (lambda: env.step([1.0]), r"action float64 of shape \(1,\): must be real numbers"),
            (lambda: env.reset(seed=2**32), "seed 4294967296: must be from 0 to 4294967295"),
            (
                lambda: env.reset(options={"reset_to_state": [1e300, 1, 1, 1, 0]}),
                r"reset_to_state: reset: pusher_x 1e\+297 m: must be within",
            ),
            (lambda: PushTEnv(block_cog=(0.0, 1e9)), "block_cog 0.0, 1000000000.0: must be within"),
            (
                lambda: sim2sim.make_vec("gym_pusht", 2, obs_type="state").reset(seed=no_seed),
                "seed 'a': must be an integer",
            ),
            (
                lambda: sim2sim.make("mujoco", obs_type="state", engine="box2d"),
                "engine box2d: must be left out with the kind mujoco",
            ),
            (
                lambda: sim2sim.make("mujoco", obs_type="state", max_episode_steps=5),
                "max_episode_steps: must be given as horizon",
            ),
            (lambda: env.reset(options={"state": 1}), "options .'state'.: unknown"),
            (
                lambda: env.reset(options={"reset_to_state": [1, 2]}),
                r"reset_to_state int64 of shape \(2,\)",
            ),
            (
                lambda: sim2sim.make("mujoco", obs_type="state", task="full_circle"),
                "task full_circle: must be gym_pusht",
            ),
        )
        for call, words in cases:
            with self.subTest(words), self.assertRaisesRegex(sim2sim.InvalidInput, words):
                call()
        env.step([1e6, 1e6])  # as far as it goes
        with self.assertRaises(sim2sim.SimulationFault):
            env.step([1e300, 0.0])

    def test_images_without_pygame_are_refused(self) -> None:
        program = (
            "import sys; sys.modules['pygame'] = None\n"
            "import sim2sim\n"
            "sim2sim.make('gym_pusht', obs_type='state').reset(seed=0)\n"
            "try:\n    sim2sim.make('gym_pusht', obs_type='pixels')\n"
            "except sim2sim.BadDependency as error:\n    print(error)\n"
        )
        said = subprocess.run(
            [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, check=True
        ).stdout
        self.assertIn("need pygame and OpenCV (Debian's python3-pygame and python3-opencv)", said)
        self.assertEqual(said.count("\n"), 1)


@needs_pictures
class ManyImages(unittest.TestCase):
    """Several processes draw them."""

    STATES = np.random.default_rng(1).uniform(50, 450, (67, 7))
    PROGRAM = (
        "import os, sys\n"
        "os.sched_getaffinity = lambda process: {0, 1}\n"
        "import numpy as np\n"
        "from sim2sim import renderers\n"
        "renderers.images(np.full((32, 18), 100.0), 96, 96)\n"
        "print(renderers._renderers_of(os.getpid()).others[0].process.pid, flush=True)\n"
        "sys.stdin.read()\n"
    )

    def alone(self) -> List[Any]:
        return [Sight("pixels", 80, 60).of(state[np.newaxis])[0] for state in self.STATES]

    def test_are_those_of_each(self) -> None:
        with two_renderers():
            with mock.patch.object(pictures, "images", wraps=pictures.images) as here:
                assert_array_equal(Sight("pixels", 80, 60).of(self.STATES), self.alone())
            self.assertEqual(len(here.call_args_list[0].args[0]), 23)

    def test_threads_do_not_disturb_each_other(self) -> None:
        alone = self.alone()
        with ThreadPoolExecutor(4) as pool:
            found = pool.map(lambda _: Sight("pixels", 80, 60).of(self.STATES), range(8))
        for images in found:
            assert_array_equal(images, alone)

    def test_a_renderer_that_ends_is_named(self) -> None:
        """Before it is asked, and before it answers; the next batch is drawn as usual."""
        with two_renderers() as drawing:
            dead = drawing.others[1].process
            dead.kill()
            dead.wait()
            with self.assertRaisesRegex(sim2sim.RuntimeFault, f"process {dead.pid} .* status -9"):
                Sight("pixels").of(self.STATES)
            assert_array_equal(Sight("pixels", 80, 60).of(self.STATES), self.alone())
        with two_renderers() as drawing:
            renderer = drawing.others[0]
            renderer.process.send_signal(signal.SIGSTOP)
            renderer.ask(NUMBERS, 96, 96)
            renderer.process.kill()
            with self.assertRaisesRegex(sim2sim.RuntimeFault, "renderer: process .* status -9"):
                renderer.answer(np.empty((len(NUMBERS), 96, 96, 3), np.uint8))

    def test_one_that_cannot_start_is_not_asked(self) -> None:
        with mock.patch.object(renderers, "PROGRAM", "raise SystemExit(3)"):
            renderer = renderers.Renderer()
        self.addCleanup(renderer.end)
        self.assertFalse(renderer.is_ready(patience=MOST))
        self.assertFalse(renderer.is_ready())

    def test_without_further_processes_this_one_draws(self) -> None:
        with mock.patch.object(os, "sched_getaffinity", return_value={0, 1, 2}):
            drawing = renderers.Renderers()
        with mock.patch.object(subprocess, "Popen", side_effect=BlockingIOError) as started:
            for _ in range(2):
                images = drawing.images(NUMBERS, 96, 96)
        self.assertEqual(started.call_count, 1)
        assert_array_equal(images, pictures.images(NUMBERS, 96, 96))

    def test_end_with_their_program(self) -> None:
        """In order, and killed."""
        for kills in (False, True):
            with self.subTest(kills=kills):
                program = subprocess.Popen(
                    [sys.executable, "-c", self.PROGRAM],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    text=True,
                )
                self.addCleanup(program.communicate)
                assert program.stdout is not None
                renderer = os.pidfd_open(int(program.stdout.readline()))
                self.addCleanup(os.close, renderer)
                if kills:
                    program.kill()
                program.communicate()
                self.assertEqual(select.select([renderer], [], [], MOST)[0], [renderer])


class Compared(unittest.TestCase):
    """compare() hands a callable what the environment shows."""

    OPTIONS: Dict[str, Any] = {
        "task": "gym_pusht",
        "reference": "gym_pusht",
        "engine": "none",
        "episodes": 1,
        "horizon": 12,
        "floor": False,
        "threads": 1,
    }

    PLACE = np.full(2, 230.0, np.float32)

    def seen(self, obs_type: str, history: Any = None, episode: int = 0) -> List[Any]:
        """What a callable that goes to one place is shown, after it has been tried out."""
        shown: List[Any] = []

        def to_a_place(observation: Any) -> Any:
            shown.append(observation)
            rows = observation if isinstance(observation, np.ndarray) else observation["agent_pos"]
            return np.tile(self.PLACE, (len(rows), 1))

        options: Dict[str, Any] = {**self.OPTIONS, "first_episode": episode}
        sim2sim.compare(to_a_place, obs_type=obs_type, history=history, **options)
        return shown[-self.OPTIONS["horizon"] :]

    def assert_same_as_the_environment(
        self, obs_type: str, episode: int = 0, engine: str = "gym_pusht"
    ) -> None:
        """To the last bit, while the tee is pushed."""
        env = PushTEnv(obs_type=obs_type, engine=engine)
        expected, first = env.reset(seed=100000 + episode)
        self.PLACE = first["block_pose"][:2].astype(np.float32)
        for found in self.seen(obs_type, episode=episode):
            for name, array in found.items() if isinstance(found, dict) else [("", found)]:
                there = expected[name] if name else expected
                self.assertEqual(array.dtype, there.dtype)
                assert_array_equal(array[0], there)
            expected, *_, last = env.step(self.PLACE)
        self.assertTrue((last["block_pose"] != first["block_pose"]).all(), "the tee has not moved")

    def test_the_same_as_the_environment(self) -> None:
        for obs_type in OBS_TYPES if DRAWS_AS_RECORDED else OBS_TYPES[:2]:
            with self.subTest(obs_type):
                self.assert_same_as_the_environment(obs_type)

    def test_pixels_that_the_table_has_not(self) -> None:
        """Near the window's corner, where pixels have bits that are lost in meters and back."""
        env = PushTEnv()
        expected, _ = env.reset(seed=100000)
        self.PLACE = np.array([40.0, 50.0], np.float32)
        lost = []
        for found in self.seen("state"):
            assert_array_equal(found[0], expected)
            pusher = found[0, :2]
            lost.append((pusher - 256.0) / 1000.0 * 1000.0 + 256.0 != pusher)
            expected, *_ = env.step(self.PLACE)
        self.assertTrue(np.any(lost), "the table has all of these")

    def test_the_same_from_other_seeds_and_in_other_engines(self) -> None:
        """The tee of seed 100039 lies under the pusher."""
        self.OPTIONS = {**self.OPTIONS, "horizon": 40}
        for episode in (1, 2, 39):
            with self.subTest(episode=episode):
                self.assert_same_as_the_environment("state", episode)
        for engine in ("mujoco", "box2d", "chipmunk"):
            self.OPTIONS = {**self.OPTIONS, "reference": engine}
            for episode in (1, 39):
                with self.subTest(engine, episode=episode):
                    self.assert_same_as_the_environment("state", episode, engine)

    def test_the_past_is_the_second_axis(self) -> None:
        plain = [both["agent_pos"][0] for both in self.seen("environment_state_agent_pos")]
        for step, both in enumerate(self.seen("environment_state_agent_pos", history=3)):
            self.assertEqual(both["environment_state"].shape, (1, 3, 16))
            past = [plain[max(step - 2 + i, 0)] for i in range(3)]
            assert_array_equal(both["agent_pos"][0], past)

    def test_a_loop_delays_what_is_seen(self) -> None:
        self.OPTIONS = {**self.OPTIONS, "loop": {"observation_delay": 2}}
        late = self.seen("environment_state_agent_pos")
        positions = [seen["agent_pos"][0] for seen in late]
        assert_array_equal(positions[1:3], positions[:1] * 2)
        self.assertEqual(len({tuple(position) for position in positions}), 10)
        self.OPTIONS = {**self.OPTIONS, "loop": "tracker"}
        errors = self.seen("environment_state_agent_pos")[0]["agent_pos"][0] - positions[0]
        self.assertTrue(0.1 < np.abs(errors).max() < 10.0, f"{errors} px of a tracker's 2 mm")

    def test_refused(self) -> None:
        cases: Tuple[Tuple[Dict[str, Any], str], ...] = (
            ({"policy": "expert"}, "obs_type state: must be left out unless the policy is a call"),
            (
                {"policy": len, "observation_width": 64, "obs_type": None},
                "observation_width: must be left out without an obs_type",
            ),
            (
                {"policy": len, "task": "full_circle"},
                "obs_type state: must be left out in the task",
            ),
        )
        for arguments, words in cases:
            options: Dict[str, Any] = {"obs_type": "state", **self.OPTIONS}
            options.update(arguments)
            with self.subTest(words), self.assertRaisesRegex(sim2sim.InvalidInput, words):
                sim2sim.compare(**options)


@needs_gymnasium
class WithGymnasium(unittest.TestCase):
    NAMES = ("sim2sim/GymPushT-v0", "gym_pusht/PushT-v0")

    def test_the_checker_passes(self) -> None:
        """After a seed, which decides the checker's own resets: in one start of 85 a corner of the
        tee lies beyond the window and so outside of gym-pusht's space."""
        from gymnasium.utils.env_checker import check_env  # type: ignore[import]

        for obs_type in OBS_TYPES if DRAWS_AS_RECORDED else OBS_TYPES[:2]:
            for name in self.NAMES:
                with self.subTest((name, obs_type)), warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    env = gymnasium.make(name, obs_type=obs_type, disable_env_checker=True)
                    env.reset(seed=0)
                    env.action_space.seed(0)
                    check_env(env.unwrapped)
                    said = {str(warning.message) for warning in caught}
                    self.assertTrue(all("symmetric and normalized" in w for w in said), said)

    def test_wrappers_and_the_end_of_an_episode(self) -> None:
        from gymnasium.wrappers import RecordEpisodeStatistics  # type: ignore[import]

        env = RecordEpisodeStatistics(gymnasium.make(self.NAMES[0]))
        env.reset(seed=1)
        ends = [env.step(np.array([10.0, 10.0]))[3:] for _ in range(300)]
        self.assertEqual([end[0] for end in ends], [False] * 299 + [True])
        self.assertEqual(ends[-1][1]["episode"]["l"], 300)

    def test_the_same_bits_one_by_one_in_vectors_and_in_a_batch(self) -> None:
        vectors: Tuple[Any, ...] = (
            gymnasium.make_vec(self.NAMES[0], 3, vectorization_mode="sync"),
            gymnasium.make_vec(self.NAMES[0], 3),
            sim2sim.make_vec("gym_pusht", 3, obs_type="state"),
        )
        singles = [PushTEnv() for _ in range(3)]
        starts = [vector.reset(seed=7)[0] for vector in vectors]
        starts.append(np.array([env.reset(seed=7 + i)[0] for i, env in enumerate(singles)]))
        random = np.random.default_rng(0)
        for start in starts[1:]:
            assert_same(start, starts[0])
        for step in range(320):  # beyond an end
            actions = random.uniform(0, 512, (3, 2)).astype(np.float32)
            results = [vector.step(actions) for vector in vectors]
            for other in results[1:]:
                for one, same in zip(results[0][:4], other[:4]):
                    assert_same(same, one)
            if step < 299:
                each = [env.step(action) for env, action in zip(singles, actions)]
                assert_same(np.array([row[0] for row in each]), results[0][0])
                for world, row in enumerate(each):
                    for result in results:
                        for name, value in row[4].items():
                            assert_array_equal(result[4][name][world], value, name)
        self.assertEqual(
            vectors[1].observation_space,
            gymnasium.vector.utils.batch_space(singles[0].observation_space, 3),
        )


if __name__ == "__main__":
    unittest.main()
