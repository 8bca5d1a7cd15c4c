#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The workbench in rviz: the panel drives runs, and a bag is shown as if it were live."""

import re
from typing import Any, Dict, List, Tuple

import rosbag  # type: ignore[import]

from live_support import (
    RECORDED_RESULTS,
    Launch,
    LiveCase,
    Process,
    files,
    free_port,
    result_bytes,
    until,
)


class Panel(LiveCase):
    def launch(self, **arguments: Any) -> Launch:
        """An evaluator that waits for what the panel asks for."""
        launch = Launch(self, start=False, rviz=False, **arguments)
        launch.line(r"process\[sim2sim-\d+\]: started")
        return launch

    def drive(self, launch: Launch, test: str, **environment: str) -> None:
        """Runs one test of panel_test, in a real rviz."""
        everything = {**launch.environment, "DISPLAY": self.open_display(), **environment}
        command = ("rosrun", "pusht_rviz", "panel_test", f"--gtest_filter=*.{test}")
        panel = Process(self, *command, environment=everything)
        self.assertEqual(panel.ended(5 * self.deadline), 0, panel.output)
        self.assertIn("[  PASSED  ] 1 test", panel.output)

    def test_panel_drives_runs(self) -> None:
        launch = self.launch(expert_node=True, overwrite=True)
        self.drive(launch, "DrivesARunThroughEveryButton")
        self.assertEqual(files(launch.out), RECORDED_RESULTS)
        wanted = "--policy expert --first-episode 1 --episodes 2".split()
        self.assertEqual(result_bytes(launch.out), self.batch_bytes(*wanted))

    def test_f37_run_that_the_evaluator_refuses(self) -> None:
        launch = self.launch(smoke=True)
        self.drive(launch, "ShowsWhyTheEvaluatorRefusesARun", PANEL_TEST_SMOKE="")
        self.assertEqual(result_bytes(launch.out), self.batch_bytes("--smoke"))

    def test_node_that_dies_shows_as_lost(self) -> None:
        launch = self.launch(policy="expert")
        launch.tool("rosservice", "call", "--wait", "/engine/describe", "{}")
        victim = str(launch.node("/engine"))
        self.drive(launch, "ShowsANodeThatDiesAndGoesOn", PANEL_TEST_VICTIM=victim)


