# SPDX-License-Identifier: BSD-3-Clause
"""Names and formats of the files of results, from the table that the library in C++ has too."""

import json
from pathlib import Path

__all__ = ["format_of", "name_of", "row_folder"]

_TABLE = {
    row["key"]: row
    for row in json.loads(Path(__file__).with_name("result_files.json").read_text("utf-8"))
}


def name_of(key: str) -> str:
    """Name of a file in its folder."""
    return str(_TABLE[key]["name"])


def format_of(key: str) -> int:
    """Number of a file's format, as its content says it."""
    return int(_TABLE[key]["format"])


def row_folder(sweep: Path, row: int) -> Path:
    """Folder of a row of a sweep; rowFolder() in C++."""
    return sweep / "rows" / f"{row:03d}"
