# SPDX-License-Identifier: BSD-3-Clause
"""Errors of the suite as exceptions: one class for each kind of error.hpp, with the same words."""

from pusht_task.error import Error, ExitCode

__all__ = [
    "BadDependency",
    "ContractError",
    "Error",
    "ExitCode",
    "InternalError",
    "InvalidInput",
    "RequirementNotMet",
    "RequirementUndecided",
    "RuntimeFault",
    "SimulationFault",
]


class _Kind(Error):
    """Error whose class tells its exit code."""

    code: ExitCode

    def __init__(self, message: str) -> None:
        super().__init__(message, self.code)


class InvalidInput(_Kind):
    """Bad input or configuration."""

    code = ExitCode.INVALID_INPUT


class BadDependency(_Kind):
    """Something that the run needs is missing or not as expected: a policy's answer, say."""

    code = ExitCode.BAD_DEPENDENCY


class RuntimeFault(_Kind):
    """Fault while running."""

    code = ExitCode.RUNTIME_FAULT


class SimulationFault(RuntimeFault):
    """Failure of a world's physics; other parameters may succeed."""


class ContractError(_Kind):
    """Broken contract of a simulator."""

    code = ExitCode.CONTRACT_ERROR


class RequirementNotMet(_Kind):
    """Requirement that is shown not to be met."""

    code = ExitCode.NOT_MET


class RequirementUndecided(_Kind):
    """Requirement of which the episodes cannot say whether it is met."""

    code = ExitCode.UNDECIDED


class InternalError(_Kind):
    """Defect of the suite or of a library."""

    code = ExitCode.INTERNAL_ERROR


def of_exit_code(exit_code: int, message: str) -> Error:
    """The error of a command that ended with this code."""
    kinds = {int(kind.code): kind for kind in _Kind.__subclasses__()}
    return kinds.get(exit_code, InternalError)(message)
