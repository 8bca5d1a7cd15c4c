# SPDX-License-Identifier: BSD-3-Clause
"""Runs over nodes: the time of an episode, the shares that recording takes."""

import contextlib
import ctypes
import math
import os
import socket
import statistics
import subprocess
import tempfile
import time
import xmlrpc.client
from typing import Any, Callable, Dict, Iterator, List, NamedTuple

from programs import pieces

PATIENCE = 60.0  # [s] for nodes to appear, and for a run over them
NODES = ("sim2sim", "reference", "engine", "engine_replay", "policy")
RECORDING_PAIRS = 40  # pairs of live runs, one recorded, one not
LIVE_EPISODES = 5  # in each of them


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


class LiveRun(NamedTuple):
    """Times of a live run of untrained, hence whole, episodes."""

    seconds: float  # time from goal to result
    episode_seconds: float  # time from the end of an episode to that of the next
    processor_seconds: float  # processor time of the evaluator
    all_processor_seconds: float  # processor time of all nodes


class LiveRuns:
    """Runs over nodes that stay, one after the other."""

    def __init__(self, folder: str) -> None:
        import actionlib  # type: ignore[import]
        import rospy  # type: ignore[import]
        from pusht_msgs.msg import CompareAction, EpisodeResult  # type: ignore[import]

        self._folder = folder
        self._ends: List[float] = []  # [s] ends of the episodes of the run under way
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
