# SPDX-License-Identifier: BSD-3-Clause
"""The contract of every served policy, in any language: a run over nodes relies on it.

A node serves ~act and ~describe; the fields are explained in pusht_msgs/srv. Each query gets two
finite numbers. Rows do not depend on each other, nor on how they are batched. The last query of a
rollout, sent again, gets the same answer. All random numbers of a rollout come from the seed of its
queries: the same seed gets the same actions, whatever was asked before; another seed may get
others. More executed actions than the policy answers with are refused at step 0.

A policy with a memory keeps it by rollout:
- An episode begins with step 0: whatever the node knows of that rollout is forgotten.
- Its steps come in their order. Another step, or the last one with another observation, is refused,
  and a refused request changes nothing.
- An episode ends without a word. The node forgets rollouts when there are many, oldest first, but
  none that was asked for lately; 1024 rollouts and 1000 requests in this suite.
- An episode that a fault cut off is repeated from step 0, under the same number or a new one, with
  the same seed; it must go as it would have gone. A rollout in which the policy failed has to begin
  anew.
"""

import itertools
import math
import random
from typing import Any, List

import rospy  # type: ignore[import]
from pusht_msgs.msg import Query  # type: ignore[import]
from pusht_msgs.srv import Act  # type: ignore[import]

from pusht_task.task import spawn
from pusht_testing.served import ServedCase, data, observe


class PolicyContract(ServedCase):
    """The contract of every served policy. With ~memory true it wants steps in their order."""

    subject = "policy"
    has_memory: bool
    rollouts = itertools.count(random.getrandbits(63))

    @classmethod
    def setUpClass(cls) -> None:
        cls.find(act=Act)
        cls.has_memory = rospy.get_param("~memory", False)

    def queries(self, spawns: Any, seed: int = 0) -> List[Query]:
        """The first query of a rollout for each of the spawns."""
        return [
            Query(rollout=next(self.rollouts), seed=seed, observation=observe(spawn(number)))
            for number in spawns
        ]

    def answers(self, query: Query, spawns: Any) -> List[List[float]]:
        """The actions of a rollout that sees these spawns, one at each step from 0."""
        found = []
        for step, number in enumerate(spawns):
            query.step, query.observation = step, observe(spawn(number))
            found.append(list(self.accepted("act", queries=[query]).actions))
        return found

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
        other = Query(rollout=query.rollout, step=1, observation=observe(spawn(4)))
        self.refused("step 1: was answered for another observation", "act", queries=[other])
        query.step = 7
        expected = f"rollout {query.rollout}: step 7: expected 2"
        self.refused(expected, "act", queries=[query])
        query.step = 0
        self.assertEqual(data(self.accepted("act", queries=[query])), beginning)
        (stranger,) = self.queries([3])
        stranger.step = 1
        self.refused(f"rollout {stranger.rollout}: step 1: expected 0", "act", queries=[stranger])

    def test_a_seed_decides_all_that_is_random(self) -> None:
        first, again, other = *self.queries([0, 0], seed=7), *self.queries([0], seed=2**64 - 1)
        actions = self.answers(first, range(4))
        self.assertEqual(self.answers(again, range(4)), actions)
        self.answers(other, range(4))  # may be others; a seed may be as large as that
        self.assertEqual(self.answers(first, range(4)), actions, "begun again, it is as new")

    def test_rollouts_do_not_disturb_each_other(self) -> None:
        alone = [self.answers(self.queries([0], seed)[0], range(seed, seed + 4)) for seed in (1, 2)]
        pair = [*self.queries([0], seed=1), *self.queries([0], seed=2)]
        together: List[List[List[float]]] = [[], []]
        for step in range(4):
            for query in pair:
                query.step, query.observation = step, observe(spawn(query.seed + step))
            self.accepted("act", queries=self.queries(range(3), seed=5))  # strangers in between
            actions = list(self.accepted("act", queries=pair[:: 1 if step % 2 else -1]).actions)
            found = [actions[:2], actions[2:]]
            for which, action in zip((0, 1) if step % 2 else (1, 0), found):
                together[which].append(action)
        self.assertEqual(together, alone)

    def test_a_rollout_that_was_cut_off_is_repeated(self) -> None:
        whole = self.answers(self.queries([0], seed=3)[0], range(5))
        (cut,) = self.queries([0], seed=3)
        self.answers(cut, range(2))
        self.assertEqual(self.answers(cut, range(5)), whole)

    def test_more_actions_than_there_are(self) -> None:
        queries = self.queries(range(2))
        queries[1].execute = 2**31 - 1
        self.refused("execute 2147483647: must be from 1 to", "act", queries=queries)
        queries[1].execute = 1
        self.accepted("act", queries=queries)

    def test_describe(self) -> None:
        description = self.assert_described()
        self.assertEqual((description.parameters, description.parameters_hash), ([], ""))
        self.assertEqual((description.frame_prefix, description.stamp), ("", rospy.Time()))
