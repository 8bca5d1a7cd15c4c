#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What packages say of themselves: versions, changelogs, the Debian packages that they need."""

import re
import unittest
from pathlib import Path
from typing import Dict
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[3]
MANIFESTS = {
    path.parent.name: ElementTree.parse(path).getroot() for path in ROOT.glob("src/*/package.xml")
}
# The names of rosdep that are not the names of Debian's packages.
ROSDEP = {"eigen": "libeigen3-dev", "yaml-cpp": "libyaml-cpp-dev"}


def versions() -> Dict[str, str]:
    return {name: str(root.findtext("version")) for name, root in MANIFESTS.items()}


class Packages(unittest.TestCase):
    def test_each_is_in_its_own_folder(self) -> None:
        self.assertEqual(
            len(MANIFESTS), len([path for path in ROOT.glob("src/*/") if path.is_dir()])
        )
        for folder, root in MANIFESTS.items():
            self.assertEqual(root.findtext("name"), folder)

    def test_versions_are_equal(self) -> None:
        self.assertEqual(len(set(versions().values())), 1, versions())

    def test_changelogs_are_of_one_release(self) -> None:
        """All have something to come, or all have the version, with one date."""
        first = {
            (ROOT / "src" / name / "CHANGELOG.rst").read_text().splitlines()[4]
            for name in MANIFESTS
        }
        self.assertEqual(len(first), 1, first)
        date = re.search(r"\d{4}-\d\d-\d\d", first.pop())
        common = re.search(r"^## .*$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
        assert common
        self.assertIn(date[0] if date else "[Unreleased]", common[0])

    def test_changelogs_begin_with_the_version_or_with_what_is_to_come(self) -> None:
        version = versions()["sim2sim_eval"]
        for name in MANIFESTS:
            with self.subTest(name):
                lines = (ROOT / "src" / name / "CHANGELOG.rst").read_text().splitlines()
                title = f"Changelog for package {name}"
                rule = "^" * len(title)
                self.assertEqual(lines[:4], [rule, title, rule, ""])
                self.assertRegex(
                    lines[4], rf"^(Forthcoming|{re.escape(version)} \(\d{{4}}-\d\d-\d\d\))$"
                )
                self.assertEqual(lines[5], "-" * len(lines[4]))

    def test_the_common_changelog_has_the_version_too(self) -> None:
        """Where nothing is to come, its newest section is that of the version."""
        sections = re.findall(r"^## \[(.+?)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
        self.assertIn(sections[0], ("Unreleased", versions()["sim2sim_eval"]))

    def test_what_a_package_needs_of_debian_is_installed_by_setup(self) -> None:
        installed = {
            line.split("#")[0].strip()
            for line in (ROOT / "dependencies.txt").read_text().splitlines()
        }
        needed = {
            ROSDEP.get(str(entry.text), str(entry.text))
            for root in MANIFESTS.values()
            for entry in root
            if re.fullmatch(r"(\w+_)?depend", entry.tag)
        }
        of_debian = {name for name in needed if re.fullmatch(r"lib.*-dev|python3-.*|.*-dev", name)}
        self.assertGreater(len(of_debian), 20)
        self.assertEqual(of_debian - installed, set())


if __name__ == "__main__":
    unittest.main()
