# SPDX-License-Identifier: BSD-3-Clause
"""Measures the suite against its targets, in one run on one machine, and says which are met.

Ratios count; seconds depend on the machine. Source the workspace first, and let nothing else run.
"""

import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict

from live_runs import live
from programs import callable_over_command, json_of, numpy_rate, peak_memory, pieces, start_up, tool
from pusht_task.command import OneLineParser, run_command, say
from pusht_task.error import Error, ExitCode
from pusht_task.json_file import write_json
from pusht_task.machine import cpu_model
from targets import figures, table


def measure(episodes: int) -> Dict[str, Any]:
    before = os.getloadavg()
    announce("the protocol")
    protocol = json_of([*tool("benchmark_protocol"), "--episodes", str(episodes)])
    announce("its pieces")
    result: Dict[str, Any] = {"protocol": protocol, "pieces_per_second": pieces()}
    announce("the engine in numpy")
    result["numpy_control_steps_per_second"] = {
        "free": numpy_rate("--free"),
        "contact": numpy_rate("--contact"),
    }
    announce("start and memory")
    result["start_up_seconds"] = start_up()
    few, many = 100, 2000
    memory = {str(count): peak_memory(count) for count in (few, many)}
    result["peak_memory_bytes"] = memory
    result["memory_per_episode_bytes"] = (memory[str(many)] - memory[str(few)]) / (many - few)
    announce("a callable of Python")
    result["callable_over_command"] = callable_over_command(1000)
    announce("the nodes")
    result["live"] = live()
    result["machine"] = {
        "cpu": cpu_model(),
        "cores": len(os.sched_getaffinity(0)),
        "system": platform.platform(),
        "load_before": before,
        "load_after": os.getloadavg(),
    }
    return result


def announce(what: str) -> None:
    print(f"measuring {what} ...", file=sys.stderr, flush=True)


def main() -> int:
    parser = OneLineParser(prog="bench", description=__doc__)
    parser.add_argument("--episodes", type=int, default=50, help="of the protocol (default: 50)")
    parser.add_argument(
        "--out", type=Path, default=Path("results", "benchmark.json"), help="JSON file"
    )
    args = parser.parse_args()

    def work() -> None:
        try:
            result = measure(args.episodes)
        except (RuntimeError, subprocess.CalledProcessError) as error:
            raise Error(str(error), ExitCode.RUNTIME_FAULT) from None
        rows = figures(result)
        result["figures"] = [{**row._asdict(), "verdict": row.verdict} for row in rows]
        args.out.parent.mkdir(parents=True, exist_ok=True)
        write_json(args.out, result)
        say(table(rows))
        say(f"results: {args.out}")

    return run_command("bench", work)


if __name__ == "__main__":
    sys.exit(main())
