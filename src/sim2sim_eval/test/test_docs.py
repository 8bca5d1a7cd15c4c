#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs what the docs say, and compares with the output that they show.

In a `console` block a line after `$ ` is a command, and the lines below it are what it prints; if
it fails, all that it complains of. A line `...` stands for any lines, `...` at a line's end for
any rest. Numbers in circles at the ends of lines are not printed. A block whose first line is a
comment with a file name is that file. What is called by hand is called of nodes. Nodes offer and
read what their lists say. And what docs name is there.
"""

import os
import re
import unittest
from pathlib import Path
from typing import Any, Dict, Iterator, List, Set, Tuple
from unittest import mock

import rosgraph  # type: ignore[import]
import rospkg  # type: ignore[import]
import rosservice  # type: ignore[import]
import yaml  # type: ignore[import]
from pusht_testing.long_tests import LONG, long_form

from command_case import CommandCase, executable, until
from live_support import CALLER, DEADLINE, LiveCase, OwnMaster, Process, free_port

PACKAGES = Path(rospkg.RosPack().get_path("sim2sim_eval")).parent
ROOT = PACKAGES.parent
DOCS = ROOT / "docs"
PARAMETER = ("falls", "falls", "no-difference")  # as in the solutions
LAUNCH_DEADLINE = 180  # [s] a live run of a few episodes on a busy machine
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# ([\w.]+)\n")
FINGER = re.compile(r" +[\u2460-\u2473]$", re.MULTILINE)  # number in a circle
PAGES = [*ROOT.glob("*.md"), *DOCS.rglob("*.md"), *PACKAGES.glob("*/README.md")]


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


def anchor_of(title: str) -> str:
    """The name under which a heading can be linked to."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def commands(block: str) -> Iterator[Tuple[str, List[str]]]:
    for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        command, *output = part.splitlines()
        yield command, output


class Docs(CommandCase):
    def check(self, page: Path, before: str = "") -> int:
        """How many commands were run, in one folder, one after the other; up to this line."""
        count = 0
        text = page.read_text(encoding="utf-8")
        if before:
            self.assertEqual(text.count(f"{before}\n"), 1, before)
            text = text[: text.index(f"{before}\n")]
        for language, block in BLOCK.findall(text):
            file = FILE.match(block)
            if file:
                (self.folder / file[1]).write_text(block)
            if language != "console":
                continue
            for command, output in commands(FINGER.sub("", block)):
                with self.subTest(command):
                    process = self.run_command("bash", "-c", command)
                    count += 1
                    if process.returncode != 0:  # as shown, word for word
                        self.assertEqual(process.stderr.splitlines(), output)
                    elif not re.fullmatch(pattern_of(output), process.stdout):
                        self.assertEqual(process.stdout, "\n".join(output))
        return count

    def test_beginning_of_the_tutorial(self) -> None:
        self.assertEqual(self.check(DOCS / "tutorial.md", "## 4. Change a parameter"), 2)

    def test_reading_a_result(self) -> None:
        self.assertEqual(self.check(DOCS / "reading_a_result.md"), 1)

    @long_form
    def test_tutorial(self) -> None:
        self.assertEqual(self.check(DOCS / "tutorial.md"), 14)

    @long_form
    def test_bring_your_own(self) -> None:
        self.assertEqual(self.check(DOCS / "bring_your_own.md"), 8)

    def test_networks(self) -> None:
        self.assertEqual(self.check(DOCS / "networks.md"), 7)

    @long_form
    def test_commands(self) -> None:
        self.assertEqual(self.check(DOCS / "commands.md"), 12)

    def test_faults(self) -> None:
        self.assertEqual(self.check(DOCS / "faults.md"), 2)

    def test_packages_that_show_faults_and_worlds(self) -> None:
        for package, commands_shown in (
            ("pusht_engine", 1),
            ("sim2sim_python", 1),
        ):
            self.assertEqual(self.check(PACKAGES / package / "README.md"), commands_shown, package)

    @long_form
    def test_packages(self) -> None:
        count_of = {readme: self.check(readme) for readme in sorted(PACKAGES.glob("*/README.md"))}
        self.assertEqual(count_of[PACKAGES / "sim2sim_eval" / "README.md"], 1)
        for node in PACKAGES.glob("pusht_*/nodes/*.cpp"):  # what has a node shows how it is used
            self.assertGreater(count_of[node.parents[1] / "README.md"], 0, str(node))


