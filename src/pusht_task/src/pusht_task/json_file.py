# SPDX-License-Identifier: BSD-3-Clause
"""JSON files: objects of finite numbers, with the number of their format."""

import json
from pathlib import Path
from typing import Any, Dict

from pusht_task.error import Error
from pusht_task.files import read_text, write_file

Json = Dict[str, Any]  # the content of a file: an object


def read_json(path: Path, rule: str = "it is needed") -> Json:
    """The object in a JSON file. `rule` says why the file must be there.

    Raises Error for anything else in the file, and for numbers that are not finite.
    """
    try:
        content = json.loads(read_text(path), parse_float=_finite, parse_constant=_finite)
    except (FileNotFoundError, NotADirectoryError):
        raise Error(f"{path}: no such file; {rule}") from None
    except ValueError as error:
        raise Error(f"{path}: must be JSON: {error}") from None
    except RecursionError:
        raise Error(f"{path}: must be JSON that is less deeply nested") from None
    if not isinstance(content, dict):
        raise Error(f"{path}: must be a JSON object")
    return content


def require_format(thing: object, content: Json, expected: int) -> None:
    """Raises Error, with the name of the thing, for content of another version of the suite."""
    found = content.get("format")
    if found != expected:
        raise Error(f"{thing}: format {found!r}: must be {expected}")


def write_json(path: Path, content: Json) -> None:
    """Writes a file that is complete or absent, its keys in order."""
    write_file(path, (json.dumps(content, indent=2, sort_keys=True) + "\n").encode())


def _finite(text: str) -> float:
    value = float(text)
    if value - value != 0.0:
        raise ValueError(f"{text[:40]}: must be a finite number")
    return value
