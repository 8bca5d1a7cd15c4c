#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two policies from the same starts, and what a build server may require of them."""

import csv
import json
import unittest
from typing import Any, Dict, List, Tuple
from xml.etree import ElementTree

import numpy as np
from scipy import stats  # type: ignore[import]

from pusht_testing.warm_commands import warm

from command_case import CommandCase, executable

COMPARE = executable("sim2sim_eval", "compare")
CONTRAST = executable("sim2sim_eval", "contrast")
MATRIX = executable("sim2sim_eval", "matrix")
PLAN = executable("sim2sim_eval", "plan")
REPORT = executable("sim2sim_eval", "report")
SWEEP = executable("sim2sim_eval", "sweep")
warm([REPORT], "sim2sim_report.make", "sim2sim_eval.command")
MET, NOT_MET, UNDECIDED = 0, 6, 7  # exit codes


class PolicyCase(CommandCase):
    def ended(self, code: int, *command: str) -> Tuple[str, str]:
        process = self.run_command(*command)
        self.assertEqual(process.returncode, code, process.stderr)
        return process.stdout, process.stderr

    def compared(self, out: str, policy: str, *more: str, episodes: int = 40) -> str:
        count = ("--episodes", str(episodes), "--no-floor")
        return self.ended(0, COMPARE, "--policy", policy, *count, *more, "--out", out)[0]

    def successes(self, out: str, mode: str) -> Any:
        """Whether each episode succeeds."""
        with (self.folder / out / "episodes.csv").open() as file:
            rows = [row for row in csv.DictReader(file) if row["mode"] == mode]
        return np.array([row["success"] == "true" for row in rows])


