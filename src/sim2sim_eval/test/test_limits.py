#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Commands at the limits that a shell sets, and with command lines that are mistyped."""

import os
import shlex
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import List

from command_case import CommandCase, executable

ATTRIBUTE = executable("sim2sim_eval", "attribute")
COMPARE = executable("sim2sim_eval", "compare")
DEMONSTRATE = executable("sim2sim_eval", "demonstrate")
MERGE = executable("sim2sim_eval", "merge")
PLOT = executable("sim2sim_eval", "plot_sweep")
REPORT = executable("sim2sim_eval", "report")
SWEEP = executable("sim2sim_eval", "sweep")
TRAIN = executable("pusht_policy", "train")
RUN = ("--episodes", "2", "--threads", "1")


class LimitCase(CommandCase):
    def shell(
        self, before: str, *command: str, after: str = ""
    ) -> "subprocess.CompletedProcess[str]":
        """Runs a command of ours from a shell that has set limits."""
        return self.run_command("bash", "-c", f"{before}; exec {shlex.join(command)} {after}")

    def assert_finished_or_fault(
        self, process: "subprocess.CompletedProcess[str]", out: str
    ) -> bool:
        """Either the results, or exit code 4 with one line and a status that says so."""
        folder = self.folder / out
        if process.returncode == 0:
            self.assertEqual(process.stderr, "")
            self.assertEqual(self.load(out, "status.json")["exit_code"], 0)
            return True
        self.assert_one_line(process, 4, "compare")
        self.assertFalse((folder / "metrics.json").exists())
        if folder.exists():
            self.assertEqual(self.load(out, "status.json")["exit_code"], 4)
        return False


class Memory(LimitCase):
    def test_a_policy_is_loaded_or_named(self) -> None:
        outcomes: List[bool] = []
        for megabytes in (250, 700, 3000):
            with self.subTest(megabytes):
                out = f"out-{megabytes}"
                process = self.shell(
                    f"ulimit -v {megabytes}000", COMPARE, "--policy", "bc", *RUN, "--out", out
                )
                outcomes.append(self.assert_finished_or_fault(process, out))
        self.assertFalse(outcomes[0])
        self.assertTrue(outcomes[-1])

    def test_many_threads_are_a_fault_of_the_run(self) -> None:
        for megabytes in (100, 150, 200, 300):
            with self.subTest(megabytes):
                out = f"out-{megabytes}"
                run = ("--policy", "expert", "--episodes", "1000", "--threads", "100")
                process = self.shell(f"ulimit -v {megabytes}000", COMPARE, *run, "--out", out)
                self.assertFalse(self.assert_finished_or_fault(process, out))

    def test_python_does_not_wait_for_memory_of_its_libraries(self) -> None:
        """Where there is more than the least, the command is refused for what it is to read."""
        train = (TRAIN, "--bag", "no", "--out", "x.pt")
        for command, needed in (((REPORT, "none"), 300), ((PLOT, "none"), 300), (train, 800)):
            for megabytes in (100, 150, 200, 260, needed):
                with self.subTest(command=command[0], megabytes=megabytes):
                    process = self.shell(f"ulimit -v {megabytes}000", *command)
                    self.assert_one_line(process, 4, Path(command[0]).name)
                    self.assertIn(f"memory: {needed} MB more are needed", process.stderr)
            process = self.run_command(*command)
            self.assert_one_line(process, 2, Path(command[0]).name)


