# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of formats, from the table that C++ has too. A file without a number has format 1."""

import json
from pathlib import Path

_TABLE = json.loads(Path(__file__).with_name("formats.json").read_text("utf-8"))

DEMONSTRATION_FORMAT = int(_TABLE["demonstrations"])  # of a bag, as its origin says
PROVENANCE_FORMAT = int(_TABLE["checkpoint_provenance"])  # of CHECKPOINT.provenance.json
DESCRIPTION_FORMAT = int(_TABLE["policy_description"])  # of policy.json in a checkpoint
STATE_FORMAT = int(_TABLE["training_state"])  # of state.pt
