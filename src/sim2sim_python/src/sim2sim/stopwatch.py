# SPDX-License-Identifier: BSD-3-Clause
"""Where the time of a comparison goes."""

import time
from types import SimpleNamespace
from typing import Any, Callable, Dict


class Stopwatch:
    """Seconds of a run, and of what it calls in Python."""

    def __init__(self) -> None:
        self._begin = time.perf_counter()
        self._spent = {"observations": 0.0, "policy": 0.0}

    def timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, whose seconds count as that part."""

        def call(*arguments: Any) -> Any:
            begin = time.perf_counter()
            try:
                return function(*arguments)
            finally:
                self._spent[part] += time.perf_counter() - begin

        return call

    def timed_policy(self, policy: Any) -> Any:
        """A callable, or an object with begin() and act(), whose answers count."""
        if hasattr(policy, "begin") and hasattr(policy, "act"):
            return SimpleNamespace(begin=policy.begin, act=self.timed("policy", policy.act))
        return self.timed("policy", policy)

    def seconds(self) -> Dict[str, float]:
        """Seconds until now: of all, and of the parts that run in Python. The rest is of the
        worlds and the statistics."""
        return {"all": time.perf_counter() - self._begin, **self._spent}
