# SPDX-License-Identifier: BSD-3-Clause
"""Behaviour cloning of a PushT policy from recorded demonstrations."""
