#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reports: what they say, what they refuse, and how they look and move in a browser."""

import base64
import csv
import functools
import html
import json
import logging
import math
import os
import re
import shlex
import shutil
import subprocess
import unittest
from pathlib import Path
from typing import Any, Dict, List, Tuple
from unittest import mock

import numpy as np
import rospkg  # type: ignore[import]
from selenium import webdriver  # type: ignore[import]
from selenium.webdriver.chrome.options import Options  # type: ignore[import]
from selenium.webdriver.chrome.service import Service  # type: ignore[import]
from selenium.webdriver.support.wait import WebDriverWait  # type: ignore[import]
from pusht_task.command import SIGNALS
from pusht_task.palette import DARK, LIGHT
from pusht_testing.warm_commands import warm
from sim2sim_eval.command import rosrun
from sim2sim_report.figures import Drawing
from sim2sim_report.make import make
from sim2sim_report.results import METRICS_FORMAT
from sim2sim_report.suite import Suite
from sim2sim_report.tables import CONTRASTED, contrast_rows
from sim2sim_report.words import times, transfer_percent

from command_case import CommandCase, catches, executable, until

ATTRIBUTE = executable("sim2sim_eval", "attribute")
AUDIT = executable("sim2sim_eval", "audit")
COMPARE = executable("sim2sim_eval", "compare")
RECOMPUTE = executable("sim2sim_eval", "recompute")
REPORT = executable("sim2sim_eval", "report")
MATRIX = executable("sim2sim_eval", "matrix")
SWEEP = executable("sim2sim_eval", "sweep")
EPISODES = 30
WALL_OUTSIDE = 0.41  # m, the edge of the picture
ON_TABLE = 0.39  # m, in which the pusher is seen whole
SIZES = ((1366, 768), (1920, 1080), (390, 844))  # a laptop, a screen, a phone
A4_WIDTH = 718  # px between margins
PAGES = ("run", "runs", "sweep", "ladder", "policies", "audited")
warm([REPORT], "sim2sim_report.make", "sim2sim_eval.command")
logging.getLogger("selenium").setLevel(logging.WARNING)
logging.getLogger("urllib3").setLevel(logging.WARNING)
NUMBER = r"[+-]?\d+\.\d{3,4}"


LADDER = """
{policy: expert, episodes: 24, horizon: 60, engine: rigid_body, reanchor: [5, 20],
 grid: {servo: [false, true], drag: [false, true], coulomb: [false, true]}}
"""


def program(name: str) -> str:
    path = shutil.which(name)
    assert path, f"{name} is not installed"
    return path


POLICIES = """
policies: [{files: bc, group: trained}, {files: expert, group: expert}]
episodes: 20
floor: false
engine: [two_mass, chipmunk]
"""
EXPECTED = "the expert is better: {more: expert, less: trained, in: mujoco, side: above}"


def answer_of(run: Path) -> str:
    """What the headline of a run answers."""
    statistics = json.loads((run / "statistics.json").read_text())
    return str(statistics["headline"]["answer"])


PLANTED: Dict[str, Dict[str, Any]] = {  # findings of an audit, by property
    "delay": {
        "declared": False,
        "reference": 0.0,
        "engine": 0.1,
        "difference": 0.1,
        "allowed": 0.002,
        "held_against": "resolution",
        "estimated_effect_m": 0.0123,
        "cause": "acts 1 control step late: 0.1 s between a command and the first motion",
        "look_at": "the order in which a command is taken & a step is made",
    },
    "wall_up": {
        "declared": True,
        "reference": 0.4500001,
        "engine": "none",
        "difference": "none",
        "allowed": 1.23456e-05,
        "held_against": "model variants",
        "estimated_effect_m": 0.00256,
        "cause": "there is no wall towards +y",
        "look_at": "places of the walls",
    },
}


def plant(path: Path, *planted: str) -> None:
    """Makes an audit find these, the first as its worst, and else what physics it has found."""
    audit = json.loads(path.read_text())
    by_key = {found["property"]: found for found in audit["properties"]}
    for key in audit["findings"]:
        if by_key[key]["contract"]:
            by_key[key]["verdict"] = "same"
    for key in planted:
        by_key[key].pop("reason", None)
        by_key[key].update(PLANTED[key], verdict="differs")
    others = [key for key, found in by_key.items() if found["verdict"] == "differs"]
    audit["findings"] = [*planted, *(key for key in others if key not in planted)]
    audit["contract_holds"] = "delay" not in planted
    path.write_text(json.dumps(audit))


@functools.lru_cache(maxsize=None)
def made() -> Tuple[CommandCase, str]:
    """Where the run of all tests is, and what it printed."""
    case = CommandCase()
    case.setUp()
    process = case.run_command(
        *(COMPARE, "--episodes", str(EPISODES), "--traces", "--record", "--out", "run")
    )
    assert process.returncode == 0, process.stderr
    return case, process.stdout


@functools.lru_cache(maxsize=None)
def audited() -> Path:
    """A copy of that run with its audit."""
    case, _ = made()
    folder = case.folder / "audited"
    shutil.copytree(case.folder / "run", folder)
    process = case.run_command(AUDIT, "--out", "audited/audit.json")
    assert process.returncode in (0, 5), process.stderr
    return folder


def tearDownModule() -> None:
    if made.cache_info().currsize:
        made()[0].doCleanups()


class ReportCase(CommandCase):
    """The run of all tests is made once; what tests add to it has names of its own."""

    made: "CommandCase"
    printed: str  # by the run
    run_folder: Path

    @classmethod
    def setUpClass(cls) -> None:
        cls.made, cls.printed = made()
        cls.run_folder = cls.made.folder / "run"

    def report(self, *arguments: str) -> str:
        process = self.run_command(REPORT, *arguments, "--out", "report.html", "--overwrite")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual((process.stdout, process.stderr), ("report.html\n", ""))
        return (self.folder / "report.html").read_text(encoding="utf-8")

    def page(self, *folders: str) -> str:
        """The page without its drawings, which take most of the time of a report."""
        with mock.patch.multiple(Drawing, svg=lambda *_: "<svg></svg>", width=600):
            html, _ = make([self.folder / folder for folder in folders], [], Suite(rosrun))
        return html

    def copy(self, name: str = "copy") -> Path:
        shutil.copytree(self.run_folder, self.folder / name)
        return self.folder / name

    def change(self, path: Path, **values: Any) -> None:
        content = json.loads(path.read_text())
        content.update(values)
        path.write_text(json.dumps(content))


