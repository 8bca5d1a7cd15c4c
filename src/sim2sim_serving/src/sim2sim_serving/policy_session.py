# SPDX-License-Identifier: BSD-3-Clause
"""The rules of a served policy, without a node: requests in, replies out."""

import threading
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Sequence, Union

import numpy as np
from pusht_msgs.srv import ActResponse, DescribeResponse  # type: ignore[import]

from pusht_task.error import Error, ExitCode
from pusht_task.task import FULL_CIRCLE, action_limit_of
from sim2sim_serving.parameters import parameter_messages
from sim2sim_serving.session import FOREIGN, TASK, Identity, provenance, refused, reported

# float32 [n, 10] to [n, 2], as in Query.msg and Act.srv; with a memory, [n, 10] and n memories.
Act = Union[Callable[[np.ndarray], Any], Callable[[np.ndarray, List[Any]], Any]]
# The memory of a rollout that begins, from its seed and the number of actions of each answer that
# are executed; 0: as many as the policy itself says.
Begin = Callable[[int, int], Any]

MANY_ROLLOUTS = 1_024  # above it, those not asked for lately are forgotten: none says when it ends
LATELY = 1_000  # requests


@dataclass
class Remembered:
    """A rollout of a policy with a memory, and its last answer."""

    memory: Any
    step: int = -1
    observation: Sequence[float] = ()
    action: np.ndarray = field(default_factory=lambda: np.zeros(2, dtype=np.float32))
    last_request: int = 0


class PolicySession:
    """A served policy. Without `begin` it has no memory: the same query gets the same answer."""

    def __init__(
        self,
        act: Act,
        identity: Identity,
        begin: Optional[Begin] = None,
        answers: int = 1,
        stochastic: bool = False,
        task: str = FULL_CIRCLE,
    ) -> None:
        """`answers` is how many actions the policy answers with at a time, of which the first
        ones may be executed before it looks again; a `stochastic` one draws random numbers.
        `task` is the one in which it acts."""
        self._policy: Callable[..., Any] = act
        self._begin = begin
        self._answers = answers
        self._noise = {"noise": {"drawn_by": "the node"}} if stochastic else {}
        action_limit_of(task)  # refuses what is no task
        self._parameters = {} if task == FULL_CIRCLE else {TASK: task}
        self._identity = identity
        self._lock = threading.Lock()
        self._rollouts: Dict[int, Remembered] = {}
        self._requests = 0

    def act(self, request: Any) -> ActResponse:
        with self._lock:
            try:
                self._require(request.queries)
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
            parameters=parameter_messages(self._parameters),
            provenance=provenance(self._noise),
        )

    def _require(self, queries: Sequence[Any]) -> None:
        """Refuses a request before anything changes."""
        seen = set()
        for query in queries:
            who = f"rollout {query.rollout}"
            if not np.isfinite(np.asarray(query.observation, dtype=np.float32)).all():
                raise Error(f"{who}: observation must be finite")
            if query.step == 0 and query.execute > self._answers:
                raise Error(
                    f"{who}: execute {query.execute}: must be from 1 to {self._answers}, the "
                    "actions of an answer of the policy; 0: as many as it says"
                )
            if self._begin is None:
                continue
            if query.rollout in seen:
                raise Error(f"{who}: must be asked for once in a request")
            seen.add(query.rollout)
            if query.step == 0 or self._is_repeated(query):
                continue
            rollout = self._rollouts.get(query.rollout)
            expected = 0 if rollout is None else rollout.step + 1
            if query.step + 1 == expected:
                raise Error(f"{who}: step {query.step}: was answered for another observation")
            if query.step != expected:
                raise Error(f"{who}: step {query.step}: expected {expected}")

    def _is_repeated(self, query: Any) -> bool:
        """Whether a query is the last one of its rollout again; step 0 begins it anew."""
        rollout = self._rollouts.get(query.rollout)
        return (
            rollout is not None
            and query.step > 0
            and query.step == rollout.step
            and tuple(query.observation) == rollout.observation
        )

    def _actions(self, queries: Sequence[Any]) -> np.ndarray:
        if self._begin is None:
            return self._asked(queries)
        self._forget_ended()
        new = [query for query in queries if not self._is_repeated(query)]
        begun = {query.rollout: self._begun(query) for query in new if query.step == 0}
        self._rollouts.update(begun)
        try:
            actions = self._asked(new, [self._rollouts[query.rollout].memory for query in new])
        except Error:
            for query in new:  # the policy may have gone half a step
                self._rollouts.pop(query.rollout, None)
            raise
        for query, action in zip(new, actions):
            rollout = self._rollouts[query.rollout]
            rollout.step, rollout.observation = query.step, tuple(query.observation)
            rollout.action = action
        for query in queries:
            self._rollouts[query.rollout].last_request = self._requests
        answers = [self._rollouts[query.rollout].action for query in queries]
        return np.array(answers, dtype=np.float32).reshape(-1, 2)

    def _begun(self, query: Any) -> Remembered:
        assert self._begin is not None
        try:
            return Remembered(self._begin(query.seed, query.execute))
        except FOREIGN as error:
            raise Error(f"begin: {reported(error)}", ExitCode.RUNTIME_FAULT) from error

    def _asked(self, queries: Sequence[Any], *memories: List[Any]) -> np.ndarray:
        if not queries:
            return np.empty((0, 2), dtype=np.float32)
        observations = np.array([query.observation for query in queries], dtype=np.float32)
        try:
            actions = np.asarray(self._policy(observations, *memories), dtype=np.float32)
        except FOREIGN as error:
            raise Error(f"act: {reported(error)}", ExitCode.RUNTIME_FAULT) from error
        if actions.shape != (len(queries), 2):
            raise Error(
                f"act: shape {list(actions.shape)} of the actions: must be [{len(queries)}, 2]",
                ExitCode.BAD_DEPENDENCY,
            )
        return actions

    def _forget_ended(self) -> None:
        self._requests += 1
        if len(self._rollouts) >= MANY_ROLLOUTS:
            oldest = self._requests - LATELY
            self._rollouts = {
                name: rollout
                for name, rollout in self._rollouts.items()
                if rollout.last_request >= oldest
            }
