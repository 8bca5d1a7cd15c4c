#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The rules by which an object in Python is served, without a master."""

import io
import json
import math
import os
import signal
import subprocess
import sys
import unittest
from dataclasses import replace
from typing import Any, Dict, List, Mapping, Sequence, Tuple
from unittest import mock

import numpy as np
from genpy import Time  # type: ignore[import]
from pusht_msgs.msg import Parameter, Query, WorldStateStamped  # type: ignore[import]
from pusht_msgs.msg import WorldState as WorldStateMessage
from pusht_msgs.srv import (  # type: ignore[import]
    ActRequest,
    ConfigureRequest,
    DescribeRequest,
    ResetRequest,
    StepRequest,
)

from pusht_task.error import Error, ExitCode
from pusht_task.task import WorldState, spawn, wrap_angle
from sim2sim_serving.parameters import Value, merged
from sim2sim_serving.policy_session import PolicySession
from sim2sim_serving.session import FailedStart, Identity
from sim2sim_serving.simulator_session import SimulatorSession


class Drift:
    """The pusher goes where it is told, the tee drifts; both fail on demand."""

    def __init__(self, drift: float, label: str, count: int, sticky: bool) -> None:
        if drift < 0:
            raise ValueError(f"drift {drift}: must be at least 0 m/s")
        if label == "broken":
            raise RuntimeError("no\nsuch engine")
        self.drift = drift
        self.fault = ""
        self.actions: List[np.ndarray] = []
        self.state = WorldState()

    def reset(self, start: WorldState) -> WorldState:
        if self.fault == "elsewhere":
            return replace(start, tee_x=start.tee_x + 0.01)
        if self.fault == "rounded":
            return replace(start, tee_x=float(np.float32(start.tee_x)))
        if self.fault == "moving":
            return replace(start, tee_yaw_rate=start.tee_yaw_rate + 1e-3)
        if self.fault == "wrapped":
            return replace(start, tee_yaw=-math.pi)
        if self.fault == "askew":
            return replace(start, tee_yaw=wrap_angle(start.tee_yaw + 3.0))
        if self.fault:
            raise RuntimeError(self.fault)
        self.state = start
        return start

    def step(self, action: np.ndarray) -> Any:
        self.actions.append(action)
        if self.fault == "nothing":
            return None
        if self.fault == "raise":
            raise ZeroDivisionError("by\nzero")
        self.state = replace(
            self.state,
            pusher_x=self.state.pusher_x + 0.1 * float(action[0]),
            tee_x=math.nan if self.fault == "nan" else self.state.tee_x + self.drift,
            tee_yaw=self.state.tee_yaw + 3.0 if self.fault == "turned" else self.state.tee_yaw,
        )
        if self.fault == "far":
            self.state = replace(self.state, tee_x=1e300)
        if self.fault == "fast":
            self.state = replace(self.state, tee_yaw_rate=-1e9)
        if self.fault == "exit":
            sys.exit(3)
        return self.state


DEFAULTS: Dict[str, Value] = {"drift": 0.5, "label": "plain", "count": 3, "sticky": False}


class SessionCase(unittest.TestCase):
    def setUp(self) -> None:
        self.simulators: List[Drift] = []
        self.updates: List[WorldStateStamped] = []
        self.session = SimulatorSession(
            self.make, DEFAULTS, Identity("drift", "1"), "here", self.updates.append
        )

    def make(self, **parameters: Any) -> Drift:
        self.simulators.append(Drift(**parameters))
        return self.simulators[-1]

    def reset(self, **fields: Any) -> Any:
        return self.accepted(self.session.reset(ResetRequest(**fields)))

    def step(self, step: int = -1, action: Tuple[float, float] = (0.5, 0.0), **fields: Any) -> Any:
        return self.accepted(self.session.step(StepRequest(step=step, action=action, **fields)))

    def configure(
        self,
        values: Mapping[str, str] = {},
        end_episode: bool = False,
        token: str = "",
        kind: str = "",
    ) -> Any:
        parameters = [Parameter(name, value) for name, value in values.items()]
        return self.session.configure(ConfigureRequest(kind, parameters, end_episode, token))

    def accepted(self, response: Any) -> Any:
        self.assertTrue(response.success, response.message)
        self.assertEqual((response.message, response.exit_code), ("", ExitCode.OK))
        self.assertEqual(response.instance_id, self.session.describe().instance_id)
        return response

    def refused(self, response: Any, pattern: str, exit_code: int = ExitCode.INVALID_INPUT) -> None:
        self.assertFalse(response.success)
        self.assertRegex(response.message, pattern)
        self.assertNotIn("\n", response.message)
        self.assertEqual(response.exit_code, exit_code)
        self.assertEqual(response.instance_id, self.session.describe().instance_id)

    def refused_step(self, pattern: str, exit_code: int = 2, **fields: Any) -> None:
        fields = {"step": -1, **fields}
        self.refused(self.session.step(StepRequest(**fields)), pattern, exit_code)

    def refused_reset(self, pattern: str, exit_code: int = 2, **fields: Any) -> None:
        self.refused(self.session.reset(ResetRequest(**fields)), pattern, exit_code)


