#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What may be concluded: yardsticks, probes, decisions and contrasts, as a user meets them."""

import csv
import json
import math
import re
import unittest
from typing import Any, Dict, List

import numpy as np
from scipy import stats  # type: ignore[import]
from pusht_testing.warm_commands import warm

from command_case import CommandCase, executable

COMPARE = executable("sim2sim_eval", "compare")
CONTRAST = executable("sim2sim_eval", "contrast")
PLAN = executable("sim2sim_eval", "plan")
PLOT = executable("sim2sim_eval", "plot_sweep")
warm([PLOT], "sim2sim_report.make", "sim2sim_eval.command")
RECOMPUTE = executable("sim2sim_eval", "recompute")
SWEEP = executable("sim2sim_eval", "sweep")
BOUND = 0.03  # m, the default
FILES = ("metrics.json", "statistics.json", "episodes.csv", "divergence.csv")
EXPERT = ("--policy", "expert")
RANDOM_OFTEN = ("--episodes", "60", *EXPERT)


class GapCase(CommandCase):
    def finished(self, program: str, *arguments: str) -> str:
        process = self.run_command(program, *arguments)
        self.assertEqual(process.returncode, 0, process.stderr)
        output: str = process.stdout
        return output

    def refused(self, program: str, *arguments: str) -> str:
        process = self.run_command(program, *arguments)
        self.assertEqual(process.returncode, 2, process.stderr)
        self.assertEqual(len(process.stderr.splitlines()), 1, process.stderr)
        message: str = process.stderr
        return message

    def bytes_of(self, out: str) -> List[bytes]:
        return [(self.folder / out / name).read_bytes() for name in FILES]

    def rows(self, out: str, mode: str) -> List[Dict[str, str]]:
        with (self.folder / out / "episodes.csv").open() as file:
            return [row for row in csv.DictReader(file) if row["mode"] == mode]

    def column(self, out: str, mode: str, name: str) -> Any:
        """NaN where there is none."""
        return np.array([float(row[name] or math.nan) for row in self.rows(out, mode)])


