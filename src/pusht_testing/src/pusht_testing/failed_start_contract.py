# SPDX-License-Identifier: BSD-3-Clause
"""The contract of a node of this suite that fails at start."""

import rosgraph  # type: ignore[import]
import rospy  # type: ignore[import]
from diagnostic_msgs.msg import DiagnosticStatus  # type: ignore[import]

from pusht_testing.served import BAD_REQUEST, ServedCase


class FailedStartContract(ServedCase):
    """A node that fails at start stays alive to say so.

    ~exit_code is the one it must tell, ~message a regular expression to be found in its message.
    """

    subject = "node"

    @classmethod
    def setUpClass(cls) -> None:
        cls.find()

    def test_describe_tells_the_error(self) -> None:
        description = self.call("describe")
        self.assertFalse(description.success)
        self.assertEqual(description.exit_code, rospy.get_param("~exit_code", BAD_REQUEST))
        self.assertRegex(description.message, rospy.get_param("~message", "."))
        self.assertNotIn("\n", description.message)
        self.assertTrue(description.instance_id)

    def test_nothing_else_is_served(self) -> None:
        _, _, services = rosgraph.Master(rospy.get_name()).getSystemState()
        served = {name for name, _ in services}
        self.assertIn(f"{self.namespace}/describe", served)
        for name in ("reset", "step", "configure", "act"):
            self.assertNotIn(f"{self.namespace}/{name}", served)

    def test_diagnostics(self) -> None:
        self.assert_healthy(DiagnosticStatus.ERROR)
