# SPDX-License-Identifier: BSD-3-Clause
"""Worlds of PushT and comparisons of simulators, in process."""

from sim2sim._sim2sim import FIRST_SPAWN_SEED, HORIZON, STATE_FIELDS, kinds
from sim2sim.comparison import Comparison, compare
from sim2sim.errors import (
    BadDependency,
    ContractError,
    Error,
    InternalError,
    InvalidInput,
    RuntimeFault,
    SimulationFault,
)
from sim2sim.policy import Policy, load_policy
from sim2sim.policy_audit import PolicyAudit, audit_policy
from sim2sim.worlds import Box, VectorWorld, World, make, make_vec, parameters

__all__ = [
    "FIRST_SPAWN_SEED",
    "HORIZON",
    "STATE_FIELDS",
    "BadDependency",
    "Box",
    "Comparison",
    "ContractError",
    "Error",
    "InternalError",
    "InvalidInput",
    "Policy",
    "PolicyAudit",
    "RuntimeFault",
    "SimulationFault",
    "VectorWorld",
    "World",
    "audit_policy",
    "compare",
    "kinds",
    "load_policy",
    "make",
    "make_vec",
    "parameters",
]
