# SPDX-License-Identifier: BSD-3-Clause
"""The contract of every served simulator, in any language: a run over nodes relies on it.

A node serves ~reset, ~step, ~configure and ~describe and publishes ~state; the fields are explained
in pusht_msgs/srv. The rules, each with its tests below:

- A reset takes a spawn seed or a state, and clears all that was before. A state of its own is taken
  without a change of bits. Velocities count; yaws are wrapped.
- A step has an index. The last request, sent again, gets the stored answer; any other index is
  refused. Actions are clipped; success never stops a world, the horizon does.
- A request that is refused changes nothing. The answer has `success` false, a reason of one line,
  whose words are free, and an exit code.
- A reset with a token holds the world: other callers may reset it, but not step or configure it.
- Stamps grow by 0.1 s, over episodes too. ~state and the frames show what was answered, at its
  stamp; of a silent episode they show nothing.
- Parameters have a hash, which each reset repeats. They change between episodes.
"""

import math
from dataclasses import replace
from typing import Any, Dict, List

import numpy as np
import rospy  # type: ignore[import]
from pusht_msgs.msg import Parameter  # type: ignore[import]

from pusht_task.task import (
    HORIZON,
    PLAUSIBLE_SPEED,
    PUSHER_FRAME_HEIGHT,
    START_TOLERANCE,
    TEE_FRAME_HEIGHT,
    WorldState,
    spawn,
)
from pusht_testing.served import HELD, data, message_of, numbers_of
from pusht_testing.simulator_case import CONTROL_STEP, MOVING, PUSHES, SimulatorCase


