# SPDX-License-Identifier: BSD-3-Clause
"""What the configuration of a run says beside what every run's says."""

from typing import Any, Dict

__all__ = ["changed_options"]

# Keys of each configuration; further ones are options that are not the course's.
ALWAYS = frozenset(
    (
        *("format", "policy", "seed", "first_episode", "episodes", "horizon", "smoke", "probes"),
        *("bound", "reference_simulator", "engine_simulator", "knobs", "simulators", "config_hash"),
    )
)


def changed_options(configuration: Dict[str, Any]) -> Dict[str, Any]:
    """Options of a run that a configuration has only because they are changed, such as repeats;
    and `starts`, if the run took its initial states from a file."""
    return {name: value for name, value in configuration.items() if name not in ALWAYS}
