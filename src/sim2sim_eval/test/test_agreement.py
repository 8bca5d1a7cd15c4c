#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Agreement of simulators, as a user meets it: all pairs, one way and both, and their picture."""

import json
import unittest
from typing import Any, Dict, List

import numpy as np
from pusht_testing.warm_commands import warm

from command_case import CommandCase, executable
from sim2sim_report.agreement import principal_coordinates, text_of, tree

AGREEMENT = executable("sim2sim_eval", "agreement")
COMPARE = executable("sim2sim_eval", "compare")
PLOT = executable("sim2sim_eval", "plot_agreement")
REPORT = executable("sim2sim_eval", "report")
warm([PLOT, REPORT], "sim2sim_report.make", "sim2sim_eval.command")
KINDS = ("mujoco", "chipmunk", "two_mass")
SHORT = ("--policy", "expert", "--episodes", "4", "--horizon", "60", "--reanchor", "5")
REPLAYS = {5: "engine_reanchored_5", None: "engine_replay"}
COMPONENTS = {"position": "m", "angle": "rad"}


class AgreementCase(CommandCase):
    def agree(self, out: str, *arguments: str) -> Dict[str, Any]:
        self.run_all((AGREEMENT, *arguments, *SHORT, "--out", out))
        content: Dict[str, Any] = json.loads((self.folder / out).read_text())
        return content

    def refused(self, program: str, *arguments: str, code: int = 2) -> str:
        process = self.run_command(program, *arguments)
        self.assert_one_line(process, code, program.rsplit("/", 1)[-1])
        message: str = process.stderr
        return message

    def compared(self, reference: str, engine: str, *more: str) -> Dict[str, Any]:
        out = f"{reference}-{engine}"
        self.run_all(
            (COMPARE, "--reference", reference, "--engine", engine, *SHORT, *more, "--out", out)
        )
        return self.load(out, "metrics.json")


def mean_of(metrics: Dict[str, Any], replay: str, component: str) -> float:
    course = {"position": "mean_pos_divergence_m", "angle": "mean_ang_divergence_rad"}
    own = f"{replay}_mean_{component}_divergence_{COMPONENTS[component]}"
    value: float = metrics[course[component] if replay == "engine_replay" else own]
    return value


class Figures(AgreementCase):
    def test_of_a_pair_are_those_of_compare(self) -> None:
        one_way = self.agree("one.json", *KINDS)
        both = self.agree("both.json", "--both-ways", *KINDS)
        there = self.compared("mujoco", "chipmunk", "--model-variants", "timestep=0.005")
        back = self.compared("chipmunk", "mujoco")
        for content, i, j, metrics in (
            (one_way, 0, 1, there),
            (both, 0, 1, there),
            (both, 1, 0, back),
        ):
            for replay in content["replays"]:
                for component in COMPONENTS:
                    found = replay[component]["distances"][i][j]["value"]
                    expected = mean_of(metrics, REPLAYS[replay["reset_every"]], component)
                    self.assertAlmostEqual(found, expected, delta=1e-6)
                    self.assertGreater(found, 0)
        for content in (one_way, both):
            variants = content["simulators"][0]["variants"]
            place = variants.index("mujoco:timestep=0.005")
            found = content["replays"][-1]["position"]["variants"][0][place]["value"]
            self.assertAlmostEqual(
                found, mean_of(there, "variant_timestep=0.005", "position"), delta=1e-6
            )

    def test_intervals_are_those_of_compare(self) -> None:
        longer = ("--policy", "expert", "--episodes", "20", "--horizon", "30", "--reanchor", "1")
        self.run_all((AGREEMENT, *KINDS[:2], *longer, "--no-variants", "--out", "agreement.json"))
        self.run_all((COMPARE, "--engine", "chipmunk", *longer, "--out", "run"))
        metrics = self.load("run", "metrics.json")
        first = self.load(".", "agreement.json")["replays"][0]
        for component, unit in COMPONENTS.items():
            self.assertEqual(
                first[component]["distances"][0][1]["interval"],
                metrics[f"engine_reanchored_1_mean_{component}_divergence_interval_{unit}"],
            )
            self.assertEqual(first[component]["most_central"], [0.5, 0.5])
            self.assertEqual(first[component]["variants"], [[], []])

    def test_one_way_is_symmetric_and_a_metric(self) -> None:
        content = self.agree("one.json", *KINDS)
        self.assertEqual([each["name"] for each in content["simulators"]], list(KINDS))
        self.assertEqual(content["reference"]["name"], "mujoco")
        for replay in content["replays"]:
            for component in COMPONENTS:
                cells = replay[component]["distances"]
                d = [[cell["value"] for cell in row] for row in cells]
                self.assertEqual([d[i][i] for i in range(3)], [0.0, 0.0, 0.0])
                self.assertEqual(d, [list(column) for column in zip(*d)])
                for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                    self.assertLessEqual(d[a][c], d[a][b] + d[b][c] + 1e-6)

    def test_reference_may_be_another_simulator(self) -> None:
        by_list = self.agree("listed.json", *KINDS)
        apart = self.agree("apart.json", *KINDS[1:], "--reference", "mujoco")
        for replay, of_apart in zip(by_list["replays"], apart["replays"]):
            self.assertEqual(
                replay["position"]["distances"][1][2], of_apart["position"]["distances"][0][1]
            )

    def test_bytes_are_those_of_any_threads_and_cache(self) -> None:
        for number, more in enumerate(
            (
                ("--threads", "1"),
                ("--threads", "2", "--reference-cache", "kept"),
                ("--threads", "2", "--reference-cache", "kept"),
            )
        ):
            self.agree(f"{number}.json", "--both-ways", *KINDS, *more)
        contents = {(self.folder / f"{number}.json").read_bytes() for number in range(3)}
        self.assertEqual(len(contents), 1)


