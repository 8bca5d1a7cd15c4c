#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of reading demonstrations, of the policy module and of the training."""

import dataclasses
import hashlib
import json
import math
import signal
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path
from typing import Any, Dict, List, Sequence
from unittest import mock

import numpy as np
import rosbag  # type: ignore[import]
import rospy  # type: ignore[import]
import torch
from pusht_msgs.msg import DemonstrationEnd, DemonstrationStep  # type: ignore[import]
from std_msgs.msg import String  # type: ignore[import]

from pusht_policy import software, training
from pusht_policy.checkpoint import PROVENANCE_FORMAT, provenance_path
from pusht_policy.demonstrations import Demonstration, read_demonstrations, sha256_of_frames
from pusht_policy.formats import DEMONSTRATION_FORMAT
from pusht_policy.frames import split
from pusht_policy.model import Policy, Ranges, minimum_and_range, normalised, torchscript_bytes
from pusht_policy.recipe import Recipe
from pusht_policy.trainer import Trainer
from pusht_task.error import Error, ExitCode
from pusht_testing.long_tests import LONG
from pusht_testing.warm_commands import run_warm, warm

SCRIPTS = Path(__file__).resolve().parent.parent / "scripts"
DEADLINE = 120  # s, for a started command
ORIGIN = {
    "demonstrator": "a smooth expert",
    "simulators": [{"name": "none", "parameters": {}, "drawn": {}}],
    "format": DEMONSTRATION_FORMAT,
}
warm([], "pusht_policy.several", "pusht_policy.training")
SMALL = Recipe(epochs=12, batch=16, hidden=(8, 6))


def demonstration(seed: int, steps: int = 12, success: bool = True) -> Demonstration:
    """Random observations with a smooth expert; the target pose is constant, as in the task."""
    generator = np.random.default_rng(seed)
    observations = generator.uniform(-0.3, 0.3, (steps, 10)).astype(np.float32)
    observations[:, 6:] = [0, 0, 0, 1]
    actions = np.tanh(3 * (observations[:, 2:4] - observations[:, 0:2])).astype(np.float32)
    return Demonstration(seed, success, observations, actions)


def messages(source: Demonstration) -> List[Any]:
    """The messages of one demonstration, in their order."""
    result: List[Any] = [
        DemonstrationStep(seed=source.seed, step=i, observation=o, action=a)
        for i, (o, a) in enumerate(zip(source.observations, source.actions))
    ]
    result.append(
        DemonstrationEnd(seed=source.seed, steps=len(source.actions), success=source.success)
    )
    return result


