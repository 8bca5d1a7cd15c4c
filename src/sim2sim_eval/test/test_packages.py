#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What packages say of themselves: versions, changelogs, dependencies."""

import re
import unittest
from pathlib import Path
from typing import Dict, Iterator, List, Set, Tuple
from xml.etree import ElementTree

import rospkg  # type: ignore[import]
from pusht_task.command import SIGNALS

ROOT = Path(__file__).resolve().parents[3]
MANIFESTS = {
    path.parent.name: ElementTree.parse(path).getroot() for path in ROOT.glob("src/*/package.xml")
}
# The names of rosdep that are not the names of Debian's packages.
ROSDEP = {"eigen": "libeigen3-dev", "yaml-cpp": "libyaml-cpp-dev"}
# What sources name is of a ROS package of the same name, or of these, by the names of rosdep.
OF_INCLUDES = {
    **{"Eigen": "eigen", "boost": "libboost-dev", "ccd": "libccd-dev", "CLI": "libcli11-dev"},
    **{"LinearMath": "libbullet-dev", "btBulletDynamicsCommon.h": "libbullet-dev"},
    **{"box2d": "libbox2d-dev", "chipmunk": "libchipmunk-dev", "gsl": "libmsgsl-dev"},
    **{"mujoco": "libmujoco-dev"},
    **{"nlohmann": "nlohmann-json3-dev", "openssl": "libssl-dev", "yaml-cpp": "yaml-cpp"},
    **{"torch": "libtorch-dev", "ATen": "libtorch-dev", "caffe2": "libtorch-dev"},
    **{"benchmark": "libbenchmark-dev", "gmock": "libgmock-dev", "gtest": "libgtest-dev"},
    **{"ros": "roscpp", "rosbag": "rosbag_storage", "qcustomplot.h": "libqcustomplot-dev"},
    **{"tinyxml2.h": "libtinyxml2-dev", "pybind11": "pybind11-dev"},
    **{"onnx": "libonnx-dev", "google": "libprotobuf-dev"},
}
OF_CMAKE = {
    **{"benchmark": "libbenchmark-dev", "Boost": "libboost-dev", "ccd": "libccd-dev"},
    **{"box2d": "libbox2d-dev"},
    **{"CLI11": "libcli11-dev", "Eigen3": "eigen", "Microsoft.GSL": "libmsgsl-dev"},
    **{"mujoco": "libmujoco-dev", "nlohmann_json": "nlohmann-json3-dev", "OpenSSL": "libssl-dev"},
    **{"PkgConfig": "pkg-config", "Qt": "qtbase5-dev", "Torch": "libtorch-dev"},
    **{"pybind11": "pybind11-dev", "Python3": "python3-dev"},
    **{"tinyxml2": "libtinyxml2-dev"},
    **{"ONNX": "libonnx-dev", "Protobuf": "libprotobuf-dev"},
    **{"GTest": "libgtest-dev", "yaml-cpp": "yaml-cpp"},
    **{"Threads": "", "catkin": ""},  # these come with every build
}
OF_PYTHON = ("cryptography", "distributed", "jinja2", "matplotlib", "numpy", "rospkg", "scipy")
OF_IMPORTS = {name: f"python3-{name}" for name in (*OF_PYTHON, "onnx", "selenium", "torch", "yaml")}


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
            ROSDEP.get(name, name) for root in MANIFESTS.values() for name in dependencies(root)
        }
        of_debian = {name for name in needed if re.fullmatch(r"lib.*-dev|python3-.*|.*-dev", name)}
        self.assertGreater(len(of_debian), 20)
        self.assertEqual(of_debian - installed, set())

    def test_the_picture_of_the_packages_has_all_and_each_uses_those_below(self) -> None:
        page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
        (text,) = re.findall(r"!\[(Each package uses .*?)\]\(house\.svg\)", page)
        name = r"\b(?:pusht|sim2sim)_\w+"
        layers = [re.findall(name, layer) for layer in text.split(";")]
        layer_of = {package: n for n, layer in enumerate(layers) for package in layer}
        picture = (ROOT / "docs" / "house.svg").read_text(encoding="utf-8")
        self.assertEqual(sorted(MANIFESTS), sorted(re.findall(f">({name})<", picture)))
        self.assertEqual(sorted(MANIFESTS), sorted(re.findall(name, text)))
        for package, root in MANIFESTS.items():
            for entry in root.iter():
                if entry.tag.endswith("depend") and entry.tag != "test_depend":
                    below = layer_of.get(str(entry.text), len(layers))
                    self.assertGreater(below, layer_of[package], f"{package}: {entry.text}")

    def test_commands_in_both_languages_end_at_the_same_signals(self) -> None:
        header = ROOT / "src/pusht_task/include/pusht_task/ending_signals.hpp"
        listed = re.search(r"kEndingSignals\{(.*)\}", header.read_text())
        assert listed
        self.assertEqual(listed[1].split(", "), [number.name for number in SIGNALS])

    def test_nodes_begin_without_parameters_of_an_earlier_launch(self) -> None:
        files = list((ROOT / "src").glob("*/launch/*.launch"))
        nodes = [(file.name, *node) for file in files for node in nodes_of(file)]
        self.assertGreater(len(nodes), 10)
        for file, kind, cleared in nodes:
            if not kind.startswith("rviz"):
                self.assertEqual(cleared, "true", f"{file}: {kind}")

    def test_what_sources_use_is_a_dependency(self) -> None:
        """By name, and not only by way of another package: so rosdep installs what is needed."""
        for name, root in MANIFESTS.items():
            declared = dependencies(root)
            used = list(uses_of(name))
            self.assertGreater(len(used), 1, name)
            for file, need in used:
                if need not in (name, ""):
                    with self.subTest(f"{file.relative_to(ROOT)}: {need}"):
                        self.assertIn(need, declared)


