# SPDX-License-Identifier: BSD-3-Clause
"""The colors of everything that is drawn, from palette.json. C++ has DARK as palette.hpp."""

import json
from pathlib import Path
from typing import Dict

_PALETTE: Dict[str, Dict[str, str]] = json.loads(
    Path(__file__).with_name("palette.json").read_text(encoding="utf-8")
)

DARK = _PALETTE["dark"]  # rviz, its panel, and pages and tables on a dark background
LIGHT = _PALETTE["light"]  # pages and figures on a light background
PRINT = {**LIGHT, **_PALETTE["print"]}  # pages on paper
