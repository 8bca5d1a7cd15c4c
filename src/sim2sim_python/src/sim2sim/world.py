# SPDX-License-Identifier: BSD-3-Clause
"""Worlds of PushT as environments of Gymnasium, one or many at a time.

https://gymnasium.farama.org/api/env and /api/vector define what the methods mean.
"""

from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim2sim._sim2sim import (
    HORIZON,
    STATE_FIELDS,
    WorldBatch,
    kinds,
    parameters_of,
)
from sim2sim.checks import (
    LARGEST_SEED,
    OBSERVATION,
    checked_integer,
    checked_numbers,
    checked_option,
    checked_seed,
    checked_text,
)
from sim2sim.errors import InvalidInput
from sim2sim.gym import NEXT_STEP, Box, Env, VectorEnv, register, register_gym_pusht
from sim2sim.pixel_world import PushTEnv, PushTVectorEnv
from sim2sim.starts import Seeds, Starts, seeds_of

Info = Dict[str, Any]
ACTION = 2  # numbers
GYM_PUSHT = "gym_pusht"  # task and kind
VELOCITIES = ("pusher_vx", "pusher_vy", "tee_vx", "tee_vy", "tee_yaw_rate")  # 0 if left out
MOST_WORLDS = 100_000


class _Worlds:
    """What one world and many have in common."""

    metadata: Dict[str, Any] = {"render_modes": [], "render_fps": 10}
    render_mode = None
    spec = None

    def __init__(
        self,
        kind: str,
        count: int,
        horizon: int,
        task: Optional[str],
        parameters: Mapping[str, object],
    ) -> None:
        self.kind = checked_text("kind", kind)
        self.horizon = checked_integer("horizon", horizon, 1, 1_000_000)
        named = "" if task is None else checked_text("task", task)
        self._batch = WorldBatch(self.kind, dict(parameters), count, named)
        self._starts = [Starts(self._batch.first_spawn_seed) for _ in range(count)]
        self._ended: Optional[NDArray[np.bool_]] = None  # None: must be reset

    def render(self) -> None:
        """Does nothing: worlds have no picture of their own; `report` draws runs."""

    def _reset(self, seeds: Sequence[Optional[int]], states: Optional[NDArray[np.float64]]) -> Info:
        drawn = []
        for world, (starts, seed) in enumerate(zip(self._starts, seeds)):
            if states is None:
                drawn.append(starts.drawn() if seed is None else seed)
                self._batch.spawn(world, drawn[-1])
            else:
                self._batch.reset(world, states[world])
            if seed is not None:
                starts.given(seed)
            self._ended = (
                None  # until all are reset; a refusal of the first leaves them as they were
            )
        self._ended = np.zeros(len(self._starts), np.bool_)
        info = self._info()
        if states is None:
            info["seed"] = np.array(drawn, np.uint64)
        return info

    def _info(self) -> Info:
        batch = self._batch
        coverage = {"coverage": batch.coverages} if batch.judged_by_coverage else {}
        return {
            **coverage,
            "state": batch.states,
            "position_error": batch.position_errors,
            "angle_error": batch.angle_errors,
            "success": batch.successes,
            "steps": batch.steps,
        }

    def _ends(self) -> Tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which worlds have succeeded, and which have reached the horizon."""
        terminated = self._batch.successes
        truncated = self._batch.steps >= self.horizon
        self._ended = terminated | truncated
        return terminated, truncated


class World(_Worlds, Env):
    """One world of PushT, of a kind of simulator, as an environment of Gymnasium.

    `horizon`: control steps after which an episode is truncated. `task`: a name, or a file
    NAME.json; without one, the kind's own. `parameters` are the kind's.
    """

    def __init__(
        self,
        kind: str,
        *,
        horizon: int = HORIZON,
        task: Optional[str] = None,
        **parameters: object,
    ) -> None:
        super().__init__(kind, 1, horizon, task, parameters)
        limit = self._batch.action_limit
        self.observation_space = Box(-np.inf, np.inf, (OBSERVATION,))
        self.action_space = Box(-limit, limit, (ACTION,))

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Mapping[str, Any]] = None
    ) -> Tuple[NDArray[np.float32], Info]:
        """Begins an episode; returns observation float32 [10] and info.

        It starts from the suite's spawn of `seed`; without a seed, from one that is drawn, which
        the last given seed decides. `options={"state": ...}` starts from a state instead: 10
        numbers as STATE_FIELDS, or a dict of them, in which velocities may be left out.
        """
        state = _state_in(options)
        wanted = None if seed is None else checked_seed(seed)
        super().reset(seed=wanted)
        info = self._reset([wanted], None if state is None else state[np.newaxis])
        return self._batch.observations[0], _first(info)

    def step(self, action: ArrayLike) -> Tuple[NDArray[np.float32], float, bool, bool, Info]:
        """Takes a control step (0.1 s) with an action of the task: the commanded velocity of the
        pusher [m/s], or the position to which it is drawn.

        Returns observation, reward, terminated (success), truncated (horizon) and info. The
        reward is that of the task: -(position error / 0.5 m + angle error / pi) / 2, and 1 more in
        the step in which success latches; or the coverage over that of success, at most 1. After
        an end a world must be reset.
        """
        if self._ended is None or self._ended[0]:
            raise InvalidInput("step: the episode has ended, or none has begun; reset the world")
        actions = _checked_actions("action", action, (ACTION,))[np.newaxis]
        self._step(actions)
        terminated, truncated = self._ends()
        return (
            self._batch.observations[0],
            float(self._batch.rewards[0]),
            bool(terminated[0]),
            bool(truncated[0]),
            _first(self._info()),
        )

    def _step(self, actions: NDArray[np.float32]) -> None:
        self._batch.step(actions, np.ones(1, np.bool_))


class VectorWorld(_Worlds, VectorEnv):
    """Worlds of one kind that step together, as a vector environment of Gymnasium.

    Autoreset is that of the next step (AutoresetMode.NEXT_STEP): the step after the end of an
    episode ignores the action of that world and begins its next episode, with reward 0 and
    neither terminated nor truncated. Its start is drawn as by reset() without a seed.
    """

    metadata: Dict[str, Any] = {**_Worlds.metadata, "autoreset_mode": NEXT_STEP}

    def __init__(
        self,
        kind: str,
        num_envs: int,
        *,
        horizon: int = HORIZON,
        task: Optional[str] = None,
        **parameters: object,
    ) -> None:
        self.num_envs = checked_integer("num_envs", num_envs, 1, MOST_WORLDS)
        super().__init__(kind, self.num_envs, horizon, task, parameters)
        limit = self._batch.action_limit
        self.single_observation_space = Box(-np.inf, np.inf, (OBSERVATION,))
        self.single_action_space = Box(-limit, limit, (ACTION,))
        self.observation_space = Box(-np.inf, np.inf, (num_envs, OBSERVATION))
        self.action_space = Box(-limit, limit, (num_envs, ACTION))

    def reset(
        self,
        *,
        seed: Seeds = None,
        options: Optional[Mapping[str, Any]] = None,
    ) -> Tuple[NDArray[np.float32], Info]:
        """Begins an episode in each world; returns observations float32 [num_envs, 10] and info.

        `seed` s gives world i the seed s + i; a list has one for each. `options={"state": ...}`
        starts from states [num_envs, 10]. Each entry of info is an array over the worlds.
        """
        states = _state_in(options, self.num_envs)
        seeds = seeds_of(seed, self.num_envs, LARGEST_SEED)
        super().reset(seed=seeds[0])
        info = self._reset(seeds, states)
        return self._batch.observations, info

    def step(
        self, actions: ArrayLike
    ) -> Tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        Info,
    ]:
        """Takes a control step in each world; arrays as World.step().

        Where a world has begun its next episode, info has its `seed`, and `_seed` is true.
        """
        if self._ended is None:
            raise InvalidInput("step: no episode has begun; reset the worlds")
        rows = _checked_actions("actions", actions, (self.num_envs, ACTION))
        ended = self._ended
        self._batch.step(rows, ~ended)
        seeds = np.zeros(self.num_envs, np.int64)
        for world in np.flatnonzero(ended):
            seeds[world] = self._starts[world].drawn()
            self._batch.spawn(int(world), int(seeds[world]))
        terminated, truncated = self._ends()
        info = self._info()
        if ended.any():
            info.update({"seed": seeds, "_seed": ended})
        return self._batch.observations, self._batch.rewards, terminated, truncated, info


@overload
def make(
    kind: str,
    *,
    obs_type: None = None,
    horizon: int = HORIZON,
    task: Optional[str] = None,
    **parameters: object,
) -> World:
    ...


@overload
def make(
    kind: str,
    *,
    obs_type: str,
    horizon: int = HORIZON,
    task: Optional[str] = None,
    **parameters: Any,
) -> PushTEnv:
    ...


def make(
    kind: str,
    *,
    obs_type: Optional[str] = None,
    horizon: int = HORIZON,
    task: Optional[str] = None,
    **parameters: Any,
) -> Union[World, PushTEnv]:
    """A world of an installed kind: make("mujoco", timestep=0.005).

    With `obs_type` it is gym-pusht's environment (sim2sim.gym_pusht.PushTEnv), whose arguments are
    then the keywords: make("gym_pusht", obs_type="state"). Another kind, or `engine`, puts it on
    other physics: make("mujoco", obs_type="pixels").
    """
    if obs_type is None:
        return World(kind, horizon=horizon, task=task, **parameters)
    arguments = _of_pixel_world(kind, task, parameters)
    return PushTEnv(obs_type, max_episode_steps=horizon, **arguments)


@overload
def make_vec(
    kind: str,
    num_envs: int = 1,
    *,
    obs_type: None = None,
    horizon: int = HORIZON,
    task: Optional[str] = None,
    **parameters: object,
) -> VectorWorld:
    ...


@overload
def make_vec(
    kind: str,
    num_envs: int = 1,
    *,
    obs_type: str,
    horizon: int = HORIZON,
    task: Optional[str] = None,
    **parameters: Any,
) -> PushTVectorEnv:
    ...


def make_vec(
    kind: str,
    num_envs: int = 1,
    *,
    obs_type: Optional[str] = None,
    horizon: int = HORIZON,
    task: Optional[str] = None,
    **parameters: Any,
) -> Union[VectorWorld, PushTVectorEnv]:
    """Worlds of an installed kind that step together; with `obs_type`, environments of gym-pusht
    (sim2sim.gym_pusht.PushTVectorEnv), as make()."""
    if obs_type is None:
        return VectorWorld(kind, num_envs, horizon=horizon, task=task, **parameters)
    arguments = _of_pixel_world(kind, task, parameters)
    return PushTVectorEnv(num_envs, obs_type, max_episode_steps=horizon, **arguments)


def _of_pixel_world(
    kind: str, task: Optional[str], parameters: Mapping[str, Any]
) -> Dict[str, Any]:
    """Arguments of gym-pusht's environment on the engine `kind`, or on the one that they name."""
    if task not in (None, GYM_PUSHT):
        raise InvalidInput(f"task {task}: must be {GYM_PUSHT}, or left out, with an obs_type")
    if "max_episode_steps" in parameters:
        raise InvalidInput("max_episode_steps: must be given as horizon")
    if "engine" in parameters and kind != GYM_PUSHT:
        engine = parameters["engine"]
        raise InvalidInput(f"engine {engine}: must be left out with the kind {kind}, which is one")
    return {"engine": kind, **parameters}