class States(unittest.TestCase):
    def test_fields_are_those_of_the_message(self) -> None:
        self.assertEqual(list(vars(WorldState())), WorldStateMessage.__slots__)


class Resets(SessionCase):
    def test_seed(self) -> None:
        response = self.reset(seed=7)
        self.assertEqual(response.state, WorldStateMessage(**vars(spawn(7))))
        self.assertEqual(response.stamp, Time(0, 100_000_000))

    def test_start(self) -> None:
        start = WorldStateMessage(*range(10))
        response = self.reset(start=[start])
        self.assertEqual(response.state.tee_yaw, wrap_angle(6.0))
        start.tee_yaw = response.state.tee_yaw
        self.assertEqual(response.state, start)

    def test_refusals_change_nothing(self) -> None:
        self.reset(stamp=Time(10))
        self.step()
        for number in (math.nan, math.inf):
            bad = WorldStateMessage(tee_vx=number)
            self.refused_reset(f"start: tee_vx {number}: must be finite", start=[bad])
        two = [WorldStateMessage(), WorldStateMessage()]
        self.refused_reset("start: 2 states; must be one", start=two)
        for late in (Time(0, 1), Time(10), Time(10, 100_000_000)):
            self.refused_reset(r"stamp .*: must be above 10\.100000000", stamp=late)
        self.assertEqual(self.step(step=1).stamp, Time(10, 200_000_000))
        self.assertEqual(len(self.updates), 3)

    def test_stamps_grow_over_episodes(self) -> None:
        for episode in range(3):
            self.reset(episode=episode)
            for _ in range(2):
                self.step(episode=episode)
        stamps = [update.header.stamp.to_nsec() for update in self.updates]
        self.assertEqual(stamps, [100_000_000 * (k + 1) for k in range(9)])

    def test_late_stamps_do_not_spoil_the_world(self) -> None:
        for late in (Time(2**31), Time(2**32 - 1, 999_999_999)):
            self.refused_reset(r"must be below 2\^31 \[s\] without a token", stamp=late)
        self.reset(stamp=Time(2**31 - 1, 999_999_999))
        self.refused_step("must be below 2\\^31", stamp=Time(2**31))
        self.assertEqual(self.step().stamp, Time(2**31, 99_999_999))
        run: Dict[str, Any] = {"token": "mine"}  # it names stamps, too
        self.reset(stamp=Time(2**31, 199_999_999), **run)
        self.refused_step(r"must be below 2\^32 - 10\^6", stamp=Time(2**32 - 10**6), **run)
        self.assertEqual(self.step(stamp=Time(2**31, 299_999_999), **run).stamp.secs, 2**31)
        self.reset()

    def test_repeated_reset_is_answered_again(self) -> None:
        request = ResetRequest(seed=3, episode=5, stamp=Time(4))
        first = self.session.reset(request)
        self.assertEqual(data(self.session.reset(request)), data(first))
        self.assertEqual(len(self.updates), 1)
        self.refused_reset("stamp", episode=6, stamp=Time(4))
        others: List[Dict[str, Any]] = [{"seed": 4}, {"horizon": 7}, {"token": "other"}]
        for other in others:
            fields = {"seed": 3, "episode": 5, "stamp": Time(4), **other}
            self.refused_reset("stamp", **fields)
        self.step(episode=5)
        self.refused(self.session.reset(request), "stamp 4.000000000: must be above 4.100000000")

    def test_reset_is_not_answered_again_if_the_world_has_changed_since(self) -> None:
        request = ResetRequest(stamp=Time(4))
        self.session.reset(request)
        self.simulators[0].fault = "raise"
        self.refused_step("ZeroDivisionError", exit_code=4)
        self.refused(self.session.reset(request), "stamp")
        self.simulators[0].fault = ""
        self.reset(stamp=Time(5))
        self.accepted(self.configure(end_episode=True))
        self.refused(self.session.reset(ResetRequest(stamp=Time(5))), "stamp")

    def test_start_that_is_another_one(self) -> None:
        for fault, message in (
            ("elsewhere", "reset: ValueError: tee_x 0.01: must be within 1e-06 of 0.0"),
            ("askew", r"reset: ValueError: tee_yaw 3.0: must be within 1e-06 of 0.0"),
            ("moving", "reset: ValueError: tee_yaw_rate 0.001: must be within 1e-06 of 0"),
        ):
            self.simulators[0].fault = fault
            self.refused_reset(message, exit_code=4, start=[WorldStateMessage()])
            self.refused_step("needs a reset")
        self.reset(start=[WorldStateMessage(tee_vx=0.1)])  # motion may be projected
        self.simulators[0].fault = "wrapped"
        self.reset(start=[WorldStateMessage(tee_yaw=math.pi - 1e-9)])  # yaws meet where they wrap

    def test_start_tolerance_is_what_the_simulator_says(self) -> None:
        self.assertEqual(self.session.describe().start_tolerance, 0.0, "it does not say")
        self.simulators[0].fault = "rounded"
        start = [WorldStateMessage(tee_x=0.1)]
        self.reset(start=start)

        def session(start_tolerance: float) -> SimulatorSession:
            identity = Identity("drift", "1", start_tolerance=start_tolerance)
            return SimulatorSession(self.make, DEFAULTS, identity, "here", self.updates.append)

        for tolerance, accepted in ((1e-6, True), (1e-12, False)):
            said = session(tolerance)
            self.assertEqual(said.describe().start_tolerance, tolerance)
            self.simulators[-1].fault = "rounded"
            response = said.reset(ResetRequest(start=start))
            self.assertEqual(bool(response.success), accepted)
            if not accepted:
                self.assertRegex(response.message, "must be within 1e-12 of 0.1")
        for bad in (-1e-12, 0.1, math.nan):
            with self.assertRaisesRegex(Error, f"start_tolerance {bad}: must be above 0"):
                session(bad)

    def test_start_that_is_out_of_range(self) -> None:
        bad = WorldStateMessage(tee_x=1e300)
        self.refused_reset(r"tee_x 1e\+300: must be within 1000", start=[bad])

    def test_failing_reset(self) -> None:
        self.reset()
        self.simulators[0].fault = "engine lost"
        self.refused_reset("reset: RuntimeError: engine lost", exit_code=4)
        self.refused_step("needs a reset")
        self.accepted(self.configure())  # no episode is under way
        self.reset()
        self.step()


