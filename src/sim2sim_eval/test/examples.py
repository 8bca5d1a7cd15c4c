#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The examples in Python keep the contract of every simulator and policy, and that of this suite.

Each contract runs as a user runs it, against the nodes of one launch.
"""

from pusht_testing.nodes import run

from command_case import CommandCase, executable


class Examples(CommandCase):
    def assert_kept(self, contract: str, *parameters: str) -> None:
        process = self.run_command(executable("pusht_testing", contract), "--text", *parameters)
        said = process.stdout + process.stderr
        self.assertEqual(process.returncode, 0, said)
        self.assertRegex(said, r"Ran [1-9]\d* tests?")

    def test_simulator(self) -> None:
        for contract in ("simulator_contract", "own_simulator_contract"):
            with self.subTest(contract):
                self.assert_kept(contract, "_simulator:=quasi_static")

    def test_policy(self) -> None:
        for contract in ("policy_contract", "own_policy_contract"):
            with self.subTest(contract):
                self.assert_kept(contract, "_policy:=by_hand")

    def test_policy_with_a_memory(self) -> None:
        self.assert_kept("own_policy_contract", "_policy:=by_hand_with_memory", "_memory:=true")

    def test_value_that_is_refused(self) -> None:
        self.assert_fails_at_start("bad_value", "^characteristic_length -1.0: must be in")

    def test_unknown_parameter(self) -> None:
        node = "simulators/unknown_parameter"
        known = "known: .*characteristic_length"
        self.assert_fails_at_start(node, f"/{node}/characteristic_lenght.*: unknown; {known}")

    def assert_fails_at_start(self, node: str, message: str) -> None:
        self.assert_kept("failed_start_contract", f"_node:={node}", f"_message:='{message}'")


run(Examples)
