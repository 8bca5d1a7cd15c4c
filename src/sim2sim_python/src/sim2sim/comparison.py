# SPDX-License-Identifier: BSD-3-Clause
"""Comparison of two simulators under one policy, in process."""

from dataclasses import replace
from typing import Mapping, Optional

from sim2sim import _sim2sim
from sim2sim.asked import asked
from sim2sim.checks import checked_mapping, checked_text
from sim2sim.errors import InvalidInput
from sim2sim.results import Comparison, comparison_of
from sim2sim.sight import Sight
from sim2sim.simulator import in_python
from sim2sim.stopwatch import Stopwatch


def compare(
    policy: object = "bc",
    *,
    reference: object = None,
    engine: object = None,
    reference_parameters: Optional[Mapping[str, object]] = None,
    engine_parameters: Optional[Mapping[str, object]] = None,
    history: Optional[int] = None,
    version: Optional[str] = None,
    obs_type: Optional[str] = None,
    observation_width: Optional[int] = None,
    observation_height: Optional[int] = None,
    progress: bool = False,
    **options: object,
) -> Comparison:
    """Compares two simulators under one policy, as `rosrun sim2sim_eval compare` does.

    `policy` is a name or file as for the command, or a callable: it gets observations float32
    [n, 10], or with `history=H` [n, H, 10] with the oldest first, and gives actions [n, 2], or a
    chunk [n, K, 2], of which the first `execute` are taken before it is asked again (all without
    `execute`). An object with begin(seed) and act(observations, memories) has a memory for each
    row: begin() makes one at the beginning of a rollout, act() changes it in place. All calls come
    from the thread that called compare(). A PyTorch module, eager or scripted, is a callable: it
    gets and gives tensors, without gradients and in evaluation mode.

    In the task gym_pusht, `obs_type` hands a callable what gym-pusht's environment of that type
    shows, for n worlds at once: arrays, or a dict of them, whose first axis is the worlds', and
    with `history` the second one the past's (sim2sim.gym_pusht.Sight).

    Before the run a callable is asked for eight rows, in order, in reverse, and for three of them.
    If a row gets another action (by more than 0.001 m/s, or 0.2 px), the callable has a memory or
    random numbers of its own, or mixes rows, and is refused.

    `reference` and `engine` are names as for the command, or classes with reset() and step() of
    which a world is made by each call: worlds() describes them, and gives them a name, a version
    and parameters. Their calls come from the same thread. Without a `version` a run cannot go on.

    `options` are those of the command, with underscores: episodes=200, horizon=100,
    loop={"action_delay": 2} or "tracker", threads=2, out="results/mine". Without `out` nothing is
    written.

    With a callable, `threads` is 1 by default: then the rows of each call are the same ones every
    time. With more threads they are not, which changes no result if a row's action has the same
    bits whatever rows are beside it. A callable with an attribute `row_independent`, which is true,
    says so, and gets all cores. `version` names the policy for runs that continue and for
    reference_cache, which otherwise refuse a callable.

    Raises Error, with the command's words; what a callable or a world raises; KeyboardInterrupt at
    Ctrl-C.
    """
    simulators = in_python(options, reference=reference, engine=engine)
    options["set_reference"] = dict(checked_mapping("reference_parameters", reference_parameters))
    options["set"] = dict(checked_mapping("engine_parameters", engine_parameters))
    sizes = {"width": observation_width, "height": observation_height}
    given = {side: size for side, size in sizes.items() if size is not None}
    if obs_type is None and given:
        raise InvalidInput(f"observation_{min(given)}: must be left out without an obs_type")
    sight = None if obs_type is None else Sight(obs_type, **given)
    known_as = "" if version is None else checked_text("version", version)
    stopwatch = Stopwatch()
    with asked(policy, history=history, version=version, obs_type=obs_type) as it:
        if it.callable is None:
            options["policy"] = policy
        one_thread = it.callable is not None and not getattr(policy, "row_independent", False)
        if (one_thread or simulators) and options.get("threads") is None:
            options["threads"] = 1
        texts = _sim2sim.compare(
            options,
            None if it.callable is None else stopwatch.timed_policy(it.callable),
            it.name,
            known_as,
            it.history,
            None if sight is None else stopwatch.timed("observations", sight.with_past),
            "" if sight is None else str(sight),
            simulators,
            bool(progress),
        )
    return replace(comparison_of(texts), seconds=stopwatch.seconds())