class Steps(SessionCase):
    def test_before_reset(self) -> None:
        self.refused_step("step before reset")

    def test_updates_are_the_answers(self) -> None:
        answers = [self.reset(episode=2), self.step(episode=2, action=(7.0, -0.25))]
        self.assertEqual([update.step for update in self.updates], [0, 1])
        self.assertEqual([list(u.action) for u in self.updates], [[0.0, 0.0], [1.0, -0.25]])
        for answer, update in zip(answers, self.updates):
            self.assertEqual((answer.stamp, answer.state), (update.header.stamp, update.state))
            self.assertEqual((update.header.frame_id, update.episode), ("here/table", 2))
            data(update)

    def test_actions_are_clipped(self) -> None:
        self.reset()
        self.step(action=(17.0, -1.5))
        np.testing.assert_array_equal(self.simulators[0].actions[0], [1.0, -1.0])
        self.assertEqual(self.simulators[0].actions[0].dtype, np.float64)

    def test_repeated_step_is_answered_again(self) -> None:
        self.reset(token="mine")
        first = self.step(step=0, token="mine")
        self.assertEqual(data(self.step(step=0, token="mine")), data(first))
        message = "step 0: was taken with another action or stamp"
        others: List[Dict[str, Any]] = [
            {"action": (0.5, 0.1)},
            {"action": (math.nan, 0)},
            {"stamp": Time(0, 1)},
        ]
        for other in others:
            fields: Dict[str, Any] = {"step": 0, "action": (0.5, 0.0), "token": "mine", **other}
            self.refused_step(message, **fields)
        self.assertEqual(len(self.simulators[0].actions), 1)
        self.assertEqual(len(self.updates), 2)
        self.assertEqual(self.step(step=1, token="mine").step, 1)

    def test_last_step_is_answered_again_at_the_horizon(self) -> None:
        self.reset(horizon=1)
        self.assertEqual(data(self.step(step=0)), data(self.step(step=0)))

    def test_refusals_change_nothing(self) -> None:
        self.reset(episode=3)
        self.step(episode=3)
        self.refused_step("episode 7: must be 3, the one under way", episode=7)
        for step in (-2, 2, 7):
            self.refused_step(f"step {step}: expected 1", episode=3, step=step)
        for action in ((math.nan, 0.0), (0.0, -math.inf)):
            self.refused_step("action .*: must be finite", episode=3, action=action)
        for stamp in (Time(0, 1), Time(0, 200_000_000)):
            self.refused_step("stamp .*: must be above 0.200000000", episode=3, stamp=stamp)
        self.assertEqual(len(self.simulators[0].actions), 1)
        self.assertEqual(self.step(step=1, episode=3).stamp, Time(0, 300_000_000))
        self.refused_step("step 0: expected 2", episode=3, step=0)

    def test_first_step_of_an_episode_is_not_a_repetition(self) -> None:
        self.reset()
        self.step(step=0)
        self.reset()
        self.step(step=0)
        self.assertEqual(len(self.simulators[0].actions), 2)

    def test_order_of_the_checks(self) -> None:
        everything_wrong = {"episode": 9, "step": 7, "action": (math.nan, 0), "stamp": Time(0, 1)}
        self.refused_step("before reset", **everything_wrong)
        self.reset(horizon=1)
        self.step()
        self.refused_step("episode", **everything_wrong)
        self.refused_step("expected", **{**everything_wrong, "episode": 0})
        self.refused_step("horizon", **{**everything_wrong, "episode": 0, "step": 1})
        self.reset()
        self.refused_step("action", **{**everything_wrong, "episode": 0, "step": 0})

    def test_horizon(self) -> None:
        for asked, horizon in ((2, 2), (0, 300)):
            self.reset(horizon=asked)
            for _ in range(horizon):
                self.step()
            for step in (-1, horizon):
                self.refused_step(
                    f"step {horizon}: the horizon of {horizon} control steps is reached", step=step
                )

    def test_failing_simulation(self) -> None:
        for fault, message in (
            ("raise", r"step: ZeroDivisionError: by zero \(step, line \d+\)"),
            ("nan", "step: ValueError: tee_x nan: must be finite"),
            ("nothing", "step: TypeError: returned NoneType: must be WorldState"),
            ("turned", r"step: ValueError: tee_yaw 6.0: must be in \[-pi, pi\) rad"),
            ("far", r"step: ValueError: tee_x 1e\+300: must be within 1000.0"),
            ("fast", "step: ValueError: tee_yaw_rate -1000000000.0: must be within 1000000.0"),
            ("exit", r"step: SystemExit: 3 \(step, line \d+\)"),
        ):
            self.simulators[0].fault = ""
            self.reset(start=[WorldStateMessage(tee_yaw=3.0)])
            self.step(step=0)
            self.simulators[0].fault = fault
            with self.assertLogs("rosout", "ERROR") as log:
                self.refused_step(message, exit_code=ExitCode.RUNTIME_FAULT)
            self.assertIn("Traceback (most recent call last)", log.output[0])
            self.refused_step("needs a reset")
            self.refused_step("needs a reset", step=0, episode=9)
        self.assertEqual(len(self.updates), 14)