class TwoPolicies(PolicyCase):
    def test_agree_with_a_program_over_their_episodes(self) -> None:
        self.compared("a", "expert")
        self.compared("b", "bc")
        output, _ = self.ended(0, CONTRAST, "a", "b", "--out", "contrast.json")
        self.assertTrue(output.startswith("Is bc better than expert? In MuJoCo bc is "), output)
        content = json.loads((self.folder / "contrast.json").read_text())
        self.assertEqual(content["baseline"]["policy"], "expert")
        found = content["contrasts"][0]
        self.assertEqual(found["policy"], "bc")
        rates: Dict[str, Dict[str, float]] = {"a": {}, "b": {}}
        for role, mode, of in (
            ("reference", "reference_closed", found["reference"]),
            ("engine", "engine_closed", found),
        ):
            before, now = self.successes("a", mode), self.successes("b", mode)
            lost, gained = np.flatnonzero(before & ~now), np.flatnonzero(now & ~before)
            self.assertEqual(of["only_baseline_succeeds"], lost.tolist())
            self.assertEqual(of["only_other_succeeds"], gained.tolist())
            self.assertEqual(of["both_succeed"], int(np.sum(before & now)))
            self.assertEqual(of["neither_succeeds"], int(np.sum(~before & ~now)))
            figure = found["figures"][f"{role}_success_rate"]
            self.assertAlmostEqual(figure["difference"], now.mean() - before.mean(), places=12)
            self.assertAlmostEqual(figure["p"], mid_p(len(lost), len(gained)), places=12)
            rates["a"][role], rates["b"][role] = before.mean(), now.mean()
        transfers = {out: rate["engine"] / rate["reference"] for out, rate in rates.items()}
        self.assertAlmostEqual(found["transfer"]["baseline"]["value"], transfers["a"], places=6)
        self.assertAlmostEqual(found["transfer"]["other"]["value"], transfers["b"], places=6)
        figure = found["figures"]["transfer"]
        self.assertAlmostEqual(figure["difference"], transfers["b"] - transfers["a"], places=12)
        low, high = figure["interval"]
        self.assertEqual(low <= 0.0 <= high, figure["p"] > 0.05)

        plan, _ = self.ended(0, PLAN, "a", "b", "--success", "0.2")
        self.assertIn("success in reference, other - pilot", plan)
        self.assertIn("success in engine, other - pilot", plan)

    def test_stand_on_one_page(self) -> None:
        self.compared("a", "fresh-untrained", episodes=12)
        self.compared("b", "expert", episodes=12)
        self.ended(0, REPORT, "a", "b", "--out", "page.html")
        page = (self.folder / "page.html").read_text()
        self.assertIn("Is expert better than fresh-untrained?", page)
        self.assertIn("There is no transfer of fresh-untrained, which never succeeds", page)
        self.assertRegex(page, r"<td>transfer</td><td class=\"number\">none</td>")
        self.assertIn("episodes in which only one succeeds", page)
        self.assertRegex(page, r"<td>reference</td><td class=\"long\">none</td>")
        self.assertIn("fresh-untrained in MuJoCo", page)

    def test_in_the_reference_alone_say_what_they_say_beside_an_engine(self) -> None:
        for out, policy in (("a", "expert"), ("b", "bc")):
            self.compared(out, policy, "--reanchor", "5", "--traces")
            printed = self.compared(f"{out}-alone", policy, "--engine", "none", "--traces")
            rows = [self.reference_rows(folder) for folder in (out, f"{out}-alone")]
            self.assertEqual(*rows)
            self.assertEqual(
                len((self.folder / f"{out}-alone/episodes.csv").read_text().splitlines()), 41
            )
            metrics, alone = (
                json.loads((self.folder / folder / "metrics.json").read_text())
                for folder in (out, f"{out}-alone")
            )
            own = {"config_hash", "knobs", "engine_simulator", "simulators", "probes"}
            for key in set(alone) - own:
                self.assertEqual(alone[key], metrics[key], key)
            self.assertFalse({key for key in alone if "transfer" in key or "divergence" in key})
            self.assertTrue(printed.count("MuJoCo") >= 2 and "transfer" not in printed, printed)
            head = (self.folder / f"{out}-alone/divergence.csv").read_text().splitlines()
            self.assertEqual(len(head), 1)
            traces = np.load(self.folder / f"{out}-alone/traces.npy")
            self.assertEqual(set(traces["mode"]), {b"reference_closed"})
        for pair in (("a", "b"), ("a-alone", "b-alone")):
            self.ended(0, CONTRAST, *pair, "--out", f"{pair[0]}.json")
        whole, alone = (
            json.loads((self.folder / f"{out}.json").read_text())["contrasts"][0]
            for out in ("a", "a-alone")
        )
        self.assertEqual(list(alone["figures"]), ["reference_success_rate"])
        figure, of_two = (found["figures"]["reference_success_rate"] for found in (alone, whole))
        self.assertLessEqual(figure.pop("adjusted_p"), of_two.pop("adjusted_p"))
        self.assertEqual(figure, of_two)
        self.assertEqual(alone["reference"], whole["reference"])
        self.assertEqual(alone["headline"].count(" In "), 0)
        plan, _ = self.ended(0, PLAN, "a-alone", "b-alone", "--success", "0.2")
        self.assertEqual(len(plan.splitlines()), 3)
        said, _ = self.ended(MET, CONTRAST, "a-alone", "b-alone", "--require", "A.reference > 0.3")
        self.assertIn("A.reference > 0.3: shown", said)
        for command, refusal in (
            ((CONTRAST, "a", "b-alone"), "one of them has no engine"),
            ((CONTRAST, "a-alone", "a-alone"), "the same policy, and no engine"),
            ((CONTRAST, "a-alone", "b-alone", "--require", "B > A"), "these runs have no engine"),
            ((PLAN, "a-alone"), "has no engine; must stand beside a run of another policy"),
            ((REPORT, "a-alone", "--out", "page.html"), "has no engine"),
        ):
            self.assertIn(refusal, self.ended(2, *command)[1])

    def reference_rows(self, out: str) -> List[Dict[str, str]]:
        """Rows of the reference's closed loop, without columns of pushes."""
        with (self.folder / out / "episodes.csv").open() as file:
            rows = [row for row in csv.DictReader(file) if row["mode"] == "reference_closed"]
        return [{key: row[key] for key in row if not key.startswith("push")} for row in rows]

    def test_in_another_engine_too_are_refused(self) -> None:
        self.compared("a", "expert", episodes=3)
        self.compared("b", "fresh-untrained", "--block_damp", "20", episodes=3)
        _, message = self.ended(2, CONTRAST, "a", "b")
        self.assertIn('policy is "expert" and "fresh-untrained", and simulators/engine', message)

    def test_of_a_sweep_are_a_pair_of_its_matrix(self) -> None:
        plan = (
            "{policies: [expert, bc], episodes: 20, floor: false, engine: [two_mass, rigid_body]}"
        )
        (self.folder / "plan.yaml").write_text(plan)
        self.ended(0, SWEEP, "plan.yaml", "--out", "sweep")
        _, message = self.ended(2, MATRIX, "sweep", "--pair", "bc", "other")
        self.assertIn("policy other: must be one of the matrix", message)
        output, _ = self.ended(0, MATRIX, "sweep", "--pair", "bc", "expert")
        self.assertIn("expert - bc", output)
        pairs = json.loads((self.folder / "sweep/matrix.json").read_text())["pairs"]
        self.assertEqual([p["simulator"] for p in pairs], ["mujoco", "two_mass", "rigid_body"])
        self.ended(0, CONTRAST, "sweep/rows/002", "sweep/rows/000", "--out", "contrast.json")
        figures = json.loads((self.folder / "contrast.json").read_text())["contrasts"][0]["figures"]
        for pair, row in zip(pairs, ("reference_success_rate", "engine_success_rate")):
            self.assertAlmostEqual(pair["difference"]["value"], figures[row]["difference"])
            self.assertEqual(pair["p"], figures[row]["p"])


