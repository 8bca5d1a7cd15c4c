#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The table of defects: each can be planted, and its tests are there. script/mutants plants all."""

import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "src" / "sim2sim_eval" / "benchmark"))
import mutant_table as table  # noqa: E402
import mutants  # noqa: E402
from pusht_task.error import Error  # noqa: E402

DEFECTS = table.read()


class Table(unittest.TestCase):
    def test_every_defect_has_one_place_and_changes_it(self) -> None:
        self.assertEqual(len({defect.id for defect in DEFECTS}), len(DEFECTS))
        for defect in DEFECTS:
            text = (ROOT / defect.file).read_text("utf-8")
            self.assertNotEqual(defect.in_text(text), text, defect.id)

    def test_every_test_is_there(self) -> None:
        for name in table.tests_of(DEFECTS):
            table.test_named(name, ROOT)

    def test_every_package_has_defects(self) -> None:
        packages = {path.parent.name for path in ROOT.glob("src/*/package.xml")} - {"pusht_msgs"}
        self.assertEqual({Path(defect.file).parts[1] for defect in DEFECTS}, packages)

    def test_shards_are_all(self) -> None:
        shards = [table.chosen(DEFECTS, [], (number, 3)) for number in (1, 2, 3)]
        self.assertEqual({d.id for shard in shards for d in shard}, {d.id for d in DEFECTS})
        self.assertEqual(sum(map(len, shards)), len(DEFECTS))


# A package whose test passes if the sum is one, fails if it is a difference, and may have no end.
TOY = {
    ".gitignore": "/build/\n/devel/\n",
    "build/nothing": "",
    "devel/setup.bash": "",
    "devel/lib/pusht_toy/toy_test": """#!/bin/sh
        file=$(dirname "$0")/../../../src/pusht_toy/a.cpp
        grep -q loop "$file" && sleep 60
        grep -q + "$file"
    """,
    "script/build": """#!/bin/sh
        echo "$@" >> targets
        ! grep -q nonsense "$(dirname "$0")/../src/pusht_toy/a.cpp"
    """,
    "src/pusht_toy/CMakeLists.txt": "pusht_add_gtest(toy_test test/toy_test.cpp)",
    "src/pusht_toy/a.cpp": "1 + 2",
}


class Trees(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name, "tree")
        self.out = Path(folder.name, "out.json")
        self.log = Path(folder.name, "out.log")
        for name, text in TOY.items():
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_text(text)
            (self.root / name).chmod(0o755)
        author = ["-c", "user.name=A", "-c", "user.email=a@example.org"]
        for command in (["init", "-q"], ["add", "."], [*author, "commit", "-q", "-m", "A"]):
            subprocess.run(["git", "-C", str(self.root), *command], check=True)
        self.file = self.root / "src" / "pusht_toy" / "a.cpp"

    @staticmethod
    def defect(name: str, new: str) -> table.Defect:
        return table.Defect(name, "src/pusht_toy/a.cpp", "+", new, "the sum is wrong", ["toy_test"])

    def test_each_defect_is_found_by_what_fails(self) -> None:
        tree = mutants.Tree(self.root, self.log)
        record = mutants.Record(self.out, tree.commit)
        self.assertTrue(tree.build())
        self.assertEqual(mutants.run_control(tree, record, ["toy_test"]), [])
        defects = [self.defect("sign", "-"), self.defect("none", "+ 0 +")]
        defects += [self.defect("nonsense", "nonsense"), self.defect("loop", "loop")]
        with mock.patch.multiple(mutants, LEAST_LIMIT=2):
            self.assertEqual(mutants.run_defects(tree, record, defects), ["none"])
        found = {name: row["found_by"] for name, row in record.defects.items()}
        expected = {"sign": "toy_test", "none": "", "nonsense": "the compiler", "loop": "toy_test"}
        self.assertEqual(found, expected)
        self.assertEqual(self.file.read_text(), "1 + 2")
        # What was built with a defect is built again: with the next one, or alone.
        self.assertEqual(
            (self.root / "build" / "targets").read_text().split("\n")[1:3], ["toy_test"] * 2
        )
        again = mutants.Record(self.out, tree.commit)
        self.assertEqual(again.defects, record.defects)

    def test_refused(self) -> None:
        with self.assertRaisesRegex(Error, "is the source tree of this script"):
            mutants.Tree(ROOT, self.log)
        with self.assertRaisesRegex(Error, "must be a clone that is built"):
            mutants.Tree(self.root / "src", self.log)
        self.file.write_text("1 - 2")
        with self.assertRaisesRegex(Error, r"has changes \(src/pusht_toy/a.cpp\)"):
            mutants.Tree(self.root, self.log)

    def test_a_defect_is_taken_out_whatever_happens(self) -> None:
        tree = mutants.Tree(self.root, self.log)
        with self.assertRaises(KeyboardInterrupt):
            with tree.with_defect(self.defect("sign", "-")):
                self.assertEqual(self.file.read_text(), "1 - 2")
                raise KeyboardInterrupt
        self.assertEqual(self.file.read_text(), "1 + 2")
        with self.assertRaisesRegex(Error, "defect sign: '[+]' is 2 times"):
            self.defect("sign", "-").in_text("1 + 1 + 1")

    def test_nothing_counts_without_a_control(self) -> None:
        record = mutants.Record(self.out, "abc")
        with self.assertRaisesRegex(Error, "run --control first"):
            record.limit("task_test")
        record.keep(record.control, "task_test", time.monotonic() - 2.0, passes=True)
        again = mutants.Record(self.out, "abc")
        self.assertEqual(again.limit("task_test"), 70.0)
        with self.assertRaisesRegex(Error, "is of another commit"):
            mutants.Record(self.out, "abd")


if __name__ == "__main__":
    unittest.main()
