#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The loop between policy and world, repeats, and equivalents, as a user meets them."""

import csv
import json
import re
import unittest
from typing import List, Tuple
from pusht_testing.warm_commands import warm

from command_case import CommandCase, executable

COMPARE = executable("sim2sim_eval", "compare")
EQUIVALENT = executable("sim2sim_eval", "equivalent")
PLOT = executable("sim2sim_eval", "plot_sweep")
CONTRAST = executable("sim2sim_eval", "contrast")
MATRIX = executable("sim2sim_eval", "matrix")
MERGE = executable("sim2sim_eval", "merge")
PLAN = executable("sim2sim_eval", "plan")
REPORT = executable("sim2sim_eval", "report")
warm([PLOT, REPORT], "sim2sim_report.make", "sim2sim_eval.command")
RECOMPUTE = executable("sim2sim_eval", "recompute")
SWEEP = executable("sim2sim_eval", "sweep")
EXPERT = ("--policy", "expert")
NOISY = (
    *("--loop", "action_noise=0.2", "--loop-engine", "action_delay=1"),
    *("--loop-reference", "observation_noise_yaw=0.05", "--repeats", "3", "--episodes", "12"),
)


class LoopCase(CommandCase):
    def compare(self, out: str, *arguments: str) -> str:
        return self.run_all((COMPARE, *EXPERT, *arguments, "--out", out))

    def refused(self, program: str, *arguments: str) -> str:
        process = self.run_command(program, *arguments)
        self.assert_one_line(process, 2, program.rsplit("/", 1)[-1])
        message: str = process.stderr
        return message

    def episodes(self, out: str) -> bytes:
        return (self.folder / out / "episodes.csv").read_bytes()

    def sweep(self, plan: str, out: str, *arguments: str) -> None:
        self.write("plan.yaml", plan.encode())
        self.run_all((SWEEP, "plan.yaml", "--out", out, *arguments))