class Gate(PolicyCase):
    RUN = (COMPARE, "--policy", "expert", "--episodes", "40", "--no-floor")

    def test_answers_in_words_in_exit_codes_and_for_build_servers(self) -> None:
        output, message = self.ended(MET, *self.RUN, "--require", "reference > 0.5", "--out", "a")
        self.assertIn("required: reference > 0.5: shown, ", output)
        self.assertEqual(message, "")
        more = ("--require", "engine < 90%", "--require", "engine > 0.9", "--junit", "gate.xml")
        output, message = self.ended(NOT_MET, *self.RUN, *more, "--out", "b")
        self.assertIn("1 of 2 requirements not met: engine > 0.9: shown otherwise, ", message)
        for name in ("metrics.json", "episodes.csv"):
            same = (self.folder / "b" / name).read_bytes()
            self.assertEqual(same, (self.folder / "a" / name).read_bytes(), "the run is the run")
        suite = ElementTree.parse(str(self.folder / "gate.xml")).getroot()[0]
        self.assertEqual([suite.get(n) for n in ("tests", "failures", "errors")], ["2", "1", "0"])
        self.assertEqual([t.get("name") for t in suite], ["engine < 90%", "engine > 0.9"])
        self.assertIn("shown otherwise", str(suite[1][0].get("message")))
        rate = f"{self.successes('a', 'engine_closed').mean():.6f}"
        _, message = self.ended(UNDECIDED, *self.RUN, "--require", f"engine > {rate}", "--out", "c")
        self.assertIn("starts would decide", message)

    def test_of_two_policies(self) -> None:
        self.compared("a", "fresh-untrained")
        self.compared("b", "expert")
        self.ended(MET, CONTRAST, "a", "b", "--require", "B.reference > A.reference + 0.3")
        _, message = self.ended(
            NOT_MET, CONTRAST, "b", "a", "--require", "B.reference > A.reference"
        )
        self.assertIn("shown otherwise", message)
        self.ended(MET, CONTRAST, "a", "b", "--require", "B.reference > 0.5")
        _, message = self.ended(2, CONTRAST, "a", "b", "--require", "C > A")
        self.assertIn('requirement "C > A": must name runs by their letters', message)

    def test_of_a_run_that_ends_when_it_is_decided(self) -> None:
        run = (*self.RUN[:3], "--episodes", "400", "--no-floor", "--until-decided", "0.8")
        output, _ = self.ended(NOT_MET, *run, "--require", "transfer > 0.8", "--out", "a")
        self.assertIn("decided after", output)
        _, message = self.ended(2, *run, "--require", "engine > 0.8", "--out", "b")
        self.assertIn("must be one of transfer", message)
        self.assertFalse((self.folder / "b").exists())

    def test_f57_what_cannot_be_required_is_refused_before_the_run(self) -> None:
        (self.folder / "there.xml").write_text("kept")
        require = ("--require", "transfer > 0.8")
        for more, said in (
            (("--require", "success > 0.8"), "success must be reference, engine or transfer"),
            (("--require", "transfer is 0.8"), 'must be as "transfer > 0.8"'),
            (("--require", "B > A"), "must name no run"),
            (("--junit", "gate.xml"), "must stand with --require"),
            ((*require, "--junit", "there.xml"), "junit there.xml: is there already"),
        ):
            _, message = self.ended(2, *self.RUN, *more, "--out", "out")
            self.assertIn(said, message)
            self.assertFalse((self.folder / "out").exists())
        self.assertEqual((self.folder / "there.xml").read_text(), "kept")

    def test_of_a_plan_is_asked_of_each_row(self) -> None:
        plan = (
            "{policy: expert, episodes: 30, floor: false, grid: {block_damp: [6, 20]}, require: %s}"
        )
        (self.folder / "plan.yaml").write_text(plan % "reference > 0.5")
        output, _ = self.ended(MET, SWEEP, "plan.yaml", "--out", "sweep", "--junit", "gate.xml")
        self.assertIn("required: row 1 (block_damp 20.0), reference > 0.5: shown", output)
        suite = ElementTree.parse(str(self.folder / "gate.xml")).getroot()[0]
        self.assertEqual(suite.get("tests"), "2")
        (self.folder / "plan.yaml").write_text(plan % '["reference > 0.5", "engine > 0.99"]')
        _, message = self.ended(NOT_MET, SWEEP, "plan.yaml", "--out", "sweep")
        self.assertIn("2 of 4 requirements not met: row 0 (block_damp 6.0), engine", message)
        (self.folder / "plan.yaml").write_text(plan % "engine")
        self.assertIn('requirement "engine"', self.ended(2, SWEEP, "plan.yaml", "--out", "x")[1])