class Files(LimitCase):
    def test_few_files_are_a_fault_of_the_run(self) -> None:
        for policy in ("expert", "bc"):
            for count in (4, 5, 15, 16):
                with self.subTest(f"{policy}, {count}"):
                    out = f"{policy}-{count}"
                    run = ("--policy", policy, *RUN, "--out", out)
                    process = self.shell(f"ulimit -n {count}", COMPARE, *run)
                    self.assertEqual(self.assert_finished_or_fault(process, out), count == 16)

    def test_attribution_is_whole_or_absent(self) -> None:
        grid = "{servo: [false, true], drag: [false, true]}"
        plan = f"{{policy: expert, episodes: 20, horizon: 20, engine: rigid_body, grid: {grid}}}"
        self.write("plan.yaml", plan.encode())
        process = self.run_command(SWEEP, "plan.yaml", "--out", "sweep")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        before = self.files("sweep")
        process = self.shell("ulimit -f 3", ATTRIBUTE, "sweep")
        self.assert_one_line(process, 4, "attribute")
        self.assertIn("cannot write sweep/attribution.json: File too large", process.stderr)
        self.assertEqual(self.files("sweep"), before)
        for arguments in ((), ("--overwrite",)):
            process = self.run_command(ATTRIBUTE, "sweep", *arguments)
            self.assertEqual((process.returncode, process.stderr), (0, ""))
        process = self.run_command(ATTRIBUTE, "sweep")
        self.assert_one_line(process, 2, "attribute")
        self.assertIn("sweep/attribution.csv: is there already", process.stderr)

    def test_python_names_the_file_that_cannot_grow(self) -> None:
        self.write("plan.yaml", b"{policy: expert, episodes: 2, grid: {block_damp: [2, 20]}}")
        process = self.run_command(SWEEP, "plan.yaml", "--out", "sweep")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        demonstrate = (DEMONSTRATE, "--episodes", "2", "--out", "two.bag")
        self.assertEqual(self.run_command(*demonstrate).returncode, 0)
        train = (TRAIN, "--bag", "two.bag", "--out", "two.pt", "--epochs", "1", "--threads", "1")
        temporary = tempfile.gettempdir()  # where rosbag writes modules
        for command, file, limit in (
            ((PLOT, "sweep"), "sweep/sweep.png", 10),
            ((REPORT, "sweep"), "sweep/report.html", 10),
            (train, temporary, 1),
            (train, "two.pt.training/state.pt", 100),
        ):
            with self.subTest(file):
                process = self.shell(f"ulimit -f {limit}", *command)
                name = Path(command[0]).name
                self.assertEqual(process.returncode, 4, process.stderr)
                self.assertEqual(process.stderr, f"{name}: {file}: File too large\n")
                self.assertFalse((self.folder / file).is_file())
                if file.startswith("sweep"):
                    process = self.shell("true", *command, after="> /dev/full")
                    self.assert_one_line(process, 4, name)
                    self.assertIn("stdout: No space left on device", process.stderr)


class ClosedStreams(LimitCase):
    def test_commands_work(self) -> None:
        self.write("plan.yaml", b"{policy: expert, episodes: 2, rows: [{}, {block_damp: 20}]}")
        compare = (COMPARE, "--policy", "bc", *RUN)  # tries it out in a copy of the process
        sweep = (SWEEP, "plan.yaml", "--threads", "1")
        for name, command in (("compare", compare), ("sweep", sweep)):
            whole = self.run_command(*command, "--out", name)
            self.assertEqual((whole.returncode, whole.stderr), (0, ""))
            for number, closed in enumerate((">&-", "2>&-", "<&-", ">&- 2>&-", "<&- >&- 2>&-")):
                with self.subTest(f"{name} {closed}"):
                    out = f"{name}-{number}"
                    process = self.shell("true", *command, "--out", out, after=closed)
                    self.assertEqual((process.returncode, process.stderr), (0, ""))
                    found, wanted = (
                        {
                            str(file.relative_to(self.folder / folder)): file.read_bytes()
                            for file in (self.folder / folder).rglob("*")
                            if file.is_file()
                        }
                        for folder in (out, name)
                    )
                    self.assertEqual(found, wanted)

    def test_failure_keeps_its_code(self) -> None:
        for closed in (">&- 2>&-", "<&- >&- 2>&-"):
            process = self.shell(
                "true", COMPARE, "--policy", "none.pt", "--out", "out", after=closed
            )
            self.assertEqual((process.returncode, process.stderr), (2, ""))
            self.assertFalse((self.folder / "out").exists())


class CommandLine(LimitCase):
    def test_mistyped_option_is_answered_with_the_nearest(self) -> None:
        for argument, said in {
            "--epsiodes": "--epsiodes: there is no such option; did you mean --episodes?",
            "--polcy=bc": "--polcy: there is no such option; did you mean --policy?",
            "--block_dump": "did you mean --block_damp?",
            "--over-write": "did you mean --overwrite?",
            "--velocity": "--velocity: there is no such option; --help lists what there is",
        }.items():
            process = self.run_command(COMPARE, argument, "5", "--out", "out")
            self.assert_one_line(process, 2, "compare")
            self.assertIn(said, process.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_empty_names_are_refused(self) -> None:
        self.write("plan.yaml", b"{policy: expert, episodes: 1, rows: [{}]}")
        for command in (
            *((COMPARE, option) for option in ("--out", "--starts", "--write-starts")),
            (COMPARE, "--reference-cache"),
            *((SWEEP, "plan.yaml", option) for option in ("--out", "--shard")),
            (SWEEP,),
            (MERGE,),
            (ATTRIBUTE,),
            (executable("sim2sim_eval", "contrast"), "sweep", "--out"),
            (executable("sim2sim_eval", "demonstrate"), "--out"),
            (executable("sim2sim_eval", "plan"),),
            (executable("sim2sim_eval", "recompute"),),
        ):
            with self.subTest(command):
                process = self.run_command(*command, "")
                self.assert_one_line(process, 2, os.path.basename(command[0]))
                self.assertIn("must not be empty", process.stderr)
        self.assertEqual(self.files("."), {"plan.yaml"})


if __name__ == "__main__":
    unittest.main()
