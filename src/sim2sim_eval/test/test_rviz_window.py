#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The views of the configurations of rviz, and how they fill a screen."""

import unittest
from pathlib import Path
from typing import Any, Dict, List
from unittest import mock

import rospkg  # type: ignore[import]
import yaml  # type: ignore[import]

from command_case import load_script

PACKAGES = rospkg.RosPack()
CONFIGURATIONS = {
    name: Path(PACKAGES.get_path(package), "rviz", name).read_text()
    for package, name in (
        ("sim2sim_eval", "compare.rviz"),
        ("pusht_mujoco", "mujoco.rviz"),
        ("pusht_engine", "engine.rviz"),
    )
}
SCREENS = ((1366, 768), (900, 700))  # [px] of an old laptop, and smaller


rviz_window = load_script("rviz_window")


def views(configuration: str) -> List[Dict[str, Any]]:
    """The current one and the saved ones."""
    found = yaml.safe_load(configuration)["Visualization Manager"]["Views"]
    return [found["Current"], *found["Saved"]]


class Configurations(unittest.TestCase):
    def test_every_view_is_from_above_without_perspective(self) -> None:
        for name, configuration in CONFIGURATIONS.items():
            classes = {view["Name"]: view["Class"] for view in views(configuration)}
            self.assertGreater(len(classes), 1, f"{name} has no saved view")
            self.assertEqual(set(classes.values()), {"rviz/TopDownOrtho"}, (name, classes))

    def test_current_view_is_the_first_saved_one(self) -> None:
        for name, configuration in CONFIGURATIONS.items():
            current, first, *_ = views(configuration)
            self.assertEqual({**current, "Name": first["Name"]}, first, name)

    def test_views_of_a_comparison_have_known_sizes(self) -> None:
        names = [view["Name"] for view in views(CONFIGURATIONS["compare.rviz"])]
        self.assertEqual(names, list(rviz_window.VIEWS))


class FillScreen(unittest.TestCase):
    def check(self, width: int, height: int, fullscreen: bool) -> None:
        before = CONFIGURATIONS["compare.rviz"]
        with mock.patch.object(rviz_window, "screen", return_value=(width, height)):
            after = rviz_window.fill_screen(before, fullscreen)
        settings = yaml.safe_load(after)
        window = settings["Window Geometry"]
        self.assertEqual((window["Width"], window["Height"]), (width, height))
        if not fullscreen:
            width -= settings["Panels"][0]["Width"]
        for old, new in zip(views(before), views(after)):
            with self.subTest(new["Name"]):
                shown = [new["Scale"] * meters for meters in rviz_window.VIEWS[new["Name"]]]
                self.assertLessEqual(shown[0], width)
                self.assertLessEqual(shown[1], height)
                used = max(shown[0] / width, shown[1] / height)
                self.assertGreater(used, 0.85, "most of the place is used")
                self.assertEqual({**new, "Scale": old["Scale"]}, old, "nothing else changes")

    def test_views_fit_beside_the_panel(self) -> None:
        for width, height in SCREENS:
            with self.subTest(width=width, height=height):
                self.check(width, height, fullscreen=False)

    def test_views_fill_a_screen_without_a_panel(self) -> None:
        for width, height in SCREENS:
            with self.subTest(width=width, height=height):
                self.check(width, height, fullscreen=True)


if __name__ == "__main__":
    unittest.main()