class Holds(SessionCase):
    """Callers that may step and configure a world that was reset with a token."""

    def refused_without(self, pattern: str, token: str) -> None:
        """Every request but a reset."""
        before = data(self.session.describe())
        self.refused_step(pattern, exit_code=4, token=token)
        for end_episode in (False, True):
            answer = self.configure({"drift": "1"}, end_episode, token)
            self.refused(answer, pattern, exit_code=4)
        self.assertEqual(data(self.session.describe()), before)

    def test_only_the_holder_is_served(self) -> None:
        self.reset(token="mine", horizon=1)
        self.refused_without("held by another caller", "")
        self.refused_without("was reset by another caller", "other")
        self.step(token="mine")
        self.refused_without("held by another caller", "")  # past the horizon, too
        self.assertEqual(len(self.simulators[0].actions), 1)

    def test_a_reset_takes_the_world_over(self) -> None:
        for token in ("other", ""):
            self.reset(token="mine")
            self.step(token="mine")
            self.reset(token=token)
            self.refused_without("was reset by another caller", "mine")
            self.step(token=token)

    def test_configuring_ends_the_hold(self) -> None:
        self.reset(token="mine")
        self.accepted(self.configure({}, end_episode=True, token="mine"))
        self.refused_without("was reset by another caller, or its episode has ended", "mine")
        self.accepted(self.configure({"drift": "1"}))

    def test_refused_reset_leaves_the_hold(self) -> None:
        self.reset(token="mine", stamp=Time(7))
        self.refused_reset("stamp", stamp=Time(6))
        self.step(token="mine")

    def test_failed_simulation_leaves_the_hold(self) -> None:
        self.reset(token="mine")
        self.simulators[0].fault = "raise"
        self.refused_step("ZeroDivision", exit_code=4, token="mine")
        self.refused_step("held by another caller", exit_code=4)
        self.refused_step("needs a reset", token="mine")

    def test_answers_name_the_parameters(self) -> None:
        self.assertEqual(self.reset().parameters_hash, self.session.describe().parameters_hash)
        configured = self.accepted(self.configure({"drift": "0.6"}, end_episode=True))
        self.assertEqual(configured.parameters_hash, self.session.describe().parameters_hash)
        self.assertEqual(self.reset().parameters_hash, configured.parameters_hash)


