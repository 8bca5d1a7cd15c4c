#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs what the docs say, and compares with the output that they show.

In a `console` block a line after `$ ` is a command, and the lines below it are what it prints; if
it fails, all that it complains of. A line `...` stands for any lines, `...` at a line's end for
any rest. A block whose first line is a comment with a file name is that file. What is called by
hand is called of nodes. And what docs name is there.
"""

import re
import unittest
from pathlib import Path
from typing import Iterator, List, Tuple

import rospkg  # type: ignore[import]

from command_case import CommandCase, executable
from live_support import LiveCase, Process, free_port

PACKAGES = Path(rospkg.RosPack().get_path("sim2sim_eval")).parent
DOCS = PACKAGES.parent / "docs"
KNOB = ("falls", "falls", "no-difference")  # as in the solutions
LAUNCH_DEADLINE = 180  # [s] a live run of a few episodes on a busy machine
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# ([\w.]+)\n")


def pattern_of(lines: List[str]) -> str:
    """A regular expression for the output."""
    pattern = ""
    for line in lines:
        if line == "...":
            pattern += r"(?:.*\n)*?"
        else:
            rest = line.endswith("...")
            pattern += re.escape(line[:-3] if rest else line) + (r".*\n" if rest else r" *\n")
    return pattern


def commands(block: str) -> Iterator[Tuple[str, List[str]]]:
    for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        command, *output = part.splitlines()
        yield command, output


class Docs(CommandCase):
    def check(self, text: Path) -> int:
        """How many commands were run, in one folder, one after the other."""
        count = 0
        for language, block in BLOCK.findall(text.read_text(encoding="utf-8")):
            file = FILE.match(block)
            if file:
                (self.folder / file[1]).write_text(block)
            if language != "console":
                continue
            for command, output in commands(block):
                with self.subTest(command):
                    process = self.run_command("bash", "-c", command)
                    count += 1
                    if process.returncode != 0:  # as shown, word for word
                        self.assertEqual(process.stderr.splitlines(), output)
                    elif not re.fullmatch(pattern_of(output), process.stdout):
                        self.assertEqual(process.stdout, "\n".join(output))
        return count

    def test_tutorial(self) -> None:
        self.assertEqual(self.check(DOCS / "tutorial.md"), 11)

    def test_bring_your_own(self) -> None:
        self.assertEqual(self.check(DOCS / "bring_your_own.md"), 5)

    def test_faults(self) -> None:
        self.assertEqual(self.check(DOCS / "faults.md"), 2)

    def test_packages(self) -> None:
        count_of = {readme: self.check(readme) for readme in sorted(PACKAGES.glob("*/README.md"))}
        self.assertEqual(count_of[PACKAGES / "sim2sim_eval" / "README.md"], 9)
        for node in PACKAGES.glob("pusht_*/nodes/*.cpp"):  # what has a node shows how it is used
            self.assertGreater(count_of[node.parents[1] / "README.md"], 0, str(node))


class Pasted(LiveCase):
    """The commands of the README, in their order, in one folder that was empty."""

    EPISODES = "20"  # the fewest with intervals of differences

    def setUp(self) -> None:
        super().setUp()
        uri = f"http://127.0.0.1:{free_port()}"
        self.port = uri.split(":")[-1]
        self.environment = {
            "ROS_MASTER_URI": uri,
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(self.folder / "ros"),
            "DISPLAY": "",
            "PWD": str(self.folder),
        }

    def quick(self, command: str) -> str:
        """The same with few episodes, where it says how many or may."""
        if re.search(r"--episodes \d", command):
            return re.sub(r"--episodes \d+", f"--episodes {self.EPISODES}", command)
        if command.startswith(("rosrun sim2sim_eval compare", "rosrun sim2sim_eval sweep")):
            return f"{command} --episodes {self.EPISODES}"
        return command

    def paste(self, command: str) -> None:
        if not command.startswith("roslaunch"):
            self.succeed("bash", "-c", self.quick(command), environment=self.environment)
            return
        launch = command.replace("roslaunch", f"roslaunch -p {self.port}", 1)
        quick = [] if "replay" in command else [f"episodes:={self.EPISODES}"]
        arguments = ["rviz:=false", *quick]
        process = Process(self, *launch.split(), *arguments, environment=self.environment)
        if "replay.launch" in command:  # shows the bag until it is ended
            process.line(r"process\[sim2sim-\d+\]: started")
            self.succeed(
                *("rosservice", "call", "--wait", "/sim2sim/control", "{command: pause}"),
                environment=self.environment,
            )
            process.interrupt()
        self.assertEqual(process.ended(LAUNCH_DEADLINE), 0, process.output)

    def test_readme(self) -> None:
        text = (PACKAGES.parent / "README.md").read_text(encoding="utf-8")
        lines = [line for _, block in BLOCK.findall(text) for line in block.splitlines()]
        pasted = [line for line in lines if not line.startswith("script/")]
        self.assertEqual(len(pasted), 15)
        for line in pasted:
            with self.subTest(line):
                self.paste(re.sub(r"\s+#.*", "", line))
        for file in ("live/metrics.json", "first/report.html", "switches/attribution.json"):
            self.assertTrue((self.folder / file).exists(), file)


class ByHand(LiveCase):
    """What a README shows of a node, called of one."""

    def setUp(self) -> None:
        super().setUp()
        uri = f"http://127.0.0.1:{free_port()}"
        self.environment = {
            "ROS_MASTER_URI": uri,
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(self.folder / "ros"),
        }
        launch = ("roslaunch", "-p", uri.split(":")[-1], "pusht_engine", "engine.launch")
        node = Process(self, *launch, environment=self.environment)
        node.line(r"process\[engine-\d+\]: started")  # and so there is a master
        self.call("rosservice call --wait /engine/describe {}")

    def call(self, command: str) -> str:
        return self.succeed("bash", "-c", command, environment=self.environment)

    def test_services_of_the_engine(self) -> None:
        text = (PACKAGES / "pusht_engine" / "README.md").read_text(encoding="utf-8")
        calls = re.findall(r"^rosservice call .*$", text, re.MULTILINE)
        self.assertEqual(len(calls), 3)
        for call in calls:
            with self.subTest(call):
                self.assertIn("success: True", self.call(call))

    def test_services_in_python(self) -> None:
        text = (PACKAGES / "pusht_msgs" / "README.md").read_text(encoding="utf-8")
        blocks = BLOCK.findall(text)
        ((number, (_, program)),) = [b for b in enumerate(blocks) if b[1][0] == "python"]
        (self.folder / "by_hand.py").write_text(program)
        printed = self.call("python3 by_hand.py")
        self.assertEqual(printed, blocks[number + 1][1])
        calls = re.findall(r"`(rosservice call .*?)`", text)
        self.assertEqual(len(calls), 2)
        for call in calls:
            with self.subTest(call):
                self.assertIn("success: True", self.call(call))


class Names(CommandCase):
    def test_every_test_that_the_table_of_faults_names_is_there(self) -> None:
        sources = {
            file.name: file.read_text(encoding="utf-8")
            for file in PACKAGES.rglob("*")
            if file.suffix in (".py", ".cpp", ".hpp") and file.is_file()
        }
        rows = re.findall(r"^\| F(\d+) .*\|(.*)\|$", (DOCS / "faults.md").read_text(), re.MULTILINE)
        self.assertEqual([int(number) for number, _ in rows], list(range(1, len(rows) + 1)))
        for number, tests in rows:
            source = ""
            for name in re.findall(r"`(.*?)`", tests):
                with self.subTest(f"F{number}: {name}"):
                    if name.endswith((".py", ".cpp", ".hpp")):
                        self.assertIn(name, sources)
                        source = sources.get(name, "")
                    elif not (PACKAGES / name).is_dir():
                        for part in name.split("."):
                            self.assertRegex(source, rf"(def |class |, ){part}\b[(:)]")

    def test_every_kind_of_simulator_is_listed(self) -> None:
        command = (executable("sim2sim_eval", "compare"), "--engine", "none")
        (known,) = re.findall(r"known: (.*)", self.run_command(*command).stderr)
        wanted = {f"`{kind}`" for kind in known.split(", ")}
        for file, begin in (
            (PACKAGES / "sim2sim_eval" / "README.md", "**Simulators by name.**"),
            (DOCS / "glossary.md", "**Kind** (of simulator):"),
        ):
            with self.subTest(file.name):
                paragraphs = file.read_text(encoding="utf-8").split("\n\n")
                (listed,) = [text for text in paragraphs if text.startswith(begin)]
                self.assertEqual(wanted - set(re.findall("`.*?`", listed)), set())

    def test_what_docs_name_of_the_report_is_there(self) -> None:
        folder = PACKAGES / "sim2sim_report" / "src" / "sim2sim_report"
        page = "".join(file.read_text(encoding="utf-8") for file in folder.glob("page.*"))
        for text in (DOCS / "tutorial.md", DOCS / "exercises" / "README.md"):
            names = re.findall(
                r"ection \*([^*]+)\*|\*([^*]+)\* under \*([^*]+)\*", text.read_text()
            )
            self.assertGreater(len(names), 0, text)
            for name in (part for found in names for part in found if part):
                with self.subTest(f"{text.name}: {name}"):
                    self.assertIn(name, page)


class Exercises(CommandCase):
    """The checks tell right answers from wrong ones, and give none away."""

    def check(self, *arguments: str) -> Tuple[int, str]:
        process = self.run_command(str(DOCS / "exercises" / "check"), *arguments)
        return process.returncode, process.stdout + process.stderr

    def test_transfer(self) -> None:
        code, text = self.check("transfer", "--keeps", "20", "60", "--not-better-in", "angle")
        self.assertEqual((code, text.count(": right")), (0, 2))
        code, text = self.check("transfer", "--keeps", "90", "100", "--not-better-in", "neither")
        self.assertEqual((code, text.count("not right")), (1, 2))
        self.assertNotRegex(text, r"\d", "no figure is given away")

    def test_transfer_refuses_a_range_that_is_right_whatever_happens(self) -> None:
        for low, high in (("0", "100"), ("20", "71"), ("60", "20"), ("-10", "30"), ("nan", "30")):
            with self.subTest(low=low, high=high):
                keeps = ("--keeps", low, high)
                code, text = self.check("transfer", *keeps, "--not-better-in", "angle")
                self.assertEqual(code, 2)
                self.assertIn("at most 50 wide", text)

    def test_observation(self) -> None:
        exercise = DOCS / "exercises" / "observation.py"
        self.assertEqual(self.check("observation", str(exercise))[0], 2)
        solution = DOCS / "exercises" / "solutions" / "observation.py"
        self.assertEqual(self.check("observation", str(solution))[0], 0)
        text = solution.read_text()
        wrong = {
            "the wrong turn": ("1.5 * math.pi", "0.5 * math.pi"),
            "not wrapped": (" % (2.0 * math.pi) - math.pi", " - math.pi"),
            "the wrong order": ("math.sin(yaw), math.cos(yaw)", "math.cos(yaw), math.sin(yaw)"),
            "too few": (", 1.0]", "]"),
        }
        for name, (right, changed) in wrong.items():
            with self.subTest(name):
                mine = self.folder / "mine.py"
                mine.write_text(text.replace(right, changed))
                self.assertEqual(self.check("observation", str(mine))[0], 1)
        mine.write_text("no python")
        self.assertEqual(self.check("observation", str(mine))[0], 2)

    def test_knob(self) -> None:
        code, text = self.check("knob", *KNOB)
        self.assertEqual((code, text.count(": right")), (0, 3))
        code, text = self.check("knob", "rises", "rises", "rises")
        self.assertEqual(code, 1)


class Pattern(unittest.TestCase):
    def test_dots_stand_for_anything_and_nothing_else_does(self) -> None:
        pattern = pattern_of(["a", "...", "b 0.5", "c..."])
        for text in ("a\nb 0.5\nc\n", "a\nx\ny\nb 0.5  \ncd\n"):
            self.assertIsNotNone(re.fullmatch(pattern, text))
        for text in ("a\nb 0x5\nc\n", "a\nb 0.5\nc\nd\n", "b 0.5\nc\n"):
            self.assertIsNone(re.fullmatch(pattern, text))


if __name__ == "__main__":
    unittest.main()
