#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Sweeps, their shards and the reference they share, as a user meets them."""

import csv
import fcntl
import json
import os
import shutil
import signal
import subprocess
import unittest
from pathlib import Path
from typing import Dict, List

import rospkg  # type: ignore[import]
import torch
from pusht_task.command import SIGNALS
from pusht_testing.long_tests import LONG
from pusht_testing.warm_commands import warm
from sim2sim_eval.command import rosrun
from sim2sim_report.convergence import FIRST_2_S, WHOLE, read_convergence
from sim2sim_report.curves import read_curves
from sim2sim_report.results import METRICS_FORMAT
from sim2sim_report.suite import Suite

from command_case import CommandCase, catches, executable, until
from test_figures import check_words

SWEEP = executable("sim2sim_eval", "sweep")
MERGE = executable("sim2sim_eval", "merge")
COMPARE = executable("sim2sim_eval", "compare")
PLOT = executable("sim2sim_eval", "plot_sweep")
warm([PLOT], "sim2sim_report.make", "sim2sim_eval.command")
INTERRUPTED = "plot_sweep: interrupted; nothing is written\n"

# Short, and yet with successes in both worlds: the expert needs about half the horizon.
PLAN = """
policy: expert
episodes: 7
horizon: 150
reanchor: [5]
grid:
  block_damp: [6, 20]
  pusher_mass: [4, 1.5]
"""


WITH_AND_WITHOUT: List[List[str]] = [[], ["--overwrite"]]


class SweepCase(CommandCase):
    def sweep(self, *arguments: str, plan: str = PLAN) -> "subprocess.CompletedProcess[str]":
        return self.run_command(SWEEP, self.plan(plan), *arguments)

    def plan(self, text: str) -> str:
        return self.write("plan.yaml", text.encode())

    def finished(self, out: str, *arguments: str, plan: str = PLAN) -> Dict[str, bytes]:
        """What a sweep that must succeed has written, its provenance aside."""
        process = self.sweep(*arguments, "--out", out, plan=plan)
        self.assertEqual(process.returncode, 0, process.stderr)
        return self.results(out)

    def results(self, out: str) -> Dict[str, bytes]:
        files = [file for file in (self.folder / out).rglob("*") if file.is_file()]
        return {
            str(file.relative_to(self.folder / out)): file.read_bytes()
            for file in files
            if file.name != "provenance.json"
        }

    def refused(self, code: int, process: "subprocess.CompletedProcess[str]", name: str) -> str:
        self.assert_one_line(process, code, name)
        return process.stderr

    def shards(self, count: int, plan: str = PLAN) -> List[str]:
        folders = [f"shard-{number}-of-{count}" for number in range(1, count + 1)]
        for number, folder in enumerate(folders, 1):
            self.finished(folder, "--shard", f"{number}/{count}", plan=plan)
        return folders

    def merge(self, *folders: str, out: str = "merged") -> "subprocess.CompletedProcess[str]":
        return self.run_command(MERGE, *folders, "--out", out)


