# SPDX-License-Identifier: BSD-3-Clause
"""Programs that are measured by themselves: their rates, their start, their memory."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, List


def tool(name: str) -> List[str]:
    return ["rosrun", "sim2sim_eval", name]


def json_of(command: List[str]) -> Dict[str, Any]:
    content: Dict[str, Any] = json.loads(
        subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
    )
    return content


def pieces(pattern: str = "") -> Dict[str, float]:
    """Items per second of each piece: control steps, rows, messages, calls."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "pieces.json")
        filters = [f"--benchmark_filter={pattern}"] if pattern else []
        options = ["--benchmark_repetitions=3", "--benchmark_report_aggregates_only=true"]
        subprocess.run(
            [*tool("benchmark_pieces"), *options, *filters]
            + [f"--benchmark_out={out}", "--benchmark_out_format=json"],
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        found = json.loads(out.read_text())["benchmarks"]
    return {
        entry["run_name"].replace("/real_time", ""): entry["items_per_second"]
        for entry in found
        if entry.get("aggregate_name") == "median" and "items_per_second" in entry
    }


def numpy_rate(scenario: str) -> float:
    """Control steps per second of the engine as a user would write it in numpy."""
    script = Path(__file__).resolve().parents[2] / "pusht_engine" / "test" / "numpy_two_mass.py"
    return float(json_of([sys.executable, str(script), scenario])["control_steps_per_second"])


def seconds_of(command: List[str]) -> float:
    begin = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begin


def executable(name: str) -> str:
    found = subprocess.run(
        ["catkin_find", "--first-only", "--libexec", "sim2sim_eval", name],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    return found.stdout.strip()


def start_up() -> float:
    """[s] from start to end of a run of two times 40 steps, beyond an empty program."""
    compare, empty = executable("compare"), executable("linked_to_libtorch")
    differences = []
    with tempfile.TemporaryDirectory() as folder:
        run = [compare, "--smoke", "--overwrite", "--threads", "1", "--out", folder]
        for _ in range(7):
            differences.append(seconds_of(run) - seconds_of([empty]))
    return statistics.median(differences)


CALLABLE = """
import sim2sim
policy = sim2sim.load_policy("bc")
sim2sim.compare(lambda observations: policy(observations), episodes={episodes}, threads=1)
"""


def callable_over_command(episodes: int) -> float:
    """Time of a comparison with the shipped policy as a callable of Python, over the command's."""
    command = [executable("compare"), "--overwrite", "--threads", "1", "--episodes", str(episodes)]
    called = [sys.executable, "-c", CALLABLE.format(episodes=episodes)]
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(3):  # in turn
            ratios.append(seconds_of(called) / seconds_of([*command, "--out", folder]))
    return statistics.median(ratios)


def peak_memory(episodes: int) -> int:
    """[bytes] of a comparison, at its peak."""
    with tempfile.TemporaryDirectory() as folder:
        run = [executable("compare"), "--overwrite", "--out", folder, "--episodes", str(episodes)]
        process = subprocess.Popen(run, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            raise RuntimeError(f"compare ended with {status}")
        return usage.ru_maxrss * 1024
