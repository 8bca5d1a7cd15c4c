# SPDX-License-Identifier: BSD-3-Clause
"""Serves a plain Python object as a simulator or a policy."""