class Refusals(AgreementCase):
    def test_of_the_list(self) -> None:
        for arguments, words in (
            (("mujoco",), "simulators mujoco: must be two or more"),
            (("mujoco", "mujoco:timestep=0.01"), "is there twice"),
            (("mujoco", "nowhere"), "nowhere"),
            (("mujoco", "chipmunk:depth=3"), "depth"),
            (("mujoco", "chipmunk:loop.action_delay=1"), "no policy in a loop"),
            (("mujoco", "chipmunk", "--reference", "nowhere"), "nowhere"),
            (("mujoco", "chipmunk", "--reference", "mujoco", "--both-ways"), "excludes"),
            (("mujoco", "chipmunk", "--reanchor", "5,5"), "reanchor 5: is named twice"),
            (("mujoco", "chipmunk", "--reanchor", "0"), "reanchor 0: must be from 1"),
            (("mujoco", "chipmunk", "--until-decided", "0.5"), "--until-decided"),
        ):
            self.assertIn(words, self.refused(AGREEMENT, *arguments), arguments)

    def test_of_a_file_that_is_there(self) -> None:
        self.write("there.json", b"mine")
        self.assertIn("there.json", self.refused(AGREEMENT, *KINDS, "--out", "there.json"))
        self.assertEqual((self.folder / "there.json").read_bytes(), b"mine")

    def test_of_a_world_that_fails(self) -> None:
        charge = ("--policy", self.charging_policy(), "--first-episode", "3", "--episodes", "1")
        engine = "two_mass:baumgarte=10"
        message = self.refused(AGREEMENT, "mujoco", engine, *charge, "--out", "a.json", code=4)
        self.assertIn("two_mass:baumgarte=10.0 along mujoco: episode 3", message)
        self.assertFalse((self.folder / "a.json").exists())


class Picture(AgreementCase):
    def test_has_its_bytes_and_is_not_overwritten_by_chance(self) -> None:
        self.agree("a.json", *KINDS)
        self.run_all((PLOT, "a.json"), (PLOT, "a.json", "--out", "b.png", "--reset-every", "5"))
        picture = (self.folder / "a.png").read_bytes()
        self.assertEqual(picture[:4], b"\x89PNG")
        self.assertIn("a.png", self.refused(PLOT, "a.json"))
        self.run_all((PLOT, "a.json", "--overwrite", "--reset-every", "0"))
        self.assertNotEqual((self.folder / "a.png").read_bytes(), picture)

    def test_refuses_what_it_cannot_draw(self) -> None:
        content = self.agree("a.json", *KINDS[:2])
        self.assertIn("must be one of 5, 0", self.refused(PLOT, "a.json", "--reset-every", "7"))
        self.assertIn("nowhere.json", self.refused(PLOT, "nowhere.json"))
        content["format"] = 0
        self.write("old.json", json.dumps(content).encode())
        self.assertIn("format", self.refused(PLOT, "old.json"))


