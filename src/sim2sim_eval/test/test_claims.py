#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the documents claim: every mark names a claim, every interval has a mark, and the cheap
figures are measured again. script/claims measures all."""

import re
import shlex
import sys
from pathlib import Path
from typing import Dict, List, Tuple

from command_case import CommandCase, executable

BENCHMARK = Path(__file__).resolve().parents[1] / "benchmark"
SOURCES = BENCHMARK.parents[1]
sys.path.insert(0, str(BENCHMARK))
import claims  # noqa: E402

# Documents of which every interval is a claim.
DOCUMENTS = (
    "README.md",
    "docs/agreement.md",
    "docs/continuous_contact.md",
    "docs/course.md",
    "docs/findings.md",
    "docs/idioms.md",
    "docs/ladder.md",
    "docs/study/engines.md",
    "docs/study/findings.md",
)
RUNS = claims.read(claims.TABLE)
TOY = """
toy:
  run:
    - |-
      echo '{content}' > toy.json
  claims:
    toy.json:
      keeps: {{keys: transfer, where: [{where}]}}
"""
PAGE = "The engine keeps 31 % [30, 32]<!--toy.keeps-->,\nand 16 %<!--outside--> elsewhere.\n"


class Table(CommandCase):
    def test_every_interval_that_the_documents_print_has_a_mark(self) -> None:
        marked = claims.marks(RUNS, claims.ROOT)
        for document in DOCUMENTS:
            text = (claims.ROOT / document).read_text(encoding="utf-8")
            for mark in (mark for mark in marked if mark.document == document):
                for figure in mark.figures:
                    blank = "#" * len(figure.text)
                    text = text[: figure.begin] + blank + text[figure.end :]
            with self.subTest(document):
                self.assertEqual(claims.INTERVAL.findall(text), [])

    def test_commands_are_those_of_the_suite(self) -> None:
        """Each option is in the command's help, each plan is there."""
        help_of: Dict[Tuple[str, ...], str] = {}
        for command in (command for run in RUNS for command in run.commands):
            words = shlex.split(re.sub(r"\$\(rospack find (\w+)\)", rf"{SOURCES}/\1", command))
            with self.subTest(command):
                if words[0] == "echo":
                    continue
                program: Tuple[str, ...] = tuple(words[:2])
                arguments = words[2:]
                if words[0] == "rosrun":
                    program, arguments = (executable(*words[1:3]),), words[3:]
                else:
                    self.assertEqual(words[0], "/usr/bin/python3")
                    self.assertEqual(Path(words[1]).parents[2], SOURCES)
                if program not in help_of:
                    process = self.run_command(*program, "--help")
                    self.assertEqual(process.returncode, 0, process.stderr)
                    help_of[program] = process.stdout
                for word in arguments:
                    if word.startswith("--"):
                        self.assertIn(word, re.findall(r"--[\w-]+", help_of[program]))
                    if "/config/" in word:
                        self.assertTrue(Path(word).is_file(), word)

    def test_cheap_claims_are_measured_again(self) -> None:
        self.assertEqual(claims.main(["--cheap", "--out", str(self.folder)]), 0)


