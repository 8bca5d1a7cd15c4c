# SPDX-License-Identifier: BSD-3-Clause
"""PushT in Python: the task, and what serves a plain object as a simulator or a policy."""
