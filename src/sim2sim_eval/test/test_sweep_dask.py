#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""sweep_dask as a user meets it: the bytes of a plain sweep, whatever happens to its workers."""

import json
import os
import re
import select
import shutil
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List

import torch
from catkin.find_in_workspaces import find_in_workspaces  # type: ignore[import]
from pusht_testing.long_tests import LONG

DEADLINE = 120  # s, for one command
SHARDS = 6
SMALL = ("--workers", "1", "--shards", "2")  # enough where no worker takes the place of another

CONFIG = """
policy: expert
episodes: 6
horizon: 40
grid: {block_damp: [2, 6]}
"""

POLICIES = """
policies:
- expert
- {{files: "{folder}/small-*.ts.pt", group: small}}
episodes: 5
horizon: 150
engine: [chipmunk, two_mass]
"""

# Instead of rosrun: the first shard tells which worker runs it, and ends only with it.
STOP_FIRST_SHARD = """#!/bin/sh
if [ "$2" = sweep ] && mkdir {folder}/begun 2>/dev/null; then
  exec 3>{folder}/started
  echo $PPID >&3
  read -r _ <{folder}/never
fi
exec {rosrun} "$@"
"""

# Command that fails shard 1 so many times.
FAIL_SHARD = """#!/bin/sh
case "$*" in
  *"--shard 1/"*)
    for try in {tries}; do
      mkdir {folder}/try-$try 2>/dev/null && echo "sweep: disk full" >&2 && exit 4
    done
esac
exec {rosrun} "$@"
"""


def executable(name: str) -> str:
    """An executable of the package, in the devel or the install space."""
    found: List[str] = find_in_workspaces(["libexec"], "sim2sim_eval", name, first_match_only=True)
    assert found, f"sim2sim_eval has no executable {name}"
    return found[0]


MATRIX = executable("matrix")
SWEEP = executable("sweep")
SWEEP_DASK = executable("sweep_dask")


