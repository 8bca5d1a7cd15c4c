# SPDX-License-Identifier: BSD-3-Clause
"""The success rate of a checkpoint in MuJoCo, from a comparison into its provenance."""

from pathlib import Path
from typing import Any, Dict

from pusht_policy.checkpoint import provenance_path, read_provenance, sha256_of
from pusht_task.error import Error
from pusht_task.json_file import Json, read_json, require_format, write_json
from sim2sim_protocol.configuration import changed_options
from sim2sim_protocol.result_files import format_of, name_of

# Configuration of a comparison that is an evaluation, besides episodes and seed.
EVALUATED: Dict[str, Any] = {
    "reference_simulator": "mujoco",
    "simulators.reference.changed": [],  # parameters
    "horizon": 300,
    "first_episode": 0,
    "smoke": False,
}


def record_evaluation(checkpoint: Path, results: Path) -> None:
    """Fills `evaluation` in the provenance of a checkpoint from the results of a comparison.

    Raises Error for figures of another policy, simulator or protocol.
    """
    provenance = read_provenance(checkpoint)
    found = sha256_of(checkpoint)
    _require(provenance_path(checkpoint), provenance, "checkpoint.sha256", found)
    configuration = _evaluated_configuration(results / name_of("provenance"), found)
    path = results / name_of("metrics")
    metrics = read_json(path)
    require_format(path, metrics, format_of("metrics"))
    for name, value in configuration.items():
        _require(path, metrics, name, value)
    episodes = _value(path, metrics, "episodes")
    successes = _value(path, metrics, "mj_successes")
    rate = _value(path, metrics, "mj_success_rate")
    if not (0 <= successes <= episodes and rate == round(successes / episodes, 6)):
        raise Error(
            f"{path}: mj_success_rate is {rate}; it must be mj_successes ({successes}) over "
            f"episodes ({episodes})"
        )
    origin = read_json(results / name_of("provenance"))
    version = _value(results / name_of("provenance"), origin, "reference.version")
    provenance["evaluation"] = {
        "simulator": f"MuJoCo {version}",
        "episodes": episodes,
        "seed": _value(path, metrics, "seed"),
        "success_rate": rate,
        "successes": successes,
    }
    write_json(provenance_path(checkpoint), provenance)


def _evaluated_configuration(path: Path, checkpoint_sha256: str) -> Json:
    """The configuration of a comparison. Raises Error if it is none of an evaluation."""
    origin = read_json(path)
    _require(path, origin, "policy.sha256", checkpoint_sha256)
    for name, value in EVALUATED.items():
        _require(path, origin, f"configuration.{name}", value)
    configuration: Json = origin["configuration"]
    changed = changed_options(configuration)
    if changed:
        named = ", ".join(f"configuration.{name} is {value}" for name, value in changed.items())
        raise Error(f"{path}: {named}; there must be none")
    return configuration


def _value(path: Path, content: Any, key: str) -> Any:
    """The value under "a.b" in the content of a JSON file."""
    for name in key.split("."):
        if not isinstance(content, dict) or name not in content:
            raise Error(f"{path}: no key {key}; it is needed")
        content = content[name]
    return content


def _require(path: Path, content: Any, key: str, expected: Any) -> None:
    """Raises Error unless the value under `key` is as expected."""
    found = _value(path, content, key)
    if found != expected:
        raise Error(f"{path}: {key} is {found}; it must be {expected}")
