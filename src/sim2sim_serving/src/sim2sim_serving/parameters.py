# SPDX-License-Identifier: BSD-3-Clause
"""Parameters of a simulator as names with values, as messages, and under a hash."""

import hashlib
import json
import math
from typing import Any, Dict, List, Mapping, Optional, Sequence, Union

from pusht_msgs.msg import Parameter, ParameterDescriptor  # type: ignore[import]

from pusht_task.error import Error

Value = Union[bool, int, float, str]  # value of a parameter
KINDS = {bool: "true or false", int: "an integer", float: "a finite number", str: "a text"}
TYPES = {bool: "boolean", int: "integer", float: "real", str: "text"}  # in ParameterDescriptor


def merged(
    parameters: Mapping[str, Value], changes: Mapping[str, object], namespace: str = ""
) -> Dict[str, Value]:
    """`changes` on top of `parameters`, whose types they must have; an integer is a real too."""
    result = dict(parameters)
    for name, value in changes.items():
        if name not in parameters:
            raise Error(
                f"parameter {namespace}{name}: unknown; "
                f"known: {', '.join(parameters) or 'none'}"
            )
        kind = type(parameters[name])
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
            raise Error(f"parameter {namespace}{name} {value}: must be {KINDS[kind]}")
        result[name] = value  # type: ignore[assignment]
    return result


def require_once(parameters: Sequence[Any]) -> None:
    """Raises Error for a parameter that is named twice: which value counts would be a guess."""
    values: Dict[str, str] = {}
    for parameter in parameters:
        if parameter.name in values:
            both = f"{values[parameter.name]}, {parameter.value}"
            raise Error(f"parameter {parameter.name} {both}: must be set once")
        values[parameter.name] = parameter.value


def from_text(text: str, default: Optional[Value]) -> object:
    """The value of a text, for a parameter with that default; its type is still to be checked."""
    if isinstance(default, str):
        return text
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _to_text(value: Value) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def parameter_messages(parameters: Mapping[str, Value]) -> List[Parameter]:
    """Parameters as messages, in their order."""
    return [Parameter(name=name, value=_to_text(value)) for name, value in parameters.items()]


def descriptor(name: str, default: Value) -> ParameterDescriptor:
    """Description of a parameter of which only the default is known."""
    return ParameterDescriptor(
        name=name,
        type=TYPES[type(default)],
        default_value=_to_text(default),
        least=-math.inf,
        greatest=math.inf,
    )


def hash_of(parameters: Mapping[str, Value]) -> str:
    """Hash of names and values, 12 hexadecimal digits; empty without parameters."""
    if not parameters:
        return ""
    key = "".join(f"{name}={_to_text(value)}|" for name, value in parameters.items())
    return hashlib.sha256(key.encode()).hexdigest()[:12]
