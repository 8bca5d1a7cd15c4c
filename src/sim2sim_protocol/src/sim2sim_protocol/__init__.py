# SPDX-License-Identifier: BSD-3-Clause
"""Results of runs, as files."""
