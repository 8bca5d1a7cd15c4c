# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a measurement, what they are to reach, and the table that says whether they do."""

from typing import Any, Dict, List, NamedTuple, Optional, Tuple

Interval = Tuple[float, float]


class Figure(NamedTuple):
    """A figure as measured, and its target."""

    name: str
    meaning: str
    measured: Optional[float]
    unit: str
    at_least: Optional[float] = None
    at_most: Optional[float] = None
    interval: Optional[Interval] = None  # 95 %, where a single run says little

    @property
    def verdict(self) -> str:
        """Undecided if the interval holds the bound, or keeps it but is wider than it."""
        if self.measured is None or (self.at_least is None and self.at_most is None):
            return ""
        low, high = self.interval or (self.measured, self.measured)
        kept = {self.keeps(low), self.keeps(high)}
        if kept == {False}:
            return "NOT MET"
        too_wide = self.at_most is not None and high - low > self.at_most
        return "undecided" if len(kept) > 1 or too_wide else "met"

    def keeps(self, value: float) -> bool:
        return (self.at_least is None or value >= self.at_least) and (
            self.at_most is None or value <= self.at_most
        )


def kinds(rate: Dict[str, float]) -> List[Figure]:
    """Speed of each installed kind on the actions of the reference, and the time of its resets."""
    rows: List[Figure] = []
    for piece in sorted(rate):
        if piece.startswith("kind/"):
            name = piece[len("kind/") :]
            ratio = rate[piece] / rate["mujoco/bare"]
            reset = 1e6 / rate["reset/" + name]
            rows += [
                Figure("", name, rate[piece], "control steps/s"),
                Figure("", f"{name} over bare mj_step", ratio, "x"),
                Figure("", f"{name}, reset", reset, "us", at_most=50.0),
            ]
    return rows


def figures(result: Dict[str, Any]) -> List[Figure]:
    ratios = result["protocol"]["ratios"]
    rate = result["pieces_per_second"]
    numpy = result["numpy_control_steps_per_second"]
    policy = "policy/" + result["protocol"]["instruction_set"]
    steps = "control steps/s"
    episode = result["live"]["episode_seconds"]
    share = result["live"]["recording_share"]
    return [
        Figure(
            "P1",
            "protocol over bare mj_step",
            ratios["protocol_over_bare_mj_step"],
            "x",
            None,
            1.35,
        ),
        Figure("P2", "one thread over two", ratios["one_thread_over_two"], "x", 1.8),
        Figure(
            "P3",
            "further parameter value over the first",
            ratios["further_parameter_value_over_first"],
            "x",
            None,
            0.25,
        ),
        Figure("P4", "engine, in contact", rate["engine/contact/1"], steps, 250e3),
        Figure("P4", "engine, free", rate["engine/free/0"], steps, 2e6),
        Figure("P4", "engine in lanes, in contact", rate["engine_lanes/contact/1"], steps, 1e6),
        Figure("P4", "engine in lanes, free", rate["engine_lanes/free/0"], steps, 5e6),
        Figure(
            "P5",
            "MuJoCo world over bare mj_step",
            rate["mujoco/bare"] / rate["mujoco/world"],
            "x",
            None,
            1.02,
        ),
        Figure(
            "",
            "faithful engine over bare mj_step",
            rate["faithful/world"] / rate["mujoco/bare"],
            "x",
            5.0,
        ),
        *kinds(rate),
        Figure("P6", "policy, one row at a time", rate[policy + "/1"], "rows/s", 60e3),
        Figure("P6", "policy, batches of 16", rate[policy + "/16"], "rows/s", 110e3),
        Figure("P7", "allocations in a control step (a test)", None, ""),
        Figure(
            "P8",
            "episode of 300 steps through the nodes",
            episode["median"],
            "s",
            None,
            0.080,
            episode["interval"],
        ),
        Figure(
            "P9",
            "recording, of the time",
            share["seconds"]["median"],
            "",
            None,
            0.05,
            share["seconds"]["interval"],
        ),
        Figure(
            "",
            "recording, of the evaluator's processor time",
            share["processor_seconds"]["median"],
            "",
            interval=share["processor_seconds"]["interval"],
        ),
        Figure(
            "",
            "recording, of all nodes' processor time",
            share["all_processor_seconds"]["median"],
            "",
            interval=share["all_processor_seconds"]["interval"],
        ),
        Figure("P10", "start beyond an empty program", result["start_up_seconds"], "s", None, 0.3),
        Figure(
            "P11",
            "memory for each further episode",
            result["memory_per_episode_bytes"],
            "bytes",
            None,
            2000,
        ),
        Figure(
            "P12",
            "policy in Python over the command",
            result["callable_over_command"],
            "x",
            None,
            2.0,
        ),
        Figure("", "libtorch over the kernel, whole protocol", ratios["libtorch_over_kernel"], "x"),
        Figure(
            "", "engine over numpy, in contact", rate["engine/contact/1"] / numpy["contact"], "x"
        ),
        Figure("", "engine over numpy, free", rate["engine/free/0"] / numpy["free"], "x"),
        Figure(
            "",
            "engine in lanes over numpy, in contact",
            rate["engine_lanes/contact/1"] / numpy["contact"],
            "x",
        ),
        Figure("", "service call", result["live"]["service_round_trip_seconds"], "s"),
        Figure("", "bag", rate["bag/write"], "messages/s"),
    ]


def number(value: Optional[float]) -> str:
    if value is None:
        return ""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def table(rows: List[Figure]) -> str:
    lines = [f"{'':5}{'':46}{'measured':>12}  {'':17}{'95 %':18}{'to reach':>12}"]
    for row in rows:
        goal = f">= {number(row.at_least)}" if row.at_least is not None else ""
        goal = f"<= {number(row.at_most)}" if row.at_most is not None else goal
        interval = f"[{', '.join(map(number, row.interval))}]" if row.interval else ""
        head = f"{row.name:5}{row.meaning:46}{number(row.measured):>12}  {row.unit:17}"
        lines.append((head + f"{interval:18}{goal:>12}  {row.verdict}").rstrip())
    return "\n".join(lines)
