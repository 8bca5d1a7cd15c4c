# SPDX-License-Identifier: BSD-3-Clause
"""Interfaces of policies: which numbers they see of an observation, and the task that has them."""

import ctypes
from typing import Any, Dict, Mapping, NamedTuple

import numpy as np
from pusht_task.error import Error

OBSERVATION = 10  # numbers
NUMBERS = ctypes.POINTER(ctypes.c_float)


class Interface(NamedTuple):
    """What a policy sees."""

    task: str
    keypoints: int = 0  # points of the tee; 0: its pose
    agent_first: bool = True

    def numbers(self) -> int:
        """How many numbers it sees."""
        return OBSERVATION if self.task == "full_circle" else self._look(0, None, None)

    def fields(self, name: str) -> Dict[str, Any]:
        """What a description says of it; the default is left out."""
        if self.task == "full_circle":
            return {}
        points = {"keypoints": self.keypoints, "agent": "first" if self.agent_first else "last"}
        return {"interface": name, **(points if self.keypoints else {})}

    def seen(self, observations: np.ndarray) -> np.ndarray:
        """float32 [n, numbers()] of observations float32 [n, 10], by the suite's own code."""
        if self.task == "full_circle":
            return observations
        rows = np.ascontiguousarray(observations, np.float32)
        seen = np.empty((len(rows), self.numbers()), np.float32)
        self._look(len(rows), rows.ctypes.data_as(NUMBERS), seen.ctypes.data_as(NUMBERS))
        return seen

    def _look(self, rows: int, observations: Any, seen: Any) -> int:
        look = ctypes.CDLL("libpusht_task.so").seenOfGymPusht
        look.argtypes = (ctypes.c_int, ctypes.c_int, NUMBERS, ctypes.c_size_t, NUMBERS)
        return int(look(self.keypoints, self.agent_first, observations, rows, seen))


INTERFACES: Mapping[str, Interface] = {
    "full_circle": Interface("full_circle"),
    "gym_state": Interface("gym_pusht"),
    "gym_keypoints": Interface("gym_pusht", keypoints=8),  # LeRobot's
}


def numbers_of(description: Mapping[str, Any]) -> int:
    """How many numbers a policy of this description sees."""
    interface = INTERFACES[description.get("interface", "full_circle")]
    return interface._replace(keypoints=int(description.get("keypoints", 0))).numbers()


def require_task(bag: object, name: str, task: str) -> None:
    """Raises Error unless demonstrations of this task show what the interface has."""
    if INTERFACES[name].task != task:
        known = [other for other, interface in INTERFACES.items() if interface.task == task]
        raise Error(
            f"{bag}: is of the task {task}; interface {name} must be {' or '.join(known) or 'none'}"
        )
