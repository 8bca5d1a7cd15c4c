# SPDX-License-Identifier: BSD-3-Clause
"""What the policy nodes of this suite do besides the contract of every policy."""

from pusht_task.testing.policy_contract import PolicyContract


class OwnPolicyContract(PolicyContract):
    """What every policy must do, in our words, and what ours do besides."""

    words_are_ours = True

    def test_version_is_known(self) -> None:
        self.assertTrue(self.call("describe").version)

    def test_diagnostics(self) -> None:
        self.assert_healthy()
