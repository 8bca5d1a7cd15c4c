#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the networks that look back, remember, answer with chunks or draw noise: what they learn
from, what they answer, and their checkpoints."""

import dataclasses
import json
import os
import subprocess
import unittest
import zipfile
from typing import Any, Dict, List, Tuple
from unittest import mock

import numpy as np
import torch

from pusht_policy import models
from pusht_policy.checkpoint import provenance_path
from pusht_policy.demonstrations import Demonstration
from pusht_policy.frames import Examples, Frames, frames_of, pieces, windows
from pusht_policy.interface import INTERFACES
from pusht_policy.model import DESCRIPTION, Model, Policy, ranges_of
from pusht_policy.models import MODELS
from pusht_policy.recipe import INTERFACES as INTERFACE_NAMES, MODELS as NAMES, Recipe
from pusht_testing.long_tests import LONG
from std_msgs.msg import String  # type: ignore[import]

from test_training import (
    DEADLINE,
    SMALL,
    CommandCase,
    TrainerCase,
    demonstration,
    messages,
    never,
    weights,
    write_bag,
)

DESCRIBED = ("gru", "chunk", "flow", "flow_x")
OBSERVATIONS, ACTIONS, _ = Recipe().chunk


def numbered(*lengths: int) -> Frames:
    """Demonstrations of so many steps. Frame i has the observation i in each column, and the action
    (i, -i)."""
    demonstrations = []
    for seed, steps in enumerate(lengths):
        i = np.arange(sum(lengths[:seed]), sum(lengths[: seed + 1]), dtype=np.float32)[:, None]
        observations, actions = i.repeat(10, axis=1), np.concatenate([i, -i], axis=1)
        demonstrations.append(Demonstration(seed, True, observations, actions))
    return frames_of(demonstrations)


def made(name: str, frames: Frames) -> Model:
    """An untrained network."""
    torch.manual_seed(5)
    return MODELS[name](Recipe(hidden=(8, 6), model=name), ranges_of(frames)).eval()


class Cutting(unittest.TestCase):
    def numbers(self, examples: Examples) -> List[Any]:
        """Numbers of the frames in inputs and in targets; columns must agree."""
        self.assertTrue((examples.inputs == examples.inputs[..., :1]).all())
        self.assertTrue((examples.targets[..., 0] == -examples.targets[..., 1]).all())
        return [examples.inputs[..., 0].int().tolist(), examples.targets[..., 0].int().tolist()]

    def test_windows_repeat_first_observations_and_last_actions(self) -> None:
        past, ahead = self.numbers(windows(numbered(3, 1, 2), 3, 2))
        self.assertEqual(past, [[0, 0, 0], [0, 0, 1], [0, 1, 2], [3, 3, 3], [4, 4, 4], [4, 4, 5]])
        self.assertEqual(ahead, [[0, 1], [1, 2], [2, 2], [3, 3], [4, 5], [5, 5]])

    def test_a_window_of_one_is_a_frame(self) -> None:
        frames = numbered(3, 2)
        examples = windows(frames, 1, 1)
        self.assertTrue(torch.equal(examples.inputs.flatten(1), frames.observations))
        self.assertTrue(torch.equal(examples.targets.flatten(1), frames.actions))
        self.assertEqual(examples.frames(), 5)

    def test_pieces_end_where_a_demonstration_ends(self) -> None:
        examples = pieces(numbered(5, 1, 2), 2)
        expected = [[0, 1], [2, 3], [4, 4], [5, 5], [6, 7]]
        self.assertEqual(self.numbers(examples), [expected] * 2)
        self.assertEqual(examples.lengths.tolist(), [2, 2, 1, 1, 2])
        self.assertEqual(examples.frames(), 8)


class Networks(unittest.TestCase):
    def setUp(self) -> None:
        self.frames = frames_of(
            [demonstration(seed, steps=steps) for seed, steps in ((0, 9), (1, 5))]
        )

    def loss_of(self, model: Model, examples: Examples) -> float:
        with torch.no_grad():
            return float(model.loss(examples, torch.Generator().manual_seed(1)))

    def test_every_name_of_a_recipe_is_there(self) -> None:
        self.assertEqual(tuple(MODELS), NAMES)
        self.assertEqual(tuple(INTERFACES), INTERFACE_NAMES)

    def test_the_loss_is_that_of_what_is_answered(self) -> None:
        """Answers in SI units, mapped as the targets are."""
        for name in ("mlp", "chunk"):
            with self.subTest(name):
                model = made(name, self.frames)
                examples = model.examples(self.frames)
                seen = OBSERVATIONS if name == "chunk" else 1
                raw = windows(self.frames, seen, 1).inputs
                with torch.no_grad():
                    actions = model(raw if name == "chunk" else raw[:, 0])
                answered = (actions - model.act_min) * 2 / model.act_range - 1
                error = (answered.reshape(examples.targets.shape) - examples.targets).abs()
                expected = (error**2 if name == "mlp" else error).mean().item()
                self.assertAlmostEqual(self.loss_of(model, examples), expected, places=5)

    def test_a_recurrent_one_steps_as_it_was_trained(self) -> None:
        """Step by step, with its state handed on: the mean over all steps of both episodes."""
        model = made("gru", self.frames)
        errors = []
        for first, last in ((0, 8), (9, 13)):
            state = torch.zeros(1, 8)
            for i in range(first, last + 1):
                with torch.no_grad():
                    action, state = model(self.frames.observations[i].reshape(1, 1, 10), state)
                self.assertEqual((action.shape, state.shape), ((1, 1, 2), (1, 8)))
                wanted = self.frames.actions[i]
                errors.append(((action[0, 0] - wanted) * 2 / model.act_range).abs())
        loss = self.loss_of(model, model.examples(self.frames))
        self.assertAlmostEqual(loss, torch.stack(errors).mean().item(), places=5)

    def test_steps_after_an_end_teach_nothing(self) -> None:
        model = made("gru", self.frames)
        examples = model.examples(self.frames)
        before = self.loss_of(model, examples)
        second = examples.rows(torch.tensor([1]))
        alone = Examples(second.inputs[:, :5], second.targets[:, :5], second.lengths)
        self.assertEqual(self.loss_of(model, second), self.loss_of(model, alone))
        examples.inputs[1, 5:] = 0.25
        examples.targets[1, 5:] = 7.0
        self.assertEqual(self.loss_of(model, examples), before)
        examples.targets[1, 4] = 7.0
        self.assertNotEqual(self.loss_of(model, examples), before)

    def test_a_flow_follows_its_velocity(self) -> None:
        """A constant velocity b carries noise to noise + b, which is then clamped."""
        offset = torch.linspace(-0.5, 0.5, 2 * ACTIONS)
        model, noise, found = self.with_constant_net("flow", offset)
        y = (noise + offset.reshape(ACTIONS, 2)).clamp(-1, 1)
        self.assertGreater(int((y.abs() == 1).sum()), 3)
        expected = (y + 1) / 2 * model.act_range + model.act_min
        np.testing.assert_allclose(found.numpy(), expected.numpy(), atol=1e-6)

    def test_a_flow_to_actions_ends_at_them(self) -> None:
        """Whatever the noise is: none is left."""
        end = torch.linspace(-0.5, 0.5, 2 * ACTIONS)
        model, _, found = self.with_constant_net("flow_x", end)
        expected = (end.reshape(ACTIONS, 2) + 1) / 2 * model.act_range + model.act_min
        np.testing.assert_allclose(found.numpy(), expected.expand(3, -1, -1).numpy(), atol=1e-6)

    def with_constant_net(self, name: str, answer: torch.Tensor) -> Tuple[Model, Any, Any]:
        """A flow whose network gives one answer, noise, and its actions."""
        model = made(name, self.frames)
        with torch.no_grad():
            for parameter in model.parameters():
                parameter.zero_()
            list(model.parameters())[-1].copy_(answer)
            noise = torch.randn(3, ACTIONS, 2, generator=torch.Generator().manual_seed(2))
            return model, noise, model(torch.zeros(3, OBSERVATIONS, 10), noise)


class Training(TrainerCase):
    def test_a_chunk_of_one_has_the_bits_of_the_plain_network(self) -> None:
        plain = weights(self.finished())
        with mock.patch.object(models.Chunk, "loss", Policy.loss):
            chunk = self.finished(dataclasses.replace(SMALL, model="chunk", chunk=(1, 1, 1)))
        self.assertEqual(weights(chunk), plain)

    def test_a_recurrent_one_remembers(self) -> None:
        """Experts whose way shows at their first step alone: a plain network answers their mean."""
        for seed, each in enumerate(self.demonstrations):
            way = 1.0 if seed % 2 else -1.0
            each.observations[:] = 0.0
            each.observations[0] = way
            each.actions[:] = way
        losses = {}
        for name in ("gru", "mlp"):
            recipe = dataclasses.replace(SMALL, model=name, batch=4, learning_rate=1e-2, epochs=120)
            losses[name] = self.finished(recipe).validation_loss
        self.assertLess(losses["gru"], 0.1)  # mean absolute error; 1: the way is unknown
        self.assertGreater(losses["mlp"], 0.5)

    def test_a_flow_learns_both_ways_where_a_mean_learns_none(self) -> None:
        """Experts that go left or right, with nothing to tell them by."""
        for seed, each in enumerate(self.demonstrations):
            each.observations[:] = np.linspace(0, 1, 10)
            each.actions[:] = 1.0 if seed % 2 else -1.0
        recipe = dataclasses.replace(SMALL, epochs=200, hidden=(32, 32), learning_rate=3e-3)
        observations = torch.from_numpy(self.demonstrations[0].observations[:1]).repeat(200, 2, 1)
        noise = torch.randn(200, ACTIONS, 2, generator=torch.Generator().manual_seed(3))
        for name in ("flow", "flow_x"):
            flow = self.finished(dataclasses.replace(recipe, model=name)).script
            with torch.no_grad():
                first = flow(observations, noise)[:, 0, 0]
            for side in (first, -first):
                self.assertGreater(int((side > 0.5).sum()), 50, name)
            self.assertGreater(int((first.abs() > 0.5).sum()), 160, name)
        plain = self.finished(recipe).script
        with torch.no_grad():
            self.assertLess(float(plain(observations[:, 0]).abs().max()), 0.5)

    def test_bits_of_an_uninterrupted_run(self) -> None:
        """The noise of a training goes on where it was; that of a validation takes none of it."""
        for name in DESCRIBED:
            with self.subTest(name):
                recipe = dataclasses.replace(SMALL, model=name)
                reference = self.finished(recipe)
                stopped = self.trainer(recipe)
                stopped.run(self.state, never, until=5)
                stopped.provenance()
                torch.manual_seed(99)
                resumed = self.trainer(recipe)
                resumed.resume(self.state)
                resumed.run(self.state, never)
                self.assertEqual(weights(resumed), weights(reference))
                self.assertEqual(resumed.provenance(), reference.provenance())
                stopped.run(self.state, never)
                self.assertEqual(weights(stopped), weights(reference))


class Checkpoints(CommandCase):
    def train(
        self, name: str, *extra: str, out: str = "policy.ts.pt", hash_seed: str = "0"
    ) -> None:
        command = self.command("--model", name, *extra, out=out)
        environment = {**os.environ, "PYTHONHASHSEED": hash_seed}
        process = subprocess.run(
            command, env=environment, timeout=DEADLINE, capture_output=True, text=True
        )
        self.assertEqual((process.returncode, process.stderr), (0, ""))

    def loaded(self) -> "tuple[torch.jit.ScriptModule, Dict[str, Any]]":
        extra = {DESCRIPTION: ""}
        network = torch.jit.load(str(self.out), _extra_files=extra)
        return network, json.loads(extra[DESCRIPTION])

    def test_each_says_what_it_is_and_keeps_to_it(self) -> None:
        for name in DESCRIBED:
            with self.subTest(name):
                self.train(name, "--overwrite")
                network, description = self.loaded()
                inputs = [torch.zeros(3, description["observations"], 10)]
                for key in ("state", "noise"):
                    if key in description:
                        inputs.append(torch.zeros(3, *description[key]["shape"]))
                answer = network(*inputs)
                actions = answer
                if "state" in description:
                    actions, state = answer
                    self.assertEqual(state.shape, inputs[1].shape)
                self.assertEqual(actions.shape, (3, description["actions"], 2))
                self.assertLessEqual(description["execute"], description["actions"])
                training = json.loads(provenance_path(self.out).read_text())["training"]
                self.assertEqual(
                    (training["train_frames"], training["validation_frames"]), (144, 12)
                )

    def test_policies_of_gym_pusht_say_what_they_see(self) -> None:
        origin = String(data=json.dumps({"format": 2, "task": "gym_pusht"}))
        steps = [message for seed in range(13) for message in messages(demonstration(seed))]
        self.bag.unlink()
        write_bag(self.bag, [origin, *steps])
        for name, interface, chunk, numbers, sizes in (
            ("mlp", "gym_state", (), 5, (1, 1, 1)),
            ("chunk", "gym_keypoints", ("2", "16", "8"), 18, (2, 16, 8)),
            ("flow", "gym_keypoints", ("2", "4", "2"), 18, (2, 4, 2)),
        ):
            with self.subTest(name):
                more = ("--chunk", *chunk) if chunk else ()
                self.train(name, "--overwrite", "--interface", interface, *more)
                network, description = self.loaded()
                found = [description[key] for key in ("observations", "actions", "execute")]
                self.assertEqual((description["interface"], tuple(found)), (interface, sizes))
                inputs = [torch.zeros(3, sizes[0], numbers)]
                if name == "flow":
                    inputs.append(torch.zeros(3, sizes[1], 2))
                self.assertEqual(network(*inputs).shape, (3, sizes[1], 2))
                recipe = json.loads(provenance_path(self.out).read_text())["training"]
                self.assertEqual(recipe["interface"], interface)
                self.train(name, "--keep", "--interface", interface, *more)
        self.out.unlink()
        provenance_path(self.out).unlink()
        self.assert_refused(
            self.run_command(self.command()),
            2,
            "is of the task gym_pusht; interface full_circle must be gym_state or gym_keypoints",
        )

    def test_the_plain_one_has_no_description(self) -> None:
        self.train("mlp")
        with zipfile.ZipFile(self.out) as archive:
            self.assertNotIn(f"archive/extra/{DESCRIPTION}", archive.namelist())

    def test_bytes_depend_on_no_order_of_a_set(self) -> None:
        for name in DESCRIBED if LONG else ("flow",):
            with self.subTest(name):
                contents = set()
                for hash_seed in ("1", "2", "3") if LONG else ("1", "2"):
                    self.train(name, "--overwrite", hash_seed=hash_seed)
                    contents.add(self.out.read_bytes())
                self.assertEqual(len(contents), 1)

    def test_seeds_are_of_the_model_that_is_named(self) -> None:
        self.train("flow", "--seeds", "2", out="several.ts.pt")
        self.train("flow", "--seed", "1")
        several = [self.folder / f"several-{seed}.ts.pt" for seed in (0, 1)]
        self.assertEqual(several[1].read_bytes(), self.out.read_bytes())
        self.assertNotEqual(several[0].read_bytes(), self.out.read_bytes())

    def test_an_unknown_model_is_refused(self) -> None:
        finished = self.run_command(self.command("--model", "transformer"))
        self.assert_refused(finished, 2, "invalid choice: 'transformer' (choose from ")
        for name in MODELS:
            self.assertIn(name, finished.stderr)


if __name__ == "__main__":
    unittest.main()