class Rows(SweepCase):
    def test_rows_are_the_runs_of_compare(self) -> None:
        plan = "{policy: expert, seed: 3, episodes: 4, rows: [{block_damp: 20}, {pusher_mass: 2}]}"
        results = self.finished("out", plan=plan)
        rows = {"rows/000": ["--block_damp", "20"], "rows/001": ["--pusher_mass", "2"]}
        for row, parameters in rows.items():
            command = [COMPARE, "--policy", "expert", "--seed", "3", "--episodes", "4", *parameters]
            self.run_command(*command, "--out", row)
            self.assertEqual(self.result_bytes(row), self.result_bytes("out/" + row))
        self.assertEqual(set(self.load("out", "sweep.json")), {"sweep", "rows"})
        table = results["sweep.csv"].decode().splitlines()
        self.assertEqual(len(table), 3)
        self.assertEqual(
            self.finished("same", "--episodes", "4", plan=plan.replace("4", "9")), results
        )
        (first, _) = csv.DictReader(table)
        found = [
            first[name] for name in ("row", "baumgarte", "block_damp", "pusher_mass", "episodes")
        ]
        self.assertEqual(found, ["0", "40.0", "20.0", "4.0", "4"])

    def test_given_starts_are_those_of_compare_in_shards_too(self) -> None:
        run = [COMPARE, "--policy", "expert", "--episodes", "4", "--seed", "3"]
        self.run_command(*run, "--write-starts", "starts.csv", "--out", "spawned")
        self.run_command(*run, "--starts", "starts.csv", "--out", "row")
        plan = "{policy: expert, seed: 3, episodes: 4, starts: starts.csv, rows: [{}]}"
        whole = self.finished("out", plan=plan)
        self.assertEqual(self.result_bytes("row"), self.result_bytes("out/rows/000"))
        process = self.merge(*self.shards(2, plan))
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(self.results("merged"), whole)

    def test_every_figure_has_its_columns(self) -> None:
        rows = "[{block_damp: 20}, {pusher_mass: 2}]"
        variants = "model_variants: [cone=elliptic], closed_variants: [timestep=0.005]"
        plan = f"{{policy: expert, episodes: 20, reanchor: [5], {variants}, rows: {rows}}}"
        table = self.finished("out", plan=plan)["sweep.csv"].decode().splitlines()
        for name in (
            "mean_pos_divergence_over_variants",
            "closed_variant_timestep=0.005_success_difference",
        ):
            self.assertIn(f",{name},{name}_low,{name}_high,", table[0])
        for cells, row in zip(csv.DictReader(table), ["rows/000", "rows/001"], strict=True):
            metrics = self.load("out/" + row, "metrics.json")
            for key in [
                key for key in metrics if "_interval" in key and "reference_succ" not in key
            ]:
                figure = key.replace("success_interval", "success_rate").replace("_interval", "")
                wanted = [metrics[figure], *(metrics[key] or [None, None])]
                found = [cells[figure + end] for end in ("", "_low", "_high")]
                self.assertEqual([float(cell) if cell else None for cell in found], wanted, key)

    def test_grid_has_every_combination_the_last_parameter_fastest(self) -> None:
        self.finished("out")
        rows = [row["knobs"] for row in self.load("out", "sweep.json")["rows"]]
        self.assertEqual(
            [(row["block_damp"], row["pusher_mass"]) for row in rows],
            [(6.0, 4.0), (6.0, 1.5), (20.0, 4.0), (20.0, 1.5)],
        )
        successes = [row["mj_successes"] for row in self.load("out", "sweep.json")["rows"]]
        self.assertEqual(len(set(successes)), 1, "the reference knows no parameters of the engine")
        self.assertGreater(successes[0], 0)

    def test_bytes_do_not_depend_on_threads_cache_or_shards(self) -> None:
        expected = self.finished("one", "--threads", "1")
        for threads in ("2", "4"):
            self.assertEqual(self.finished(f"threads-{threads}", "--threads", threads), expected)
        for temperature in ("cold", "warm"):
            self.assertEqual(self.finished(temperature, "--reference-cache", "cache"), expected)
        for count in (1, 3):
            process = self.merge(*self.shards(count), out=f"merged-{count}")
            self.assertEqual(process.returncode, 0, process.stderr)
            self.assertEqual(self.results(f"merged-{count}"), expected)

    def test_compare_and_sweeps_share_their_reference(self) -> None:
        plan = "{policy: expert, episodes: 3, rows: [{block_damp: 6}]}"
        self.finished("out", "--reference-cache", "cache", plan=plan)
        kept = {
            file: file.stat().st_mtime_ns for file in (self.folder / "cache").rglob("*.reference")
        }
        self.assertEqual(len(kept), 3)
        command = [COMPARE, "--policy", "expert", "--episodes", "3"]
        self.run_command(*command, "--out", "without")
        self.run_command(*command, "--out", "with", "--reference-cache", "cache")
        self.assertEqual(self.result_bytes("with"), self.result_bytes("without"))
        self.assertEqual(self.result_bytes("with"), self.result_bytes("out/rows/000"))
        other = [*command, "--engine", "chipmunk", "--reference-cache", "cache"]
        self.run_command(*other, "--out", "other")
        again = {
            file: file.stat().st_mtime_ns for file in (self.folder / "cache").rglob("*.reference")
        }
        self.assertEqual(again, kept, "rolled out once, for whatever engine")
        next(iter(kept)).write_bytes(b"damaged")
        process = self.run_command(*command, "--out", "damaged", "--reference-cache", "cache")
        self.assert_one_line(process, 3, "compare")
        self.assertIn(next(iter(kept)).name, process.stderr)
        self.assertFalse((self.folder / "damaged" / "metrics.json").exists())

    def test_plot_says_that_rows_are_missing(self) -> None:
        self.finished("out")
        sweep = self.folder / "out" / "sweep.json"
        content = json.loads(sweep.read_text())
        del content["rows"][1]
        sweep.write_text(json.dumps(content))
        process = self.run_command(PLOT, "out", "--out", "plot.svg")
        self.assertEqual(process.returncode, 0)
        self.assertEqual(
            process.stderr, "plot_sweep: NOT A WHOLE SWEEP: 3 of 4 rows have finished\n"
        )
        drawn = (self.folder / "plot.svg").read_text()
        self.assertIn("<!-- NOT A WHOLE SWEEP: 3 of 4 rows have finished -->", drawn)

    def test_plot_shows_a_sweep(self) -> None:
        self.finished("out")
        process = self.run_command(PLOT, "out")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertTrue((self.folder / "out" / "sweep.png").read_bytes().startswith(b"\x89PNG"))
        self.finished("flat", plan="{policy: expert, episodes: 2, horizon: 5, rows: [{}]}")
        self.assertIn("no parameter", self.refused(2, self.run_command(PLOT, "flat"), "plot_sweep"))
        self.refused(2, self.run_command(PLOT, "none"), "plot_sweep")

    def test_plot_leaves_what_is_there(self) -> None:
        self.finished("out", plan="{policy: expert, episodes: 2, rows: [{}, {block_damp: 20}]}")
        self.assertEqual(self.run_command(PLOT, "out", "--out", "plot.png").returncode, 0)
        theirs = self.write("theirs.png", b"theirs")
        cases = (("plot.png", ()), ("theirs.png", ()), ("theirs.png", ("--overwrite",)))
        for out, options in cases:
            process = self.run_command(PLOT, "out", "--out", out, *options)
            said = self.refused(2, process, "plot_sweep")
            self.assertIn(f"out {out}: is there already", said)
        self.assertEqual(Path(theirs).read_bytes(), b"theirs")
        process = self.run_command(PLOT, "out", "--out", "plot.png", "--overwrite")
        self.assertEqual(process.returncode, 0, process.stderr)

    def test_plot_that_is_interrupted(self) -> None:
        self.finished("out", plan="{policy: expert, episodes: 2, rows: [{}, {block_damp: 20}]}")
        for number in SIGNALS:
            with subprocess.Popen(
                (PLOT, "out"), cwd=self.folder, stderr=subprocess.PIPE, text=True
            ) as process:
                until(lambda: catches(process.pid, SIGNALS[-1]))
                process.send_signal(number)
                _, said = process.communicate(timeout=self.deadline)
            self.assertEqual((process.returncode, said), (4, INTERRUPTED), number)
            self.assertFalse((self.folder / "out" / "sweep.png").exists())

    def test_plot_of_nested_and_unfinished_sweeps(self) -> None:
        self.finished("out", plan="{policy: expert, episodes: 2, rows: [{}, {block_damp: 20}]}")
        path = self.folder / "out" / "sweep.json"
        content = json.loads(path.read_text())
        del content["rows"][1]
        path.write_text(json.dumps(content))
        said = self.refused(2, self.run_command(PLOT, "out"), "plot_sweep")
        self.assertIn("is unfinished: 1 of 2 rows", said)
        path.write_text("[" * 100_000 + "]" * 100_000)
        said = self.refused(2, self.run_command(PLOT, "out"), "plot_sweep")
        self.assertIn("sweep.json: must be JSON that is less deeply nested", said)

    def test_plot_of_words(self) -> None:
        for grid, words in (
            ("{preset: [simple, faithful]}", ["simple", "faithful"]),
            (
                "{preset: [simple, faithful], drag: [true, false]}",
                ["simple", "faithful", "preset simple", "drag false"],
            ),
        ):
            plan = f"{{policy: expert, episodes: 2, horizon: 5, engine: rigid_body, grid: {grid}}}"
            self.finished("out", "--overwrite", plan=plan)
            process = self.run_command(PLOT, "out", "--out", "plot.svg", "--overwrite")
            self.assertEqual((process.returncode, process.stderr), (0, ""))
            drawn = (self.folder / "plot.svg").read_text()
            for word in words:
                self.assertTrue(f"<!-- {word} -->" in drawn, word)
            self.assertFalse("<!-- servo -->" in drawn, "it follows the preset")

    def test_plot_of_another_format_is_refused(self) -> None:
        self.finished("out", plan="{policy: expert, episodes: 2, rows: [{}, {block_damp: 20}]}")
        path = self.folder / "out" / "sweep.json"
        content = json.loads(path.read_text())
        content["sweep"]["format"] -= 1
        path.write_text(json.dumps(content))
        said = self.refused(2, self.run_command(PLOT, "out"), "plot_sweep")
        was = content["sweep"]["format"]
        self.assertIn(f"out/sweep.json: format {was}: must be {was + 1}", said)

    def test_legends_of_a_plot_are_within_it_and_apart(self) -> None:
        grid = "{block_damp: [6, 20], pusher_mass: [4, 2], baumgarte: [30, 40, 50]}"
        self.finished("out", plan=f"{{policy: expert, episodes: 2, horizon: 5, grid: {grid}}}")
        drawing = read_curves(self.folder / "out", Suite(rosrun)).drawing("curves")
        legends = [axes.get_legend() for axes in drawing.wide.axes if axes.get_legend()]
        self.assertEqual([len(legend.get_texts()) for legend in legends], [5, 7, 7])
        check_words(self, drawing)

    def test_plot_names_engines_settings_and_units(self) -> None:
        """Texts of matplotlib's SVG, which has each as a comment."""
        cases = {
            "grid: {block_damp: [6, 20], pusher_mass: [4, 2]}": [
                "block_damp [1/s]",
                "pusher_mass [kg]",
                "MuJoCo (reference)",
            ],
            "engine: [two_mass, chipmunk]": ["two-mass engine", "Chipmunk", "MuJoCo (reference)"],
            "reference: chipmunk, rows: [{block_damp: 6}, {block_damp: 20}]": [
                "Chipmunk (reference)",
                "policy expert: Chipmunk to two-mass engine",
            ],
        }
        for number, (rows, texts) in enumerate(cases.items()):
            out = str(number)
            self.finished(out, plan="{policy: expert, episodes: 3, horizon: 60, " + rows + "}")
            process = self.run_command(PLOT, out, "--out", "plot.svg", "--overwrite")
            self.assertEqual(process.returncode, 0, process.stderr)
            drawn = (self.folder / "plot.svg").read_text()
            for text in texts:
                self.assertIn(f"<!-- {text} -->", drawn)

    def test_plot_of_convergence(self) -> None:
        plan = """
            policy: expert
            episodes: 10
            horizon: 60
            timestep: 0.005
            engine: rigid_body
            model_variants: [timestep=0.01, timestep=0.002, cone=elliptic]
            grid: {substep: [0.01, 0.002]}
        """
        self.finished("out", plan=plan)
        process = self.run_command(PLOT, "out", "--convergence", "--out", "plot.svg")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        drawn = (self.folder / "plot.svg").read_text()
        for text in (
            "divergence from MuJoCo with timestep 0.005, in replays of its actions (policy expert)",
            "MuJoCo, timestep: mean",
            "MuJoCo, timestep: median",
            "rigid-body engine, substep: mean",
            "timestep, substep [s]",
            "0.002",
        ):
            self.assertIn(f"<!-- {text} -->", drawn)
        self.assertNotIn("cone", drawn)

        variants, rows = read_convergence(self.folder / "out").lines
        self.assertEqual([point.value for point in variants.points], [0.002, 0.01])
        statistics = self.load("out/rows/001", "statistics.json")["rollouts"]
        for line, rollout in ((variants, "variant_timestep=0.002"), (rows, "engine_replay")):
            for component, unit in (("position", "m"), ("angle", "rad")):
                figures = statistics[rollout][f"mean_{component}_divergence_{unit}"]
                for suffix, key in (("", "mean"), ("_median", "median")):
                    found = line.points[0].figure(WHOLE, component, unit, suffix)
                    self.assertAlmostEqual(found, figures[key], delta=1e-6, msg=rollout)
                early = statistics[rollout][f"early_{component}_divergence_{unit}"]["mean"]
                self.assertEqual(line.points[0].figure(FIRST_2_S, component, unit), early)

        self.finished("words", plan="{policy: expert, episodes: 2, engine: [two_mass, chipmunk]}")
        process = self.run_command(PLOT, "words", "--convergence")
        self.assertIn("0 numeric parameters", self.refused(2, process, "plot_sweep"))


