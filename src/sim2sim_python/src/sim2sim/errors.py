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


class InternalError(Error):
    """Defect of the suite or of a library."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.INTERNAL_ERROR)


def of_exit_code(exit_code: int, message: str) -> Error:
    """The error of a command that ended with this code."""
    kinds = (InvalidInput, BadDependency, RuntimeFault, ContractError)
    for kind in kinds:
        error: Error = kind(message)
        if error.exit_code == exit_code:
            return error
    return InternalError(message)