class Tasks(SessionCase):
    """A simulator with a parameter `task` holds others than full_circle."""

    def setUp(self) -> None:
        super().setUp()
        self.session = SimulatorSession(
            self.make_in, {"task": "gym_pusht"}, Identity("drift", "1"), "here", self.updates.append
        )

    def make_in(self, task: str) -> Drift:
        if task == "full_circle":
            raise ValueError("task full_circle: must be another")
        return self.make(drift=0.5, label=task, count=3, sticky=False)

    def test_actions_are_those_of_the_task(self) -> None:
        self.reset(start=[WorldStateMessage()])
        self.step(action=(300.0, -20.0))
        np.testing.assert_array_equal(self.simulators[-1].actions[-1], [300.0, -20.0])
        self.accepted(self.configure({"task": '{"name": "mine", "action_limit": 2.0}'}, True))
        self.reset(start=[WorldStateMessage()])
        self.step(action=(300.0, -20.0))
        np.testing.assert_array_equal(self.simulators[-1].actions[-1], [2.0, -2.0])

    def test_seeds_are_drawn_elsewhere(self) -> None:
        words = "start: must be given in the task gym_pusht"
        self.refused(self.session.reset(ResetRequest(seed=100000)), words)

    def test_refusals_change_nothing(self) -> None:
        for task, words in (
            ("full_circle", "task full_circle: must be another"),
            ("pusht", "task 'pusht': must be one of full_circle, gym_pusht, or a task's JSON"),
            ("3", "task '3': must be one of"),
        ):
            with self.subTest(task):
                self.refused(self.configure({"task": task}), words)
                self.assertEqual(self.session.parameters, {"task": "gym_pusht"})

    def test_a_policy_says_of_another_task(self) -> None:
        def described(task: str) -> List[Tuple[str, str]]:
            policy = PolicySession(lambda rows: rows, Identity("mine", "2"), task=task)
            return [(each.name, each.value) for each in policy.describe().parameters]

        self.assertEqual(described("gym_pusht"), [("task", "gym_pusht")])
        self.assertEqual(described("full_circle"), [])
        with self.assertRaisesRegex(Error, "task 'gym_push': must be one of"):
            described("gym_push")


class Configurations(SessionCase):
    def test_mid_episode(self) -> None:
        self.reset(horizon=2)
        self.step()
        self.refused(self.configure({"drift": "1"}), "mid-episode, after 1 of 2 .* end_episode")
        self.step(step=1)
        self.accepted(self.configure({"drift": "1"}))
        self.refused_step("needs a reset")
        self.reset()
        self.accepted(self.configure({"drift": "2"}, end_episode=True))
        self.refused_step("needs a reset")
        self.assertEqual([simulator.drift for simulator in self.simulators], [0.5, 1.0, 2.0])

    def test_repeated_one_is_answered_again(self) -> None:
        def configure(drift: str = "1", token: str = "mine") -> Any:
            return self.configure({"drift": drift}, end_episode=True, token=token)

        self.reset(token="mine")
        first = self.accepted(configure())
        self.assertEqual(data(self.accepted(configure())), data(first))
        self.assertEqual(len(self.simulators), 2, "nothing is made anew for it")
        self.refused(configure("2"), "its episode has ended", ExitCode.RUNTIME_FAULT)
        self.refused(configure(token="other"), "its episode has ended", ExitCode.RUNTIME_FAULT)
        self.assertEqual(data(self.accepted(configure())), data(first))
        self.reset(token="other")
        self.refused(configure(), "reset by another caller", ExitCode.RUNTIME_FAULT)

    def test_after_a_failure(self) -> None:
        self.reset()
        self.simulators[0].fault = "raise"
        self.refused_step("ZeroDivision", exit_code=4)
        self.accepted(self.configure())

    def test_values(self) -> None:
        response = self.accepted(self.configure({"sticky": "true", "count": "12", "label": "12"}))
        values = {parameter.name: parameter.value for parameter in response.parameters}
        wanted = {"drift": "0.5", "label": "12", "count": "12", "sticky": "true"}
        self.assertEqual(values, wanted)
        self.assertEqual(list(values), list(DEFAULTS))
        self.assertEqual(self.session.describe().parameters, response.parameters)

    def test_refusals_change_nothing(self) -> None:
        before = self.session.describe()
        for values, message in (
            ({"dirft": "1"}, "dirft: unknown; known: drift, label"),
            ({"drift": "nan"}, "drift nan: must be a finite number"),
            ({"drift": "Infinity"}, "drift inf: must be a finite number"),
            ({"drift": "much"}, "drift much: must be a finite number"),
            ({"drift": "true"}, "drift True: must be a finite number"),
            ({"drift": "1_0"}, "drift 1_0: must be a finite number"),
            ({"drift": "[" * 100_000}, r"drift \[.*: must be a finite number"),
            ({"drift": ""}, "drift : must be a finite number"),
            ({"count": "1.5"}, "count 1.5: must be an integer"),
            ({"sticky": "1"}, "sticky 1: must be true or false"),
            ({"label": "x", "drift": "-1"}, "drift -1.0: must be at least 0 m/s"),
        ):
            self.refused(self.configure(values), message)
        self.refused(
            self.configure({"label": "broken"}),
            r"RuntimeError: no such engine \(__init__",
            exit_code=70,
        )
        self.assertEqual(data(self.session.describe()), data(before))

    def test_hash_tells_values_apart(self) -> None:
        plain = self.session.describe().parameters_hash
        self.configure({"drift": "0.6"})
        self.assertNotEqual(self.session.describe().parameters_hash, plain)
        self.configure({"drift": "5e-1"})
        self.assertEqual(self.session.describe().parameters_hash, plain)

    def test_describe(self) -> None:
        self.reset(stamp=Time(3))
        description = self.session.describe()
        self.assertTrue(description.success)
        self.assertEqual((description.name, description.version), ("drift", "1"))
        self.assertEqual((description.frame_prefix, description.stamp), ("here", Time(3)))
        self.assertIn("numpy", json.loads(description.provenance))


