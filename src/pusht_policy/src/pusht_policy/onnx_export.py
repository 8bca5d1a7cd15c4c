# SPDX-License-Identifier: BSD-3-Clause
"""A TorchScript checkpoint as ONNX, with its provenance.

The exporter of torch writes the operations of the module as they stand, so that the suite's kernel
gives the bits of the TorchScript.
"""

import contextlib
import hashlib
import inspect
import io
import warnings
from pathlib import Path
from typing import Any, Dict

import torch

from pusht_policy.checkpoint import (
    PROVENANCE_FORMAT,
    provenance_path,
    read_provenance,
    sha256_of,
)
from pusht_task.command import require_folder_of, require_new_file
from pusht_task.error import Error, ExitCode
from pusht_task.files import read_file, write_file
from pusht_task.json_file import Json, write_json

OPSET = 14  # version of ONNX's operators; torch 1.13 and 2.6 both write it
SUFFIX = ".onnx"  # by which the suite knows such a file
MARK = b"\x12\x07pytorch"  # the producer, at the beginning of a file that torch exported
DESCRIPTION = "policy.json"  # extra file of a checkpoint with a history, chunks, a state or noise
OBSERVATION = 10
ACTION = 2


def export(source: Path, target: Path, overwrite: bool = False) -> None:
    """Writes the checkpoint `source` as ONNX, and its provenance beside it, first.

    Raises Error, and writes nothing, if the checkpoint is not the one of its provenance, is no
    TorchScript, or is anything but a network from [n, 10] to [n, 2].
    """
    if target.suffix != SUFFIX:
        raise Error(f"out {target}: must end in {SUFFIX}, by which the suite knows ONNX")
    require_new_file("out", target, MARK if overwrite else None)
    require_folder_of("out", target)
    if not overwrite:
        require_new_file("provenance", provenance_path(target))
    digest = sha256_of(source)
    provenance = _provenance_of(source, digest)
    content = onnx_bytes(load(source), str(source))
    provenance.update(
        checkpoint={"file": target.name, "sha256": hashlib.sha256(content).hexdigest()},
        exported={
            "from": {"file": source.name, "sha256": digest},
            "torch": torch.__version__,
            "opset": OPSET,
        },
        evaluation=None,  # of another file
    )
    write_json(provenance_path(target), provenance)
    write_file(target, content)


def load(path: Path) -> torch.jit.ScriptModule:
    """The module of a checkpoint. Raises Error unless it maps float32 [1, 10] to [1, 2], alone."""
    extra: Dict[str, Any] = {DESCRIPTION: ""}
    try:
        module = torch.jit.load(io.BytesIO(read_file(path)), "cpu", extra).eval()
    except (RuntimeError, ValueError) as error:
        raise Error(f"{path}: must be TorchScript: {_first_line(error)}") from None
    if extra[DESCRIPTION]:
        raise Error(f"{path}: must have no {DESCRIPTION}: ONNX here is a network without a memory")
    try:
        with torch.no_grad():
            action = module(torch.zeros(1, OBSERVATION))
    except RuntimeError as error:
        reason = f"but fails: {_first_line(error)}"
        raise Error(f"{path}: must map [1, 10] to [1, 2], {reason}", ExitCode.BAD_DEPENDENCY)
    if not isinstance(action, torch.Tensor) or action.shape != (1, ACTION):
        found = list(action.shape) if isinstance(action, torch.Tensor) else type(action).__name__
        raise Error(f"{path}: must map [1, 10] to [1, 2], not to {found}", ExitCode.BAD_DEPENDENCY)
    return module


def onnx_bytes(module: torch.nn.Module, name: str, opset: int = OPSET) -> bytes:
    """The module as ONNX, from observation [n, 10] to action [n, 2]. `name` is for messages."""
    if not torch.__version__.startswith("1."):
        import onnx  # type: ignore[import]  # noqa: F401  # later exporters need it
    options: Dict[str, Any] = {
        "input_names": ["observation"],
        "output_names": ["action"],
        "dynamic_axes": {"observation": {0: "n"}, "action": {0: "n"}},
        "opset_version": opset,
    }
    if "dynamo" in inspect.signature(torch.onnx.export).parameters:
        options["dynamo"] = False  # the other exporter needs packages that Debian has not
    saved = io.BytesIO()
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            torch.onnx.export(module, (torch.zeros(1, OBSERVATION),), saved, **options)
    except RuntimeError as error:
        raise Error(f"{name}: cannot be exported: {_first_line(error)}") from None
    return saved.getvalue()


def _provenance_of(source: Path, digest: str) -> Json:
    if not provenance_path(source).exists():
        return {"format": PROVENANCE_FORMAT}
    provenance = read_provenance(source)
    expected = provenance.get("checkpoint", {}).get("sha256")
    if digest != expected:
        raise Error(
            f"{source}: its SHA-256 is {digest}, must be {expected} ({provenance_path(source)})",
            ExitCode.BAD_DEPENDENCY,
        )
    return provenance


def _first_line(error: Exception) -> str:
    """The reason among the lines of an error of torch."""
    text = str(error).rpartition("RuntimeError: ")[2].strip()
    return text.splitlines()[0] if text else type(error).__name__