class Resuming(SweepCase):
    def test_rows_that_are_finished_are_not_run_again(self) -> None:
        expected = self.finished("whole")
        # A row that cannot be written ends the sweep in its midst.
        row = self.folder / "out" / "rows" / "002"
        shutil.copytree(self.folder / "whole", self.folder / "out")
        shutil.rmtree(row)
        blocked = row / "episodes.csv"
        blocked.mkdir(parents=True)
        self.assertIn("rows/002", self.refused(4, self.sweep("--out", "out"), "sweep"))
        status = self.load("out", "status.json")
        self.assertEqual((status["exit_code"], status["rows_finished"]), (4, 2))
        self.assertEqual(len(self.load("out", "sweep.json")["rows"]), 2)

        blocked.rmdir()
        times = {row: self.time_of(row) for row in ("000", "001", "003")}
        self.assertEqual(self.finished("out"), expected)
        self.assertEqual({row: self.time_of(row) for row in times}, times)

    def time_of(self, row: str) -> int:
        return (self.folder / "out" / "rows" / row / "metrics.json").stat().st_mtime_ns

    def test_interrupted_sweep_goes_on(self) -> None:
        damps = [1 + row / 2 for row in range(150)]
        plan = json.dumps({"policy": "expert", "episodes": 4, "grid": {"block_damp": damps}})
        command = [SWEEP, self.plan(plan), "--out", "out"]
        with subprocess.Popen(
            command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            self.assertTrue(process.stdout.readline().startswith("block_damp 1.0: "))
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=self.deadline)
        self.assertEqual(process.returncode, 4, said)
        self.assertIn("to continue, run the same command with --out out", said)
        status = self.load("out", "status.json")
        self.assertEqual((status["exit_code"], status["rows"]), (4, 150))
        self.assertGreater(status["rows_finished"], 0)
        self.assertLess(status["rows_finished"], 150)
        self.assertEqual(self.finished("out", plan=plan), self.finished("whole", plan=plan))

    def test_row_that_is_not_as_it_was_written_is_refused_by_name(self) -> None:
        self.finished("out")
        episodes = self.folder / "out" / "rows" / "001" / "episodes.csv"
        whole = episodes.read_text()
        for text in (
            whole.replace("true", "false", 1),
            whole[:-20],
            whole.replace("10003", "10004"),
        ):
            episodes.write_text(text)
            refusal = self.refused(3, self.sweep("--out", "out"), "sweep")
            self.assertIn("rows/001/", refusal)
            self.assertIn("delete the row", refusal)

    def test_folder_of_another_sweep_is_refused(self) -> None:
        self.finished("out")
        other = PLAN.replace("episodes: 7", "episodes: 8")
        refusal = self.refused(2, self.sweep("--out", "out", plan=other), "sweep")
        self.assertIn("/episodes is 7, must be 8", refusal)
        again = self.finished("out", "--overwrite", plan=other)
        self.assertEqual(again, self.finished("fresh", plan=other))

    def test_folder_of_a_comparison_is_refused(self) -> None:
        self.run_command(COMPARE, "--smoke", "--out", "out")
        for overwrite in WITH_AND_WITHOUT:
            process = self.sweep("--out", "out", *overwrite)
            self.assertIn(
                "holds a run (metrics.json), which a sweep does not replace",
                self.refused(2, process, "sweep"),
            )

    def test_sweep_is_not_replaced_by_a_comparison(self) -> None:
        before = self.finished("out")
        for overwrite in WITH_AND_WITHOUT:
            process = self.run_command(COMPARE, "--smoke", "--out", "out", *overwrite)
            self.assertIn(
                "holds a sweep (sweep.", self.refused(2, process, "compare"), "by its name"
            )
        self.assertEqual(self.results("out"), before)

    def test_what_is_not_ours_stays(self) -> None:
        mine = ["rows/notes.txt", "rows/000/notes.txt", "rows/007/figure.png", "reference/x"]
        mine += [
            "reference/0123456789abcdef/x",
            "metrics.json.part",
            "rows/001/metrics.json.2.part",
        ]
        for name in mine:
            self.write_below("out/" + name)
        expected = self.finished("whole")
        self.finished("out")
        status = self.load("out", "status.json")  # as an attempt that was cut short leaves it
        (self.folder / "out" / "rows" / "002" / "metrics.json").unlink()
        self.write_below("out/reference/0123456789abcdef/10000.reference")
        self.finished("out")
        self.assertEqual(self.load("out", "status.json"), status)
        self.assertFalse(
            (self.folder / "out/reference/0123456789abcdef/10000.reference").exists(), "it is ours"
        )
        self.finished("out", "--overwrite")
        kept = {name: (self.folder / "out" / name).read_text() for name in mine}
        self.assertEqual(kept, {name: "out/" + name for name in mine})
        results = {n: content for n, content in self.results("out").items() if n not in mine}
        self.assertEqual(results, expected)

    def test_link_where_rows_belong_is_refused(self) -> None:
        """Or what is written below it would replace files in another place."""
        self.write_below("data/000/episodes.csv")
        (self.folder / "out").mkdir()
        (self.folder / "out" / "rows").symlink_to(self.folder / "data")
        for arguments in ((), ("--overwrite",)):
            refusal = self.refused(2, self.sweep("--out", "out", *arguments), "sweep")
            self.assertIn("rows, which is a link or a file: must be a folder", refusal)
            self.assertEqual(self.files("out"), {"rows"})
        self.assertEqual(
            (self.folder / "data/000/episodes.csv").read_text(), "data/000/episodes.csv"
        )

    def test_rows_of_an_earlier_sweep_go(self) -> None:
        self.finished("out")
        single = PLAN.replace("[6, 20]", "[6]").replace("[4, 1.5]", "[4]")
        again = self.finished("out", "--overwrite", plan=single)
        self.assertEqual(set(again), set(self.finished("fresh", plan=single)))
        self.assertEqual(self.files("out/rows"), {"000"})

    def test_inputs_where_results_are_written_are_refused(self) -> None:
        for overwrite in WITH_AND_WITHOUT:
            plan = self.write_below("out/rows/plan.yaml", PLAN)
            process = self.run_command(SWEEP, str(plan), "--out", "out", *overwrite)
            self.assertIn(f"plan {plan}: must not be", self.refused(2, process, "sweep"))
            for arguments, named in (
                (["--reference-cache", "out/reference"], "reference cache out/reference"),
                (["--reference-cache", "out/rows/x"], "reference cache out/rows/x"),
            ):
                process = self.sweep("--out", "out", *overwrite, *arguments)
                self.assertIn(f"{named}: must not be", self.refused(2, process, "sweep"))
            for key in ("policy", "scene"):
                text = PLAN.replace("policy: expert", "") + f"{key}: out/sweep.csv"
                process = self.sweep("--out", "out", *overwrite, plan=text)
                self.assertIn(f"{key} out/sweep.csv: must", self.refused(2, process, "sweep"))
            self.assertEqual(self.files("out"), {"rows"})
            self.assertEqual(plan.read_text(), PLAN)

    def test_scene_of_a_row_where_results_are_written_is_refused(self) -> None:
        """Not only the reference reads files."""
        scene = Path(rospkg.RosPack().get_path("pusht_mujoco"), "scenes", "pusht.xml").read_text()
        self.write_below("a.xml", scene)
        kept = self.write_below("out/sweep.csv", scene)
        plan = PLAN.split("grid")[0] + "engine: mujoco\ngrid: {scene: [a.xml, out/sweep.csv]}"
        for overwrite in WITH_AND_WITHOUT:
            process = self.sweep("--out", "out", *overwrite, plan=plan)
            refusal = self.refused(2, process, "sweep")
            self.assertIn("scene out/sweep.csv: must not be where results are written", refusal)
            self.assertEqual(kept.read_text(), scene)
            self.assertEqual(self.files("out"), {"sweep.csv"})

    def write_below(self, name: str, content: str = "") -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content or name)
        return path