class PoliciesOfAPlan(PolicyCase):
    def test_f55_one_that_is_refused_is_named_and_the_others_run(self) -> None:
        (self.folder / "bad.pt").write_text("hello")
        (self.folder / "plan.yaml").write_text(
            "{policies: [expert, bad.pt, fresh-untrained], episodes: 3, floor: false}"
        )
        _, message = self.ended(4, SWEEP, "plan.yaml", "--out", "sweep")
        self.assertIn("sweep: left out: policy bad.pt: must be TorchScript", message)
        self.assertIn("1 of 3 policies were left out, first policy bad.pt", message)
        listed = json.loads((self.folder / "sweep/sweep.json").read_text())["sweep"]["policies"]
        self.assertEqual([p["policy"] for p in listed], ["expert", "fresh-untrained"])
        self.assertEqual(len(list((self.folder / "sweep/rows").iterdir())), 2)

    def test_a_file_whose_name_reads_as_a_pattern_is_that_file(self) -> None:
        (self.folder / "run [v2].pt").write_text("hello")
        (self.folder / "plan.yaml").write_text("{policies: ['run [v2].pt'], episodes: 3}")
        _, message = self.ended(2, SWEEP, "plan.yaml", "--out", "sweep")
        self.assertIn("policy run [v2].pt: must be TorchScript", message)


def mid_p(lost: int, gained: int) -> float:
    """McNemar's mid-p."""
    coin = stats.binom(lost + gained, 0.5)
    if lost == gained:
        return 1.0 - 0.5 * float(coin.pmf(lost)) if lost else 1.0
    return 2.0 * float(coin.cdf(min(lost, gained))) - float(coin.pmf(min(lost, gained)))


if __name__ == "__main__":
    unittest.main()
