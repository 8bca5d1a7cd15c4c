# SPDX-License-Identifier: BSD-3-Clause
"""Measures the suite against its targets, in one run on one machine, and says which are met.

Ratios count; seconds depend on the machine. Source the workspace first, and let nothing else run.
"""

import argparse
import contextlib
import ctypes
import json
import math
import os
import platform
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import xmlrpc.client
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

from pusht_task.files import write_file

PATIENCE = 60.0  # [s] for nodes to appear, and for a run over them
NODES = ("sim2sim", "reference", "engine", "engine_replay", "policy")
RECORDING_PAIRS = 40  # of live runs, one recorded, one not
LIVE_EPISODES = 5  # in each of them

Interval = Tuple[float, float]


class Figure(NamedTuple):
    """What is to be reached, and what was."""

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


class LiveRun(NamedTuple):
    """What a live run of untrained, hence whole, episodes takes."""

    seconds: float  # from goal to result
    episode_seconds: float  # from the end of an episode to that of the next
    processor_seconds: float  # of the evaluator
    all_processor_seconds: float  # of all nodes


class Processor:
    """The processor time of a node."""

    def __init__(self, node: str) -> None:
        import rosgraph  # type: ignore[import]

        uri = rosgraph.Master("/bench").lookupNode(node)
        with xmlrpc.client.ServerProxy(uri) as proxy:
            answer: Any = proxy.getPid("/bench")
        clock = ctypes.c_int()
        if ctypes.CDLL(None).clock_getcpuclockid(answer[2], ctypes.byref(clock)) != 0:
            raise RuntimeError(f"{node}: its processor time is not known")
        self._clock = clock.value

    @property
    def seconds(self) -> float:
        return time.clock_gettime(self._clock)


class LiveRuns:
    """Runs over nodes that stay, one after the other."""

    def __init__(self, folder: str) -> None:
        import actionlib  # type: ignore[import]
        import rospy  # type: ignore[import]
        from pusht_msgs.msg import CompareAction, EpisodeResult  # type: ignore[import]

        self._folder = folder
        self._ends: List[float] = []  # of the episodes of the run under way [s]
        rospy.init_node("bench", disable_signals=True)
        rospy.Subscriber(
            "/sim2sim/episode",
            EpisodeResult,
            lambda _: self._ends.append(time.perf_counter()),
            tcp_nodelay=True,
        )
        self._patience = rospy.Duration(PATIENCE)
        self._client = actionlib.SimpleActionClient("/sim2sim/compare", CompareAction)
        if not self._client.wait_for_server(self._patience):
            raise RuntimeError("no evaluator")
        self._processors = [Processor(f"/{node}") for node in NODES]

    def run(self, record: bool) -> LiveRun:
        from pusht_msgs.msg import CompareGoal

        goal = CompareGoal(
            episodes=[LIVE_EPISODES],
            out=[self._folder],
            overwrite=[True],
            record=[record],
            floor=[False],  # the three modes alone
        )
        self._ends.clear()
        before = [processor.seconds for processor in self._processors]
        begin = time.perf_counter()
        self._client.send_goal(goal)
        if not self._client.wait_for_result(self._patience):
            raise RuntimeError("the live run does not end")
        seconds = time.perf_counter() - begin
        result = self._client.get_result()
        if result.exit_code != 0:
            raise RuntimeError(f"the live run: {result.reason}")
        until(lambda: len(self._ends) == LIVE_EPISODES, "end of the last episode")
        used = [after.seconds - was for after, was in zip(self._processors, before)]
        each = (self._ends[-1] - self._ends[0]) / (LIVE_EPISODES - 1)
        return LiveRun(seconds, each, used[0], sum(used))


def median(values: List[float]) -> Dict[str, Any]:
    """The median and a 95 % interval for it, whatever the distribution.

    The interval of order statistics (Conover, Practical Nonparametric Statistics, 3.2): the number
    of values below the true median is binomial with p = 1/2.
    """
    ordered = sorted(values)
    count = len(ordered)
    rank, below = 0, 0.0
    while below + math.comb(count, rank) / 2**count <= 0.025:
        below += math.comb(count, rank) / 2**count
        rank += 1
    if rank == 0:
        raise ValueError(f"{count} values: too few for an interval")
    return {
        "median": statistics.median(ordered),
        "interval": (ordered[rank - 1], ordered[count - rank]),
        "range": (ordered[0], ordered[-1]),
        "values": count,
    }


def live() -> Dict[str, Any]:
    """An episode through the nodes [s]; the shares that recording takes; a service call [s]."""
    with tempfile.TemporaryDirectory() as folder, nodes("policy:=fresh-untrained", "start:=false"):
        until_master_answers()
        for name in NODES[1:]:
            until_node_answers(f"/{name}")
        runs = LiveRuns(folder)
        runs.run(record=True)  # not measured: whatever is done once is done
        bare: List[LiveRun] = []
        recorded: List[LiveRun] = []
        for pair in range(RECORDING_PAIRS):
            for record in (False, True) if pair % 2 == 0 else (True, False):
                (recorded if record else bare).append(runs.run(record))
        call = pieces("service/round_trip")["service/round_trip"]
    shares = {
        field: median([getattr(b, field) / getattr(a, field) - 1.0 for a, b in zip(bare, recorded)])
        for field in ("seconds", "processor_seconds", "all_processor_seconds")
    }
    return {
        "episode_seconds": median([run.episode_seconds for run in bare]),
        "recording_share": shares,
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
        Figure(
            "",
            "faithful engine over bare mj_step",
            rate["faithful/world"] / rate["mujoco/bare"],
            "x",
            5.0,
        ),
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


def say(what: str) -> None:
    print(f"measuring {what} ...", file=sys.stderr, flush=True)


def write(path: Path, content: Dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_file(path, (json.dumps(content, indent=2, sort_keys=True) + "\n").encode())


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("--episodes", type=int, default=50, help="of the protocol (default: 50)")
    parser.add_argument(
        "--out", type=Path, default=Path("results", "benchmark.json"), help="JSON file"
    )
    args = parser.parse_args()
    try:
        result = measure(args.episodes)
        rows = figures(result)
        result["figures"] = [{**row._asdict(), "verdict": row.verdict} for row in rows]
        write(args.out, result)
    except (OSError, RuntimeError, subprocess.CalledProcessError) as error:
        print(f"bench: {error}", file=sys.stderr)
        return 4
    print(table(rows))
    print(f"results: {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
