#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The commands as a user meets them: figures, bytes, and the outcome of every fault."""

import csv
import fcntl
import io
import json
import os
import pickle
import pty
import shutil
import signal
import subprocess
import time
import unittest
import zipfile
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Union

import rosbag  # type: ignore[import]
import rospkg  # type: ignore[import]
import torch
from pusht_policy.demonstrations import (
    DEMONSTRATION_FORMAT,
    read_demonstrations,
    read_origin,
    sha256_of_frames,
)
from sim2sim_report.results import METRICS_FORMAT
from sim2sim_protocol.configuration import ALWAYS

from command_case import DEADLINE, CommandCase, executable, signals, until
from torch_policies import Endless

PACKAGES = rospkg.RosPack()
PATIENCE = 10.0  # s, in which a command that was asked to end must have ended
SCENE = Path(PACKAGES.get_path("pusht_mujoco"), "scenes", "pusht.xml")
RESULTS = {
    *("metrics.json", "statistics.json", "episodes.csv", "divergence.csv"),
    *("provenance.json", "status.json"),
}
UNFINISHED = {"episodes.csv", "episodes.journal", "provenance.json", "status.json"}
FLOORS = ("floor_1e-9", "floor_1e-6")
ROLLOUTS = ("reference_closed", "engine_closed", "engine_replay", *FLOORS)
COMPARE = executable("sim2sim_eval", "compare")
DEMONSTRATE = executable("sim2sim_eval", "demonstrate")
RECOMPUTE = executable("sim2sim_eval", "recompute")
RECORD_EVALUATION = executable("sim2sim_eval", "record_evaluation")
SWEEP = executable("sim2sim_eval", "sweep")
TRAIN = executable("pusht_policy", "train")
SHORT = ("--policy", "expert", "--episodes", "2", "--horizon", "40")  # needs no libtorch
PRELOAD = "libraise_mujoco_error.so"  # found in the workspace by the loader


class CompareCase(CommandCase):
    """Runs comparisons."""

    def compare(
        self, *arguments: str, environment: Optional[Dict[str, str]] = None
    ) -> "subprocess.CompletedProcess[str]":
        return self.run_command(COMPARE, *arguments, environment=environment)

    def finished(self, *arguments: str, out: str = "out", **named: Any) -> Dict[str, Any]:
        """The metrics of a comparison that must succeed."""
        process = self.compare(*arguments, "--out", out, **named)
        self.assertEqual(process.returncode, 0, process.stderr)
        recorded = {"compare.bag"} if "--record" in arguments else set()
        self.assertEqual(self.files(out), RESULTS | recorded)
        return self.load(out, "metrics.json")

    def refused(self, code: int, *arguments: str, out: str = "out", **named: Any) -> str:
        """The one line with which a run is refused before it writes anything."""
        process = self.compare(*arguments, "--out", out, **named)
        self.assert_one_line(process, code)
        self.assertFalse((self.folder / out).exists(), "a refused run leaves no folder")
        return process.stderr

    def failed(self, code: int, *arguments: str, **named: Any) -> str:
        """The one line with which a run ends that had begun; no metrics, but a status."""
        process = self.compare(*arguments, "--out", "out", **named)
        self.assert_one_line(process, code)
        status = self.load("out", "status.json")
        self.assertEqual(status["exit_code"], code)
        self.assertIn(status["reason"], process.stderr)
        self.assertFalse((self.folder / "out" / "metrics.json").exists())
        return process.stderr

    def assert_one_line(
        self, process: "subprocess.CompletedProcess[str]", code: int, command: str = "compare"
    ) -> None:
        super().assert_one_line(process, code, command)


