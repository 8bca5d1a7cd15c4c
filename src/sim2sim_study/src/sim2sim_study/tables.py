# SPDX-License-Identifier: BSD-3-Clause
"""Tables of figures as CSV, and by their keys as JSON."""

import csv
import io
import json
import math
from pathlib import Path
from typing import Any, Dict, Sequence

from pusht_task.files import write_file

Row = Dict[str, Any]


def write_table(path: Path, rows: Sequence[Row]) -> None:
    """Writes rows as CSV; the keys of the first are the columns."""
    text = io.StringIO()
    writer = csv.DictWriter(text, rows[0].keys() if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_file(path, text.getvalue().encode())


def write_figures(path: Path, figures: Row) -> None:
    """Writes what docs/claims.yaml reads."""
    write_file(path, (json.dumps(figures, indent=1, sort_keys=True) + "\n").encode())


def nested(rows: Sequence[Row], *keys: str) -> Row:
    """Rows of a table by their keys. An interval stands beside its figure: x_interval of x_low and
    x_high."""
    found: Row = {}
    for row in rows:
        place = found
        for key in keys:
            place = place.setdefault(str(row[key]).replace("/", " "), {})
        for name, value in row.items():
            stem, _, end = name.rpartition("_")
            if name == "high" or end == "high":
                low = row["low" if name == "high" else f"{stem}_low"]
                ends = None if low in ("", None) else [low, value]
                place[f"{stem}_interval" if stem else "interval"] = ends
            elif name not in (*keys, "low") and end != "low":
                is_missing = isinstance(value, float) and math.isnan(value)
                place[name] = None if is_missing else value
    return found