def parameters(kind: str) -> List[Dict[str, Any]]:
    """The parameters of a kind: name, type, unit, default, range, meaning."""
    return parameters_of(checked_text("kind", kind))


def _first(info: Info) -> Info:
    """The info of one world from that of a batch of one."""
    return {name: value[0] if value.ndim > 1 else value[0].item() for name, value in info.items()}


def _checked_actions(name: str, actions: object, shape: Tuple[int, ...]) -> NDArray[np.float32]:
    return np.asarray(checked_numbers(name, actions, shape), np.float32)


def _state_in(
    options: Optional[Mapping[str, Any]], count: Optional[int] = None
) -> Optional[NDArray[np.float64]]:
    """The state that options of a reset ask for, or those of `count` worlds."""
    state = checked_option(options, "state")
    if state is None:
        return None
    if count is None and isinstance(state, Mapping):
        state = _numbers_by_name(state)
    shape = (len(STATE_FIELDS),) if count is None else (count, len(STATE_FIELDS))
    return np.ascontiguousarray(checked_numbers("state", state, shape), np.float64)


def _numbers_by_name(state: Mapping[str, float]) -> List[float]:
    for name in state:
        if name not in STATE_FIELDS:
            raise InvalidInput(f"state {name}: unknown; known: {', '.join(STATE_FIELDS)}")
    for name in STATE_FIELDS:
        if name not in state and name not in VELOCITIES:
            raise InvalidInput(f"state: {name} is missing; velocities alone may be left out")
    return [state.get(name, 0.0) for name in STATE_FIELDS]


register(kinds())
register_gym_pusht("sim2sim/GymPushT-v0")