class Measurement(CompareCase):
    def test_smoke_run_meets_the_courses_figures_and_repeats_its_bytes(self) -> None:
        metrics = self.finished("--smoke", out="a")
        self.finished("--smoke", out="b")
        self.assertEqual(self.result_bytes("a"), self.result_bytes("b"))
        self.assertAlmostEqual(metrics["mean_pos_divergence_m"], 0.004037, delta=1e-4)
        self.assertAlmostEqual(metrics["mean_ang_divergence_rad"], 0.038148, delta=1e-4)
        self.assertEqual((metrics["mj_success_rate"], metrics["engine_success_rate"]), (0, 0))
        self.assertEqual((metrics["episodes"], metrics["horizon"]), (2, 40))
        self.assertEqual(metrics["policy"], "fresh-untrained")
        self.assertEqual(metrics["config_hash"], "636a7da5cf2c")

    def test_shipped_policy_runs_on_the_kernel_and_solves_the_task(self) -> None:
        metrics = self.finished()
        self.assertEqual(metrics["config_hash"], "4d20147498c1")
        self.assertEqual((metrics["episodes"], metrics["policy"]), (50, "bc"))
        self.assertGreater(metrics["mj_success_interval"][0], 0.3)
        provenance = self.load("out", "provenance.json")
        self.assertEqual(set(provenance["configuration"]), ALWAYS)
        self.assertEqual(provenance["policy"]["runs_on"], "fixed-order kernel")
        recorded = json.loads(
            Path(
                PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt.provenance.json"
            ).read_text()
        )
        self.assertEqual(provenance["policy"]["sha256"], recorded["checkpoint"]["sha256"])
        status = self.load("out", "status.json")
        self.assertEqual((status["reason"], status["faults_survived"]), ("finished", 0))

    def test_shipped_policys_provenance_tells_its_evaluation(self) -> None:
        path = Path(
            PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt.provenance.json"
        )
        recorded = json.loads(path.read_text())
        self.assertEqual(recorded["evaluation"]["episodes"], 50)
        self.assertEqual(recorded["evaluation"]["seed"], 0)
        self.assertEqual(recorded["demonstrations"]["episodes"], 500)
        self.assertEqual(recorded["training"]["epochs"], 600)
        # Another libm or FMA class changes single episodes, not the picture.
        successes = self.finished()["mj_successes"]
        self.assertAlmostEqual(recorded["evaluation"]["successes"], successes, delta=5)

    def test_provenance_names_the_versions_of_those_who_took_part(self) -> None:
        process = self.run_command(COMPARE, *SHORT, "--engine", "chipmunk", "--out", "out")
        self.assertIn("engine - reference", process.stdout, "Chipmunk's greeting alone is silenced")
        provenance = self.load("out", "provenance.json")
        self.assertRegex(provenance["engine"]["version"], r"^7\.\d+\.\d+$")
        self.assertRegex(provenance["reference"]["version"], r"^\d+\.\d+\.\d+$")
        self.assertNotIn("mujoco", provenance["software"], "it need not take part")
        for library in ("libmujoco.so", "libccd.so", "libchipmunk.so"):  # what they compute with
            self.assertTrue(any(name.startswith(library) for name in provenance["code"]), library)

    def test_same_kind_in_both_roles_keeps_its_bytes_on_every_way(self) -> None:
        """Nothing of one role may reach the other: not its parameters, nor its kept rollouts."""
        run = ("--policy", "expert", "--episodes", "4")
        ways: Dict[str, List[str]] = {
            "one": ["--threads", "1"],
            "two": ["--threads", "2", "--record"],
            "cold": ["--reference-cache", "kept"],
            "warm": ["--reference-cache", "kept"],
        }
        two_mass = ("--set-reference", "block_damp=20", "--engine", "two_mass")
        swapped = ("--set", "block_damp=20", "--engine", "two_mass")
        for name, roles in {
            "twins": ("--reference", "two_mass", *two_mass),
            "swapped": ("--reference", "two_mass", *swapped),
            "chipmunk": ("--reference", "chipmunk"),
        }.items():
            for way, arguments in ways.items():
                self.finished(*run, *roles, *arguments, out=f"{name}-{way}")
                self.assertEqual(
                    self.result_bytes(f"{name}-{way}"), self.result_bytes(f"{name}-one"), name
                )
            again = self.run_command(RECOMPUTE, f"{name}-two/compare.bag", "--out", f"{name}-again")
            self.assertEqual(again.returncode, 0, again.stderr)
            self.assertEqual(self.result_bytes(f"{name}-again"), self.result_bytes(f"{name}-one"))
        steps = {}
        for name in ("twins", "swapped"):
            with (self.folder / f"{name}-one" / "episodes.csv").open() as file:
                rows = list(csv.DictReader(file))
            for mode in ("reference_closed", "engine_closed"):
                steps[name, mode] = [
                    (row["steps"], row["final_position_error_m"])
                    for row in rows
                    if row["mode"] == mode
                ]
        self.assertEqual(steps["twins", "reference_closed"], steps["swapped", "engine_closed"])
        self.assertEqual(steps["twins", "engine_closed"], steps["swapped", "reference_closed"])
        self.assertNotEqual(steps["twins", "engine_closed"], steps["twins", "reference_closed"])

    def test_rows_agree_with_the_metrics(self) -> None:
        metrics = self.finished("--policy", "expert", "--episodes", "6", "--seed", "4")
        with (self.folder / "out" / "episodes.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["mode"] for row in rows], 6 * list(ROLLOUTS))
        self.assertEqual(
            [row["seed"] for row in rows[:: len(ROLLOUTS)]], [str(10004 + i) for i in range(6)]
        )
        successes = [
            row for row in rows if row["mode"] == "reference_closed" and row["success"] == "true"
        ]
        self.assertEqual(len(successes), metrics["mj_successes"])
        replays = [
            float(r["mean_angle_divergence_rad"]) for r in rows if r["mode"] == "engine_replay"
        ]
        self.assertAlmostEqual(sum(replays) / 6, metrics["mean_ang_divergence_rad"], delta=1e-6)

    def test_closed_loops_say_how_they_end(self) -> None:
        options = ("--no-floor", "--closed-variants", "timestep=0.005")
        self.run_all((COMPARE, "--episodes", "20", *options, "--out", "ends"))
        with (self.folder / "ends" / "episodes.csv").open() as file:
            rows = list(csv.DictReader(file))
        closed = [row for row in rows if "replay" not in row["mode"]]
        self.assertEqual(len(closed), 3 * 20, "reference, engine and the variant")
        for row in rows:
            if row not in closed:
                ends = [row[name] for name in ("ending", "still_step", "pusher_ending")]
                self.assertEqual(ends, ["", "", ""])
            else:
                self.assertEqual(row["ending"] == "success", row["success"] == "true")
                still = int(row["steps"]) - int(row["still_step"])
                self.assertEqual(row["ending"] == "stuck", still >= 50 and row["success"] != "true")
        metrics = self.load("ends", "metrics.json")
        for role in ("reference", "engine"):
            ends = [row["ending"] for row in closed if row["mode"] == f"{role}_closed"]
            self.assertEqual(metrics[f"{role}_stuck"], ends.count("stuck"))
            self.assertGreater(ends.count("stuck"), 0)

    def test_run_can_be_split(self) -> None:
        self.finished("--policy", "expert", "--episodes", "5", out="whole")
        self.finished("--policy", "expert", "--episodes", "2", out="a")
        metrics = self.finished(
            "--policy", "expert", "--first-episode", "2", "--episodes", "3", out="b"
        )
        self.assertEqual((metrics["first_episode"], metrics["episodes"]), (2, 3))
        rows = {
            out: (self.folder / out / "episodes.csv").read_text().splitlines(keepends=True)
            for out in ("whole", "a", "b")
        }
        self.assertEqual(rows["whole"], rows["a"] + rows["b"][1:])

    def test_parameters_change_the_engine_and_nothing_else(self) -> None:
        self.finished("--policy", "expert", "--episodes", "3", out="a")
        self.finished("--policy", "expert", "--episodes", "3", "--block_damp", "60", out="b")
        rows = {}
        for out in ("a", "b"):
            with (self.folder / out / "episodes.csv").open() as file:
                rows[out] = list(csv.DictReader(file))
        for a, b in zip(rows["a"], rows["b"]):
            self.assertEqual(a == b, a["mode"] in ("reference_closed", *FLOORS))

    def test_expert_solves_at_least_49_of_50(self) -> None:
        process = self.run_command(DEMONSTRATE, "--episodes", "50", "--out", "demonstrations.bag")
        self.assertEqual(process.returncode, 0, process.stderr)
        with rosbag.Bag(str(self.folder / "demonstrations.bag")) as bag:
            ends = [message for _, message, _ in bag.read_messages(topics=["/demonstration/end"])]
        self.assertEqual([end.seed for end in ends], list(range(50)))
        self.assertGreaterEqual(sum(end.success for end in ends), 49)

    def test_shipped_policy_learned_from_what_demonstrate_gives(self) -> None:
        """All 500: about 10 s where nothing else runs."""
        path = Path(
            PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt.provenance.json"
        )
        recorded = json.loads(path.read_text())["demonstrations"]
        process = self.run_command(DEMONSTRATE, "--out", "demonstrations.bag")
        self.assertEqual(process.returncode, 0, process.stderr)
        bag = self.folder / "demonstrations.bag"
        demonstrations = read_demonstrations([bag])
        self.assertEqual(len(demonstrations), recorded["episodes"])
        origin = read_origin(bag)
        assert origin is not None
        learned_in = recorded["bags"][0]["origin"]
        self.assertEqual(origin["format"], DEMONSTRATION_FORMAT)
        self.assertEqual(origin["demonstrator"], learned_in["demonstrator"])
        (simulator,) = origin["simulators"]
        self.assertEqual(simulator["name"], learned_in["simulator"])
        self.assertEqual((simulator["parameters"], simulator["drawn"]), ({}, {}))
        if simulator["provenance"]["version"] != learned_in["software"]["mujoco"]:
            self.skipTest("another MuJoCo has other trajectories")
        if not {"avx2", "fma"} <= set(origin["software"]["cpu_features"]):
            self.skipTest("without FMA, libm and MuJoCo have other trajectories")
        self.assertEqual(sha256_of_frames(demonstrations), recorded["sha256_of_frames"])

    def test_demonstrations_train_a_policy_end_to_end(self) -> None:
        for process in (
            self.run_command(DEMONSTRATE, "--episodes", "6", "--out", "demonstrations.bag"),
            self.run_command(
                TRAIN, "--bag", "demonstrations.bag", "--out", "policy.pt", "--epochs", "3"
            ),
        ):
            self.assertEqual(process.returncode, 0, process.stderr)
        metrics = self.finished("--policy", "policy.pt", "--episodes", "2")
        self.assertEqual(metrics["policy"], "policy.pt")
        self.assertEqual(
            self.load("out", "provenance.json")["policy"]["runs_on"], "fixed-order kernel"
        )
        recorded = self.run_command(RECORD_EVALUATION, "policy.pt", "out")
        self.assertEqual(recorded.returncode, 0, recorded.stderr)
        evaluation = self.load(".", "policy.pt.provenance.json")["evaluation"]
        self.assertEqual((evaluation["episodes"], evaluation["seed"]), (2, 0))


class ResultsFolder(CompareCase):
    def test_default_is_the_next_free_folder(self) -> None:
        for number in (1, 2):
            process = self.compare(*SHORT)
            self.assertEqual(process.returncode, 0, process.stderr)
            self.assertIn(f"results/compare-{number}", process.stdout)
        self.assertTrue((self.folder / "results" / "compare-2" / "metrics.json").exists())

    def test_results_are_not_overwritten_unless_told_to(self) -> None:
        self.finished(*SHORT)
        before = self.result_bytes("out")
        process = self.compare(*SHORT, "--seed", "1", "--out", "out")
        self.assert_one_line(process, 2)
        self.assertIn("holds results", process.stderr)
        self.assertEqual(self.result_bytes("out"), before)
        self.finished(*SHORT, "--seed", "1", "--overwrite")
        self.assertNotEqual(self.result_bytes("out"), before)

    def test_bag_belongs_to_the_results(self) -> None:
        for name in ("compare.bag", "compare.bag.part"):
            (self.folder / name).mkdir()
            bag = self.folder / name / name
            bag.write_bytes(b"mine")
            process = self.compare(*SHORT, "--out", name)
            self.assert_one_line(process, 2)
            self.assertIn(f"holds results ({name})", process.stderr)
            self.assertEqual(bag.read_bytes(), b"mine")
            process = self.compare(*SHORT, "--out", name, "--overwrite")
            self.assertEqual(process.returncode, 0, process.stderr)
            self.assertEqual(self.files(name), RESULTS)

    def test_what_is_not_ours_stays(self) -> None:
        mine = {
            name: self.write_below("out", name)
            for name in (
                *("rows/notes.txt", "rows/000/notes.txt", "rows/mine/metrics.json"),
                *("reference/x", "reference/0123456789abcdef/x", "metrics.part", "sweep.json.part"),
                *("metrics.json.2.part", "notes.part", "episodes.csv.bak"),
            )
        }
        target = self.folder / "target"
        target.write_bytes(b"mine")
        for name in ("status.json.part", "compare.bag.2.part", "provenance.json.part"):
            (self.folder / "out" / name).symlink_to(target)
        ways: List[List[str]] = [[], ["--overwrite"], ["--overwrite", "--record"]]
        for overwrite in ways:
            process = self.compare(*SHORT, "--out", "out", *overwrite)
            self.assertEqual(process.returncode, 0, process.stderr)
            for name, path in mine.items():
                self.assertEqual(path.read_bytes(), name.encode())
            self.assertEqual(target.read_bytes(), b"mine")
        self.assertTrue((self.folder / "out" / "compare.bag").exists())
        self.assertTrue((self.folder / "out" / "status.json.part").is_symlink())

    def test_folder_under_the_name_of_a_result_is_refused(self) -> None:
        mine = self.write_below("out", "metrics.json/notes.txt")
        process = self.compare(*SHORT, "--out", "out", "--overwrite")
        self.assert_one_line(process, 2)
        self.assertIn("holds a folder where results are written (metrics.json)", process.stderr)
        self.assertTrue(mine.exists())

    def test_link_under_the_name_of_a_result_is_replaced_and_not_followed(self) -> None:
        target = self.folder / "target"
        target.write_bytes(b"mine")
        (self.folder / "out").mkdir()
        (self.folder / "out" / "metrics.json").symlink_to(target)
        self.assert_one_line(self.compare(*SHORT, "--out", "out"), 2)
        self.finished(*SHORT, "--overwrite")
        self.assertEqual(target.read_bytes(), b"mine")
        self.assertFalse((self.folder / "out" / "metrics.json").is_symlink())

    def test_inputs_where_results_are_written_are_refused(self) -> None:
        policy = Path(PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt")
        kept = {}
        for name, content in (
            ("out/rows/policy.pt", policy.read_bytes()),
            ("out/episodes.csv", policy.read_bytes()),
            ("out/reference/scene.xml", SCENE.read_bytes()),
        ):
            kept[name] = self.write_below("out", name[4:], content)
        (self.folder / "link").symlink_to("out", target_is_directory=True)
        (self.folder / "policy.pt").symlink_to("out/rows/policy.pt")
        for arguments, named in (
            (["--policy", "out/rows/policy.pt"], "policy out/rows/policy.pt"),
            (["--policy", "link/rows/policy.pt"], "policy link/rows/policy.pt"),
            (["--policy", "policy.pt"], "policy policy.pt"),
            (["--policy", "out/episodes.csv"], "policy out/episodes.csv"),
            (["--scene", "out/reference/scene.xml"], "scene out/reference/scene.xml"),
            (["--reference-cache", "out/reference"], "reference cache out/reference"),
            (["--reference-cache", "out/rows/cache"], "reference cache out/rows/cache"),
        ):
            for out in ("out", "out/", "link", "./out/../out"):
                process = self.compare("--episodes", "1", "--out", out, "--overwrite", *arguments)
                self.assert_one_line(process, 2)
                self.assertIn(f"{named}: must not be where results are written", process.stderr)
        self.assertEqual(
            {file for file in (self.folder / "out").rglob("*") if file.is_file()},
            set(kept.values()),
        )
        self.assertIn(
            "reference cache fresh/reference: must not be",
            self.refused(2, "--reference-cache", "fresh/reference", out="fresh"),
        )

    def test_inputs_beside_the_results_are_fine(self) -> None:
        policy = Path(PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt")
        kept = self.write_below("out", "policy.pt", policy.read_bytes())
        for _ in range(2):
            arguments = ["--policy", "out/policy.pt", "--reference-cache", "out/cache"]
            process = self.compare("--episodes", "1", *arguments, "--out", "out", "--overwrite")
            self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(kept.read_bytes(), policy.read_bytes())
        self.assertEqual(len(list((self.folder / "out" / "cache").rglob("*.reference"))), 1)

    def test_refused_run_does_not_keep_the_folder(self) -> None:
        """A status of the evaluator's, which leaves one."""
        refused: Dict[str, Any] = {"format": 1, "exit_code": 2, "reason": "episodes 0"}
        status = {**refused, "episodes_finished": 0, "episodes": 0}
        self.write_below("out", "status.json", json.dumps(status).encode())
        self.finished(*SHORT)
        finished = {**status, "exit_code": 0}
        of_another_suite = {**status, "format": 2}  # there the same words may mean anything
        for content in (
            *(b"mine", b"[]", b"{}"),
            *(json.dumps(other).encode() for other in (finished, of_another_suite)),
        ):
            self.write_below("mine", "status.json", content)
            process = self.compare(*SHORT, "--out", "mine")
            self.assert_one_line(process, 2)
            self.assertIn("holds results (status.json)", process.stderr)
            self.assertIn("--overwrite (overwrite:=true in a launch file)", process.stderr)

    def write_below(self, out: str, name: str, content: Optional[bytes] = None) -> Path:
        path = self.folder / out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(name.encode() if content is None else content)
        return path

    def test_runs_at_once_get_folders_of_their_own(self) -> None:
        runs = [
            subprocess.Popen([COMPARE, *SHORT], cwd=self.folder, stdout=subprocess.DEVNULL)
            for _ in range(3)
        ]
        self.assertEqual([run.wait(DEADLINE) for run in runs], [0, 0, 0])
        folders = sorted(folder.name for folder in (self.folder / "results").iterdir())
        self.assertEqual(folders, ["compare-1", "compare-2", "compare-3"])

    def test_folder_in_use_is_refused(self) -> None:
        out = self.folder / "out"
        out.mkdir()
        with out.joinpath("mine").open("w"):
            descriptor = os.open(out, os.O_RDONLY)
            self.addCleanup(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_SH)  # which a second run would get, too
            process = self.compare(*SHORT, "--out", "out")
        self.assert_one_line(process, 2)
        self.assertIn("in use by another run", process.stderr)

    def test_out_that_is_a_file_is_refused(self) -> None:
        self.write("out", b"mine")
        self.assert_one_line(self.compare(*SHORT, "--out", "out"), 2)
        self.assertEqual((self.folder / "out").read_bytes(), b"mine")

    def test_nothing_but_the_table_is_printed_without_a_terminal(self) -> None:
        process = self.compare(*SHORT, "--out", "out")
        self.assertEqual(process.stderr, "")


class GivenStarts(CompareCase):
    """Starts from a file, instead of spawn seeds."""

    RUN = ("--policy", "expert", "--episodes", "4", "--seed", "3")

    def figures(self, out: str) -> List[Dict[str, str]]:
        """The rows of a run, but for the spawn seeds."""
        with (self.folder / out / "episodes.csv").open() as file:
            return [{**row, "seed": ""} for row in csv.DictReader(file)]

    def test_run_from_written_starts_is_the_run(self) -> None:
        spawned = self.finished(*self.RUN, "--write-starts", "starts.csv", out="spawned")
        cached = ("--reference-cache", "kept")
        for name, more in {
            "given": (),
            "threads": ("--threads", "1"),
            "cold": cached,
            "warm": cached,
        }.items():
            given = self.finished(*self.RUN, "--starts", "starts.csv", *more, out=name)
            self.assertEqual(self.figures(name), self.figures("spawned"), name)
            self.assertNotEqual(given["config_hash"], spawned["config_hash"])
            self.assertEqual(self.result_bytes(name), self.result_bytes("given"), name)
        self.assertIn(",,reference_closed,", (self.folder / "given" / "episodes.csv").read_text())

    def test_episodes_are_as_many_as_the_rows_unless_said_otherwise(self) -> None:
        expert = ("--policy", "expert", "--no-floor", "--reference", "two_mass")
        self.finished(*expert, "--episodes", "60", "--write-starts", "60.csv", out="spawned")
        lines = (self.folder / "60.csv").read_text().splitlines(keepends=True)
        (self.folder / "3.csv").write_text("".join(lines[:4]))
        for arguments, episodes in {
            ("--starts", "3.csv"): 3,
            ("--starts", "3.csv", "--episodes", "2"): 2,
            ("--starts", "60.csv"): 50,
        }.items():
            metrics = self.finished(*expert, *arguments, "--overwrite")
            self.assertEqual(metrics["episodes"], episodes, arguments)
        said = self.refused(2, *expert, "--starts", "3.csv", "--episodes", "4", out="more")
        self.assertIn("3.csv", said)

    def test_recompute_takes_the_starts_from_the_bag(self) -> None:
        self.finished(*self.RUN, "--write-starts", "starts.csv", out="spawned")
        self.finished(*self.RUN, "--starts", "starts.csv", "--record")
        (self.folder / "starts.csv").rename(self.folder / "kept.csv")
        again = self.run_command(RECOMPUTE, "out/compare.bag", "--out", "again")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(self.result_bytes("again"), self.result_bytes("out"))
        kept = self.load("again", "provenance.json")["starts"]
        self.assertEqual(kept, (self.folder / "kept.csv").read_text())

    def test_part_of_a_run_takes_its_own_rows(self) -> None:
        part = ("--policy", "expert", "--episodes", "2", "--first-episode", "5")
        self.finished(*part, "--write-starts", "starts.csv", out="spawned")
        self.finished(*part, "--starts", "starts.csv")
        self.assertEqual(self.figures("out"), self.figures("spawned"))

    def test_refusals(self) -> None:
        text = "pusher_x,pusher_y,tee_x,tee_y,tee_yaw\n0.2,0.2,0,0,0\n0.2,0.2,0,0,none\n"
        starts = self.write("starts.csv", text.encode())
        for arguments, words in {
            (
                "--starts",
                starts,
                "--episodes",
                "2",
            ): "line 3: tee_yaw 'none': must be a decimal number",
            ("--starts", "absent.csv"): "starts absent.csv",
            ("--starts", "out/episodes.csv"): "starts out/episodes.csv: ",
            ("--write-starts", "starts.csv"): "write_starts starts.csv: is there already",
            ("--write-starts", "out"): "write_starts out: must not be the folder of the results",
        }.items():
            self.assertIn(words, self.refused(2, "--policy", "expert", *arguments))
        self.assertEqual(Path(starts).read_text(), text)
        one = ("--policy", "expert", "--episodes", "1")
        self.compare(
            *one, "--starts", "starts.csv", "--write-starts", "out/mine.csv", "--out", "out"
        )
        self.assertEqual(len((self.folder / "out" / "mine.csv").read_text().splitlines()), 2)


class Recompute(CompareCase):
    """A run again from its bag."""

    def recompute(self, bag: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
        return self.run_command(RECOMPUTE, bag, *arguments)

    def refused_bag(self, code: int, bag: str) -> str:
        """The one line with which a bag is refused."""
        process = self.recompute(bag, "--out", "again")
        self.assert_one_line(process, code, "recompute")
        self.assertFalse((self.folder / "again").exists(), "a refused bag leaves no folder")
        return process.stderr

    def unfinished(self, bag: str, *, out: str = "again") -> str:
        """The one line that tells what a run lacks; what it has is kept."""
        process = self.recompute(bag, "--out", out)
        self.assert_one_line(process, 4, "recompute")
        self.assertEqual(self.files(out), UNFINISHED - {"episodes.journal"})
        self.assertIn(self.load(out, "status.json")["reason"], process.stderr)
        return process.stderr

    def edited(self, edit: Callable[[str, Any], bool]) -> str:
        """A copy of out/compare.bag: the messages for which `edit` holds, as it leaves them."""
        name = str(self.folder / "edited.bag")
        with rosbag.Bag(str(self.folder / "out" / "compare.bag")) as bag:
            with rosbag.Bag(name, "w") as copy:
                for topic, message, stamp in bag.read_messages():
                    if edit(topic, message):
                        copy.write(topic, message, stamp)
        return name

    def test_gives_the_bytes_of_the_run(self) -> None:
        for number, arguments in enumerate(
            (["--smoke"], ["--policy", "expert", "--episodes", "12", "--first-episode", "3"])
        ):
            out = f"out-{number}"
            self.finished(*arguments, "--record", out=out)
            self.finished(*arguments, out=f"{out}-unrecorded")
            process = self.recompute(f"{out}/compare.bag")
            self.assertEqual(process.returncode, 0, process.stderr)
            again = f"results/recompute-{number + 1}"
            self.assertEqual(self.files(again), RESULTS)
            self.assertEqual(self.result_bytes(again), self.result_bytes(out))
            self.assertEqual(self.result_bytes(again), self.result_bytes(f"{out}-unrecorded"))
            provenance = self.load(again, "provenance.json")
            self.assertEqual(provenance.pop("bag"), f"{out}/compare.bag")
            self.assertEqual(provenance, self.load(out, "provenance.json"))

    def test_bag_that_was_tampered_with_is_refused(self) -> None:
        self.finished(*SHORT, "--record")

        def at(topic: str, message: Any, world: str, step: int) -> bool:
            return topic == f"{world}/state" and (message.episode, message.step) == (0, step)

        def other_state(topic: str, message: Any) -> bool:
            if at(topic, message, "/engine_replay", 17):
                message.state.tee_x += 1e-9
            return True

        def other_action(topic: str, message: Any) -> bool:
            if at(topic, message, "/engine_replay", 17):
                message.action = [0.25, 0.0]
            return True

        def other_start(topic: str, message: Any) -> bool:
            if at(topic, message, "/reference", 0):
                message.state.pusher_y += 0.001
            return True

        def lost_state(topic: str, message: Any) -> bool:
            return not at(topic, message, "/engine", 5)

        for edit, named in (
            (other_state, "episode 0: its result does not follow from the recorded states"),
            (other_action, "engine_replay, step 16: the action that is recorded is (0.25"),
            (
                other_start,
                "reference_closed, step 0: the start that is recorded is not that of the episode",
            ),
            (lost_state, "engine_closed: step 6 is recorded, must be 5"),
        ):
            self.assertIn(named, self.refused_bag(3, self.edited(edit)))

    def test_episodes_that_did_not_finish_are_named(self) -> None:
        self.finished("--policy", "expert", "--episodes", "7", "--record")
        bag = self.edited(
            lambda topic, message: topic != "/sim2sim/episode" or message.episode not in (1, 4, 5)
        )
        self.assertIn("episodes 1, 4 to 5 are missing", self.unfinished(bag))
        rows = {
            out: (self.folder / out / "episodes.csv").read_text().splitlines()
            for out in ("out", "again")
        }
        kept = [row for row in rows["out"] if row.split(",")[0] not in ("1", "4", "5")]
        self.assertEqual(rows["again"], kept)

    def test_run_that_was_interrupted_keeps_its_bag(self) -> None:
        terminal, side = pty.openpty()
        command = [COMPARE, "--policy", "expert", "--episodes", "100000", "--out", "out"]
        with subprocess.Popen(
            [*command, "--record"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=side
        ) as process:
            os.close(side)
            shown = b""
            while b"/100000" not in shown:
                shown += os.read(terminal, 1000)
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(DEADLINE), 4)
        os.close(terminal)
        finished = self.load("out", "status.json")["episodes_finished"]
        self.assertGreater(finished, 0)
        self.assertIn("are missing", self.unfinished("out/compare.bag"))
        self.assertEqual(self.load("again", "status.json")["episodes_finished"], finished)
        rows = [(self.folder / out / "episodes.csv").read_bytes() for out in ("out", "again")]
        self.assertEqual(rows[0], rows[1])

    def test_recorder_that_was_killed(self) -> None:
        part = self.folder / "out" / "compare.bag.part"
        command = [COMPARE, "--policy", "expert", "--episodes", "100000", "--out", "out"]
        terminal, side = pty.openpty()
        with subprocess.Popen(
            [*command, "--record"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=side
        ) as process:
            os.close(side)
            shown = b""
            while b" 20/100000" not in shown:  # more than one chunk of the bag
                shown += os.read(terminal, 1000)
            process.kill()
        os.close(terminal)
        self.assertEqual(self.files("out"), {"provenance.json", "status.json", part.name})
        status = self.load("out", "status.json")
        self.assertEqual((status["exit_code"], status["reason"]), (4, "under way, or killed"))
        self.assertEqual((status["episodes_finished"], status["episodes"]), (0, 100000))
        self.assertIn(f"`rosbag reindex {part}`", self.refused_bag(2, str(part)))
        reindex = self.run_command("rosbag", "reindex", str(part))
        self.assertEqual(reindex.returncode, 0, reindex.stderr)
        self.assertRegex(self.unfinished(str(part)), r"episodes .*to 99999 are missing")
        self.assertGreater(self.load("again", "status.json")["episodes_finished"], 0)

    def test_what_is_no_bag_of_a_run_is_refused(self) -> None:
        self.finished(*SHORT, "--record")
        whole = (self.folder / "out" / "compare.bag").read_bytes()
        self.write("half.bag", whole[: len(whole) // 2])
        self.write("text.bag", b"no bag")
        self.write("empty.bag", b"")
        os.mkfifo(self.folder / "pipe.bag")
        for name, named in (
            ("half.bag", "`rosbag reindex half.bag` recovers what is left"),
            ("text.bag", "must be a whole bag"),
            ("empty.bag", "must be a whole bag"),
            ("pipe.bag", "must be a readable file"),
            ("none.bag", "must be a readable file"),
            ("out", "must be a readable file"),
        ):
            self.assertIn(f"bag {name}: ", self.refused_bag(2, name))
            self.assertIn(named, self.refused_bag(2, name))

        self.assertIn(
            "holds 0 messages on /sim2sim/configuration",
            self.refused_bag(2, self.edited(lambda topic, _: topic != "/sim2sim/configuration")),
        )

        def other_configuration(topic: str, message: Any) -> bool:
            if topic == "/sim2sim/configuration":
                message.data = message.data.replace("4.0", "5.0")
            return True

        self.assertIn("config_hash", self.refused_bag(2, self.edited(other_configuration)))

        for text in ("", "no JSON", "[]", '{"a":' * 100_000):

            def damaged(topic: str, message: Any, text: str = text) -> bool:
                if topic == "/sim2sim/configuration":
                    message.data = text
                return True

            said = self.refused_bag(2, self.edited(damaged))
            self.assertIn("on /sim2sim/configuration must hold a JSON object", said)

        def older_format(topic: str, message: Any) -> bool:
            if topic == "/sim2sim/configuration":
                ours, other = (
                    f'"format":{number}' for number in (METRICS_FORMAT, METRICS_FORMAT - 1)
                )
                self.assertEqual(message.data.count(ours), 1)
                message.data = message.data.replace(ours, other)
            return True

        bag = self.edited(older_format)
        rule = f"format {METRICS_FORMAT - 1}: must be {METRICS_FORMAT}"
        self.assertIn(f"bag {bag}: {rule}", self.refused_bag(2, bag))

    def test_bag_is_not_replaced_by_what_comes_of_it(self) -> None:
        self.finished(*SHORT, "--record")
        before = (self.folder / "out" / "compare.bag").read_bytes()
        (self.folder / "link.bag").symlink_to("out/compare.bag")
        for bag in ("out/compare.bag", "link.bag"):
            process = self.recompute(bag, "--out", "out", "--overwrite")
            self.assert_one_line(process, 2, "recompute")
            self.assertIn(f"bag {bag}: must not be where results are written", process.stderr)
            self.assertEqual((self.folder / "out" / "compare.bag").read_bytes(), before)
            self.assertEqual(self.files("out"), RESULTS | {"compare.bag"})

    def test_interrupt_while_the_bag_is_read(self) -> None:
        bag = str(self.folder / "big.bag")
        self.finished("--policy", "expert", "--episodes", "300", "--record")
        os.rename(self.folder / "out" / "compare.bag", bag)
        for number in (signal.SIGINT, signal.SIGTERM):
            out = self.folder / number.name
            with subprocess.Popen(
                [RECOMPUTE, bag, "--out", str(out)],
                cwd=self.folder,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            ) as process:
                until(lambda: opened(process.pid, bag))
                process.send_signal(number)
                _, said = process.communicate(timeout=DEADLINE)
            self.assertEqual(process.returncode, 4, said)
            self.assertEqual(said, f"recompute: bag {bag}: interrupted while it was read\n")
            self.assertEqual(self.files(number.name), {"status.json"})
            status = self.load(number.name, "status.json")
            self.assertEqual(status["exit_code"], 4)
            self.assertIn(status["reason"], said)


class Faults(CompareCase):
    """The numbers are those of the project's list of faults."""

    def test_f1_scene_that_does_not_load(self) -> None:
        scene = SCENE.read_bytes()
        cases = {"empty.xml": b"", "half.xml": scene[: len(scene) // 2], "text.xml": b"no xml"}
        for name, content in cases.items():
            self.assertIn(name, self.refused(2, "--smoke", "--scene", self.write(name, content)))
        self.assertIn("none.xml", self.refused(2, "--smoke", "--scene", "none.xml"))
        os.mkfifo(self.folder / "pipe.xml")
        self.assertIn("pipe.xml", self.refused(2, "--smoke", "--scene", "pipe.xml"))
        self.assertFalse((self.folder / "MUJOCO_LOG.TXT").exists())

    def test_f2_scene_that_is_another_task(self) -> None:
        for old, new, named in (
            (b'timestep="0.01"', b'timestep="0.02"', "option timestep is 0.02: must be 0.01"),
            (
                b'frictionloss="1.2"',
                b'frictionloss="0"',
                "joint tee_x dof_frictionloss is 0.0: must be 1.2",
            ),
            (b'kv="20"', b'kv="2"', "actuator pusher_x actuator_gainprm[0] is 2.0: must be 20.0"),
        ):
            scene = self.write("scene.xml", SCENE.read_bytes().replace(old, new))
            self.assertIn(named, self.refused(2, "--smoke", "--scene", scene))

    def test_f3_error_raised_by_mujoco(self) -> None:
        line = self.failed(
            70, "--policy", "expert", "--episodes", "2", environment={"LD_PRELOAD": PRELOAD}
        )
        self.assertIn("raised on purpose", line)
        self.assertFalse(
            (self.folder / "out" / "episodes.csv").exists(), "no results after a defect"
        )

    def test_f4_missing_policy(self) -> None:
        for more in ((), ("--require-policy",)):
            line = self.refused(2, "--policy", "none.pt", *more)
            self.assertIn("policy none.pt: must be a readable file, but is not there", line)
        process = self.compare(
            *("--policy", "none.pt", "--allow-untrained", "--episodes", "1", "--out", "out")
        )
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("WARNING: policy none.pt", process.stderr)
        self.assertEqual(self.load("out", "metrics.json")["policy"], "fresh-untrained")

    def test_f4_holds_only_for_a_file_that_is_not_there(self) -> None:
        for name in ("", "x" * 300):
            self.assertIn("must be a readable file", self.refused(2, "--policy", name))
        for option in ("--require-policy", "--allow-untrained"):
            self.assertIn(option, self.refused(2, "--smoke", option))

    def test_f5_file_that_is_no_torchscript(self) -> None:
        whole = Path(PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt").read_bytes()
        torch.save({"weight": torch.zeros(3)}, str(self.folder / "state_dict.pt"))
        cases = {
            "empty.pt": b"",
            "half.pt": whole[: len(whole) // 2],
            "random.pt": bytes(range(256)) * 20,
            "pickle.pt": pickle.dumps({"a": 1}),
            "state_dict.pt": (self.folder / "state_dict.pt").read_bytes(),
        }
        for name, content in cases.items():
            self.assertIn(name, self.refused(2, "--policy", self.write(name, content)))
        self.assertIn(str(self.folder), self.refused(2, "--policy", str(self.folder)))

    def test_f6_checkpoint_that_is_not_the_one_in_its_provenance(self) -> None:
        policy = self.save("policy.pt", Straight())
        Path(policy + ".provenance.json").write_text(
            json.dumps({"checkpoint": {"sha256": "0" * 64}})
        )
        self.assertIn("SHA-256", self.refused(3, "--policy", policy))

    def test_f33_library_of_the_networks_that_is_not_there(self) -> None:
        library = Path(executable("sim2sim_eval", "compare")).parents[1] / "libpusht_policy.so"
        shutil.copy(library, self.folder)
        alone = {"LD_LIBRARY_PATH": f"{self.folder}:{os.environ['LD_LIBRARY_PATH']}"}
        line = self.refused(3, "--episodes", "1", environment=alone)
        self.assertIn(f"library {self.folder}/libpusht_network_policy.so: cannot be loaded", line)
        self.finished("--policy", "expert", "--episodes", "1", environment=alone)

    def test_expert_needs_no_libtorch(self) -> None:
        watched = {"LD_DEBUG": "files"}
        for policy, needs in (("expert", False), ("bc", True)):
            process = self.compare(
                *("--policy", policy, "--episodes", "1", "--out", policy), environment=watched
            )
            self.assertEqual(process.returncode, 0)
            self.assertIn("libpusht_policy.so", process.stderr)
            self.assertEqual("libtorch" in process.stderr, needs, policy)

    def test_f7_policy_that_does_not_fit(self) -> None:
        nan_weights = Straight()
        nan_weights.scale.fill_(float("nan"))
        cases = {
            "columns.pt": Columns(),
            "inputs.pt": Inputs(),
            "weights.pt": nan_weights,
            "random.pt": Random(),
        }
        for name, module in cases.items():
            self.assertIn(name, self.refused(3, "--policy", self.save(name, module)))

    def test_f7_action_that_is_not_finite_fails_the_episode(self) -> None:
        line = self.failed(3, "--policy", self.save("trap.pt", Trap()), "--episodes", "4")
        self.assertRegex(
            line, r"episode \d+ \(spawn seed 1000\d\), \w+, step \d+: the policy's action \(nan"
        )

    def test_f7_late_action_of_a_chunk_that_is_not_finite_fails_the_episode(self) -> None:
        policy = self.save("late.pt", LateTrap(), {"format": 1, "observations": 2, "actions": 8})
        line = self.failed(3, "--policy", policy, "--episodes", "4")
        self.assertRegex(line, r"episode \d+ .*, step 14: the policy's action \(nan")

    def test_f7_more_actions_are_executed_than_an_answer_has(self) -> None:
        self.assertIn("execute 2: must be from 1 to 1", self.refused(2, "--execute", "2"))

    def test_f28_damaged_checkpoint_without_provenance(self) -> None:
        shipped = Path(PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt")
        damaged = bytearray(shipped.read_bytes())
        damaged[len(damaged) // 2] ^= 1
        with zipfile.ZipFile(shipped) as archive:
            records = {name: archive.read(name) for name in archive.namelist()}
        first = "archive/data/0"
        cases: Dict[str, Union[bytes, Dict[str, bytes]]] = {
            "archive/data/6: must have the size and the CRC-32": bytes(damaged),
            "must be TorchScript, a sound zip archive": shipped.read_bytes()[:-100],
            f"{first}: must have the 40 bytes of its tensor, but has 0": {**records, first: b""},
            f"{first}: must have the 40 bytes of its tensor, but has 24": {
                **records,
                first: records[first][:24],
            },
        }
        for message, content in cases.items():
            if isinstance(content, dict):
                buffer = io.BytesIO()
                with zipfile.ZipFile(buffer, "w") as archive:
                    for name, record in content.items():
                        archive.writestr(name, record)
                content = buffer.getvalue()
            self.assertIn(message, self.refused(2, "--policy", self.write("policy.pt", content)))

    def test_f19_bad_arguments(self) -> None:
        for arguments, named in (
            (["--episodes", "0"], "episodes 0: must be from 1"),
            (["--episodes", "1000000000"], "episodes 1000000000: must be from 1 to"),
            (["--episodes", "ten"], "--episodes"),
            (["--episodes", "010"], "'010': must be a decimal integer"),
            (["--first-episode", "2000000000"], "first_episode 2000000000: must be from 0 to"),
            (["--seed", ""], "'': must be a decimal integer"),
            (["--seed", "0x10"], "'0x10': must be a decimal integer"),
            (["--pusher_mass", "1e-320"], "pusher_mass 1e-320"),
            (["--pusher_mass", "0"], "pusher_mass 0"),
            (["--pusher_mass", "-1"], "pusher_mass -1"),
            (["--block_damp", "nan"], "'nan': must be a decimal number"),
            (["--baumgarte", "inf"], "'inf': must be a decimal number"),
            (["--block_damp", "much"], "--block_damp"),
            (["--block_damp", "010"], "--block_damp"),
            (["--seed", "010"], "--seed"),
            (["--smoke", "--episodes", "7"], "episodes 7, horizon 300: must be left out"),
            (["--block_dump", "6"], "--block_dump"),
            (["stray"], "stray"),
        ):
            self.assertIn(named, self.refused(2, *arguments))

    def test_f20_seeds(self) -> None:
        for seed in (0, 2**32 - 1, 2**63):
            metrics = self.finished(*SHORT, "--seed", str(seed), out=f"seed-{seed}")
            self.assertEqual(metrics["seed"], seed)
        for seed in (-1, 2**64 - 1, 2**64):
            self.assertIn("seed", self.refused(2, *SHORT, "--seed", str(seed)))

    def test_f21_engine_that_flies_apart(self) -> None:
        charge = ["--policy", self.charging_policy(), "--first-episode", "3", "--episodes", "1"]
        line = self.failed(4, *charge, "--baumgarte", "10")
        self.assertRegex(
            line,
            r"episode 3 .*engine_closed, step \d+: step: \w+ \S+ m: must be within 1000.0 m\n$",
        )

    def test_f31_parameters_outside_the_stable_range(self) -> None:
        for arguments, rule in (
            (["--block_damp", "110"], "block_damp 110.0: must be from 0.0 to 100.0 [1/s]: "),
            (["--baumgarte", "5"], "baumgarte 5.0: must be from 10.0 to 82.8 [rad/s]: "),
            (["--baumgarte", "60", "--block_damp", "100"], "60.0: must be below 44.95 [rad/s]"),
            (["--pusher_mass", "1e7"], "pusher_mass 10000000.0: must be from 1e-06 to "),
        ):
            self.assertIn(rule, self.refused(2, *arguments))

    def test_f22_disk_full(self) -> None:
        """A file that cannot grow beyond 4 kB stands for a full disk."""
        limited = f"ulimit -f 4; exec {COMPARE} --policy expert --episodes 50 --out out"
        process = self.run_command("bash", "-c", limited)
        self.assert_one_line(process, 4)
        self.assertIn("cannot write out/episodes.journal: File too large", process.stderr)
        self.assertEqual(self.files("out"), UNFINISHED)
        self.assertEqual(self.load("out", "status.json")["exit_code"], 4)

    def test_f22_bag_that_cannot_be_written(self) -> None:
        limited = f"ulimit -f 20; exec {DEMONSTRATE} --episodes 50 --out demonstrations.bag"
        process = self.run_command("bash", "-c", limited)
        self.assertEqual(process.returncode, 4, process.stderr)
        self.assertIn("cannot write demonstrations.bag", process.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_bag_is_not_overwritten(self) -> None:
        bag = self.write("demonstrations.bag", b"mine")
        process = self.run_command(DEMONSTRATE, "--episodes", "1", "--out", bag)
        self.assertEqual(process.returncode, 2, process.stderr)
        self.assertEqual(Path(bag).read_bytes(), b"mine")

    def test_f22_reader_that_has_gone(self) -> None:
        reader, writer = os.pipe()
        os.close(reader)
        command = [COMPARE, *SHORT, "--out", "out"]
        process = subprocess.run(
            command,
            cwd=self.folder,
            stdout=writer,
            stderr=subprocess.PIPE,
            text=True,
            timeout=DEADLINE,
        )
        os.close(writer)
        self.assert_one_line(process, 4)
        self.assertIn("cannot write to stdout", process.stderr)
        self.assertEqual(self.files("out"), RESULTS)

    def test_options_of_an_engine_that_there_is_not(self) -> None:
        without = "must be left out without an engine"
        for option, value, said in (
            ("--block_damp", "20", "setting 'block_damp=20' of the engine: must be left out"),
            ("--loop-engine", "action_delay=1", "setting 'loop.action_delay=1' of the engine"),
            ("--reanchor", "5", f"probe engine_reanchored_5: {without}"),
            ("--model-variants", "timestep=0.005", f"probe variant_timestep=0.005: {without}"),
            ("--until-decided", "0.8", f"until_decided 0.8: {without}"),
            ("--record", "", "record: must be left out with engine none"),
            ("--require", "transfer > 0.8", 'must be as "reference > 0.6", as there is no engine'),
        ):
            given = [text for text in (option, value) if text]
            process = self.compare("--engine", "none", *given, "--out", "out")
            self.assert_one_line(process, 2)
            self.assertIn(said, process.stderr)
            self.assertFalse((self.folder / "out" / "episodes.csv").exists())

    def test_f22_folder_that_cannot_be_made(self) -> None:
        self.assert_one_line(self.compare(*SHORT, "--out", "/proc/none/out"), 4)

    def test_f22_interrupted(self) -> None:
        """Once, or twice at once, as `timeout` does: it signals the command and its group."""
        for number, times in ((signal.SIGINT, 1), (signal.SIGTERM, 2), (signal.SIGUSR1, 1)):
            out = f"out-{number.name}"
            terminal, side = pty.openpty()
            command = [COMPARE, "--policy", "expert", "--episodes", "100000", "--out", out]
            with subprocess.Popen(
                command, cwd=self.folder, stdout=subprocess.PIPE, stderr=side, text=True
            ) as process:
                os.close(side)
                shown = b""
                while b"/100000" not in shown:  # the progress bar shows finished episodes
                    shown += os.read(terminal, 1000)
                for _ in range(times):
                    process.send_signal(number)
                    until(lambda: caught(process.pid, number))
                printed, _ = process.communicate(timeout=DEADLINE)
            while b"interrupted" not in shown:
                shown += os.read(terminal, 1000)
            os.close(terminal)
            self.assertEqual(process.returncode, 4)
            status = self.load(out, "status.json")
            self.assertIn("interrupted after", status["reason"])
            self.assertIn("NOT A WHOLE RUN", printed)
            self.assertEqual(self.files(out), UNFINISHED)
            rows = (self.folder / out / "episodes.csv").read_text().splitlines()
            self.assertEqual(len(rows), 1 + len(ROLLOUTS) * status["episodes_finished"])
            self.assertGreater(status["episodes_finished"], 0)

    def test_f29_policy_that_never_returns(self) -> None:
        """A signal is enough, if not at once; a second one ends the command at once."""
        policy = self.save("in_episode.pt", Endless(0.34, 0.37))
        for more in (False, True):
            out = f"out-{more}"
            terminal, side = pty.openpty()  # or what it prints would be kept
            with self.endless(policy, out, stdout=side) as process:
                os.close(side)
                shown = b""
                while b"never returns" not in shown:
                    shown += os.read(terminal, 1000)
                process.send_signal(signal.SIGTERM)
                begin = time.monotonic()
                while more and process.poll() is None:
                    process.send_signal(signal.SIGTERM)
                _, said = process.communicate(timeout=DEADLINE)
                self.assertEqual(more, time.monotonic() - begin < PATIENCE)
            os.close(terminal)
            self.assertEqual(process.returncode, 4, said)
            self.assertRegex(said, r"^compare: interrupted, and ended before .*\n$")
            self.assertEqual(self.load(out, "status.json")["exit_code"], 4)
            self.assertEqual(self.files(out), UNFINISHED - {"episodes.csv"})

    def test_f29_policy_that_never_returns_from_its_first_action(self) -> None:
        """It is tried out in a copy of the process, which a signal ends."""
        policy = self.save("at_load.pt", Endless(-10.0, 10.0))
        with self.endless(policy, "out", stdout=subprocess.DEVNULL) as process:
            children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
            until(lambda: children.read_text() != "")
            process.send_signal(signal.SIGTERM)
            _, said = process.communicate(timeout=DEADLINE)
        self.assertEqual(process.returncode, 4, said)
        self.assertRegex(
            said, r"^compare: policy \S+at_load.pt: interrupted while it was tried out\n$"
        )
        self.assertEqual(self.files("out"), {"status.json"})
        status = self.load("out", "status.json")
        self.assertEqual((status["exit_code"], status["episodes_finished"]), (4, 0))

    def endless(self, policy: str, out: str, stdout: int) -> "subprocess.Popen[str]":
        return subprocess.Popen(
            [COMPARE, "--policy", policy, "--episodes", "50", "--threads", "1", "--out", out],
            cwd=self.folder,
            stdout=stdout,
            stderr=subprocess.PIPE,
            text=True,
        )

    def test_f24_same_bytes_for_any_blas_and_thread_count(self) -> None:
        folders = [p.parent for p in Path("/usr/lib").glob("*/*/libblas.so.3")]
        environments = [
            {"LD_LIBRARY_PATH": f"{folder}:{os.environ['LD_LIBRARY_PATH']}"} for folder in folders
        ]
        environments += [{"OMP_NUM_THREADS": "1"}, {"OMP_NUM_THREADS": "2"}]
        self.assertGreaterEqual(len(folders), 2, "two BLAS must be installed to tell")
        used = set()
        for number, environment in enumerate(environments):
            run = ("--episodes", "5", "--block_damp", "6.5")
            self.finished(*run, out=str(number), environment=environment)
            self.assertEqual(self.result_bytes(str(number)), self.result_bytes("0"), environment)
            used.add(self.load(str(number), "provenance.json")["policy"]["blas"])
        self.assertEqual(len(used), len(folders), used)

    def test_trained_policy_that_never_succeeds_is_pointed_out(self) -> None:
        process = self.compare(
            "--policy", self.save("lazy.pt", Straight()), "--episodes", "1", "--out", "out"
        )
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("never succeeds in the reference", process.stderr)
        # Two starts at which the expert needs over forty steps, and no checkpoint to be stale.
        self.write(
            "plan.yaml", b"{policy: expert, episodes: 2, horizon: 40, rows: [{block_damp: 6}]}"
        )
        process = self.run_command(SWEEP, "plan.yaml", "--out", "sweep")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        self.assertEqual(self.load("sweep", "sweep.json")["rows"][0]["mj_successes"], 0)

    def save(
        self, name: str, module: torch.nn.Module, description: Optional[Dict[str, Any]] = None
    ) -> str:
        path = str(self.folder / name)
        files = {"policy.json": json.dumps(description)} if description else {}
        torch.jit.save(torch.jit.script(module.eval()), path, _extra_files=files)
        return path


def opened(pid: int, path: str) -> bool:
    """Whether a process has opened a file."""
    folder = f"/proc/{pid}/fd"
    try:
        return path in {os.readlink(f"{folder}/{name}") for name in os.listdir(folder)}
    except FileNotFoundError:  # closed meanwhile
        return False


def caught(pid: int, number: signal.Signals) -> bool:
    """Whether a signal that was sent to a process is no longer pending: two at once are one."""
    try:
        return not signals(pid, "ShdPnd") & 1 << (number - 1)
    except FileNotFoundError:
        return True


class Straight(torch.nn.Module):
    """Always to the right, slowly."""

    scale: torch.Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("scale", torch.tensor([0.1, 0.0]))

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        return obs[:, :2] * 0 + self.scale


class Columns(torch.nn.Module):
    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        return obs[:, :3]


class Inputs(torch.nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.net = torch.nn.Linear(8, 2)

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        result: torch.Tensor = self.net(obs)
        return result


class Random(torch.nn.Module):
    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        return torch.rand(obs.size(0), 2)


class Trap(torch.nn.Module):
    """To the right, and not a number shortly before the wall: no probe at load finds that."""

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        x = obs[:, :1]
        action = torch.where((x > 0.34) & (x < 0.37), x * float("nan"), torch.ones_like(x))
        return torch.cat([action, torch.zeros_like(x)], dim=1)


class LateTrap(torch.nn.Module):
    """Upward, and not a number at the seventh action, once it moves and the tee does not."""

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        moved = obs[:, 0] != obs[:, 1]
        trap = moved[:, :2].any(1) & ~moved[:, 2:].any(1)
        action = torch.tensor([0.0, 0.05]).expand(1, 8, 2).clone()
        action[:, 6] = torch.where(
            trap.unsqueeze(1), torch.full([1, 2], float("nan")), action[:, 6]
        )
        return action


if __name__ == "__main__":
    unittest.main()