class Content(ReportCase):
    def test_a_finding_is_what_holm_keeps(self) -> None:
        figure: Dict[str, Any] = {"difference": 0.1, "unit": "", "interval": [0.01, 0.2], "p": 0.03}
        for adjusted, is_finding in ((0.04, True), (0.06, False), (None, False)):
            figures = {key: {**figure, "adjusted_p": adjusted} for key in CONTRASTED}
            rows = contrast_rows({"title": "", "figures": figures})["rows"]
            self.assertEqual([row["finding"] for row in rows], [is_finding] * len(CONTRASTED))

    def test_figures_are_those_of_the_terminal(self) -> None:
        page = html.unescape(self.report(str(self.run_folder)))
        table = self.printed[: self.printed.index("results:")]
        figures = re.findall(rf"{NUMBER}(?: m| rad)?(?: \[{NUMBER}, {NUMBER}\])(?: \(!\))?", table)
        self.assertGreaterEqual(len(figures), 11)
        figures += re.findall(r"\d+ times|McNemar p \S+", table)
        for figure in figures:
            self.assertIn(figure, page)
        parted = re.search(r"beyond the bound +(\d+ of \d+), half by (\S+ s)", table)
        assert parted
        self.assertIn(f"In open loop {parted[1]} episodes leave", page)
        self.assertIn(f"Half of all have left it by {parted[2]}.", page)
        transfer = re.search(r"\d+ % \[.*?\]", table)
        counts = re.search(
            r"both (\d+), reference only (\d+) +engine only (\d+), neither (\d+)", table
        )
        assert transfer and counts
        self.assertIn(transfer[0], page)
        cells = re.search(
            r'"both">(\d+)<.*?"lost">(\d+)<.*?"won">(\d+)<.*?"neither">(\d+)<', page, re.DOTALL
        )
        assert cells
        self.assertEqual(cells.groups(), counts.groups())

    def test_doubts_name_their_horizon(self) -> None:
        position, angle = (
            f"engine_replay_early_{name}_divergence" for name in ("position", "angle")
        )
        changed: Dict[str, Any] = {
            f"{position}_beats_null": True,
            f"{position}_minus_null_interval_m": [-0.02, -0.01],
            f"{angle}_beats_null": False,
            f"{angle}_minus_null_interval_rad": [0.03, 0.29],
            "mean_pos_divergence_beats_null": None,
            "mean_pos_divergence_minus_null_interval_m": None,
            "mean_ang_divergence_beats_null": False,
            "mean_ang_divergence_minus_null_interval_rad": [-0.1, 0.3],
        }
        self.change(self.copy() / "metrics.json", **changed)
        doubt = r"\([!?]\) In \w+, over [^<]+ that tee\."
        of_whole = [
            "(?) In position, over the whole episode, there are too few episodes to compare it "
            "with that tee.",
            "(!) In angle, over the whole episode, it is not shown to be nearer than that tee.",
        ]
        self.assertEqual(
            re.findall(doubt, html.unescape(self.page("copy"))),
            ["(!) In angle, over the first 2 s, it is farther away than that tee.", *of_whole],
        )
        changed = {
            f"{key}_{figure}": value
            for key, unit in ((position, "m"), (angle, "rad"))
            for figure, value in (
                ("episodes", 0),
                ("beats_null", None),
                (f"minus_null_interval_{unit}", None),
            )
        }
        self.change(self.folder / "copy" / "metrics.json", **changed)
        self.assertEqual(
            re.findall(doubt, html.unescape(self.page("copy"))), of_whole, "none lasts 2 s"
        )

    def test_is_one_file_with_the_same_bytes_again(self) -> None:
        page = self.report(str(self.run_folder))
        self.assertEqual(page, self.report(str(self.run_folder)))
        self.assertLess(len(page), 3_000_000)
        self.assertEqual(re.findall(r'(?:src|href)="(?!#)[^"]*"', page), [])
        self.assertEqual(re.findall(r"url\((?!#|data:)", page), [])
        ids = re.findall(r'\bid="([^"]+)"', page)
        self.assertEqual(len(ids), len(set(ids)))

    def test_bag_and_traces_give_the_same_report(self) -> None:
        page = self.report(str(self.run_folder))
        (self.copy("run") / "traces.npy").unlink()
        self.assertEqual(page, self.report("run"))

    def test_run_without_states_has_no_animation(self) -> None:
        folder = self.copy()
        (folder / "traces.npy").unlink()
        (folder / "compare.bag").unlink()
        page = self.page("copy")
        self.assertIn("neither traces.npy nor compare.bag", page)
        self.assertNotIn("<canvas", page)

    def test_part_of_a_run(self) -> None:
        folder = self.copy()
        for name in ("metrics.json", "statistics.json", "divergence.csv", "traces.npy"):
            (folder / name).unlink()
        (folder / "compare.bag").unlink()
        status = {"episodes_finished": EPISODES, "episodes": 2000, "exit_code": 4}
        reason = f"interrupted after {EPISODES} of 2000 episodes"
        self.change(folder / "status.json", reason=reason, **status)
        page = html.unescape(self.report("copy"))
        said = f"Not a whole run: {EPISODES} of 2000 episodes; interrupted after"
        self.assertIn(said, page[: page.index("<h1>")])
        self.assertEqual(page.count('<tr><td class="number">'), EPISODES)
        self.assertNotIn("<svg", page, "no figures")
        self.change(folder / "status.json", episodes_finished=0)
        process = self.run_command(REPORT, "copy", "--out", "none.html")
        self.assert_one_line(process, 2, "report")
        self.assertIn("no episode has finished", process.stderr)
        (folder / "episodes.journal").touch()  # as a killed run leaves it
        process = self.run_command(REPORT, "copy", "--out", "none.html")
        self.assert_one_line(process, 2, "report")
        self.assertIn("was killed; run the same command again", process.stderr)

    def test_traces_have_the_same_bytes_from_a_bag_and_for_any_number_of_threads(self) -> None:
        run = (COMPARE, "--episodes", str(EPISODES), "--traces", "--threads")
        for threads in ("1", "3"):
            self.assertEqual(
                self.run_command(*run, threads, "--out", threads).returncode, 0, threads
            )
        bag = str(self.run_folder / "compare.bag")
        process = self.run_command(RECOMPUTE, bag, "--traces", "--out", "bag")
        self.assertEqual(process.returncode, 0, process.stderr)
        expected = (self.run_folder / "traces.npy").read_bytes()
        for folder in ("1", "3", "bag"):
            self.assertEqual((self.folder / folder / "traces.npy").read_bytes(), expected, folder)

    def test_states_of_traces_give_the_divergence_of_the_table(self) -> None:
        traces = np.load(self.run_folder / "traces.npy")
        means = []
        for episode in range(EPISODES):
            own = traces[traces["episode"] == episode]
            a, b = (own[own["mode"] == m] for m in (b"reference_closed", b"engine_replay"))
            means.append(np.hypot(a["tee_x"] - b["tee_x"], a["tee_y"] - b["tee_y"]).mean())
            self.assertTrue(np.isnan(a["action_x"][-1]) and not np.isnan(a["action_x"][:-1]).any())
        metrics = json.loads((self.run_folder / "metrics.json").read_text())
        self.assertAlmostEqual(np.mean(means), metrics["mean_pos_divergence_m"], places=6)

    def test_several_runs_stand_side_by_side(self) -> None:
        process = self.run_command(
            *(COMPARE, "--episodes", str(EPISODES), "--engine", "chipmunk", "--out", "other")
        )
        self.assertEqual(process.returncode, 0, process.stderr)
        page = html.unescape(self.report(str(self.run_folder), "other", "--images", "images"))
        self.assertIn("Pair by pair, against two-mass engine", page)
        self.assertIn('id="run1"', page)
        for run, out in ((self.run_folder, "run0"), (self.folder / "other", "run1")):
            self.assertIn(answer_of(run), page[: page.index("<main>")], out)
        contrast = self.run_command(
            executable("sim2sim_eval", "contrast"), str(self.run_folder), "other"
        ).stdout
        row = re.search(rf"engine_success_rate +({NUMBER} \[{NUMBER}, {NUMBER}\])", contrast)
        assert row
        self.assertIn(row[1], page)
        images = {path.name for path in (self.folder / "images").iterdir()}
        drawn = {"success"} | {
            f"{n}-{f}" for n in "01" for f in ("yardsticks", "divergence", "causes")
        }
        self.assertEqual(images, {f"{name}.{kind}" for name in drawn for kind in ("png", "pdf")})

    def test_sweep(self) -> None:
        (self.folder / "plan.yaml").write_text(
            "{policy: expert, episodes: 20, grid: {block_damp: [2, 20]}}"
        )
        process = self.run_command(SWEEP, "plan.yaml", "--out", "sweep")
        self.assertEqual(process.returncode, 0, process.stderr)
        page = self.report("sweep")
        self.assertIn('<span class="question">', page)
        for number in ("000", "001"):
            answer = answer_of(self.folder / "sweep" / "rows" / number)
            self.assertIn(answer, html.unescape(page))
        self.assertEqual(page.count("<svg"), 4, "two figures, wide and narrow")
        self.assertNotIn("attribute sweep", page)
        self.report("sweep", "--images", "images")
        names = {f"{name}.{kind}" for name in ("curves", "pairs") for kind in ("png", "pdf")}
        self.assertEqual(self.files("images"), names)
        self.assertIn("Pair by pair, against two-mass engine, block_damp 2.0", page)
        rows = json.loads((self.folder / "sweep" / "sweep.json").read_text())["rows"]
        for row in rows:
            self.assertIn(f"{row['mean_pos_divergence_m']:.4f}", page)

    def test_cause(self) -> None:
        (self.folder / "ladder.yaml").write_text(LADDER)
        process = self.run_command(SWEEP, "ladder.yaml", "--out", "ladder")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("rosrun sim2sim_eval attribute ladder", self.report("ladder"))
        (self.folder / "base.yaml").write_text(
            "{policy: expert, episodes: 24, horizon: 60, reanchor: [5, 20], rows: [{}]}"
        )
        self.run_all(
            (SWEEP, "base.yaml", "--out", "base"),
            (ATTRIBUTE, "ladder", "--baseline", "base/rows/000"),
        )
        page = html.unescape(self.report("ladder", "--images", "images"))
        self.assertIn("What closes the gap in position: ", page)
        gaps = json.loads((self.folder / "ladder" / "attribution.json").read_text())["gaps"]
        for gap in gaps.values():
            self.assertIn(f"<h3>{gap['title']}", page)
            for name, found in gap["switches"].items():
                ends = found["share_interval"]
                text = f"{found['share']:+.4f}" if found["share"] > 0 else f"{found['share']:.4f}"
                if ends:
                    text += f" [{ends[0]:.4f}, {ends[1]:.4f}]"
                self.assertIn(text, page, name)
                ends = found["part_interval"]
                if ends:
                    self.assertIn(f" % [{100 * ends[0]:.0f}, {100 * ends[1]:.0f}]", page, name)
            if gap["baseline"]["value"] is not None:
                self.assertIn("<td>baseline: two-mass engine</td>", page)
                self.assertIn(f"{gap['baseline']['value']:.4f} [", page)
        self.assertIn("success: part of the gap", page)
        images = {path.name for path in (self.folder / "images").iterdir()}
        kinds = ("png", "pdf")
        drawn = {f"{name}.{kind}" for name in ("shares", "staircase") for kind in kinds}
        self.assertEqual(images, drawn)
        self.assert_damage_refused("ladder", "attribution.json")

    def assert_damage_refused(self, folder: str, name: str) -> None:
        """A result file that is empty, no object, of another format or without its figures."""
        for damage in (b"", b"[1]", b'{"format": 99}', b'{"format": 1}'):
            (self.folder / folder / name).write_bytes(damage)
            process = self.run_command(REPORT, folder, "--out", "no.html")
            self.assert_one_line(process, 2, "report")
            self.assertIn(name, process.stderr)

    def test_matrix(self) -> None:
        """The figures of the terminal, for each policy and simulator."""
        self.write("policies.yaml", POLICIES.encode())
        self.write("expected.yaml", EXPECTED.encode())
        printed = self.run_all(
            (SWEEP, "policies.yaml", "--out", "policies"),
            (MATRIX, "policies", "--hypotheses", "expected.yaml"),
        )
        page = html.unescape(self.report("policies", "--images", "images")).replace("\u00a0", " ")
        cells = re.findall(r"\d\.\d\d \[\d\.\d\d, \d\.\d\d\]", printed)
        self.assertEqual(len(cells), 12, "of policies, and of groups of one")
        for cell in cells:
            self.assertIn(f">{cell}<", page)
        for transfer in re.findall(r"\d+ % \[\d+, \d+\]", printed):
            self.assertIn(f"<br>{transfer}<", page)
        self.assertIn("<td>the expert is better</td>", page)
        drawn = {f"{name}.{kind}" for name in ("matrix", "rankings") for kind in ("png", "pdf")}
        self.assertEqual(self.files("images"), drawn)
        self.assert_damage_refused("policies", "matrix.json")

    def test_text_of_others_is_text(self) -> None:
        folder = self.copy()
        evil = '</script><img src=x onerror="alert(1)"> $\\x$'
        metrics = json.loads((folder / "metrics.json").read_text())
        metrics["simulators"]["engine"]["title"] = evil
        metrics["policy"] = evil
        self.change(folder / "metrics.json", **metrics)
        provenance = json.loads((folder / "provenance.json").read_text())
        provenance["configuration"].update(policy=evil, simulators=metrics["simulators"])
        self.change(folder / "provenance.json", **provenance)
        page = self.report("copy")
        self.assertNotIn(evil, page)
        self.assertNotIn("<img", page)
        self.assertIn("onerror", page, "it is shown, as text")

    def test_transfer_stands_on_its_side_of_each_bound(self) -> None:
        printed = [transfer_percent(share) for share in (0.5, 0.4996, 0.496, 0.494, 0.8999, 1.1)]
        self.assertEqual(printed, ["50 %", "49.96 %", "49.6 %", "49 %", "89.99 %", "110 %"])

    def test_multiples_have_two_digits_and_no_exponent(self) -> None:
        self.assertEqual(times(99.6, [2e-5, 416.0]), "100 times [0.00002, 420]")
        self.assertEqual(times(1.26, None), "1.3 times")

    def test_rare_runs(self) -> None:
        """Each with what its page must say."""
        (self.folder / "starts.csv").write_text(
            "pusher_x,pusher_y,tee_x,tee_y,tee_yaw\n-0.2,0.0,-0.1,0.05,0.3\n"
        )
        runs = {
            "--smoke": "The policy is untrained",
            "--policy fresh-untrained --episodes 20": "The policy is untrained",
            "--policy expert --episodes 1 --starts starts.csv": "(?) In position, over the whole "
            "episode, there are too few",
            "--policy expert --episodes 20 --no-floor --reanchor 1,5": "made in 5 steps",
            "--until-decided 0.8999 --episodes 60": "does not keep 89.99 % of the success",
            "--reference two_mass --policy expert --episodes 20": "two-mass engine",
            "--policy expert --set block_damp=20 --set baumgarte=70": "baumgarte",
            "--policy expert --episodes 5 --engine rigid_body": "rigid-body",  # 2e-06 m apart
        }
        for number, (options, said) in enumerate(runs.items()):
            with self.subTest(options):
                out = str(number)
                process = self.run_command(COMPARE, *options.split(), "--traces", "--out", out)
                self.assertEqual(process.returncode, 0, process.stderr)
                page = html.unescape(self.page(out))
                self.assertIn(said, page)
                for pushes in re.findall("in the mean episode .*", process.stdout):
                    self.assertIn(f">{pushes}<", page, "as the command prints it")

    def test_command_makes_the_run_again(self) -> None:
        options = ["--set", "block_damp=20.5", "--reanchor", "5", "--bound-angle", "0.123456789"]
        options += ["--episodes", "12", "--first-episode", "4", "--seed", "4", "--no-floor"]
        options += ["--horizon", "200", "--noise-seed", "7", "--repeats", "2"]
        options += ["--independent-noise", "--set", "loop.observation_noise_position=0.002"]
        process = self.run_command(COMPARE, *options, "--out", "run")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.made_again(self.command("run")[0])

    def command(self, out: str) -> Tuple[List[str], str]:
        """The words of the command that makes a run again, and the page."""
        page = self.page(out)
        command = re.search(r'<pre class="command">(.*?)</pre>', page, re.DOTALL)
        assert command
        return shlex.split(html.unescape(command[1])), page

    def made_again(self, words: List[str]) -> None:
        self.assertEqual(words[:3], ["rosrun", "sim2sim_eval", "compare"])
        process = self.run_command(COMPARE, *words[3:], "--out", "again")
        self.assertEqual(process.returncode, 0, process.stderr)
        for name in ("metrics.json", "episodes.csv"):
            again = (self.folder / "again" / name).read_bytes()
            self.assertEqual(again, (self.folder / "run" / name).read_bytes(), name)

    def test_command_names_a_scene_by_its_file(self) -> None:
        scenes = Path(rospkg.RosPack().get_path("pusht_mujoco"), "scenes")
        shutil.copy(scenes / "pusht.xml", self.folder / "my scene.xml")
        options = ["--policy", "expert", "--episodes", "2", "--scene", "my scene.xml"]
        process = self.run_command(COMPARE, *options, "--out", "run")
        self.assertEqual(process.returncode, 0, process.stderr)
        words, page = self.command("run")
        self.assertIn("scene=my scene.xml", words)
        self.assertIn("scene my scene.xml had the checksum sha256:", page)
        self.made_again(words)


