# SPDX-License-Identifier: BSD-3-Clause
"""PushT in Python: the task, and the rules of commands."""