class Probes(GapCase):
    def test_are_the_same_whatever_the_threads_the_cache_and_the_way(self) -> None:
        run = ("--episodes", "12", "--reanchor", "1,5", *EXPERT)
        self.finished(COMPARE, *run, "--out", "one", "--threads", "1", "--record")
        self.finished(COMPARE, *run, "--out", "two", "--threads", "2", "--reference-cache", "kept")
        self.finished(COMPARE, *run, "--out", "kept-one", "--reference-cache", "kept")
        self.finished(RECOMPUTE, "one/compare.bag", "--out", "again")
        wanted = self.bytes_of("one")
        for out in ("two", "kept-one", "again"):
            self.assertEqual(self.bytes_of(out), wanted, out)
        kept = {path.suffix for path in (self.folder / "kept").rglob("*") if path.is_file()}
        self.assertEqual(kept, {".reference", ".floor_1e-9", ".floor_1e-6"})

    def test_model_variants_are_what_a_pair_of_references_measures(self) -> None:
        run = ("--episodes", "12", *EXPERT)
        variants = (
            "--model-variants",
            "timestep=5e-3,cone=elliptic",
            "--closed-variants",
            "timestep=0.005",
        )
        self.finished(COMPARE, *run, *variants, "--out", "one", "--threads", "1", "--record")
        self.finished(
            COMPARE, *run, *variants, "--out", "two", "--threads", "2", "--reference-cache", "kept"
        )
        self.finished(COMPARE, *run, *variants, "--out", "kept-one", "--reference-cache", "kept")
        self.finished(RECOMPUTE, "one/compare.bag", "--out", "again")
        wanted = self.bytes_of("one")
        for out in ("two", "kept-one", "again"):
            self.assertEqual(self.bytes_of(out), wanted, out)
        kept = {path.name.partition(".")[2] for path in (self.folder / "kept").rglob("*.*")}
        self.assertEqual(
            kept - {"reference", "floor_1e-9", "floor_1e-6"},
            {"variant_timestep=0.005", "variant_cone=elliptic", "closed_variant_timestep=0.005"},
        )

        pair = ("--reference", "mujoco", "--engine", "mujoco", "--set", "timestep=0.005")
        self.finished(COMPARE, *run, *pair, "--out", "pair")
        measured = ("steps", "mean_position_divergence_m", "mean_angle_divergence_rad")
        for mode, variant in (
            ("engine_replay", "variant_timestep=0.005"),
            ("engine_closed", "closed_variant_timestep=0.005"),
        ):
            for theirs, ours in zip(self.rows("pair", mode), self.rows("one", variant)):
                self.assertEqual(
                    [theirs[k] for k in measured], [ours[k] for k in measured], variant
                )
        self.assertGreater(self.column("one", "variant_cone=elliptic", measured[1]).mean(), 1e-5)

    def test_f47_model_variants_are_refused_with_the_rule(self) -> None:
        for argument, rule in {
            "timestep": "model variant 'timestep': must be NAME=VALUE, or several joined by ':'",
            "timestep=0.01": "model variant timestep=0.01: of the reference mujoco: must differ",
            "timestep=0.003": "timestep 0.003: must be one of: 0.01, 0.005",
            "speed=3": "parameter 'speed': unknown; known: scene, timestep",
            "timestep=0.005,timestep=5e-3": "model_variants timestep=0.005: is named twice",
            "timestep=0.005:timestep=0.001": "parameter timestep: must be set once",
            "timestep=0.005,timestep=0.005:integrator=implicit": "model_variants timestep=0.005:"
            "integrator=implicit: is the same model as timestep=0.005",
        }.items():
            self.assertIn(rule, self.refused(COMPARE, "--model-variants", argument, *EXPERT))
        swapped = ("--reference", "two_mass", "--engine", "mujoco", "--model-variants")
        self.assertIn("the reference two_mass has none;", self.refused(COMPARE, *swapped, *EXPERT))

    def test_default_variants_are_those_that_the_reference_is_not(self) -> None:
        run = ("--episodes", "2", "--no-floor", "--set-reference", "timestep=0.005", *EXPERT)
        self.finished(COMPARE, *run, "--model-variants", "--out", "out")
        probes = self.load("out", "metrics.json")["probes"]
        self.assertEqual(probes, ["variant_integrator=Euler", "variant_cone=elliptic"])

    def test_what_else_is_measured_does_not_touch_the_course(self) -> None:
        run = ("--episodes", "12", *EXPERT)
        self.finished(COMPARE, *run, "--out", "full", "--reanchor")
        self.finished(COMPARE, *run, "--out", "bare", "--no-floor")
        full, bare = (self.load(out, "metrics.json") for out in ("full", "bare"))
        self.assertEqual(full["probes"][-1], "engine_reanchored_20", "1, 5, 20 where none is named")
        self.assertEqual(bare["probes"], [])
        for key in ("mean_pos_divergence_m", "mean_ang_divergence_rad", "mj_success_rate"):
            self.assertEqual(full[key], bare[key], key)
        for mode in ("reference_closed", "engine_closed", "engine_replay"):
            bare_rows, full_rows = self.rows("bare", mode), self.rows("full", mode)
            pushes = full_rows[0].keys() - bare_rows[0].keys()
            self.assertEqual({name.partition("_")[0] for name in pushes}, {"push", "pushes"})
            for row in full_rows:
                self.assertEqual({row.pop(name) for name in pushes}, {""}, "it is never put back")
            self.assertEqual(full_rows, bare_rows)
        self.assertIsNone(bare["mean_pos_divergence_over_floor"])

    def test_yardsticks_follow_from_the_rows(self) -> None:
        self.finished(COMPARE, "--episodes", "30", "--reanchor", "1,5", *EXPERT, "--out", "out")
        metrics = self.load("out", "metrics.json")
        mean = self.column("out", "engine_replay", "mean_position_divergence_m")
        null = self.column("out", "engine_replay", "null_position_divergence_m")
        floor = self.column("out", "floor_1e-6", "mean_position_divergence_m")
        interval = metrics["mean_pos_divergence_minus_null_interval_m"]
        low, high = stats.t.interval(
            0.95, len(mean) - 1, loc=np.mean(mean - null), scale=stats.sem(mean - null)
        )
        self.assertAlmostEqual(interval[0], low, places=5)
        self.assertAlmostEqual(interval[1], high, places=5)
        self.assertEqual(metrics["mean_pos_divergence_beats_null"], bool(high < 0))
        self.assertAlmostEqual(
            metrics["mean_pos_divergence_over_floor"] * floor.mean() / mean.mean(), 1, places=4
        )
        closed = self.column("out", "engine_closed", "mean_position_divergence_m")
        absorbed = self.column("out", "engine_closed", "absorbed_position_divergence_m")
        as_long = np.array(
            [
                int(ours["steps"]) >= int(theirs["steps"])
                for ours, theirs in zip(
                    self.rows("out", "engine_closed"), self.rows("out", "reference_closed")
                )
            ]
        )
        self.assertTrue(as_long.any())
        np.testing.assert_allclose(absorbed[as_long], (mean - closed)[as_long], atol=1e-12)
        self.assertAlmostEqual(
            metrics["engine_closed_absorbed_position_divergence_m"], absorbed.mean(), places=6
        )
        each = self.column("out", "engine_reanchored_1", "anchor_position_error_m")
        five = self.column("out", "engine_reanchored_5", "anchor_position_error_m")
        self.assertTrue(np.nanmean(five) > np.nanmean(each) > 0)

    def test_partings_and_bands_count_the_rows(self) -> None:
        self.finished(COMPARE, "--episodes", "20", *EXPERT, "--out", "out")
        parted = [row for row in self.rows("out", "engine_replay") if row["parting_step"]]
        self.assertTrue(parted)
        statistics = self.load("out", "statistics.json")["rollouts"]["engine_replay"]["parting"]
        self.assertEqual(statistics["parted"]["episodes"], len(parted))
        self.assertEqual(
            sum(cause["episodes"] for cause in statistics["causes"].values()), len(parted)
        )
        self.assertEqual(self.load("out", "metrics.json")["parted"], len(parted))
        with (self.folder / "out" / "divergence.csv").open() as file:
            bands = [row for row in csv.DictReader(file) if row["mode"] == "engine_replay"]
        self.assertEqual(bands[0]["episodes"], "20")
        self.assertEqual(float(bands[0]["position_0.50_m"]), 0.0, "one start")
        counts = [int(band["episodes"]) for band in bands]
        self.assertEqual(counts, sorted(counts, reverse=True), "episodes end, none begin")
        for band in bands:
            quantiles = [float(band[f"position_{p}_m"]) for p in ("0.05", "0.50", "0.95")]
            self.assertEqual(quantiles, sorted(quantiles))

    def test_bad_input_is_refused_in_one_line(self) -> None:
        cases = {
            ("--reanchor", "0"): "reanchor 0: must be from 1 to 300 control steps",
            ("--reanchor", "5,5"): "reanchor 5: is named twice",
            ("--reanchor", "5;6"): "reanchor '5;6': must be numbers of control steps",
            ("--bound-position", "0"): "bound position 0.0: must be finite and above 0",
            ("--bound-angle", "-1"): "bound angle -1.0: must be finite and above 0",
            ("--until-decided", "1.5"): "until_decided 1.5: must be",
        }
        for arguments, reason in cases.items():
            self.assertIn(reason, self.refused(COMPARE, *arguments, "--out", "out"))
            self.assertFalse((self.folder / "out").exists())