class Compared(CommandCase):
    """A table of one run, whose document is beside it."""

    def claims(
        self,
        content: str = '{"transfer": 0.3104, "transfer_interval": [0.297, 0.324]}',
        where: str = "transfer < 0.5",
        document: str = PAGE,
        arguments: Tuple[str, ...] = (),
    ) -> Tuple[int, str]:
        text = TOY.format(content=content, where=where)
        return self.claims_of(text, document, arguments)

    def claims_of(
        self, text: str, document: str, arguments: Tuple[str, ...] = ()
    ) -> Tuple[int, str]:
        self.write("README.md", document.encode())
        (self.folder / "docs").mkdir(exist_ok=True)
        table = self.write("docs/claims.yaml", text.encode())
        program = str(BENCHMARK / "claims.py")
        process = self.run_command(sys.executable, program, "--table", table, *arguments)
        return process.returncode, process.stdout + process.stderr

    def test_same_to_the_printed_digits(self) -> None:
        code, text = self.claims()
        self.assertEqual(code, 0, text)
        self.assertIn("2 same, 0 DIFFERS; 1 were measured outside", text)

    def test_what_differs(self) -> None:
        for content, line in (
            ('{"transfer": 0.3156, "transfer_interval": [0.297, 0.324]}', r"32 % \[30, 32\]"),
            ('{"transfer": 0.31, "transfer_interval": [0.297, 0.325001]}', r"31 % \[30, 33\]"),
            ('{"transfer": 0.31, "transfer_interval": null}', r"31 % \[none, none\]"),
            ('{"transfer": null}', r"none % \[none, none\]"),
        ):
            with self.subTest(content):
                code, text = self.claims(content=content)
                self.assertEqual(code, 1, text)
                self.assertRegex(text, rf"toy.keeps +31 % \[30, 32\] +{line} +DIFFERS")

    def test_what_differs_is_written_into_the_document(self) -> None:
        content = '{"transfer": 0.3156, "transfer_interval": [0.297, 0.3451]}'
        code, text = self.claims(content=content, arguments=("--write",))
        self.assertEqual(code, 1, text)
        expected = PAGE.replace("31 % [30, 32]", "32 % [30, 35]")
        self.assertEqual((self.folder / "README.md").read_text(), expected)

    def test_condition_that_does_not_hold(self) -> None:
        code, text = self.claims(where="transfer > 0.5")
        self.assertEqual(code, 1, text)
        self.assertIn("transfer is 0.3104", text)

    def test_refused(self) -> None:
        for document, rule in (
            ("It keeps 31 %.", "claim toy.keeps: no document has its mark <!--toy.keeps-->"),
            (PAGE + "16 %<!--toy.kept-->", "README.md: mark <!--toy.kept-->: claims.yaml has no"),
            ("About a third<!--toy.keeps-->", "mark <!--toy.keeps-->: 0 figures before it: must"),
            ("Of 31 %:\n\na third<!--toy.keeps-->", "0 figures before it: must be 1"),
        ):
            with self.subTest(document):
                code, text = self.claims(document=document)
                self.assertEqual(code, 2, text)
                self.assertIn(rule, text)
        for content in ('{"share": 0.31}', "[]", "no JSON"):
            with self.subTest(content):
                code, text = self.claims(content=content)
                self.assertEqual(code, 2, text)
                self.assertIn("claims: claim toy.keeps: toy.json transfer: ", text)

    def test_figures_before_a_mark(self) -> None:
        """The last ones of the paragraph, as many as the claim has keys."""
        for text, count, expected in (
            ("| 2 | 0.046 [0.042, 0.050] | +5 % [-1, 9]<!--a.b-->", 2, None),
            ("44 %<!--a.c--> after 2 s, 31 %<!--a.b-->", 1, ["31 %"]),
            ("100 % [94, 106]<!--a.b-->", 1, ["100 % [94, 106]"]),
            ("costs 1.9 control steps [1, 2]<!--a.b-->", 1, ["1.9 control steps [1, 2]"]),
            ("7.1 mm to 8.2 mm<!--a.b-->", 2, ["7.1 mm", "8.2 mm"]),
            ("version 2.2.2<!--a.b-->", 1, None),
        ):
            with self.subTest(text):
                counts = {"a.b": count, "a.c": 1}
                if text.startswith("version"):
                    with self.assertRaises(claims.Error):
                        [*claims.marks_in("page", text, {"a.b": 2})]
                    continue
                mark = [*claims.marks_in("page", text, counts)][-1]
                expected = expected or ["0.046 [0.042, 0.050]", "+5 % [-1, 9]"]
                self.assertEqual([figure.text for figure in mark.figures], expected)
                for figure in mark.figures:
                    self.assertEqual(text[figure.begin : figure.end], figure.text)

    def test_signs_and_units(self) -> None:
        cases: List[Tuple[str, List[float], str]] = [
            ("+0.010", [0.0104], "+0.010"),
            ("+0.00", [-0.001], "+0.00"),
            ("-0.01", [0.01], "0.01"),
            ("7 mm [6.0, 9]", [0.00712, 0.006, 0.0089], "7 mm [6.0, 9]"),
            ("0.97 rad [0.96, 0.98]", [0.9704, 0.957, 0.983], "0.97 rad [0.96, 0.98]"),
            ("603", [603], "603"),
            ("37 % [21 %, 61 %]", [0.366, 0.209, 0.611], "37 % [21 %, 61 %]"),
        ]
        for printed, numbers, expected in cases:
            self.assertEqual(claims.in_form_of(printed, [*numbers]), expected)

    def test_unit_that_the_document_names_elsewhere(self) -> None:
        self.kept('{"gap_m": 0.00712, "gap_interval_m": [0.006, 0.0089]}')
        table = "toy:\n  kept: docs\n  claims: {toy.json: {gap: gap_m mm}}"
        code, text = self.claims_of(table, "| gap [mm] |\n| 7.1 [6.0, 9]<!--toy.gap--> |")
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"7.1 \[6.0, 9\] +7.1 \[6.0, 9\] +same")

    def kept(self, content: str) -> None:
        (self.folder / "docs").mkdir(exist_ok=True)
        self.write("docs/toy.json", content.encode())

    def test_results_that_stand_in_the_project(self) -> None:
        """A longer program left them there; no command is run, and a mark may name a key."""
        table = "toy:\n  kept: docs\n  file: toy.json"
        page = "The engine keeps 31 %<!--toy.of/two mass/transfer-->."
        self.kept('{"of": {"two mass": {"transfer": 0.3104}}}')
        code, text = self.claims_of(table, page, ("--cheap",))
        self.assertEqual(code, 0, text)
        self.assertIn("1 same, 0 DIFFERS", text)
        self.kept('{"of": {"two mass": {"transfer": 0.33}}}')
        code, text = self.claims_of(table, page, ("--cheap",))
        self.assertEqual(code, 1, text)
        code, text = self.claims_of(table, page.replace("mass", "masses"))
        self.assertEqual(code, 2, text)
        self.assertIn("claim toy.of/two masses/transfer: toy.json", text)

    def test_results_are_kept_and_used_again(self) -> None:
        kept = ("--out", str(self.folder / "kept"))
        for content in ('{"transfer": 0.31, "transfer_interval": [0.3, 0.32]}', "{}"):
            code, text = self.claims(content=content, arguments=kept)
            self.assertEqual(code, 0, text)

    def test_some_by_name(self) -> None:
        code, text = self.claims(content="{}", arguments=("--cheap",))
        self.assertEqual(code, 0, text)
        self.assertIn("0 same, 0 DIFFERS; 1 were measured outside", text)
        code, text = self.claims(arguments=("nothing",))
        self.assertEqual(code, 2, text)
        self.assertIn("claim nothing: unknown", text)
