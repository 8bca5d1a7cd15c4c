# SPDX-License-Identifier: BSD-3-Clause
"""gym-pusht's environment, on its own physics or on another engine's."""

from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim2sim import renderers
from sim2sim._sim2sim import (
    GYM_PUSHT_FIRST_SEED,
    GYM_PUSHT_SUCCESS,
    PixelWorlds,
    gym_pusht_drawn,
    gym_pusht_keypoints,
)
from sim2sim.checks import (
    checked_integer,
    checked_number,
    checked_numbers,
    checked_option,
    checked_text,
)
from sim2sim.errors import InvalidInput
from sim2sim.gym import NEXT_STEP, Box, Env, VectorEnv
from sim2sim.sight import GOAL, SIDE, Observation, Sight, checked_side
from sim2sim.starts import Seeds, Starts, seeds_of

Info = Dict[str, Any]

STATE = 5  # numbers that a reset takes
LARGEST_SEED = 2**32 - 1  # of numpy's RandomState
CONTACTS_PER_STEP = 1000  # by which gym-pusht divides the number of contact points
RENDER_MODES = ["human", "rgb_array"]
FRAMES_PER_SECOND = 100  # of a window, as gym-pusht has it
LARGEST_OFFSET = 512.0  # [px] of a center of gravity


