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


class InvalidInput(Error):
    """Bad input or configuration."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.INVALID_INPUT)


class BadDependency(Error):
    """Something that the run needs is missing or not as expected: a policy's answer, say."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.BAD_DEPENDENCY)


class RuntimeFault(Error):
    """Fault while running."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.RUNTIME_FAULT)


class SimulationFault(RuntimeFault):
    """Failure of a world's physics; other parameters may succeed."""


class ContractError(Error):
    """Broken contract of a simulator."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.CONTRACT_ERROR)


class RequirementNotMet(Error):
    """Requirement that is shown not to be met."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.NOT_MET)


class RequirementUndecided(Error):
    """Requirement of which the episodes cannot say whether it is met."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.UNDECIDED)


class InternalError(Error):
    """Defect of the suite or of a library."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.INTERNAL_ERROR)


def of_exit_code(exit_code: int, message: str) -> Error:
    """The error of a command that ended with this code."""
    kinds = (
        InvalidInput,
        BadDependency,
        RuntimeFault,
        ContractError,
        RequirementNotMet,
        RequirementUndecided,
    )
    for kind in kinds:
        error: Error = kind(message)
        if error.exit_code == exit_code:
            return error
    return InternalError(message)
