#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""One set of nodes, many goals: the evaluator's action, its ~control, its topics, the bytes."""

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any, Dict, List, Set, Tuple

import actionlib  # type: ignore[import]
import numpy as np
import rosbag  # type: ignore[import]
import rospy  # type: ignore[import]
import tf2_ros  # type: ignore[import]
from actionlib_msgs.msg import GoalStatus  # type: ignore[import]
from geometry_msgs.msg import TransformStamped  # type: ignore[import]
from pusht_msgs.msg import (  # type: ignore[import]
    CompareAction,
    CompareActionResult,
    CompareGoal,
    Divergence,
    EpisodeResult,
    Parameter,
    Progress,
    Summary,
    WorldStateStamped,
)
from pusht_msgs.srv import Configure, Episodes, Reset, Step  # type: ignore[import]
from pusht_task.task import wrap_angle
from pusht_testing.long_tests import LONG
from pusht_testing.nodes import Inbox, run, sends, until
from rosgraph_msgs.msg import Log  # type: ignore[import]
from tf2_msgs.msg import TFMessage  # type: ignore[import]
from visualization_msgs.msg import MarkerArray  # type: ignore[import]

from command_case import executable
from live_support import (
    DEADLINE,
    RECORDED_RESULTS,
    RESULTS,
    WORLDS,
    GoalCase,
    Process,
    Topic,
    connected,
    describe,
    files,
    metrics_of,
    pid_of,
    result_bytes,
    rows,
    status_of,
)

CONTROL_STEP = rospy.Duration(0, 100_000_000)
PACED = {"rate": 150.0}  # a run that can be followed
AT_ONCE = -1.0  # a rate: as fast as possible
EPISODES = 3  # with fewer steps than messages wait in a publisher
BATCH = ("--policy", "expert", "--episodes", str(EPISODES))