class SweepDask(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name, "results")
        self.hooks = Path(folder.name, "hooks")
        self.policies = Path(folder.name, "policies")
        for each in (self.folder, self.hooks, self.policies):
            each.mkdir()
        self.config(CONFIG)

    def test_policies_in_a_plan(self) -> None:
        """Results and matrix are those of a plain sweep."""
        for seed in range(2):
            self.small_policy(f"small-{seed}.ts.pt", seed)
        self.config(POLICIES.format(folder=self.policies))
        self.finish(self.start("--shards", "3"))
        self.plain_sweep()
        self.assertEqual(self.result_bytes("out"), self.result_bytes("plain"))
        of_dask, of_plain = self.matrix("out"), self.matrix("plain")
        self.assertEqual(of_dask, of_plain)
        policies = json.loads(of_dask[0])["policies"]
        self.assertEqual([policy["group"] for policy in policies], ["", "small", "small"])
        self.assertGreater(policies[0]["cells"][1]["successes"], 0)

    def test_worker_that_is_killed(self) -> None:
        started = self.stop_first_shard()
        process = self.start()
        worker = int(self.read(started))
        os.kill(worker, signal.SIGKILL)
        self.assertEqual(self.read(started), b"", "the command must end with its worker")
        self.finish(process)
        self.assert_plain_bytes()

    def test_interrupt(self) -> None:
        for number in (signal.SIGTERM, signal.SIGINT)[: 2 if LONG else 1]:
            started = self.stop_first_shard()
            process = self.start(*SMALL)
            self.read(started)
            process.send_signal(number)
            self.assertIn("interrupted", self.fail_with(4, process))
            self.assertEqual(self.read(started), b"", "no command may be left")
            self.hooks.joinpath("begun").rmdir()

    def test_command_that_refuses_its_input(self) -> None:
        self.config("rows: [{block_damp: -1}]")
        line = self.fail_with(2, self.start(*SMALL))
        self.assertRegex(line, r"shard \d/2: sweep: .*block_damp -1")

    def test_transient_failure_is_tried_again_twice(self) -> None:
        self.hook(FAIL_SHARD, tries="1 2")
        self.finish(self.start(*SMALL))
        self.assert_plain_bytes()
        shutil.rmtree(self.folder / "out")
        self.hook(FAIL_SHARD, tries="3 4 5")
        line = self.fail_with(4, self.start(*SMALL))
        self.assertRegex(line, "sweep-dask: shard 1/2: sweep: disk full; finished shards are kept")

    def test_bad_arguments(self) -> None:
        for arguments, named in (
            (["--shards", "0"], "'0': must be an integer of at least 1"),
            (["--workers", "two"], "'two': must be an integer"),
            (["--scheduler", "nowhere"], "'nowhere': must be tcp://HOST:PORT"),
        ):
            self.assertIn(named, self.fail_with(2, self.start(*arguments)))
        self.folder.joinpath("sweep.yaml").unlink()
        self.assertIn("sweep.yaml: No such file", self.fail_with(2, self.start()))

    def test_results_are_not_overwritten_unless_told_to(self) -> None:
        """The status of a run that was refused is no result."""
        out = self.folder / "out"
        out.mkdir()
        status = {"format": 1, "exit_code": 2, "reason": "refused", "rows_finished": 0}
        out.joinpath("status.json").write_text(json.dumps(status))
        self.finish(self.start(*SMALL))
        self.assert_plain_bytes()
        before = self.result_bytes("out")
        process = self.start()
        _, line = process.communicate(timeout=DEADLINE)
        self.assertEqual(process.returncode, 2, line)
        self.assertIn("holds results (sweep.json)", line)
        self.assertEqual(self.result_bytes("out"), before)
        self.config(CONFIG + "seed: 1\n")
        self.finish(self.start("--overwrite", *SMALL))
        self.assertNotEqual(self.result_bytes("out"), before)
        self.folder.joinpath("out", "metrics.json").write_text("of a run")
        process = self.start("--overwrite")
        _, line = process.communicate(timeout=DEADLINE)
        self.assertEqual(process.returncode, 2, line)
        self.assertIn("holds results (metrics.json); name another folder\n", line)

    def config(self, text: str) -> None:
        self.folder.joinpath("sweep.yaml").write_text(text)

    def small_policy(self, name: str, seed: int) -> None:
        torch.manual_seed(seed)
        layers = (torch.nn.Linear(10, 8), torch.nn.ReLU(), torch.nn.Linear(8, 2), torch.nn.Tanh())
        torch.jit.script(torch.nn.Sequential(*layers)).save(str(self.policies / name))

    def hook(self, script: str, **values: str) -> None:
        """Puts `script` before rosrun."""
        rosrun = self.hooks / "rosrun"
        rosrun.write_text(script.format(folder=self.hooks, rosrun=shutil.which("rosrun"), **values))
        rosrun.chmod(0o755)

    def stop_first_shard(self) -> int:
        """Gives what tells its worker, and then its end."""
        self.hook(STOP_FIRST_SHARD)
        for name in ("started", "never"):
            if not self.hooks.joinpath(name).exists():
                os.mkfifo(self.hooks / name)
        started = os.open(self.hooks / "started", os.O_RDONLY | os.O_NONBLOCK)
        self.addCleanup(os.close, started)
        return started

    def read(self, pipe: int) -> bytes:
        readable, _, _ = select.select([pipe], [], [], DEADLINE)
        self.assertTrue(readable, "nothing came in time")
        return os.read(pipe, 100)

    def start(self, *arguments: str) -> "subprocess.Popen[str]":
        command = [SWEEP_DASK, "sweep.yaml", "--out", "out", *arguments]
        for name, value in (("--workers", "2"), ("--shards", str(SHARDS))):
            if name not in command and "--scheduler" not in command:
                command += [name, value]
        process = subprocess.Popen(
            command,
            cwd=self.folder,
            env={**os.environ, "PATH": f"{self.hooks}:{os.environ['PATH']}"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def finish(self, process: "subprocess.Popen[str]") -> None:
        """A sweep that must succeed, and leave nothing but its results."""
        _, said = process.communicate(timeout=DEADLINE)
        self.assertEqual((process.returncode, said), (0, ""))
        self.assert_files("out", "sweep.yaml")

    def fail_with(self, code: int, process: "subprocess.Popen[str]") -> str:
        """The one line of a sweep that must fail, and leave nothing but finished shards."""
        _, line = process.communicate(timeout=DEADLINE)
        self.assertEqual(process.returncode, code, line)
        self.assertEqual(line.count("\n"), 1, line)
        self.assertTrue(line.startswith("sweep-dask: "), line)
        kept = re.search(r"; finished shards are kept for `merge` in (.*)\n", line)
        if kept:
            for shard in Path(kept[1]).iterdir():
                self.assertEqual(json.loads((shard / "status.json").read_text())["exit_code"], 0)
            shutil.rmtree(kept[1])
        self.assert_files("sweep.yaml")
        return line

    def assert_files(self, *names: str) -> None:
        found = {path.name for path in self.folder.iterdir()} | {"sweep.yaml"}
        self.assertEqual(found, {*names, "sweep.yaml"})

    def assert_plain_bytes(self) -> None:
        self.plain_sweep()
        self.assertEqual(self.result_bytes("out"), self.result_bytes("plain"))
        shutil.rmtree(self.folder / "plain")

    def plain_sweep(self) -> None:
        """Runs the sweep in one process, into the folder plain."""
        self.run_command(SWEEP, "sweep.yaml", "--out", "plain", "--threads", "1")

    def matrix(self, out: str) -> List[bytes]:
        """Files of the matrix of a sweep."""
        self.run_command(MATRIX, out)
        return [(self.folder / out / name).read_bytes() for name in ("matrix.json", "matrix.csv")]

    def run_command(self, *command: str) -> None:
        """Runs a command that must succeed."""
        subprocess.run(
            command,
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            timeout=DEADLINE,
            check=True,
        )

    def result_bytes(self, out: str) -> Dict[str, bytes]:
        """What the determinism contract covers."""
        folder = self.folder / out
        files = [folder / "sweep.csv", folder / "sweep.json", *folder.glob("rows/*/*")]
        self.assertGreater(len(files), 4)
        return {str(file.relative_to(folder)): file.read_bytes() for file in files}


if __name__ == "__main__":
    unittest.main()
