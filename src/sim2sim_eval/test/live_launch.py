#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""compare.launch as its user meets it: results, notices, and refusals.

The numbers of the faults are those of the project's list. live_faults.py has the lost nodes.
"""

import json
import os
import re
import shutil
import signal
from pathlib import Path
from typing import Any, Dict, List

import rosgraph  # type: ignore[import]
import rospkg  # type: ignore[import]
import rospy  # type: ignore[import]
from pusht_testing.long_tests import LONG

from gym_policies import LEROBOT, save_mlp
from launch_support import (
    LAUNCHES,
    Launch,
    Run,
    SharedLaunch,
    Start,
    configuration,
    node_file,
    parameters_of,
    shared_master,
)
from live_support import (
    DEADLINE,
    RECORDED_RESULTS,
    RESULTS,
    LiveCase,
    Process,
    files,
    result_bytes,
    status_of,
    status_of_file,
    text_of,
    until,
)

COMPARE = LAUNCHES / "compare.launch"


class Runs(LiveCase):
    def test_smoke_run_without_a_display(self) -> None:
        """With all that a run can leave: a folder of its own, a report, a copy of its status."""
        launch = Launch(self, smoke=True, out="auto", report=True, status_file="copy.json")
        self.assertEqual(launch.ended(), 0)
        self.assertIn("running headless: no display (DISPLAY is not set)", launch.output)
        out = self.folder / "results" / "compare-1"
        self.assertEqual(status_of(out)["exit_code"], 0, launch.output)
        copy = (self.folder / "copy.json").read_bytes()
        self.assertEqual(copy, (out / "status.json").read_bytes())
        self.assertEqual(files(out), RECORDED_RESULTS | {"report.html"})
        self.assertEqual(result_bytes(out), self.batch_bytes("--smoke"))
        self.assert_recomputed(out)
        page = (out / "report.html").read_text(encoding="utf-8")
        self.assertIn("roslaunch sim2sim_eval compare.launch", page)

    def test_nothing_of_an_earlier_launch_comes_in(self) -> None:
        """Parameters that it has left under the names of the nodes, on a master that stays."""
        short: Dict[str, Any] = {"policy": "expert", "episodes": 2, "horizon": 30}
        master = shared_master()
        master.end_nodes()
        master.forget(keep=set())
        given = ("starts:=s.csv", "reanchor:=5", "rate:=7", "model_variants:=cone=elliptic")
        for name in parameters_of(COMPARE, "rviz:=false", "smoke:=true", *given):
            rospy.set_param(name, "left by another")
        for node in ("sim2sim", "policy", "reference", "engine", "engine_replay"):
            rospy.set_param(f"/{node}/none_such", "would be refused")
        launch = Launch(self, master_uri=master.uri, rviz=False, **short)
        self.assertEqual(launch.ended(), 0, launch.output)
        words = ("--policy", "expert", "--episodes", "2", "--horizon", "30")
        self.assertEqual(result_bytes(launch.out), self.batch_bytes(*words))

    def test_report_that_cannot_be_written(self) -> None:
        (self.folder / "rosrun").write_text("#!/bin/sh\nexit 3\n")
        (self.folder / "rosrun").chmod(0o755)
        path = {"PATH": f"{self.folder}:{os.environ['PATH']}"}
        run = Start(self, smoke=True, report=True, status_file="copy.json", environment=path)
        self.assertEqual(run.ended(), 4)
        self.assertIn("its report was not written: report ended with exit code 3", run.output)
        self.assertEqual(status_of_file(self.folder / "copy.json")["exit_code"], 4)
        self.assertEqual(run.status()["exit_code"], 0, "of the run, whose results stand")
        self.assertEqual(files(run.out), RECORDED_RESULTS)

    def test_arguments_mean_what_they_mean_to_the_command(self) -> None:
        run = Start(self, policy="expert", episodes=2, seed=4, block_damp=20, record=False)
        self.assertEqual(run.ended(), 0)
        self.assertNotIn("no display", run.output)
        self.assertEqual(files(run.out), RESULTS)
        wanted = "--policy expert --episodes 2 --seed 4 --block_damp 20".split()
        self.assertEqual(result_bytes(run.out), self.batch_bytes(*wanted))

    def test_a_task_goes_over_nodes_and_back(self) -> None:
        """gym-pusht's, with a policy on its keypoints; a third one in a file; and the course's."""
        shutil.copy(LAUNCHES.parent / "config" / "big_tee.json", self.folder)
        of_gym = str(self.folder / "corners.pt")
        save_mlp(of_gym, LEROBOT, 18, past=2, chunk=16)
        tasks = {
            "gym_pusht": (of_gym, "gym_pusht", "mujoco"),
            "big_tee.json": ("expert", "mujoco", "rigid_body"),
            "full_circle": ("expert", "mujoco", "rigid_body"),
        }
        for task, (policy, reference, engine) in tasks.items():
            with self.subTest(task):
                run = Start(
                    self,
                    policy=policy,
                    episodes=2,
                    horizon=60,
                    reanchor="5",
                    model_variants="timestep=0.005" if reference == "mujoco" else "none",
                    task=task,
                    reference=reference,
                    engine=engine,
                    engine_parameters="loop.preset=tracker loop.action_delay=1",
                    out=f"out_{engine}_{reference}_{len(task)}",
                )
                self.assertEqual(run.ended(), 0, run.output)
                self.assert_recomputed(run.out)
                words = f"--policy {policy} --episodes 2 --horizon 60 --reanchor=5 --task {task}"
                kinds = f"--reference {reference} --engine {engine}"
                kinds += " --set loop.preset=tracker --set loop.action_delay=1"
                kinds += " --model-variants=timestep=0.005" * (reference == "mujoco")
                self.assertEqual(
                    result_bytes(run.out), self.batch_bytes(*words.split(), *kinds.split())
                )

    def test_tasks_that_nodes_do_not_hold(self) -> None:
        gym = {"task": "gym_pusht", "policy": "expert", "reference": "gym_pusht"}
        cases: Dict[str, Dict[str, Any]] = {
            "task gym_pusht: the kind two_mass holds only full_circle": gym,
            "acts in the task full_circle: must in gym_pusht; start it with the parameter task": {
                **gym,
                "engine": "chipmunk",
                "parameters": {"policy/task": "full_circle"},
            },
            "task 'pusht': must be one of: full_circle, gym_pusht; or a file": {"task": "pusht"},
        }
        for number, (words, arguments) in enumerate(cases.items()):
            with self.subTest(words):
                run = Start(self, out=number, **arguments)
                self.assertEqual(run.ended(), 2, run.output)
                self.assertIn(words, run.output)

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
                run = Start(self, policy="expert", episodes=1, out=number, **arguments)
                self.assertEqual(run.ended(), 0, run.output)
                wanted = self.batch_bytes(*"--policy expert --episodes 1".split(), *options.split())
                self.assertEqual(result_bytes(run.out), wanted)
                self.assert_recomputed(run.out)

    def test_status_of_a_goal_is_copied(self) -> None:
        run = Start(self, keep=False, policy="expert", start=False, status_file="copy.json")
        run.control("resume")
        copy = self.folder / "copy.json"
        self.assertFalse(copy.exists(), "there has been no run")
        self.run_goal(run, "out")
        self.assertEqual(copy.read_bytes(), (run.out / "status.json").read_bytes())

    def test_lost_node_is_brought_back_as_documented(self) -> None:
        """Whatever kind a run has made of it."""
        run = Start(self, keep=False, policy="expert", start=False)
        self.run_goal(run, "first", engine="rigid_body")
        lost = run.node("/engine")
        os.kill(lost, signal.SIGKILL)
        command = ("roslaunch", "sim2sim_eval", "simulator.launch", "name:=engine")
        Process(self, *command, "kind:=two_mass", environment=run.environment)
        until(lambda: self.answers_anew(run, lost), "the node")
        self.run_goal(run, "second")
        wanted = self.batch_bytes("--policy", "expert", "--episodes", "1")
        self.assertEqual(result_bytes(self.folder / "second"), wanted)

    def answers_anew(self, run: Run, lost: int) -> bool:
        """Whether another process than the lost one serves the engine."""
        try:
            return run.node("/engine") != lost
        except (OSError, rosgraph.MasterError):
            return False

    def run_goal(self, run: Run, out: str, **fields: str) -> None:
        """Waits for a run that must finish."""
        folder = str(self.folder / out)
        client = run.send_goal(episodes=1, record=False, out=folder, **fields)
        self.assertTrue(client.wait_for_result(rospy.Duration(DEADLINE)))
        self.assertEqual(client.get_result().reason, "finished")

    def test_policies_with_memory_chunks_and_noise_survive_a_killed_node(self) -> None:
        """Their episode begins again, with the same noise."""
        given: Dict[str, Any] = {"episodes": 2, "horizon": 60}
        options = " ".join(f"--{name} {value}" for name, value in given.items())
        chunks = [("chunk", 4)] if LONG else []  # flow answers with chunks, too, of noise
        for name, execute in (("gru", 0), *chunks, ("flow", 8)):
            with self.subTest(name):
                policy = str(rospkg.RosPack().get_path("pusht_policy")) + f"/policies/{name}.ts.pt"
                given.update(policy=policy, execute=execute, respawn=True, rate=5)
                run = Start(self, out=name, **given)
                run.first("/sim2sim/divergence")
                run.control("pause")
                os.kill(run.node("/policy"), signal.SIGKILL)
                node = (node_file("pusht_policy", "policy_node"), "__name:=policy")
                again = Process(self, *node, environment=run.environment)
                run.control("rate", rate=-1.0)
                run.control("resume")
                self.assertEqual(run.ended(), 0, run.output)
                self.assertEqual(run.status()["faults_survived"], 1)
                batch = ("--policy", policy, *options.split(), "--execute", str(execute))
                self.assertEqual(result_bytes(run.out), self.batch_bytes(*batch))
                self.assert_recomputed(run.out)
                again.interrupt()
                again.ended()

    def with_engine_from_elsewhere(self, *node: str, **arguments: Any) -> Run:
        run = Start(
            self, policy="expert", episodes=1, engine_nodes=False, record=False, **arguments
        )
        for name in ("engine", "engine_replay"):
            command = (node_file(*node[:2]), *node[2:], f"__name:={name}")
            Process(self, *command, environment=run.environment)
        run.ended()
        return run

    def test_parameters_reach_an_engine_that_is_started_elsewhere(self) -> None:
        run = self.with_engine_from_elsewhere("pusht_engine", "engine_node", block_damp=20)
        wanted = "--policy expert --episodes 1 --block_damp 20".split()
        self.assertEqual(result_bytes(run.out), self.batch_bytes(*wanted))

    def test_engine_that_is_started_elsewhere_becomes_the_kind_that_is_named(self) -> None:
        node = ("sim2sim_eval", "simulator_node", "_kind:=two_mass")
        run = self.with_engine_from_elsewhere(*node, engine="chipmunk")
        wanted = "--policy expert --episodes 1 --engine chipmunk".split()
        self.assertEqual(result_bytes(run.out), self.batch_bytes(*wanted))

    def test_engine_that_is_started_elsewhere_and_cannot_be_what_is_named_refuses(self) -> None:
        node = ("pusht_engine", "engine_node")
        run = self.with_engine_from_elsewhere(*node, engine="chipmunk")
        status = run.status()
        self.assertEqual(status["exit_code"], 2, run.output)
        self.assertIn("simulator 'chipmunk': must be two_mass, the only kind", status["reason"])

    def test_run_says_how_far_it_is_and_that_all_is_well(self) -> None:
        run = Start(self, policy="expert", episodes=2, horizon=60, rate=10)
        run.first("/sim2sim/episode")
        run.control("rate", rate=100000)
        run.ended()
        run.line(r"0 of 2 episodes finished, the next one is at control step \d+")
        run.line(f"finished, all is well: results in {run.out}")

    def test_policy_that_is_started_elsewhere_must_be_the_one_that_is_named(self) -> None:
        run = Start(self, policy="bc", policy_node=False)
        command = (node_file("pusht_policy", "policy_node"), "__name:=policy", "_policy:=expert")
        Process(self, *command, environment=run.environment)
        run.ended()
        status = run.status()
        self.assertEqual(status["exit_code"], 2, run.output)
        self.assertIn("policy bc: /policy serves expert", status["reason"])


class Displays(LiveCase):
    """A display is there, cannot be opened, or goes."""

    def test_display_that_cannot_be_opened(self) -> None:
        launch = SharedLaunch(self, smoke=True, rviz=True, display=":77")
        launch.ended()
        self.assertIn("running headless: no display (DISPLAY is :77, which cannot", launch.output)
        self.assertEqual(result_bytes(launch.out), self.batch_bytes("--smoke"))

    def test_rviz_that_dies_does_not_end_the_run(self) -> None:
        """A second view goes on, and ends when its own launch does."""
        display = self.open_display("320x240x24")  # which is quickly drawn
        launch = SharedLaunch(self, smoke=True, rviz=True, rate=20, display=display)
        launch.first("/sim2sim/divergence")
        launch.control("pause")
        first = self.only_view(launch)
        command = ("roslaunch", "sim2sim_eval", "view.launch")
        view = Process(self, *command, environment=launch.environment)
        until(lambda: len(views()) == 2, "a second view")
        os.kill(launch.node(first), signal.SIGKILL)
        launch.line(r"rviz has died \(exit code -9\): the run goes on headless")
        launch.control("rate", rate=-1.0)
        launch.control("resume")
        launch.ended()
        view.interrupt()
        view.ended()
        self.assertEqual(launch.status()["exit_code"], 0, launch.output)
        self.assertEqual(result_bytes(launch.out), self.batch_bytes("--smoke"))

    def only_view(self, launch: Launch) -> str:
        until(lambda: bool(views()), "a view")
        (view,) = views()
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
        run = Start(self, parameters={"sim2sim/none_such": 1}, policy="expert")
        run.ended()
        (names,) = re.findall(r"known: (.*) \(set by a launch", run.status()["reason"])
        self.assertGreater(set(names.split(", ")), self.DERIVED)
        default = parameters_of(COMPARE, "rviz:=false")
        for name in set(names.split(", ")) - self.DERIVED:
            with self.subTest(name):
                self.assert_argument(name, default.get(f"/sim2sim/{name}"))

    def test_no_argument_is_listed_as_required(self) -> None:
        arguments = self.succeed("roslaunch", "--ros-args", "sim2sim_eval", "compare.launch")
        self.assertIn("Optional Arguments", arguments)
        self.assertNotIn("Required Arguments", arguments)

    def test_roslaunch_leaves_empty_arguments_out(self) -> None:
        """So no launch file can refuse them; script/compare does."""
        names = "policy reanchor reference reference_parameters engine engine_parameters".split()
        names += "pusher_mass block_damp baumgarte scene out starts status_file".split()
        empty = parameters_of(COMPARE, "rviz:=false", *(f"{name}:=" for name in names))
        self.assertEqual(empty, parameters_of(COMPARE, "rviz:=false"))

    def test_short_forms_are_parameters_of_the_engine(self) -> None:
        for name in ("pusher_mass", "block_damp", "baumgarte"):
            given = parameters_of(COMPARE, "rviz:=false", f"{name}:=1")[
                "/sim2sim/engine_parameters"
            ]
            self.assertEqual(given.strip(), f"{name}=1")
        engine = Path(rospkg.RosPack().get_path("pusht_engine")) / "launch" / "engine.launch"
        given = parameters_of(engine, "parameters:={block_damp: 20, baumgarte: 50.5}")
        self.assertEqual((given["/engine/block_damp"], given["/engine/baumgarte"]), (20, 50.5))

    def test_evaluator_is_signaled_before_the_nodes_that_it_needs(self) -> None:
        """roslaunch does so in reverse order."""
        config = configuration(COMPARE, "rviz:=true", "expert_node:=true")
        self.assertEqual([node.name for node in config.nodes][-1], "sim2sim")

    def assert_argument(self, name: str, default: Any) -> None:
        """A value that is not the default reaches the parameter."""
        value = not default if isinstance(default, bool) else 1
        given = parameters_of(COMPARE, "rviz:=false", f"{name}:={text_of(value)}")
        self.assertNotEqual(default, value)
        self.assertEqual(given[f"/sim2sim/{name}"], type(given[f"/sim2sim/{name}"])(value))


class Refusals(LiveCase):
    """Runs that never begin."""

    def assert_refused(self, reason: str, code: int = 2, **arguments: Any) -> None:
        arguments.setdefault("policy", "expert")
        run = Start(self, status_file="copy.json", **arguments)
        self.assertEqual(run.ended(), code, run.output)
        self.assert_refusal(run, reason, code)

    def assert_refusal(self, run: Run, reason: str, code: int) -> None:
        status = run.status()
        self.assertEqual(status["exit_code"], code, run.output)
        self.assertRegex(status["reason"], reason)
        self.assertEqual(status_of_file(self.folder / "copy.json"), status)
        self.assertIn(status["reason"], run.output)
        self.assertEqual(files(run.out), {"status.json"})

    def test_f19_no_episodes(self) -> None:
        self.assert_refused("episodes 0: must be from 1 to", episodes=0)

    def test_refusal_does_not_keep_the_folder(self) -> None:
        self.assert_refused("episodes 0: must be from 1 to", episodes=0)
        run = Start(self, smoke=True)
        self.assertEqual(run.ended(), 0, run.output)
        self.assertEqual(run.status()["exit_code"], 0, run.output)
        self.assertEqual(files(run.out), RECORDED_RESULTS)

    def test_f19_parameter_that_is_no_number(self) -> None:
        self.assert_refused("block_damp 'abc': must be a", block_damp="abc")

    def test_f19_unknown_kind(self) -> None:
        """Two nodes cannot start. They answer all the same, until roslaunch ends them."""
        launch = SharedLaunch(self, policy="expert", engine="bulet", status_file="copy.json")
        launch.ended()
        self.assert_refusal(launch, "simulator 'bulet': unknown", 2)
        self.assertFalse(rospy.has_param("/sim2sim"), "what the launch has set is left to others")

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
        Start(self, policy="expert", episodes=0, out="auto", parameters=words).ended()
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
        place: Dict[str, Any] = {"scene": "out/rows/scene.xml", "overwrite": True}
        run = Start(self, policy="expert", status_file="copy.json", **place)
        run.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual(status["exit_code"], 2, run.output)
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
        run = Start(self, policy="expert", status_file="copy.json")
        run.ended()
        status = status_of_file(self.folder / "copy.json")
        self.assertEqual(status["exit_code"], 2)
        self.assertRegex(status["reason"], r"out .*: holds results \(metrics.json\)")
        self.assertEqual(files(run.out), {"metrics.json"})
        self.assertEqual((run.out / "metrics.json").read_text(), "mine")


def views() -> List[str]:
    """Names of the nodes that are rviz."""
    publishers, subscribers, services = rosgraph.Master("/live_test").getSystemState()
    kinds = (publishers, subscribers, services)
    names = {name for kind in kinds for _, nodes in kind for name in nodes}
    return [name for name in names if name.startswith("/rviz")]
