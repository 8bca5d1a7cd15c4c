#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""compare.launch when it loses something: nodes, its own process, its files, its master.

The numbers of the faults are those of the project's list.
"""

import math
import os
import resource
import signal
import time
from pathlib import Path
from typing import Any, Dict, Tuple

import rosbag  # type: ignore[import]
import rosgraph  # type: ignore[import]
import rospy  # type: ignore[import]
import torch
from pusht_msgs.msg import Divergence  # type: ignore[import]
from pusht_testing.nodes import Inbox

from command_case import catches, executable, signals
from launch_support import Launch, Run, SharedLaunch, Start, node_file
from live_support import (
    DEADLINE,
    ROLLOUTS,
    UNFINISHED,
    LiveCase,
    Process,
    answers,
    children_of,
    describe,
    files,
    free_port,
    kill,
    result_bytes,
    rows,
    status_of,
    status_of_file,
    until,
)
from torch_policies import Endless

CONTRACT = "simulator_contract"
ESCALATION = 15.0  # [s] after which roslaunch sends SIGTERM
# A run that a fault can find under way, however busy the machine is.
LONG: Dict[str, Any] = {"policy": "expert", "episodes": 1000, "horizon": 60, "rate": 300}


class LostNodes(LiveCase):
    """F13 and F14 without respawn; F16."""

    def under_way(self, **more: Any) -> Run:
        """A run that has finished an episode and is in another one."""
        run = Start(self, keep=False, **{**LONG, **more})
        run.first("/sim2sim/episode")
        return run

    def assert_ended_by(self, launch: Run, reason: str, since: float, patience: float) -> None:
        """The fault of the time `since` ended the run; it was noticed within `patience` seconds."""
        noticed, _ = launch.line(rf"lost in episode \d+: .*{reason}")
        launch.line(f"sim2sim: .*{reason}")
        self.assertLess(noticed - since, patience)
        launch.ended()
        status = self.assert_not_whole(launch.out, reason)
        self.assertGreaterEqual(status["episodes_finished"], 1)

    def test_f13_killed_node(self) -> None:
        for node in ("engine", "reference", "policy"):
            with self.subTest(node):
                run = self.under_way(out=node)
                self.assert_ended_by_a_kill(run, f"/{node}")

    def test_f13_killed_node_of_a_launch(self) -> None:
        launch = SharedLaunch(self, **LONG)
        launch.first("/sim2sim/episode")
        self.assert_ended_by_a_kill(launch, "/engine_replay")

    def assert_ended_by_a_kill(self, run: Run, node: str) -> None:
        pid = run.node(node)  # which takes its time
        since = time.monotonic()
        os.kill(pid, signal.SIGKILL)
        self.assert_ended_by(run, f"{node}/.*: the node has died", since, 1.0)

    def test_f13_killed_node_whose_rollout_has_ended(self) -> None:
        """In episode 1 MuJoCo succeeds after 73 of 300 control steps."""
        run = Start(self, keep=False, policy="expert", first_episode=1, episodes=1, rate=50)
        step = Inbox("/sim2sim/divergence", Divergence)
        self.addCleanup(step.close)
        step.until(lambda message: math.isnan(message.closed_position))
        run.control("pause")
        os.kill(run.node("/reference"), signal.SIGKILL)
        run.control("resume")
        run.line("sim2sim: /reference/describe: the node has died")  # not: end of episode 1: ...
        run.ended()

    def test_f13_node_that_is_dead_before_the_run_begins(self) -> None:
        run = Start(self, keep=False, policy="expert", start=False, status_file="copy.json")
        describe("engine")
        run.control("resume")
        os.kill(run.node("/engine"), signal.SIGKILL)
        client = run.send_goal(episodes=1)
        waits, _ = run.line("waiting for the node of /engine/describe, for 30 s at most")
        noticed, _ = run.line("sim2sim: /engine/describe: the master knows a node at .* died")
        self.assertLess(noticed - waits, 15.0)
        self.assertTrue(client.wait_for_result(rospy.Duration(DEADLINE)))
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual(status["exit_code"], 4)
        self.assertIn("has died", status["reason"])

    def test_f14_stopped_node(self) -> None:
        run = self.under_way(deadline=0.5)
        pid = run.node("/engine_replay")
        self.addCleanup(kill, pid, signal.SIGCONT)
        since = time.monotonic()
        os.kill(pid, signal.SIGSTOP)
        self.assert_ended_by(run, "/engine_replay/[a-z]+: no answer within 500 ms", since, DEADLINE)

    def test_f16_services_that_another_node_takes_over(self) -> None:
        run = self.under_way()
        services = ("reset", "step", "configure", "describe")
        remappings = [f"/impostor/{service}:=/engine/{service}" for service in services]
        command = (node_file("pusht_engine", "engine_node"), "__name:=impostor", *remappings)
        since = time.monotonic()
        Process(self, *command, environment=run.environment)
        reason = "/engine: its services belong to another node .* second node of that name"
        self.assert_ended_by(run, reason, since, DEADLINE)

    def test_f16_second_node_of_a_name(self) -> None:
        run = self.under_way()
        since = time.monotonic()
        command = (node_file("sim2sim_eval", "quasi_static_simulator"), "__name:=engine")
        Process(self, *command, environment=run.environment)
        reason = "/engine.*: (the node has (died|gone)|its services belong to|another instance)"
        self.assert_ended_by(run, reason, since, DEADLINE)


class LostRuns(LiveCase):
    """F22 and F23."""

    def test_f22_folder_that_cannot_be_made(self) -> None:
        run = Start(self, policy="expert", out="/proc/none/out", status_file="copy.json")
        run.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual(status["exit_code"], 4)
        self.assertIn("/proc/none/out", status["reason"])

    def test_f22_bag_that_cannot_be_written(self) -> None:
        run = Start(self, policy="expert", episodes=50, file_limit=1_000_000)
        run.ended()
        self.assert_not_whole(run.out, "cannot write .*compare.bag", bag=False)

    def test_f22_metrics_that_cannot_be_written(self) -> None:
        """Files that cannot grow beyond 1 kB stand for a full disk."""
        run = Start(self, policy="expert", episodes=2, rate=1, record=False)
        run.first("/sim2sim/divergence")
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (1000, 1000))
        run.control("rate", rate=100000)
        run.ended()
        status = run.status()
        self.assertEqual((status["exit_code"], status["episodes_finished"]), (4, 2))
        self.assertIn("episodes.csv: File too large", status["reason"])
        self.assertEqual(files(run.out), {"provenance.json", "status.json"})

    def test_f22_interrupted(self) -> None:
        """rviz would be one of the nodes."""
        launch = SharedLaunch(self, rviz=True, **LONG)
        launch.first("/sim2sim/episode")
        launch.interrupt()
        launch.ended()
        self.assertNotIn("escalating", launch.output)
        status = self.assert_not_whole(launch.out, "interrupted in episode")
        with rosbag.Bag(str(launch.out / "compare.bag")) as bag:
            recorded = bag.get_message_count("/sim2sim/episode")
        self.assertEqual(recorded, status["episodes_finished"])

    def test_f22_node_that_hears_of_the_end_before_the_evaluator(self) -> None:
        """roslaunch signals one node after the other."""
        run = Start(self, keep=False, grace=60, **LONG)
        run.first("/sim2sim/episode")
        os.kill(run.node("/engine"), signal.SIGINT)
        run.line("lost in episode")
        run.interrupt()
        run.ended()
        self.assert_not_whole(run.out, "^interrupted in episode")

    def test_f22_interrupted_while_it_waits_for_a_node(self) -> None:
        run = Start(self, policy_node=False)
        run.line("waiting for the node of /policy/describe, for 30 s at most")
        run.interrupt()
        self.assertEqual(run.ended(ESCALATION), 4)
        self.assertEqual(run.status()["exit_code"], 4)
        self.assertEqual(run.status()["reason"], "interrupted before the first episode")

    def test_f22_signal_as_soon_as_the_evaluator_runs(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number.name):
                run = Start(self, out=number.name, status_file="copy.json", **LONG)
                until(lambda: catches(run.pid, number), "a handler")
                os.kill(run.pid, number)
                run.ended()
                self.assertEqual(run.status()["exit_code"], 4)
                self.assertEqual(run.status()["episodes_finished"], 0)
                self.assertEqual(status_of_file(self.folder / "copy.json"), run.status())

    def test_f22_killed_roslaunch(self) -> None:
        python = '<node name="python" pkg="sim2sim_eval" type="quasi_static_simulator"/>'
        launch = Launch(self, beside=python, rviz=False, **LONG)
        first_episode(launch)
        names = ("sim2sim", "engine", "reference", "policy", "python")
        launch.tool("rosservice", "call", "--wait", "/python/describe", "{}")
        nodes = [launch.node(f"/{name}") for name in names]
        children = children_of(launch.pid)  # the master is one
        for pid in children:
            self.addCleanup(kill, pid, signal.SIGKILL)
        os.kill(launch.pid, signal.SIGKILL)
        until(lambda: not any(runs(pid) for pid in nodes), "the end of all nodes")
        for pid in children:
            kill(pid, signal.SIGKILL)
        launch.ended()
        self.assert_not_whole(launch.out, "interrupted in episode|the node has (died|gone)")

    def test_f7_failed_start_claims_no_success(self) -> None:
        Start(self, smoke=True, status_file="copy.json").ended()
        before = result_bytes(self.folder / "out")
        (self.folder / "none.xml").write_text("<mujoco/>")
        run = Start(self, smoke=True, overwrite=True, scene="none.xml", status_file="copy.json")
        run.ended()
        status = run.status()
        self.assertEqual((status["exit_code"], status["beside_earlier_results"]), (2, True))
        self.assertIn("none.xml", status["reason"])
        self.assertEqual(status_of_file(self.folder / "copy.json")["exit_code"], 2)
        self.assertEqual(result_bytes(run.out), before, "nothing is lost")

    def test_f7_killed_before_the_run_begins(self) -> None:
        (self.folder / "copy.json").write_text('{"exit_code": 0, "reason": "finished"}')
        run = Start(self, policy_node=False, status_file="copy.json")
        run.control("pause")
        os.kill(run.pid, signal.SIGKILL)
        run.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual((status["exit_code"], status["reason"]), (4, "under way, or killed"))

    def test_f23_killed_evaluator(self) -> None:
        launch = Start(self, keep=False, policy="expert", episodes=1000)
        part = launch.out / "compare.bag.part"
        launch.first("/sim2sim/episode")
        until(
            lambda: part.stat().st_size > 2**20, "an episode on the disk"
        )  # written when there is time
        os.kill(launch.pid, signal.SIGKILL)
        launch.ended()
        self.assertEqual(files(launch.out), {"provenance.json", "status.json", part.name})
        status = launch.status()
        self.assertEqual((status["exit_code"], status["reason"]), (4, "under way, or killed"))
        recovered = self.folder / "recovered.bag"
        part.rename(recovered)
        self.succeed("rosbag", "reindex", str(recovered))
        command = (executable("sim2sim_eval", "recompute"), str(recovered), "--out", "again")
        process = self.run_command(*command)
        self.assertEqual(process.returncode, 4, process.stderr)
        self.assertRegex(process.stderr, r"episodes \d+ to 999 are missing")
        again = self.folder / "again"
        self.assertEqual(files(again), UNFINISHED)
        finished = status_of(again)["episodes_finished"]
        self.assertGreaterEqual(finished, 1)
        self.assertEqual(len(rows(again)), ROLLOUTS * finished)


class LostMaster(LiveCase):
    """F15 and F17."""

    NODES = (
        ("pusht_engine", "engine_node"),
        ("pusht_mujoco", "mujoco_node"),
        ("pusht_policy", "policy_node"),
        ("sim2sim_eval", "evaluator_node"),
        ("sim2sim_eval", "quasi_static_simulator"),
        ("sim2sim_eval", "python_policy"),
    )

    def assert_every_node_ends(self, uri: str, reason: str) -> None:
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        nodes = [Process(self, node_file(*node), environment=environment) for node in self.NODES]
        for name, node in zip(self.NODES, nodes):
            with self.subTest(name):
                self.assertEqual(node.ended(10.0), 4, node.output)
                self.assertRegex(node.output, reason)

    def start_master(self, uri: str = "") -> Tuple[Process, str]:
        uri = uri or f"http://127.0.0.1:{free_port()}"
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        port = uri.split(":")[-1]
        master = Process(self, "rosmaster", "--core", "-p", port, environment=environment)
        until(lambda: answers(uri), "a master")
        return master, uri

    def test_f15_no_master(self) -> None:
        uri = f"http://127.0.0.1:{free_port()}"
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        for package, name in (("sim2sim_eval", "evaluator_node"), ("pusht_testing", CONTRACT)):
            node = Process(self, node_file(package, name), environment=environment)
            self.assertEqual(node.ended(10.0), 4, node.output)
            self.assertIn(f"no ROS master at {uri}: start roscore", node.output)

    def test_nodes_wait_for_the_master(self) -> None:
        uri = f"http://127.0.0.1:{free_port()}"
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        waiting = [node for node in self.NODES if node[1] != "evaluator_node"]
        nodes = [
            Process(self, node_file(*node), f"__name:={node[1]}", environment=environment)
            for node in waiting
        ]
        for node in nodes:
            node.line("waiting for the ROS master|Failed to contact master.*Retrying")
        nodes[-1].interrupt()
        self.assertNotEqual(nodes[-1].ended(), 0)
        self.start_master(uri)
        for _, name in waiting[:-1]:
            self.succeed(
                *("rosservice", "call", "--wait", f"/{name}/describe", "{}"),
                environment=environment,
            )

    def test_a_node_that_failed_at_start_ends_with_the_code_of_it(self) -> None:
        _, uri = self.start_master()
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        command = (node_file("pusht_engine", "engine_node"), "__name:=refused", "_block_damp:=-1")
        node = Process(self, *command, environment=environment)
        describe = ("rosservice", "call", "--wait", "/refused/describe", "{}")
        self.assertIn("success: False", self.succeed(*describe, environment=environment))
        node.interrupt()
        self.assertEqual(node.ended(), 2, node.output)

    def test_parameters_of_a_command_line_end_with_their_node(self) -> None:
        """The next node of that name would get them. What is left all the same is named."""
        _, uri = self.start_master()
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        master = rosgraph.Master("/live_test", master_uri=uri)
        for package, name, parameter in (
            ("pusht_engine", "engine_node", "block_damp"),
            ("sim2sim_eval", "quasi_static_simulator", "characteristic_length"),
        ):
            command = (node_file(package, name), "__name:=kept")
            first = Process(self, *command, f"_{parameter}:=0.05", environment=environment)
            describe = ("rosservice", "call", "--wait", "/kept/describe", "{}")
            self.assertIn(parameter, self.succeed(*describe, environment=environment))
            self.assertEqual(master.getParam(f"/kept/{parameter}"), 0.05)
            wanted = f"{{parameters: [{{name: {parameter}, value: '0.06'}}], end_episode: true}}"
            configure = ("rosservice", "call", "/kept/configure", wanted)
            self.assertIn("success: True", self.succeed(*configure, environment=environment))
            self.assertEqual(master.getParam(f"/kept/{parameter}"), 0.06)
            first.interrupt()
            first.ended()
            self.assertEqual(master.getParam("/kept"), {}, name)
            master.setParam("/kept/nonsense", 7)
            second = Process(self, *command, environment=environment)
            second.line(
                "/kept/nonsense.*unknown; known: .*`rosparam delete /kept/nonsense` removes it"
            )
            self.assertIn("success: False", self.succeed(*describe, environment=environment))
            second.interrupt()
            second.ended()
            master.deleteParam("/kept")
        audit = Process(
            self,
            *(node_file("sim2sim_eval", "audit_node"), "_out:=left.json", "_patience:=0.1"),
            environment=environment,
        )
        self.assertNotEqual(audit.ended(), 0)
        self.assertEqual(master.getParam("/audit"), {}, audit.output)

    def test_contracts_say_how_they_are_used(self) -> None:
        uri = f"http://127.0.0.1:{free_port()}"
        for name, subject in (
            (CONTRACT, "simulator"),
            ("own_simulator_contract", "simulator"),
            ("policy_contract", "policy"),
            ("own_policy_contract", "policy"),
            ("failed_start_contract", "node"),
        ):
            usage = f"usage: rosrun pusht_testing {name} --text _{subject}:=/NAME"
            command = (node_file("pusht_testing", name),)
            shown = self.succeed(*command, "--help", environment={"ROS_MASTER_URI": uri})
            self.assertIn(usage, shown)
        _, uri = self.start_master()
        contract = Process(
            self, node_file("pusht_testing", CONTRACT), environment={"ROS_MASTER_URI": uri}
        )
        self.assertEqual(contract.ended(), 2, contract.output)
        self.assertRegex(contract.output, "parameter ~simulator is not set; usage: rosrun")

    def test_f15_master_that_dies(self) -> None:
        master, uri = self.start_master()
        launch = Launch(self, master_uri=uri, rviz=False, **LONG)
        first_episode(launch)
        since = time.monotonic()
        os.kill(master.pid, signal.SIGKILL)
        noticed, _ = launch.line("sim2sim: .*master")
        self.assertLess(noticed - since, 10.0)
        launch.ended()
        self.assert_not_whole(launch.out, "the ROS master at .* has died|interrupted in episode")

    def test_f22_signal_while_the_master_is_asked(self) -> None:
        master, uri = self.start_master()
        self.addCleanup(kill, master.pid, signal.SIGCONT)
        parameters = {"out": str(self.folder / "out"), "start": True, "exit": True}
        rosgraph.Master("/live_test", master_uri=uri).setParam("/sim2sim", parameters)
        os.kill(master.pid, signal.SIGSTOP)
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        node = Process(self, node_file("sim2sim_eval", "evaluator_node"), environment=environment)
        until(lambda: catches(node.pid, signal.SIGTERM) and in_poll(node.pid), "a call")
        os.kill(node.pid, signal.SIGTERM)
        until(lambda: signals(node.pid, "ShdPnd") == 0, "the signal")
        os.kill(master.pid, signal.SIGCONT)
        self.assertEqual(node.ended(), 4, node.output)
        self.assertEqual(status_of(self.folder / "out")["exit_code"], 4)

    def test_f29_policy_node_ends_while_it_tries_a_policy_out(self) -> None:
        _, uri = self.start_master()
        torch.jit.script(Endless(-10.0, 10.0)).save(str(self.folder / "endless.pt"))
        command = (node_file("pusht_policy", "policy_node"), "_policy:=endless.pt")
        node = Process(self, *command, environment={"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"})
        until(lambda: bool(children_of(node.pid)), "a copy that tries it out")
        node.interrupt()
        self.assertEqual(node.ended(10.0), 4, node.output)
        self.assertIn("endless.pt: interrupted while it was tried out", node.output)

    def test_f17_no_clock(self) -> None:
        _, uri = self.start_master()
        environment = {"ROS_MASTER_URI": uri}
        self.succeed("rosparam", "set", "/use_sim_time", "true", environment=environment)
        self.assert_every_node_ends(uri, "/use_sim_time is set, but nothing publishes /clock")

    def test_f17_launch_without_a_clock(self) -> None:
        """The outcome of an earlier run does not stand for this one."""
        copy = self.folder / "copy.json"
        copy.write_text('{"exit_code": 0, "reason": "finished"}')
        parameters = {"/use_sim_time": True}
        launch = Launch(self, parameters, smoke=True, rviz=False, status_file=copy)
        launch.ended()
        self.assertIn("sim2sim: /use_sim_time is set, but nothing publishes /clock", launch.output)
        self.assertEqual(files(launch.out), {"status.json"})
        self.assertEqual(launch.status()["exit_code"], 4)
        self.assertEqual(status_of_file(copy), launch.status())


def first_episode(launch: Launch) -> None:
    """Waits for the end of one, in a launch with a master of its own."""
    launch.line(r"process\[sim2sim-\d+\]: started")
    launch.tool("rostopic", "echo", "-n1", "/sim2sim/episode")


def in_poll(pid: int) -> bool:
    """Whether the main thread of a process waits for an answer."""
    return "poll" in Path(f"/proc/{pid}/wchan").read_text()


def runs(pid: int) -> bool:
    """A process that has ended may wait for its parent to ask for its exit code."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False
