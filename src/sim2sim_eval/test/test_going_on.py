#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Interrupted runs and sweeps go on, and their results have the bytes of a run in one piece."""

import shutil
import signal
import subprocess
import unittest
from pathlib import Path
from typing import Dict, List, Tuple

import torch

from command_case import CommandCase, executable, until
from torch_policies import Endless

COMPARE = executable("sim2sim_eval", "compare")
SWEEP = executable("sim2sim_eval", "sweep")
JOURNAL = "episodes.journal"
RUN = ("--policy", "expert", "--episodes", "150")
PLAN = "{policy: expert, episodes: 150, rows: [{block_damp: 6}, {block_damp: 20}]}"


class GoingOn(CommandCase):
    def end_at(
        self, episodes: int, number: signal.Signals, command: List[str], journal: Path
    ) -> List[bytes]:
        """Ends a command with a signal once its journal has so many, and one of its own."""

        def finished() -> int:
            return journal.read_bytes().count(b"\n") - 1 if journal.exists() else -1

        before = max(finished(), episodes - 1)
        with subprocess.Popen(
            command,
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            until(lambda: finished() > before)
            process.send_signal(number)
            _, said = process.communicate(timeout=self.deadline)
        if number == signal.SIGKILL:
            self.assertEqual((process.returncode, said), (-number, ""))
        else:
            self.assertEqual(process.returncode, 4, said)
            self.assertIn("to continue, run the same command with --out out", said)
        content = journal.read_bytes()
        return content[: content.rfind(b"\n") + 1].splitlines()

    def results(self, out: str) -> Dict[str, bytes]:
        files = [file for file in (self.folder / out).rglob("*") if file.is_file()]
        return {str(file.relative_to(self.folder / out)): file.read_bytes() for file in files}


class Comparison(GoingOn):
    def compare(self, *arguments: str, out: str = "out") -> "subprocess.CompletedProcess[str]":
        return self.run_command(COMPARE, *arguments, "--out", out)

    def finished(self, *arguments: str, out: str = "out") -> Dict[str, bytes]:
        process = self.compare(*arguments, out=out)
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        return self.results(out)

    def interrupt(
        self, *arguments: str, episodes: int = 1, number: signal.Signals = signal.SIGKILL
    ) -> List[bytes]:
        command = [COMPARE, *arguments, "--out", "out"]
        return self.end_at(episodes, number, command, self.folder / "out" / JOURNAL)

    def test_run_goes_on_from_whatever_moment(self) -> None:
        whole = self.finished(*RUN, out="whole")
        before: List[bytes] = []
        moments: Tuple[Tuple[int, signal.Signals, str], ...] = (
            (0, signal.SIGKILL, "1"),
            (3, signal.SIGINT, "2"),
            (20, signal.SIGKILL, "2"),
            (40, signal.SIGTERM, "1"),
        )
        for episodes, number, threads in moments:
            lines = self.interrupt(*RUN, "--threads", threads, episodes=episodes, number=number)
            self.assertEqual(lines[: len(before)], before, "what is there stays")
            status = self.load("out", "status.json")
            self.assertEqual((status["exit_code"], status["episodes"]), (4, 150))
            self.assertFalse((self.folder / "out" / "metrics.json").exists())
            before = lines
        self.assertEqual(self.finished(*RUN), whole)

    def test_run_without_an_engine_goes_on(self) -> None:
        alone = (*RUN, "--engine", "none")
        whole = self.finished(*alone, out="whole")
        self.interrupt(*alone, episodes=5, number=signal.SIGUSR1)
        self.assertFalse((self.folder / "out" / "metrics.json").exists())
        self.assertEqual(self.finished(*alone), whole)

    def test_nothing_is_left_of_what_was_there_before(self) -> None:
        """Neither the report of the part of a run nor files that a killed process was writing."""
        whole = self.finished(*RUN, out="whole")
        self.interrupt(*RUN)
        left = ["report.html", *(f"{name}.part" for name in whole)]
        for name in (*left, "mine.part"):
            self.write(f"out/{name}", b"{")
        self.assertEqual(self.finished(*RUN), {**whole, "mine.part": b"{"})

    def test_status_stays_if_the_next_run_ends_while_it_loads(self) -> None:
        self.interrupt(*RUN, episodes=3, number=signal.SIGINT)
        before = self.results("out")
        torch.jit.script(Endless(-10.0, 10.0)).save(str(self.folder / "endless.pt"))
        command = [COMPARE, "--policy", "endless.pt", "--episodes", "150", "--out", "out"]
        with subprocess.Popen(
            command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as process:
            children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
            until(lambda: children.read_text() != "")
            process.send_signal(signal.SIGTERM)
            _, said = process.communicate(timeout=self.deadline)
        self.assertEqual(process.returncode, 4, said)
        self.assertEqual(self.results("out"), before)

    def test_line_in_which_it_was_killed_is_run_again(self) -> None:
        whole = self.finished(*RUN, out="whole")
        lines = self.interrupt(*RUN, episodes=2)
        journal = self.folder / "out" / JOURNAL
        for end in (b"", lines[0][:20], b"\n".join(lines)[:-30]):
            journal.write_bytes(end)
            shutil.copytree(self.folder / "out", self.folder / "again")
            self.assertEqual(self.finished(*RUN, out="again"), whole)
            shutil.rmtree(self.folder / "again")
        self.interrupt(*RUN, episodes=2)  # what it appends stands in lines of its own
        self.assertEqual(self.finished(*RUN), whole)

    def test_another_run_is_refused_by_name(self) -> None:
        self.interrupt(*RUN)
        before = self.results("out")
        for other, named in {
            "--seed 1": "/configuration/seed is 0, must be 1",
            "--block_damp 7": "/configuration/knobs/block_damp is 6.0, must be 7.0",
            "--reanchor 20": "/configuration/probes is",
            "--until-decided 0.5": "/configuration/until_decided is nothing, must be 0.5",
        }.items():
            process = self.compare(*RUN, *other.split())
            self.assert_one_line(process, 2, "compare")
            self.assertIn(f"out/{JOURNAL}: is of another run ({named}", process.stderr)
            self.assertEqual(self.results("out"), before)
        for recorded in ("--record", "--traces"):
            process = self.compare(*RUN, recorded)
            self.assert_one_line(process, 2, "compare")
            self.assertIn("holds results", process.stderr)
            self.assertEqual(self.results("out"), before)
        again = self.finished("--smoke", "--overwrite")
        self.assertEqual(again, self.finished("--smoke", out="fresh"))

    def test_damaged_journal_is_refused_by_line(self) -> None:
        lines = self.interrupt(*RUN, episodes=3)
        journal = self.folder / "out" / JOURNAL
        flipped = bytearray(lines[1])
        flipped[100] ^= 1
        for damaged, named in (
            ([lines[0], bytes(flipped), *lines[2:]], "line 2 is damaged"),
            ([b"?", *lines[1:]], "line 1 must say the format 3 and the run"),
            ([lines[0], lines[1], lines[1]], "line 3 has episode"),
        ):
            journal.write_bytes(b"\n".join(damaged) + b"\n")
            process = self.compare(*RUN)
            self.assert_one_line(process, 3, "compare")
            self.assertIn(f"journal out/{JOURNAL}: {named}", process.stderr)
            self.assertEqual(journal.read_bytes(), b"\n".join(damaged) + b"\n")

    def test_run_until_it_is_decided_goes_on(self) -> None:
        run = "--policy expert --episodes 3000 --engine mujoco --no-floor".split()
        run += ["--until-decided", "0.97"]
        whole = self.finished(*run, out="whole")
        self.assertGreater(self.load("whole", "metrics.json")["episodes"], 60)
        self.interrupt(*run, episodes=5)
        self.interrupt(*run, "--threads", "1", episodes=12, number=signal.SIGINT)
        self.assertEqual(self.finished(*run), whole)

    def test_starts_that_it_has_written_stay(self) -> None:
        run = (*RUN, "--write-starts", "starts.csv")
        self.interrupt(*run)
        starts = self.folder / "starts.csv"
        whole = starts.read_bytes()
        starts.write_bytes(b"mine")
        process = self.compare(*run)
        self.assert_one_line(process, 2, "compare")
        self.assertIn("write_starts starts.csv: is there already", process.stderr)
        starts.write_bytes(whole)
        self.finished(*run)
        self.assertEqual(starts.read_bytes(), whole)

    def test_recorded_run_says_that_it_begins_again(self) -> None:
        command = [COMPARE, *RUN, "--record", "--out", "out"]
        with subprocess.Popen(
            command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as process:
            until((self.folder / "out" / "compare.bag.part").exists)
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=self.deadline)
        self.assertEqual(process.returncode, 4, said)
        self.assertIn("a run with --record or --traces begins again: --overwrite --out out", said)
        self.assertFalse((self.folder / "out" / JOURNAL).exists())


class Sweep(GoingOn):
    def test_row_keeps_its_finished_episodes(self) -> None:
        self.write("plan.yaml", PLAN.encode())
        process = self.run_command(SWEEP, "plan.yaml", "--out", "whole")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        command = [SWEEP, "plan.yaml", "--out", "out"]
        row = self.folder / "out" / "rows" / "001"
        self.end_at(5, signal.SIGKILL, command, self.folder / "out" / "rows" / "000" / JOURNAL)
        before = self.end_at(5, signal.SIGKILL, command, row / JOURNAL)
        status = self.load("out", "status.json")
        self.assertEqual((status["exit_code"], status["rows_finished"]), (4, 1))
        lines = self.end_at(30, signal.SIGINT, [*command, "--threads", "1"], row / JOURNAL)
        self.assertEqual(lines[: len(before)], before)
        self.assertIn("in row 1 of 0 to 1, after", self.load("out", "status.json")["reason"])
        process = self.run_command(*command)
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        self.assertEqual(self.results("out"), self.results("whole"))

    def test_what_a_killed_process_has_left_is_removed(self) -> None:
        self.write("plan.yaml", PLAN.replace("150", "2").encode())
        for times in range(2):
            process = self.run_command(SWEEP, "plan.yaml", "--out", "out")
            self.assertEqual((process.returncode, process.stderr), (0, ""))
            for name in ("provenance.json.part", "status.json.part"):
                self.assertFalse((self.folder / "out" / name).exists(), times)
                self.write(f"out/{name}", b"{")


if __name__ == "__main__":
    unittest.main()
