#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Policies as a dimension of a plan, and the matrix of policies by simulators."""

import csv
import hashlib
import json
import os
import shutil
import subprocess
import unittest
from pathlib import Path
from typing import Any, Dict, List, Optional

import rospkg  # type: ignore[import]
import torch
from pusht_testing.long_tests import LONG, long_form
from pusht_testing.warm_commands import warm

from command_case import CommandCase, executable

SWEEP = executable("sim2sim_eval", "sweep")
MERGE = executable("sim2sim_eval", "merge")
COMPARE = executable("sim2sim_eval", "compare")
PLAN_COMMAND = executable("sim2sim_eval", "plan")
MATRIX = executable("sim2sim_eval", "matrix")
PLOT = executable("sim2sim_eval", "plot_sweep")
warm([PLOT], "sim2sim_report.make", "sim2sim_eval.command")
SHIPPED = Path(rospkg.RosPack().get_path("pusht_policy"), "policies", "bc_policy.ts.pt")
OF_ROW = ("metrics.json", "episodes.csv")
OF_MATRIX = ("matrix.json", "matrix.csv")


class PartlyRandom(torch.nn.Module):
    """A policy whose action is replaced by a random one in a share of the steps.

    The draw is a hash of the observation, in whole numbers: an equal observation has an equal
    action, as a checkpoint must.
    """

    def __init__(self, policy: torch.nn.Module, share: float) -> None:
        super().__init__()
        self.policy = policy
        self.share = share
        self.unit = 2.0**-24  # of the observation; a float32 of 0.5 has this resolution
        self.prime = 2**31 - 1
        generator = torch.Generator().manual_seed(0)
        self.register_buffer("key", torch.randint(self.prime, (10, 3), generator=generator))

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        whole = (obs / self.unit).to(torch.int64).unsqueeze(2)
        uniform = (whole * self.key).sum(1) % self.prime / self.prime
        random = 2.0 * uniform[:, 1:] - 1.0
        return torch.where(uniform[:, :1] < self.share, random, self.policy(obs))