class _PixelEpisodes:
    """What one environment and many have in common."""

    metadata: Dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 10}
    spec = None
    success_threshold = GYM_PUSHT_SUCCESS

    def __init__(
        self,
        count: int,
        sight: Sight,
        horizon: Optional[int],
        engine: str,
        block_cog: Optional[Sequence[float]],
        damping: Optional[float],
        parameters: Mapping[str, object],
    ) -> None:
        self.engine = checked_text("engine", engine)
        self._horizon = (
            None if horizon is None else checked_integer("max_episode_steps", horizon, 1, 10**6)
        )
        self.block_cog = block_cog
        self.damping = damping
        self.goal_pose = np.array(GOAL)
        self._sight = sight
        self._worlds = PixelWorlds(
            self.engine,
            dict(parameters),
            count,
            _checked_point(block_cog),
            _checked_damping(damping),
        )
        self._starts = [Starts(GYM_PUSHT_FIRST_SEED) for _ in range(count)]
        self._steps: Optional[NDArray[np.int64]] = None  # None: must be reset

    def _begin(self, world: int, seed: Optional[int], state: Optional[NDArray[np.float64]]) -> None:
        """Begins an episode: in a given state, or from a seed; without one, from one that is
        drawn, which the last given seed decides."""
        starts = self._starts[world]
        if seed is not None:
            starts.given(seed)
        if state is None:
            state = gym_pusht_drawn(starts.drawn() if seed is None else seed)
        self._worlds.reset(world, state)

    def _info(self, states: NDArray[np.float64]) -> Info:
        """Each entry is an array over the worlds."""
        contacts = -(-self._worlds.contacts // CONTACTS_PER_STEP)
        return {
            "pos_agent": states[:, :2].copy(),
            "vel_agent": states[:, 2:4].copy(),
            "block_pose": np.column_stack([states[:, 4:6], self._worlds.unwrapped_angles]),
            "goal_pose": np.tile(self.goal_pose, (len(states), 1)),
            "n_contacts": contacts.astype(np.int64),
        }


class PushTEnv(_PixelEpisodes, Env):
    """gym-pusht's environment: the same arguments, arrays and numbers, to the last bit.

    `engine` puts it on another engine, with that kind's `parameters`. `max_episode_steps`: control
    steps after which an episode is truncated; None: never, as there.

    What differs: a reset without a seed draws one that the last given seed decides; bad input is
    refused by name; pymunk's objects (`space`, `agent`, `block`) and `teleop_agent()` are not
    there; render() without a render mode gives None.
    """

    def __init__(
        self,
        obs_type: str = "state",
        render_mode: Optional[str] = "rgb_array",
        block_cog: Optional[Sequence[float]] = None,
        damping: Optional[float] = None,
        observation_width: int = 96,
        observation_height: int = 96,
        visualization_width: int = 680,
        visualization_height: int = 680,
        *,
        engine: str = "gym_pusht",
        max_episode_steps: Optional[int] = None,
        **parameters: object,
    ) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise InvalidInput(
                f"render_mode {render_mode!r}: must be one of {', '.join(RENDER_MODES)}"
            )
        sight = Sight(obs_type, observation_width, observation_height)
        super().__init__(1, sight, max_episode_steps, engine, block_cog, damping, parameters)
        self.obs_type = obs_type
        self.render_mode = render_mode
        self.observation_width = observation_width
        self.observation_height = observation_height
        self.visualization_width = checked_side("visualization_width", visualization_width)
        self.visualization_height = checked_side("visualization_height", visualization_height)
        self.observation_space = sight.space()
        self.action_space = Box(0, SIDE, (2,))
        self._last_action: Optional[NDArray[np.float64]] = None
        self._window: Any = None

    def reset(
        self, seed: Optional[int] = None, options: Optional[Mapping[str, Any]] = None
    ) -> Tuple[Observation, Info]:
        """Begins an episode from gym-pusht's draw of `seed`, below 2^32; or, with
        `options={"reset_to_state": [...]}`, from pusher x, y, tee x, y [px], angle [rad], which
        moves the tee as there (docs/tasks.md)."""
        state = _state_in(options)
        wanted = None if seed is None else checked_integer("seed", seed, 0, LARGEST_SEED)
        super().reset(seed=wanted)
        self._begin(0, wanted, state)
        self._steps = np.zeros(1, np.int64)
        states = self._worlds.states
        if self.render_mode == "human":
            self.render()
        return self._seen(states), {**self._first_info(states), "is_success": False}

    def step(self, action: ArrayLike) -> Tuple[Observation, np.float64, bool, bool, Info]:
        """Takes a control step (0.1 s) that draws the pusher to `action` [px], which is not
        clipped. Returns observation, reward, terminated, truncated and info."""
        if self._steps is None:
            raise InvalidInput("step: no episode has begun; reset the environment")
        target = _finite("action", action, (2,))
        self._worlds.step(target[np.newaxis], np.ones(1, np.bool_))
        self._last_action = target
        self._steps += 1
        states = self._worlds.states
        coverage = float(self._worlds.coverages[0])
        is_success = coverage > GYM_PUSHT_SUCCESS
        info = {**self._first_info(states), "is_success": is_success, "coverage": coverage}
        truncated = self._horizon is not None and bool(self._steps[0] >= self._horizon)
        return self._seen(states), self._worlds.rewards[0], is_success, truncated, info

    def render(self) -> Any:
        """The picture for people, with a cross where the last action draws to; or, in the mode
        "human", a window."""
        if self._steps is None or self.render_mode is None:
            return None
        pictures = renderers.pictures()
        states = self._worlds.states
        numbers = np.concatenate([states[0, :2], gym_pusht_keypoints(states)[0]])
        surface = pictures.draw(numbers)
        if self.render_mode == "human":
            self._window = self._window or pictures.Window(FRAMES_PER_SECOND)
            self._window.show(surface)
            return None
        image = pictures.scaled(surface, self.visualization_width, self.visualization_height)
        if self._last_action is not None:
            pictures.mark(image, self._last_action)
        return image

    def get_obs(self) -> Observation:
        """The observation of the present state."""
        return self._seen(self._worlds.states)

    def close(self) -> None:
        """Closes the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _seen(self, states: NDArray[np.float64]) -> Observation:
        return self._sight.first(self._sight.of(states))

    def _first_info(self, states: NDArray[np.float64]) -> Info:
        info = {name: values[0] for name, values in self._info(states).items()}
        return {**info, "n_contacts": int(info["n_contacts"])}


class PushTVectorEnv(_PixelEpisodes, VectorEnv):
    """Environments of gym-pusht that step together. Autoreset is that of the next step, as that of
    Gymnasium's SyncVectorEnv, whose bits they have."""

    metadata: Dict[str, Any] = {**_PixelEpisodes.metadata, "autoreset_mode": NEXT_STEP}
    render_mode = None

    def __init__(
        self,
        num_envs: int = 1,
        obs_type: str = "state",
        block_cog: Optional[Sequence[float]] = None,
        damping: Optional[float] = None,
        observation_width: int = 96,
        observation_height: int = 96,
        *,
        engine: str = "gym_pusht",
        max_episode_steps: Optional[int] = None,
        **parameters: object,
    ) -> None:
        self.num_envs = checked_integer("num_envs", num_envs, 1, 100_000)
        sight = Sight(obs_type, observation_width, observation_height)
        super().__init__(num_envs, sight, max_episode_steps, engine, block_cog, damping, parameters)
        self.single_observation_space = sight.space()
        self.single_action_space = Box(0, SIDE, (2,))
        self.observation_space = sight.space(num_envs)
        self.action_space = Box(0, SIDE, (num_envs, 2))
        self._ended = np.zeros(num_envs, np.bool_)

    def reset(
        self,
        *,
        seed: Seeds = None,
        options: Optional[Mapping[str, Any]] = None,
    ) -> Tuple[Observation, Info]:
        """Begins an episode in each: `seed` s gives environment i the seed s + i; a list has one
        for each. `options={"reset_to_state": ...}` has states [num_envs, 5]."""
        states = _state_in(options, self.num_envs)
        seeds = seeds_of(seed, self.num_envs, LARGEST_SEED)
        super().reset(seed=seeds[0])
        self._steps = None  # until all are reset
        for world, one in enumerate(seeds):
            self._begin(world, one, None if states is None else states[world])
        self._steps = np.zeros(self.num_envs, np.int64)
        self._ended = np.zeros(self.num_envs, np.bool_)
        now = self._worlds.states
        return self._sight.of(now), {
            **self._info(now),
            "is_success": np.zeros(self.num_envs, np.bool_),
        }

    def step(
        self, actions: ArrayLike
    ) -> Tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Info]:
        """Takes a control step in each; where an episode has ended, begins the next one."""
        if self._steps is None:
            raise InvalidInput("step: no episode has begun; reset the environments")
        targets = _finite("actions", actions, (self.num_envs, 2))
        begin = self._ended
        self._worlds.step(targets, ~begin)
        for world in np.flatnonzero(begin):
            self._begin(int(world), None, None)
        self._steps = np.where(begin, 0, self._steps + 1)
        states = self._worlds.states
        coverage = np.where(begin, 0.0, self._worlds.coverages)
        terminated = coverage > GYM_PUSHT_SUCCESS
        truncated = np.zeros(self.num_envs, np.bool_)
        if self._horizon is not None:
            truncated = self._steps >= self._horizon
        self._ended = terminated | truncated
        info = {
            **self._info(states),
            "is_success": terminated,
            "coverage": coverage,
            "_coverage": ~begin,
        }
        rewards = np.where(begin, 0.0, self._worlds.rewards)
        return self._sight.of(states), rewards, terminated, truncated, info