class Kinds(SessionCase):
    """An object in Python is of one kind and stays so."""

    def test_own_kind_again_has_its_defaults(self) -> None:
        self.accepted(self.configure({"drift": "0.6", "label": "mine"}))
        response = self.accepted(self.configure({"count": "4"}, kind="drift"))
        values = {parameter.name: parameter.value for parameter in response.parameters}
        self.assertEqual(
            values, {"drift": "0.5", "label": "plain", "count": "4", "sticky": "false"}
        )
        self.assertEqual([simulator.drift for simulator in self.simulators], [0.5, 0.6, 0.5])
        self.assertEqual(DEFAULTS["count"], 3)

    def test_defaults_are_those_of_the_simulator(self) -> None:
        """Not the values that the node started with."""
        values: Dict[str, Value] = {**DEFAULTS, "drift": 0.7}
        identity = Identity("drift", "1")
        self.session = SimulatorSession(
            self.make, values, identity, "here", self.updates.append, defaults=DEFAULTS
        )
        would_be = self.session.describe(DescribeRequest("drift"))
        self.assertEqual(would_be.parameters[0], Parameter("drift", "0.5"))
        response = self.accepted(self.configure(kind="drift"))
        self.assertEqual(response.parameters, would_be.parameters)

    def test_repeated_one_is_answered_again(self) -> None:
        self.reset(token="mine")
        first = self.accepted(self.configure({}, True, "mine", "drift"))
        again = self.accepted(self.configure({}, True, "mine", "drift"))
        self.assertEqual(data(again), data(first))
        self.assertEqual(len(self.simulators), 2, "nothing is made anew for it")
        other = self.configure({}, True, "mine")
        self.refused(other, "its episode has ended", ExitCode.RUNTIME_FAULT)

    def test_a_parameter_that_is_set_twice_is_refused(self) -> None:
        twice = [Parameter("drift", "0.6"), Parameter("count", "4"), Parameter("drift", "0.7")]
        answer = self.session.configure(ConfigureRequest(parameters=twice))
        self.refused(answer, "parameter drift 0.6, 0.7: must be set once")
        self.assertEqual(self.session.parameters, DEFAULTS)

    def test_long_texts_are_not_echoed(self) -> None:
        endless = "x" * 10_000_000
        for changes in ({endless: "1"}, {"drift": endless}):
            answer = self.configure(changes)
            self.refused(answer, "characters left out")
            self.assertLess(len(answer.message), 2100)

    def test_other_kinds_are_refused(self) -> None:
        self.reset()
        before = self.session.describe()
        for kind in ("mujoco", "Drift", "drift "):
            reason = f"simulator '{kind}': must be drift, the only kind that this node can be"
            self.refused(self.configure({}, end_episode=True, kind=kind), rf"\A{reason}\Z")
            self.refused(self.session.describe(DescribeRequest(kind)), rf"\A{reason}\Z")
        stray = self.configure({"dirft": "1"}, end_episode=True, kind="drift")
        self.refused(stray, "dirft: unknown")
        self.assertEqual(data(self.session.describe()), data(before))
        self.step(step=0)

    def test_hold_comes_first(self) -> None:
        self.reset(token="mine")
        for kind in ("drift", "mujoco"):
            answer = self.configure(kind=kind)
            self.refused(answer, "held by another caller", ExitCode.RUNTIME_FAULT)
        self.refused(self.configure(token="mine", kind="drift"), "mid-episode")

    def test_describe_what_it_would_be(self) -> None:
        self.accepted(self.configure({"drift": "0.6"}))
        self.reset(stamp=Time(3))
        before = self.session.describe()
        would_be = self.accepted(self.session.describe(DescribeRequest("drift")))
        self.assertEqual((would_be.name, would_be.kinds), ("drift", []))
        self.assertEqual(would_be.parameters[0], Parameter("drift", "0.5"))
        self.assertEqual(would_be.parameter_descriptors, before.parameter_descriptors)
        self.assertEqual((would_be.parameters_hash, would_be.provenance), ("", ""))
        self.assertEqual((would_be.frame_prefix, would_be.stamp), ("here", Time(3)))
        self.assertEqual(data(self.session.describe()), data(before))
        self.step(step=0)