class PolicyCase(CommandCase):
    def sweep(self, plan: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
        return self.run_command(SWEEP, self.write("plan.yaml", plan.encode()), *arguments)

    def finished(self, out: str, plan: str, *arguments: str) -> Dict[str, bytes]:
        """What a sweep that must succeed has written, its provenance aside."""
        process = self.sweep(plan, "--out", out, *arguments)
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        return self.results(out)

    def results(self, out: str) -> Dict[str, bytes]:
        folder = self.folder / out
        files = [file for file in folder.rglob("*") if file.is_file()]
        return {
            str(file.relative_to(folder)): file.read_bytes()
            for file in files
            if file.name != "provenance.json"
        }

    def checkpoint(self, name: str, origin: Optional[Dict[str, Any]]) -> str:
        """The shipped network in another file, demonstrated elsewhere."""
        path = self.folder / name
        torch.jit.load(str(SHIPPED)).save(str(path))  # the bytes have the file's name
        provenance = {
            "format": 1,
            "checkpoint": {"sha256": hashlib.sha256(path.read_bytes()).hexdigest()},
            "demonstrations": {"bags": [{"origin": origin}]},
        }
        path.with_name(name + ".provenance.json").write_text(json.dumps(provenance))
        return str(path)

    def row_of_compare(self, *options: str) -> List[bytes]:
        process = self.run_command(COMPARE, *options, "--out", "compare", "--overwrite")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        return [(self.folder / "compare" / name).read_bytes() for name in OF_ROW]


HOME = {"simulators": [{"name": "chipmunk", "parameters": {"iterations": 10}, "drawn": {}}]}
PLAN = """
policies: [expert, bc]
episodes: 3
horizon: 60
engine: [two_mass, "mujoco:timestep=0.005", chipmunk]
"""


class Plans(PolicyCase):
    def test_rows_are_the_runs_of_compare(self) -> None:
        results = self.finished("out", PLAN)
        engines = (
            ["two_mass"],
            ["mujoco", "--set", "timestep=0.005"],
            ["chipmunk"],
        )
        rows = [(policy, engine) for policy in ("expert", "bc") for engine in engines]
        for row, (policy, engine) in enumerate(rows):
            options = [
                "--policy",
                policy,
                "--episodes",
                "3",
                "--horizon",
                "60",
                "--engine",
                *engine,
            ]
            self.assertEqual(
                [results[f"rows/{row:03d}/{name}"] for name in OF_ROW],
                self.row_of_compare(*options),
                rows[row],
            )
        self.assertNotIn("rows/006/metrics.json", results)
        columns = list(csv.DictReader(results["sweep.csv"].decode().splitlines()))
        self.assertEqual([row["policy"] for row in columns], ["expert"] * 3 + ["bc"] * 3)

    def test_bytes_do_not_depend_on_threads_cache_or_shards(self) -> None:
        whole = self.finished("whole", PLAN, "--threads", "1")
        cached = self.finished("cached", PLAN, "--threads", "2", "--reference-cache", "cache")
        self.assertEqual(cached, whole)
        for number in (1, 2):
            self.finished(f"shard-{number}", PLAN, "--shard", f"{number}/2")
        process = self.run_command(MERGE, "shard-1", "shard-2", "--out", "merged")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        self.assertEqual(self.results("merged"), whole)

    def test_finished_rows_are_not_run_again(self) -> None:
        whole = self.finished("out", PLAN)
        kept = self.folder / "out" / "rows" / "004" / "metrics.json"
        before = kept.stat().st_mtime_ns
        shutil.rmtree(self.folder / "out" / "rows" / "003")
        self.assertEqual(self.finished("out", PLAN), whole)
        self.assertEqual(kept.stat().st_mtime_ns, before)
        plot = self.run_command(PLOT, "out", "--out", "out.png")
        self.assert_one_line(plot, 2, "plot_sweep")
        self.assertIn("row 3: its policy is not that of row 0", plot.stderr)
        other = self.sweep(PLAN.replace("[expert, bc]", "[expert]"), "--out", "out")
        self.assert_one_line(other, 2, "sweep")
        self.assertIn("holds another sweep (", other.stderr)

    def test_home_is_where_the_demonstrations_took_place(self) -> None:
        self.checkpoint("away-2.ts.pt", HOME)
        self.checkpoint("away-1.ts.pt", {"simulator": "mujoco"})  # as the first format says it
        plan = (
            "{policies: [{files: 'away-*.ts.pt', group: away}, bc], reference: home, episodes: 2, "
            "horizon: 30, engine: [mujoco, 'chipmunk:iterations=10', chipmunk]}"
        )
        results = self.finished("out", plan)
        rows = [json.loads(results[f"rows/{row:03d}/metrics.json"]) for row in range(6)]
        found = [
            (row["policy"], row["reference_simulator"], row["engine_simulator"]) for row in rows
        ]
        wanted = [
            ("away-1.ts.pt", "mujoco", "chipmunk"),
            ("away-1.ts.pt", "mujoco", "chipmunk"),
            ("away-2.ts.pt", "chipmunk", "mujoco"),
            ("away-2.ts.pt", "chipmunk", "chipmunk"),
            ("bc", "mujoco", "chipmunk"),
            ("bc", "mujoco", "chipmunk"),
        ]
        self.assertEqual(found, wanted, "the home itself has no row")
        self.assertEqual(rows[2]["simulators"]["reference"]["parameters"]["iterations"], 10)
        self.assertEqual(rows[3]["simulators"]["engine"]["changed"], [])
        columns = list(csv.DictReader(results["sweep.csv"].decode().splitlines()))
        self.assertEqual(columns[2]["reference_simulator"], "chipmunk")
        self.assertIn("reference_successes", columns[0])
        command = ("--policy", "away-2.ts.pt", "--episodes", "2", "--horizon", "30")
        simulators = ("--reference", "chipmunk", "--set-reference", "iterations=10")
        self.assertEqual(
            [results[f"rows/002/{name}"] for name in OF_ROW],
            self.row_of_compare(*command, *simulators, "--engine", "mujoco"),
        )

    def test_a_reference_of_a_group(self) -> None:
        plan = (
            "{policies: [{files: expert, reference: chipmunk}, bc], episodes: 2, horizon: 20, "
            "engine: two_mass}"
        )
        results = self.finished("out", plan)
        references = [
            json.loads(results[f"rows/{row:03d}/metrics.json"])["reference_simulator"]
            for row in range(2)
        ]
        self.assertEqual(references, ["chipmunk", "mujoco"])

    def test_f48_refused_by_name_line_and_rule(self) -> None:
        nowhere = self.checkpoint("nowhere.ts.pt", None)
        shutil.copyfile(SHIPPED, self.folder / "twin-1.ts.pt")
        os.link(self.folder / "twin-1.ts.pt", self.folder / "twin-2.ts.pt")
        for number, other in ((1, 2), (2, 1)):
            (self.folder / f"loop-{number}.ts.pt").symlink_to(f"loop-{other}.ts.pt")
        plans = {
            "policies: 5\nengine: chipmunk": "line 1, policies: must be a list of policies",
            "policies: []\nengine: chipmunk": "line 1, policies: must be a list of policies",
            "policy: bc\npolicies: [bc]": "line 1, policy: must not be there beside policies",
            "policies:\n- none-*.pt": "line 2, policies: no file is named like 'none-*.pt'",
            "policies:\n- bc\n- bc": "line 3, policies: 'bc' must appear only once",
            "policies:\n- 'twin-*.ts.pt'\nengine: chipmunk": "line 2, policies: 'twin-2.ts.pt' is "
            "'twin-1.ts.pt' under another name; a policy must appear only once",
            "policies:\n- bc\n- twin-1.ts.pt\nengine: chipmunk": "line 3, policies: 'twin-1.ts.pt' "
            "is 'bc' under another name",
            "policies: ['loop-*.ts.pt']\nengine: chipmunk": "policy loop-1.ts.pt: must be a "
            "readable file",
            f"policies: [{300 * 'a'}.ts.pt]\nengine: chipmunk": "must be a readable file",
            "policies:\n- {group: a}": "line 2, policies: must have files",
            "policies:\n- {files: bc, seed: 1}": "line 2, seed: there is no such key; there are "
            "files, group, reference",
            "policies: [none.pt]\nengine: chipmunk": "policy none.pt: must be a readable file",
            "policies: [expert]\nreference: home": "policy expert: has no home; name its reference",
            f"policies: ['{nowhere}']\nreference: home": "must name the simulator of the "
            "demonstrations",
            "policies: [none.pt]\nreference: home": "none.pt.provenance.json",
            "policies: [bc]\nreference: home\nscene: a.xml": "line 3, scene: must not be there",
            "policies: [bc]\nengine: mujoco": "must give from 1 to 100000 rows, gives 0",
            "policies: [bc, {files: expert, reference: chipmunk}]\nengine: mujoco": "policy bc: "
            "must have an engine beside its reference, has none",
            "policies: [bc]\nengine: 'mujoco:timestep=5'": "line 2: timestep 5.0: must be",
            "policies: [bc, {files: expert, reference: chipmunk}]\nmodel_variants: [default]": ""
            "model variants: of policy expert they would be",
        }
        for plan, rule in plans.items():
            with self.subTest(plan=plan):
                process = self.sweep(plan, "--out", "out")
                self.assert_one_line(process, 2, "sweep")
                self.assertIn(rule, process.stderr)
                self.assertFalse((self.folder / "out").exists(), "nothing is begun")


class Matrices(PolicyCase):
    GROUPED = """
policies:
- {files: "one-*.ts.pt", group: one}
- expert
episodes: 20
horizon: 100
engine: [two_mass, chipmunk]
"""

    def matrix(self, *arguments: str) -> str:
        process = self.run_command(MATRIX, *arguments)
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        return process.stdout

    def test_cells_are_the_figures_of_the_rows(self) -> None:
        for seed in range(5):
            self.checkpoint(f"one-{seed}.ts.pt", {"simulator": "mujoco"})
        results = self.finished("out", self.GROUPED)
        text = self.matrix("out")
        content = self.load("out", "matrix.json")
        self.assertEqual(
            [simulator["name"] for simulator in content["simulators"]],
            ["mujoco", "two_mass", "chipmunk"],
        )
        self.assertEqual([policy["reference"] for policy in content["policies"]], [0] * 6)
        for index, policy in enumerate(content["policies"]):
            for simulator, cell in enumerate(policy["cells"]):
                row = 2 * index + max(0, simulator - 1)
                metrics = json.loads(results[f"rows/{row:03d}/metrics.json"])
                role = "engine" if simulator else "reference"
                self.assertEqual(cell["row"], f"rows/{row:03d}")
                self.assertEqual(cell["successes"], metrics[f"{role}_successes"])
                self.assertEqual(cell["success_interval"], metrics[f"{role}_success_interval"])
                if simulator:
                    self.assertEqual(cell["transfer"], metrics["transfer"])
                    self.assertEqual(cell["transfer_interval"], metrics["transfer_interval"])
                    self.assertEqual(
                        cell["divergence"]["early_position_divergence"]["value"],
                        metrics["engine_replay_early_position_divergence_m"],
                    )
                else:
                    self.assertIsNone(cell["transfer"])
        group = content["groups"][0]
        self.assertEqual((group["group"], group["policies"]), ("one", [0, 1, 2, 3, 4]))
        cell = content["policies"][0]["cells"][1]
        self.assertEqual(group["cells"][1]["success_rate"]["value"], cell["success_rate"])
        self.assertEqual(group["cells"][1]["between_policies"], 0.0, "they are one checkpoint")
        self.assertIn("one (5)", text)
        with (self.folder / "out" / "matrix.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 18)
        self.assertEqual(
            [float(row["success_rate"]) for row in rows[:3]],
            [cell["success_rate"] for cell in content["policies"][0]["cells"]],
        )

    def perturbed(self, name: str, noise: float, seed: int) -> None:
        """The shipped checkpoint with noise on its weights: the more, the worse."""
        script = torch.jit.load(str(SHIPPED))
        torch.manual_seed(seed)
        with torch.no_grad():
            for parameter in script.parameters():
                parameter.add_(noise * parameter.std() * torch.randn_like(parameter))
        script.save(str(self.folder / name))

    def good_and_bad(self, count: int) -> None:
        """Checkpoints good-N.ts.pt and bad-N.ts.pt."""
        for seed in range(count):
            self.perturbed(f"good-{seed}.ts.pt", 0.02, seed)
            self.perturbed(f"bad-{seed}.ts.pt", 0.5, seed)

    def partly_random(self, count: int) -> None:
        """Checkpoints random-N.ts.pt, N below `count`, random in N / `count` of the steps."""
        shipped = torch.jit.load(str(SHIPPED))
        shutil.copyfile(SHIPPED, self.folder / "random-0.ts.pt")
        observations = torch.rand(4000, 10, generator=torch.Generator().manual_seed(0)) - 0.5
        for number in range(1, count):
            policy = torch.jit.script(PartlyRandom(shipped, number / count).eval())
            replaced = (policy(observations) != shipped(observations)).any(dim=1)
            self.assertAlmostEqual(replaced.float().mean().item(), number / count, delta=0.03)
            policy.save(str(self.folder / f"random-{number}.ts.pt"))

    def rates(self, results: Dict[str, bytes], policies: int, engines: int) -> List[List[float]]:
        """Success rates by simulator, the reference first, and policy, counted in the episodes."""
        rates: List[List[float]] = [[] for _ in range(engines + 1)]
        for row in range(policies * engines):
            text = results[f"rows/{row:03d}/episodes.csv"].decode().splitlines()
            episodes = list(csv.DictReader(text))
            roles = {"engine_closed": 1 + row % engines}
            if row % engines == 0:
                roles["reference_closed"] = 0
            for mode, simulator in roles.items():
                won = [e["success"] == "true" for e in episodes if e["mode"] == mode]
                rates[simulator].append(sum(won) / len(won))
        return rates

    def test_a_planted_ranking_is_found_and_counted_from_the_episodes(self) -> None:
        """Random actions in 0 to 7/8 of the steps make a policy worse, here and there."""
        count, engines = (8, ["chipmunk", "two_mass"]) if LONG else (5, ["chipmunk"])
        self.partly_random(count)
        plan = (
            "{policies: [{files: 'random-*.ts.pt', group: random}], episodes: 24, horizon: 150, "
            f"engine: [{', '.join(engines)}]}}"
        )
        results = self.finished("out", plan)
        text = self.matrix("out")
        content = self.load("out", "matrix.json")
        self.assertEqual(
            [simulator["name"] for simulator in content["simulators"]],
            ["mujoco", *engines],
        )
        rates = self.rates(results, policies=count, engines=len(engines))
        for simulator in (0, 1):
            self.assertGreater(rates[simulator][0], rates[simulator][-1])
        rankings = {(r["reference"], r["test"]): r for r in content["rankings"]}
        self.assertEqual(len(rankings), len(engines) * (len(engines) + 1))
        if LONG:  # fewer policies cannot show it
            for pair in ((0, 1), (1, 0)):
                self.assertEqual(rankings[pair]["verdict"], "preserved")
                self.assertGreater(rankings[pair]["kendall"]["interval"][0], 0.0)
            self.assertRegex(text, r"\nmujoco +chipmunk .* preserved\n")
        for (reference, test), ranking in rankings.items():
            here, there = rates[reference], rates[test]
            worst = [
                max(
                    abs(here[i] - here[j]) if (there[i] > there[j]) != (here[i] > here[j]) else 0.0
                    for j in range(count)
                )
                for i in range(count)
            ]
            found = ranking["mean_maximum_rank_violation"]["value"]
            self.assertAlmostEqual(found, sum(worst) / count, places=5)
            self.assertEqual(ranking["policy_count"], count)
        group = content["groups"][0]["cells"]
        for simulator in range(len(engines) + 1):
            self.assertAlmostEqual(
                group[simulator]["success_rate"]["value"], sum(rates[simulator]) / count, places=5
            )
        self.assertAlmostEqual(
            group[1]["transfer"]["value"], sum(rates[1]) / sum(rates[0]), places=5
        )
        self.assertGreater(len(set(rates[0])), 2, "only then can this test fail")
        planned = self.run_command(PLAN_COMMAND, "out")
        self.assertEqual((planned.returncode, planned.stderr), (0, ""))
        self.assertEqual(
            len(planned.stdout.splitlines()), len(rankings) + 2, "with heading and legend"
        )
        for question in (("--success", "0.1"), ("--episodes", "7")):
            refused = self.run_command(PLAN_COMMAND, "out", *question)
            self.assert_one_line(refused, 2, "plan")
            self.assertIn("out: is a sweep over policies", refused.stderr)

    @long_form
    def test_a_planted_tie_ends_in_cannot_say(self) -> None:
        """One network in eight files; eight whose weights differ by a thousandth."""
        for number in range(8):
            self.perturbed(f"same-{number}.ts.pt", 0.0, number)
            self.perturbed(f"alike-{number}.ts.pt", 0.001, number)
        plan = (
            "{policies: [{files: 'same-*.ts.pt', group: same}, "
            "{files: 'alike-*.ts.pt', group: alike}], "
            "episodes: 24, horizon: 200, engine: chipmunk}"
        )
        rates = self.rates(self.finished("out", plan), policies=16, engines=1)
        for simulator in range(2):
            self.assertEqual(len(set(rates[simulator][:8])), 1)
            self.assertGreater(len(set(rates[simulator][8:])), 1, "they tie but for chance")
        for group in ("same", "alike"):
            with self.subTest(group):
                text = self.matrix("out", "--group", group, "--overwrite")
                self.assertRegex(text, r"\nmujoco +chipmunk .* cannot say\n")
                rankings = self.load("out", "matrix.json")["rankings"]
                self.assertEqual([r["policy_count"] for r in rankings], [8, 8])
                self.assertEqual([r["verdict"] for r in rankings], ["cannot say"] * 2)

    def test_a_matrix_of_merged_shards_has_the_bytes_of_the_whole(self) -> None:
        self.good_and_bad(5)
        plan = (
            "{policies: [{files: 'good-*.ts.pt', group: good}, {files: 'bad-*.ts.pt', group: bad}],"
            " episodes: 20, horizon: 100, floor: false, engine: chipmunk}"
        )
        self.finished("whole", plan)
        for shard in ("1", "2"):
            self.finished(f"shard-{shard}", plan, "--shard", f"{shard}/2")
        self.run_all([MERGE, "shard-1", "shard-2", "--out", "merged"])
        expected = self.write("e.yaml", b"e: {more: good, less: bad, in: chipmunk, side: above}")
        of_whole, of_merged = (
            [self.matrix(out, "--hypotheses", expected)]
            + [(self.folder / out / name).read_bytes() for name in OF_MATRIX]
            for out in ("whole", "merged")
        )
        self.assertEqual(of_merged, of_whole)
        content = self.load("whole", "matrix.json")
        self.assertIsNotNone(content["rankings"][0]["kendall"]["interval"])
        self.assertIsNotNone(content["groups"][0]["cells"][1]["success_rate"]["interval"])

    def test_hypotheses_are_tested(self) -> None:
        """A planted difference is found, its opposite contradicted; a planted tie is not shown."""
        self.good_and_bad(5)
        plan = (
            "{policies: [{files: 'good-*.ts.pt', group: good}, {files: 'bad-*.ts.pt', group: bad}],"
            " episodes: 30, horizon: 250, floor: false, engine: [chipmunk, two_mass]}"
        )
        self.finished("out", plan)
        expected = self.write(
            "expected.yaml",
            b"""
better: {more: good, less: bad, in: chipmunk, side: above}
worse: {more: good, less: bad, in: mujoco, side: below, paired: true}
same: {more: good, less: good, in: chipmunk, side: above}
alike: {more: good, less: bad, in: two_mass, figure: early_position_divergence, within: 1.0}
few: {more: good, less: bad, in: chipmunk, figure: early_position_divergence, within: 1.0}
ranked: {ranking: [good, bad], here: mujoco, there: chipmunk, side: above}
otherwise: {ranking: [good, bad], here: mujoco, there: chipmunk, side: below}
""",
        )
        text = self.matrix("out", "--hypotheses", expected)
        matrix = self.load("out", "matrix.json")
        verdicts = {h["name"]: h["verdict"] for h in matrix["hypotheses"]}
        self.assertEqual(
            verdicts,
            {
                "better": "holds",
                "worse": "contradicted",
                "same": "not shown",
                "alike": "holds",
                "few": "not shown",  # few starts carry the mean: no interval
                "ranked": "holds",
                "otherwise": "contradicted",
            },
        )
        of_all = next(r for r in matrix["rankings"] if (r["reference"], r["test"]) == (0, 1))
        ranked = next(h for h in matrix["hypotheses"] if h["name"] == "ranked")
        self.assertEqual(ranked["value"], of_all["kendall"]["value"])
        self.assertEqual(ranked["interval"], of_all["kendall"]["interval"])
        self.assertIn("hypotheses; intervals over further trainings and starts", text)
        for bad, rule in {
            "a: {more: good, less: none, in: mujoco, side: above}": "none: must be one of "
            "the matrix, ",
            "a: {more: good, less: bad, in: mars, side: above}": "simulator mars: must be one of",
            "a: {more: good, less: bad, in: mujoco, figure: luck, side: above}": "luck: must be",
            "a: {more: good, less: bad, in: mujoco}": "line 1, a: must have either side or within",
            "a: {more: good, in: mujoco, side: above}": "line 1, a: must have more, less and in",
            "a: {more: good, less: bad, in: mujoco, side: left}": "'left' must be above or below",
            "a: {more: good, less: bad, in: mujoco, within: 0}": "'0' must be a decimal number",
            "a: {ranking: [], here: mujoco, there: mars, side: above}": "must list groups",
            "a: {ranking: [bad], here: mujoco, side: above}": "must have ranking, here and there",
            "a: {ranking: [bad], here: mars, there: mujoco, side: above}": "mars: must be one of",
            "a: {ranking: [bad], more: good, side: above}": "more: there is no such key; there are",
            "[]": "must map names to hypotheses",
        }.items():
            with self.subTest(bad):
                file = self.write("bad.yaml", bad.encode())
                process = self.run_command(MATRIX, "out", "--overwrite", "--hypotheses", file)
                self.assert_one_line(process, 2, "matrix")
                self.assertIn(rule, process.stderr)

    def test_a_matrix_of_some_groups(self) -> None:
        """Its cells are those of the whole; what makes the cells differ needs two groups."""
        self.good_and_bad(2)
        plan = (
            "{policies: [expert, {files: 'good-*.ts.pt', group: good}, "
            "{files: 'bad-*.ts.pt', group: bad}], "
            "episodes: 12, horizon: 200, engine: [chipmunk, two_mass]}"
        )
        self.finished("out", plan)
        text = self.matrix("out", "--group", "good", "--group", "bad")
        self.assertIn("what makes the cells differ?", text)
        both = self.load("out", "matrix.json")
        self.matrix("out", "--group", "bad", "--overwrite")
        bad = self.load("out", "matrix.json")
        self.matrix("out", "--overwrite")
        whole = self.load("out", "matrix.json")
        self.assertEqual(both["policies"], whole["policies"][1:])
        self.assertEqual(bad["policies"], whole["policies"][3:])
        self.assertEqual(bad["spreads"], [])
        self.assertEqual(both["spreads"], whole["spreads"], "the expert has no group")
        simulators = {s["figure"]: s["simulators"] for s in both["spreads"]}
        self.assertEqual(simulators["success"], [0, 1, 2])
        self.assertEqual(simulators["early_position_divergence"], [1, 2], "away from the reference")
        for spread in both["spreads"]:
            with self.subTest(spread["figure"]):
                shares = [source["share"] for source in spread["sources"]]
                self.assertAlmostEqual(sum(shares), 1.0, places=4)
        process = self.run_command(MATRIX, "out", "--group", "none", "--overwrite")
        self.assert_one_line(process, 2, "matrix")
        self.assertIn("group none: must be one of the sweep's, ", process.stderr)

    def test_a_home_with_a_preset_is_one_column(self) -> None:
        process = self.run_command(
            COMPARE,
            "--policy",
            "expert",
            "--engine",
            "rigid_body",
            "--set",
            "preset=shaped",
            "--episodes",
            "1",
            "--horizon",
            "2",
            "--out",
            "shaped",
        )
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        engine = self.load("shaped", "metrics.json")["simulators"]["engine"]
        parameters = {name: engine["parameters"][name] for name in engine["changed"]}
        self.assertGreater(len(parameters), 1)
        home = {"simulators": [{"name": "rigid_body", "parameters": parameters, "drawn": {}}]}
        self.checkpoint("shaped.ts.pt", home)
        plan = (
            "{policies: [shaped.ts.pt, bc], reference: home, episodes: 1, horizon: 2, "
            "engine: [mujoco, 'rigid_body:preset=shaped']}"
        )
        self.finished("out", plan)
        self.matrix("out")
        names = [s["name"] for s in self.load("out", "matrix.json")["simulators"]]
        self.assertEqual(names, ["rigid_body:preset=shaped", "mujoco"])

    def test_a_matrix_that_is_there_stays(self) -> None:
        self.finished("out", "{policies: [expert], episodes: 1, horizon: 5, engine: chipmunk}")
        self.matrix("out")
        before = (self.folder / "out" / "matrix.json").read_bytes()
        again = self.run_command(MATRIX, "out")
        self.assert_one_line(again, 2, "matrix")
        self.assertIn("is there already; replace it with --overwrite", again.stderr)
        self.matrix("out", "--overwrite")
        self.assertEqual((self.folder / "out" / "matrix.json").read_bytes(), before)

    def test_f48_what_is_no_matrix_is_refused_by_name(self) -> None:
        self.finished("plain", "{policy: expert, episodes: 2, horizon: 5, rows: [{}]}")
        plan = "{policies: [expert], episodes: 2, horizon: 5, engine: [chipmunk, two_mass]}"
        self.finished("shard", plan, "--shard", "1/2")
        self.finished("damaged", plan)
        shutil.rmtree(self.folder / "damaged" / "rows" / "001")
        for folder, rule in {
            "plain": "lists no policies; a plan with the key policies is needed",
            "shard": 'is shard "1/2" of a sweep; merge the shards first',
            "damaged": "row 1 of 2 has not finished",
            "absent": "absent/sweep.json",
        }.items():
            with self.subTest(folder):
                process = self.run_command(MATRIX, folder)
                self.assert_one_line(process, 2, "matrix")
                self.assertIn(rule, process.stderr)
                self.assertFalse((self.folder / folder / "matrix.json").exists())


if __name__ == "__main__":
    unittest.main()