class Replay(LiveCase):
    """replay.launch, without rviz."""

    def replay(self, display: str = "", **arguments: Any) -> Process:
        self.uri = f"http://127.0.0.1:{free_port()}"
        self.environment = {
            "ROS_MASTER_URI": self.uri,
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(self.folder / "ros"),
            "DISPLAY": display,
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "PWD": str(self.folder),
        }
        given = [f"{name}:={value}" for name, value in {"rviz": "false", **arguments}.items()]
        command = ("roslaunch", "-p", self.uri.split(":")[-1], "sim2sim_eval", "replay.launch")
        launch = Process(self, *command, *given, environment=self.environment)
        launch.line(r"process\[sim2sim-\d+\]: started")
        return launch

    def control(self, command: str) -> str:
        call = ("rosservice", "call", "--wait", "/sim2sim/control", command)
        return self.succeed(*call, environment=self.environment)

    def record(self) -> str:
        """The bag of two episodes."""
        command = ("rosrun", "sim2sim_eval", "compare", "--policy", "expert", "--record")
        self.succeed(*command, "--seed", "3", "--episodes", "2", "--out", str(self.folder / "out"))
        return "out/compare.bag"

    def test_replay_of_what_cannot_be_shown_says_why(self) -> None:
        (self.folder / "no.bag").write_text("no bag")
        bag = self.record()
        cases: List[Tuple[Any, str]] = [
            ({}, "no bag: say which, as bag:=PATH of a compare.bag"),
            ({"bag": "missing.bag"}, "bag missing.bag: must be a readable file"),
            ({"bag": "no.bag"}, "bag no.bag: must be a whole bag: .*"),
            ({"bag": bag, "episode": 2}, "episode 2: must be one that the bag holds: 0 to 1"),
            ({"bag": bag, "start": 31}, "start 31.0: must be within an episode .s."),
            ({"bag": bag, "speed": -1}, "speed -1.0: must be finite and >= 0 .*"),
        ]
        for arguments, reason in cases:
            with self.subTest(arguments):
                launch = self.replay(**arguments)
                launch.ended()
                self.assertRegex(launch.output, f"(?m)^sim2sim: {reason}$")
                self.assertIn("exit code 2", launch.output)

    def test_replay_without_a_display_ends(self) -> None:
        launch = self.replay(bag=self.record(), rviz="true")
        launch.ended()
        self.assertRegex(launch.output, "(?m)^no display .*: nothing can be shown")
        self.assertNotIn("Traceback", launch.output)

    def test_replay_without_its_bag_ends_though_rviz_is_there(self) -> None:
        launch = self.replay(display=self.open_display(), bag="missing.bag", rviz="true")
        launch.ended()
        self.assertIn("sim2sim: bag missing.bag: must be a readable file", launch.output)

    def steps_of(self, bag: str) -> Dict[Tuple[int, int], str]:
        """How each step looks that the bag tells of, by episode and step."""
        with rosbag.Bag(str(self.folder / bag)) as recorded:
            messages = [str(m) for _, m, _ in recorded.read_messages(["/sim2sim/divergence"])]
        steps = {}
        for message in messages:
            look = message[message.index("episode:") :]
            episode, step = re.findall(r"(?m)^(?:episode|step): (\d+)$", look)
            steps[int(episode), int(step)] = look
        return steps

    def watch(self) -> Process:
        """A subscriber; without one, nothing is shown."""
        topic = ("rostopic", "echo", "/sim2sim/divergence")
        return Process(self, *topic, environment=self.environment)

    def test_replay_begins_where_it_is_told(self) -> None:
        path = self.record()
        steps = self.steps_of(path)
        self.replay(bag=path, episode=1, start=0.5, speed=0.001)  # 100 s after the first step
        shown = self.watch()
        until(lambda: steps[1, 5] in shown.output, "the control step at 0.5 s")
        self.assertNotIn("episode: 0", shown.output)

    def test_replay_goes_where_it_is_told(self) -> None:
        path = self.record()
        recorded = self.steps_of(path)
        self.replay(bag=path, speed=0)
        self.control("{command: pause}")
        shown = self.watch()

        def expect(place: Tuple[int, int]) -> None:
            until(lambda: recorded[place] in shown.output, f"episode and step {place}")

        for place in recorded:  # the curve of the episode that is shown is whole
            if place[0] == 0:
                expect(place)
        self.control("{command: seek, episode: 1, step: 5}")
        for step in range(6):  # a curve is whole
            expect((1, step))
        self.control("{command: step}")
        expect((1, 6))
        self.control("{command: seek, episode: 1, step: 9}")
        until(lambda: shown.output.count(recorded[1, 9]) == 2, "the step, which was foretold, too")
        self.assertEqual(shown.output.count(recorded[1, 2]), 1, "the others are not told again")
        self.control("{command: seek, episode: 0, step: 3}")
        expect((0, 3))
        frames = ("rostopic", "echo", "-n1", "/tf")  # again, for late subscribers
        self.assertIn("child_frame_id", self.succeed(*frames, environment=self.environment))
        answer = self.control("{command: seek, episode: 2}")
        self.assertIn("episode 2: must be one that the bag holds: 0 to 1", answer)
        answer = self.control("{command: seek, episode: 1, step: 9999}")
        self.assertIn("step 9999: must be from 0 to ", answer)
        self.assertIn("cancel: only in a live run", self.control("{command: cancel}"))
        self.control("{command: resume}")
        expect(max(recorded))
        until(lambda: self.latched("progress", "paused: True"), "a pause at the end")
        episodes = self.succeed(
            "rosservice", "call", "/sim2sim/episodes", environment=self.environment
        )
        self.assertEqual(episodes.count("seed: "), 2)
        self.assertTrue(self.latched("summary", "episodes_finished: 2"))

    def latched(self, topic: str, text: str) -> bool:
        echo = ("rostopic", "echo", "-n", "1", f"/sim2sim/{topic}")
        return text in self.succeed(*echo, environment=self.environment)


if __name__ == "__main__":
    import unittest

    unittest.main()
