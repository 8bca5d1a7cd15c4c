# SPDX-License-Identifier: BSD-3-Clause
"""Studies over policies: what is run, judged and tabulated. docs/study has their plans."""
