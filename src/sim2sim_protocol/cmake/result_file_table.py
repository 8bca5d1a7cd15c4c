#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints the rows of result_files.json for result_file_table.hpp.in."""

import json
import sys
from pathlib import Path

for row in json.loads(Path(sys.argv[1]).read_text("utf-8")):
    streamed = "true" if row.get("streamed") else "false"
    texts = ", ".join(json.dumps(row[key]) for key in ("key", "name", "in"))
    print(f"    {{{texts}, {row.get('format', 0)}, {streamed}}},")