class TooFew(GapCase):
    def test_what_cannot_be_told_is_marked(self) -> None:
        output = self.finished(COMPARE, "--episodes", "15", *EXPERT, "--out", "out")
        self.assertIsNone(self.load("out", "metrics.json")["mean_pos_divergence_beats_null"])
        self.assertIn("(?) too few episodes to compare it with that of a tee that never", output)
        self.assertNotIn("(!)", output)
        self.assertIn("differences 20", output)


class CommonHorizon(GapCase):
    def test_leads_and_has_the_same_steps_in_every_episode(self) -> None:
        run = ("--episodes", "30", "--traces", "--no-floor", *EXPERT)
        output = self.finished(COMPARE, *run, "--out", "out")
        metrics = self.load("out", "metrics.json")
        traces = np.load(self.folder / "out" / "traces.npy")
        lines = [line for line in output.splitlines() if re.match(r"  (first|whole)", line)]
        self.assertEqual(
            [line[2:11].strip() for line in lines], ["first 2 s", "first 5 s", "whole epi"]
        )
        steps = {
            int(row["episode"]): int(row["steps"]) for row in self.rows("out", "reference_closed")
        }
        self.assertLess(min(steps.values()), 50, "some episodes end before 5 s")
        for name, horizon, line in zip(("early", "early_5s"), (20, 50), lines):
            long_enough = [index for index, count in steps.items() if count >= horizon]
            position = self.column("out", "engine_replay", f"{name}_position_divergence_m")
            self.assertEqual(np.flatnonzero(~np.isnan(position)).tolist(), long_enough)
            key = f"engine_replay_{name}_position_divergence"
            self.assertEqual(metrics[f"{key}_episodes"], len(long_enough))
            self.assertEqual("(n " in line, len(long_enough) < 30, line)
            self.assertIn(f"{np.nanmean(position):.4f} m", line)
            reference, replay = (
                self.tees(traces, mode, long_enough[0])[: horizon + 1]
                for mode in (b"reference_closed", b"engine_replay")
            )
            apart = np.hypot(*(reference - replay).T).mean()
            self.assertAlmostEqual(position[long_enough[0]], apart, places=12)
            null = self.column("out", "engine_replay", f"{name}_null_position_divergence_m")
            rest = np.hypot(*(reference - reference[0]).T).mean()
            self.assertAlmostEqual(null[long_enough[0]], rest, places=12)

    def tees(self, traces: Any, mode: bytes, episode: int) -> Any:
        """Positions of the tee in a rollout."""
        rows = traces[(traces["mode"] == mode) & (traces["episode"] == episode)]
        return np.stack([rows["tee_x"], rows["tee_y"]], axis=1)


