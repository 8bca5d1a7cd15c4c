#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Policies in ONNX: exported, run, and refused, as a user of the commands meets them."""

import json
import unittest
from pathlib import Path
from typing import Any, Callable, Dict, Optional

import onnx  # type: ignore[import]
import rospkg  # type: ignore[import]
import torch
from pusht_testing.warm_commands import warm

from command_case import CommandCase, executable
from torch_policies import Charge

COMPARE = executable("sim2sim_eval", "compare")
SWEEP = executable("sim2sim_eval", "sweep")
EXPORT = executable("pusht_policy", "export_onnx")
warm([EXPORT], "pusht_policy.onnx_export")
SHIPPED = Path(rospkg.RosPack().get_path("pusht_policy"), "policies", "bc_policy.ts.pt")


class Wide(torch.nn.Module):
    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        return obs * 2.0


class Softmax(torch.nn.Module):
    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        return torch.softmax(obs[:, :2], 1)


class Linear(torch.nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.layer = torch.nn.Linear(10, 2)

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        return self.layer(obs)


class OnnxCase(CommandCase):
    def saved(self, module: torch.nn.Module, extra: Optional[Dict[str, str]] = None) -> str:
        """A TorchScript file without a provenance."""
        path = self.folder / "policy.ts.pt"
        torch.jit.save(torch.jit.script(module.eval()), str(path), _extra_files=extra or {})
        return path.name

    def exported(self, source: str, out: str = "policy.onnx") -> str:
        self.run_all((EXPORT, source, out))
        return out

    def compared(self, policy: str, out: str, *more: str) -> Dict[str, Any]:
        self.run_all((COMPARE, "--policy", policy, "--episodes", "3", "--out", out, *more))
        return self.load(out, "provenance.json")


class Policies(OnnxCase):
    def test_shipped_policy_gives_the_bytes_of_its_torchscript(self) -> None:
        policy = self.exported(str(SHIPPED))
        provenance = self.compared(policy, "onnx")["policy"]
        shipped = self.compared("bc", "torchscript")["policy"]
        for name in ("episodes.csv", "divergence.csv"):
            self.assertEqual(
                (self.folder / "onnx" / name).read_bytes(),
                (self.folder / "torchscript" / name).read_bytes(),
            )
        self.assertEqual(provenance["operations"], shipped["operations"])
        self.assertEqual(provenance["runs_on"], "fixed-order kernel")
        self.assertEqual(provenance["onnx"]["opset"], 14)
        self.assertNotEqual(provenance["sha256"], shipped["sha256"])

    def test_needs_no_libtorch(self) -> None:
        policy = self.exported(str(SHIPPED))
        process = self.run_command(
            *(COMPARE, "--policy", policy, "--episodes", "1", "--out", "out"),
            environment={"LD_DEBUG": "files"},
        )
        self.assertEqual(process.returncode, 0)
        self.assertIn("libpusht_onnx_policy.so", process.stderr)
        self.assertNotIn("libtorch", process.stderr)

    def test_plan_takes_patterns_and_both_formats_in_one_process(self) -> None:
        script = self.saved(Charge())
        torch.manual_seed(0)
        for name in ("one", "two"):
            torch.jit.save(torch.jit.script(Linear().eval()), str(self.folder / f"{name}.ts.pt"))
            self.exported(f"{name}.ts.pt", f"{name}.onnx")
        plan = {"policies": ["*.onnx", script, "two.ts.pt"], "episodes": 1, "engine": ["two_mass"]}
        (self.folder / "plan.yaml").write_text(json.dumps(plan))
        self.run_all((SWEEP, "plan.yaml", "--out", "sweep"))
        rows = (self.folder / "sweep" / "sweep.csv").read_text().splitlines()
        column = rows[0].split(",").index("policy")
        self.assertEqual(
            [row.split(",")[column] for row in rows[1:]],
            ["one.onnx", "two.onnx", script, "two.ts.pt"],
        )

    def test_home_is_that_of_the_torchscript(self) -> None:
        self.exported(str(SHIPPED))
        plan = {"policies": ["policy.onnx"], "reference": "home", "episodes": 1}
        (self.folder / "plan.yaml").write_text(json.dumps({**plan, "engine": ["two_mass"]}))
        self.run_all((SWEEP, "plan.yaml", "--out", "sweep"))
        self.assertIn("mujoco", (self.folder / "sweep" / "sweep.json").read_text())


class Refusals(OnnxCase):
    def refused(self, code: int, policy: str) -> str:
        process = self.run_command(COMPARE, "--policy", policy, "--out", "out")
        self.assert_one_line(process, code, "compare")
        self.assertIn(f"policy {policy}: ", process.stderr)
        self.assertFalse((self.folder / "out").exists(), "a refused run leaves no folder")
        return process.stderr

    def changed(self, change: Callable[[Any], object]) -> str:
        """An ONNX file without a provenance, changed."""
        torch.manual_seed(0)
        self.exported(self.saved(Linear()), "whole.onnx")
        model = onnx.load(str(self.folder / "whole.onnx"))
        change(model)
        (self.folder / "changed.onnx").write_bytes(model.SerializeToString())
        (self.folder / "whole.onnx").unlink()
        (self.folder / "whole.onnx.provenance.json").unlink()
        return "changed.onnx"

    def test_f5_file_that_is_no_onnx(self) -> None:
        whole = Path(self.folder / self.exported(self.saved(Linear()))).read_bytes()
        for name, content, reason in (
            ("empty.onnx", b"", "must be ONNX, but is empty"),
            ("half.onnx", whole[: len(whole) // 2], "must be ONNX: protobuf cannot read it"),
            ("random.onnx", bytes(range(256)) * 20, "must be ONNX"),
            ("script.onnx", SHIPPED.read_bytes(), "is a zip archive, as TorchScript is"),
        ):
            (self.folder / name).write_bytes(content)
            self.assertIn(reason, self.refused(2, name))
        with (self.folder / "large.onnx").open("wb") as file:
            file.truncate(3_000_000_000)
        self.assertIn("must have at most 2147483647 bytes", self.refused(2, "large.onnx"))
        self.assertIn("must be a readable file", self.refused(2, "none.onnx"))

    def test_f5_network_that_the_kernel_does_not_know(self) -> None:
        def with_softmax(model: Any) -> None:
            model.graph.node[-1].output[0] = "product"
            node = onnx.helper.make_node("Softmax", ["product"], ["action"], name="last")
            model.graph.node.append(node)

        line = self.refused(2, self.changed(with_softmax))
        self.assertIn(
            "operator 'Softmax' of node 'last': is not known to the kernel; docs/net", line
        )

        def of_another_opset(model: Any) -> None:
            model.opset_import[0].version = 99

        line = self.refused(2, self.changed(of_another_opset))
        self.assertIn("opset 99: must be from 7 to 22", line)

    def test_f5_tensor_that_is_not_in_the_file(self) -> None:
        def of_two_gigabytes(model: Any) -> None:
            model.graph.initializer[0].dims[0] = 53687091

        self.assertIn(
            "must hold the values of its", self.refused(2, self.changed(of_two_gigabytes))
        )

        def of_negative_size(model: Any) -> None:
            model.graph.initializer[0].dims[0] = -2

        self.assertIn("must not be negative", self.refused(2, self.changed(of_negative_size)))

        def elsewhere(model: Any) -> None:
            tensor = model.graph.initializer[0]
            tensor.data_location = onnx.TensorProto.EXTERNAL
            tensor.external_data.add(key="location", value="weights.bin")

        self.assertIn("weights.bin: must be a readable", self.refused(2, self.changed(elsewhere)))

    def test_f6_file_that_is_not_the_one_in_its_provenance(self) -> None:
        path = self.folder / self.exported(self.saved(Linear()))
        damaged = bytearray(path.read_bytes())
        damaged[len(damaged) // 2] ^= 1
        path.write_bytes(damaged)
        self.assertIn("SHA-256", self.refused(3, "policy.onnx"))

    def test_f7_network_that_does_not_fit(self) -> None:
        def of_eight_inputs(model: Any) -> None:
            model.graph.input[0].type.tensor_type.shape.dim[1].dim_value = 8

        line = self.refused(3, self.changed(of_eight_inputs))
        self.assertIn("input 'observation': must be FLOAT [n, 10] or [1, 10], but is", line)

        def of_nan(model: Any) -> None:
            tensor = model.graph.initializer[0]
            tensor.raw_data = b"\0\0\xc0\x7f" + tensor.raw_data[4:]

        self.assertIn("its values must be finite", self.refused(3, self.changed(of_nan)))


class Export(OnnxCase):
    def refused(self, code: int, *arguments: str) -> str:
        before = self.files(".")
        process = self.run_command(EXPORT, *arguments)
        self.assert_one_line(process, code, "export_onnx")
        self.assertEqual(self.files("."), before)
        return process.stderr

    def test_says_where_the_file_comes_from(self) -> None:
        self.exported(str(SHIPPED))
        provenance = self.load(".", "policy.onnx.provenance.json")
        of_shipped = json.loads(Path(f"{SHIPPED}.provenance.json").read_text())
        self.assertEqual(provenance["demonstrations"], of_shipped["demonstrations"])
        self.assertEqual(provenance["exported"]["from"], of_shipped["checkpoint"])
        self.assertEqual(provenance["exported"]["torch"], torch.__version__)
        self.assertIsNone(provenance["evaluation"])

    def test_replaces_only_what_it_wrote(self) -> None:
        script = self.saved(Linear())
        first = (self.folder / self.exported(script)).read_bytes()
        self.assertIn("is there already", self.refused(2, script, "policy.onnx"))
        self.run_all((EXPORT, script, "policy.onnx", "--overwrite"))
        self.assertEqual((self.folder / "policy.onnx").read_bytes(), first)
        (self.folder / "other.onnx").write_text("mine")
        line = self.refused(2, script, "other.onnx", "--overwrite")
        self.assertIn("is not this command's own", line)

    def test_refuses_what_is_no_such_network(self) -> None:
        (self.folder / "text.ts.pt").write_text("no archive")
        self.assertIn("must be TorchScript", self.refused(2, "text.ts.pt", "a.onnx"))
        self.assertIn("no such file", self.refused(2, "none.ts.pt", "a.onnx"))
        script = self.saved(Linear())
        self.assertIn("must end in .onnx", self.refused(2, script, "a.pt"))
        line = self.refused(3, self.saved(Wide()), "a.onnx")
        self.assertIn("must map [1, 10] to [1, 2], not to [1, 10]", line)
        described = self.saved(Linear(), {"policy.json": "{}"})
        self.assertIn("policy.json must be a description", self.refused(2, described, "a.onnx"))

    def test_refuses_what_compare_would(self) -> None:
        line = self.refused(2, self.saved(Softmax()), "a.onnx")
        self.assertIn("as ONNX: operator 'Softmax' of node", line)
        self.assertIn("is not known to the kernel", line)

    def test_refuses_a_checkpoint_that_is_not_the_one_in_its_provenance(self) -> None:
        script = self.saved(Linear())
        provenance = {"format": 1, "checkpoint": {"sha256": "0" * 64}}
        (self.folder / f"{script}.provenance.json").write_text(json.dumps(provenance))
        self.assertIn("its SHA-256 is", self.refused(3, script, "a.onnx"))


if __name__ == "__main__":
    unittest.main()
