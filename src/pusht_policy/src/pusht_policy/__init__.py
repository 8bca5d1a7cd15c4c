# SPDX-License-Identifier: BSD-3-Clause
"""Behavior cloning of a PushT policy from recorded demonstrations."""
