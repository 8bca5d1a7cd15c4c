# SPDX-License-Identifier: BSD-3-Clause
"""Writes TorchScript checkpoints and the ONNX files of torch's exporter: make_onnx.py POLICIES OUT

NAME.ts.pt belongs to NAME.onnx and to all NAME-*.onnx.
"""

import json
import shutil
import sys
from pathlib import Path
from typing import Any, Dict, Tuple

import torch
from make_checkpoints import (
    HIDDEN,
    OBSERVATION,
    Chunks,
    Denoising,
    Gated,
    LongMemory,
    Normalized,
    Recurrent,
    Residual,
    TakesSingleRows,
    TwoHeads,
    activations,
    batch_norm,
    layer_norm,
    perceptron,
    with_extras,
)
from pusht_policy.onnx_export import export, onnx_bytes
from torch import nn

OPSETS = (9, 11, 13, 14, 17)


class Spelled(nn.Module):
    """Operations in other words than nn.Linear."""

    def __init__(self) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.rand(2, OBSERVATION) - 0.5)
        self.bias = nn.Parameter(torch.rand(2))
        self.register_buffer("scale", torch.tensor(0.5, dtype=torch.float64))

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        x = torch.neg(1 - obs) * self.scale
        y = x @ self.weight.t() + self.bias
        return self.bias - torch.tanh(y.clamp(max=0.5))


def graphs() -> Dict[str, nn.Module]:
    return {
        "residual": Residual(),
        "gated": Gated(),
        "two_heads": TwoHeads(),
        "layer_norm": Normalized(layer_norm()),
        "batch_norm": Normalized(batch_norm()),
        **activations(),
    }


def described() -> Dict[str, Tuple[nn.Module, Dict[str, Any]]]:
    noise = {"shape": [8, 2], "distribution": "normal"}
    return {
        "chunks": (Chunks(), {"observations": 2, "actions": 8, "execute": 4}),
        "noise": (Denoising(), {"observations": 2, "actions": 8, "execute": 4, "noise": noise}),
        "gru": (Recurrent(True), {"observations": 1, "actions": 1, "state": {"shape": [HIDDEN]}}),
        "lstm": (
            LongMemory(),
            {"observations": 3, "actions": 1, "state": {"shape": [2, 2, HIDDEN]}},
        ),
    }


def main() -> None:
    policies, out = Path(sys.argv[1]), Path(sys.argv[2])
    torch.manual_seed(0)
    modules = {
        "course": Normalized(perceptron()),
        "rows": TakesSingleRows(perceptron()),
        "extras": Normalized(with_extras()),
        "spelled": Spelled(),
    }
    for name, module in modules.items():
        script = torch.jit.script(module.eval())
        script.save(str(out / f"{name}.ts.pt"))
        for opset in OPSETS if name in ("course", "extras") else (14,):
            (out / f"{name}-{opset}.onnx").write_bytes(onnx_bytes(script, name, opset))
        (out / f"{name}-module.onnx").write_bytes(onnx_bytes(module, name))
    for name, module in graphs().items():
        script = torch.jit.script(module.eval())
        script.save(str(out / f"graph_{name}.ts.pt"))
        for opset in (14, 17) if name == "layer_norm" else (14,):
            (out / f"graph_{name}-{opset}.onnx").write_bytes(onnx_bytes(script, name, opset))
    for name, (module, fields) in described().items():
        path = out / f"described_{name}.ts.pt"
        extra = {"policy.json": json.dumps({"format": 1, **fields})}
        torch.jit.save(torch.jit.script(module.eval()), str(path), _extra_files=extra)
        export(path, out / f"described_{name}.onnx")
    shutil.copy(policies / "bc_policy.ts.pt", out / "shipped.ts.pt")
    export(out / "shipped.ts.pt", out / "shipped.onnx")


if __name__ == "__main__":
    main()
