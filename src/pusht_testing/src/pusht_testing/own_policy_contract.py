# SPDX-License-Identifier: BSD-3-Clause
"""The contract of this suite's policy nodes, beyond that of every policy."""

from pusht_testing.policy_contract import PolicyContract


class OwnPolicyContract(PolicyContract):
    """The contract of every policy, in the words of this suite, and what its nodes add."""

    words_are_ours = True

    def test_version_is_known(self) -> None:
        self.assertTrue(self.call("describe").version)

    def test_diagnostics(self) -> None:
        self.assert_healthy()
