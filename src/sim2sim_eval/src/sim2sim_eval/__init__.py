# SPDX-License-Identifier: BSD-3-Clause
"""What looks at results: it reads the files of runs and computes no statistics of its own."""
