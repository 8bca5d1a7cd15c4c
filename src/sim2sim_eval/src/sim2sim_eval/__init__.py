# SPDX-License-Identifier: BSD-3-Clause
"""Calls of the suite's commands, and records of their results."""
