# SPDX-License-Identifier: BSD-3-Clause
"""Worlds of PushT, comparisons of simulators, and what the other commands do, in process."""

from sim2sim import statistics
from sim2sim._sim2sim import FIRST_SPAWN_SEED, HORIZON, STATE_FIELDS, kinds
from sim2sim.commands import contrast, matrix, plan, report, sweep
from sim2sim.comparison import compare
from sim2sim.errors import (
    BadDependency,
    ContractError,
    Error,
    InternalError,
    InvalidInput,
    RequirementNotMet,
    RequirementUndecided,
    RuntimeFault,
    SimulationFault,
)
from sim2sim.gym import Box
from sim2sim.policy import Policy, load_policy
from sim2sim.policy_audit import PolicyAudit, audit_policy
from sim2sim.results import Comparison, Findings, Sweep, load
from sim2sim.simulator import Worlds, worlds
from sim2sim.world import VectorWorld, World, make, make_vec, parameters

__all__ = [
    "FIRST_SPAWN_SEED",
    "HORIZON",
    "STATE_FIELDS",
    "BadDependency",
    "Box",
    "Comparison",
    "ContractError",
    "Error",
    "Findings",
    "InternalError",
    "InvalidInput",
    "Policy",
    "PolicyAudit",
    "RequirementNotMet",
    "RequirementUndecided",
    "RuntimeFault",
    "SimulationFault",
    "Sweep",
    "VectorWorld",
    "World",
    "Worlds",
    "audit_policy",
    "compare",
    "contrast",
    "kinds",
    "load",
    "load_policy",
    "make",
    "make_vec",
    "matrix",
    "parameters",
    "plan",
    "report",
    "statistics",
    "sweep",
    "worlds",
]
