# SPDX-License-Identifier: BSD-3-Clause
"""Checks of what a program hands over. Each raises InvalidInput, with thing, value and rule."""

import os
from typing import Any, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from sim2sim.errors import InvalidInput

OBSERVATION = 10  # numbers
LARGEST_SEED = 2**64 - 1


def checked_integer(name: str, value: object, least: int, greatest: int) -> int:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise InvalidInput(f"{name} {value!r}: must be an integer")
    if not least <= value <= greatest:
        raise InvalidInput(f"{name} {value}: must be from {least} to {greatest}")
    return int(value)


def checked_text(name: str, value: object) -> str:
    if not isinstance(value, str) or "\0" in value:
        raise InvalidInput(f"{name} {value!r}: must be text without NUL characters")
    return value


def checked_path(name: str, value: object) -> str:
    if not isinstance(value, (str, os.PathLike)):
        raise InvalidInput(f"{name} {value!r}: must be a name or a path")
    return checked_text(name, os.fspath(value))


def checked_mapping(name: str, value: object) -> Mapping[Any, Any]:
    """None is an empty one."""
    if value is not None and not isinstance(value, Mapping):
        raise InvalidInput(f"{name} {value!r}: must be a dict")
    return value or {}


def checked_option(options: object, known: str) -> Any:
    """The only option that a reset knows; None: it is not there."""
    given = checked_mapping("options", options)
    unknown = set(given) - {known}
    if unknown:
        raise InvalidInput(f"options {sorted(map(str, unknown))}: unknown; known: {known}")
    return given.get(known)


def checked_list(name: str, value: object) -> List[Any]:
    if not isinstance(value, (list, tuple, np.ndarray)):
        raise InvalidInput(f"{name} {value!r}: must be a list")
    return list(value)


def checked_seed(seed: object) -> int:
    return checked_integer("seed", seed, 0, LARGEST_SEED)


def checked_number(name: str, value: object) -> float:
    if isinstance(value, (bool, np.bool_)) or not isinstance(
        value, (int, float, np.integer, np.floating)
    ):
        raise InvalidInput(f"{name} {value!r}: must be a number")
    return float(value)


def checked_numbers(
    name: str, given: object, shape: Optional[Sequence[Optional[int]]] = None
) -> NDArray[Any]:
    """`given` as an array of real numbers. None in `shape`: any length; no shape: a list."""
    shape = (None,) if shape is None else shape
    try:
        array = np.asarray(given)
    except ValueError as error:  # rows of different lengths
        raise InvalidInput(f"{name} {given!r}: {error}") from None
    if array.size == 0 and None in shape:
        array = array.astype(float)  # an empty list has no type of its own
    if array.dtype.kind not in "fiu" or not _fits(array.shape, shape):
        raise InvalidInput(
            f"{name} {array.dtype} of shape {array.shape}: must be real numbers of shape "
            + _text_of(shape)
        )
    return array


def _fits(found: Tuple[int, ...], wanted: Sequence[Optional[int]]) -> bool:
    return len(found) == len(wanted) and all(w in (None, f) for f, w in zip(found, wanted))


def _text_of(shape: Sequence[Optional[int]]) -> str:
    lengths = ["n" if length is None else str(length) for length in shape]
    return f"({lengths[0]},)" if len(lengths) == 1 else f"({', '.join(lengths)})"
