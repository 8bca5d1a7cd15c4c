#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Policies that were made for gym-pusht: their interfaces, and the shapes of LeRobot and Diffusion
Policy, as files and as modules."""

import json
import re
import unittest
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Dict, List, Tuple

import numpy as np
import rospkg  # type: ignore[import]
import sim2sim
import torch

from command_case import CommandCase, executable
from gym_policies import (
    DIFFUSION_POLICY,
    LEROBOT,
    Seer,
    Unet,
    save,
    save_act,
    save_diffusion,
    save_mlp,
)

try:
    from sim2sim import pictures

    needs_pictures = unittest.skipIf(False, "")
except sim2sim.BadDependency as missing:
    needs_pictures = unittest.skip(str(missing))

COMPARE = executable("sim2sim_eval", "compare")
MATRIX = executable("sim2sim_eval", "matrix")
SWEEP = executable("sim2sim_eval", "sweep")
DEMONSTRATE = executable("sim2sim_eval", "demonstrate")
TRAIN = executable("pusht_policy", "train")
EXPORT = executable("pusht_policy", "export_onnx")
GYM_STATE = {"interface": "gym_state"}
DOCS = Path(__file__).resolve().parents[3] / "docs"
SHORT = ("--task", "gym_pusht", "--reference", "gym_pusht", "--episodes", "2", "--horizon", "20")


class Part(torch.nn.Module):
    """To the point that two of the numbers are, to 4 px, so that their last bits do not count."""

    def __init__(self, first: int, angle: bool = False) -> None:
        super().__init__()
        self.first = first
        self.angle = angle

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        point = observations[:, :, self.first : self.first + 2]
        if self.angle:
            point = point[:, :, :1] * torch.tensor([50.0, 20.0])
        return torch.floor(point / 4.0 + 0.5) * 4.0


class Stand(SimpleNamespace):
    """Stands in for a policy of a project that cannot be installed here."""

    def eval(self) -> "Stand":
        self.net.eval()
        return self

    def requires_grad_(self, wanted: bool) -> None:
        self.net.requires_grad_(wanted)


def normalized(pixels: torch.Tensor) -> torch.Tensor:
    return pixels / 256.0 - 1.0


def in_pixels(numbers: torch.Tensor) -> torch.Tensor:
    return (numbers + 1.0) * 256.0


class Interfaces(CommandCase):
    def compare(self, policy: str, out: str, *arguments: str) -> Dict[str, Any]:
        command = (COMPARE, "--policy", policy, *SHORT, *arguments, "--out", out)
        process = self.run_command(*command)
        self.assertEqual(process.returncode, 0, process.stderr)
        return dict(json.loads((self.folder / out / "provenance.json").read_text()))

    def episodes(self, out: str) -> bytes:
        return (self.folder / out / "episodes.csv").read_bytes()

    def refusal(self, policy: str, *arguments: str, code: int = 2) -> str:
        process = self.run_command(COMPARE, "--policy", policy, *arguments, "--out", "refused")
        self.assertEqual(process.returncode, code, process.stdout)
        self.assertEqual(process.stderr.count("\n"), 1, process.stderr)
        return str(process.stderr)

    def path(self, name: str) -> str:
        return str(self.folder / name)

    def test_a_policy_sees_what_the_environment_shows(self) -> None:
        """By a callable in Python that is shown gym-pusht's own observations."""
        corner = {"interface": "gym_keypoints", "keypoints": 8}
        cases: Tuple[Tuple[Dict[str, Any], Part, str, Any], ...] = (
            (GYM_STATE, Part(2), "state", lambda seen: seen[:, 2:4]),
            (
                GYM_STATE,
                Part(4, angle=True),
                "state",
                lambda seen: seen[:, 4:] * np.array([[50.0, 20.0]]),
            ),
            (
                {**corner, "agent": "last"},
                Part(12),
                "environment_state_agent_pos",
                lambda seen: seen["environment_state"][:, 12:14],
            ),
            (
                {**corner, "agent": "first"},
                Part(2),
                "environment_state_agent_pos",
                lambda seen: seen["environment_state"][:, 0:2],
            ),
            (
                {**corner, "agent": "last"},
                Part(16),
                "environment_state_agent_pos",
                lambda seen: seen["agent_pos"] + 0.0,
            ),
        )
        for number, (interface, module, obs_type, point) in enumerate(cases):
            with self.subTest((interface, module.first)):
                numbers = 5 if interface is GYM_STATE else 18
                inputs = (torch.ones(1, 1, numbers),)
                file = f"part{number}.pt"
                save(module, inputs, self.path(file), observations=1, actions=1, **interface)

                def callable_(seen: Any) -> Any:
                    return np.float32(np.floor(point(seen) / 4.0 + 0.5) * 4.0)

                found = sim2sim.compare(
                    callable_,
                    task="gym_pusht",
                    reference="gym_pusht",
                    episodes=2,
                    horizon=20,
                    floor=False,
                    obs_type=obs_type,
                    engine="chipmunk",
                    out=self.path(f"callable{number}"),
                )
                self.assertEqual(len(found.episodes["episode"]), 2 * 3)
                self.compare(file, f"again{number}", "--no-floor", "--engine", "chipmunk")
                self.assertEqual(
                    self.episodes(f"again{number}"), self.episodes(f"callable{number}")
                )

    def test_the_nine_keypoints_of_diffusion_policy(self) -> None:
        """All nine, whose mean distance from the tee's origin is known."""

        class Mean(torch.nn.Module):
            def forward(self, observations: torch.Tensor) -> torch.Tensor:
                return observations[:, :, :18].reshape(-1, 1, 9, 2).mean(2)

        inputs = (torch.ones(1, 1, 20),)
        save(Mean(), inputs, self.path("mean.pt"), observations=1, actions=1, **DIFFUSION_POLICY)
        policy = sim2sim.load_policy(self.path("mean.pt"), task="gym_pusht")
        # A tee at (200, 100) that is not turned; the pusher elsewhere.
        row = np.array([[10, 20, 200, 100, 0, 1, 256, 256, 0.7, 0.7]], np.float32)
        x, y = policy(row)[0] - [200.0, 100.0]
        self.assertAlmostEqual(float(x), 0.0686, places=3)
        self.assertAlmostEqual(float(y), 40.2856, places=3)

    def test_shapes_of_lerobot_and_diffusion_policy_run(self) -> None:
        save_mlp(self.path("state.pt"), GYM_STATE, 5, past=1, chunk=1)
        save_mlp(self.path("corners.pt"), LEROBOT, 18, past=2, chunk=16)
        save_diffusion(self.path("lerobot.pt"), 18, (32, 64), LEROBOT)
        save_diffusion(self.path("dp.pt"), 20, (32, 64, 128), DIFFUSION_POLICY)
        save_act(self.path("act.pt"), chunk=20, width=32)
        runs_on = {}
        for name in ("state", "corners", "lerobot", "dp", "act"):
            with self.subTest(name):
                arguments = ("--engine", "chipmunk", "--no-floor")
                provenance = self.compare(f"{name}.pt", name, *arguments)
                runs_on[name] = provenance["policy"]["runs_on"]
                description = provenance["policy"]["description"]
                self.assertTrue(description["interface"].startswith("gym_"))
        self.assertEqual(
            [runs_on[name] for name in ("state", "corners")], ["fixed-order kernel"] * 2
        )
        self.assertEqual([runs_on[name] for name in ("lerobot", "dp", "act")], ["libtorch"] * 3)

    def test_the_export_that_the_page_shows(self) -> None:
        """With the attributes that it reads of LeRobot's and Diffusion Policy's classes."""
        page = (DOCS / "policies.md").read_text(encoding="utf-8")
        (code,) = [c for c in re.findall("```python\n(.*?)```", page, re.S) if "of_lerobot" in c]
        shown: Dict[str, Any] = {}
        exec(code, shown)  # pylint: disable=exec-used
        scheduler = SimpleNamespace(
            alphas_cumprod=torch.linspace(0.999, 0.01, 100),
            config=SimpleNamespace(prediction_type="epsilon"),
        )
        nets = {numbers: Unet(2 * numbers, (32, 64), embedding=32) for numbers in (18, 20)}

        def model(numbers: int) -> Any:
            return lambda x, t, global_cond: nets[numbers](x, t.float(), global_cond)

        lerobot = Stand(
            net=nets[18],
            normalize_inputs=lambda batch: {name: normalized(x) for name, x in batch.items()},
            unnormalize_outputs=lambda batch: {"action": in_pixels(batch["action"])},
            diffusion=SimpleNamespace(
                config=SimpleNamespace(prediction_type="epsilon", horizon=16),
                unet=model(18),
                noise_scheduler=scheduler,
            ),
        )
        normalizer = SimpleNamespace(normalize=normalized, unnormalize=in_pixels)
        diffusion_policy = Stand(
            net=nets[20],
            horizon=16,
            model=model(20),
            noise_scheduler=scheduler,
            normalizer={"obs": normalizer, "action": normalizer},
        )
        of_lerobot = shown["of_lerobot"](lerobot)
        shown["export"](of_lerobot, 18, self.path("lerobot.pt"), **LEROBOT)
        of_diffusion = shown["of_diffusion_policy"](diffusion_policy)
        shown["export"](of_diffusion, 20, self.path("dp.pt"), **DIFFUSION_POLICY)
        for name in ("lerobot", "dp"):
            self.compare(f"{name}.pt", name, "--engine", "none", "--no-floor")

    def test_onnx_has_the_bits_or_names_the_operators(self) -> None:
        save_mlp(self.path("corners.pt"), LEROBOT, 18, past=2, chunk=16)
        process = self.run_command(EXPORT, "corners.pt", "corners.onnx")
        self.assertEqual(process.returncode, 0, process.stderr)
        for kind in ("pt", "onnx"):
            self.compare(f"corners.{kind}", kind, "--engine", "chipmunk", "--no-floor")
        self.assertEqual(self.episodes("onnx"), self.episodes("pt"))
        save_diffusion(self.path("unet.pt"), 18, (32, 64), LEROBOT)
        process = self.run_command(EXPORT, "unet.pt", "unet.onnx")
        self.assertEqual(process.returncode, 2, process.stdout)
        self.assertIn("operator 'Conv' of node", process.stderr)
        self.assertEqual(process.stderr.count("\n"), 1, process.stderr)

    def test_other_interfaces_are_refused_by_name(self) -> None:
        save_mlp(self.path("state.pt"), GYM_STATE, 5, past=1, chunk=1)
        save_mlp(self.path("wrong.pt"), DIFFUSION_POLICY, 18, past=2, chunk=16)
        save_mlp(self.path("none.pt"), {"interface": "gym"}, 5, past=1, chunk=1)
        save_mlp(self.path("bare.pt"), {"interface": "gym_keypoints"}, 18, past=1, chunk=1)
        save_mlp(self.path("more.pt"), {**GYM_STATE, "agent": "last"}, 5, past=1, chunk=1)
        of_gym = ("--task", "gym_pusht", "--reference", "gym_pusht", "--engine", "chipmunk")
        for policy, arguments, code, words in (
            (
                "state.pt",
                (),
                2,
                "has the interface gym_state; must have one of the task full_circle",
            ),
            ("bc", of_gym, 2, "has the interface full_circle; must have one of the task gym_pusht"),
            ("wrong.pt", of_gym, 3, "float [1, 2, 20]"),
            ("none.pt", of_gym, 2, 'interface "gym": must be one of full_circle, gym_state'),
            ("bare.pt", of_gym, 2, "must have the key keypoints"),
            ("more.pt", of_gym, 2, "key agent must be left out with the interface gym_state"),
        ):
            with self.subTest(policy):
                self.assertIn(words, self.refusal(policy, *arguments, code=code))

    def test_policies_by_engines(self) -> None:
        save_mlp(self.path("state.pt"), GYM_STATE, 5, past=1, chunk=1)
        save_mlp(self.path("corners.pt"), LEROBOT, 18, past=2, chunk=16)
        plan = {
            "task": "gym_pusht",
            "policies": ["state.pt", "corners.pt"],
            "reference": "gym_pusht",
            "engine": ["chipmunk", "mujoco"],
            "episodes": 3,
            "horizon": 30,
            "floor": False,
        }
        self.write("plan.yaml", json.dumps(plan).encode())
        for command in ((SWEEP, "plan.yaml", "--out", "sweep"), (MATRIX, "sweep")):
            process = self.run_command(*command)
            self.assertEqual(process.returncode, 0, process.stderr)
        matrix = json.loads((self.folder / "sweep" / "matrix.json").read_text())
        self.assertEqual(len(matrix["policies"]), 2)

    def test_installed_ones_act(self) -> None:
        folder = Path(rospkg.RosPack().get_path("pusht_policy")) / "policies"
        for name, sizes in {"state": (1, 1), "chunk": (16, 8), "flow": (16, 8)}.items():
            with self.subTest(name):
                policy = str(folder / f"gym_{name}.ts.pt")
                provenance = self.compare(policy, name, "--engine", "mujoco", "--no-floor")
                self.assertEqual(provenance["policy"]["runs_on"], "fixed-order kernel")
                description = provenance["policy"]["description"]
                self.assertEqual((description["actions"], description["execute"]), sizes)

    def test_from_demonstrations_to_a_policy(self) -> None:
        """The planner shows gym-pusht's task; what was trained on its keypoints acts there."""
        demonstrate = (DEMONSTRATE, "--task", "gym_pusht", "--simulator", "gym_pusht")
        planner = ("--demonstrator", "planner", "--episodes", "3", "--action-noise", "5")
        train = (TRAIN, "--bag", "shown.bag", "--model", "flow", "--interface", "gym_keypoints")
        sizes = ("--chunk", "2", "6", "3", "--epochs", "2", "--hidden", "16", "16")
        for command in (
            (*demonstrate, *planner, "--out", "shown.bag"),
            (*train, *sizes, "--out", "trained.pt"),
        ):
            process = self.run_command(*command)
            self.assertEqual(process.returncode, 0, process.stderr)
        provenance = self.compare("trained.pt", "trained", "--engine", "mujoco", "--no-floor")
        self.assertEqual(provenance["policy"]["runs_on"], "fixed-order kernel")
        beside = json.loads((self.folder / "trained.pt.provenance.json").read_text())
        (origin,) = [bag["origin"] for bag in beside["demonstrations"]["bags"]]
        self.assertEqual((origin["task"], origin["demonstrator"]), ("gym_pusht", "planning expert"))
        self.assertEqual(origin["simulators"][0]["name"], "gym_pusht")
        process = self.run_command(*demonstrate, "--action-noise", "201", "--out", "none.bag")
        self.assertEqual(process.returncode, 2)
        self.assertIn("action noise 201.0: must be from 0 to 200.0 px", process.stderr)

    @needs_pictures
    def test_an_image_policy_runs_in_other_physics(self) -> None:
        torch.manual_seed(0)
        results: List[bytes] = []
        for run in ("one", "two"):
            found = sim2sim.compare(
                Seer(),
                task="gym_pusht",
                reference="gym_pusht",
                engine="mujoco",
                obs_type="pixels_agent_pos",
                history=2,
                episodes=2,
                horizon=24,
                floor=False,
                out=self.path(run),
            )
            results.append(self.episodes(run))
            torch.manual_seed(0)
        self.assertEqual(results[0], results[1])
        self.assertEqual(
            found.provenance["policy"]["sees"], f"pixels_agent_pos 96 x 96, {pictures.VERSIONS}"
        )
        seconds = found.seconds
        self.assertEqual(set(seconds), {"all", "observations", "policy"})
        self.assertGreater(min(seconds["observations"], seconds["policy"]), 0.0)
        self.assertLess(seconds["observations"] + seconds["policy"], seconds["all"])


if __name__ == "__main__":
    unittest.main()