class Parameters(unittest.TestCase):
    def test_integers_are_accepted_for_reals(self) -> None:
        drift = merged({"drift": 0.5}, {"drift": 2})["drift"]
        self.assertIsInstance(drift, float)

    def test_refusals_name_key_value_and_rule(self) -> None:
        cases: List[Tuple[Dict[str, Value], str]] = [
            ({"drift": "2"}, "parameter /sim/drift 2: must be a finite number"),
            ({"drift": math.nan}, "parameter /sim/drift nan: must be a finite number"),
            ({"count": True}, "parameter /sim/count True: must be an integer"),
            ({"dirft": 1}, "parameter /sim/dirft: unknown; known: drift"),
        ]
        for changes, message in cases:
            with self.assertRaisesRegex(Error, message):
                merged(DEFAULTS, changes, "/sim/")


class Starts(unittest.TestCase):
    def test_failed_start(self) -> None:
        cases: List[Tuple[Dict[str, Value], int]] = [
            ({"drift": -1.0}, 2),
            ({"label": "broken"}, 70),
        ]
        for values, exit_code in cases:
            identity = Identity("drift", "1")
            try:
                SimulatorSession(Drift, {**DEFAULTS, **values}, identity, "", lambda _: None)
                self.fail("must raise")
            except Error as failure:
                description = FailedStart(failure, identity).describe()
            self.assertFalse(description.success)
            self.assertEqual(description.exit_code, exit_code)
            self.assertNotIn("\n", description.message)
            self.assertEqual(description.instance_id, identity.instance_id)
        try:
            raise MemoryError("too\nmuch")
        except MemoryError as failure:
            description = FailedStart(failure, identity).describe()
        self.assertEqual(description.exit_code, ExitCode.INTERNAL_ERROR)
        self.assertRegex(description.message, r"\AMemoryError: too much \(.*, line \d+\)\Z")

    def test_instances_differ(self) -> None:
        self.assertNotEqual(Identity("a", "1").instance_id, Identity("a", "1").instance_id)

    def test_waits_for_the_master(self) -> None:
        code = (
            "import sys; from sim2sim_serving.ros import serve_policy;"
            " sys.exit(serve_policy(lambda rows: rows[:, :2], name='mine', version='1'))"
        )
        process = subprocess.Popen(
            [sys.executable, "-c", code],
            env={**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"},
            stderr=subprocess.PIPE,
            text=True,
        )
        assert process.stderr
        with process.stderr:
            waiting = process.stderr.readline()
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(timeout=10), ExitCode.RUNTIME_FAULT)
            self.assertRegex(waiting, r"\Amine: waiting for the ROS master at .*: roscore .*\n\Z")
            self.assertEqual(process.stderr.read(), "")


class Policies(unittest.TestCase):
    QUERIES = [Query(rollout=5, observation=range(10)), Query(rollout=6, observation=[1] * 10)]

    def session(self, act: Any) -> PolicySession:
        return PolicySession(act, Identity("mine", "2"))

    def test_rows(self) -> None:
        seen: Dict[str, Any] = {}

        def act(rows: np.ndarray) -> np.ndarray:
            seen.update(shape=rows.shape, dtype=rows.dtype)
            return rows[:, :2] + np.array([0.5, math.inf])

        response = self.session(act).act(ActRequest(self.QUERIES))
        self.assertTrue(response.success)
        self.assertEqual(response.actions, [0.5, math.inf, 1.5, math.inf])
        self.assertEqual(seen, {"shape": (2, 10), "dtype": np.float32})
        data(response)

    def test_nothing_asked(self) -> None:
        response = self.session(None).act(ActRequest())
        self.assertEqual((response.success, response.actions), (True, []))

    def test_refusals(self) -> None:
        def fail(rows: np.ndarray) -> None:
            raise KeyError("weights")

        def bad(number: float) -> List[Query]:
            return [*self.QUERIES, Query(rollout=8, observation=[0] * 9 + [number])]

        many = [Query(rollout=8, execute=2**32 - 1)]
        for act, queries, exit_code, message in (
            (fail, many, 2, "rollout 8: execute 4294967295: must be from 1 to 1, the actions"),
            (lambda rows: rows, self.QUERIES, 3, r"shape \[2, 10\] .* must be \[2, 2\]"),
            (lambda rows: rows[0, :2], self.QUERIES, 3, r"shape \[2\] of the actions"),
            (lambda rows: "left", self.QUERIES, 4, "act: ValueError: could not convert"),
            (fail, self.QUERIES, 4, r"act: KeyError: 'weights' \(fail"),
            (fail, bad(math.nan), 2, "rollout 8: observation must be finite"),
        ):
            session = self.session(act)
            response = session.act(ActRequest(queries))
            self.assertFalse(response.success)
            self.assertRegex(response.message, message)
            self.assertEqual(response.exit_code, exit_code)
            self.assertEqual(response.instance_id, session.describe().instance_id)

    def test_describe(self) -> None:
        description = self.session(None).describe()
        self.assertTrue(description.success)
        self.assertEqual((description.name, description.version), ("mine", "2"))
        self.assertEqual((description.parameters, description.parameters_hash), ([], ""))
        self.assertNotIn("noise", json.loads(description.provenance))

    def test_stochastic_one_says_so(self) -> None:
        identity = Identity("mine", "2")
        description = PolicySession(lambda rows: rows[:, :2], identity, stochastic=True).describe()
        self.assertEqual(json.loads(description.provenance)["noise"], {"drawn_by": "the node"})


