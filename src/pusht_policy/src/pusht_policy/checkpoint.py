# SPDX-License-Identifier: BSD-3-Clause
"""A checkpoint and its provenance, the file beside it that says where it comes from."""

import hashlib
from pathlib import Path

from pusht_policy.formats import PROVENANCE_FORMAT
from pusht_task.error import Error
from pusht_task.files import read_file
from pusht_task.json_file import Json, read_json, require_format

ARCHIVE_MARK = b"PK\x03\x04"  # at the beginning of a TorchScript archive


def provenance_path(checkpoint: Path) -> Path:
    """The file with the provenance of a checkpoint: beside it."""
    return checkpoint.with_name(checkpoint.name + ".provenance.json")


def read_provenance(checkpoint: Path) -> Json:
    """The provenance of a checkpoint. Raises Error for that of another version of the suite."""
    path = provenance_path(checkpoint)
    provenance = read_json(path)
    numbered = {"format": 1, **provenance}  # the first format had no number
    require_format(path, numbered, PROVENANCE_FORMAT)
    return provenance


def sha256_of(path: Path) -> str:
    """Hexadecimal SHA-256 of a file."""
    try:
        return hashlib.sha256(read_file(path)).hexdigest()
    except FileNotFoundError:
        raise Error(f"{path}: no such file; it must exist") from None