class Plan(GapCase):
    def test_is_the_normal_approximation_of_the_pilots_spread(self) -> None:
        run = (COMPARE, "--episodes", "40", *EXPERT)
        self.finished(*run, "--out", "pilot")
        self.finished(*run, "--block_damp", "60", "--out", "other")
        table = self.finished(PLAN, "pilot", "other", "--episodes", "50,200", "--position", "0.01")
        name = "mean_position_divergence_m"
        before, now = (self.column(out, "engine_replay", name) for out in ("pilot", "other"))
        z = stats.norm.ppf(0.975) + stats.norm.ppf(0.8)
        deviation = np.std(now - before, ddof=1)
        line = next(li for li in table.splitlines() if li.startswith("position") and "other" in li)
        text, needed = line[44:].split("0.01:")
        for found, episodes in zip(text.split(), (50, 200), strict=True):
            self.assertAlmostEqual(
                float(found), z * deviation / episodes**0.5, delta=0.06 * float(found)
            )
        wanted = max(20, math.ceil((z * deviation / 0.01) ** 2))
        self.assertEqual(needed.split(), [str(wanted), "episodes"])

    def test_bad_input_is_refused_before_a_line_is_printed(self) -> None:
        self.finished(COMPARE, "--episodes", "3", *EXPERT, "--out", "pilot")
        for arguments, reason in {
            ("--episodes", "10"): "episodes 10",
            ("--success", "0"): "success 0: must be above 0",
            ("--angle", "-1"): "angle -1: must be above 0",
        }.items():
            process = self.run_command(PLAN, "pilot", *arguments)
            self.assertEqual((process.returncode, process.stdout), (2, ""))
            self.assertIn(reason, process.stderr)