class Pasted(LiveCase):
    """Commands of a page, in their order, in one folder that was empty."""

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
        """Command with few episodes, where it says how many or may."""
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

    def check(self, page: Path, count: int, *files: str) -> None:
        text = page.read_text(encoding="utf-8")
        pasted = "".join(block for language, block in BLOCK.findall(text) if not language)
        lines = [line for line in pasted.splitlines() if not line.startswith("script/")]
        self.assertEqual(len(lines), count)
        for line in lines:
            with self.subTest(line):
                self.paste(re.sub(r"\s+#.*", "", line))
        for file in files:
            self.assertTrue((self.folder / file).exists(), file)

    def test_readme_takes_three_minutes_and_two_commands(self) -> None:
        self.assertLessEqual(len((ROOT / "README.md").read_text().splitlines()), 110)
        self.check(ROOT / "README.md", 0)

    @long_form
    def test_commands(self) -> None:
        files = ("live/metrics.json", "first/report.html", "switches/attribution.json")
        self.check(DOCS / "commands.md", 13, *files)

    @long_form
    def test_findings(self) -> None:
        self.check(DOCS / "findings.md", 4, "damp/sweep.png", "variants/sweep.json")


class ByHand(OwnMaster):
    """What a README shows of a node, called of one."""

    def setUp(self) -> None:
        super().setUp()
        uri = self.use_own_master()
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


class WorkedExample(OwnMaster):
    """Audit of a node with two mistakes that are found and mended one after the other."""

    def setUp(self) -> None:
        super().setUp()
        text = (DOCS / "audit.md").read_text(encoding="utf-8")
        (section,) = re.findall(r"^## Worked example\n(.*?)^## ", text, re.M | re.S)
        blocks = BLOCK.findall(section)
        self.mistakes = [block for language, block in blocks if language == "diff"]
        shown = [block for language, block in blocks if language == "console"]
        self.audits = [next(commands(block)) for block in shown]
        self.master = rosgraph.Master(CALLER, master_uri=self.start_master())

    def with_mistakes(self, mistakes: List[str]) -> str:
        """The example with these lines changed."""
        path = PACKAGES / "sim2sim_eval" / "examples" / "quasi_static_simulator"
        text = path.read_text(encoding="utf-8")
        for hunk in re.split(r"^@@.*\n", "".join(mistakes), flags=re.M)[1:]:
            right, wrong = (
                "".join(line[1:] for line in hunk.splitlines(True) if line[0] == sign)
                for sign in "-+"
            )
            self.assertEqual(text.count(right), 1, right)
            text = text.replace(right, wrong)
        return text

    def served(self) -> bool:
        _, _, services = self.master.getSystemState()
        return "/engine/describe" in dict(services)

    def audited(self, program: str, command: str) -> str:
        """What an audit of a simulator prints."""
        (self.folder / "mine.py").write_text(program)
        node = ("/usr/bin/python3", "mine.py", "__name:=engine")
        process = Process(self, *node, environment=self.environment)
        until(self.served)
        audit = self.run_command("bash", "-c", command, environment=self.environment)
        process.interrupt()
        process.ended(DEADLINE)
        return audit.stdout + audit.stderr

    def test_two_mistakes(self) -> None:
        self.assertEqual((len(self.mistakes), len(self.audits)), (2, 3))
        found = []
        for stage, (command, shown) in enumerate(self.audits):
            with self.subTest(stage):
                printed = self.audited(self.with_mistakes(self.mistakes[stage:]), command)
                if not re.fullmatch(pattern_of(shown), printed):
                    self.assertEqual(printed, "\n".join(shown))
                found += re.findall(r"^1\. (.*?)[: ]", printed, re.M)
        self.assertEqual(found, ["[contract]", "[contract]", "[physics]"])


