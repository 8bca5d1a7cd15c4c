#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the documents claim: the table of claims is whole, documents say what it says, and the
cheap ones are measured again. script/claims measures all."""

import re
import shlex
import sys
from pathlib import Path
from typing import Dict, List, Tuple

from command_case import CommandCase, executable

BENCHMARK = Path(__file__).resolve().parents[1] / "benchmark"
sys.path.insert(0, str(BENCHMARK))
import claims  # noqa: E402

# Documents of which every interval is a claim.
DOCUMENTS = (
    "README.md",
    "docs/agreement.md",
    "docs/continuous_contact.md",
    "docs/findings.md",
    "docs/idioms.md",
    "docs/ladder.md",
    "docs/study/engines.md",
    "docs/study/findings.md",
)
INTERVAL = re.compile(r"\[[+-]?\d[^\[\],]*, [+-]?\d[^\[\],]*\]")
RUNS = claims.read(claims.TABLE)
TOY = """
toy:
  run:
    - |-
      echo '{content}' > toy.json
  claims:
    keeps:
      {{in: README.md, says: "keeps {figure}", file: toy.json, keys: [transfer], where: [{where}]}}
outside:
  claims:
    more: {{in: README.md, says: "and {{16 %}} elsewhere"}}
"""


class Table(CommandCase):
    def test_documents_say_what_the_table_says(self) -> None:
        for run in RUNS:
            for claim in run.claims:
                with self.subTest(claim.name):
                    self.assertTrue(claims.stands(claim), f"{claim.document}: {claim.text}")

    def test_every_interval_that_the_documents_print_is_a_claim(self) -> None:
        for document in DOCUMENTS:
            text = claims.plain((claims.ROOT / document).read_text(encoding="utf-8"))
            said = [
                claims.plain(claim.text)
                for run in RUNS
                for claim in run.claims
                if claim.document == document
            ]
            for words in sorted(said, key=len, reverse=True):  # "5 %" is in "65 % [46, 79]"
                text = text.replace(words, "")
            with self.subTest(document):
                self.assertEqual(INTERVAL.findall(text), [])

    def test_commands_are_those_of_the_suite(self) -> None:
        """Each option is in the command's help, each plan is there."""
        help_of: Dict[Tuple[str, ...], str] = {}
        for command in (command for run in RUNS for command in run.commands):
            words = shlex.split(
                command.replace("$(rospack find sim2sim_eval)", str(BENCHMARK.parent))
            )
            with self.subTest(command):
                if words[0] == "echo":
                    continue
                program: Tuple[str, ...] = tuple(words[:2])
                arguments = words[2:]
                if words[0] == "rosrun":
                    program, arguments = (executable(*words[1:3]),), words[3:]
                else:
                    self.assertEqual(words[0], "/usr/bin/python3")
                    self.assertEqual(Path(words[1]).parent, BENCHMARK)
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
    """A table of two runs, whose document is beside it."""

    def claims(
        self,
        figure: str = "{31 % [30, 32]}",
        content: str = '{"transfer": 0.3104, "transfer_interval": [0.297, 0.324]}',
        where: str = "transfer < 0.5",
        document: str = "The engine keeps 31 % [30, 32],\nand 16 % elsewhere.\n",
        arguments: Tuple[str, ...] = (),
    ) -> Tuple[int, str]:
        self.write("README.md", document.encode())
        (self.folder / "docs").mkdir(exist_ok=True)
        text = TOY.format(figure=figure, content=content, where=where)
        table = self.write("docs/claims.yaml", text.encode())
        program = str(BENCHMARK / "claims.py")
        process = self.run_command(sys.executable, program, "--table", table, *arguments)
        return process.returncode, process.stdout + process.stderr

    def test_same_to_the_printed_digits(self) -> None:
        code, text = self.claims()
        self.assertEqual(code, 0, text)
        self.assertIn("2 same, 0 DIFFERS, 1 measured outside", text)

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

    def test_condition_that_does_not_hold(self) -> None:
        code, text = self.claims(where="transfer > 0.5")
        self.assertEqual(code, 1, text)
        self.assertIn("transfer is 0.3104", text)

    def test_text_that_is_not_in_the_document(self) -> None:
        code, text = self.claims(document="The engine keeps 37 % [21, 61], and 16 % elsewhere.")
        self.assertEqual(code, 1, text)
        self.assertIn("is not in README.md", text)

    def test_refused(self) -> None:
        for figure, rule in (
            ("{about a third}", "must be like"),
            ("31 % [30, 32]", "1 keys: must be 0"),
        ):
            with self.subTest(figure):
                code, text = self.claims(figure=figure)
                self.assertEqual(code, 2, text)
                self.assertIn(rule, text)
        for content in ('{"share": 0.31}', "[]", "no JSON"):
            with self.subTest(content):
                code, text = self.claims(content=content)
                self.assertEqual(code, 2, text)
                self.assertIn("claims: claim toy.keeps: toy.json transfer: ", text)

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
        claim = "gap: {in: README.md, says: '| {7.1 [6.0, 9]} |', file: toy.json, keys: [gap_m mm]}"
        self.write("README.md", b"| gap [mm] |\n| 7.1 [6.0, 9] |")
        (self.folder / "docs").mkdir()
        self.write("docs/toy.json", b'{"gap_m": 0.00712, "gap_interval_m": [0.006, 0.0089]}')
        table = self.write(
            "docs/claims.yaml", f"toy:\n  kept: docs\n  claims:\n    {claim}".encode()
        )
        self.assertEqual(claims.main(["--table", table]), 0)

    def test_results_that_stand_in_the_project(self) -> None:
        """A longer program left them there; no command is run."""
        claim = "keeps: {in: README.md, says: 'keeps {31 %}', file: toy.json, keys: [transfer]}"
        self.write("README.md", b"The engine keeps 31 %.")
        (self.folder / "docs").mkdir()
        self.write("docs/toy.json", b'{"transfer": 0.3104}')
        table = self.write(
            "docs/claims.yaml", f"toy:\n  kept: docs\n  claims:\n    {claim}".encode()
        )
        program = str(BENCHMARK / "claims.py")
        process = self.run_command(sys.executable, program, "--table", table, "--cheap")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("1 same, 0 DIFFERS, 0 measured outside", process.stdout)
        self.write("docs/toy.json", b'{"transfer": 0.33}')
        process = self.run_command(sys.executable, program, "--table", table, "--cheap")
        self.assertEqual(process.returncode, 1, process.stderr)

    def test_results_are_kept_and_used_again(self) -> None:
        kept = ("--out", str(self.folder / "kept"))
        for content in ('{"transfer": 0.31, "transfer_interval": [0.3, 0.32]}', "{}"):
            code, text = self.claims(content=content, arguments=kept)
            self.assertEqual(code, 0, text)

    def test_some_by_name(self) -> None:
        code, text = self.claims(content="{}", arguments=("outside.more",))
        self.assertEqual(code, 0, text)
        self.assertIn("0 same, 0 DIFFERS, 1 measured outside", text)
        code, text = self.claims(content="{}", arguments=("--cheap",))
        self.assertEqual(code, 0, text)
        self.assertIn("0 same, 0 DIFFERS, 0 measured outside", text)
        code, text = self.claims(arguments=("nothing",))
        self.assertEqual(code, 2, text)
        self.assertIn("claim nothing: unknown", text)
