#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The workbench in rviz: the panel drives runs, and a bag is shown as if it were live."""

from collections import Counter
from typing import Any, Dict, List, Tuple

import rosbag  # type: ignore[import]
import rospy  # type: ignore[import]
from pusht_msgs.msg import Divergence, Progress, Summary  # type: ignore[import]
from pusht_msgs.srv import Control, Episodes  # type: ignore[import]
from pusht_testing.nodes import Inbox
from tf2_msgs.msg import TFMessage  # type: ignore[import]

from command_case import executable
from launch_support import Start, environment_of, node_file, shared_master
from live_support import (
    DEADLINE,
    RECORDED_RESULTS,
    LiveCase,
    Process,
    connected,
    describe,
    files,
    free_port,
    result_bytes,
)


class Panel(LiveCase):
    def launch(self, **arguments: Any) -> Start:
        """An evaluator that waits for what the panel asks for."""
        return Start(self, keep=False, start=False, **arguments)

    def drive(self, launch: Start, test: str, **environment: str) -> None:
        """Runs one test of panel_test, in a real rviz."""
        everything = {**launch.environment, "DISPLAY": self.open_display(), **environment}
        command = (node_file("pusht_rviz", "panel_test"), f"--gtest_filter=*.{test}")
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
        describe("engine")
        victim = str(launch.node("/engine"))
        self.drive(launch, "ShowsANodeThatDiesAndGoesOn", PANEL_TEST_VICTIM=victim)

    def test_evaluator_that_hangs_and_dies_shows(self) -> None:
        launch = self.launch(policy="expert")
        connected("/sim2sim/control", Control).close()  # it is there
        victim = str(launch.node("/sim2sim"))
        self.drive(launch, "ShowsAnEvaluatorThatHangsAndDies", PANEL_TEST_EVALUATOR=victim)


class Replay(LiveCase):
    """replay.launch, without rviz."""

    def setUp(self) -> None:
        super().setUp()
        shared_master()  # before anything is subscribed to

    def replay(self, **arguments: Any) -> Start:
        return Start(self, file="replay", **arguments)

    def launch(self, display: str = "", **arguments: str) -> Process:
        """The user's own, with rviz."""
        uri = f"http://127.0.0.1:{free_port()}"
        given = [f"{name}:={value}" for name, value in arguments.items()]
        command = ("roslaunch", "-p", uri.split(":")[-1], "sim2sim_eval", "replay.launch")
        return Process(self, *command, *given, environment=environment_of(self, uri, display))

    def record(self) -> str:
        """The bag of two episodes."""
        command = (executable("sim2sim_eval", "compare"), "--policy", "expert", "--record")
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
                node = self.replay(**arguments)
                self.assertEqual(node.ended(), 2, node.output)
                self.assertRegex(node.output, f"(?m)^sim2sim: {reason}$")

    def test_replay_without_a_display_ends(self) -> None:
        launch = self.launch(bag=self.record())
        launch.ended()
        self.assertRegex(launch.output, "(?m)^no display .*: nothing can be shown")
        self.assertNotIn("Traceback", launch.output)

    def test_replay_without_its_bag_ends_though_rviz_is_there(self) -> None:
        launch = self.launch(self.open_display("320x240x24"), bag="missing.bag")
        launch.ended()
        self.assertIn("sim2sim: bag missing.bag: must be a readable file", launch.output)
        self.assertIn("exit code 2", launch.output)

    def steps_of(self, bag: str) -> Dict[Tuple[int, int], str]:
        """How each step looks that the bag tells of, by episode and step."""
        with rosbag.Bag(str(self.folder / bag)) as recorded:
            messages = [m for _, m, _ in recorded.read_messages(["/sim2sim/divergence"])]
        return {(message.episode, message.step): look(message) for message in messages}

    def test_replay_begins_where_it_is_told(self) -> None:
        path = self.record()
        steps = self.steps_of(path)
        shown = self.inbox("/sim2sim/divergence", Divergence)  # without one, nothing is shown
        self.replay(bag=path, episode=1, start=0.5, speed=0.001)  # 100 s after the first step
        seen = shown.until(lambda message: look(message) == steps[1, 5])
        self.assertEqual({message.episode for message in seen}, {1})

    def test_replay_goes_where_it_is_told(self) -> None:
        path = self.record()
        recorded = self.steps_of(path)
        node = self.replay(bag=path, speed=0)
        node.control("pause")
        shown = self.inbox("/sim2sim/divergence", Divergence)  # which is told the whole curve
        seen: "Counter[str]" = Counter()

        def expect(*places: Tuple[int, int], times: int = 1) -> None:
            """Waits until each of these has been told so often."""
            while any(seen[recorded[place]] < times for place in places):
                seen.update(look(message) for message in shown.until(lambda _: True))

        expect(*(place for place in recorded if place[0] == 0))  # the curve is whole
        node.control("seek", episode=1, step=5)
        expect(*((1, step) for step in range(6)))  # a curve is whole
        node.control("step")
        expect((1, 6))
        node.control("seek", episode=1, step=9)
        expect((1, 9), times=2)  # it was foretold, too
        self.assertEqual(seen[recorded[1, 2]], 1, "the others are not told again")
        last = max(recorded)[1]
        node.control("seek", episode=1, step=last)
        expect((1, last), times=2)
        node.control("seek", episode=0, step=3)
        expect((0, 3))
        rospy.wait_for_message("/tf", TFMessage, DEADLINE)  # again, for late subscribers
        self.assertIn("episode 2: must be one that the bag holds: 0 to 1", self.refusal(2))
        reason = f"step {last + 1}: must be from 0 to {last}, the end of episode 1"
        self.assertEqual(self.refusal(1, last + 1), reason)
        answer = connected("/sim2sim/control", Control)(command="cancel")
        self.assertEqual((answer.success, "only in a live run" in answer.message), (False, True))
        node.control("resume")
        expect(max(recorded))
        progress = self.inbox("/sim2sim/progress", Progress)
        progress.until(lambda message: bool(message.paused))  # at the end
        episodes = connected("/sim2sim/episodes", Episodes)().episodes
        self.assertEqual(len(episodes), 2)
        summary = rospy.wait_for_message("/sim2sim/summary", Summary, DEADLINE)
        self.assertEqual(summary.episodes_finished, 2)

    def inbox(self, topic: str, message_type: Any) -> Inbox:
        """Messages during this test. A replay begins as soon as there is a subscriber."""
        inbox = Inbox(topic, message_type)
        self.addCleanup(inbox.close)
        return inbox

    def refusal(self, episode: int, step: int = 0) -> str:
        """Why the replay cannot go there."""
        control = connected("/sim2sim/control", Control)
        answer = control(command="seek", episode=episode, step=step)
        self.assertFalse(answer.success)
        return str(answer.message)


def look(message: Any) -> str:
    """What a step shows, without its header."""
    text = str(message)
    return text[text.index("episode:") :]


if __name__ == "__main__":
    import unittest

    unittest.main()