class LiveSession(GoalCase):
    divergence: Topic
    episode: Topic
    states: Dict[str, Topic]  # where a test listens to the worlds

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.divergence = Topic("/sim2sim/divergence", Divergence)
        cls.episode = Topic("/sim2sim/episode", EpisodeResult)

    def setUp(self) -> None:
        super().setUp()
        self.states = {}
        self.forget_runs()

    def inbox(self, topic: str, message_type: Any) -> Inbox:
        """Messages during this test."""
        inbox = Inbox(topic, message_type)
        self.addCleanup(inbox.close)
        return inbox

    def markers_to_come(self) -> Inbox:
        markers = self.inbox("/sim2sim/markers", MarkerArray)
        until(lambda: sends("/sim2sim", "/sim2sim/markers"), "markers")
        return markers

    def listen_to_worlds(self) -> None:
        """During this test: a message of each step takes its time."""
        for name in WORLDS:
            self.states[name] = Topic(f"/{name}/state", WorldStateStamped, f"/{name}")
            self.addCleanup(self.states[name].close)
        self.forget_runs()

    def listen_to_frames(self) -> tf2_ros.Buffer:
        """During this test."""
        frames = tf2_ros.Buffer(rospy.Duration(3600), debug=False)
        listener = tf2_ros.TransformListener(frames)
        self.addCleanup(listener.unregister)
        for name in WORLDS:
            until(lambda: sends(f"/{name}", "/tf"), f"TF of {name}")
        return frames

    def forget_runs(self) -> None:
        """What the topics have told of until now."""
        last = max(describe(world).stamp for world in WORLDS)
        for topic in (self.divergence, self.episode, *self.states.values()):
            topic.forget(last)

    def send(self, **fields: Any) -> None:
        super().send(**{"episodes": EPISODES, **fields})

    # The bytes.

    def test_bytes_are_those_of_the_command(self) -> None:
        expected = self.batch_bytes(*BATCH)
        cases: Dict[str, Dict[str, Any]] = {
            "recorded": {},
            "not recorded": {"record": False},
            "paced": {"rate": 400.0, "record": False},
        }
        for name, fields in cases.items():
            with self.subTest(name):
                self.out = self.folder / name
                result = self.compare(**fields)
                self.assertEqual((result.exit_code, result.folder), (0, str(self.out)))
                wanted = RESULTS if "record" in fields else RECORDED_RESULTS
                self.assertEqual(files(self.out), wanted)
                self.assertEqual(result_bytes(self.out), expected)
        self.assert_recomputed(self.folder / "recorded")

    def test_parameters_of_a_goal(self) -> None:
        before = describe("engine")
        for value in ("20", "6.0"):
            parameters = [Parameter("block_damp", value)]
            self.out = self.folder / value
            self.compare(engine_parameters=parameters, episodes=2, record=False)
            self.assertEqual(metrics_of(self.out)["knobs"]["block_damp"], float(value))
            nodes = json.loads((self.out / "provenance.json").read_text())["nodes"]
            modes = ("reference_closed", "engine_closed", "engine_replay")
            for name, mode in zip(WORLDS, modes, strict=True):
                node = describe(name)
                self.assertEqual(nodes[mode]["instance_id"], node.instance_id)
                self.assertEqual(nodes[mode]["parameters_hash"], node.parameters_hash)
            self.assertEqual(nodes["policy"]["instance_id"], describe("policy").instance_id)
        command = ("--policy", "expert", "--episodes", "2")
        expected = self.batch_bytes(*command, "--block_damp", "20")
        self.assertEqual(result_bytes(self.folder / "20"), expected)
        self.assertEqual(result_bytes(self.folder / "6.0"), self.batch_bytes(*command))
        self.assertEqual(describe("engine").parameters_hash, before.parameters_hash)

    def test_kind_of_a_goal(self) -> None:
        for kind in ("rigid_body", "two_mass"):
            with self.subTest(kind):
                self.out = self.folder / kind
                self.compare(engine=kind)
                self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH, "--engine", kind))

    def test_goal_inherits_nothing_from_the_one_before(self) -> None:
        expected = self.batch_bytes(*BATCH)
        simple = [Parameter("preset", "simple"), Parameter("drag", "true")]
        goals: Tuple[Dict[str, Any], ...] = (
            {"engine": "rigid_body", "engine_parameters": simple},
            {"engine_parameters": [Parameter("block_damp", "20")]},
            {"reference": "rigid_body"},
            {"reference": "two_mass", "reference_parameters": [Parameter("baumgarte", "20")]},
        )
        for number, fields in enumerate(goals):
            with self.subTest(fields):
                self.out = self.folder / f"{number} set"
                self.compare(episodes=1, record=False, **fields)
                self.assertNotEqual(result_bytes(self.out), expected)
                self.out = self.folder / f"{number} open"
                self.compare(record=False)
                self.assertEqual(result_bytes(self.out), expected)

    def test_parameter_that_a_goal_leaves_open_is_not_of_the_one_before(self) -> None:
        self.compare(episodes=1, record=False, engine_parameters=[Parameter("pusher_mass", "2")])
        self.out = self.folder / "damped"
        self.compare(record=False, engine_parameters=[Parameter("block_damp", "20")])
        expected = self.batch_bytes(*BATCH, "--block_damp", "20")
        self.assertEqual(result_bytes(self.out), expected)

    def test_world_that_is_configured_by_hand_stays_so(self) -> None:
        def set_by_hand(value: str) -> None:
            for world in ("engine", "engine_replay"):
                configure = connected(f"/{world}/configure", Configure)
                answer = configure(parameters=[Parameter("block_damp", value)], end_episode=True)
                self.assertTrue(answer.success, answer.message)

        self.compare(episodes=1, record=False)
        self.out = self.folder / "refused"  # which changes nothing that the evaluator remembers
        self.send(engine_parameters=[Parameter("pusher_mass", "-1")])
        self.result(GoalStatus.ABORTED)
        set_by_hand("20")
        self.addCleanup(set_by_hand, "6.0")
        for number in range(2):
            self.out = self.folder / str(number)
            self.compare(record=False)
            self.assertEqual(metrics_of(self.out)["knobs"]["block_damp"], 20.0)

    def test_parameter_on_the_server_that_has_no_effect_is_refused(self) -> None:
        self.addCleanup(rospy.set_param, "/engine/block_damp", 6.0)
        rospy.set_param("/engine/block_damp", 6)
        self.compare(episodes=1)
        rospy.set_param("/engine/block_damp", 1.0 / 3.0)
        self.out = self.folder / "refused"
        self.send()
        result = self.result(GoalStatus.ABORTED)
        self.assertEqual(result.exit_code, 2)
        self.assertRegex(
            result.reason, "parameter /engine/block_damp 0.33333.*: the node works with 6.0; set it"
        )

    def test_part_of_a_run(self) -> None:
        self.compare(seed=4, first_episode=2, episodes=1, horizon=25)
        metrics = metrics_of(self.out)
        wanted = {"seed": 4, "first_episode": 2, "episodes": 1, "horizon": 25}
        self.assertEqual({key: metrics[key] for key in wanted}, wanted)
        self.assertEqual({row["seed"] for row in rows(self.out)}, {"10006"})
        self.assertEqual({row["episode"] for row in rows(self.out)}, {"2"})
        self.assertEqual(rows(self.out)[2]["steps"], "25")

    def test_refused_goal_tells_why(self) -> None:
        cases: List[Tuple[Dict[str, Any], str]] = [
            (
                {"engine_parameters": [Parameter("block_dump", "6")]},
                "block_dump.*unknown; known: ",
            ),
            ({"engine_parameters": [Parameter("pusher_mass", "-1")]}, "pusher_mass -1.0: must be"),
            (
                {"engine_parameters": [Parameter("block_damp", "110")]},
                "block_damp 110.0: must be from 0.0 to",
            ),
            ({"seed": 2**64 - 1}, "seed"),
            ({"rate": math.nan}, "rate nan: must be finite"),
        ]
        for fields, reason in cases:
            with self.subTest(reason):
                self.out = self.folder / reason[:10]
                self.send(**fields)
                result = self.result(GoalStatus.ABORTED)
                self.assertEqual(result.exit_code, 2)
                self.assertRegex(result.reason, reason)
                self.assertEqual(files(self.out), {"status.json"})
                self.assertEqual(status_of(self.out)["reason"], result.reason)

    def test_goal_that_cannot_be_is_rejected(self) -> None:
        damp = [Parameter("block_damp", "6"), Parameter("block_damp", "20")]
        cases: List[Tuple[Dict[str, Any], str]] = [
            ({"policy_namespace": "a b"}, "policy_namespace 'a b': must be a ROS name"),
            ({"engine_parameters": damp}, "parameter block_damp 6, 20: must be set once"),
            ({"episodes": 1_000_000_000}, "episodes 1000000000: must be from 1 to"),
            ({"horizon": 2**32 - 1}, "horizon 4294967295: must be from 1 to 300"),
            ({"reanchor": [5, 2**32 - 1]}, "reanchor '5,4294967295': must be numbers of"),
            ({"policy_namespace": "x" * 10_000_000 + " "}, "policy_namespace 'x.*bytes left out"),
        ]
        for fields, reason in cases:
            with self.subTest(reason):
                results = self.results_to_come()
                self.send(**fields)
                self.assert_rejected(results, 2, reason)

    def results_to_come(self) -> Topic:
        results = Topic("/sim2sim/compare/result", CompareActionResult)
        self.addCleanup(results.close)
        return results

    def assert_rejected(self, results: Topic, exit_code: int, reason: str) -> None:
        """Not by the client: it loses an answer that comes before its goal is known to it."""

        def rejected(message: Any) -> bool:
            return bool(message.status.status == GoalStatus.REJECTED)

        answer = results.until(rejected)[-1]
        self.assertEqual(answer.result.exit_code, exit_code)
        self.assertRegex(answer.result.reason, reason)
        self.assertLess(len(answer.result.reason), 2100)
        self.assertEqual(answer.status.text, answer.result.reason)

    def test_policy_that_nobody_serves(self) -> None:
        self.send(policy_namespace="nobody")
        result = self.result(GoalStatus.ABORTED)
        self.assertEqual(result.exit_code, 4)
        self.assertRegex(result.reason, "/nobody/describe: no node answers within")
        self.assertRegex(result.reason, "roslaunch pusht_policy policy.launch name:=nobody$")

    def test_world_is_no_policy(self) -> None:
        self.send(policy_namespace="engine")
        result = self.result(GoalStatus.ABORTED)
        self.assertEqual(result.exit_code, 2)
        self.assertIn("/engine: is the simulator 'two_mass', must be a policy", result.reason)

    def test_node_that_is_waited_for_is_named(self) -> None:
        progress = self.inbox("/sim2sim/progress", Progress)
        until(lambda: sends("/sim2sim", "/sim2sim/progress"), "progress")
        self.send(replay_namespace="late")
        progress.until(lambda message: message.busy and message.waiting_for == "/late")
        self.result(GoalStatus.ABORTED)
        ended = progress.until(lambda message: not message.busy)[-1]
        self.assertEqual(ended.waiting_for, "")
        self.assertRegex(ended.failure, "simulator.launch name:=late kind:=two_mass$")
        self.send(reference_namespace="unheard_of")
        reason = self.result(GoalStatus.ABORTED).reason
        self.assertRegex(reason, "simulator.launch name:=unheard_of kind:=KIND$")

    # A run that does not begin leaves the last one as it was.

    def test_start_that_fails_leaves_the_last_run(self) -> None:
        self.compare()
        before = self.picture()
        cases: Dict[str, Dict[str, Any]] = {
            "refused": {"out": str(self.out)},
            "no node": {"replay_namespace": "late"},
            "wrong": {"engine_parameters": [Parameter("pusher_mass", "-1")]},
        }
        for name, fields in cases.items():
            with self.subTest(name):
                self.send(**{"out": str(self.folder / name), **fields})
                result = self.result(GoalStatus.ABORTED)
                self.assertEqual(result.summary.episodes, 0)
                self.assertEqual(self.picture(), before)

    def picture(self) -> Any:
        """What late subscribers learn of the run that is shown."""
        with_stamp = rospy.wait_for_message("/sim2sim/summary", Summary, DEADLINE)
        progress = self.progress()
        shown = {name: self.frames_now(name) for name in WORLDS}
        run = (progress.run, progress.episodes, progress.episodes_finished)
        answer = connected("/sim2sim/episodes", Episodes)()
        return str(with_stamp), run, str(answer.episodes), str(answer.curve), shown

    def frames_now(self, name: str) -> Tuple[float, float, float]:
        """Pose of the tee, from TF."""
        last = self.inbox("/tf", TFMessage)
        wanted = f"{name}/tee"

        def has(message: Any) -> bool:
            return any(frame.child_frame_id == wanted for frame in message.transforms)

        message = last.until(has)[-1]
        frame = next(f for f in message.transforms if f.child_frame_id == wanted)
        place = frame.transform
        return place.translation.x, place.translation.y, place.rotation.z

    def test_cancel_at_full_speed_leaves_one_moment(self) -> None:
        for number in range(8) if LONG else (0, 7):
            with self.subTest(number):
                self.out = self.folder / str(number)
                self.divergence.forget(max(describe(world).stamp for world in WORLDS))
                markers = self.markers_to_come()
                self.send(record=False, episodes=1000, rate=0.0)
                self.divergence.until(lambda message: message.step == 10 + 7 * number)
                self.cancel()
                self.result(GoalStatus.PREEMPTED)
                curve = connected("/sim2sim/episodes", Episodes)().curve
                last = max(describe(world).stamp for world in WORLDS)
                told = self.divergence.until(lambda message: message.header.stamp == last)[-1]
                self.assertEqual(point_of(curve[-1]), point_of(told))
                self.assertEqual([point.step for point in curve], list(range(told.step + 1)))
                wanted = f"episode {told.episode}, {told.step / 10:.1f} s"

                def drawn(message: Any, wanted: str = wanted) -> bool:
                    return any(wanted in text for text in texts(message))

                markers.until(drawn)

    # The action.

    def test_feedback_and_result(self) -> None:
        self.send(episodes=2, horizon=30, **PACED)
        result = self.result()
        expected = [(e, e, k) for e in range(2) for k in range(31)]
        steps = []
        for _ in expected:
            (message,) = self.feedback.until(lambda _: True)
            at = message.feedback.divergence
            steps.append((message.feedback.episodes_finished, at.episode, at.step))
        self.assertEqual(steps, expected)
        self.assertEqual(
            (result.exit_code, result.reason, result.faults_survived), (0, "finished", 0)
        )
        metrics = metrics_of(self.out)
        summary = result.summary
        self.assertEqual((summary.episodes, summary.episodes_finished), (2, 2))
        self.assertEqual(summary.reference.successes, metrics["mj_successes"])
        for mean in summary.means:
            wanted = metrics[f"{mean.name}_{mean.unit}"]
            if wanted is None:  # no episode is so long
                self.assertTrue(math.isnan(mean.value), mean.name)
            else:
                self.assertAlmostEqual(mean.value, wanted, delta=1e-6)
        self.assertIn("mean_ang_divergence", [mean.name for mean in summary.means])

    def test_given_starts_are_those_of_the_command(self) -> None:
        starts = str(self.folder / "starts.csv")
        self.batch_bytes(*BATCH, "--seed", "4", "--write-starts", starts)
        expected = self.batch_bytes(*BATCH, "--starts", starts)
        self.compare(starts=starts)
        self.assertEqual(result_bytes(self.out), expected)

    def test_probes_are_those_of_the_command_and_nobody_sees_them(self) -> None:
        self.listen_to_worlds()
        probes = ("--reanchor", "1,5", "--model-variants", "--closed-variants", "cone=elliptic")
        self.compare(
            reanchor=[1, 5],
            options=[
                Parameter("model_variants", "default"),
                Parameter("closed_variants", "cone=elliptic"),
            ],
        )
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH, *probes))
        taken = {(row["mode"], int(row["episode"])): int(row["steps"]) for row in rows(self.out)}
        for world, mode in (("reference", "reference_closed"), ("engine_replay",) * 2):
            last = EPISODES - 1
            end = taken[mode, last]

            def ended(state: Any, end: int = end) -> bool:
                return bool((state.episode, state.step) == (last, end))

            seen = self.states[world].until(ended)
            steps = sum(taken[mode, episode] + 1 for episode in range(EPISODES))
            times = Counter((state.episode, state.step) for state in seen)
            self.assertEqual(len(times), steps, "the modes alone")
            twice = {state for state, count in times.items() if count > 1}
            self.assertLessEqual(twice, {(0, 0)}, "the reset that takes the world over may be seen")

    def test_loop_and_repeats_are_those_of_the_command(self) -> None:
        reference = {"observation_delay": "1", "action_noise": "0.1"}
        engine = {"action_delay": "1", "observation_noise_position": "0.002"}
        sides = (("reference", reference), ("engine", engine))
        self.compare(
            options=[Parameter("repeats", str(EPISODES)), Parameter("independent_noise", "true")],
            **{
                f"{side}_parameters": [Parameter(f"loop.{k}", v) for k, v in loop.items()]
                for side, loop in sides
            },
        )
        loops = [
            word
            for side, loop in sides
            for name, value in loop.items()
            for word in (f"--loop-{side}", f"{name}={value}")
        ]
        command = (*BATCH, "--repeats", str(EPISODES), "--independent-noise", *loops)
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*command))

    def test_ends_when_it_is_decided(self) -> None:
        decided = ("--policy", "expert", "--episodes", "60", "--until-decided", "0.9")
        markers = self.markers_to_come()
        self.compare(episodes=60, until_decided=0.9)
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*decided))
        episodes = metrics_of(self.out)["episodes"]
        self.assertLess(episodes, 60)
        wanted = f"finished: policy expert, {episodes} episodes"
        markers.until(lambda message: wanted in texts(message))

    def test_second_goal_is_rejected(self) -> None:
        self.send_and_hold(0, 5)
        second = actionlib.SimpleActionClient("/sim2sim/compare", CompareAction)
        self.assertTrue(second.wait_for_server(rospy.Duration(DEADLINE)))
        results = self.results_to_come()
        second.send_goal(CompareGoal())
        self.assert_rejected(results, 4, "a comparison is under way")
        self.accepted("resume")
        self.result()
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH))

    def test_cancel_in_mid_episode_and_go_on(self) -> None:
        self.send_and_hold(1, 5)
        self.cancel()
        result = self.result(GoalStatus.PREEMPTED)
        self.assertEqual((result.exit_code, result.summary.episodes_finished), (4, 1))
        self.assert_not_whole(self.out, "interrupted in episode 1")
        with rosbag.Bag(str(self.out / "compare.bag")) as bag:
            self.assertEqual(bag.get_message_count("/sim2sim/episode"), 1)
        last = max(describe(world).stamp for world in WORLDS)
        self.divergence.until(lambda message: message.header.stamp == last)

        self.accepted("resume")
        self.out = self.folder / "again"
        self.compare()
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH))
        first = self.divergence.until(lambda message: message.step == 0)[0]
        self.assertGreater(first.header.stamp, last)

    def test_cancel_at_any_moment(self) -> None:
        states = set()
        for steps in range(1, 31) if LONG else (1, 2, 3, 15, 30):
            self.out = self.folder / str(steps)
            self.send(episodes=1, horizon=steps, record=False, **PACED)
            while self.next_feedback() < (0, steps // 2):
                pass
            self.cancel()
            self.assertTrue(self.client.wait_for_result(rospy.Duration(DEADLINE)))
            states.add(self.client.get_state())
            self.assertEqual(status_of(self.out)["exit_code"], self.client.get_result().exit_code)
        self.assertLessEqual(states, {GoalStatus.PREEMPTED, GoalStatus.SUCCEEDED})

    # ~control.

    def test_paused_run_goes_step_by_step(self) -> None:
        self.accepted("pause")
        self.send()
        for step in range(6):
            (message,) = self.divergence.until(lambda message: True)
            self.assertEqual((message.episode, message.step), (0, step))
            self.assertEqual(describe("engine_replay").stamp, message.header.stamp)
            self.accepted("step")
        self.accepted("resume")
        self.result()
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH))

    def test_pause_in_mid_episode_changes_no_byte(self) -> None:
        self.send(rate=10.0)  # slow enough for any machine
        while self.next_feedback() < (0, 3):
            pass
        self.accepted("pause")
        self.accepted("rate", AT_ONCE)  # all would be over at once
        self.accepted("step")
        self.assertFalse(self.client.wait_for_result(rospy.Duration(0.5)))
        self.accepted("resume")
        self.result()
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH))

    def test_refused_control(self) -> None:
        self.send(rate=10.0)
        self.next_feedback()
        for command, rate, reason in (
            ("step", 0.0, "step: only while paused"),
            ("faster", 0.0, "command 'faster': must be pause, resume, step, rate, cancel or seek"),
            ("rate", 0.0, r"rate 0: must be above 0 .*, or below 0 \(as fast as possible\)"),
            ("rate", math.inf, "rate inf: must be finite"),
        ):
            response = self.control(command=command, rate=rate)
            self.assertFalse(response.success)
            self.assertRegex(response.message, reason)
        self.accepted("rate", AT_ONCE)
        self.result()
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH))

    def test_control_between_runs(self) -> None:
        for command in ("step", "cancel"):
            response = self.control(command=command)
            self.assertFalse(response.success)
            self.assertEqual(response.message, f"{command}: no comparison is under way")
        response = self.control(command="pause")
        self.assertTrue(response.success)
        self.assertIn("the next one begins paused", response.message)
        self.accepted("resume")

    def test_late_subscriber_gets_the_curve(self) -> None:
        self.send_and_hold(0, 5, **PACED)
        curve = connected("/sim2sim/episodes", Episodes)().curve
        last = rospy.wait_for_message("/sim2sim/divergence", Divergence, DEADLINE)
        self.assertEqual(point_of(curve[-1]), point_of(last))
        self.assertEqual([point.step for point in curve], list(range(6)))
        self.accepted("rate", AT_ONCE)
        self.accepted("resume")
        self.result()

    def test_anybody_can_learn_of_pause_and_rate(self) -> None:
        self.send_and_hold(0, 5, rate=120.0, record=False)
        held = self.progress()
        self.assertEqual((held.busy, held.paused, held.rate), (True, True, 120.0))
        self.assertEqual((held.episodes, held.episodes_finished), (EPISODES, 0))
        self.accepted("rate", AT_ONCE)
        self.assertEqual(self.progress().rate, 0.0)
        self.accepted("resume")
        self.result()
        ended = self.progress()
        self.assertEqual((ended.busy, ended.paused), (False, False))
        self.assertEqual(ended.episodes_finished, EPISODES)

    def progress(self) -> Any:
        return rospy.wait_for_message("/sim2sim/progress", Progress, DEADLINE)

    def test_pause_that_holds_a_goal_is_told(self) -> None:
        log = self.inbox("/rosout", Log)
        until(lambda: sends("/sim2sim", "/rosout"), "the log")
        self.send_and_hold(0, 0, **PACED)
        log.until(lambda line: "paused; to go on: rosservice call" in line.msg)
        self.accepted("rate", AT_ONCE)
        self.accepted("resume")
        self.result()

    def test_parameters_follow_a_configuration(self) -> None:
        for value in ("20", "6.0"):
            self.out = self.folder / value
            self.compare(
                engine_parameters=[Parameter("block_damp", value)], episodes=1, record=False
            )
            self.assertEqual(rospy.get_param("/engine/block_damp"), float(value))

    # The topics.

    def test_topics_tell_the_run(self) -> None:
        self.listen_to_worlds()
        self.compare()
        results = self.episode.until(lambda message: message.episode == EPISODES - 1)
        found = [
            (str(result.episode), str(result.seed), rollout)
            for result in results
            for rollout in result.rollouts
        ]
        for row, (episode, seed, rollout) in zip(rows(self.out), found, strict=True):
            self.assertEqual((row["episode"], row["seed"]), (episode, seed))
            self.assertEqual((row["mode"], row["steps"]), (rollout.mode, str(rollout.steps)))
            self.assertEqual(row["success"] == "true", rollout.success)
            columns = [f"{quantity.name}_{quantity.unit}" for quantity in rollout.quantities]
            parting = ["parting_step", "parting_cause", "parting_first"]
            ends = ["ending", "still_step", "pusher_ending"]
            named = [*columns, *parting, *ends]
            self.assertEqual(named, list(row)[-len(named) :])
            self.assertEqual(row["ending"], rollout.ending)
            self.assertEqual(row["still_step"], str(rollout.still_step) if rollout.ending else "")
            self.assertEqual(row["pusher_ending"], rollout.pusher_ending)
            self.assertEqual(row["parting_step"], str(rollout.parting_step or ""))
            self.assertEqual(row["parting_cause"], rollout.parting_cause)
            self.assertEqual(row["parting_first"], rollout.parting_first)
            for column, quantity in zip(columns, rollout.quantities):
                cell = "" if math.isnan(quantity.value) else quantity.value
                self.assertEqual(row[column] and float(row[column]), cell)

        last = results[-1].header.stamp
        states = {
            name: {s.header.stamp: s for s in inbox.until(lambda s: s.episode == 2 and s.step == 1)}
            for name, inbox in self.states.items()
        }
        messages = self.divergence.until(lambda message: message.header.stamp == last)
        compared = 0
        for message in messages:
            stamp = message.header.stamp
            tees = [states[name][stamp].state for name in WORLDS if stamp in states[name]]
            if len(tees) == len(WORLDS):
                compared += 1
                self.assertEqual(states["reference"][stamp].step, message.step)
                self.assert_apart(tees[0], tees[1], message.closed_position, message.closed_angle)
                self.assert_apart(tees[0], tees[2], message.replay_position, message.replay_angle)
        self.assertGreater(compared, 50)
        stamps = [message.header.stamp for message in messages]
        growth = {b - a for a, b in zip(stamps, stamps[1:])}
        self.assertEqual(growth, {CONTROL_STEP})

    def assert_apart(self, a: Any, b: Any, position: float, angle: float) -> None:
        self.assertAlmostEqual(
            math.hypot(a.tee_x - b.tee_x, a.tee_y - b.tee_y), position, delta=1e-12
        )
        self.assertAlmostEqual(abs(wrap_angle(a.tee_yaw - b.tee_yaw)), angle, delta=1e-12)

    def test_summary_is_latched(self) -> None:
        self.compare(record=False)
        summary = rospy.wait_for_message("/sim2sim/summary", Summary, DEADLINE)
        metrics = metrics_of(self.out)
        self.assertEqual((summary.episodes_finished, summary.policy), (EPISODES, "expert"))
        self.assertEqual(summary.reference.rate, metrics["mj_success_rate"])
        self.assertEqual(summary.engine.rate, metrics["engine_success_rate"])

    def test_tables_stand_side_by_side(self) -> None:
        self.listen_to_worlds()
        frames = self.listen_to_frames()
        self.send(horizon=20, episodes=1)
        self.result()
        for place, name in zip((-0.96, 0.0, 0.96), WORLDS):
            stamp = describe(name).stamp
            state = self.state_at(name, stamp)
            tee = frames.lookup_transform(
                "world", f"{name}/tee", stamp, rospy.Duration(DEADLINE)
            ).transform.translation
            np.testing.assert_allclose([tee.x, tee.y], [place + state.tee_x, state.tee_y])

    def state_at(self, name: str, stamp: rospy.Time) -> Any:
        return self.states[name].until(lambda s: s.header.stamp == stamp)[-1].state

    def test_whoever_comes_late_sees_everything(self) -> None:
        self.listen_to_worlds()
        self.send_and_hold(0, 20, **PACED)
        markers = self.inbox("/sim2sim/markers", MarkerArray)
        scene = markers.until(lambda message: "reference/captions" in namespaces(message))[-1]
        self.assertIn("engine_replay/captions", namespaces(scene))
        shown = markers.until(lambda message: "reference/episode" in namespaces(message))[-1]
        markers.until(lambda message: message == scene)  # again: rviz's Reset forgets
        markers.until(lambda message: message == shown)

        frames = tf2_ros.Buffer(debug=False)
        listener = tf2_ros.TransformListener(frames)
        self.addCleanup(listener.unregister)
        for name in WORLDS:
            stamp = describe(name).stamp
            state = self.state_at(name, stamp)
            tee = frames.lookup_transform(
                f"{name}/table", f"{name}/tee", rospy.Time(), rospy.Duration(DEADLINE)
            ).transform.translation
            self.assertEqual((tee.x, tee.y), (state.tee_x, state.tee_y))
            frames.lookup_transform(
                "world", f"{name}/target", rospy.Time(), rospy.Duration(DEADLINE)
            )
        self.accepted("rate", AT_ONCE)
        self.accepted("resume")
        self.result()

    def test_last_picture_is_that_of_the_result(self) -> None:
        markers = self.markers_to_come()
        self.compare()
        markers.until(
            lambda message: f"finished: policy expert, {EPISODES} episodes" in texts(message)
        )
        metrics = metrics_of(self.out)
        counts = [
            f"success {metrics[key]}/{EPISODES}" for key in ("mj_successes", "engine_successes")
        ]

        def counted(message: Any) -> bool:
            return all(any(t.startswith(count) for t in texts(message)) for count in counts)

        last = markers.until(counted)[-1]
        with rosbag.Bag(str(self.out / "compare.bag")) as bag:
            recorded = [m for _, m, _ in bag.read_messages(topics=["/sim2sim/markers"])]
            self.assertEqual(texts(recorded[-1]), texts(last, overlay=False))
            self.assertNotEqual(texts(last), texts(last, overlay=False))

    # Bags.

    def test_bag_holds_the_frames_that_never_move(self) -> None:
        self.compare(episodes=1)
        with rosbag.Bag(str(self.out / "compare.bag")) as bag:
            ((_, message, _),) = bag.read_messages(topics=["/tf_static"])
        found = {(f.header.frame_id, f.child_frame_id) for f in message.transforms}
        wanted = {("world", f"{name}/{frame}") for name in WORLDS for frame in ("table", "window")}
        wanted |= {(f"{name}/table", f"{name}/target") for name in WORLDS}
        self.assertEqual(found, wanted | {("world", "overlay/window")})

    def test_bag_of_a_plain_recorder(self) -> None:
        self.compare(episodes=1, seed=9)  # the recorder hears of this run, too
        names = [f"/{world}/state" for world in WORLDS]
        names += [f"/sim2sim/{n}" for n in ("divergence", "episode", "summary", "trace")]
        command = ("rosbag", "record", "-a", "--output-name", "plain.bag", "__name:=recorder")
        recorder = Process(self, *command)
        for name in [*names, "/sim2sim/configuration"]:
            publisher = "/" + name.split("/")[1]
            until(lambda: sends(publisher, name, "/recorder"), f"a record of {name}")
        self.forget_runs()
        self.out = self.folder / "recorded"
        self.send(**PACED)
        self.result()
        # What has arrived here has been sent to the recorder, which ends when it has written it.
        self.episode.until(lambda message: message.episode == EPISODES - 1)
        recorder.interrupt()
        recorder.ended()
        plain_bag = self.folder / "plain.bag"
        with rosbag.Bag(str(plain_bag)) as plain, rosbag.Bag(str(self.out / "compare.bag")) as ours:
            for name in names:
                if name != "/sim2sim/summary":  # some say that nothing is known yet
                    with self.subTest(name):
                        wanted = stamps_in(ours, name)
                        # Before: what was latched.
                        found = [stamp for stamp in stamps_in(plain, name) if stamp >= wanted[0]]
                        self.assertEqual(found, wanted)
            self.assertGreaterEqual(plain.get_message_count("/sim2sim/summary"), EPISODES)
        again = self.folder / "again"
        recompute = executable("sim2sim_eval", "recompute")
        self.succeed(recompute, str(plain_bag), "--out", str(again))
        self.assertEqual(result_bytes(again), result_bytes(self.out))

    # F18.

    def test_f18_a_thousand_resets(self) -> None:
        listener = Process(self, "rosrun", "tf2_ros", "buffer_server", "__name:=f18_listener")
        until(lambda: sends("/engine", "/tf", "/f18_listener"), "a listener")
        pid = pid_of("/engine")
        services = {
            name: connected(f"/engine/{name}", service)
            for name, service in {"reset": Reset, "step": Step}.items()
        }
        services["reset"](seed=0, horizon=1)
        stamps = []
        memory = []  # [kB]
        for index in range(1000):
            stamps.append(services["reset"](seed=index, horizon=5).stamp)
            stamps.append(services["step"](step=-1, action=(0.5, 0.5)).stamp)
            if index in (200, 999):
                memory.append(resident_memory(pid))
        growth = {b - a for a, b in zip(stamps, stamps[1:])}
        self.assertEqual(growth, {CONTROL_STEP})
        self.assertLess(memory[1] - memory[0], 300)
        self.assertEqual(self.complaints_of(listener), [])

    def complaints_of(self, listener: Process) -> List[str]:
        """Transforms of a tf2 listener. It is given a reason for one, to know when it has all."""
        publisher = rospy.Publisher("/tf", TFMessage, queue_size=10)
        until(lambda: sends(rospy.get_name(), "/tf", "/f18_listener"), "the listener")
        repeated = TransformStamped(child_frame_id="f18")
        repeated.header.frame_id = "world"
        repeated.transform.rotation.w = 1.0
        for _ in range(2):
            publisher.publish([repeated])
        listener.line("TF_REPEATED_DATA.*f18")
        return [
            line for line in listener.output.splitlines() if "TF_" in line and "f18" not in line
        ]


def resident_memory(pid: int) -> int:
    """[kB]"""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def stamps_in(bag: Any, topic: str) -> List[Any]:
    return [message.header.stamp for _, message, _ in bag.read_messages(topics=[topic])]


def point_of(divergence: Any) -> Tuple[Any, ...]:
    """All but the number that a topic gives to its messages."""
    at = (divergence.header.stamp, divergence.episode, divergence.step)
    # Texts are compared: what is not a number equals nothing.
    return (*at, str(divergence.replay_position), str(divergence.replay_angle))


def namespaces(markers: Any) -> Set[str]:
    return {marker.ns for marker in markers.markers}


def texts(markers: Any, overlay: bool = True) -> List[str]:
    """Topics of the overlay are not recorded."""
    shown = [m for m in markers.markers if overlay or not m.ns.startswith("overlay/")]
    return [marker.text for marker in shown if marker.text]


run(LiveSession)
