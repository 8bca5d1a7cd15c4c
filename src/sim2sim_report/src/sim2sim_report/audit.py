# SPDX-License-Identifier: BSD-3-Clause
"""The audit of a run's simulators, as `audit` has written it, for the page of the run."""

from pathlib import Path
from typing import Any, List, Optional

from pusht_task.error import Error
from pusht_task.json_file import Json, read_json, require_format
from sim2sim_protocol.result_files import format_of, name_of

__all__ = ["caution", "section"]

DIGITS = 4  # that count, as in the command's own text
ROLES = ("reference", "engine")
SAME, DIFFERS, UNKNOWN = VERDICTS = ("same", "differs", "cannot tell")


def section(folder: Path, simulators: Json) -> Optional[Json]:
    """What audit.json in the folder of a run says; None without one.

    Refuses a file that is not as this version writes it, and the audit of another pair than
    `simulators`, those of the run.
    """
    path = folder / name_of("audit")
    if not path.exists():
        return None
    audit = read_json(path)
    require_format(path, audit, format_of("audit"))
    try:
        _require_pair(path, audit["simulators"], simulators)
        return _section(audit)
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        raise Error(f"{path}: is not as this version writes it: {error!r}") from None


def caution(audit: Optional[Json]) -> List[str]:
    """What a broken contract means for the figures of the run."""
    if audit is None or audit["holds"]:
        return []
    return [
        f"The audit says that the contract is broken ({audit['broken']}). Every figure here was "
        "measured through it: mend that first."
    ]


def _require_pair(path: Path, audited: Json, run: Json) -> None:
    def identity(simulator: Optional[Json]) -> Any:
        return simulator and (simulator["name"], simulator["parameters"])

    if any(identity(audited[role]) != identity(run[role]) for role in ROLES):
        raise Error(
            f"{path}: is of {_pair(audited)}: must be of the run's {_pair(run)}; audit that pair "
            "into this file, or move it"
        )


def _pair(simulators: Json) -> str:
    """Both simulators: "two_mass with block_damp 20.0 against mujoco"."""

    def name(simulator: Optional[Json]) -> str:
        if simulator is None:
            return "the task"
        parameters = simulator["parameters"]
        changed = ", ".join(f"{key} {parameters[key]}" for key in simulator["changed"])
        return " with ".join(filter(None, [str(simulator["name"]), changed]))

    return f"{name(simulators['engine'])} against {name(simulators['reference'])}"


def _section(audit: Json) -> Json:
    by_key = {found["property"]: found for found in audit["properties"]}
    findings = [by_key[key] for key in audit["findings"]]
    counts = {verdict: 0 for verdict in VERDICTS}
    for found in audit["properties"]:
        counts[found["verdict"]] += 1
    broken = [str(finding["title"]) for finding in findings if _is_error(finding)]
    if audit["contract_holds"] != (not broken):
        raise ValueError("contract_holds does not fit the findings")
    divergence = audit["divergence_after_5_steps_m"]
    return {
        "holds": not broken,
        "broken": "; ".join(broken),
        "errors": len(broken),
        "same": counts[SAME],
        "differ": counts[DIFFERS],
        "unknown": counts[UNKNOWN],
        "divergence": None if divergence is None else f"{1e3 * divergence:.3g} mm",
        "findings": [_finding(finding) for finding in findings],
        "properties": [_property(found) for found in audit["properties"]],
        "seed": int(audit["seed"]),
    }


def _is_error(finding: Json) -> bool:
    """Whether it breaks the contract: what a kind declares that it does on purpose does not."""
    return bool(finding["contract"]) and not finding["declared"]


def _finding(finding: Json) -> Json:
    kind = "contract" if finding["contract"] else "physics"
    return {
        **_property(finding),
        "label": f"{kind}, declared" if finding["declared"] else kind,
        "is_error": _is_error(finding),
        "cause": str(finding["cause"]),
        "effect": f"{1e3 * finding['estimated_effect_m']:.2g} mm",
        "look_at": str(finding["look_at"]),
    }


def _property(found: Json) -> Json:
    known = found["verdict"] != UNKNOWN
    unit = str(found["unit"])
    return {
        "title": str(found["title"]),
        "area": str(found["area"]),
        "verdict": str(found["verdict"]),
        "differs": found["verdict"] == DIFFERS,
        "reference": _value(found["reference"], unit),
        "engine": _value(found["engine"], unit),
        "allowed": _value(found["allowed"], unit) if known else "",
        "why": str(found["held_against"] if known else found["reason"]),
    }


def _value(value: Any, unit: str) -> str:
    """A value with its unit; a word stands for infinity, a dash for what is not known."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return " ".join(filter(None, [f"{value:.{DIGITS}g}", unit]))