class Shards(SweepCase):
    def test_missing_and_double_shards_are_named(self) -> None:
        folders = self.shards(3)
        for missing in range(3):
            there = [folder for i, folder in enumerate(folders) if i != missing]
            self.assertIn(f"shards {missing + 1}/3: are missing", self.bad_merge(*there))
        self.assertIn("are both 2/3", self.bad_merge(*folders, folders[1]))
        self.assertFalse((self.folder / "merged").exists())

    def test_shards_are_not_replaced_by_what_comes_of_them(self) -> None:
        first, second = self.shards(2)
        before = self.results(first)
        (self.folder / "link").symlink_to(first)
        for shard, out in ((first, first), ("link", first), (first, "link")):
            process = self.run_command(MERGE, shard, second, "--out", out, "--overwrite")
            refusal = self.refused(2, process, "merge")
            self.assertIn(f"shard {shard}/sweep.json: must not be where", refusal)
            self.assertEqual(self.results(first), before)

    def test_shards_among_the_rows_are_refused(self) -> None:
        for folder, name in zip(self.shards(2), ("a", "b")):
            (self.folder / "out" / "rows").mkdir(parents=True, exist_ok=True)
            shutil.move(str(self.folder / folder), str(self.folder / "out" / "rows" / name))
        before = self.results("out")
        process = self.run_command(MERGE, "out/rows/a", "out/rows/b", "--out", "out", "--overwrite")
        self.assertIn("shard out/rows/a/", self.refused(2, process, "merge"))
        self.assertEqual(self.results("out"), before)

    def test_shards_beside_the_rows_are_fine(self) -> None:
        whole = self.finished("whole")
        folders = []
        for folder in self.shards(2):
            (self.folder / "out").mkdir(exist_ok=True)
            shutil.move(str(self.folder / folder), str(self.folder / "out"))
            folders.append(f"out/{folder}")
        for _ in range(2):
            process = self.run_command(MERGE, *folders, "--out", "out", "--overwrite")
            self.assertEqual(process.returncode, 0, process.stderr)
        merged = self.results("out")
        self.assertEqual({name: merged[name] for name in whole}, whole)

    def test_f29_merge_that_is_interrupted(self) -> None:
        rows = [{"block_damp": 1 + row / 10} for row in range(300)]
        plan = json.dumps(
            {"policy": "expert", "episodes": 2, "horizon": 1, "floor": False, "rows": rows}
        )
        folders = self.shards(2, plan=plan)
        whole = self.finished("whole", plan=plan)
        for number in (signal.SIGINT, signal.SIGTERM) if LONG else (signal.SIGTERM,):
            out = number.name
            with subprocess.Popen(
                [MERGE, *folders, "--out", out],
                cwd=self.folder,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            ) as process:
                until((self.folder / out / "rows" / "000" / "metrics.json").exists)
                process.send_signal(number)
                _, said = process.communicate(timeout=self.deadline)
            self.assertEqual(process.returncode, 4, said)
            self.assertRegex(said, r"^merge: interrupted in row \d+ of 0 to 299\n$")
            status = self.load(out, "status.json")
            self.assertEqual((status["exit_code"], status["rows"]), (4, 300))
            self.assertEqual(status["rows_finished"], len(self.load(out, "sweep.json")["rows"]))
            self.assertEqual(status["rows_finished"], len(self.files(out + "/rows")))
            self.assertLess(status["rows_finished"], 300)
            self.assertEqual(list((self.folder / out).rglob("*.part")), [])
            self.assertEqual(self.merge(*folders, out=out).returncode, 0)
            self.assertEqual(self.results(out), whole)

    def test_f29_merge_whose_files_cannot_grow(self) -> None:
        folders = self.shards(2)
        command = f'ulimit -f 5; exec "{MERGE}" {" ".join(folders)} --out out'
        process = self.run_command("bash", "-c", command)
        self.assertIn("cannot write out/rows/", self.refused(4, process, "merge"))
        self.assertEqual(self.load("out", "status.json")["exit_code"], 4)
        self.assertEqual(list((self.folder / "out").rglob("*.part")), [])

    def test_merging_again_writes_every_row(self) -> None:
        folders = self.shards(2)
        self.assertEqual(self.merge(*folders).returncode, 0)
        expected = self.results("merged")
        (self.folder / "merged" / "rows" / "000" / "metrics.json").write_text("{}")
        self.assertEqual(self.merge(*folders).returncode, 0)
        self.assertEqual(self.results("merged"), expected)

    def test_sweep_json_that_is_none_is_refused_by_name(self) -> None:
        folders = self.shards(2)
        for rows in (None, [1, 2, 3, 4]):
            for folder in folders:
                path = self.folder / folder / "sweep.json"
                content = json.loads(path.read_text())
                content["sweep"].pop("rows", None)
                if rows is not None:
                    content["sweep"]["rows"] = rows
                path.write_text(json.dumps(content))
            self.assertIn(f"shard {folders[0]}: its sweep.json", self.bad_merge(*folders))

    def test_foreign_shards_are_named(self) -> None:
        first, second = self.shards(2)
        foreign = PLAN.replace("policy: expert", "policy: fresh-untrained")
        self.finished("foreign", "--shard", "2/2", plan=foreign)
        refusal = self.bad_merge(first, "foreign")
        self.assertIn("foreign: is of another sweep", refusal)
        self.assertIn("inputs/policy", refusal)
        self.finished("third", "--shard", "3/3")
        self.assertIn("third: is of another sweep", self.bad_merge(first, second, "third"))
        self.finished("whole")
        self.assertIn("whole: is a sweep in one piece", self.bad_merge("whole"))

        provenance = self.folder / second / "provenance.json"
        changed = json.loads(provenance.read_text())
        changed["code"]["libmujoco.so"] = "another"
        provenance.write_text(json.dumps(changed))
        self.assertIn('/libmujoco.so is "another"', self.bad_merge(first, second))

    def test_shard_of_another_format_is_named_before_anything_is_replaced(self) -> None:
        folders = self.shards(2)
        self.assertEqual(self.merge(*folders).returncode, 0)
        before = self.results("merged")
        for file, place in (("sweep.json", "sweep"), ("provenance.json", None)):
            path = self.folder / folders[1] / file
            whole = path.read_text()
            content = json.loads(whole)
            described = content[place] if place else content
            self.assertEqual(described["format"], METRICS_FORMAT)
            described["format"] -= 1
            path.write_text(json.dumps(content))
            process = self.run_command(MERGE, *folders, "--out", "merged", "--overwrite")
            rule = f"format {METRICS_FORMAT - 1}: must be {METRICS_FORMAT}"
            refusal = self.refused(2, process, "merge")
            self.assertIn(f"shard {folders[1]}/{file}: {rule}", refusal)
            self.assertEqual(self.results("merged"), before)
            path.write_text(whole)

    def test_sweep_whose_provenance_is_of_another_format_does_not_go_on(self) -> None:
        self.finished("out")
        path = self.folder / "out" / "provenance.json"
        ours, other = (f'"format": {number}' for number in (METRICS_FORMAT, METRICS_FORMAT - 1))
        path.write_text(path.read_text().replace(ours, other))
        refusal = self.refused(2, self.sweep("--out", "out"), "sweep")
        self.assertIn(f"/format is {METRICS_FORMAT - 1}, must be {METRICS_FORMAT}", refusal)

    def test_unfinished_and_damaged_shards_are_named(self) -> None:
        first, second = self.shards(2)
        row = self.folder / second / "rows" / "003"
        episodes = (row / "episodes.csv").read_text()
        (row / "episodes.csv").write_text(episodes.replace("true", "false", 1))
        self.assertIn(f"{second}/rows/003/", self.bad_merge(first, second))
        shutil.rmtree(row)
        self.assertIn(f"shard {second}: row 3 is not finished", self.bad_merge(first, second))
        self.assertFalse((self.folder / "merged").exists(), "nothing is written before it is found")

    def bad_merge(self, *folders: str) -> str:
        return self.refused(3, self.merge(*folders), "merge")

    def test_more_shards_than_episodes_are_refused(self) -> None:
        refusal = self.refused(2, self.sweep("--out", "out", "--shard", "8/8"), "sweep")
        self.assertIn("at least as many episodes as shards", refusal)
        for text in ("0/3", "4/3", "1", "a/b", "1/3x", "-1/3"):
            refusal = self.refused(2, self.sweep("--out", "out", f"--shard={text}"), "sweep")
            self.assertIn(f"shard '{text}': must be I/N", refusal)