class Nodes(OwnMaster):
    """Lists of topics, services, actions and private parameters in READMEs, against the nodes."""

    OF_ALL = {"/rosout", "~get_loggers", "~set_logger_level"}
    OF_AN_ACTION = ("goal", "cancel", "feedback", "result", "status")

    def setUp(self) -> None:
        super().setUp()
        self.master = rosgraph.Master(CALLER, master_uri=self.start_master())

    def run_node(self, package: str, node: str, *arguments: str) -> Process:
        command = (executable(package, node), "__name:=node", *arguments)
        return Process(self, *command, environment=self.environment)

    def offered(self, last: str) -> Dict[str, str]:
        """What the node offers, with the kind and type of each, once it offers the last."""
        until(lambda: any(f"/node/{last}" in dict(some) for some in self.master.getSystemState()))
        publishers, subscribers, services = self.master.getSystemState()
        found = {
            name: f"topic {kind}"
            for name, kind in self.master.getTopicTypes()
            if "/node" in dict(publishers).get(name, [])
        }
        with mock.patch.dict(os.environ, self.environment):
            found.update(
                (name, f"service {rosservice.get_service_type(name)}")
                for name, nodes in services
                if "/node" in nodes
            )
        listed = {re.sub("^/node/", "~", name): kind for name, kind in found.items()}
        for goal, nodes in subscribers:
            if "/node" in nodes and goal.endswith("/goal"):
                action = re.sub("^/node/", "~", goal[: -len("/goal")])
                feedback = listed[f"{action}/feedback"]
                for part in self.OF_AN_ACTION:
                    listed.pop(f"{action}/{part}", None)
                listed[action] = re.sub("topic (.*)ActionFeedback", r"action \1", feedback)
        return {name: kind for name, kind in listed.items() if name not in self.OF_ALL}

    def refused(self, package: str, node: str, *arguments: str) -> Set[str]:
        """The private parameters that the node knows, as it says when it refuses another one."""
        process = self.run_node(package, node, "_nonsense:=1", *arguments)
        _, line = process.line("nonsense 1: unknown; known: ")
        self.end(process)
        return {f"~{name}" for name in line.split("known: ")[1].strip().split(", ")}

    def end(self, process: Process) -> None:
        process.interrupt()
        process.ended(DEADLINE)
        if self.master.hasParam("/node"):
            self.master.deleteParam("/node")

    def published(self, topic: str) -> Dict[str, Any]:
        """The last message of a topic of the node."""
        echo = ("rostopic", "echo", "-n1", f"/node/{topic}")
        text = self.succeed(*echo, environment=self.environment)
        message: Dict[str, Any] = yaml.safe_load(text.split("---")[0])
        return message

    @staticmethod
    def listed(package: str, node: str) -> Tuple[Dict[str, str], Dict[str, str]]:
        """Kind and type of what a README lists of a node; defaults of its parameters."""
        text = (PACKAGES / package / "README.md").read_text(encoding="utf-8")
        (section,) = re.findall(rf"^##+ Node `{node}`\n(.*?)(?=^#|\Z)", text, re.M | re.S)
        offers: Dict[str, str] = {}
        defaults: Dict[str, str] = {}
        for row in re.findall(r"^\| (`[~/].*) \|$", section, re.M):
            names, kind, *rest = row.split(" | ")
            offered = re.match(r"(topic|service|action)s? `(.*?)`", kind)
            for name in re.findall("`(.*?)`", names):
                if len(rest) == 2:
                    defaults[name] = rest[0].strip("`")
                else:
                    offers[name] = " ".join(offered.groups()) if offered else ""
        return offers, defaults

    def test_evaluator(self) -> None:
        offers, defaults = self.listed("sim2sim_eval", "evaluator_node")
        known = self.refused("sim2sim_eval", "evaluator_node")
        self.run_node("sim2sim_eval", "evaluator_node")
        self.assertEqual(self.offered("compare/cancel"), offers)
        options = self.published("options")  # which the README does not list
        default_of = {f"~{of['name']}": of["default_value"] for of in options["descriptors"]}
        values = {f"~{option['name']}": option["value"] for option in options["values"]}
        self.assertEqual(values, default_of)
        self.assertEqual(sorted([*defaults, *default_of]), sorted(known))
        request = self.published("request")
        for name in ("overwrite", "record"):
            self.assertEqual(yaml.safe_load(defaults[f"~{name}"]), request[name][0], name)

    def test_audit(self) -> None:
        offers, defaults = self.listed("sim2sim_eval", "audit_node")
        self.assertEqual(set(defaults), self.refused("sim2sim_eval", "audit_node"))
        self.run_node("sim2sim_eval", "audit_node")
        self.assertEqual(self.offered("get_loggers"), offers)

    def test_replay(self) -> None:
        bag = ("--policy", "expert", "--episodes", "1", "--record", "--out", "recorded")
        self.succeed("rosrun", "sim2sim_eval", "compare", *bag)
        offers, defaults = self.listed("sim2sim_eval", "replay_node")
        self.assertEqual(set(defaults), self.refused("sim2sim_eval", "replay_node"))
        self.run_node("sim2sim_eval", "replay_node", "_bag:=recorded/compare.bag")
        evaluator, _ = self.listed("sim2sim_eval", "evaluator_node")
        for name, kind in self.offered("control").items():
            self.assertEqual(kind, offers.pop(name) or evaluator[name], name)
        self.assertEqual(offers, {})

    def test_simulators(self) -> None:
        offers, defaults = self.listed("sim2sim_serving", "simulator_node")
        for package, node, kind in (
            ("sim2sim_eval", "simulator_node", ("_kind:=two_mass",)),
            ("pusht_engine", "engine_node", ()),
            ("pusht_mujoco", "mujoco_node", ()),
            ("pusht_box2d", "box2d_node", ()),
            ("pusht_chipmunk", "chipmunk_node", ()),
            ("pusht_bullet", "bullet_node", ()),
        ):
            with self.subTest(node):
                own = "pusht_engine" if kind else package
                readme = (PACKAGES / own / "README.md").read_text(encoding="utf-8")
                rows = set(re.findall(r"^\| `(\w+)` \|", readme, re.M))
                known = self.refused(package, node, *kind)
                common = {name for name in defaults if kind or name != "~kind"}
                self.assertLessEqual(common, known)
                self.assertLessEqual({name[1:] for name in known - common}, rows)
                process = self.run_node(package, node, *kind)
                self.assertEqual(self.offered("describe"), offers)
                self.end(process)

    def test_policy(self) -> None:
        offers, _ = self.listed("sim2sim_serving", "policy_node")
        _, defaults = self.listed("pusht_policy", "policy_node")
        known = self.refused("pusht_policy", "policy_node", "_policy:=expert")
        self.assertEqual(set(defaults), known)
        self.run_node("pusht_policy", "policy_node", "_policy:=expert")
        self.assertEqual(self.offered("describe"), offers)