class Loops(LoopCase):
    def test_noise_has_the_same_bytes_over_threads_cache_bag_and_rows(self) -> None:
        self.compare("one", *NOISY, "--threads", "1", "--record")
        self.compare("two", *NOISY, "--threads", "2", "--reference-cache", "kept")
        self.compare("cached", *NOISY, "--reference-cache", "kept")
        self.run_all((RECOMPUTE, "one/compare.bag", "--out", "again"))
        for out in ("two", "cached", "again"):
            self.assertEqual(self.result_bytes(out), self.result_bytes("one"), out)

    def test_the_reference_is_kept_for_its_own_loop_alone(self) -> None:
        loop = ("--loop-reference", "action_delay=3", "--episodes", "5")
        self.compare("alone", *loop)
        self.compare("plain", "--episodes", "5", "--reference-cache", "kept")
        self.compare("cached", *loop, "--reference-cache", "kept")
        self.assertEqual(self.result_bytes("cached"), self.result_bytes("alone"))
        self.assertNotEqual(self.episodes("plain"), self.episodes("alone"))

    def test_the_reference_is_kept_for_its_own_random_numbers_alone(self) -> None:
        noise = ("--loop", "action_noise=0.5", "--episodes", "3", "--noise-seed")
        self.compare("first", *noise, "1", "--reference-cache", "kept")
        self.compare("cached", *noise, "2", "--reference-cache", "kept")
        self.compare("alone", *noise, "2")
        self.assertEqual(self.episodes("cached"), self.episodes("alone"))

    def test_nothing_set_changes_nothing(self) -> None:
        self.compare("without", "--episodes", "4")
        for number, loop in enumerate(("action_delay=0", "hold=1", "action_noise=0")):
            self.compare(f"with{number}", "--episodes", "4", "--loop", loop)
            self.assertEqual(self.episodes(f"with{number}"), self.episodes("without"), loop)

    def test_a_delay_is_a_change_of_its_side_alone(self) -> None:
        self.compare("late", "--episodes", "2", "--loop-engine", "action_delay=2")
        metrics = self.load("late", "metrics.json")
        self.assertEqual(metrics["simulators"]["engine"]["changed"], ["loop.action_delay"])
        self.assertEqual(metrics["simulators"]["reference"]["changed"], [])

    def test_shards_and_rows_of_a_grid(self) -> None:
        plan = "{policy: expert, episodes: 12, repeats: 2, grid: {loop.action_noise: [0, 0.3]}}"
        self.sweep(plan, "whole")
        for shard in ("1/2", "2/2"):
            self.run_all((SWEEP, "plan.yaml", "--shard", shard, "--out", f"s{shard[0]}"))
        self.assertFalse((self.folder / "whole" / "reference").exists(), "kept for the sweep alone")
        self.run_all((MERGE, "s1", "s2", "--out", "merged"))
        for row in ("rows/000", "rows/001"):
            self.assertEqual(self.episodes(f"merged/{row}"), self.episodes(f"whole/{row}"))
        self.compare("run", "--episodes", "12", "--repeats", "2", "--set", "loop.action_noise=0.3")
        self.assertEqual(self.episodes("whole/rows/001"), self.episodes("run"))
        with (self.folder / "whole" / "sweep.csv").open() as file:
            self.assertEqual([r["loop.action_noise"] for r in csv.DictReader(file)], ["0.0", "0.3"])

    def test_a_loop_with_a_name_is_its_parameters(self) -> None:
        parameters = {
            "observation_delay": "1",
            "observation_noise_position": "0.002",
            "observation_noise_yaw": "0.01",
        }
        each = [word for item in parameters.items() for word in ("--loop", "=".join(item))]
        run = ("--episodes", "4", "--no-floor")
        self.compare("one_by_one", *run, *each)
        self.compare("named", *run, "--loop", "tracker")
        self.compare("after", *run, "--loop", "tracker", "--loop", "observation_delay=0")
        self.assertEqual(self.episodes("named"), self.episodes("one_by_one"))
        self.assertNotEqual(self.episodes("after"), self.episodes("named"))
        loop = self.load("named", "metrics.json")["simulators"]["engine"]["parameters"]
        self.assertEqual(loop["loop.preset"], "tracker")
        self.assertEqual(loop["loop.observation_noise_yaw"], 0.01)

    def test_the_loops_of_a_plan_are_in_both_roles(self) -> None:
        loops = "[none, tracker, {observation_noise_position: 0.005}]"
        self.sweep(f"{{policy: expert, episodes: 4, floor: false, loop: {loops}}}", "loops")
        for row, loop in enumerate(("none", "tracker", "observation_noise_position=0.005")):
            self.compare(f"run{row}", "--episodes", "4", "--no-floor", "--loop", loop)
            self.assertEqual(self.episodes(f"loops/rows/00{row}"), self.episodes(f"run{row}"))
        matrix = executable("sim2sim_eval", "matrix")
        self.assertIn("has policy expert in several loops", self.refused(matrix, "loops"))
        self.assertIn("has several loops; `plot_sweep` draws", self.refused(REPORT, "loops"))
        self.run_all((PLOT, "loops"))
        self.sweep("{policy: expert, episodes: 4, floor: false, loop: tracker, rows: [{}]}", "one")
        self.assertEqual(self.episodes("one/rows/000"), self.episodes("run1"))
        for plan, rule in {
            "loop: camera": "loop 'camera': must be NAME=VALUE, or one of: none, tracker",
            "loop: [tracker, tracker]": "loop: must appear only once",
            "loop: [none, {hold: 1}]": "loop: must appear only once",
            "loop: []": "loop: must be a loop, or a list of loops",
            "loop: {hold: 2}, engine: ['two_mass:loop.hold=3']": "loop.hold: must appear only once",
        }.items():
            self.write("plan.yaml", f"{{policy: expert, rows: [{{}}], {plan}}}".encode())
            self.assertIn(rule, self.refused(SWEEP, "plan.yaml", "--out", "refused"))

    def test_refusals(self) -> None:
        for arguments, words in {
            ("--loop", "delay=1"): "loop: parameter 'delay': unknown; known: preset, ",
            ("--loop", "action_delay=-1"): "loop: action_delay -1: must be from 0 to 100",
            ("--loop-engine", "action_delay"): "must be NAME=VALUE, or one of: none, tracker",
            ("--loop", "hold=2", "--loop-engine", "hold=3"): "loop.hold must be set once",
            ("--repeats", "3"): "repeats 3: must divide episodes 50",
            ("--execute", "2"): "policy expert: execute 2: must be from 1 to 1",
        }.items():
            self.assertIn(words, self.refused(COMPARE, *EXPERT, *arguments), arguments)
        audit = executable("sim2sim_eval", "audit")
        self.assertIn("an audit has no policy", self.refused(audit, "--set", "loop.hold=2"))


