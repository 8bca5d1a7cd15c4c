#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Policies with a memory, with chunks and with noise: the same bytes however a run is made."""

import unittest
from pathlib import Path
from typing import Dict, Tuple

import rospkg  # type: ignore[import]
from pusht_testing.long_tests import LONG

from command_case import CommandCase, executable

COMPARE = executable("sim2sim_eval", "compare")
MERGE = executable("sim2sim_eval", "merge")
RECOMPUTE = executable("sim2sim_eval", "recompute")
SWEEP = executable("sim2sim_eval", "sweep")
SHIPPED = Path(rospkg.RosPack().get_path("pusht_policy"), "policies")
OPTIONS: Dict[str, Tuple[str, ...]] = {  # of a run with each kind
    "gru": (),
    "chunk": ("--execute", "4"),
    "flow": ("--execute", "8", "--repeats", "2"),
}
SHORT = ("--episodes", "4", "--horizon", "60")


class KindsOfPolicy(CommandCase):
    def compare(self, name: str, out: str, *arguments: str) -> str:
        policy = str(SHIPPED / f"{name}.ts.pt")
        return self.run_all((COMPARE, "--policy", policy, *SHORT, *arguments, "--out", out))

    def test_same_bytes_over_threads_lanes_cache_bag_and_shards(self) -> None:
        for name in OPTIONS if LONG else ("gru", "flow"):
            options = OPTIONS[name]
            with self.subTest(name):
                one, two, cached, again = (f"{name}_{way}" for way in ("1", "2", "kept", "bag"))
                self.compare(name, one, *options, "--threads", "1", "--record")
                for out in (two, cached):
                    self.compare(
                        name, out, *options, "--threads", "2", "--reference-cache", "cache"
                    )
                self.run_all((RECOMPUTE, f"{one}/compare.bag", "--out", again))
                for out in (two, cached, again):
                    self.assertEqual(self.result_bytes(out), self.result_bytes(one), out)
                self.shards(name, options)
                merged = self.folder / f"{name}_merged" / "rows" / "000" / "episodes.csv"
                self.assertEqual(
                    merged.read_bytes(), (self.folder / one / "episodes.csv").read_bytes()
                )

    def shards(self, name: str, options: Tuple[str, ...]) -> None:
        """Runs the same episodes in two shards, and merges them."""
        words = (*SHORT, *options)
        lines = [f"{option[2:]}: {value}" for option, value in zip(words[::2], words[1::2])]
        lines += [f"policy: {SHIPPED / name}.ts.pt", "grid: {block_damp: [6.0]}"]
        self.write(f"{name}.yaml", "\n".join(lines).encode())
        shards = [f"{name}_{number}_of_2" for number in (1, 2)]
        for number, shard in enumerate(shards, 1):
            self.run_all((SWEEP, f"{name}.yaml", "--shard", f"{number}/2", "--out", shard))
        self.run_all((MERGE, *shards, "--out", f"{name}_merged"))

    def test_noise_is_of_the_seed_and_of_nothing_else(self) -> None:
        text = self.compare("flow", "first")
        self.compare("flow", "again")
        self.assertEqual(self.result_bytes("again"), self.result_bytes("first"))
        self.compare("flow", "other", "--noise-seed", "1")
        self.assertNotEqual(self.result_bytes("other"), self.result_bytes("first"))
        self.assertIn("The policy draws random numbers, and each start was played once", text)

    def test_number_of_executed_actions_changes_a_run(self) -> None:
        self.compare("chunk", "four", "--execute", "4")
        self.compare("chunk", "eight", "--execute", "8")
        self.assertNotEqual(self.result_bytes("four"), self.result_bytes("eight"))


if __name__ == "__main__":
    unittest.main()
