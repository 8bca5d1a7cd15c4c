# SPDX-License-Identifier: BSD-3-Clause
"""A TorchScript checkpoint as ONNX, with its provenance.

The exporter of torch writes the operations of the module as they stand, so that the suite's kernel
gives the bits of the TorchScript.
"""

import contextlib
import ctypes
import hashlib
import inspect
import io
import json
import warnings
from pathlib import Path
from typing import Any, Dict, List, Tuple

import torch

from pusht_policy.checkpoint import (
    PROVENANCE_FORMAT,
    provenance_path,
    read_provenance,
    sha256_of,
)
from pusht_policy.interface import OBSERVATION, numbers_of
from pusht_task.command import require_folder_of, require_new_file
from pusht_task.error import Error, ExitCode
from pusht_task.files import read_file, write_file
from pusht_task.json_file import Json, write_json

OPSET = 14  # version of ONNX's operators; torch 1.13 and 2.6 both write it
SUFFIX = ".onnx"  # by which the suite knows such a file
MARK = b"\x12\x07pytorch"  # the producer, at the beginning of a file that torch exported
DESCRIPTION = "policy.json"  # extra file of a checkpoint with a history, chunks, a state or noise
ARITHMETIC = ("aten::add", "aten::sub", "aten::mul", "aten::div")
ACTION = 2


def export(source: Path, target: Path, overwrite: bool = False) -> None:
    """Writes the checkpoint `source` as ONNX, and its provenance beside it, first.

    Raises Error, and writes nothing, if the checkpoint is not the one of its provenance, is no
    TorchScript, does not map what its description says, or `compare` would refuse the ONNX.
    """
    if target.suffix != SUFFIX:
        raise Error(f"out {target}: must end in {SUFFIX}, by which the suite knows ONNX")
    require_new_file("out", target, MARK if overwrite else None)
    require_folder_of("out", target)
    if not overwrite:
        require_new_file("provenance", provenance_path(target))
    digest = sha256_of(source)
    provenance = _provenance_of(source, digest)
    module, description = load(source)
    content = onnx_bytes(module, str(source), description=description)
    require_runs(content, str(source))
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


def load(path: Path) -> Tuple[torch.jit.ScriptModule, str]:
    """A checkpoint and its description. Raises Error unless it does what that says."""
    extra: Dict[str, Any] = {DESCRIPTION: ""}
    try:
        module = torch.jit.load(io.BytesIO(read_file(path)), "cpu", extra).eval()
    except (RuntimeError, ValueError) as error:
        raise Error(f"{path}: must be TorchScript: {_first_line(error)}") from None
    description = extra[DESCRIPTION]
    description = description.decode() if isinstance(description, bytes) else description
    _restore_numbers(module)
    if description:
        return module, description
    try:
        with torch.no_grad():
            action = module(torch.zeros(1, OBSERVATION))
    except RuntimeError as error:
        reason = f"but fails: {_first_line(error)}"
        raise Error(f"{path}: must map [1, 10] to [1, 2], {reason}", ExitCode.BAD_DEPENDENCY)
    if not isinstance(action, torch.Tensor) or action.shape != (1, ACTION):
        found = list(action.shape) if isinstance(action, torch.Tensor) else type(action).__name__
        raise Error(f"{path}: must map [1, 10] to [1, 2], not to {found}", ExitCode.BAD_DEPENDENCY)
    return module, ""


def _restore_numbers(module: torch.jit.ScriptModule) -> None:
    """Makes numbers of the constants of no dimension that arithmetic takes, as the suite does where
    it loads a module (traced_numbers.cpp): tracing has made tensors of them, of which a tensor of
    integers becomes double."""
    parts = [getattr(part, "_c") for part in module.modules()]
    methods = [part._get_method(name) for part in parts for name in part._method_names()]
    for graph in (method.graph for method in methods):
        _restore_in(graph, graph)


def _restore_in(graph: Any, block: Any) -> None:
    for node in block.nodes():
        for inner in node.blocks():
            _restore_in(graph, inner)
        is_arithmetic = node.kind() in ARITHMETIC and ".Tensor(" in node.schema()
        constant = list(node.inputs())[1].toIValue() if is_arithmetic else None
        if isinstance(constant, torch.Tensor) and constant.dim() == 0:
            number = graph.insertConstant(constant.item())
            number.node().moveBefore(node)
            node.replaceInput(1, number)


def onnx_bytes(
    module: torch.nn.Module, name: str, opset: int = OPSET, description: str = ""
) -> bytes:
    """The module as ONNX, with its description in the metadata. `name` is for messages."""
    if not torch.__version__.startswith("1."):
        import onnx  # type: ignore[import]  # noqa: F401  # later exporters need it
    inputs, outputs, arguments = _signature(description, name)
    options: Dict[str, Any] = {
        "input_names": inputs,
        "output_names": outputs,
        "dynamic_axes": {tensor: {0: "n"} for tensor in (*inputs, *outputs)},
        "opset_version": opset,
    }
    if "dynamo" in inspect.signature(torch.onnx.export).parameters:
        options["dynamo"] = False  # the other exporter needs packages that Debian has not
    saved = io.BytesIO()
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            torch.onnx.export(module, tuple(arguments), saved, **options)
    except RuntimeError as error:
        raise Error(f"{name}: cannot be exported: {_first_line(error)}") from None
    return saved.getvalue() + (_metadata(DESCRIPTION, description) if description else b"")


def require_runs(content: bytes, name: str) -> None:
    """Raises Error if `compare` would refuse this ONNX file."""
    reason = ctypes.create_string_buffer(4096)
    check = ctypes.CDLL("libpusht_onnx_policy.so").checkOnnx
    check.argtypes = (ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t)
    code = check(content, len(content), reason, len(reason))
    if code != 0:
        raise Error(f"{name}: as {reason.value.decode()}", ExitCode(code))


def _signature(description: str, name: str) -> Tuple[List[str], List[str], List[torch.Tensor]]:
    """Names of inputs and outputs, and inputs of one rollout."""
    if not description:
        return ["observation"], ["action"], [torch.zeros(1, OBSERVATION)]
    try:
        fields = json.loads(description)
        inputs = {"observations": [fields["observations"], numbers_of(fields)]}
        inputs.update({key: fields[key]["shape"] for key in ("state", "noise") if key in fields})
        arguments = [torch.zeros(1, *shape) for shape in inputs.values()]
    except (ValueError, KeyError, TypeError, RuntimeError) as error:
        raise Error(f"{name}: {DESCRIPTION} must be a description: {error!r}") from None
    outputs = ["actions", "next_state"] if "state" in inputs else ["actions"]
    return list(inputs), outputs, arguments


def _metadata(key: str, value: str) -> bytes:
    """An entry of a model's metadata (field 14) as protobuf has it: appended, it is part of it."""

    def field(number: int, content: bytes) -> bytes:
        size, length = len(content), b""
        while size > 127:
            length += bytes([size % 128 + 128])
            size //= 128
        return bytes([number * 8 + 2]) + length + bytes([size]) + content

    return field(14, field(1, key.encode()) + field(2, value.encode()))


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
