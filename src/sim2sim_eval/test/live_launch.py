#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""compare.launch as its user meets it: results, notices, and the outcome of every fault.

The numbers of the faults are those of the project's list.
"""

import json
import os
import re
import resource
import signal
import time
from pathlib import Path
from typing import Any, Dict, List, Tuple

import rosbag  # type: ignore[import]
import rosgraph  # type: ignore[import]
import roslaunch  # type: ignore[import]
import rospkg  # type: ignore[import]
import torch

from command_case import Endless, catches, executable, signals
from live_support import (
    DEADLINE,
    RECORDED_RESULTS,
    RESULTS,
    ROLLOUTS,
    UNFINISHED,
    Launch,
    LiveCase,
    Process,
    answers,
    children_of,
    files,
    free_port,
    kill,
    result_bytes,
    rows,
    status_of,
    text_of,
    until,
)

CONTRACT = "simulator_contract"
LONG: Dict[str, Any] = {
    "policy": "expert",
    "episodes": 100,
    "rate": 300,
}  # a run that a fault can find under way


class Runs(LiveCase):
    def test_smoke_run_without_a_display(self) -> None:
        launch = Launch(self, smoke=True)
        self.assertEqual(launch.ended(), 0)
        self.assertIn("running headless: no display (DISPLAY is not set)", launch.output)
        self.assertEqual(launch.status()["exit_code"], 0, launch.output)
        self.assertEqual(files(launch.out), RECORDED_RESULTS)
        self.assertEqual(result_bytes(launch.out), self.batch_bytes("--smoke"))
        self.assert_recomputed(launch.out)

    def test_report(self) -> None:
        launch = Launch(self, smoke=True, report=True)
        self.assertEqual(launch.ended(), 0)
        self.assertEqual(files(launch.out), RECORDED_RESULTS | {"report.html"})
        self.assertEqual(launch.status()["exit_code"], 0)
        page = (launch.out / "report.html").read_text(encoding="utf-8")
        self.assertIn("roslaunch sim2sim_eval compare.launch", page)

    def test_report_that_cannot_be_written(self) -> None:
        (self.folder / "rosrun").write_text("#!/bin/sh\nexit 3\n")
        (self.folder / "rosrun").chmod(0o755)
        self.addCleanup(os.environ.update, {"PATH": os.environ["PATH"]})
        os.environ["PATH"] = f"{self.folder}:{os.environ['PATH']}"
        launch = Launch(self, smoke=True, report=True, status_file="copy.json")
        launch.ended()
        self.assertIn("its report was not written: report ended with exit code 3", launch.output)
        self.assertEqual(status_of_file(self.folder / "copy.json")["exit_code"], 4)
        self.assertEqual(launch.status()["exit_code"], 0, "of the run, whose results stand")
        self.assertEqual(files(launch.out), RECORDED_RESULTS)

    def test_arguments_mean_what_they_mean_to_the_command(self) -> None:
        launch = Launch(
            self, policy="expert", episodes=2, seed=4, block_damp=20, record=False, rviz=False
        )
        launch.ended()
        self.assertNotIn("no display", launch.output)
        self.assertEqual(files(launch.out), RESULTS)
        wanted = "--policy expert --episodes 2 --seed 4 --block_damp 20".split()
        self.assertEqual(result_bytes(launch.out), self.batch_bytes(*wanted))

    def test_any_kind_stands_in_either_role(self) -> None:
        cases: Dict[str, Dict[str, Any]] = {
            "--reference chipmunk --set-reference iterations=10 --engine mujoco": {
                "reference": "chipmunk",
                "reference_parameters": "iterations=10",
                "engine": "mujoco",
            },
            "--reference two_mass --set-reference block_damp=20": {
                "reference": "two_mass",
                "reference_parameters": "block_damp=20",
            },
            "--engine chipmunk": {"engine": "chipmunk"},
            "--engine rigid_body --set preset=simple --set drag=true": {
                "engine": "rigid_body",
                "engine_parameters": "preset=simple drag=true",
            },
        }
        for number, (options, arguments) in enumerate(cases.items()):
            with self.subTest(options):
                launch = Launch(self, policy="expert", episodes=1, out=number, **arguments)
                launch.ended()
                wanted = self.batch_bytes(*"--policy expert --episodes 1".split(), *options.split())
                self.assertEqual(result_bytes(launch.out), wanted)
                self.assert_recomputed(launch.out)

    def test_status_is_copied(self) -> None:
        launch = Launch(self, smoke=True, status_file="copy.json", out="auto")
        launch.ended()
        out = self.folder / "results" / "compare-1"
        self.assertEqual(
            (self.folder / "copy.json").read_bytes(), (out / "status.json").read_bytes()
        )
        self.assertEqual(files(out), RECORDED_RESULTS)

    def test_status_of_a_goal_is_copied(self) -> None:
        launch = Launch(self, policy="expert", start=False, status_file="copy.json")
        launch.line(r"process\[sim2sim-\d+\]: started")
        launch.tool("rosservice", "call", "--wait", "/sim2sim/control", "{command: resume}")
        copy = self.folder / "copy.json"
        self.assertFalse(copy.exists(), "there has been no run")
        goal = f"{{goal: {{episodes: [1], out: ['{launch.out}']}}}}"
        command = ("rostopic", "pub", "/sim2sim/compare/goal", "pusht_msgs/CompareActionGoal", goal)
        Process(self, *command, environment=launch.environment)
        until(lambda: copy.exists() and status_of_file(copy)["exit_code"] == 0, "a finished run")
        self.assertEqual(copy.read_bytes(), (launch.out / "status.json").read_bytes())

    def test_lost_node_is_brought_back_as_documented(self) -> None:
        """Whatever kind a run has made of it."""
        launch = Launch(self, policy="expert", start=False)
        launch.line(r"process\[sim2sim-\d+\]: started")
        launch.tool("rosservice", "call", "--wait", "/sim2sim/control", "{command: resume}")
        self.run_goal(launch, "first", "engine: [rigid_body]")
        lost = launch.node("/engine")
        os.kill(lost, signal.SIGKILL)
        command = ("roslaunch", "sim2sim_eval", "simulator.launch", "name:=engine")
        Process(self, *command, "kind:=two_mass", environment=launch.environment)
        until(lambda: self.answers_anew(launch, lost), "the node")
        self.run_goal(launch, "second")
        wanted = self.batch_bytes("--policy", "expert", "--episodes", "1")
        self.assertEqual(result_bytes(self.folder / "second"), wanted)

    def answers_anew(self, launch: Launch, lost: int) -> bool:
        """Whether another process than the lost one serves the engine."""
        try:
            return launch.node("/engine") != lost
        except (OSError, rosgraph.MasterError):
            return False

    def run_goal(self, launch: Launch, out: str, *fields: str) -> None:
        """Waits for a run that must finish."""
        folder = self.folder / out
        goal = ", ".join(("episodes: [1]", "record: [false]", f"out: ['{folder}']", *fields))
        command = ("rostopic", "pub", "-1", "/sim2sim/compare/goal")
        topic = "pusht_msgs/CompareActionGoal"
        launch.tool(*command, topic, f"{{goal: {{{goal}}}}}")
        status = folder / "status.json"
        until(lambda: status.exists() and status_of_file(status)["exit_code"] != 4, "a status")
        self.assertEqual(status_of_file(status)["reason"], "finished")

    def test_policies_with_memory_chunks_and_noise_survive_a_killed_node(self) -> None:
        """Their episode begins again, with the same noise."""
        run: Dict[str, Any] = {"episodes": 2, "horizon": 60}
        options = " ".join(f"--{name} {value}" for name, value in run.items())
        for name, execute in (("gru", 0), ("chunk", 4), ("flow", 8)):
            with self.subTest(name):
                policy = str(rospkg.RosPack().get_path("pusht_policy")) + f"/policies/{name}.ts.pt"
                given: Dict[str, Any] = {
                    **run,
                    "policy": policy,
                    "execute": execute,
                    "respawn": True,
                    "rate": 5,
                }
                launch = Launch(self, out=name, **given)
                launch.first("/sim2sim/divergence")
                control = ("rosservice", "call", "/sim2sim/control")
                launch.tool(*control, "{command: pause}")
                os.kill(launch.node("/policy"), signal.SIGKILL)
                launch.tool(*control, "{command: rate, rate: -1.0}")
                launch.tool(*control, "{command: resume}")
                self.assertEqual(launch.ended(), 0, launch.output)
                self.assertEqual(launch.status()["faults_survived"], 1)
                batch = ("--policy", policy, *options.split(), "--execute", str(execute))
                self.assertEqual(result_bytes(launch.out), self.batch_bytes(*batch))
                self.assert_recomputed(launch.out)

    def with_engine_from_elsewhere(self, *node: str, **arguments: Any) -> Launch:
        launch = Launch(
            self, policy="expert", episodes=1, engine_nodes=False, record=False, **arguments
        )
        launch.line(r"process\[sim2sim-\d+\]: started")
        for name in ("engine", "engine_replay"):
            Process(self, "rosrun", *node, f"__name:={name}", environment=launch.environment)
        launch.ended()
        return launch

    def test_parameters_reach_an_engine_that_is_started_elsewhere(self) -> None:
        launch = self.with_engine_from_elsewhere("pusht_engine", "engine_node", block_damp=20)
        wanted = "--policy expert --episodes 1 --block_damp 20".split()
        self.assertEqual(result_bytes(launch.out), self.batch_bytes(*wanted))

    def test_engine_that_is_started_elsewhere_becomes_the_kind_that_is_named(self) -> None:
        node = ("sim2sim_eval", "simulator_node", "_kind:=two_mass")
        launch = self.with_engine_from_elsewhere(*node, engine="chipmunk")
        wanted = "--policy expert --episodes 1 --engine chipmunk".split()
        self.assertEqual(result_bytes(launch.out), self.batch_bytes(*wanted))

    def test_engine_that_is_started_elsewhere_and_cannot_be_what_is_named_refuses(self) -> None:
        node = ("pusht_engine", "engine_node")
        launch = self.with_engine_from_elsewhere(*node, engine="chipmunk")
        status = launch.status()
        self.assertEqual(status["exit_code"], 2, launch.output)
        self.assertIn("simulator 'chipmunk': must be two_mass, the only kind", status["reason"])

    def test_run_says_how_far_it_is_and_that_all_is_well(self) -> None:
        launch = Launch(self, policy="expert", episodes=2, horizon=60, rate=10)
        launch.first("/sim2sim/episode")
        launch.tool("rosservice", "call", "/sim2sim/control", "{command: rate, rate: 100000}")
        launch.ended()
        launch.line(r"0 of 2 episodes finished, the next one is at control step \d+")
        launch.line(f"finished, all is well: results in {launch.out}")

    def test_policy_that_is_started_elsewhere_must_be_the_one_that_is_named(self) -> None:
        launch = Launch(self, policy="bc", policy_node=False)
        launch.line(r"process\[sim2sim-\d+\]: started")
        command = ("rosrun", "pusht_policy", "policy_node", "__name:=policy", "_policy:=expert")
        Process(self, *command, environment=launch.environment)
        launch.ended()
        status = launch.status()
        self.assertEqual(status["exit_code"], 2, launch.output)
        self.assertIn("policy bc: /policy serves expert", status["reason"])


class Displays(LiveCase):
    """A display is there, cannot be opened, or goes."""

    def test_display_that_cannot_be_opened(self) -> None:
        launch = Launch(self, smoke=True, display=":77")
        launch.ended()
        self.assertIn("running headless: no display (DISPLAY is :77, which cannot", launch.output)
        self.assertEqual(result_bytes(launch.out), self.batch_bytes("--smoke"))

    def test_rviz_that_dies_does_not_end_the_run(self) -> None:
        launch = Launch(self, smoke=True, rate=20, display=self.open_display())
        launch.first("/sim2sim/divergence")
        os.kill(launch.node(self.only_view(launch)), signal.SIGKILL)
        launch.line(r"rviz has died \(exit code -9\): the run goes on headless")
        launch.ended(2 * DEADLINE)
        self.assertEqual(launch.status()["exit_code"], 0, launch.output)
        self.assertEqual(result_bytes(launch.out), self.batch_bytes("--smoke"))

    def test_second_view_does_not_end_the_run(self) -> None:
        launch = Launch(self, smoke=True, rate=20, display=self.open_display())
        launch.first("/sim2sim/divergence")
        first = self.only_view(launch)
        view = Process(
            self, "roslaunch", "sim2sim_eval", "view.launch", environment=launch.environment
        )
        until(lambda: len(views(launch)) == 2, "a second view")
        os.kill(launch.node(first), signal.SIGKILL)
        launch.line(r"rviz has died \(exit code -9\): the run goes on headless")
        launch.ended(2 * DEADLINE)
        view.interrupt()
        view.ended()
        self.assertEqual(launch.status()["exit_code"], 0, launch.output)

    def only_view(self, launch: Launch) -> str:
        until(lambda: bool(views(launch)), "a view")
        (view,) = views(launch)
        return view


class Arguments(LiveCase):
    """A file outside the package is enough."""

    # The names of the nodes that the launch file starts, and what follows from other arguments.
    DERIVED = {
        *("reference_namespace", "engine_namespace", "replay_namespace", "policy_namespace"),
        *("exit", "headless", "working_directory"),
        "policy",  # handed to its own node, unless that is started elsewhere
    }

    def test_every_parameter_of_the_evaluator_is_an_argument(self) -> None:
        launch = Launch(self, parameters={"sim2sim/none_such": 1}, smoke=True)
        launch.ended()
        (names,) = re.findall(r"known: (.*)$", launch.status()["reason"])
        self.assertGreater(set(names.split(", ")), self.DERIVED)
        for name in set(names.split(", ")) - self.DERIVED:
            self.assert_argument("sim2sim_eval", "compare", name, f"/sim2sim/{name}")

    def test_no_argument_is_listed_as_required(self) -> None:
        arguments = self.succeed("roslaunch", "--ros-args", "sim2sim_eval", "compare.launch")
        self.assertIn("Optional Arguments", arguments)
        self.assertNotIn("Required Arguments", arguments)

    def test_roslaunch_leaves_empty_arguments_out(self) -> None:
        """So no launch file can refuse them; script/compare does."""
        path = Path(rospkg.RosPack().get_path("sim2sim_eval")) / "launch" / "compare.launch"
        names = "policy reanchor reference reference_parameters engine engine_parameters".split()
        names += "pusher_mass block_damp baumgarte scene out starts status_file".split()
        empty = self.parameters_of(path, *(f"{name}:=" for name in names))
        self.assertEqual(empty, self.parameters_of(path))

    def test_short_forms_are_parameters_of_the_engine(self) -> None:
        path = Path(rospkg.RosPack().get_path("sim2sim_eval")) / "launch" / "compare.launch"
        for name in ("pusher_mass", "block_damp", "baumgarte"):
            given = self.parameters_of(path, f"{name}:=1")["/sim2sim/engine_parameters"]
            self.assertEqual(given.strip(), f"{name}=1")
        engine = Path(rospkg.RosPack().get_path("pusht_engine")) / "launch" / "engine.launch"
        given = self.parameters_of(engine, "parameters:={block_damp: 20, baumgarte: 50.5}")
        self.assertEqual((given["/engine/block_damp"], given["/engine/baumgarte"]), (20, 50.5))

    def test_evaluator_is_signaled_before_the_nodes_that_it_needs(self) -> None:
        """roslaunch does so in reverse order."""
        path = Path(rospkg.RosPack().get_path("sim2sim_eval")) / "launch" / "compare.launch"
        config = roslaunch.config.ROSLaunchConfig()
        arguments = ["rviz:=true", "expert_node:=true"]
        roslaunch.xmlloader.XmlLoader().load(str(path), config, argv=arguments, verbose=False)
        self.assertEqual([node.name for node in config.nodes][-1], "sim2sim")

    def assert_argument(self, package: str, launch: str, name: str, parameter: str) -> None:
        """A value that is not the default reaches the parameter."""
        path = Path(rospkg.RosPack().get_path(package)) / "launch" / f"{launch}.launch"
        default = self.parameters_of(path).get(parameter)
        value = not default if isinstance(default, bool) else 1
        with self.subTest(name):
            given = self.parameters_of(path, f"{name}:={text_of(value)}")[parameter]
            self.assertNotEqual(default, value)
            self.assertEqual(given, type(given)(value))

    def parameters_of(self, path: Path, *arguments: str) -> Dict[str, Any]:
        config = roslaunch.config.ROSLaunchConfig()
        loader = roslaunch.xmlloader.XmlLoader()
        loader.load(str(path), config, argv=["rviz:=false", *arguments], verbose=False)
        return {name: parameter.value for name, parameter in config.params.items()}


class Refusals(LiveCase):
    """Runs that never begin."""

    def assert_refused(self, reason: str, code: int = 2, **arguments: Any) -> None:
        launch = Launch(self, status_file="copy.json", **arguments)
        launch.ended()
        status = launch.status()
        self.assertEqual(status["exit_code"], code, launch.output)
        self.assertRegex(status["reason"], reason)
        self.assertEqual(status_of_file(self.folder / "copy.json"), status)
        self.assertIn(status["reason"], launch.output)
        self.assertEqual(files(launch.out), {"status.json"})

    def test_f19_no_episodes(self) -> None:
        self.assert_refused("episodes 0: must be from 1 to", episodes=0)

    def test_refusal_does_not_keep_the_folder(self) -> None:
        self.assert_refused("episodes 0: must be from 1 to", episodes=0)
        launch = Launch(self, smoke=True)
        launch.ended()
        self.assertEqual(launch.status()["exit_code"], 0, launch.output)
        self.assertEqual(files(launch.out), RECORDED_RESULTS)

    def test_f19_parameter_that_is_no_number(self) -> None:
        self.assert_refused("block_damp 'abc': must be a", block_damp="abc")

    def test_f19_unknown_kind(self) -> None:
        self.assert_refused("simulator 'bulet': unknown", engine="bulet")

    def test_f19_negative_mass(self) -> None:
        self.assert_refused("pusher_mass -1.0: must be from", pusher_mass=-1)

    def test_f19_unknown_parameter(self) -> None:
        self.assert_refused(
            "/sim2sim/horizont 40: unknown; known: .*horizon",
            parameters={"sim2sim/horizont": 40},
        )

    def test_f19_parameter_of_the_wrong_type(self) -> None:
        self.assert_refused(
            "/sim2sim/deadline soon: must be a number", parameters={"sim2sim/deadline": "soon"}
        )

    def test_f19_number_that_is_octal_elsewhere(self) -> None:
        for name, rule in (("seed", "from 0 to 2.64 - 1"), ("episodes", "of 32 bits")):
            with self.subTest(name):
                reason = f"/sim2sim/{name} 010: must be an integer {rule}"
                arguments: Dict[str, Any] = {"out": name, name: "010"}
                self.assert_refused(reason, **arguments)

    def test_empty_texts(self) -> None:
        for name in ("starts", "reanchor", "model_variants", "engine", "engine_parameters"):
            with self.subTest(name):
                parameters = {f"sim2sim/{name}": ""}
                reason = f"^{name} '': must not be empty; leave it out, or say (auto|none)$"
                self.assert_refused(reason, out=f"empty_{name}", parameters=parameters)

    def test_words_for_what_is_left_out_name_no_place_of_a_refusal(self) -> None:
        words = {"sim2sim/out": "auto", "sim2sim/status_file": "none"}
        launch = Launch(self, episodes=0, out="auto", parameters=words)
        launch.ended()
        self.assertEqual(files(self.folder / "results" / "compare-1"), {"status.json"})
        self.assertEqual([name for name in ("auto", "none") if (self.folder / name).exists()], [])

    def test_f19_namespace_that_is_none(self) -> None:
        self.assert_refused(
            "/sim2sim/policy_namespace 'a b': must be a ROS name",
            parameters={"sim2sim/policy_namespace": "a b"},
        )

    def test_scene_that_lies_where_results_are_written(self) -> None:
        package = Path(rospkg.RosPack().get_path("pusht_mujoco"))
        (shipped,) = package.glob("**/pusht.xml")
        scene = self.folder / "out" / "rows" / "scene.xml"
        scene.parent.mkdir(parents=True)
        scene.write_bytes(shipped.read_bytes())
        launch = Launch(
            self, smoke=True, scene="out/rows/scene.xml", overwrite=True, status_file="copy.json"
        )
        launch.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual(status["exit_code"], 2, launch.output)
        self.assertIn("must not be where results are written", status["reason"])
        self.assertEqual(scene.read_bytes(), shipped.read_bytes())

    def test_f4_policy_that_is_named_must_be_there(self) -> None:
        self.assert_refused(r"none\.pt", policy="none.pt")

    def test_f5_policy_that_is_no_torchscript(self) -> None:
        policy = self.folder / "policy.pt"
        policy.write_text("not a policy")
        self.assert_refused("policy.pt", policy="policy.pt")

    def test_f6_policy_that_is_not_the_one_in_its_provenance(self) -> None:
        (self.folder / "policy.pt").write_text("not a policy")
        expected = {"checkpoint": {"sha256": "0" * 64}}
        (self.folder / "policy.pt.provenance.json").write_text(json.dumps(expected))
        self.assert_refused("policy.pt.*SHA-256", code=3, policy="policy.pt")

    def test_results_are_not_overwritten(self) -> None:
        (self.folder / "out").mkdir()
        (self.folder / "out" / "metrics.json").write_text("mine")
        launch = Launch(self, smoke=True, status_file="copy.json")
        launch.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual(status["exit_code"], 2)
        self.assertRegex(status["reason"], r"out .*: holds results \(metrics.json\)")
        self.assertEqual(files(launch.out), {"metrics.json"})
        self.assertEqual((launch.out / "metrics.json").read_text(), "mine")


class LostNodes(LiveCase):
    """F13 and F14 without respawn; F16."""

    def under_way(self, **more: Any) -> Launch:
        """A run that has finished an episode and is in another one."""
        launch = Launch(self, **{**LONG, **more})
        launch.first("/sim2sim/episode")
        return launch

    def assert_ended_by(self, launch: Launch, reason: str, since: float, patience: float) -> None:
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
                launch = self.under_way(out=node)
                pid = launch.node(f"/{node}")  # which takes its time
                since = time.monotonic()
                os.kill(pid, signal.SIGKILL)
                self.assert_ended_by(launch, f"/{node}/.*: the node has died", since, 1.0)

    def test_f13_killed_node_whose_rollout_has_ended(self) -> None:
        """In episode 1 MuJoCo succeeds after 73 of 300 control steps."""
        launch = Launch(self, policy="expert", first_episode=1, episodes=1, rate=10)
        launch.first("/sim2sim/divergence")
        step = ("rostopic", "echo", "-n1", "/sim2sim/divergence")
        until(lambda: "closed_position: nan" in launch.tool(*step), "the end of a rollout")
        control = ("rosservice", "call", "/sim2sim/control")
        launch.tool(*control, "{command: pause}")
        os.kill(launch.node("/reference"), signal.SIGKILL)
        launch.tool(*control, "{command: resume}")
        launch.line("sim2sim: /reference/describe: the node has died")  # not: end of episode 1: ...
        launch.ended()

    def test_f13_node_that_is_dead_before_the_run_begins(self) -> None:
        launch = Launch(self, policy="expert", start=False, status_file="copy.json")
        launch.line(r"process\[sim2sim-\d+\]: started")
        launch.tool("rosservice", "call", "--wait", "/engine/describe", "{}")
        launch.tool("rosservice", "call", "--wait", "/sim2sim/control", "{command: resume}")
        os.kill(launch.node("/engine"), signal.SIGKILL)
        goal = ("/sim2sim/compare/goal", "pusht_msgs/CompareActionGoal", "{goal: {episodes: [1]}}")
        Process(self, "rostopic", "pub", *goal, environment=launch.environment)
        waits, _ = launch.line("waiting for the node of /engine/describe, for 30 s at most")
        noticed, _ = launch.line("sim2sim: /engine/describe: the master knows a node at .* died")
        self.assertLess(noticed - waits, 15.0)
        copy = self.folder / "copy.json"
        until(lambda: "has died" in status_of_file(copy)["reason"], "an outcome")
        self.assertEqual(status_of_file(copy)["exit_code"], 4)

    def test_f14_stopped_node(self) -> None:
        launch = self.under_way(parameters={"sim2sim/deadline": 0.5})
        pid = launch.node("/engine_replay")
        self.addCleanup(kill, pid, signal.SIGCONT)
        since = time.monotonic()
        os.kill(pid, signal.SIGSTOP)
        reason = "/engine_replay/[a-z]+: no answer within 500 ms"
        launch.line("sim2sim-.* has died")
        os.kill(pid, signal.SIGCONT)
        self.assert_ended_by(launch, reason, since, DEADLINE)

    def test_f16_services_that_another_node_takes_over(self) -> None:
        launch = self.under_way()
        services = ("reset", "step", "configure", "describe")
        remappings = [f"/impostor/{service}:=/engine/{service}" for service in services]
        command = ["rosrun", "pusht_engine", "engine_node", "__name:=impostor", *remappings]
        since = time.monotonic()
        Process(self, *command, environment=launch.environment)
        reason = "/engine: its services belong to another node .* second node of that name"
        self.assert_ended_by(launch, reason, since, DEADLINE)

    def test_f16_second_node_of_a_name(self) -> None:
        launch = self.under_way()
        since = time.monotonic()
        command = ("rosrun", "sim2sim_eval", "quasi_static_simulator", "__name:=engine")
        Process(self, *command, environment=launch.environment)
        reason = "/engine.*: (the node has (died|gone)|its services belong to|another instance)"
        self.assert_ended_by(launch, reason, since, DEADLINE)


class LostRuns(LiveCase):
    """F22 and F23."""

    def test_f22_folder_that_cannot_be_made(self) -> None:
        launch = Launch(self, smoke=True, out="/proc/none/out", status_file="copy.json")
        launch.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual(status["exit_code"], 4)
        self.assertIn("/proc/none/out", status["reason"])

    def test_f22_bag_that_cannot_be_written(self) -> None:
        launch = Launch(self, policy="expert", episodes=50, file_limit=1_000_000)
        launch.ended()
        self.assert_not_whole(launch.out, "cannot write .*compare.bag", bag=False)

    def test_f22_metrics_that_cannot_be_written(self) -> None:
        """Files that cannot grow beyond 1 kB stand for a full disk."""
        launch = Launch(self, policy="expert", episodes=2, rate=1, record=False)
        launch.first("/sim2sim/divergence")
        resource.prlimit(launch.node("/sim2sim"), resource.RLIMIT_FSIZE, (1000, 1000))
        launch.tool("rosservice", "call", "/sim2sim/control", "{command: rate, rate: 100000}")
        launch.ended()
        status = launch.status()
        self.assertEqual((status["exit_code"], status["episodes_finished"]), (4, 2))
        self.assertIn("episodes.csv: File too large", status["reason"])
        self.assertEqual(files(launch.out), {"provenance.json", "status.json"})

    def test_f22_interrupted(self) -> None:
        launch = Launch(self, **LONG)
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
        launch = Launch(self, grace=60, **LONG)
        launch.first("/sim2sim/episode")
        evaluator = launch.node("/sim2sim")
        os.kill(launch.node("/engine"), signal.SIGINT)
        launch.line("lost in episode")
        os.kill(evaluator, signal.SIGINT)
        launch.ended()
        self.assert_not_whole(launch.out, "^interrupted in episode")

    def test_f22_interrupted_while_it_waits_for_a_node(self) -> None:
        launch = Launch(self, policy_node=False)
        launch.line(r"process\[sim2sim-\d+\]: started")
        launch.line("waiting for the node of /policy/describe, for 30 s at most")
        launch.interrupt()
        launch.ended()
        self.assertNotIn("escalating", launch.output)
        self.assertEqual(launch.status()["exit_code"], 4)
        self.assertEqual(launch.status()["reason"], "interrupted before the first episode")

    def test_f22_signal_as_soon_as_the_evaluator_runs(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number.name):
                launch = Launch(self, out=number.name, status_file="copy.json", **LONG)
                started = launch.line(r"process\[sim2sim-\d+\]: started with pid \[\d+\]")[1]
                pid = int(started.split("with pid [")[1].split("]")[0])
                until(lambda: catches(pid, number), "a handler")
                os.kill(pid, number)
                launch.ended()
                self.assertEqual(launch.status()["exit_code"], 4)
                self.assertEqual(launch.status()["episodes_finished"], 0)
                self.assertEqual(status_of_file(self.folder / "copy.json"), launch.status())

    def test_f22_killed_roslaunch(self) -> None:
        python = '<node name="python" pkg="sim2sim_eval" type="quasi_static_simulator"/>'
        launch = Launch(self, beside=python, **LONG)
        launch.first("/sim2sim/episode")
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
        Launch(self, smoke=True, status_file="copy.json").ended()
        before = result_bytes(self.folder / "out")
        (self.folder / "none.xml").write_text("<mujoco/>")
        launch = Launch(self, overwrite=True, scene="none.xml", status_file="copy.json")
        launch.ended()
        status = launch.status()
        self.assertEqual((status["exit_code"], status["beside_earlier_results"]), (2, True))
        self.assertIn("none.xml", status["reason"])
        self.assertEqual(status_of_file(self.folder / "copy.json")["exit_code"], 2)
        self.assertEqual(result_bytes(launch.out), before, "nothing is lost")

    def test_f7_killed_before_the_run_begins(self) -> None:
        (self.folder / "copy.json").write_text('{"exit_code": 0, "reason": "finished"}')
        launch = Launch(self, policy_node=False, status_file="copy.json")
        launch.line(r"process\[sim2sim-\d+\]: started")
        launch.tool("rosservice", "call", "--wait", "/sim2sim/control", "{command: pause}")
        os.kill(launch.node("/sim2sim"), signal.SIGKILL)
        launch.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual((status["exit_code"], status["reason"]), (4, "under way, or killed"))

    def test_f23_killed_evaluator(self) -> None:
        launch = Launch(self, policy="expert", episodes=1000)
        part = launch.out / "compare.bag.part"
        launch.first("/sim2sim/episode")
        until(
            lambda: part.stat().st_size > 2**20, "an episode on the disk"
        )  # written when there is time
        os.kill(launch.node("/sim2sim"), signal.SIGKILL)
        launch.ended()
        self.assertEqual(files(launch.out), {"provenance.json", "status.json", part.name})
        status = launch.status()
        self.assertEqual((status["exit_code"], status["reason"]), (4, "under way, or killed"))
        recovered = self.folder / "recovered.bag"
        part.rename(recovered)
        self.succeed("rosbag", "reindex", str(recovered))
        command = ("rosrun", "sim2sim_eval", "recompute", str(recovered), "--out", "again")
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
        nodes = [Process(self, "rosrun", *node, environment=environment) for node in self.NODES]
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
        for package, name in (("sim2sim_eval", "evaluator_node"), ("pusht_task", CONTRACT)):
            node = Process(self, "rosrun", package, name, environment=environment)
            self.assertEqual(node.ended(10.0), 4, node.output)
            self.assertIn(f"no ROS master at {uri}: start roscore", node.output)

    def test_nodes_wait_for_the_master(self) -> None:
        uri = f"http://127.0.0.1:{free_port()}"
        environment = {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        waiting = [node for node in self.NODES if node[1] != "evaluator_node"]
        nodes = [
            Process(self, "rosrun", *node, f"__name:={node[1]}", environment=environment)
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

    def test_contracts_say_how_they_are_used(self) -> None:
        uri = f"http://127.0.0.1:{free_port()}"
        for name, subject in (
            (CONTRACT, "simulator"),
            ("own_simulator_contract", "simulator"),
            ("policy_contract", "policy"),
            ("own_policy_contract", "policy"),
            ("failed_start_contract", "node"),
        ):
            usage = f"usage: rosrun pusht_task {name} --text _{subject}:=/NAME"
            command = ("rosrun", "pusht_task", name)
            shown = self.succeed(*command, "--help", environment={"ROS_MASTER_URI": uri})
            self.assertIn(usage, shown)
        _, uri = self.start_master()
        contract = Process(
            self, "rosrun", "pusht_task", CONTRACT, environment={"ROS_MASTER_URI": uri}
        )
        self.assertEqual(contract.ended(), 2, contract.output)
        self.assertRegex(contract.output, "parameter ~simulator is not set; usage: rosrun")

    def test_f15_master_that_dies(self) -> None:
        master, uri = self.start_master()
        launch = Launch(self, master_uri=uri, **LONG)
        launch.first("/sim2sim/episode")
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
        node = Process(self, "rosrun", "sim2sim_eval", "evaluator_node", environment=environment)
        until(lambda: catches(node.pid, signal.SIGTERM) and in_poll(node.pid), "a call")
        os.kill(node.pid, signal.SIGTERM)
        until(lambda: signals(node.pid, "ShdPnd") == 0, "the signal")
        os.kill(master.pid, signal.SIGCONT)
        self.assertEqual(node.ended(), 4, node.output)
        self.assertEqual(status_of(self.folder / "out")["exit_code"], 4)

    def test_f29_policy_node_ends_while_it_tries_a_policy_out(self) -> None:
        _, uri = self.start_master()
        torch.jit.script(Endless(-10.0, 10.0)).save(str(self.folder / "endless.pt"))
        command = (executable("pusht_policy", "policy_node"), "_policy:=endless.pt")
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
        launch = Launch(self, parameters={"/use_sim_time": True}, smoke=True, status_file=copy)
        launch.ended()
        self.assertIn("sim2sim: /use_sim_time is set, but nothing publishes /clock", launch.output)
        self.assertEqual(files(launch.out), {"status.json"})
        self.assertEqual(launch.status()["exit_code"], 4)
        self.assertEqual(status_of_file(copy), launch.status())


def views(launch: Launch) -> List[str]:
    """The names of the nodes that are rviz."""
    return [name for name in launch.tool("rosnode", "list").split() if name.startswith("/rviz")]


def in_poll(pid: int) -> bool:
    """Whether the main thread of a process waits for an answer."""
    return "poll" in Path(f"/proc/{pid}/wchan").read_text()


def runs(pid: int) -> bool:
    """A process that has ended may wait for its parent to ask for its exit code."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def status_of_file(path: Path) -> Any:
    return json.loads(path.read_text())