def _checked_point(point: Optional[Sequence[float]]) -> Optional[Tuple[float, float]]:
    if point is None:
        return None
    x, y = _finite("block_cog", point, (2,))
    if max(abs(x), abs(y)) > LARGEST_OFFSET:
        raise InvalidInput(f"block_cog {x}, {y}: must be within {LARGEST_OFFSET} px of the origin")
    return float(x), float(y)


def _checked_damping(damping: Optional[float]) -> Optional[float]:
    if damping is None:
        return None
    value = checked_number("damping", damping)
    if not 0.0 <= value <= 1.0:
        raise InvalidInput(f"damping {value}: must be from 0 to 1")
    return value


def _finite(name: str, given: object, shape: Tuple[int, ...]) -> NDArray[np.float64]:
    numbers = checked_numbers(name, given, shape)
    if not np.isfinite(numbers).all():
        raise InvalidInput(f"{name} {numbers.tolist()}: must be finite")
    return np.ascontiguousarray(numbers, np.float64)


def _state_in(
    options: Optional[Mapping[str, Any]], count: Optional[int] = None
) -> Optional[NDArray[np.float64]]:
    """The state that options of a reset ask for, or those of `count` environments."""
    state = checked_option(options, "reset_to_state")
    if state is None:
        return None
    shape = (STATE,) if count is None else (count, STATE)
    return _finite("reset_to_state", state, shape)