class Repeats(LoopCase):
    NOISE = ("--loop", "action_noise=0.5", "--no-floor", "--repeats", "3", "--episodes", "60")

    def test_results_are_by_start(self) -> None:
        text = self.compare("run", *self.NOISE, "--write-starts", "starts.csv")
        self.assertIn("(60 episodes, 3 of each start; in brackets", text)
        self.assertEqual(len((self.folder / "starts.csv").read_text().splitlines()), 1 + 20)
        self.assertIn("variance of repeats", text)
        metrics = self.load("run", "metrics.json")
        self.assertEqual((metrics["number_of_starts"], metrics["repeats"]), (20, 3))
        low, high = metrics["engine_success_variance_repeats_interval"]
        self.assertTrue(low <= metrics["engine_success_variance_repeats"] <= high <= 0.5)
        with (self.folder / "run" / "episodes.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["repeat"] for row in rows[::3]], ["0", "1", "2"] * 20)
        self.assertEqual([row["seed"] for row in rows[:12:3]], ["10000"] * 3 + ["10001"])
        wide = self.load("run", "statistics.json")["number_of_starts"]
        self.assertEqual(wide, 20)

    def test_readers_of_repeats(self) -> None:
        self.compare("run", *self.NOISE)
        self.compare("other", *self.NOISE, "--set", "block_damp=20")
        contrasted = self.run_all((CONTRAST, "run", "other", "--out", "contrast.json"))
        self.assertIn("block_damp 20.0", contrasted)
        (found,) = json.loads((self.folder / "contrast.json").read_text())["contrasts"]
        self.assertTrue(all(f["decided_after"] is None for f in found["figures"].values()))
        self.run_all((REPORT, "run", "other", "--out", "report.html"))
        page = (self.folder / "report.html").read_text()
        self.assertIn("Each of 20 starts was played 3 times", page)
        self.assertIn("has 3 repeats of each start; must have one", self.refused(PLAN, "run"))
        plan = "{policies: [expert, bc], episodes: 4, repeats: 2, engine: [two_mass]}"
        self.sweep(plan, "policies")
        self.assertIn("has 2 repeats of each start", self.refused(MATRIX, "policies"))
        arguments = (*EXPERT, *self.NOISE, "--until-decided", "0.5")
        self.assertIn("must not be given with repeats 3", self.refused(COMPARE, *arguments))


class Equivalents(LoopCase):
    DELAYS = ", ".join(f"'mujoco:loop.action_delay={steps}'" for steps in (1, 2, 3, 4))

    def swept(self, engine: str) -> str:
        out = engine.split(":")[0]
        plan = (
            f"{{policy: expert, episodes: 40, floor: false, engine: ['{engine}', {self.DELAYS}]}}"
        )
        self.sweep(plan, out)
        return out

    def found(self, out: str) -> Tuple[float, List[float], str]:
        text = self.run_all((EQUIVALENT, out))
        (engine,) = json.loads((self.folder / out / "equivalent.json").read_text())["engines"]
        (equivalent,) = engine["equivalents"]
        self.assertEqual(equivalent["parameter"], "loop.action_delay")
        return equivalent["error"], equivalent["error_interval"], text

    def test_a_planted_delay_is_found(self) -> None:
        # An engine of another name that is the reference, two steps late.
        out = self.swept("rigid_body:loop.action_delay=2")
        error, (low, high), text = self.found(out)
        picture = self.folder / out / "sweep.png"
        self.run_all((PLOT, "--equivalents", out))
        self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
        self.run_all((REPORT, out))
        page = (self.folder / out / "report.html").read_text()
        self.assertIn("Which error of MuJoCo costs as much as an engine?", page)
        self.assertIn("[1, 3] control steps</td>", page)
        self.assertEqual((low, high), (1.0, 3.0))
        self.assertEqual(error, 2.0)
        found = re.search(
            r"loop.action_delay \+ (.*) \[1, 3\] control steps, (.*) \[100, 300\] ms", text
        )
        assert found
        self.assertAlmostEqual(100.0 * float(found[1]), float(found[2]), delta=1.0)

    def test_engines_stand_side_by_side_and_one_may_gain(self) -> None:
        # The reference is late itself. So is an engine that loses more; one that is not gains.
        late = "loop.action_delay"
        errors = [f"mujoco:{late}={steps}" for steps in (0, 2, 3)]
        engines = [f"rigid_body:{late}=2", "rigid_body", *errors]
        plan = {"policy": "expert", "episodes": 40, "floor": False, "engine": engines}
        self.sweep(json.dumps({**plan, "reference": f"mujoco:{late}=1"}), "both")
        text = self.run_all((EQUIVALENT, "both"))
        slower, gains = json.loads((self.folder / "both/equivalent.json").read_text())["engines"]
        less, more = slower["equivalents"]
        self.assertEqual((more["without"], less["without"]), (1, 1))
        self.assertEqual([level["size"] for level in more["levels"]], [1, 2, 3])
        self.assertEqual([level["size"] for level in less["levels"]], [1, 0])
        self.assertAlmostEqual(more["error"], 1.0, delta=0.5)
        self.assertEqual(more["error_interval"][0], 0.0)
        self.assertEqual((less["rises_at"], less["error"]), (1, None), "less delay gains success")
        self.assertIn("loop.action_delay: none, success rises at - 1 control steps\n", text)
        self.assertIn("(it gains success: no loss has an equivalent)", text)
        self.assertEqual({each["error"] for each in gains["equivalents"]}, {None})
        self.run_all((PLOT, "--equivalents", "both"))

    def test_an_error_that_gains_success_has_no_equivalent(self) -> None:
        errors = [f"mujoco:loop.observation_noise_position={size}" for size in (0.01, 0.2)]
        plan = {"policy": "bc", "episodes": 60, "floor": False, "engine": ["two_mass", *errors]}
        self.sweep(json.dumps(plan), "rises")
        text = self.run_all((EQUIVALENT, "rises"))
        (engine,) = json.loads((self.folder / "rises/equivalent.json").read_text())["engines"]
        (noise,) = engine["equivalents"]
        self.assertEqual(noise["rises_at"], 0.01)
        self.assertEqual((noise["error"], noise["error_interval"]), (None, None))
        self.assertIn("observation_noise_position: none, success rises at + 0.01 m\n", text)
        self.run_all((PLOT, "--equivalents", "rises"), (REPORT, "rises"))
        page = (self.folder / "rises" / "report.html").read_text()
        self.assertIn("none: success rises at + 0.01 m", page)

    def test_repeats_count_by_start(self) -> None:
        noisy = "loop.action_noise=0.2"
        engines = [f"{kind}:{noisy}" for kind in ("two_mass", "mujoco:loop.action_delay=3")]
        plan = {"policy": "expert", "episodes": 60, "repeats": 3, "floor": False, "engine": engines}
        self.sweep(json.dumps({**plan, "reference": f"mujoco:{noisy}"}), "repeated")
        self.run_all((EQUIVALENT, "repeated"))
        (engine,) = json.loads((self.folder / "repeated/equivalent.json").read_text())["engines"]
        low, high = self.load("repeated/rows/000", "metrics.json")["success_difference_interval"]
        self.assertEqual(engine["lost_interval"], [-high, -low])

    def test_refusals(self) -> None:
        self.compare("run", "--episodes", "2")
        self.assertIn("is a run", self.refused(EQUIVALENT, "run"))
        short = "policy: expert, episodes: 12, horizon: 30, floor: false"
        self.sweep(f"{{{short}, engine: [two_mass, chipmunk]}}", "engines")
        self.assertIn(
            "equivalent.json: is not there", self.refused(PLOT, "--equivalents", "engines")
        )
        self.assertIn("has no row in the reference's kind", self.refused(EQUIVALENT, "engines"))
        self.sweep(f"{{{short}, engine: [{self.DELAYS}]}}", "errors")
        self.assertIn("has no engine but the reference", self.refused(EQUIVALENT, "errors"))
        few = short.replace("12", "4")
        self.sweep(f"{{{few}, engine: [two_mass, {self.DELAYS}]}}", "few")
        self.assertIn("has 4 starts; must have at least 10", self.refused(EQUIVALENT, "few"))
        engines = f"engine: [two_mass, {self.DELAYS}]"
        both = short.replace("policy: expert", "policies: [expert, bc]")
        self.sweep(f"{{{both}, {engines}}}", "policies")
        self.assertIn("is of another policy", self.refused(EQUIVALENT, "policies"))
        self.sweep(f"{{{short}, {engines}}}", "shard", "--shard", "1/2")
        self.assertIn("merge the shards first", self.refused(EQUIVALENT, "shard"))
        self.sweep(f"{{policy: expert, episodes: 12, floor: false, {engines}}}", "whole")
        self.run_all((EQUIVALENT, "whole"))
        self.assertIn("is there already; replace it", self.refused(EQUIVALENT, "whole"))


if __name__ == "__main__":
    unittest.main()