def write_bag(path: Path, content: Sequence[Any], compression: str = "none") -> Path:
    """Writes messages 0.1 s apart."""
    topics = {
        DemonstrationStep: "/demonstration/step",
        DemonstrationEnd: "/demonstration/end",
        String: "/demonstration/origin",
    }
    with rosbag.Bag(str(path), "w", compression=compression) as bag:
        for i, message in enumerate(content):
            bag.write(topics[type(message)], message, rospy.Time(1 + i // 10, i % 10 * 100000000))
    return path


def weights(trainer: Trainer) -> Dict[str, bytes]:
    return {name: value.numpy().tobytes() for name, value in trainer.model.state_dict().items()}


def never() -> bool:
    return False


class TemporaryFolderCase(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)


class ReadDemonstrations(TemporaryFolderCase):
    def refused(self, content: Sequence[Any]) -> str:
        """The error for a bag of these messages."""
        bag = write_bag(self.folder / "some.bag", content)
        with self.assertRaises(Error) as caught:
            read_demonstrations([bag])
        text = str(caught.exception)
        self.assertIn("some.bag", text)
        self.assertNotIn("\n", text)
        return text

    def test_everything_is_read_in_the_order_of_seeds(self) -> None:
        written = [demonstration(2**63), demonstration(1, steps=1, success=False)]
        first = write_bag(self.folder / "a.bag", messages(written[0]) + messages(written[1]))
        second = write_bag(self.folder / "b.bag", messages(demonstration(5)))
        read = read_demonstrations([first, second])
        self.assertEqual([d.seed for d in read], [1, 5, 2**63])
        self.assertEqual([d.success for d in read], [False, True, True])
        for expected, found in zip([written[1], demonstration(5), written[0]], read):
            self.assertEqual(found.observations.dtype, np.float32)
            np.testing.assert_array_equal(found.observations, expected.observations)
            np.testing.assert_array_equal(found.actions, expected.actions)

    def test_frames_have_a_fingerprint_whatever_holds_them(self) -> None:
        def fingerprint(name: str, content: Sequence[Any], compression: str = "none") -> str:
            bag = write_bag(self.folder / name, content, compression)
            return sha256_of_frames(read_demonstrations([bag]))

        plain = messages(demonstration(1)) + messages(demonstration(2))
        first = fingerprint("a.bag", plain)
        swapped = messages(demonstration(2)) + messages(demonstration(1))
        self.assertEqual(fingerprint("b.bag", swapped, compression="bz2"), first)
        for index, field, value in (
            (0, "seed", 9),
            (3, "action", [0.5, 0.25]),
            (3, "observation", [0.5] * 10),
            (12, "success", False),
        ):
            changed = messages(demonstration(1))
            for message in changed if field == "seed" else [changed[index]]:
                setattr(message, field, value)
            other = fingerprint("c.bag", changed + messages(demonstration(2)))
            self.assertNotEqual(other, first, field)

    def test_step_missing(self) -> None:
        content = messages(demonstration(7))
        del content[3]
        self.assertIn("seed 7: step 4: steps must be consecutive", self.refused(content))

    def test_first_step_missing(self) -> None:
        self.assertIn("seed 7: step 1: ", self.refused(messages(demonstration(7))[1:]))

    def test_step_repeated(self) -> None:
        content = messages(demonstration(7))
        content.insert(3, content[3])
        self.assertIn("seed 7: step 3: steps must be consecutive", self.refused(content))

    def test_end_missing(self) -> None:
        content = messages(demonstration(8)) + messages(demonstration(7))[:-1]
        self.assertIn("seed 7: step 11: is the last, but no end", self.refused(content))

    def test_step_count_disagrees(self) -> None:
        content = messages(demonstration(7))
        content[-1].steps = 13
        self.assertIn("seed 7: end: says 13 steps, found 12", self.refused(content))

    def test_end_without_steps(self) -> None:
        content = messages(demonstration(8)) + [DemonstrationEnd(seed=7, steps=0)]
        self.assertIn("seed 7: end: says 0 steps, found 0", self.refused(content))

    def test_seed_twice_in_one_bag(self) -> None:
        content = messages(demonstration(7)) + messages(demonstration(7))
        self.assertIn("seed 7: step 0: comes after the end", self.refused(content))

    def test_end_twice(self) -> None:
        content = messages(demonstration(7))
        self.assertIn("seed 7: end: appears twice", self.refused(content + content[-1:]))

    def test_seed_twice_in_two_bags(self) -> None:
        bags = [
            write_bag(self.folder / name, messages(demonstration(7))) for name in ("a.bag", "b.bag")
        ]
        with self.assertRaisesRegex(Error, "b.bag: seed 7: also in .*a.bag"):
            read_demonstrations(bags)

    def test_numbers_not_finite(self) -> None:
        for name, value in (("observation", math.nan), ("action", -math.inf)):
            content = messages(demonstration(7))
            values = list(getattr(content[2], name))
            values[1] = value
            setattr(content[2], name, values)
            self.assertRegex(
                self.refused(content), f"seed 7: step 2: {name} is .*{value:g}.*must be finite"
            )

    def test_topic_missing(self) -> None:
        content = messages(demonstration(7))
        self.assertIn("no messages on /demonstration/end", self.refused(content[:-1]))

    def test_type_of_topic(self) -> None:
        path = self.folder / "some.bag"
        with rosbag.Bag(str(path), "w") as bag:
            bag.write("/demonstration/step", String("a"))
        with self.assertRaisesRegex(Error, "step is of type std_msgs/String; it must be"):
            read_demonstrations([path])

    def test_format_of_the_bag(self) -> None:
        recording = messages(demonstration(7))
        for text in ("{}", '{"format": 1}', '{"format": 2}'):
            bag = write_bag(self.folder / "some.bag", [String(data=text)] + recording)
            self.assertEqual(len(read_demonstrations([bag])), 1)
        for text, why in (
            ('{"format": 3}', "format 3: must be 2"),
            ('{"format": null}', "format None: must be 2"),
            ("[]", r"origin is \[\]; it must be a JSON object"),
            ("{", "origin: .*; it must be JSON"),
        ):
            self.assertRegex(self.refused([String(data=text)] + recording), why)

    def test_not_a_readable_bag(self) -> None:
        path = write_bag(self.folder / "some.bag", messages(demonstration(7)))
        whole = path.read_bytes()
        for content in (b"", b"no bag", whole[:100], whole[: len(whole) // 2], whole[:-7]):
            path.write_bytes(content)
            with self.assertRaisesRegex(Error, "some.bag: "):
                read_demonstrations([path])
        path = write_bag(self.folder / "some.bag", messages(demonstration(7)), "bz2")
        packed = bytearray(path.read_bytes())
        packed[packed.find(b"BZh") + 20] ^= 255
        path.write_bytes(packed)
        with self.assertRaisesRegex(Error, "some.bag: Invalid data stream; a readable"):
            read_demonstrations([path])
        with self.assertRaisesRegex(Error, "absent.bag: no such file"):
            read_demonstrations([self.folder / "absent.bag"])
        with self.assertRaisesRegex(Error, "is a folder"):
            read_demonstrations([self.folder])


class PolicyModule(unittest.TestCase):
    def setUp(self) -> None:
        torch.manual_seed(3)
        observations = torch.from_numpy(demonstration(0, steps=40).observations)
        actions = torch.from_numpy(demonstration(0, steps=40).actions)
        self.observations = observations
        ranges = Ranges(*minimum_and_range(observations), *minimum_and_range(actions))
        self.model = Policy((7, 5), ranges).eval()

    def test_layout_of_the_checkpoint(self) -> None:
        layers = [f"net.{i}.{kind}" for i in (0, 2, 4) for kind in ("weight", "bias")]
        buffers = ["obs_min", "obs_range", "act_min", "act_range"]
        self.assertEqual(sorted(self.model.state_dict()), sorted(layers + buffers))

    def test_narrow_range_counts_as_one(self) -> None:
        values = torch.tensor([[0.0, 2.0, -1.0], [0.9e-4, 2.0, 3.0]])
        minimum, value_range = minimum_and_range(values)
        self.assertEqual(minimum.tolist(), [0.0, 2.0, -1.0])
        self.assertEqual(value_range.tolist(), [1.0, 1.0, 4.0])

    def test_frames_fill_the_normalized_interval(self) -> None:
        mapped = normalised(self.observations, self.model.obs_min, self.model.obs_range)
        self.assertEqual(mapped.min(dim=0).values.tolist(), [-1.0] * 10)
        for column in range(6):
            self.assertAlmostEqual(mapped[:, column].max().item(), 1.0, places=6)

    def test_forward_rounds_in_the_documented_order(self) -> None:
        """The network is made to pass one input through, so that numpy can repeat each rounding."""
        with torch.no_grad():
            for parameter in self.model.parameters():
                parameter.zero_()
            self.model.net[0].weight[0, 0] = 1.0
            self.model.net[0].bias[0] = 1.0
            self.model.net[2].weight[0, 0] = 1.0
            self.model.net[4].weight[:, 0] = 1.0
        observations = np.random.default_rng(1).uniform(-0.5, 0.5, (500, 10)).astype(np.float32)
        one, two = np.float32(1), np.float32(2)
        obs_min, obs_range = self.model.obs_min.numpy(), self.model.obs_range.numpy()
        x = np.clip((observations - obs_min) * two / obs_range - one, -one, one)
        y = (x[:, :1] + one).repeat(2, axis=1)
        expected = (y + one) / two * self.model.act_range.numpy() + self.model.act_min.numpy()
        self.assertGreater(np.count_nonzero(np.abs(x[:, 0]) == 1), 50)  # the clamp is at work
        with torch.no_grad():
            found = self.model(torch.from_numpy(observations)).numpy()
        np.testing.assert_array_equal(found, expected)

    def test_saved_model_answers_alike_and_holds_no_local_path(self) -> None:
        content = torchscript_bytes(torch.jit.script(self.model))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "policy.ts.pt"
            path.write_bytes(content)
            loaded = torch.jit.load(str(path))
            with zipfile.ZipFile(path) as archive:
                records = {name: archive.read(name) for name in archive.namelist()}
        self.assertFalse(loaded.training)
        with torch.no_grad():
            for rows in (self.observations, self.observations[0]):
                self.assertTrue(torch.equal(loaded(rows), self.model(rows)))
        for name, record in records.items():
            self.assertNotIn(str(SCRIPTS.parent).encode(), record, name)
            self.assertNotIn(b"/usr/lib", record, name)


class TrainerCase(TemporaryFolderCase):
    def setUp(self) -> None:
        super().setUp()
        self.demonstrations = [demonstration(seed) for seed in range(20)]
        self.state = self.folder / "state.pt"

    def trainer(self, recipe: Recipe = SMALL) -> Trainer:
        software.set_up_torch(recipe)
        return Trainer(self.demonstrations, recipe)

    def finished(self, recipe: Recipe = SMALL) -> Trainer:
        trainer = self.trainer(recipe)
        trainer.run(self.folder / "other.pt", never)
        return trainer


class Training(TrainerCase):
    def test_split_is_by_demonstration(self) -> None:
        def parts(seed: int) -> List[List[int]]:
            recipe = dataclasses.replace(SMALL, seed=seed)
            generator = torch.Generator().manual_seed(seed)
            both = split(self.demonstrations, recipe, generator)
            return [[d.seed for d in part] for part in both]

        train_part, validation_part = parts(0)
        self.assertEqual(len(validation_part), 2)
        self.assertEqual(sorted(train_part + validation_part), list(range(20)))
        self.assertEqual(parts(0), [train_part, validation_part])
        self.assertNotEqual(parts(1), [train_part, validation_part])

    def test_normalization_ignores_validation_frames(self) -> None:
        generator = torch.Generator().manual_seed(SMALL.seed)
        train_part, validation_part = split(self.demonstrations, SMALL, generator)
        before = self.trainer().model.state_dict()
        for held_out in validation_part:
            held_out.observations[0] = 100.0
            held_out.actions[0] = 100.0
        after = self.trainer().model.state_dict()
        for name in ("obs_min", "obs_range", "act_min", "act_range"):
            self.assertTrue(torch.equal(before[name], after[name]), name)
        frames = np.concatenate([d.observations for d in train_part])
        np.testing.assert_array_equal(after["obs_min"], frames.min(axis=0))

    def test_follows_a_slow_reference(self) -> None:
        """Backpropagation, Adam and cosine by hand in float64; the tolerance is float32's."""
        recipe = dataclasses.replace(SMALL, epochs=3, learning_rate=1e-2)
        trainer = self.trainer(recipe)
        p = [value.detach().numpy().astype(np.float64) for value in trainer.model.parameters()]
        first = [np.zeros_like(value) for value in p]
        second = [np.zeros_like(value) for value in p]
        x = trainer.train_examples.inputs.flatten(1).numpy().astype(np.float64)
        t = trainer.train_examples.targets.flatten(1).numpy().astype(np.float64)
        shuffler = torch.Generator()
        shuffler.set_state(trainer.generator.get_state())
        step = 0
        for epoch in range(recipe.epochs):
            rate = recipe.learning_rate * (1 + math.cos(math.pi * epoch / recipe.epochs)) / 2
            order = torch.randperm(len(x), generator=shuffler).numpy()
            for start in range(0, len(x), recipe.batch):
                rows = order[start : start + recipe.batch]
                a0 = x[rows]
                a1 = np.maximum(a0 @ p[0].T + p[1], 0)
                a2 = np.maximum(a1 @ p[2].T + p[3], 0)
                d3 = 2 * (a2 @ p[4].T + p[5] - t[rows]) / t[rows].size
                d2 = d3 @ p[4] * (a2 > 0)
                d1 = d2 @ p[2] * (a1 > 0)
                gradients = [d1.T @ a0, d1.sum(0), d2.T @ a1, d2.sum(0), d3.T @ a2, d3.sum(0)]
                step += 1
                for i, gradient in enumerate(gradients):
                    first[i] = 0.9 * first[i] + 0.1 * gradient
                    second[i] = 0.999 * second[i] + 0.001 * gradient**2
                    mean, square = first[i] / (1 - 0.9**step), second[i] / (1 - 0.999**step)
                    p[i] = p[i] - rate * mean / (np.sqrt(square) + 1e-8)
        trainer.run(self.state, never)
        for expected, found in zip(p, trainer.model.parameters()):
            np.testing.assert_allclose(found.detach().numpy(), expected, atol=2e-5)

    def test_learns_the_expert(self) -> None:
        trainer = self.finished(dataclasses.replace(SMALL, epochs=60, hidden=(32, 32)))
        untrained = self.trainer()._loss_over(trainer.validation_examples)
        self.assertLess(trainer.validation_loss, 0.1 * untrained)
        self.assertEqual([entry["epoch"] for entry in trainer.history], [50])

    def test_same_recipe_same_bits_other_seed_other_bits(self) -> None:
        reference = weights(self.finished())
        self.assertEqual(weights(self.finished()), reference)
        other = weights(self.finished(dataclasses.replace(SMALL, seed=1)))
        self.assertNotEqual(other["net.0.weight"], reference["net.0.weight"])

    def test_diverged_loss_is_a_fault(self) -> None:
        trainer = self.trainer(dataclasses.replace(SMALL, learning_rate=1e30))
        with self.assertRaisesRegex(Error, "must be finite") as caught:
            trainer.run(self.state, never)
        self.assertEqual(caught.exception.exit_code, ExitCode.RUNTIME_FAULT)

    def test_too_few_demonstrations(self) -> None:
        self.demonstrations = self.demonstrations[:1]
        with self.assertRaisesRegex(Error, "demonstrations: 1; at least 2"):
            self.trainer()

    def test_recipe_is_checked(self) -> None:
        values: Dict[str, Any] = {
            "epochs": 0,
            "batch": -1,
            "threads": 0,
            "learning_rate": math.nan,
            "seed": -1,
            "hidden": (0, 3),
            "model": "transformer",
        }
        for name, value in values.items():
            with self.assertRaisesRegex(Error, "^lr|" + name):
                dataclasses.replace(SMALL, **{name: value}).check()


class Resume(TrainerCase):
    def interrupted_after(self, epochs: int) -> None:
        """Leaves the state of a run that was told to stop after so many epochs."""
        trainer = self.trainer()
        with self.assertRaisesRegex(Error, "^interrupted") as caught:
            trainer.run(self.state, lambda: trainer.epoch == epochs)
        self.assertEqual(caught.exception.exit_code, ExitCode.RUNTIME_FAULT)
        self.assertEqual(trainer.epoch, epochs)

    def test_bits_of_an_uninterrupted_run(self) -> None:
        reference = self.finished()
        for stop in (0, 1, 7, 11):
            self.interrupted_after(stop)
            torch.manual_seed(99)
            resumed = self.trainer()
            resumed.resume(self.state)
            self.assertEqual(resumed.epoch, stop)
            resumed.run(self.state, never)
            self.assertEqual(weights(resumed), weights(reference))
            self.assertEqual(resumed.provenance(), reference.provenance())

    def test_state_is_saved_regularly(self) -> None:
        saved = []
        trainer = self.trainer(dataclasses.replace(SMALL, epochs=22))
        with mock.patch.object(trainer, "save", lambda _: saved.append(trainer.epoch)):
            trainer.run(self.state, never)
        self.assertEqual(saved, [10, 20, 22])

    def test_another_recipe_is_refused(self) -> None:
        self.interrupted_after(2)
        others: Dict[str, Any] = {
            "epochs": 13,
            "batch": 17,
            "learning_rate": 2e-3,
            "seed": 1,
            "threads": 2,
            "hidden": (8, 7),
            "model": "chunk",
        }
        for name, value in others.items():
            trainer = self.trainer(dataclasses.replace(SMALL, **{name: value}))
            with self.assertRaisesRegex(Error, f"state.pt: {name} was .*, is now "):
                trainer.resume(self.state)

    def test_other_demonstrations_are_refused(self) -> None:
        self.interrupted_after(2)
        self.demonstrations[3].actions[5, 0] += np.float32(1e-6)
        with self.assertRaisesRegex(Error, "state.pt: frames was "):
            self.trainer().resume(self.state)

    def test_another_core_of_the_blas_is_refused(self) -> None:
        self.interrupted_after(2)
        with mock.patch.object(software, "_blas_cores", lambda: ["Another"]):
            with self.assertRaisesRegex(Error, "state.pt: blas_core was .*, is now Another"):
                self.trainer().resume(self.state)

    def test_state_of_another_format_is_refused(self) -> None:
        self.interrupted_after(2)
        with mock.patch("pusht_policy.trainer.STATE_FORMAT", 2):
            with self.assertRaisesRegex(Error, "state.pt: format was 1, is now 2"):
                self.trainer().resume(self.state)

    def test_damaged_state_is_refused(self) -> None:
        self.interrupted_after(2)
        whole = self.state.read_bytes()
        for content in (b"", b"nonsense", whole[: len(whole) // 2]):
            self.state.write_bytes(content)
            with self.assertRaisesRegex(Error, "state.pt: not a readable training state"):
                self.trainer().resume(self.state)


class CommandCase(TemporaryFolderCase):
    def setUp(self) -> None:
        super().setUp()
        content = [m for seed in range(3, 15) for m in messages(demonstration(seed))]
        content += messages(demonstration(15, success=False))
        content.insert(0, String(data=json.dumps(ORIGIN)))
        self.bag = write_bag(self.folder / "some.bag", content)
        self.out = self.folder / "policy.ts.pt"

    def command(self, *extra: str, out: str = "policy.ts.pt", epochs: int = 10) -> List[str]:
        arguments = ["--bag", str(self.bag), "--out", str(self.folder / out)]
        sizes = ["--epochs", str(epochs), "--batch", "16", "--hidden", "8", "6"]
        return [sys.executable, str(SCRIPTS / "train"), *arguments, *sizes, *extra]

    def run_command(self, command: Sequence[str]) -> "subprocess.CompletedProcess[str]":
        return run_warm(command[1:], self.folder, DEADLINE)

    def assert_refused(
        self, finished: "subprocess.CompletedProcess[str]", code: int, text: str
    ) -> None:
        self.assertEqual(finished.returncode, code, finished.stderr)
        self.assertEqual(finished.stderr.count("\n"), 1, finished.stderr)
        self.assertIn(text, finished.stderr)
        self.assertFalse(self.out.exists())


class TrainCommand(CommandCase):
    def test_writes_checkpoint_and_provenance_only(self) -> None:
        finished = self.run_command(self.command())
        self.assertEqual((finished.returncode, finished.stderr), (0, ""))
        self.assertIn("13 demonstrations, 12 solved, 156 frames", finished.stdout)
        self.assertIn("epoch 10/10  train ", finished.stdout)
        provenance_file = provenance_path(self.out)
        self.assertEqual(set(self.folder.iterdir()), {self.bag, self.out, provenance_file})
        provenance = json.loads(provenance_file.read_text())
        self.assertEqual(
            provenance["checkpoint"],
            {
                "file": "policy.ts.pt",
                "sha256": hashlib.sha256(self.out.read_bytes()).hexdigest(),
            },
        )
        self.assertEqual(provenance["format"], PROVENANCE_FORMAT)
        self.assertEqual(
            provenance["demonstrations"],
            {
                "bags": [{"file": "some.bag", "origin": ORIGIN}],
                "sha256_of_frames": sha256_of_frames(read_demonstrations([self.bag])),
                "episodes": 13,
                "successes": 12,
                "frames": 156,
                "first_seed": 3,
                "last_seed": 15,
            },
        )
        self.assertEqual(provenance["training"]["train_frames"], 144)
        self.assertEqual(provenance["training"]["validation_frames"], 12)
        self.assertEqual(provenance["software"], software.software())
        for name in ("cpu", "vectors", "blas_core"):  # as the code of torch and BLAS is chosen by
            self.assertTrue(provenance["software"][name], name)
        self.assertIsNone(provenance["evaluation"])
        self.assertNotIn(str(self.folder), provenance_file.read_text())
        self.assertEqual(
            provenance_file.read_text(), json.dumps(provenance, indent=2, sort_keys=True) + "\n"
        )

    def test_file_that_is_there_stays(self) -> None:
        before = self.bag.read_bytes()
        for options in ((), ("--overwrite",)):
            finished = self.run_command(self.command(*options, out=self.bag.name))
            self.assert_refused(finished, 2, "some.bag: is there already")
        self.assertEqual(self.bag.read_bytes(), before)
        self.assertEqual(self.run_command(self.command()).returncode, 0)
        again = self.run_command(self.command())
        self.assertEqual(again.returncode, 2, again.stderr)
        self.assertIn("policy.ts.pt: is there already", again.stderr)
        again = self.run_command(self.command("--overwrite"))
        self.assertEqual(again.returncode, 0, again.stderr)

    def test_interrupted_run_resumes_to_the_same_bytes(self) -> None:
        epochs = 600  # some 2 s
        self.assertEqual(
            self.run_command(self.command(out="whole.pt", epochs=epochs)).returncode, 0
        )
        signals = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
        for number in signals if LONG else signals[:1]:
            with subprocess.Popen(
                self.command(epochs=epochs),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            ) as process:
                assert process.stdout is not None and process.stderr is not None
                while not process.stdout.readline().startswith("epoch "):
                    self.assertIsNone(process.poll())
                process.send_signal(number)
                process.stdout.read()
                error = process.stderr.read()
                self.assertEqual(process.wait(DEADLINE), 4)
            self.assertRegex(error, r"^train: interrupted after epoch \d+ of 600, .* to resume\n$")
            self.assertFalse(self.out.exists())
        resumed = self.run_command(self.command(epochs=epochs))
        self.assertEqual(resumed.returncode, 0, resumed.stderr)
        self.assertIn("resumed after epoch ", resumed.stdout)
        self.assertEqual(self.out.read_bytes(), (self.folder / "whole.pt").read_bytes())
        self.assertFalse((self.folder / "policy.ts.pt.training").exists())

    def test_policies_of_earlier_epochs(self) -> None:
        """The policy after 4 of 10 epochs is not that of 4 epochs: its learning rate fell less."""
        finished = self.run_command(self.command("--also-after", "4", "--also-after", "7"))
        self.assertEqual((finished.returncode, finished.stderr), (0, ""))
        whole = self.run_command(self.command(out="whole.ts.pt"))
        self.assertEqual(whole.returncode, 0, whole.stderr)
        early = self.folder / "after-4-policy.ts.pt"
        self.assertEqual(self.out.read_bytes(), (self.folder / "whole.ts.pt").read_bytes())
        contents = {path.read_bytes() for path in self.folder.glob("*policy.ts.pt")}
        self.assertEqual(len(contents), 3)
        for path, epochs in ((early, 4), (self.folder / "after-7-policy.ts.pt", 7)):
            provenance = json.loads(provenance_path(path).read_text())
            self.assertEqual(provenance["training"]["after_epochs"], epochs)
            self.assertEqual(provenance["training"]["epochs"], 10)
            self.assertEqual(
                provenance["checkpoint"]["sha256"], hashlib.sha256(path.read_bytes()).hexdigest()
            )
        self.assertNotIn(
            "after_epochs", json.loads(provenance_path(self.out).read_text())["training"]
        )
        again = self.run_command(self.command("--also-after", "4", out="other.ts.pt"))
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.folder / "after-4-other.ts.pt").read_bytes(), early.read_bytes())

    def test_policy_of_an_earlier_epoch_that_is_there_stays(self) -> None:
        (self.folder / "after-4-policy.ts.pt").write_text("mine")
        finished = self.run_command(self.command("--also-after", "4"))
        self.assert_refused(finished, 2, "after-4-policy.ts.pt: is there already")
        self.assertEqual((self.folder / "after-4-policy.ts.pt").read_text(), "mine")

    def test_killed_at_the_end_it_resumes(self) -> None:
        """Whatever is written of the last checkpoint: its state is there until all is."""
        whole = self.run_command(self.command("--also-after", "4"))
        self.assertEqual(whole.returncode, 0, whole.stderr)
        early, files = self.folder / "after-4-policy.ts.pt", (self.out, provenance_path(self.out))
        wanted = [file.read_bytes() for file in (*files, early)]
        state = self.folder / "policy.ts.pt.training" / "state.pt"
        for left in ((), files[1:], files):
            with self.subTest(files=len(left)):
                self.train_to_the_end_and_stop(state)
                for file in set(files) - set(left):
                    file.unlink()
                again = self.run_command(self.command("--also-after", "4", "--keep"))
                self.assertEqual((again.returncode, again.stderr), (0, ""))
                self.assertEqual([file.read_bytes() for file in (*files, early)], wanted)
                self.assertFalse(state.parent.exists())

    def train_to_the_end_and_stop(self, state: Path) -> None:
        """Leaves the state of a training that was killed before it was removed."""
        demonstrations = read_demonstrations([self.bag])
        recipe = Recipe(epochs=10, batch=16, hidden=(8, 6))
        software_set = training.set_up_torch
        software_set(recipe)
        trainer = Trainer(demonstrations, recipe)
        state.parent.mkdir()
        trainer.run(state, never)

    def test_early_policies_that_are_passed_are_named(self) -> None:
        finished = self.run_command(self.command())
        self.assertEqual(finished.returncode, 0, finished.stderr)
        again = self.run_command(self.command("--also-after", "4", "--keep"))
        self.assertEqual(again.returncode, 2, again.stderr)
        self.assertIn("after-4-policy.ts.pt: is not there; delete ", again.stderr)

    def test_a_stdout_that_closes_ends_several_seeds(self) -> None:
        with subprocess.Popen(
            self.command("--seeds", "3", epochs=600),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            assert process.stdout is not None and process.stderr is not None
            process.stdout.readline()
            process.stdout.close()
            error = process.stderr.read()
            self.assertEqual(process.wait(DEADLINE), 4, error)
        self.assertEqual(error.count("\n"), 1, error)
        self.assertIn("stdout", error)

    def test_several_seeds_have_the_bytes_of_each(self) -> None:
        finished = self.run_command(self.command("--seeds", "3", "--seed", "5"))
        self.assertEqual((finished.returncode, finished.stderr), (0, ""))
        self.assertIn("seed 6: epoch 10/10  train ", finished.stdout)
        self.assertFalse(self.out.exists())
        single = self.run_command(self.command("--seed", "6"))
        self.assertEqual(single.returncode, 0, single.stderr)
        of_seed = [self.folder / f"policy-{seed}.ts.pt" for seed in (5, 6, 7)]
        self.assertEqual(of_seed[1].read_bytes(), self.out.read_bytes())
        self.assertEqual(len({path.read_bytes() for path in of_seed}), 3)
        before = {path: path.stat().st_mtime_ns for path in of_seed}
        of_seed[0].unlink()
        provenance_path(of_seed[0]).unlink()
        again = self.run_command(self.command("--seeds", "3", "--seed", "5"))
        self.assertEqual((again.returncode, again.stderr), (0, ""))
        self.assertIn("policy-6.ts.pt stays: it is this training, finished", again.stdout)
        self.assertEqual(
            [path.stat().st_mtime_ns for path in of_seed[1:]], list(before.values())[1:]
        )
        other = self.run_command(self.command("--seeds", "2", "--seed", "6", epochs=11))
        self.assertEqual(other.returncode, 2, other.stderr)
        self.assertIn("epochs was 10, is now 11; both must agree", other.stderr)

    def test_an_interrupt_of_several_seeds_stops_all_of_them(self) -> None:
        with subprocess.Popen(
            self.command("--seeds", "2", epochs=600),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            assert process.stdout is not None and process.stderr is not None
            while ": epoch " not in process.stdout.readline():
                self.assertIsNone(process.poll())
            process.send_signal(signal.SIGINT)
            process.stdout.read()
            error = process.stderr.read()
            self.assertEqual(process.wait(DEADLINE), 4, error)
        self.assertEqual(
            error, "train: interrupted, states saved; run the same command again to resume\n"
        )
        self.assertEqual(list(self.folder.glob("*.ts.pt")), [])
        resumed = self.run_command(self.command("--seeds", "2", epochs=600))
        self.assertEqual(resumed.returncode, 0, resumed.stderr)
        self.assertIn("resumed after epoch ", resumed.stdout)

    def test_bad_input(self) -> None:
        with self.subTest("bag"):
            command = self.command("--bag", str(self.folder / "absent.bag"))
            self.assert_refused(self.run_command(command), 2, "absent.bag: no such file")
        for option, *values in (
            ("--epochs", "0"),
            ("--lr", "nan"),
            ("--batch", "many"),
            ("--also-after", "10"),
            ("--seeds", "0"),
            ("--seeds", "2", "--threads", "0"),
        ):
            with self.subTest(option):
                finished = self.run_command(self.command(option, *values))
                self.assert_refused(finished, 2, (values[-2:-1] or [option])[0].strip("-"))
        with self.subTest("folder"):
            finished = self.run_command(self.command(out="absent/policy.pt"))
            self.assert_refused(finished, 4, "must be in a folder that is there")
        self.assertEqual(list(self.folder.iterdir()), [self.bag])

    def test_state_folder_in_use(self) -> None:
        folder = self.folder / "state"
        with training.locked(folder):
            finished = self.run_command(self.command("--state-dir", str(folder)))
            self.assert_refused(finished, 2, "in use by another training")

    def test_failing_disk(self) -> None:
        """/proc takes no folders, not even root's."""
        finished = self.run_command(self.command("--state-dir", "/proc/absent"))
        self.assert_refused(finished, 4, "/proc/absent")


if __name__ == "__main__":
    unittest.main()
