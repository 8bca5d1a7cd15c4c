# SPDX-License-Identifier: BSD-3-Clause
"""PyTorch's modules and tensors where a policy is asked. Imports no torch: only a program that has
imported it can have such an object."""

import contextlib
import sys
from typing import Any, Dict, Iterator, Union

import numpy as np
from numpy.typing import NDArray


def is_module(policy: object) -> bool:
    """Whether it is a torch.nn.Module, eager or scripted."""
    torch: Any = sys.modules.get("torch")
    return torch is not None and isinstance(policy, torch.nn.Module)


def as_array(answer: object) -> Any:
    """The answer of a policy as an array of numpy; that of a tensor has no gradient, and is
    single precision where it was half."""
    torch: Any = sys.modules.get("torch")
    if torch is not None and isinstance(answer, torch.Tensor):
        tensor = answer.detach().cpu()
        return (
            tensor.float().numpy()
            if tensor.is_floating_point() and tensor.element_size() == 2
            else tensor.numpy()
        )
    return np.asarray(answer)


class Module:
    """A module as a policy: a function of arrays, on the module's device, in its precision."""

    def __init__(self, module: Any) -> None:
        import torch

        self._module = module
        self._like = next(iter(module.parameters()), torch.empty(0))

    def __call__(self, observations: Union[NDArray[Any], Dict[str, NDArray[Any]]]) -> Any:
        if isinstance(observations, dict):
            return self._module({name: self._tensor(a) for name, a in observations.items()})
        return self._module(self._tensor(observations))

    def _tensor(self, array: NDArray[Any]) -> Any:
        """Images stay bytes."""
        import torch

        tensor = torch.from_numpy(array)
        if array.dtype == np.uint8:
            return tensor.to(self._like.device)
        return tensor.to(self._like.device, self._like.dtype)


@contextlib.contextmanager
def evaluated(module: Any) -> Iterator[object]:
    """The module as a policy, without gradients and in evaluation mode. A module that has begin()
    and act() is one as it is. Afterward each part is in the mode in which it was."""
    import torch

    parts = list(module.modules())
    modes = [getattr(part, "training", False) for part in parts]
    module.eval()
    try:
        with torch.no_grad():
            has_memory = hasattr(module, "begin") and hasattr(module, "act")
            yield module if has_memory else Module(module)
    finally:
        for part, mode in zip(parts, modes):
            if mode:
                part.training = True
