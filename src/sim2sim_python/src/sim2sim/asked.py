# SPDX-License-Identifier: BSD-3-Clause
"""What a program names as a policy, as the extension takes it."""

import contextlib
import os
from typing import Iterator, NamedTuple, Optional

from sim2sim import tensors
from sim2sim.checks import checked_integer
from sim2sim.errors import InvalidInput


class Asked(NamedTuple):
    """A policy that is to be asked."""

    callable: object  # None: the suite has it under its name
    name: str  # of the callable; of others the name or path
    history: int  # observations that a callable looks back on; 0: one, without a history


@contextlib.contextmanager
def asked(
    policy: object,
    *,
    history: Optional[int] = None,
    version: Optional[str] = None,
    obs_type: Optional[str] = None,
) -> Iterator[Asked]:
    """The policy while it is asked: a module of PyTorch without gradients, in evaluation mode.

    Raises InvalidInput for what is no policy, and for options that need a callable.
    """
    if isinstance(policy, (str, os.PathLike)):
        _require_left_out(history=history, version=version, obs_type=obs_type)
        yield Asked(None, os.fspath(policy), 0)
        return
    _require_callable(policy)
    looks_back = 0 if history is None else checked_integer("history", history, 1, 1000)
    name = _name_of(policy)
    is_module = tensors.is_module(policy)
    with tensors.evaluated(policy) if is_module else contextlib.nullcontext(policy) as it:
        yield Asked(it, name, looks_back)


def _require_callable(policy: object) -> None:
    if not callable(policy) and not (hasattr(policy, "begin") and hasattr(policy, "act")):
        raise InvalidInput(
            f"policy {policy!r}: must be a name, a file, a callable, or an object with begin() "
            "and act()"
        )


def _require_left_out(**given: object) -> None:
    for name, value in given.items():
        if value is not None:
            raise InvalidInput(f"{name} {value}: must be left out unless the policy is a callable")


def _name_of(policy: object) -> str:
    """Module and qualified name of a callable, or of its class; a scripted module knows that of
    the class that was scripted."""
    if tensors.is_module(policy) and hasattr(policy, "original_name"):
        return f"torch.jit.{getattr(policy, 'original_name')}"
    named = policy if hasattr(policy, "__qualname__") else type(policy)
    return f"{getattr(named, '__module__', None) or '?'}.{getattr(named, '__qualname__')}"
