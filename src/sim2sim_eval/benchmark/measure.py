# SPDX-License-Identifier: BSD-3-Clause
"""Measures the suite against what it is to reach, in one run on one machine, and says what was met.

Ratios count, seconds depend on the machine. Needs the workspace sourced and nothing else running.
"""

import argparse
import contextlib
import json
import os
import platform
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional

PATIENCE = 60.0  # [s] for nodes to appear
LIVE_EPISODES = 50


class Figure(NamedTuple):
    """What is to be reached, and what was."""

    name: str
    meaning: str
    measured: Optional[float]
    unit: str
    at_least: Optional[float] = None
    at_most: Optional[float] = None

    @property
    def met(self) -> Optional[bool]:
        if self.measured is None:
            return None
        return (self.at_least is None or self.measured >= self.at_least) and (
            self.at_most is None or self.measured <= self.at_most
        )


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


def peak_memory(episodes: int) -> int:
    """[bytes] of a comparison, at its peak."""
    with tempfile.TemporaryDirectory() as folder:
        run = [executable("compare"), "--overwrite", "--out", folder, "--episodes", str(episodes)]
        process = subprocess.Popen(run, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            raise RuntimeError(f"compare ended with {status}")
        return usage.ru_maxrss * 1024


@contextlib.contextmanager
def nodes(*arguments: str) -> Iterator[None]:
    """The launch file without rviz, with a master of its own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
    launch = ["roslaunch", "--port", port, "sim2sim_eval", "compare.launch", "rviz:=false"]
    process = subprocess.Popen(
        [*launch, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def live_episode(record: bool) -> float:
    """[s] for an episode of the whole horizon through the nodes."""
    with tempfile.TemporaryDirectory() as out:
        run = ["policy:=fresh-untrained", f"episodes:={LIVE_EPISODES}", f"record:={record}"]
        with nodes(*run, f"out:={out}", "overwrite:=true"):
            watcher = subprocess.run(
                [sys.executable, __file__, "--watch"], stdout=subprocess.PIPE, check=True
            )
    return float(watcher.stdout)


def watch() -> float:
    """[s] between the ends of two episodes of the run that is under way."""
    import rospy  # type: ignore[import]
    from pusht_msgs.msg import EpisodeResult  # type: ignore[import]

    ends: Dict[int, float] = {}
    done = threading.Event()

    def note(result: EpisodeResult) -> None:
        ends[result.episode] = time.perf_counter()
        if result.episode == LIVE_EPISODES - 1:
            done.set()

    until_master_answers()
    rospy.init_node("watcher", anonymous=True, disable_signals=True)
    rospy.Subscriber("/sim2sim/episode", EpisodeResult, note)
    if not done.wait(PATIENCE):
        raise RuntimeError("the live run does not end")
    first, last = min(ends), max(ends)
    return (ends[last] - ends[first]) / (last - first)


def live() -> Dict[str, float]:
    """Seconds of an episode through the nodes; the share that recording takes; a service call."""
    pairs = [(live_episode(record=False), live_episode(record=True)) for _ in range(3)]
    with nodes("start:=false"):
        until_node_answers("/engine")
        call = pieces("service/round_trip")["service/round_trip"]
    return {
        "episode_seconds": statistics.median(bare for bare, _ in pairs),
        "recording_share": statistics.median(recorded / bare - 1.0 for bare, recorded in pairs),
        "service_round_trip_seconds": 1.0 / call,
    }


def until(holds: Callable[[], bool], what: str) -> None:
    begin = time.monotonic()
    while not holds():
        if time.monotonic() - begin > PATIENCE:
            raise RuntimeError(f"no {what}")
        time.sleep(0.05)


def until_master_answers() -> None:
    import rosgraph  # type: ignore[import]

    until(rosgraph.is_master_online, "master")


def until_node_answers(name: str) -> None:
    info = ["rosservice", "info", f"{name}/describe"]

    def answers() -> bool:
        return (
            subprocess.run(info, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
            == 0
        )

    until(answers, name)


def measure(episodes: int) -> Dict[str, Any]:
    before = os.getloadavg()
    say("the protocol")
    protocol = json_of([*tool("benchmark_protocol"), "--episodes", str(episodes)])
    say("its pieces")
    result: Dict[str, Any] = {"protocol": protocol, "pieces_per_second": pieces()}
    say("the engine in numpy")
    result["numpy_control_steps_per_second"] = {
        "free": numpy_rate("--free"),
        "contact": numpy_rate("--contact"),
    }
    say("start and memory")
    result["start_up_seconds"] = start_up()
    few, many = 100, 2000
    memory = {str(count): peak_memory(count) for count in (few, many)}
    result["peak_memory_bytes"] = memory
    result["memory_per_episode_bytes"] = (memory[str(many)] - memory[str(few)]) / (many - few)
    say("the nodes")
    result["live"] = live()
    result["machine"] = {
        "cpu": cpu_name(),
        "cores": len(os.sched_getaffinity(0)),
        "system": platform.platform(),
        "load_before": before,
        "load_after": os.getloadavg(),
    }
    return result


def cpu_name() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def figures(result: Dict[str, Any]) -> List[Figure]:
    ratios = result["protocol"]["ratios"]
    rate = result["pieces_per_second"]
    numpy = result["numpy_control_steps_per_second"]
    policy = "policy/" + result["protocol"]["instruction_set"]
    steps = "control steps/s"
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
            "further knob value over the first",
            ratios["further_knob_value_over_first"],
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
        Figure("P6", "policy, one row at a time", rate[policy + "/1"], "rows/s", 60e3),
        Figure("P6", "policy, batches of 16", rate[policy + "/16"], "rows/s", 110e3),
        Figure("P7", "allocations in a control step (a test)", None, ""),
        Figure(
            "P8",
            "episode of 300 steps through the nodes",
            result["live"]["episode_seconds"],
            "s",
            None,
            0.080,
        ),
        Figure("P9", "recording, of the time", result["live"]["recording_share"], "", None, 0.05),
        Figure("P10", "start beyond an empty program", result["start_up_seconds"], "s", None, 0.3),
        Figure(
            "P11",
            "memory for each further episode",
            result["memory_per_episode_bytes"],
            "bytes",
            None,
            2000,
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
    lines = [f"{'':5}{'':42}{'measured':>12}  {'':17}{'to reach':>12}"]
    for row in rows:
        goal = f">= {number(row.at_least)}" if row.at_least is not None else ""
        goal = f"<= {number(row.at_most)}" if row.at_most is not None else goal
        verdict = "" if not goal or row.met is None else "  met" if row.met else "  NOT MET"
        head = f"{row.name:5}{row.meaning:42}{number(row.measured):>12}  {row.unit:17}"
        lines.append((head + f"{goal:>12}{verdict}").rstrip())
    return "\n".join(lines)


def say(what: str) -> None:
    print(f"measuring {what} ...", file=sys.stderr, flush=True)


def write(path: Path, content: Dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(path.name + ".part")
    aside.write_text(json.dumps(content, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    aside.replace(path)


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("--episodes", type=int, default=50, help="of the protocol (default: 50)")
    parser.add_argument(
        "--out", type=Path, default=Path("results", "benchmark.json"), help="JSON file"
    )
    parser.add_argument("--watch", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.watch:
        print(watch())
        return 0
    try:
        result = measure(args.episodes)
        rows = figures(result)
        result["figures"] = [row._asdict() for row in rows]
        write(args.out, result)
    except (OSError, RuntimeError, subprocess.CalledProcessError) as error:
        print(f"bench: {error}", file=sys.stderr)
        return 4
    print(table(rows))
    print(f"results: {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