class PoliciesWithMemory(unittest.TestCase):
    """The rules are those of the session in C++: session_test.cpp."""

    def setUp(self) -> None:
        self.fails = False
        self.session = PolicySession(self.count, Identity("mine", "2"), self.begin, answers=3)

    @staticmethod
    def begin(seed: int, execute: int) -> List[int]:
        if seed == 13:
            raise ValueError("unlucky")
        return [seed, execute, 0]

    def count(self, rows: np.ndarray, memories: List[List[int]]) -> List[List[float]]:
        """Answers with how often a rollout has asked, and its seed."""
        for memory in memories:
            memory[2] += 1
        if self.fails:
            raise KeyError("weights")
        self.assertEqual(len(rows), len(memories))
        return [[memory[2], memory[0]] for memory in memories]

    def act(self, *steps: Tuple[int, int], **fields: Any) -> Any:
        queries = [Query(rollout=rollout, step=step, **fields) for rollout, step in steps]
        return self.session.act(ActRequest(queries))

    def test_each_rollout_apart(self) -> None:
        self.assertEqual(self.act((7, 0), (9, 0), seed=4).actions, [1, 4, 1, 4])
        self.assertEqual(self.act((9, 1)).actions, [2, 4])
        self.assertEqual(self.act((9, 2), (7, 1)).actions, [3, 4, 2, 4])

    def test_last_step_again_and_the_first_anew(self) -> None:
        self.act((7, 0))
        self.act((7, 1))
        self.assertEqual(self.act((7, 1), (9, 0)).actions, [2, 0, 1, 0])
        self.assertEqual(self.act((7, 2)).actions, [3, 0])
        self.assertEqual(self.act((7, 0), seed=5).actions, [1, 5])
        self.assertEqual(self.act((7, 1)).actions, [2, 5])

    def test_refusals_change_nothing(self) -> None:
        self.act((7, 0))
        self.act((7, 1))
        cases: Sequence[Tuple[List[Tuple[int, int]], Dict[str, Any], str]] = (
            ([(9, 0), (7, 3)], {}, "rollout 7: step 3: expected 2"),
            ([(7, 0), (9, 1)], {}, "rollout 9: step 1: expected 0"),
            ([(7, 2), (7, 2)], {}, "rollout 7: must be asked for once in a request"),
            (
                [(7, 1)],
                {"observation": [0.5] * 10},
                "rollout 7: step 1: was answered for another observation",
            ),
            ([(7, 0)], {"execute": 4}, "rollout 7: execute 4: must be from 1 to 3, the actions"),
        )
        for steps, fields, message in cases:
            response = self.act(*steps, **fields)
            self.assertEqual((response.success, response.exit_code), (False, 2))
            self.assertIn(message, response.message)
        self.assertEqual(self.act((7, 2)).actions, [3, 0])
        self.assertEqual(self.act((8, 0), execute=3).actions, [1, 0])

    def test_after_a_failure_a_rollout_begins_anew(self) -> None:
        self.act((7, 0), (9, 0))
        self.fails = True
        self.assertRegex(self.act((7, 1)).message, "act: KeyError: 'weights'")
        self.fails = False
        self.assertEqual(self.act((7, 1)).message, "rollout 7: step 1: expected 0")
        self.assertEqual(self.act((7, 0), (9, 1)).actions, [1, 0, 2, 0])
        response = self.act((9, 0), seed=13)
        self.assertEqual(response.exit_code, 4)
        self.assertRegex(response.message, "begin: ValueError: unlucky")
        self.assertEqual(self.act((9, 2)).actions, [3, 0], "a beginning that failed is none")

    def test_rollouts_that_were_not_asked_for_lately_are_forgotten(self) -> None:
        self.act((7, 0))
        self.act((8, 0))
        with mock.patch.multiple("sim2sim_serving.policy_session", MANY_ROLLOUTS=2, LATELY=2):
            for step in range(1, 4):
                self.act((8, step))
        self.assertEqual(self.act((8, 4)).actions, [5, 0])
        self.assertEqual(self.act((7, 1)).message, "rollout 7: step 1: expected 0")


def data(message: Any) -> bytes:
    """What travels."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


if __name__ == "__main__":
    unittest.main()
