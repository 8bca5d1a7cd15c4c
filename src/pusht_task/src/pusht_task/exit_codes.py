# SPDX-License-Identifier: BSD-3-Clause
"""What commands and replies end with, as in pusht_task/error.hpp. Imports next to nothing."""

from enum import IntEnum


class ExitCode(IntEnum):
    OK = 0
    INVALID_INPUT = 2  # bad input or configuration
    BAD_DEPENDENCY = 3  # something the run needs is missing or not as expected
    RUNTIME_FAULT = 4  # a peer died, a deadline passed, the disk is full, the run was interrupted
    INTERNAL_ERROR = 70  # a defect of ours or of a library
