# SPDX-License-Identifier: BSD-3-Clause
"""The rules of a served policy, without a node: requests in, replies out."""

import threading
from typing import Any, Callable, Sequence

import numpy as np
from pusht_msgs.srv import ActResponse, DescribeResponse  # type: ignore[import]

from pusht_task.error import Error, ExitCode
from pusht_task.session import FOREIGN, Identity, provenance, refused, reported

Act = Callable[[np.ndarray], Any]  # float32 [n, 10] to [n, 2], as in Query.msg and Act.srv


class PolicySession:
    """A served policy without a memory: the same query gets the same answer."""

    def __init__(self, act: Act, identity: Identity) -> None:
        self._act = act
        self._identity = identity
        self._lock = threading.Lock()

    def act(self, request: Any) -> ActResponse:
        with self._lock:
            try:
                actions = self._actions(request.queries)
            except Error as refusal:
                return refused(ActResponse, refusal, self._identity)
        return ActResponse(
            success=True, instance_id=self._identity.instance_id, actions=actions.ravel().tolist()
        )

    def describe(self, _request: Any = None) -> DescribeResponse:
        return DescribeResponse(
            success=True,
            instance_id=self._identity.instance_id,
            name=self._identity.name,
            version=self._identity.version,
            provenance=provenance(),
        )

    def _actions(self, queries: Sequence[Any]) -> np.ndarray:
        if not queries:
            return np.empty((0, 2), dtype=np.float32)
        observations = np.array([query.observation for query in queries], dtype=np.float32)
        for query, finite in zip(queries, np.isfinite(observations).all(axis=1)):
            if not finite:
                raise Error(f"rollout {query.rollout}: observation must be finite")
        try:
            actions = np.asarray(self._act(observations), dtype=np.float32)
        except FOREIGN as error:
            raise Error(f"act: {reported(error)}", ExitCode.RUNTIME_FAULT) from error
        if actions.shape != (len(queries), 2):
            raise Error(
                f"act: shape {list(actions.shape)} of the actions: must be [{len(queries)}, 2]",
                ExitCode.BAD_DEPENDENCY,
            )
        return actions
