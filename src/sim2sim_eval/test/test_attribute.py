#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""attribute: from a sweep over switches to the cause of the gap."""

import csv
import itertools
import json
import re
import shutil
import signal
import subprocess
import unittest
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import yaml  # type: ignore[import]
from pusht_testing.warm_commands import warm

from command_case import CommandCase, catches, executable, until

ATTRIBUTE = executable("sim2sim_eval", "attribute")
CONFIG = Path(__file__).resolve().parents[1] / "config"
PLOT = executable("sim2sim_eval", "plot_sweep")
REPORT = executable("sim2sim_eval", "report")
warm([PLOT, REPORT], "sim2sim_report.make", "sim2sim_eval.command")
MERGE = executable("sim2sim_eval", "merge")
SWEEP = executable("sim2sim_eval", "sweep")
SWITCHES = ["servo", "drag", "coulomb"]
PLAN = """
policy: expert
episodes: 24
horizon: 60
engine: rigid_body
reanchor: [5, 20]
grid: {servo: [false, true], drag: [false, true], coulomb: [false, true]}
"""
SAMPLE = PLAN.split("grid")[0] + (
    "permutations: {switches: [servo, drag, coulomb], orders: 40, seed: 1}"
)
REPLAY = "mean_pos_divergence"


class Attributing(CommandCase):
    def sweep(self, plan: str = PLAN, out: str = "sweep", *options: str) -> Path:
        (self.folder / "plan.yaml").write_text(plan)
        process = self.run_command(SWEEP, "plan.yaml", "--out", out, *options)
        self.assertEqual(process.returncode, 0, process.stderr)
        return self.folder / out

    def attribute(self, folder: Path) -> Dict[str, Any]:
        process = self.run_command(ATTRIBUTE, str(folder))
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        self.printed = process.stdout
        content: Dict[str, Any] = json.loads((folder / "attribution.json").read_text())
        return content

    def refused(self, folder: Path, said: str) -> None:
        process = self.run_command(ATTRIBUTE, str(folder))
        self.assert_one_line(process, 2, "attribute")
        self.assertIn(said, process.stderr)
        self.assertFalse((folder / "attribution.json").exists())

    def test_shares_are_those_of_the_rows(self) -> None:
        folder = self.sweep()
        content = self.attribute(folder)
        self.assertEqual(content["switches"], sorted(SWITCHES))
        self.assertEqual(
            len(content["gaps"]), 7, "two figures in open loop and twice re-anchored; success"
        )
        rows = {}
        for row in sorted((folder / "rows").iterdir()):
            metrics = json.loads((row / "metrics.json").read_text())
            on = metrics["simulators"]["engine"]["parameters"]
            rows[tuple(on[name] for name in content["switches"])] = metrics
        gap = content["gaps"][content["order"][0]]
        means = {on: metrics[f"{REPLAY}_m"] for on, metrics in rows.items()}
        self.assertNotIn("farther from MuJoCo", self.printed)
        self.assertIn("leave_one_out in attribution.json", self.printed)
        # The course's keys have six decimals.
        self.assertAlmostEqual(gap["all_off"], means[False, False, False], delta=5e-7)
        self.assertAlmostEqual(gap["all_on"], means[True, True, True], delta=5e-7)
        total = 0.0
        for place, name in enumerate(content["switches"]):
            found = gap["switches"][name]
            expected = self.mean_over_orders(means, place)
            self.assertAlmostEqual(found["share"], expected, delta=3e-6)
            self.assertLess(found["share_interval"][0], found["share"])
            self.assertGreater(found["share_interval"][1], found["share"])
            total += found["share"]
        self.assertAlmostEqual(total, gap["all_off"] - gap["all_on"], delta=3e-6)
        success = content["gaps"]["lost_success"]
        lost = rows[False, False, False]
        self.assertAlmostEqual(
            success["all_off"],
            lost["reference_success_rate"] - lost["engine_success_rate"],
            delta=2e-6,
        )

    @staticmethod
    def mean_over_orders(means: Dict[Any, float], place: int) -> float:
        """The definition: what a switch closes, averaged over all orders of switching on."""
        closed = []
        for order in itertools.permutations(range(3)):
            before = [player in order[: order.index(place)] for player in range(3)]
            after = list(before)
            after[place] = True
            closed.append(means[tuple(before)] - means[tuple(after)])
        return float(np.mean(closed))

    def test_interrupt_while_the_rows_are_read(self) -> None:
        folder = self.sweep(PLAN.replace("24", "1000").replace("60", "1"))
        for number in (signal.SIGINT, signal.SIGTERM):
            with subprocess.Popen(
                [ATTRIBUTE, str(folder)],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            ) as process:
                until(lambda: catches(process.pid, number))
                process.send_signal(number)
                output = process.communicate(timeout=self.deadline)
            self.assertEqual((process.returncode, *output), (4, "", "attribute: interrupted\n"))
            self.assertFalse((folder / "attribution.json").exists())
            self.assertFalse((folder / "attribution.csv").exists())

    def test_files_and_terminal_agree(self) -> None:
        folder = self.sweep()
        content = self.attribute(folder)
        with open(folder / "attribution.csv", newline="", encoding="utf-8") as file:
            rows: List[Dict[str, str]] = list(csv.DictReader(file))
        self.assertEqual(len(rows), 3 * len(content["gaps"]))
        for row in rows:
            found = content["gaps"][row["gap"]]["switches"][row["switch"]]
            self.assertEqual(float(row["share"]), found["share"])
            self.assertEqual(float(row["alone"]), found["alone"]["value"])
        for name in content["order"]:
            gap = content["gaps"][name]
            self.assertIn(gap["title"], self.printed)
            for switch, found in gap["switches"].items():
                lines = [
                    line for line in self.printed.splitlines() if line.startswith(f"  {switch} ")
                ]
                text = f"{found['share']:+.4f}" if found["share"] > 0 else f"{found['share']:.4f}"
                ends = found["share_interval"]
                if ends:
                    text += f" [{ends[0]:.4f}, {ends[1]:.4f}]"
                self.assertTrue(any(f" {text} " in f"{line} " for line in lines), (switch, text))

    def test_same_bytes_from_shards(self) -> None:
        whole = self.attribute(self.sweep())
        for number in ("1", "2"):
            shard = self.sweep(PLAN, f"shard-{number}", "--shard", f"{number}/2")
            self.refused(shard, f'shard-{number}: is shard "{number}/2" of a sweep; merge')
        process = self.run_command(MERGE, "shard-1", "shard-2", "--out", "merged")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(self.attribute(self.folder / "merged"), whole)
        for name in ("attribution.json", "attribution.csv"):
            merged = (self.folder / "merged" / name).read_bytes()
            self.assertEqual(merged, (self.folder / "sweep" / name).read_bytes())

    def test_what_is_no_switch(self) -> None:
        plan = PLAN.replace(
            "{servo: [false, true], drag: [false, true], coulomb: [false, true]}", "{}"
        )
        two_mass = plan.replace("rigid_body", "two_mass").replace("{}", "{block_damp: [2, 20]}")
        self.refused(self.sweep(two_mass, "two_mass"), "only true/false parameters may vary")

    def test_random_orders_agree_with_all_combinations(self) -> None:
        exact = self.attribute(self.sweep())
        sampled = self.attribute(self.sweep(SAMPLE, "sampled"))
        self.assertEqual(sampled["orders"], 40)
        self.assertEqual(sampled["switches"], SWITCHES)
        for name in exact["order"]:
            for switch in SWITCHES:
                found = sampled["gaps"][name]["switches"][switch]
                share = exact["gaps"][name]["switches"][switch]["share"]
                if found["share_interval"]:
                    self.assertLessEqual(found["share_interval"][0], share, (name, switch))
                    self.assertGreaterEqual(found["share_interval"][1], share, (name, switch))
            self.assertAlmostEqual(
                sum(found["share"] for found in sampled["gaps"][name]["switches"].values()),
                sampled["gaps"][name]["all_off"] - sampled["gaps"][name]["all_on"],
                delta=4e-6,
            )
        process = self.run_command(REPORT, "sampled")
        self.assertEqual(process.returncode, 0, process.stderr)
        page = (self.folder / "sampled" / "report.html").read_text(encoding="utf-8")
        self.assertIn("along 40 random orders of switching on", page)
        self.assertNotIn("Who needs whom", page)
        process = self.run_command(PLOT, "sampled", "--costs")
        self.assert_one_line(process, 2, "plot_sweep")
        self.assertIn("only a sweep of all subsets says", process.stderr)

    def test_bad_samples(self) -> None:
        for bad, said in {
            "{orders: 3}": "must have switches and orders, from 1 to 10000",
            "{switches: [servo], orders: 3}": "must be a list of two parameters or more",
            "{switches: [servo, gravity], orders: 3}": "parameter 'gravity'",
            "{switches: [servo, preset], orders: 3}": "preset 'false'",
            "{switches: [servo, drag], orders: 0}": "must have switches and orders, from 1 to",
            "{switches: [servo, drag], orders: 3, sede: 1}": "there is no such key",
        }.items():
            with self.subTest(bad):
                (self.folder / "plan.yaml").write_text(
                    PLAN.split("grid")[0] + f"permutations: {bad}"
                )
                process = self.run_command(SWEEP, "plan.yaml", "--out", "bad")
                self.assert_one_line(process, 2, "sweep")
                self.assertIn(said, process.stderr)

    def test_refusals(self) -> None:
        self.refused(self.folder, "must be the folder of a whole run or of a sweep")
        compare = executable("sim2sim_eval", "compare")
        process = self.run_command(compare, *"--policy expert --episodes 2 --out run".split())
        self.assertEqual(process.returncode, 0, process.stderr)
        self.refused(self.folder / "run", "is a run; a sweep over switches is needed")
        rows = (
            PLAN.split("grid")[0]
            + "rows: [{servo: true}, {servo: false}, {servo: true, drag: false}]"
        )
        self.refused(
            self.sweep(rows, "rows"),
            "must have every combination of its switches, but drag false, servo false is not there",
        )
        folder = self.sweep()
        (folder / "rows" / "003" / "metrics.json").unlink()
        self.refused(folder, "row 3 of 8 has not finished; run the sweep again to continue it")

    def test_rows_of_other_episodes(self) -> None:
        folder = self.sweep()
        other = self.sweep(PLAN + "seed: 7\n", "other")
        shutil.rmtree(folder / "rows" / "001")
        shutil.copytree(other / "rows" / "001", folder / "rows" / "001")
        self.refused(folder, "do not pair")

    def test_few_episodes(self) -> None:
        content = self.attribute(self.sweep(PLAN.replace("24", "5")))
        self.assertIn("Below 20 episodes no intervals", self.printed)
        gap = content["gaps"][content["order"][0]]
        self.assertIsNone(gap["switches"]["drag"]["share_interval"])

    def test_damaged_row(self) -> None:
        folder = self.sweep()
        path = folder / "rows" / "002" / "episodes.csv"
        path.write_bytes(path.read_bytes()[:-200])
        self.refused(folder, "rows/002/episodes.csv")

    def test_another_sweep_takes_what_was_said_of_the_first(self) -> None:
        folder = self.sweep()
        self.attribute(folder)
        self.sweep(PLAN.replace("24", "22"), "sweep", "--overwrite")
        self.assertFalse((folder / "attribution.json").exists())
        self.assertFalse((folder / "attribution.csv").exists())

    def test_idioms_are_the_whole_gap_of_an_engine_to_itself(self) -> None:
        folders = []
        for path in sorted(CONFIG.glob("idioms_*.yaml")):
            plan = yaml.safe_load(path.read_text())
            kind = plan["engine"]
            short = {"policy": "expert", "episodes": 3, "horizon": 40, "floor": False}
            folder = self.sweep(json.dumps({**plan, **short, "reference": kind}), kind)
            content = self.attribute(folder)
            folders.append(str(folder))
            self.assertEqual(content["switches"], sorted(plan["grid"]))
            for name in content["order"][:2]:
                gap = content["gaps"][name]
                self.assertRegex(gap["title"], "open loop")
                self.assertEqual(gap["all_on"], 0.0, (kind, name))
                shares = sum(found["share"] for found in gap["switches"].values())
                self.assertAlmostEqual(shares, gap["all_off"], delta=5e-6)
                for idiom, found in gap["switches"].items():
                    self.assertGreater(found["leave_one_out"]["value"], 0.0, (kind, idiom))
            for name in content["order"][2:6]:  # being put back clears an engine's hidden state
                gap = content["gaps"][name]
                self.assertRegex(gap["title"], "re-anchored")
                self.assertLess(gap["all_on"], 0.1 * gap["all_off"], (kind, name))
        self.assertEqual([Path(folder).name for folder in folders], ["box2d", "bullet", "chipmunk"])
        picture = self.folder / "costs.png"
        process = self.run_command(PLOT, *folders, "--costs", "--out", str(picture))
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")

    def test_refused_pictures_of_costs(self) -> None:
        plan = PLAN.replace("reanchor: [5, 20]\n", "").replace("24", "2")
        folder = self.sweep(plan)
        self.attribute(folder)
        process = self.run_command(PLOT, str(folder), "--costs")
        self.assert_one_line(process, 2, "plot_sweep")
        self.assertIn("has no re-anchored replay", process.stderr)
        process = self.run_command(PLOT, str(folder), str(folder))
        self.assert_one_line(process, 2, "plot_sweep")
        self.assertIn("only --costs draws several sweeps", process.stderr)
        self.assertFalse((folder / "sweep.png").exists())

    def test_help_names_what_it_needs(self) -> None:
        process = self.run_command(ATTRIBUTE, "--help")
        self.assertEqual(process.returncode, 0)
        self.assertRegex(process.stdout, re.compile("true/false\\s+parameters"))


if __name__ == "__main__":
    unittest.main()