class UntilDecided(GapCase):
    def test_stops_at_the_same_episode_however_it_runs(self) -> None:
        run = (*EXPERT, "--episodes", "200", "--until-decided", "0.9")
        output = self.finished(COMPARE, *run, "--out", "one", "--threads", "1", "--record")
        self.finished(COMPARE, *run, "--out", "two", "--threads", "2")
        self.finished(RECOMPUTE, "one/compare.bag", "--out", "again")
        for out in ("two", "again"):
            self.assertEqual(self.bytes_of(out), self.bytes_of("one"), out)
        metrics = self.load("one", "metrics.json")
        decision = metrics["decision"]
        self.assertIn(decision["verdict"], ("keeps", "does not keep"))
        self.assertEqual(decision["episodes"], metrics["episodes"])
        self.assertLess(metrics["episodes"], 200)
        self.assertEqual(self.load("one", "status.json")["episodes"], metrics["episodes"])

        # What holds in a stopped run leads; the rest is left out.
        self.assertLess(output.index("decided after"), output.index("Does the skill transfer?"))
        table = output[output.index("decided after") :]
        self.assertEqual(table.count("["), 2, "the sequence in the answer and in its line")
        shown = re.search(r"\[([\d.]+) %, ([\d.]+) %\]", table)
        assert shown
        for end, text in zip(decision["transfer_sequence"], shown.groups()):
            self.assertAlmostEqual(float(text), 100 * end, delta=0.51)
        self.assertNotIn("McNemar", table)
        for name in ("metrics.json", "statistics.json"):
            self.assertEqual(self.intervals(self.load("one", name)), [None], name)

        # The episodes themselves are those of a run of that length.
        self.finished(COMPARE, *EXPERT, "--episodes", str(metrics["episodes"]), "--out", "as-long")
        name = "episodes.csv"
        self.assertEqual(
            (self.folder / "as-long" / name).read_bytes(),
            (self.folder / "one" / name).read_bytes(),
        )

    def intervals(self, content: Any) -> List[Any]:
        """The different intervals and p-values that a file has."""
        found: List[Any] = []
        for key, value in content.items() if isinstance(content, dict) else ():
            if re.search(r"(^|_)interval(_|$)|_p$|_beats_null$", key):
                found += [] if value in found else [value]
            else:
                found += [one for one in self.intervals(value) if one not in found]
        return found

    def test_says_when_the_episodes_do_not_decide(self) -> None:
        output = self.finished(
            COMPARE, *EXPERT, "--episodes", "3", "--until-decided", "0.5", "--out", "out"
        )
        self.assertIn("not decided after 3 episodes", output)
        decision = self.load("out", "metrics.json")["decision"]
        self.assertEqual((decision["verdict"], decision["episodes"]), ("undecided", None))