def dependencies(manifest: ElementTree.Element) -> Set[str]:
    return {str(entry.text) for entry in manifest if re.fullmatch(r"(\w+_)?depend", entry.tag)}


def nodes_of(launch_file: Path) -> Iterator[Tuple[str, str]]:
    """Type of each node in a launch file, and whether it begins without parameters of others."""
    for node in ElementTree.parse(launch_file).iter("node"):
        yield node.attrib["type"], node.attrib.get("clear_params", "false")


def uses_of(package: str) -> Iterator[Tuple[Path, str]]:
    """What each file of a package uses, by the names of rosdep."""
    of_ros = {name: name for name in rospkg.RosPack().list()}
    for file in sorted((ROOT / "src" / package).rglob("*")):
        if not file.is_file() or file.suffix in (".png", ".pt", ".bag"):
            continue
        text = file.read_text(encoding="utf-8", errors="replace")
        names: List[str] = []
        known = of_ros
        if file.suffix in (".cpp", ".hpp"):
            names = re.findall(r'^\s*#include [<"]([^/">]+)[^">]*[">]', text, re.M)
            known = {**of_ros, **OF_INCLUDES}
        elif file.suffix == ".py" or text.startswith("#!/usr/bin/env python3"):
            names = re.findall(r"^\s*(?:from|import) (\w+)", text, re.M)
            known = {**of_ros, **OF_IMPORTS}
        elif file.suffix in (".launch", ".test"):
            names = re.findall(r'(?<=pkg=")\w+|(?<=\$\(find )\w+', text)
        elif file.name == "CMakeLists.txt":
            text = re.sub(r"#.*", "", text)
            found = re.findall(r"find_package\(([\w.-]+)", text)
            components = re.findall(r"find_package\(catkin[^)]* COMPONENTS([^)]*)\)", text)
            for name in [*found, *" ".join(components).split()]:
                yield file, {**OF_CMAKE, **of_ros}[name]
        yield from ((file, known[name]) for name in names if name in known)


if __name__ == "__main__":
    unittest.main()
