# SPDX-License-Identifier: BSD-3-Clause
"""Long forms of tests, which repeat an experiment over more seeds, kinds or episodes.

Every run of the tests has time for the short form, which checks the same.
"""

import os
import unittest

LONG: bool = "PUSHT_LONG_TESTS" in os.environ  # set by script/test --long

long_form = unittest.skipUnless(LONG, "long form: script/test --long")
