# SPDX-License-Identifier: BSD-3-Clause
"""The one error of the suite's Python and its exit codes, as in error.hpp.

Imports next to nothing, so that a command obeys it before it loads the libraries that it needs.
"""

from enum import IntEnum

LONGEST_MESSAGE = 2000  # characters


class ExitCode(IntEnum):
    """Meaning of a failure for the caller."""

    OK = 0
    INVALID_INPUT = 2  # bad input or configuration
    BAD_DEPENDENCY = 3  # something the run needs is missing or not as expected
    RUNTIME_FAULT = 4  # a peer died, a deadline passed, the disk is full, the run was interrupted
    CONTRACT_ERROR = 5  # an audit found an error of the contract
    NOT_MET = 6
    UNDECIDED = 7
    INTERNAL_ERROR = 70  # a defect of ours or of a library


class Error(Exception):
    """A failure with its exit code. The message names the thing, its value and the rule."""

    def __init__(self, message: str, exit_code: int = ExitCode.INVALID_INPUT) -> None:
        super().__init__(message)
        self.exit_code = exit_code


def clipped(text: str, longest: int = LONGEST_MESSAGE) -> str:
    """The begin and end of a text longer than `longest` characters, and how many are left out."""
    if len(text) <= longest:
        return text
    half = longest // 2
    left_out = f" ... ({len(text) - 2 * half} characters left out) ... "
    return text[:half] + left_out + text[-half:]