class Contrast(GapCase):
    def test_is_what_scipy_says(self) -> None:
        for damping in ("6", "60"):
            self.finished(
                COMPARE, *RANDOM_OFTEN, "--block_damp", damping, "--out", f"damp-{damping}"
            )
        output = self.finished(CONTRAST, "damp-6", "damp-60", "--out", "contrast.json")
        self.assertIn("two-mass engine, block_damp 60.0", output)
        found = json.loads((self.folder / "contrast.json").read_text())["contrasts"][0]
        figures = found["figures"]
        for mode, name, unit in (
            ("engine_replay", "mean_position_divergence", "m"),
            ("engine_replay", "mean_angle_divergence", "rad"),
            ("engine_closed", "final_position_error", "m"),
        ):
            before, now = (
                self.column(out, mode, f"{name}_{unit}") for out in ("damp-6", "damp-60")
            )
            key = {
                "mean_position_divergence": "mean_pos_divergence",
                "mean_angle_divergence": "mean_ang_divergence",
            }.get(name, f"{mode}_{name}")
            figure = figures[f"{key}_{unit}"]
            self.assertAlmostEqual(figure["difference"], np.mean(now - before), places=12)
            self.assertAlmostEqual(figure["p"], stats.ttest_rel(now, before).pvalue, places=9)
        successes = [
            {
                int(row["episode"])
                for row in self.rows(out, "engine_closed")
                if row["success"] == "true"
            }
            for out in ("damp-6", "damp-60")
        ]
        self.assertEqual(set(found["only_baseline_succeeds"]), successes[0] - successes[1])
        self.assertEqual(set(found["only_other_succeeds"]), successes[1] - successes[0])
        ps = {key: figure["p"] for key, figure in figures.items() if figure["p"] is not None}
        order = sorted(ps, key=lambda key: ps[key])
        wanted, largest = {}, 0.0
        for rank, key in enumerate(order):
            largest = max(largest, min(1.0, ps[key] * (len(ps) - rank)))
            wanted[key] = largest
        for key in ps:
            self.assertAlmostEqual(figures[key]["adjusted_p"], wanted[key], places=12)

    def test_rows_of_a_sweep_against_one_of_them(self) -> None:
        (self.folder / "plan.yaml").write_text(
            "policy: expert\nepisodes: 30\nreanchor: [5]\ngrid:\n  block_damp: [2, 6, 20]\n"
        )
        self.finished(SWEEP, "plan.yaml", "--out", "sweep")
        output = self.finished(CONTRAST, "sweep", "--against", "1", "--out", "contrast.json")
        self.assertEqual(output.count("against two-mass engine, block_damp 6.0, 30 episodes"), 2)
        self.assertIn("What does block_damp change? At every block_damp (6, 2 and 20)", output)
        self.finished(PLOT, "sweep", "--against", "1", "--out", "change.png")
        self.assertGreater((self.folder / "change.png").stat().st_size, 10_000)
        self.finished(CONTRAST, "sweep/rows/001", "sweep/rows/002", "--out", "pair.json")
        all_rows, pair = (
            json.loads((self.folder / f"{name}.json").read_text())["contrasts"]
            for name in ("contrast", "pair")
        )
        self.assertEqual(len(all_rows), 2)
        for key, figure in pair[0]["figures"].items():
            same = all_rows[1]["figures"][key]
            self.assertEqual(figure["p"], same["p"], key)
            if figure["p"] is not None:
                self.assertLessEqual(figure["adjusted_p"], same["adjusted_p"], "a larger family")
        error = pair[0]["figures"]["engine_reanchored_5_anchor_position_error_m"]
        self.assertNotEqual(error["difference"], 0.0)
        self.assertEqual([error[key] for key in ("interval", "p", "decided_after")], [None] * 3)
        (self.folder / "sweep/rows/000/metrics.json").unlink()
        self.assertIn("row 0 of 3 has not finished", self.refused(CONTRAST, "sweep"))

    def test_what_does_not_pair_is_refused(self) -> None:
        run = ("--episodes", "4", *EXPERT)
        self.finished(COMPARE, *run, "--out", "a")
        self.finished(COMPARE, *run, "--out", "seed", "--seed", "7")
        self.finished(COMPARE, "--episodes", "3", *EXPERT, "--out", "fewer")
        self.finished(COMPARE, *run, "--out", "other", "--reference", "two_mass")
        for other, reason in {
            "seed": "seed is 0 and 7",
            "fewer": "episodes is 4 and 3",
            "other": "simulators/reference",
            "nothing": "results nothing: must be the folder of a whole run or of a sweep",
        }.items():
            self.assertIn(reason, self.refused(CONTRAST, "a", other))
        self.assertIn("is one run; name two, or a sweep", self.refused(CONTRAST, "a"))
        self.assertIn(
            "against 2: must be from 0 to 1", self.refused(CONTRAST, "a", "a", "--against", "2")
        )
        rows = self.folder / "a" / "episodes.csv"
        rows.write_text(rows.read_text().replace("true", "false", 1))
        self.finished(COMPARE, *run, "--out", "b")
        self.assertIn(
            "the reference did not do the same in episode", self.refused(CONTRAST, "a", "b")
        )
        self.assertIn(
            "is there already", self.refused(CONTRAST, "b", "b", "--out", "a/metrics.json")
        )


if __name__ == "__main__":
    unittest.main()