class OnLibtorch(SweepCase):
    """A policy that the kernel does not know: its bits depend on what libtorch computes with."""

    PLAN = "{policy: policy.pt, episodes: 4, rows: [{block_damp: 6}, {block_damp: 20}]}"

    def setUp(self) -> None:
        super().setUp()
        torch.jit.script(Forked().eval()).save(str(self.folder / "policy.pt"))
        openblas = next(Path("/usr/lib").glob("*/openblas-pthread"))
        path = f"{openblas}:{os.environ['LD_LIBRARY_PATH']}"
        self.cores = {
            core: {"LD_LIBRARY_PATH": path, "OPENBLAS_CORETYPE": core, "OPENBLAS_NUM_THREADS": "1"}
            for core in ("Prescott", "Haswell")
        }

    def compare(self, core: str, out: str, *arguments: str) -> bytes:
        command = [COMPARE, "--policy", "policy.pt", "--episodes", "4", "--out", out, *arguments]
        process = self.run_command(*command, environment=self.cores[core])
        self.assertEqual(process.returncode, 0, process.stderr)
        return self.result_bytes(out)

    def sweep_on(self, core: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
        command = [SWEEP, self.plan(self.PLAN), *arguments]
        return self.run_command(*command, environment=self.cores[core])

    def test_kept_reference_of_another_blas_is_not_used(self) -> None:
        alone = {core: self.compare(core, f"alone-{core}") for core in self.cores}
        self.assertEqual(len(set(alone.values())), 2, "only then can this test fail")
        for core in (*self.cores, *self.cores):
            shared = self.compare(core, f"with-{core}", "--reference-cache", "cache", "--overwrite")
            self.assertEqual(shared, alone[core])
        self.assertEqual(len(list((self.folder / "cache").rglob("*.reference"))), 8)
        provenance = self.load("alone-Prescott", "provenance.json")
        self.assertEqual(provenance["policy"]["libtorch_choices"]["openblas_core"], "Prescott")
        for library in ("libtorch_cpu.so", "libopenblas", "libblas.so"):
            self.assertTrue(any(name.startswith(library) for name in provenance["code"]), library)

    def test_rows_and_shards_of_another_blas_are_refused(self) -> None:
        for number, core in enumerate(self.cores, 1):
            process = self.sweep_on(core, "--out", core, "--shard", f"{number}/2")
            self.assertEqual(process.returncode, 0, process.stderr)
        refusal = self.refused(3, self.merge(*self.cores), "merge")
        self.assertIn("openblas_core", refusal)
        self.assertEqual(self.sweep_on("Haswell", "--out", "out").returncode, 0)
        shutil.rmtree(self.folder / "out" / "rows" / "001")
        process = self.sweep_on("Prescott", "--out", "out")
        self.assertNotEqual(process.returncode, 0)
        self.assertIn("openblas_core", process.stderr)


class Forked(torch.nn.Module):
    """The shipped policy, with a fork that changes nothing."""

    def __init__(self) -> None:
        super().__init__()
        folder = rospkg.RosPack().get_path("pusht_policy")
        self.policy = torch.jit.load(f"{folder}/policies/bc_policy.ts.pt")

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        action: torch.Tensor = self.policy(obs)
        return torch.where(action > 0, action, action)


class Engines(SweepCase):
    """Kinds of simulator are one more dimension."""

    PLAN = "{policy: expert, episodes: 4, engine: [two_mass, chipmunk]}"
    RUN = ("--policy", "expert", "--episodes", "4")

    def test_every_row_is_the_run_of_its_engine(self) -> None:
        results = self.finished("out", "--threads", "2", plan=self.PLAN)
        for row, engine in enumerate(("two_mass", "chipmunk")):
            command = (COMPARE, *self.RUN, "--engine", engine, "--threads", "1", "--out", engine)
            process = self.run_command(*command)
            self.assertEqual(process.returncode, 0, process.stderr)
            files = (f"rows/00{row}/metrics.json", f"rows/00{row}/episodes.csv")
            self.assertEqual(b"".join(map(results.__getitem__, files)), self.result_bytes(engine))
        names = (
            "row",
            "engine_simulator",
            "block_damp",
            "pusher_mass",
            "collision_slop",
            "iterations",
        )
        cells = [
            [row[name] for name in names]
            for row in csv.DictReader(results["sweep.csv"].decode().splitlines())
        ]
        wanted = [
            ["0", "two_mass", "6.0", "4.0", "", ""],
            ["1", "chipmunk", "", "", "0.0001", "30"],
        ]
        self.assertEqual(cells, wanted)

    def test_shards_are_the_sweep(self) -> None:
        whole = self.finished("whole", "--threads", "1", plan=self.PLAN)
        for number in (1, 2):
            self.finished(f"shard-{number}", "--shard", f"{number}/2", plan=self.PLAN)
        process = self.merge("shard-1", "shard-2")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(self.results("merged"), whole)

    def test_any_kind_is_a_reference(self) -> None:
        plan = "{policy: expert, episodes: 2, reference: chipmunk, engine: mujoco, rows: [{}]}"
        plan = plan.replace("engine:", "reference_parameters: {iterations: 10}, engine:")
        results = self.finished("out", "--reference-cache", "cache", plan=plan)
        again = self.finished("again", "--reference-cache", "cache", plan=plan)
        self.assertEqual(again, results)
        row = json.loads(results["rows/000/metrics.json"])
        self.assertEqual(row["simulators"]["reference"]["changed"], ["iterations"])
        self.assertNotIn("mj_success_rate", row)


class BadPlans(SweepCase):
    def test_refused_by_name_line_and_rule(self) -> None:
        plans: Dict[str, str] = {
            "": "must map keys to values",
            "grid: [": "must be YAML",
            "episodes: 5": "must have grid, rows, permutations, or a list of engines",
            "{grid: {block_damp: [1]}, rows: [{}]}": "must have either grid, rows or permutations",
            "grid:\n  block_dump: [1]": "line 2: parameter 'block_dump': unknown; known: ",
            "grid:\n  block_damp: 1": "line 2, block_damp: must be a list",
            "grid:\n  block_damp: [1, -2]": "line 2: block_damp -2.0: must be from 0.0 to",
            "rows:\n- {}\n- {baumgarte: 60, block_damp: 90}": "line 3: baumgarte 60.0: must be",
            "grid:\n  block_damp: [6, 90]\n  baumgarte: [60]": "line 2: baumgarte 60.0: must",
            "grid:\n  block_damp: [1, .nan]": "line 2: block_damp '.nan': must be a decimal",
            "grid:\n  block_damp: [010]": "line 2: block_damp '010': must be a decimal number",
            "grid:\n  block_damp: [010x]": "line 2: block_damp '010x': must be a decimal",
            "grid: {}": "line 1, grid: must map parameters to lists",
            "rows: []": "line 1, rows: must be a list of settings",
            "rows: [{}, {block_damp: 6.0}]": "must appear only once",
            "episodez: 5\nrows: [{}]": "line 1, episodez: there is no such key; there are policy",
            "episodes: 5\nepisodes: 6\nrows: [{}]": "line 2, episodes: must appear only once",
            "episodes: 0\nrows: [{}]": "episodes 0: must be from 1 to 1000000",
            "episodes: 5.5\nrows: [{}]": "line 1, episodes: '5.5' must be a decimal integer",
            "seed: -1\nrows: [{}]": "line 1, seed: '-1' must be a decimal integer",
            "horizon: 301\nrows: [{}]": "horizon 301: must be from 1 to 300",
            "policy: none.pt\nrows: [{}]": "policy none.pt: must be a readable file",
            "scene: none.xml\nrows: [{}]": "none.xml",
            "policy: [a]\nrows: [{}]": "line 1, policy: must be a single value",
            "&a {grid: *a}": "grid",
            "rows: [{block_damp: 1, block_damp: 2}]": "block_damp: must appear only once",
            "rows: [{}]\n---\nepisodes: 6": "must be one YAML document",
            "episodes: 010\nrows: [{}]": "'010' must be a decimal integer",
            "engine: bulet\nrows: [{}]": "line 1: simulator 'bulet': unknown",
            "reference: 6\nrows: [{}]": "line 1: simulator '6': unknown",
            "engine: []": "line 1, engine: must be a simulator, or a list of simulators",
            "engine: [chipmunk, chipmunk]": "must appear only once",
            "engine: [two_mass, chipmunk]\ngrid: {block_damp: [1]}": "unknown; known: ",
            "reference_parameters: 5\nrows: [{}]": "line 1, reference_parameters: must map",
            "reference_parameters: {scene: a.xml}\nscene: b.xml\nrows: [{}]": "line 2, scene: must "
            "appear only once; it is under reference_parameters too",
            "reference: two_mass\nscene: a.xml\nrows: [{}]": "line 2: parameter 'scene'",
        }
        for plan, rule in plans.items():
            with self.subTest(plan=plan):
                refusal = self.refused(2, self.sweep("--out", "out", plan=plan), "sweep")
                self.assertIn(rule, refusal)
                self.assertFalse((self.folder / "out").exists(), "nothing is begun")

    def test_no_plan_and_bad_options(self) -> None:
        self.refused(2, self.run_command(SWEEP), "sweep")
        self.refused(2, self.run_command(SWEEP, "none.yaml"), "sweep")
        for threads in ("0", "-1", "two", "1.5"):
            self.refused(2, self.sweep("--threads", threads, "--out", "out"), "sweep")
        self.refused(2, self.run_command(MERGE), "merge")
        self.refused(2, self.merge("none"), "merge")


class Faults(SweepCase):
    def test_disk_full(self) -> None:
        """A file that cannot grow beyond 5 kB stands for a full disk."""
        command = f'ulimit -f 5; exec "{SWEEP}" "{self.plan(PLAN)}" --out out'
        process = self.run_command("bash", "-c", command)
        refusal = self.refused(4, process, "sweep")
        self.assertIn("row 0", refusal)
        self.assertIn("cannot write", refusal)
        self.assertNotIn("rows failed", refusal, "a full disk is no fault of a row")
        left: List[Path] = list((self.folder / "out").rglob("*.part"))
        self.assertEqual(left, [])

    def test_parameter_that_lets_the_engine_fly_apart(self) -> None:
        policy = self.charging_policy()
        grid = "grid: {baumgarte: [40, 10, 20]}"
        plan = f"{{policy: {policy}, first_episode: 3, episodes: 1, {grid}}}"
        process = self.sweep("--out", "out", plan=plan)
        refusal = self.refused(4, process, "sweep")
        self.assertIn("row 1 (baumgarte 10.0): episode 3 (spawn seed 10003), engine_", refusal)
        self.assertRegex(refusal, r"step \d+: step: \w+ \S+ m: must be within 1000.0 m\n$")
        self.assertEqual(self.load("out", "status.json")["rows_finished"], 2)
        self.assertEqual([row["row"] for row in self.load("out", "sweep.json")["rows"]], [0, 2])

    def test_two_at_once_in_one_folder(self) -> None:
        (self.folder / "out").mkdir()
        descriptor = os.open(self.folder / "out", os.O_RDONLY)
        self.addCleanup(os.close, descriptor)
        fcntl.flock(descriptor, fcntl.LOCK_SH)  # which a second run would get, too
        self.assertIn("in use", self.refused(2, self.sweep("--out", "out"), "sweep"))


if __name__ == "__main__":
    unittest.main()
