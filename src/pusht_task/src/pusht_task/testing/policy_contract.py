# SPDX-License-Identifier: BSD-3-Clause
"""The contract of every served policy, in any language: a run over nodes relies on it.

A node serves ~act and ~describe; the fields are explained in pusht_msgs/srv. Each query gets two
finite numbers. Rows do not depend on each other, nor on how they are batched. The last query of a
rollout, sent again, gets the same answer. A policy with a memory wants the steps of a rollout in
their order, from 0, and begins anew at 0.
"""

import itertools
import math
import random
from typing import Any, List

import rospy  # type: ignore[import]
from pusht_msgs.msg import Query  # type: ignore[import]
from pusht_msgs.srv import Act  # type: ignore[import]

from pusht_task.task import spawn
from pusht_task.testing.served import ServedCase, data, observe


class PolicyContract(ServedCase):
    """The contract of every served policy. With ~memory true it wants steps in their order."""

    subject = "policy"
    has_memory: bool
    rollouts = itertools.count(random.getrandbits(63))

    @classmethod
    def setUpClass(cls) -> None:
        cls.find(act=Act)
        cls.has_memory = rospy.get_param("~memory", False)

    def queries(self, seeds: Any) -> List[Query]:
        """The first query of a rollout for each of the spawns."""
        return [Query(next(self.rollouts), 0, observe(spawn(seed))) for seed in seeds]

    def test_two_numbers_for_each_query(self) -> None:
        for count in (0, 1, 5):
            actions = self.accepted("act", queries=self.queries(range(count))).actions
            self.assertEqual(len(actions), 2 * count)
            self.assertTrue(all(map(math.isfinite, actions)))

    def test_rows_are_independent(self) -> None:
        together = self.accepted("act", queries=self.queries(range(8))).actions
        alone: List[float] = []
        for query in self.queries(range(8)):
            alone += self.accepted("act", queries=[query]).actions
        self.assertEqual(alone, list(together))

    def test_asked_again_it_answers_the_same(self) -> None:
        queries = self.queries(range(3))
        for step in range(3):
            for query in queries:
                query.step = step
            first = self.accepted("act", queries=queries)
            self.assertEqual(data(self.accepted("act", queries=queries)), data(first))

    def test_observations_that_are_not_finite(self) -> None:
        for number in (math.nan, math.inf):
            queries = self.queries(range(3))
            queries[1].observation[4] = number
            self.refused(f"rollout {queries[1].rollout}: .*finite", "act", queries=queries)

    def test_steps_of_a_rollout(self) -> None:
        (query,) = self.queries([3])
        beginning = data(self.accepted("act", queries=[query]))
        if not self.has_memory:  # what came before makes no difference
            query.step = 7
            self.assertEqual(data(self.accepted("act", queries=[query])), beginning)
            return
        query.step = 1
        self.accepted("act", queries=[query])
        other = Query(query.rollout, 1, observe(spawn(4)))
        self.refused("step 1: was answered for another observation", "act", queries=[other])
        query.step = 7
        expected = f"rollout {query.rollout}: step 7: expected 2"
        self.refused(expected, "act", queries=[query])
        query.step = 0
        self.assertEqual(data(self.accepted("act", queries=[query])), beginning)
        (stranger,) = self.queries([3])
        stranger.step = 1
        self.refused(f"rollout {stranger.rollout}: step 1: expected 0", "act", queries=[stranger])

    def test_describe(self) -> None:
        description = self.assert_described()
        self.assertEqual((description.parameters, description.parameters_hash), ([], ""))
        self.assertEqual((description.frame_prefix, description.stamp), ("", rospy.Time()))