class Names(CommandCase):
    def test_every_link_leads_somewhere(self) -> None:
        links = 0
        for page in PAGES:
            text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
            for target in re.findall(r"\]\(([^)\s]+)\)", text):
                if re.match(r"https?:", target):
                    continue
                links += 1
                with self.subTest(f"{page.relative_to(ROOT)}: {target}"):
                    file, _, anchor = target.partition("#")
                    path = (page.parent / file).resolve() if file else page
                    self.assertTrue(path.exists())
                    if anchor:
                        text_there = (path / "README.md" if path.is_dir() else path).read_text()
                        titles = re.findall(r"^#+ (.*)$", text_there, re.M)
                        self.assertIn(anchor, {anchor_of(title) for title in titles})
        self.assertGreater(links, 100)

    def test_pages_use_plain_words_and_the_terms_of_the_field(self) -> None:
        words = "whoever|nobody|somebody|seams?|yardsticks?|knobs?|dry friction|milliards?"
        for page in PAGES:
            if page.name in ("glossary.md", "CHANGELOG.md"):
                continue  # the one maps words, the other is the history
            text = re.sub(r"`.*?`|^```.*?^```$", "", page.read_text(), flags=re.M | re.S)
            with self.subTest(page.name):
                self.assertEqual(re.findall(rf"(?i)\b(?:{words})\b", text), [])

    def test_every_script_that_the_readme_names_is_there(self) -> None:
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        for name in set(re.findall(r"script/[\w-]+", text)):
            self.assertTrue((ROOT / name).is_file(), name)

    def test_every_fault_has_tests_that_are_there(self) -> None:
        sources: Dict[str, str] = {}  # of one name in two packages: both
        for file in PACKAGES.rglob("*"):
            if file.suffix in (".py", ".cpp", ".hpp") and file.is_file():
                sources[file.name] = sources.get(file.name, "") + file.read_text(encoding="utf-8")
        table = PACKAGES / "sim2sim_eval" / "test" / "data" / "faults.yaml"
        tests_of = yaml.safe_load(table.read_text(encoding="utf-8"))
        page = (DOCS / "faults.md").read_text(encoding="utf-8")
        rows = [int(number) for number in re.findall(r"^\| F(\d+) \|", page, re.MULTILINE)]
        self.assertEqual(sorted(rows), list(range(1, len(rows) + 1)))
        self.assertEqual(list(tests_of), [f"F{number}" for number in sorted(rows)])
        for fault, files in tests_of.items():
            for source, tests in files.items():
                with self.subTest(f"{fault}: {source}"):
                    self.assertIn(source, sources)
                    for name in [] if tests == "all" else tests:
                        for part in name.split("."):
                            self.assertRegex(sources[source], rf"(def |class |, ){part}\b[(:)]")

    def test_every_kind_of_simulator_is_listed(self) -> None:
        command = (executable("sim2sim_eval", "compare"), "--engine", "nothing")
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
        if LONG:
            code, text = self.check("transfer", "--keeps", "20", "60", "--not-better-in", "angle")
            self.assertEqual((code, text.count(": right")), (0, 2))
        code, text = self.check("transfer", "--keeps", "90", "100", "--not-better-in", "angle")
        self.assertEqual((code, text.count("not right"), text.count(": right")), (1, 1, 1))
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

    @long_form
    def test_parameter(self) -> None:
        code, text = self.check("parameter", *PARAMETER)
        self.assertEqual((code, text.count(": right")), (0, 3))
        code, text = self.check("parameter", *PARAMETER[:2], "rises")
        self.assertEqual((code, text.count("not right"), text.count(": right")), (1, 1, 2))


class Pattern(unittest.TestCase):
    def test_dots_stand_for_anything_and_nothing_else_does(self) -> None:
        pattern = pattern_of(["a", "...", "b 0.5", "c..."])
        for text in ("a\nb 0.5\nc\n", "a\nx\ny\nb 0.5  \ncd\n"):
            self.assertIsNotNone(re.fullmatch(pattern, text))
        for text in ("a\nb 0x5\nc\n", "a\nb 0.5\nc\nd\n", "b 0.5\nc\n"):
            self.assertIsNone(re.fullmatch(pattern, text))


if __name__ == "__main__":
    unittest.main()