class Page(AgreementCase):
    def test_has_the_figures_of_the_file(self) -> None:
        content = self.agree("a.json", *KINDS)
        self.run_all((REPORT, "a.json", "--images", "drawn"))
        page = (self.folder / "a.html").read_text("utf-8")
        head = page[page.index("<h1>") : page.index("</h1>")]
        self.assertRegex(
            head, r"MuJoCo and Chipmunk are nearest, [\d.]+ mm; two-mass engine is far"
        )
        for replay in content["replays"]:
            for component in COMPONENTS:
                for cell in replay[component]["distances"][0][1:]:
                    self.assertTrue(f">{text_of(1000 * cell['value'])}<" in page, cell)
        drawn = {path.name for path in (self.folder / "drawn").iterdir()}
        self.assertEqual(
            drawn, {f"agreement-{k}.{e}" for k in ("5", "open") for e in ("png", "pdf")}
        )
        self.assertIn("a.html", self.refused(REPORT, "a.json"))
        self.assertIn(
            "has no --animate", self.refused(REPORT, "a.json", "--out", "b.html", "--animate", "1")
        )

    def test_with_intervals(self) -> None:
        short = ("--policy", "expert", "--episodes", "20", "--horizon", "30", "--reanchor", "5")
        self.run_all((AGREEMENT, *KINDS, *short, "--out", "a.json"), (REPORT, "a.json"))
        page = (self.folder / "a.html").read_text("utf-8")
        head = page[page.index("<h1>") : page.index("</h1>")]
        self.assertRegex(
            head, r"nearest, [\d.]+ mm\W\[[\d.]+,\W[\d.]+\]; .* in 100 % of resamples\."
        )
        self.assertIn("In brackets 95 % intervals", page)

    def test_of_another_file_is_refused(self) -> None:
        self.write("other.json", b'{"format": 1}')
        self.assertIn("other.json", self.refused(REPORT, "other.json"))
        self.assertFalse((self.folder / "other.html").exists())


class Places(unittest.TestCase):
    def test_of_a_plane_are_recovered(self) -> None:
        places = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0], [1.0, 1.0]])
        distances = np.linalg.norm(places[:, None] - places[None], axis=2)
        found, kept = principal_coordinates(distances)
        np.testing.assert_allclose(
            np.linalg.norm(found[:, None] - found[None], axis=2), distances, atol=1e-9
        )
        self.assertAlmostEqual(kept, 1.0)

    def test_of_a_pair_and_of_one_place(self) -> None:
        found, kept = principal_coordinates(np.array([[0.0, 2.0], [2.0, 0.0]]))
        self.assertAlmostEqual(abs(found[0, 0] - found[1, 0]), 2.0)
        self.assertAlmostEqual(kept, 1.0)
        found, kept = principal_coordinates(np.zeros((3, 3)))
        self.assertEqual((found.tolist(), kept), ([[0.0, 0.0]] * 3, 1.0))

    def test_beyond_a_plane_are_said_to_be_so(self) -> None:
        corners = 1.0 - np.eye(4)  # a tetrahedron
        self.assertAlmostEqual(principal_coordinates(corners)[1], 2 / 3)

    def test_tree_joins_the_nearest_first(self) -> None:
        rows: List[List[float]] = [[0, 1, 6], [1, 0, 4], [6, 4, 0]]
        heights = tree(np.array(rows, dtype=float))[:, 2]
        self.assertEqual(heights.tolist(), [1.0, 5.0])

    def test_numbers_have_two_digits(self) -> None:
        texts = [text_of(value) for value in (0.0, 0.0123, 0.951, 9.96, 81.7, 118.0)]
        self.assertEqual(texts, ["0", "0.012", "0.95", "10", "82", "120"])


if __name__ == "__main__":
    unittest.main()