class SimulatorContract(SimulatorCase):
    """The contract of every served simulator. The node must be driven by nothing else."""

    # A reset.

    def test_seed_is_the_spawn(self) -> None:
        for seed in (0, 3, 10_000, 2**64 - 1):
            self.assert_near(self.accepted("reset", seed=seed).state, spawn(seed))

    def test_a_start_counts_whatever_the_seed(self) -> None:
        for seed, drawn in ((3, False), (4, True)):
            reset = self.accepted("reset", start=[message_of(spawn(4))], seed=seed, drawn=drawn)
            self.assert_near(reset.state, spawn(4))

    def test_start_is_taken_with_its_velocities(self) -> None:
        self.assert_near(self.begin(start=[message_of(MOVING)]).state, MOVING)

    def test_yaw_is_wrapped(self) -> None:
        turned = replace(spawn(3), tee_yaw=3.0 + 10.0 * math.pi)
        state = self.accepted("reset", start=[message_of(turned)]).state
        self.assertAlmostEqual(state.tee_yaw, 3.0, delta=self.start_tolerance)

    def test_reset_to_its_own_state_changes_no_bit(self) -> None:
        for start in (MOVING, *map(spawn, range(20))):
            once = self.accepted("reset", start=[message_of(start)]).state
            again = self.accepted("reset", start=[once]).state
            self.assertEqual(data(again), data(once))

    def test_reset_clears_all_that_was_before(self) -> None:
        alone = self.trajectory(spawn(3), PUSHES)
        self.trajectory(spawn(7), PUSHES)
        self.assertEqual(self.trajectory(spawn(3), PUSHES), alone)

    def test_refused_resets_change_nothing(self) -> None:
        stamp = self.begin(episode=4).stamp
        for number in (math.nan, math.inf, -math.inf):
            bad = message_of(replace(spawn(3), tee_vx=number))
            self.refused("finite", "reset", start=[bad])
        self.refused("start", "reset", start=[message_of(spawn(3)), message_of(spawn(4))])
        for late in (rospy.Time(0, 1), stamp - CONTROL_STEP):
            self.refused("stamp", "reset", stamp=late)
        self.refused("stamp", "reset", stamp=stamp, episode=5)
        for beyond in (rospy.Time(2**31), rospy.Time(2**32 - 1, 999_999_999)):
            self.refused("stamp", "reset", stamp=beyond)
        step = self.accepted("step", episode=4)
        self.assertEqual(step.stamp, stamp + CONTROL_STEP)
        self.assertEqual(len(self.updates_until(step)), 1)

    def test_repeated_reset_is_answered_again(self) -> None:
        stamp = self.begin().stamp + CONTROL_STEP
        request: Dict[str, Any] = {"seed": 5, "episode": 6, "stamp": stamp}
        first = self.accepted("reset", **request)
        self.assertEqual(data(self.accepted("reset", **request)), data(first))
        others: List[Dict[str, Any]] = [{"seed": 6}, {"horizon": 7}, {"token": "other"}]
        for other in others:
            self.refused("stamp", "reset", **{**request, **other})
        step = self.accepted("step", episode=6)
        self.assertEqual([update.step for update in self.updates_until(step)], [0, 1])
        self.refused("stamp", "reset", **request)

    def test_absurd_start_is_an_error_or_stays_finite(self) -> None:
        fast = replace(spawn(3), tee_vx=PLAUSIBLE_SPEED, pusher_vy=-PLAUSIBLE_SPEED)
        inside = replace(spawn(3), pusher_x=spawn(3).tee_x, pusher_y=spawn(3).tee_y)
        for start in (fast, inside):
            response = self.call("reset", start=[message_of(start)])
            steps = 0
            while response.success and steps < 20:
                self.assertTrue(all(map(math.isfinite, numbers_of(response.state))))
                response = self.call("step", step=-1)
                steps += 1
            if not response.success:
                self.assertTrue(response.message)
                self.refused("needs a reset|call reset first", "step", step=-1)
            self.assert_near(self.accepted("reset", seed=3).state, spawn(3))

    def test_start_beyond_what_is_plausible_is_refused(self) -> None:
        self.accepted("reset", seed=3)
        for beyond in (
            {"tee_x": 1e11},
            {"tee_yaw": 1e300},
            {"pusher_vy": -1e11},
            {"tee_yaw_rate": 1e308},
        ):
            start = message_of(replace(spawn(3), **beyond))
            self.refused("must be within", "reset", start=[start])
        self.accepted("step", step=0)

    # A step.

    def test_step_before_reset(self) -> None:
        if self.before_reset is None:
            self.skipTest("the world had been reset before")
        self.assert_refusal(self.before_reset, "step before reset")

    def test_pushing_moves_the_tee(self) -> None:
        state = self.accepted("reset", seed=3).state
        start = state
        for _ in range(40):
            way = np.array([state.tee_x - state.pusher_x, state.tee_y - state.pusher_y])
            action = way / np.linalg.norm(way)
            state = self.accepted("step", step=-1, action=action).state
        moved = math.hypot(state.tee_x - start.tee_x, state.tee_y - start.tee_y)
        self.assertGreater(moved, 0.02)

    def test_actions_are_clipped(self) -> None:
        inside = self.trajectory(spawn(3), [(1.0, -1.0)] * 5)
        self.assertEqual(self.trajectory(spawn(3), [(17.0, -1.5)] * 5), inside)

    def test_repeated_step_is_answered_again_without_physics(self) -> None:
        undisturbed = self.trajectory(spawn(3), PUSHES[:2])
        self.begin(start=[message_of(spawn(3))])
        first = self.accepted("step", step=0, action=PUSHES[0])
        again = self.accepted("step", step=0, action=PUSHES[0])
        self.assertEqual(data(again), data(first))
        others: List[Dict[str, Any]] = [
            {"action": PUSHES[1]},
            {"action": (math.nan, 0.0)},
            {"action": PUSHES[0], "stamp": first.stamp},
        ]
        for fields in others:
            self.refused("step 0: was taken with another action or stamp", "step", step=0, **fields)
        second = self.accepted("step", step=1, action=PUSHES[1])
        self.assertEqual([data(first.state), data(second.state)], undisturbed[1:])
        self.assertEqual([update.step for update in self.updates_until(second)], [1, 2])

    def test_refused_steps_change_nothing(self) -> None:
        undisturbed = self.trajectory(spawn(3), PUSHES[:2])
        self.begin(start=[message_of(spawn(3))], episode=3)
        first = self.accepted("step", episode=3, action=PUSHES[0])
        self.refused("episode 7: must be 3", "step", episode=7, step=1)
        for step in (-2, 2, 7):
            self.refused(f"step {step}: expected 1", "step", episode=3, step=step)
        for action in ((math.nan, 0.0), (0.0, math.inf), (-math.inf, 0.0)):
            self.refused("action .*finite", "step", episode=3, step=1, action=action)
        for stamp in (rospy.Time(0, 1), first.stamp):
            self.refused("stamp", "step", episode=3, step=1, stamp=stamp)
        second = self.accepted("step", episode=3, step=1, action=PUSHES[1])
        self.assertEqual([data(first.state), data(second.state)], undisturbed[1:])
        self.assertEqual([update.step for update in self.updates_until(second)], [1, 2])
        self.refused("step 0: expected 2", "step", episode=3, step=0)

    def test_horizon(self) -> None:
        for asked, horizon in ((2, 2), (0, HORIZON)):
            self.accepted("reset", horizon=asked)
            for step in range(horizon):
                last = self.accepted("step", step=step)
            message = f"step {horizon}: the horizon of {horizon} control steps is reached"
            for step in (-1, horizon):
                self.refused(message, "step", step=step)
            self.assertEqual(data(self.accepted("step", step=horizon - 1)), data(last))

    def test_success_never_stops_a_world(self) -> None:
        solved = WorldState(pusher_x=0.2, pusher_y=0.2)
        self.trajectory(solved, [(0.0, 0.0)] * 10)

    def test_defaults_by_hand(self) -> None:
        reset = self.begin()
        self.assert_near(reset.state, spawn(0))
        for index in range(3):
            step = self.accepted("step", step=-1)
            self.assertEqual(step.step, index)
            self.assertEqual(step.stamp, reset.stamp + (index + 1) * CONTROL_STEP)

    # The token of the caller that holds the world.

    def refused_without_hold(self, pattern: str, token: str) -> None:
        """Checks that every request but a reset is refused and leaves the world as it is."""
        before = data(self.call("describe"))
        for fields in ({"step": -1}, {"step": 0}):
            self.refused(pattern, "step", HELD, token=token, **fields)
        change: Dict[str, Any] = {
            "token": token,
            "parameters": [Parameter("no_such_parameter", "1.0")],
        }
        for end_episode in (False, True):
            self.refused(pattern, "configure", HELD, end_episode=end_episode, **change)
        self.assertEqual(data(self.call("describe")), before)

    def test_only_the_holder_is_served(self) -> None:
        undisturbed = self.trajectory(spawn(3), PUSHES[:2])
        self.begin(start=[message_of(spawn(3))], token="mine", horizon=2)
        self.refused_without_hold("held by another caller", "")
        self.refused_without_hold("was reset by another caller", "other")
        first = self.accepted("step", step=0, action=PUSHES[0], token="mine")
        self.refused_without_hold("held by another caller", "")
        self.refused("held", "step", HELD, step=0, action=PUSHES[0])
        second = self.accepted("step", step=1, action=PUSHES[1], token="mine")
        self.assertEqual([data(first.state), data(second.state)], undisturbed[1:])
        self.assertEqual([update.step for update in self.updates_until(second)], [1, 2])
        self.refused_without_hold("held by another caller", "")  # past the horizon, too

    def test_a_reset_takes_the_world_over(self) -> None:
        for token in ("other", ""):
            self.accepted("reset", token="mine")
            self.accepted("step", token="mine")
            self.accepted("reset", token=token)
            self.refused_without_hold("was reset by another caller", "mine")
            self.accepted("step", token=token)

    def test_configuring_ends_the_hold(self) -> None:
        self.accepted("reset", token="mine")
        self.refused("mid-episode", "configure", token="mine")
        response = self.accepted("configure", token="mine", end_episode=True)
        again = self.accepted("configure", token="mine", end_episode=True)
        self.assertEqual(data(again), data(response), "asked again, it answers again")
        self.refused_without_hold("was reset by another caller, or its episode has ended", "mine")
        self.accepted("configure")

    def test_refused_reset_leaves_the_hold(self) -> None:
        self.accepted("reset", token="mine")
        self.refused("stamp", "reset", stamp=rospy.Time(0, 1))
        self.refused("held", "step", HELD)
        self.accepted("step", token="mine")

    # Messages on ~state, and frames.

    def test_stamps_grow_over_episodes(self) -> None:
        last = self.begin().stamp
        stamps = []
        for episode in range(3):
            asked = last + rospy.Duration(7, 1) if episode == 1 else rospy.Time()
            answers = [self.accepted("reset", episode=episode, stamp=asked)]
            answers += [self.accepted("step", episode=episode, step=k) for k in range(5)]
            stamps += [answer.stamp for answer in answers]
            self.assertEqual(answers[0].stamp, asked or last + CONTROL_STEP)
            last = stamps[-1]
        self.assertEqual(self.call("describe").stamp, last)
        self.assertEqual(stamps, sorted(set(stamps)))
        updates = self.updates_until(answers[-1])
        self.assertEqual([update.header.stamp for update in updates], stamps)
        self.assertEqual([update.step for update in updates], [0, 1, 2, 3, 4, 5] * 3)

    def test_silent_episodes_are_simulated_but_not_published(self) -> None:
        loud = [self.begin(episode=1), self.accepted("step", episode=1, step=0, action=(1, 0))]
        silent = [self.accepted("reset", episode=2, silent=True)]
        silent += [self.accepted("step", episode=2, step=0, action=(1, 0))]
        self.assertEqual([data(a.state) for a in silent], [data(a.state) for a in loud])
        self.assertEqual({answer.stamp for answer in silent}, {loud[-1].stamp}, "stamps rest")
        after = [self.accepted("reset", episode=3), self.accepted("step", episode=3, step=0)]
        self.assertEqual(after[0].stamp, loud[-1].stamp + CONTROL_STEP)
        updates = self.updates_until(after[-1])
        self.assertEqual([(u.episode, u.step) for u in updates], [(1, 1), (3, 0), (3, 1)])

    def test_state_messages_are_the_answers(self) -> None:
        asked = [(0.25, -0.5), (3.0, -3.0)]
        answers = [self.begin(episode=9)]
        answers += [self.accepted("step", episode=9, step=-1, action=action) for action in asked]
        updates = self.updates_until(answers[-1])
        self.assertEqual([update.step for update in updates], [1, 2])
        self.assertEqual([update.action for update in updates], [(0.25, -0.5), (1.0, -1.0)])
        for update, answer in zip(updates, answers[1:]):
            self.assertEqual(update.episode, 9)
            self.assertEqual(update.header.frame_id, f"{self.frame_prefix}/table")
            self.assertEqual(update.header.stamp, answer.stamp)
            self.assertEqual(data(update.state), data(answer.state))

    def test_state_message_of_a_reset(self) -> None:
        self.begin()
        reset = self.accepted("reset", seed=4, episode=2)
        (update,) = self.updates_until(reset)
        self.assertEqual((update.episode, update.step, update.action), (2, 0, (0.0, 0.0)))
        self.assertEqual(data(update.state), data(reset.state))

    def test_frames(self) -> None:
        for answer in (self.accepted("reset", seed=3), self.accepted("step", action=(0.5, 0.5))):
            state = answer.state
            for child, x, y, height, yaw in (
                ("pusher", state.pusher_x, state.pusher_y, PUSHER_FRAME_HEIGHT, 0.0),
                ("tee", state.tee_x, state.tee_y, TEE_FRAME_HEIGHT, state.tee_yaw),
                ("target", 0.0, 0.0, 0.0, 0.0),
            ):
                found = self.frame(child, answer.stamp)
                self.assertEqual(found.header.stamp, answer.stamp)
                place, turn = found.transform.translation, found.transform.rotation
                np.testing.assert_allclose([place.x, place.y, place.z], [x, y, height], atol=1e-12)
                wanted = [0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)]
                np.testing.assert_allclose([turn.x, turn.y, turn.z, turn.w], wanted, atol=1e-12)

    # Description and parameters.

    def test_describe(self) -> None:
        description = self.assert_described()
        names = [parameter.name for parameter in description.parameters]
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual(bool(description.parameters_hash), bool(names))
        self.assertTrue(description.frame_prefix)
        self.assertFalse(description.frame_prefix.startswith("/"))
        self.assertGreaterEqual(description.start_tolerance, 0.0)
        self.assertLessEqual(description.start_tolerance, START_TOLERANCE)

    def test_answers_name_the_parameters(self) -> None:
        parameters_hash = self.call("describe").parameters_hash
        self.assertEqual(self.accepted("reset").parameters_hash, parameters_hash)
        configured = self.accepted("configure", end_episode=True)
        self.assertEqual(configured.parameters_hash, parameters_hash)

    def test_configure_in_mid_episode(self) -> None:
        before = self.trajectory(spawn(3), PUSHES[:3])
        self.trajectory(spawn(3), PUSHES[:1])
        self.refused("mid-episode", "configure")
        step = self.accepted("step", step=1, action=PUSHES[1])
        self.assertEqual(data(step.state), before[2])
        self.accepted("configure", end_episode=True)
        self.refused("reset", "step", step=-1)
        self.assertEqual(self.trajectory(spawn(3), PUSHES[:3]), before)

    def test_configure_between_episodes(self) -> None:
        stamp = self.accepted("reset", horizon=1).stamp
        self.accepted("step")
        self.accepted("configure")
        self.refused("reset", "step", step=-1)
        self.assertEqual(self.call("describe").stamp, stamp + CONTROL_STEP)
        self.accepted("reset")

    def test_configured_parameters(self) -> None:
        before = self.call("describe")
        number, changed = self.number()
        response = self.accepted("configure", parameters=[changed], end_episode=True)
        after = self.call("describe")
        self.assertEqual(after.parameters, response.parameters)
        wanted = {p.name: p.value for p in [*before.parameters, changed]}
        found = {p.name: p.value for p in after.parameters}
        self.assertEqual(list(found), [parameter.name for parameter in before.parameters])
        self.assertEqual(float(found.pop(number.name)), float(wanted.pop(number.name)))
        self.assertEqual(found, wanted)
        self.assertNotEqual(after.parameters_hash, before.parameters_hash)
        self.assertEqual(after.parameters_hash, response.parameters_hash)
        self.accepted("configure", parameters=[number])
        self.assertEqual(data(self.call("describe")), data(before))

    def test_configuring_what_is_not_there(self) -> None:
        before = self.call("describe")
        stray = Parameter("no_such_parameter", "1.0")
        self.refused("no_such_parameter", "configure", parameters=[stray], end_episode=True)
        self.assertEqual(data(self.call("describe")), data(before))

    def test_configuring_bad_values(self) -> None:
        before = self.call("describe")
        name = self.number()[0].name
        for value in ("nan", "inf", "-inf", "much", "", "1e400", "0x10", "1 2"):
            bad = Parameter(name, value)
            self.refused(name, "configure", parameters=[bad], end_episode=True)
        self.assertEqual(data(self.call("describe")), data(before))

    def test_refused_configuration_leaves_the_episode(self) -> None:
        self.accepted("reset")
        stray = Parameter("no_such_parameter", "1.0")
        self.refused("no_such_parameter", "configure", parameters=[stray], end_episode=True)
        self.accepted("step")

    def test_unknown_kind_is_refused(self) -> None:
        before = self.call("describe")
        self.refused("no_such_kind", "configure", kind="no_such_kind", end_episode=True)
        self.assertEqual(data(self.call("describe")), data(before))
