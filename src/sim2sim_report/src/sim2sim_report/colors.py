# SPDX-License-Identifier: BSD-3-Clause
"""The palette as pages and figures use it: CSS variables, and a color for each world."""

from typing import Dict

from pusht_task.palette import DARK, LIGHT, PRINT

from sim2sim_report.results import ENGINE, REFERENCE, REPLAY

# Figures are drawn in the light colors; inline() makes each the variable of its name.
INK, DIM, GRID, CARD = (LIGHT[name] for name in ("ink", "dim", "grid", "card"))
COLORS = {"reference": LIGHT["reference"], ENGINE: LIGHT["engine"], REPLAY: LIGHT["replay"]}
SERIES = [color for name, color in LIGHT.items() if name.startswith("series")]  # for any eye
VARIABLES = {
    color: f"var(--{name}, {color})"  # the color itself where a page may have no styles
    for name, color in LIGHT.items()
    if name not in ("paper", "line")
}

# Tables are dark in every theme, as in rviz.
ON_TABLE = {REFERENCE: DARK["reference"], ENGINE: DARK["engine"], REPLAY: DARK["replay"]}


def css() -> str:
    """`--NAME` for each color of a theme, and `--dark-NAME` for what is dark in every theme."""
    dark = {f"dark-{name}": color for name, color in DARK.items()}
    return (
        f"{_rule({**dark, **LIGHT})}"
        f"@media (prefers-color-scheme: dark) {{ {_rule({name: DARK[name] for name in LIGHT})}}}\n"
        f"@media print {{ {_rule(PRINT)}}}\n"
    )


def _rule(colors: Dict[str, str]) -> str:
    return ":root { " + " ".join(f"--{name}: {color};" for name, color in colors.items()) + " }\n"
