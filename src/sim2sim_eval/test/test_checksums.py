#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Bytes of results stay what they are from commit to commit.

data/checksums.json has the SHA-256 of what `compare` writes for some shipped configurations, in a
row for each class of machines with the same bytes: the version of libm, and whether it uses FMA.
On a machine of another class the test is skipped. After a change that is meant to change bytes, or
to add a class:

    /usr/bin/python3 src/sim2sim_eval/test/test_checksums.py --renew
"""

import hashlib
import json
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List

from command_case import CommandCase, executable

TABLE = Path(__file__).resolve().parent / "data" / "checksums.json"
FILES = ("metrics.json", "episodes.csv", "divergence.csv", "traces.npy")
EPISODES = ("--episodes", "6")
CONFIGURATIONS: Dict[str, List[str]] = {
    "default": [*EPISODES, "--floor"],
    "block_damp 2": [*EPISODES, "--block_damp", "2"],
    "block_damp 20": [*EPISODES, "--block_damp", "20"],
    "block_damp 60": [*EPISODES, "--block_damp", "60"],
    "light pusher": [*EPISODES, "--pusher_mass", "1", "--baumgarte", "20"],
    "seed 7": [*EPISODES, "--seed", "7"],
    "smoke": ["--smoke"],
    "chipmunk": [*EPISODES, "--policy", "expert", "--engine", "chipmunk", "--reanchor", "5"],
    "rigid_body": [*EPISODES, "--policy", "expert", "--engine", "rigid_body", "--reanchor", "5"],
}

Row = Dict[str, Dict[str, str]]  # SHA-256 by configuration and file


def rows() -> List[Dict[str, object]]:
    """Each row: `classes` of machines, and `sha256`."""
    loaded: List[Dict[str, object]] = json.loads(TABLE.read_text()) if TABLE.exists() else []
    return loaded


def machine_class(out: Path) -> str:
    """The class of the machine that wrote a folder of results."""
    provenance = json.loads((out / "provenance.json").read_text())
    fma = "FMA" if provenance["code"]["libm_uses_fma"] else "no FMA"
    return f"{provenance['software']['libc']}, {fma}"


def checksums(out: Path) -> Dict[str, str]:
    return {name: hashlib.sha256((out / name).read_bytes()).hexdigest() for name in FILES}


def differences(found: Row, expected: Row) -> List[str]:
    """What differs, as "configuration: file", in both directions."""
    pairs = {(c, f) for row in (found, expected) for c, files in row.items() for f in files}
    return sorted(
        f"{configuration}: {file}"
        for configuration, file in pairs
        if found.get(configuration, {}).get(file) != expected.get(configuration, {}).get(file)
    )


class Checksums(CommandCase):
    def run_configuration(self, name: str) -> Path:
        """The folder of results."""
        arguments = CONFIGURATIONS[name]
        command = (executable("sim2sim_eval", "compare"), *arguments, "--traces", "--out", name)
        process = self.run_command(*command)
        self.assertEqual(process.returncode, 0, process.stderr)
        return self.folder / name

    def test_results_have_the_bytes_of_the_table(self) -> None:
        found = {}
        for name in CONFIGURATIONS:
            out = self.run_configuration(name)
            found[name] = checksums(out)
        ours = machine_class(out)
        for row in rows():
            if ours in row["classes"]:  # type: ignore[operator]
                self.assertEqual(differences(found, row["sha256"]), [])  # type: ignore[arg-type]
                return
        known = [name for row in rows() for name in row["classes"]]  # type: ignore[attr-defined]
        self.skipTest(f"no checksums for {ours}; there are some for {'; '.join(known)}")

    def test_a_difference_names_configuration_and_file(self) -> None:
        row = {"default": {"metrics.json": "1", "traces.npy": "2"}}
        other = {"default": {"metrics.json": "1", "traces.npy": "3"}, "seed 7": {"traces.npy": "4"}}
        self.assertEqual(differences(row, other), ["default: traces.npy", "seed 7: traces.npy"])
        self.assertEqual(differences(row, row), [])


def renew() -> None:
    """Writes this machine's checksums into the table."""
    found = {}
    case = Checksums()
    with tempfile.TemporaryDirectory() as folder:
        case.folder = Path(folder)
        for name in CONFIGURATIONS:
            out = case.run_configuration(name)
            found[name] = checksums(out)
        ours = machine_class(out)
    kept = []
    for row in rows():
        classes = [name for name in row["classes"] if name != ours]  # type: ignore[attr-defined]
        if row["sha256"] == found:
            classes.append(ours)
            ours = ""
        if classes:
            kept.append({"classes": sorted(classes), "sha256": row["sha256"]})
    if ours:
        kept.append({"classes": [ours], "sha256": found})
    TABLE.write_text(json.dumps(kept, indent=2) + "\n")


if __name__ == "__main__":
    if sys.argv[1:] == ["--renew"]:
        renew()
    else:
        unittest.main()