class Audited(ReportCase):
    """The section of an audit."""

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.run_folder = audited()

    def setUp(self) -> None:
        super().setUp()
        self.audit_path = self.copy() / "audit.json"
        self.plant("delay", "wall_up")

    def plant(self, *planted: str) -> None:
        plant(self.audit_path, *planted)
        self.audit = json.loads(self.audit_path.read_text())

    def refused(self) -> str:
        process = self.run_command(REPORT, "copy", "--out", "no.html")
        self.assert_one_line(process, 2, "report")
        self.assertFalse((self.folder / "no.html").exists())
        self.assertIn("copy/audit.json: ", process.stderr)
        return process.stderr

    def section(self) -> str:
        page = self.page("copy")
        found = re.search(r'<section class="card audit">.*?</section>', page, re.DOTALL)
        assert found
        return html.unescape(found[0])

    def test_shows_every_finding_and_every_property(self) -> None:
        section = self.section()
        by_key = {found["property"]: found for found in self.audit["properties"]}
        self.assertEqual(self.audit["findings"][:2], ["delay", "wall_up"])
        rows = re.findall(r"<tr><td class=\"number\">\d+</td>.*?</tr>", section)
        self.assertEqual(len(rows), len(self.audit["findings"]))
        for rank, (key, row) in enumerate(zip(self.audit["findings"], rows), 1):
            with self.subTest(key):
                finding = by_key[key]
                self.assertIn(f">{rank}<", row)
                kind = "contract" if finding["contract"] else "physics"
                self.assertIn(f">{kind}{', declared' * finding['declared']}<", row)
                for name in ("cause", "look_at", "title", "held_against"):
                    self.assertIn(finding[name], row)
                for name in ("reference", "engine", "allowed"):
                    value = finding[name]
                    text = value if value == "none" else f"{value:.4g} {finding['unit']}".strip()
                    self.assertIn(f">{text}<", row)
                self.assertIn(f">{1e3 * finding['estimated_effect_m']:.2g} mm<", row)
        folded = section[section.index("<details>") : section.index("</details>")]
        for found in self.audit["properties"]:
            self.assertIn(f">{found['title']}</td><td>{found['verdict']}</td>", folded)
            self.assertIn(found.get("reason", found.get("held_against")), folded)
        for verdict, words in (("same", "are the same"), ("differs", "differ")):
            count = sum(found["verdict"] == verdict for found in self.audit["properties"])
            self.assertIn(f"{count} {'properties ' * (verdict == 'same')}{words}", section)

    def test_broken_contract_is_a_caution(self) -> None:
        page = html.unescape(self.page("copy"))
        self.assertIn("<b>The contract is broken: 1 error.</b>", page)
        said = "The audit says that the contract is broken (delay of actions). Every figure"
        self.assertIn(said, page[: page.index("See it")])
        declared = self.audit_path.read_text().replace('"declared": false', '"declared": true')
        self.audit_path.write_text(
            declared.replace('"contract_holds": false', '"contract_holds": true')
        )
        self.assertIn("<b>No error of the contract.</b>", self.page("copy"), "on purpose")
        self.plant("wall_up")
        page = self.page("copy")
        self.assertIn("<b>No error of the contract.</b>", page)
        self.assertNotIn("contract is broken", page)

    def test_part_of_a_run_has_it(self) -> None:
        folder = self.folder / "copy"
        for name in ("metrics.json", "traces.npy", "compare.bag"):
            (folder / name).unlink()
        self.change(folder / "status.json", episodes_finished=EPISODES, episodes=2000, exit_code=4)
        self.assertIn("acts 1 control step late", self.section())

    def test_run_without_one_has_no_section(self) -> None:
        self.audit_path.unlink()
        page = self.page("copy")
        self.assertNotIn("<h2>Audit</h2>", page)

    def test_several_runs_have_their_own(self) -> None:
        plant(self.copy("other") / "audit.json", "wall_up")
        page = self.page("copy", "other")
        self.assertEqual(page.count("<h2>Audit</h2>"), 2)
        self.assertEqual(page.count("acts 1 control step late"), 1)

    def test_another_pair_is_refused_by_name(self) -> None:
        for arguments, pair in (
            (("--set", "block_damp=20"), "two_mass with block_damp 20.0 against mujoco"),
            (("--engine", "mujoco"), "mujoco against mujoco"),
            (("--against", "task"), "two_mass against the task"),
        ):
            with self.subTest(pair):
                process = self.run_command(
                    *(AUDIT, "--out", "copy/audit.json", "--overwrite", *arguments)
                )
                self.assertIn(process.returncode, (0, 5), process.stderr)
                wanted = f"is of {pair}: must be of the run's two_mass against mujoco; "
                self.assertIn(wanted, self.refused())

    def test_damaged(self) -> None:
        text = self.audit_path.read_text()
        foreign = {**self.audit, "format": 99}
        contradicts = {**self.audit, "contract_holds": not self.audit["contract_holds"]}
        for damage in (
            *("", "[1]", text[: len(text) // 2], '{"format": 99}', '{"format": 1}'),
            *(json.dumps(foreign), json.dumps(contradicts)),
            text.replace('"verdict"', '"other"'),
            text.replace('"look_at"', '"other"'),
            text.replace('"simulators"', '"other"'),
            text.replace('"differs"', '"is other"'),
            json.dumps({**self.audit, "findings": ["nothing"]}),
            json.dumps({**self.audit, "findings": 7}),
            json.dumps({**self.audit, "properties": {}}),
            text.replace('"allowed": ', '"allowed": [], "was": '),
            text.replace('"seed": 0', '"seed": NaN'),
        ):
            with self.subTest(damage[:60]):
                self.assertNotEqual(damage, text)
                self.audit_path.write_text(damage)
                self.refused()

    def test_text_of_others_is_text(self) -> None:
        evil = '</script><img src=x onerror="alert(1)">'
        for found in self.audit["properties"]:
            if found["property"] == "wall_up":
                found.update(cause=evil, look_at=evil, title=evil, unit=evil, area=evil)
        self.audit_path.write_text(json.dumps(self.audit))
        page = self.page("copy")
        self.assertNotIn("<img", page)
        self.assertGreater(page.count("onerror"), 5, "it is shown, as text")


class Refusals(ReportCase):
    another_format = f"format {METRICS_FORMAT - 1}: must be {METRICS_FORMAT}"

    def refused(self, *arguments: str, code: int = 2) -> str:
        process = self.run_command(REPORT, *arguments, "--out", "refused.html")
        self.assert_one_line(process, code, "report")
        self.assertFalse(list(self.folder.glob("refused*")), "nothing is written")
        return process.stderr

    def test_traces_with_more_than_an_array(self) -> None:
        path = self.copy() / "traces.npy"
        with path.open("ab") as file:
            file.write(b"more")
        self.assertIn("traces.npy: must end after its array", self.refused("copy"))
        os.truncate(path, 3 << 30)
        self.assertIn("traces.npy: has 3221225472 bytes, must have at most", self.refused("copy"))

    def test_what_is_no_run(self) -> None:
        self.assertIn("none/metrics.json: no such file", self.refused("none"))
        (self.folder / "empty").mkdir()
        self.assertIn("empty/metrics.json: no such file", self.refused("empty"))
        self.assertIn("DIR", self.refused())

    def test_damaged_files(self) -> None:
        names = ("metrics.json", "statistics.json", "provenance.json", "episodes.csv")
        for name in (*names, "divergence.csv", "traces.npy"):
            for damage in ("half", "empty", "foreign"):
                with self.subTest(name=name, damage=damage):
                    folder = self.copy()
                    content = (folder / name).read_bytes()
                    damaged = {
                        "half": content[: len(content) // 2],
                        "empty": b"",
                        "foreign": b"[1]\n",
                    }
                    (folder / name).write_bytes(damaged[damage])
                    self.assertIn(
                        f"copy/{name}" if name != "traces.npy" else "copy", self.refused("copy")
                    )
                    shutil.rmtree(folder)

    def test_files_of_different_runs(self) -> None:
        process = self.run_command(
            *(COMPARE, "--episodes", str(EPISODES), "--seed", "7", "--traces", "--record"),
            *("--out", "other"),
        )
        self.assertEqual(process.returncode, 0, process.stderr)
        names = ("episodes.csv", "traces.npy", "compare.bag", "provenance.json")
        for name in (*names, "statistics.json", "divergence.csv"):
            with self.subTest(name):
                folder = self.copy()
                if name == "compare.bag":
                    (folder / "traces.npy").unlink()
                shutil.copy(self.folder / "other" / name, folder / name)
                self.refused("copy")
                shutil.rmtree(folder)

    def test_missing_keys_and_columns(self) -> None:
        for name, damage in {
            "metrics.json": lambda text: text.replace('"transfer"', '"other"'),
            "statistics.json": lambda text: text.replace('"parting"', '"other"'),
            "episodes.csv": lambda text: text.replace("parting_step", "other"),
            "divergence.csv": lambda text: text.replace("angle_0.50_rad", "other"),
            "provenance.json": lambda text: text.replace('"probes"', '"other"'),
        }.items():
            with self.subTest(name):
                path = self.copy() / name
                path.write_text(damage(path.read_text()))
                self.refused("copy")
                shutil.rmtree(path.parent)

    def test_run_that_has_not_ended_well(self) -> None:
        folder = self.copy()
        (folder / "metrics.json").unlink()
        (folder / "status.json").unlink()
        self.assertIn("the folder of a whole run is needed", self.refused("copy"))

    def test_unfinished_sweep(self) -> None:
        plan = "{policy: expert, episodes: 2, grid: {block_damp: [2, 20]}}"
        (self.folder / "plan.yaml").write_text(plan)
        process = self.run_command(SWEEP, "plan.yaml", "--out", "sweep")
        self.assertEqual(process.returncode, 0, process.stderr)
        rows = self.load("sweep", "sweep.json")["rows"]
        self.change(self.folder / "sweep" / "sweep.json", rows=rows[:1])
        self.assertIn("sweep: is unfinished: 1 of 2 rows", self.refused("sweep"))

    def test_another_format(self) -> None:
        folder = self.copy()
        self.change(folder / "metrics.json", format=METRICS_FORMAT - 1)
        self.assertIn(f"metrics.json: {self.another_format}", self.refused("copy"))

    def test_sweep_of_another_format(self) -> None:
        rows = "[{}, {block_damp: 20}]"
        (self.folder / "plan.yaml").write_text(f"{{policy: expert, episodes: 2, rows: {rows}}}")
        process = self.run_command(SWEEP, "plan.yaml", "--out", "sweep")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.change(self.folder / "sweep" / "sweep.json", sweep={"format": METRICS_FORMAT - 1})
        self.assertIn(f"sweep.json: {self.another_format}", self.refused("sweep"))

    def test_runs_that_do_not_pair(self) -> None:
        process = self.run_command(COMPARE, "--episodes", "10", "--out", "short")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("short", self.refused(str(self.run_folder), "short"))

    def test_damaged_bag(self) -> None:
        folder = self.copy()
        (folder / "traces.npy").unlink()
        bag = (folder / "compare.bag").read_bytes()
        (folder / "compare.bag").write_bytes(bag[: len(bag) // 2])
        self.assertIn("compare.bag", self.refused("copy"))

    def test_bad_options(self) -> None:
        self.assertIn(
            "animate 30: must be from 0 to 29",
            self.refused(str(self.run_folder), "--animate", "30"),
        )
        self.assertIn(
            "must be episodes like 7,12", self.refused(str(self.run_folder), "--animate", "x")
        )

    def test_file_that_is_there_stays(self) -> None:
        folder = self.copy()
        before = (folder / "metrics.json").read_bytes()
        for options in ((), ("--overwrite",)):
            process = self.run_command(REPORT, "copy", "--out", "copy/metrics.json", *options)
            self.assert_one_line(process, 2, "report")
            self.assertIn("out copy/metrics.json: is there already", process.stderr)
        self.assertEqual((folder / "metrics.json").read_bytes(), before)
        self.assertEqual(self.run_command(REPORT, "copy").returncode, 0)
        process = self.run_command(REPORT, "copy")
        self.assert_one_line(process, 2, "report")
        self.assertIn("out copy/report.html: is there already", process.stderr)
        self.assertEqual(self.run_command(REPORT, "copy", "--overwrite").returncode, 0)
        (folder / "report.html").unlink()
        (folder / "report.html").symlink_to("metrics.json")
        self.assert_one_line(self.run_command(REPORT, "copy", "--overwrite"), 2, "report")

    def test_images_that_are_there_stay(self) -> None:
        self.write("success.png", b"mine")
        images = (str(self.run_folder), "--images", ".")
        for options in ((), ("--overwrite",)):
            self.assertIn("success.png: is there already", self.refused(*images, *options))
        self.assertEqual(self.files("."), {"success.png"}, "nothing beside it")
        (self.folder / "success.png").unlink()
        for options in ((), ("--overwrite",)):
            process = self.run_command(REPORT, *images, "--out", "report.html", *options)
            self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("success.png: is there already", self.refused(*images))

    def test_says_how_rollouts_end(self) -> None:
        page = html.unescape(self.report(str(self.run_folder), "--out", "endings.html"))
        metrics = json.loads((self.run_folder / "metrics.json").read_text())
        headline = json.loads((self.run_folder / "statistics.json").read_text())["headline"]
        self.assertIn("--loop tracker", headline["caveat"])
        self.assertLess(page.index(headline["caveat"]), page.index(headline["answer"]))
        stuck = [metrics[f"neither_succeeds_{role}_stuck"] for role in ("reference", "engine")]
        self.assertIn("reference stuck: {}, engine stuck: {}".format(*stuck), page)
        self.assertIn(f"engine stuck: {metrics['only_reference_succeeds_engine_stuck']}<", page)

    def test_a_place_for_images_is_asked_for_first(self) -> None:
        self.write("mine", b"mine")
        folder = self.copy()
        (folder / "metrics.json").write_text("{}")  # what is in it comes later
        for images in ("mine/images", "mine/images/of/it"):
            process = self.run_command(REPORT, str(folder), "--images", images)
            self.assert_one_line(process, 4, "report")
            self.assertIn("images mine/images: must be in a folder that is there", process.stderr)
        self.assertFalse((folder / "report.html").exists())

    def test_numbers_that_are_not_finite(self) -> None:
        folder = self.copy()
        whole = np.load(folder / "traces.npy")
        for field, value in (("tee_x", np.nan), ("tee_yaw", np.inf), ("action_x", -np.inf)):
            with self.subTest(field):
                traces = whole.copy()
                traces[field][5] = value
                np.save(folder / "traces.npy", traces)
                refused = self.refused("copy")
                self.assertIn(f"episode 0, step 5: {field} {value}: must be finite", refused)
        np.save(folder / "traces.npy", whole)
        path = folder / "provenance.json"
        text = path.read_text()
        for number in ("1e400", "NaN", "-Infinity"):
            with self.subTest(number):
                path.write_text(text.replace("{", f'{{"more": {number},', 1))
                self.assertIn(f"{number}: must be a finite number", self.refused("copy"))

    def test_deeply_nested_files(self) -> None:
        depth = 100_000
        nested = '{"a": ' * depth + "1" + "}" * depth
        for name in ("metrics.json", "statistics.json", "provenance.json"):
            with self.subTest(name):
                path = self.copy() / name
                path.write_text(path.read_text().replace("{", f'{{"more": {nested},', 1))
                refused = self.refused("copy")
                self.assertIn(f"copy/{name}: must be JSON that is less deeply nested", refused)
                shutil.rmtree(path.parent)

    def test_signals(self) -> None:
        for number in SIGNALS:
            with self.subTest(number), subprocess.Popen(
                (REPORT, str(self.run_folder), "--out", "refused.html"),
                cwd=self.folder,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            ) as process:
                until(lambda: catches(process.pid, SIGNALS[-1]))
                process.send_signal(number)
                printed, said = process.communicate(timeout=self.deadline)
                expected = (4, "", "report: interrupted; nothing is written\n")
                self.assertEqual((process.returncode, printed, said), expected)
                self.assertEqual(self.files("."), set())

    def test_without_a_workspace(self) -> None:
        """In an empty environment, and where Python alone is told where the packages are."""
        for path in ("", os.environ["PYTHONPATH"]):
            for command in (REPORT, executable("sim2sim_eval", "plot_sweep")):
                process = subprocess.run(
                    (command, str(self.run_folder), "--out", "none.png"),
                    cwd=self.folder,
                    env={"PYTHONPATH": path},
                    stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE,
                    text=True,
                )
                self.assertNotIn("Traceback", process.stderr)
                self.assert_one_line(process, process.returncode, Path(command).name)
                self.assertIn(process.returncode, (2, 3))

    def test_folder_that_cannot_be_written(self) -> None:
        process = self.run_command(REPORT, str(self.run_folder), "--out", "none/report.html")
        self.assert_one_line(process, 4, "report")
        self.assertIn("out none/report.html: must be in a folder that is there", process.stderr)


class Browser(ReportCase):
    """The report in Chromium."""

    browser: Any

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        (cls.made.folder / "plan.yaml").write_text(
            "{policy: expert, episodes: 20, grid: {block_damp: [2, 20], pusher_mass: [1, 4]}}"
        )
        (cls.made.folder / "ladder.yaml").write_text(LADDER)
        (cls.made.folder / "policies.yaml").write_text(POLICIES)
        (cls.made.folder / "expected.yaml").write_text(EXPECTED)
        sizes = ("--episodes", str(EPISODES))
        for words in (
            (COMPARE, *sizes, "--engine", "chipmunk", "--out", "other"),
            (SWEEP, "plan.yaml", "--out", "sweep"),
            (REPORT, "run", "--out", "run.html"),
            (REPORT, "run", "other", "--out", "runs.html"),
            (REPORT, "sweep", "--out", "sweep.html"),
            (SWEEP, "ladder.yaml", "--out", "ladder"),
            (ATTRIBUTE, "ladder"),
            (REPORT, "ladder", "--out", "ladder.html"),
            (SWEEP, "policies.yaml", "--out", "policies"),
            (MATRIX, "policies", "--hypotheses", "expected.yaml"),
            (REPORT, "policies", "--out", "policies.html"),
        ):
            process = cls.made.run_command(*words)
            assert process.returncode == 0, process.stderr
        shutil.copytree(audited(), cls.made.folder / "planted")
        plant(cls.made.folder / "planted" / "audit.json", *PLANTED)
        process = cls.made.run_command(REPORT, "planted", "--out", "audited.html")
        assert process.returncode == 0, process.stderr
        options = Options()
        options.binary_location = program("chromium")
        for argument in (
            "--headless=new",
            "--no-sandbox",
            "--disable-dev-shm-usage",
            "--hide-scrollbars",
            "--disable-gpu",
        ):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(service=Service(program("chromedriver")), options=options)
        cls.addClassCleanup(cls.browser.quit)

    def open(self, width: int = 1366, height: int = 768, page: str = "run") -> None:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.browser.get(f"file://{self.made.folder / page}.html")
        self.assertEqual(self.browser.get_log("browser"), [], "the console is silent")

    def run_script(self, script: str, *arguments: Any) -> Any:
        return self.browser.execute_script(script, *arguments)

    def pusher_on(self, canvas: str) -> Tuple[float, float]:
        """Where the pusher is drawn [m]: the middle of the pixels of its color, without arrow."""
        x, y, edge = self.run_script(
            """
            const canvas = document.querySelector(arguments[0]);
            const { width, height } = canvas;
            const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
            let [left, right, top, bottom] = [width, 0, width, 0];
            for (let i = 0; i < data.length; i += 4) {
              if (data[i] === 0xf4 && data[i + 1] === 0xf4 && data[i + 2] === 0xf2) {
                const [x, y] = [(i / 4) % width, Math.floor(i / 4 / width)];
                [left, right] = [Math.min(left, x), Math.max(right, x)];
                [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
              }
            }
            return [(left + right + 1) / 2, (top + bottom + 1) / 2, width];
            """,
            canvas,
        )
        scale = 2 * WALL_OUTSIDE / edge
        return x * scale - WALL_OUTSIDE, WALL_OUTSIDE - y * scale

    def test_shows_the_states_to_the_pixel(self) -> None:
        self.open()
        traces = np.load(self.run_folder / "traces.npy")
        pixel = 2 * WALL_OUTSIDE / 640
        self.addCleanup(self.browser.get_log, "browser")  # it complains of reading pixels
        rng = np.random.default_rng(0)
        seen = 0
        for episode in rng.integers(0, EPISODES, 5):
            for _ in range(2):
                own = traces[traces["episode"] == episode]
                shown = {
                    f".script [data-mode={mode}] canvas": own[own["mode"] == mode.encode()]
                    for mode in ("reference_closed", "engine_closed", "engine_replay")
                }
                last = max(len(trace) for trace in shown.values()) - 1
                for step in rng.integers(0, last + 1, 4):
                    self.run_script(
                        """
                        const player = window.players.run0;
                        player.show(arguments[0]);
                        player.seek(arguments[1]);
                        // Without what else has the pusher's color.
                        for (const view of Object.values(player.views)) {
                          view.tee = () => {};
                          view.path = () => {};
                        }
                        player.draw();
                        """,
                        *(int(episode), int(step)),
                    )
                    for canvas, trace in shown.items():
                        state = trace[min(step, len(trace) - 1)]
                        if max(abs(state["pusher_x"]), abs(state["pusher_y"])) > ON_TABLE:
                            continue  # the engine lets it out
                        seen += 1
                        x, y = self.pusher_on(canvas)
                        where = (canvas, int(episode), int(step))
                        self.assertAlmostEqual(x, state["pusher_x"], delta=pixel, msg=where)
                        self.assertAlmostEqual(y, state["pusher_y"], delta=pixel, msg=where)
        self.assertGreater(seen, 40)

    def test_tee_is_drawn_where_it_is(self) -> None:
        self.open()
        self.addCleanup(self.browser.get_log, "browser")
        traces = np.load(self.run_folder / "traces.npy")
        for episode in (0, 7):
            own = traces[(traces["episode"] == episode) & (traces["mode"] == b"reference_closed")]
            for step in (0, len(own) // 2, len(own) - 1):
                state = own[step]
                sin, cos = math.sin(state["tee_yaw"]), math.cos(state["tee_yaw"])
                on_tee = [  # both ends of the bar, and of the stem
                    (state["tee_x"] + along * cos, state["tee_y"] + along * sin)
                    for along in (-0.05, 0.05)
                ]
                on_tee.append((state["tee_x"] + 0.09 * sin, state["tee_y"] - 0.09 * cos))
                beside = [  # left and right of the stem
                    (x + 0.06 * sin, y - 0.06 * cos) for x, y in on_tee[:2]
                ]
                colors = self.run_script(
                    """
                    const player = window.players.run0;
                    const left = player.views.reference_closed;
                    const draw = left.context;
                    left.path = left.pusher = () => {};
                    player.show(arguments[0]);
                    player.seek(arguments[1]);
                    return arguments[2].map(([x, y]) =>
                      draw.getImageData(left.x(x), left.y(y), 1, 1).data.join());
                    """,
                    *(episode, step, [list(map(float, point)) for point in on_tee + beside]),
                )
                self.assertEqual(colors[:3], ["90,170,255,255"] * 3, (episode, step))
                self.assertNotIn("90,170,255,255", colors[3:], (episode, step))

    def test_plays_pauses_and_scrubs(self) -> None:
        self.open()

        def clock() -> str:
            return str(self.run_script("return window.players.run0.clock.textContent"))

        picture = "return document.querySelector('.script canvas').toDataURL()"
        first = self.run_script(picture)
        button = self.browser.find_element("css selector", "button.play")
        button.click()
        WebDriverWait(self.browser, 20).until(lambda _: float(clock().split()[0]) > 0.3)
        self.assertNotEqual(self.run_script(picture), first)
        self.assertEqual(button.text, "Pause")
        button.click()
        self.assertEqual(button.text, "Play")
        stopped = clock()
        self.run_script(
            """
            const frame = () => new Promise((done) => requestAnimationFrame(done));
            return frame().then(frame);
            """
        )
        self.assertEqual(clock(), stopped)
        last = self.run_script(
            """
            const scrub = document.querySelector(".scrub");
            scrub.value = scrub.max;
            scrub.dispatchEvent(new Event("input"));
            return Number(scrub.max);
            """
        )
        self.assertEqual(clock(), f"{last * 0.1:.1f} s")
        self.assertEqual(self.browser.get_log("browser"), [])

    def test_first_episode_of_each_kind_is_offered(self) -> None:
        self.open()
        rows: Dict[str, Dict[str, bool]] = {}
        for line in (self.run_folder / "episodes.csv").read_text().splitlines()[1:]:
            cells = line.split(",")
            rows.setdefault(cells[0], {})[cells[2]] = cells[4] == "true"
        names = {(True, False): "reference only", (True, True): "both"}
        names.update({(False, False): "neither", (False, True): "engine only"})
        first: Dict[str, str] = {}
        for episode, success in rows.items():
            kind = names[success["reference_closed"], success["engine_closed"]]
            first.setdefault(kind, f"{kind}: episode {episode}")
        buttons = [b.text for b in self.browser.find_elements("css selector", ".kinds button")]
        self.assertEqual(buttons, [first[name] for name in names.values() if name in first])

    def test_table_sorts(self) -> None:
        self.open()
        rows = "[...document.querySelectorAll('.episodes tbody tr')]"
        column = f"return {rows}.map((row) => row.cells[7].textContent)"
        head = "document.querySelectorAll('.episodes thead button')[7].click();"
        before = self.run_script(column)
        self.assertEqual(len(before), EPISODES)
        ascending = self.run_script(head + column)
        self.assertEqual(ascending, sorted(before, key=float))
        self.assertEqual(self.run_script(head + column), sorted(before, key=float, reverse=True))

    def test_matrix_sorts_and_shows_the_episodes_of_a_cell(self) -> None:
        self.open(page="policies")
        rows = "[...document.querySelectorAll('.matrix tbody tr')]"
        names = f"return {rows}.map((row) => row.cells[0].textContent)"
        head = "document.querySelectorAll('.matrix thead button')[2].click();"
        self.assertEqual(self.run_script(names), ["bc", "expert"])
        self.assertEqual(
            self.run_script(head + names), ["expert", "bc"], "the best in MuJoCo first"
        )
        self.assertEqual(self.run_script(head + names), ["bc", "expert"])
        self.run_script(
            'document.querySelector(\'[data-policy="0"][data-simulator="1"] button\').click()'
        )
        matrix = json.loads((self.made.folder / "policies" / "matrix.json").read_text())
        here, there = (
            matrix["policies"][0]["cells"][simulator]["success_by_episode"] for simulator in (0, 1)
        )
        counts = {
            "both": sum(a + b == "11" for a, b in zip(here, there)),
            "two-mass engine only": sum(a + b == "01" for a, b in zip(here, there)),
            "MuJoCo only": sum(a + b == "10" for a, b in zip(here, there)),
            "neither": sum(a + b == "00" for a, b in zip(here, there)),
        }
        self.assertEqual(
            [
                e.text
                for e in self.browser.find_elements("css selector", ".matrix-episodes .keys span")
            ],
            [f"{name}: {count}" for name, count in counts.items()],
        )
        marks = self.browser.find_elements("css selector", ".marks-of-episodes i")
        self.assertEqual(len(marks), 20)
        lost = [mark for mark in marks if mark.get_attribute("class") == "only_reference_succeeds"]
        self.assertEqual(len(lost), counts["MuJoCo only"])
        command = self.browser.find_element("css selector", ".matrix-episodes pre").text
        self.assertEqual(command, "rosrun sim2sim_eval report policies/rows/000")

    def test_path_leads_to_its_episode(self) -> None:
        self.open()
        paths = self.browser.find_elements("css selector", ".paths button")
        self.assertEqual(len(paths), EPISODES)
        self.run_script("arguments[0].click()", paths[12])
        self.assertEqual(self.run_script("return window.players.run0.select.value"), "12")

    def rows_shown(self) -> List[List[str]]:
        shown: List[List[str]] = self.run_script(
            """
            return [...document.querySelectorAll(".episodes tbody tr")]
              .map((row) => [...row.cells].map((cell) => cell.textContent));
            """
        )
        return shown

    def test_filters_hold_for_table_pictures_and_turning(self) -> None:
        self.open()
        every = self.rows_shown()
        choose = """
            const filter = document.querySelector(`.filters .${arguments[0]}`);
            filter.value = arguments[1];
            filter.dispatchEvent(new Event("input", { bubbles: true }));
            """
        cause = next(row[10] for row in every if row[10])
        for name, value, passes in (
            ("kind", "2", lambda row: row[2] == "neither"),
            ("cause", cause, lambda row: row[10] == cause),
            ("least", "0.1", lambda row: row[7] != "" and float(row[7]) >= 0.1),
        ):
            with self.subTest(name):
                self.run_script(choose, name, value)
                expected = [row for row in every if passes(row)]
                self.assertEqual(self.rows_shown(), expected)
                self.assertLess(len(expected), len(every))
                seen = self.run_script(
                    """
                    return [...document.querySelectorAll(".paths button")]
                      .filter((button) => button.offsetParent)
                      .map((button) => button.dataset.episode);
                    """
                )
                self.assertEqual(seen, [row[0] for row in expected])
                order = self.run_script("return window.players.run0.order.map(String)")
                self.assertEqual(order, seen)
                saved = self.run_script("return window.tables.run0.csv()").splitlines()
                self.assertEqual([line.split(",") for line in saved[1:]], expected)
                self.run_script(choose, name, "")
        self.assertEqual(self.rows_shown(), every)

    def test_address_leads_to_episode_and_time(self) -> None:
        self.open()
        place = "const p = window.players.run0; return [p.select.value, p.clock.textContent]"
        address = f"file://{self.made.folder / 'run'}.html"
        self.browser.get("about:blank")
        self.browser.get(address + "#episode=12&t=1.3")
        self.assertEqual(self.run_script(place), ["12", "1.3 s"])
        for bad in ("#episode=999&t=1", "#episode=x", "#t=4", "#run=none&episode=3"):
            self.browser.get("about:blank")
            self.browser.get(address + bad)
            self.assertEqual(self.run_script(place)[1], "0.0 s", bad)
        self.assertEqual(self.browser.get_log("browser"), [])
        self.run_script("window.players.run0.step(7); window.players.run0.step(2)")
        self.assertTrue(self.browser.current_url.endswith("&t=0.9"), self.browser.current_url)

    def test_keys(self) -> None:
        self.open()
        press = """
            const player = window.players.run0;
            player.section.scrollIntoView();
            const of = { bubbles: true, cancelable: true };
            for (const [key, shiftKey] of arguments[0])
              document.body.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, ...of }));
            return [player.select.value, player.clock.textContent, player.play.textContent];
            """
        start = self.run_script(press, [])
        right = [["ArrowRight", False]]
        moved = self.run_script(press, right * 3 + [["ArrowRight", True], ["ArrowLeft", False]])
        self.assertEqual(moved, [start[0], "1.2 s", "Play"])
        self.assertEqual(self.run_script(press, [["Home", False]])[1], "0.0 s")
        following = self.run_script(press, [["n", False]])[0]
        self.assertEqual(int(following), int(start[0]) + 1)
        self.assertEqual(self.run_script(press, [["p", False]])[0], start[0])
        self.assertEqual(self.run_script(press, [[" ", False]])[2], "Pause")
        self.assertEqual(self.run_script(press, [[" ", False]])[2], "Play")

    def test_each_world_says_how_it_ended(self) -> None:
        self.open()
        stuck = 0
        with (self.run_folder / "episodes.csv").open() as file:
            rows = list(csv.DictReader(file))[:30]
        for row in rows:
            episode, mode, steps = int(row["episode"]), row["mode"], int(row["steps"])
            if not mode.startswith(("reference_closed", "engine_closed", "engine_replay")):
                continue
            badge = self.run_script(
                """
                const [player, [episode, mode, steps]] = [window.players.run0, arguments];
                player.show(episode);
                player.seek(steps - 1);
                const before = player.badges[mode].textContent;
                player.seek(player.last);
                return [before, player.badges[mode].textContent];
                """,
                *(episode, mode, steps),
            )
            if row["ending"] == "stuck":
                stuck += 1
                since = f"stuck since {int(row['still_step']) / 10:.1f} s"
                self.assertEqual(badge, [since, since], (episode, mode))
                continue
            words = "success at" if row["success"] == "true" else "no success, ended at"
            self.assertEqual(badge, ["", f"{words} {steps / 10:.1f} s"], (episode, mode))
        self.assertGreater(stuck, 0)
        spoken = self.run_script("return document.querySelectorAll('output, [aria-live]').length")
        self.assertEqual(spoken, 0, "nothing is read aloud at every frame")

    def test_play_stays_on_the_screen(self) -> None:
        for width, height in SIZES:
            with self.subTest(width):
                self.open(width, height)
                self.run_script(
                    "arguments[0].click()",
                    self.browser.find_elements("css selector", ".paths button")[25],
                )
                top, bottom = self.run_script(
                    """
                    const { top, bottom } = document.querySelector(".play").getBoundingClientRect();
                    return [top, bottom];
                    """
                )
                self.assertGreaterEqual(top, 0)
                self.assertLessEqual(bottom, height)

    def test_without_scripts(self) -> None:
        allow = {"value": False}
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.setScriptExecutionDisabled", allow)
        self.browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
        self.browser.get(f"file://{self.made.folder / 'run'}.html")
        shown = [
            len(
                [
                    each
                    for each in self.browser.find_elements("css selector", name)
                    if each.is_displayed()
                ]
            )
            for name in (
                ".poster svg",
                ".episodes tbody tr",
                "canvas",
                ".play",
                ".filters",
            )
        ]
        self.assertEqual(shown[0], 3, "frames of an episode")
        self.assertEqual(shown[1:], [EPISODES, 0, 0, 0])

    def test_prints_on_four_pages_with_provenance(self) -> None:
        self.open()
        inches = {"paperWidth": 8.27, "paperHeight": 11.69}
        printed = self.browser.execute_cdp_cmd("Page.printToPDF", inches)["data"]
        pages = re.findall(rb"/Type\s*/Page\b", base64.b64decode(printed))
        self.assertLessEqual(len(pages), 4)
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"media": ""})
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        height = "return document.querySelector('.provenance pre').getBoundingClientRect().height"
        self.assertGreater(self.run_script(height), 100)

    def test_nothing_overflows_or_clips(self) -> None:
        for page in PAGES:
            for width, height in SIZES:
                with self.subTest(page=page, width=width):
                    self.open(width, height, page)
                    self.assert_nothing_overflows(width)
                    answer = self.run_script(
                        "return document.querySelector('.words, h1').getBoundingClientRect().bottom"
                    )
                    self.assertLess(answer, height, "the answer is on the first screen")

    def test_paper(self) -> None:
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"media": ""})
        for page in PAGES:
            with self.subTest(page=page):
                self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
                self.open(A4_WIDTH, 1000, page)
                self.assert_nothing_overflows(A4_WIDTH)
                controls = "return [...document.querySelectorAll('.controls, .picks, .pages')]"
                shown = self.run_script(controls + ".filter((e) => e.offsetParent).length")
                self.assertEqual(shown, 0, "nothing to press")
                hidden: List[str] = self.run_script(
                    """
                    return [...document.querySelectorAll(".scroll")]
                      .filter((e) => e.scrollWidth > e.clientWidth + 1)
                      .map((e) => e.firstElementChild.className);
                    """
                )
                self.assertEqual(hidden, [], "nothing can be scrolled")

    def test_is_legible_in_light_and_dark(self) -> None:
        """WCAG: contrast of text at least 4.5; here against the card that it is on."""
        self.addCleanup(
            self.browser.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"features": []}
        )
        for scheme, colors in (("light", LIGHT), ("dark", DARK)):
            paper = f"rgb{tuple(bytes.fromhex(colors['paper'][1:]))}"
            for page in PAGES:
                with self.subTest(scheme=scheme, page=page):
                    feature = {"name": "prefers-color-scheme", "value": scheme}
                    self.browser.execute_cdp_cmd(
                        "Emulation.setEmulatedMedia", {"features": [feature]}
                    )
                    self.open(page=page)
                    background = "return getComputedStyle(document.body).backgroundColor"
                    self.assertEqual(self.run_script(background), paper)
                    faint: List[str] = self.run_script(
                        """
                        const channel = (c) =>
                          c <= 10 ? c / 3294 : ((c / 255 + 0.055) / 1.055) ** 2.4;
                        const luminance = (color) => {
                          const [r, g, b] = color.match(/[0-9.]+/g).map(Number).map(channel);
                          return 0.2126 * r + 0.7152 * g + 0.0722 * b;
                        };
                        const behind = (e) => {
                          for (; e; e = e.parentElement) {
                            const color = getComputedStyle(e).backgroundColor;
                            if (!/, 0\\)$/.test(color)) return color;
                          }
                          return "rgb(255, 255, 255)";
                        };
                        const contrast = (e, color) => {
                          const both = [luminance(color), luminance(behind(e))];
                          return (Math.max(...both) + 0.05) / (Math.min(...both) + 0.05);
                        };
                        const own = (e) =>
                          [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim());
                        return [...document.querySelectorAll("body *")]
                          .filter((e) => own(e) && e.getClientRects().length)
                          .filter((e) => !e.closest(".paths"))
                          .filter((e) => {
                            const style = getComputedStyle(e);
                            return contrast(e, e.closest("svg") ? style.fill : style.color) < 4.5;
                          })
                          .map((e) => `${e.tagName}.${e.getAttribute("class")} ${e.textContent}`);
                        """
                    )
                    self.assertEqual(faint, [])

    def assert_nothing_overflows(self, width: int) -> None:
        wide: List[str] = self.run_script(
            """
            const limit = document.documentElement.clientWidth;
            return [...document.querySelectorAll("body *")]
              .filter((e) => !e.closest(".scroll") && !e.closest("svg"))
              .filter((e) => e.getBoundingClientRect().right > limit + 1)
              .map((e) => e.tagName + "." + e.className);
            """
        )
        self.assertEqual(wide, [])
        self.assertEqual(self.run_script("return document.documentElement.scrollWidth"), width)
        outside: List[str] = self.run_script(
            """
            return [...document.querySelectorAll(".drawing svg")].flatMap((svg) => {
              const box = svg.getBoundingClientRect();
              return [...svg.querySelectorAll("text")].filter((text) => {
                const own = text.getBoundingClientRect();
                const beside = Math.max(box.left - own.left, own.right - box.right);
                return Math.max(beside, own.bottom - box.bottom) > 1;
              }).map((text) => text.textContent);
            });
            """
        )
        self.assertEqual(outside, [])
        overlaps: List[str] = self.run_script(
            """
            return [...document.querySelectorAll(".drawing svg")].flatMap((svg) => {
              const texts = [...svg.querySelectorAll("text")];
              const boxes = texts.map((text) => text.getBoundingClientRect());
              const common = (a, b, from, to) =>
                Math.min(a[to], b[to]) - Math.max(a[from], b[from]);
              const meet = (a, b) =>
                common(a, b, "left", "right") > 1 && common(a, b, "top", "bottom") > 2;
              return boxes.flatMap((box, i) => boxes.slice(0, i)
                .filter((other) => meet(box, other)).map(() => texts[i].textContent));
            });
            """
        )
        self.assertEqual(overlaps, [])


if __name__ == "__main__":
    unittest.main()
