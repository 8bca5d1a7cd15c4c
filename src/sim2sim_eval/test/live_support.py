# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of live runs share: commands, launches, results, and ways to wait for events."""

import csv
import json
import os
import random
import re
import resource
import signal
import socket
import subprocess
import tempfile
import threading
import time
import xmlrpc.client
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Tuple

import actionlib  # type: ignore[import]
import rosgraph  # type: ignore[import]
import rospy  # type: ignore[import]
from actionlib_msgs.msg import GoalStatus  # type: ignore[import]
from command_case import CommandCase, executable
from pusht_msgs.msg import (  # type: ignore[import]
    CompareAction,
    CompareActionFeedback,
    CompareGoal,
)
from pusht_msgs.srv import Control, Describe  # type: ignore[import]
from pusht_testing.nodes import DEADLINE, Inbox, sends, until

RESULTS = {
    *("metrics.json", "statistics.json", "episodes.csv", "divergence.csv"),
    *("provenance.json", "status.json"),
}
RECORDED_RESULTS = RESULTS | {"compare.bag"}
UNFINISHED = RESULTS - {"metrics.json", "statistics.json", "divergence.csv"}
ROLLOUTS = 5  # three modes and the floor
CALLER = "/live_test"
WORLDS = ["reference", "engine", "engine_replay"]
NODES = [*WORLDS, "policy"]
BATCHES: Dict[Tuple[str, ...], bytes] = {}  # what `compare` said to these arguments, which stays so


class LiveCase(CommandCase):
    """Commands and launches."""

    deadline = DEADLINE

    def succeed(self, *command: str, **named: Any) -> str:
        """What a command that must succeed prints."""
        process = self.run_command(*command, **named)
        self.assertEqual(process.returncode, 0, process.stderr)
        return process.stdout

    def batch_bytes(self, *arguments: str) -> bytes:
        """The results of `compare`, which needs no nodes."""
        if arguments not in BATCHES:
            out = Path(tempfile.mkdtemp(dir=self.folder))
            compare = executable("sim2sim_eval", "compare")
            self.succeed(compare, *arguments, "--out", str(out))
            BATCHES[arguments] = result_bytes(out)
        return BATCHES[arguments]

    def open_display(self, screen: str = "1366x768x24") -> str:
        """A virtual screen."""
        command = ("Xvfb", "-displayfd", "1", "-screen", "0", screen, "-nolisten", "tcp")
        _, number = Process(self, *command).line(r"^\d+$")
        return f":{number.strip()}"

    def assert_recomputed(self, out: Path) -> None:
        """The results in `out` are those of the bag beside them."""
        again = Path(tempfile.mkdtemp(dir=self.folder))
        bag = str(out / "compare.bag")
        recompute = executable("sim2sim_eval", "recompute")
        self.succeed(recompute, bag, "--out", str(again))
        self.assertEqual(result_bytes(again), result_bytes(out))

    def assert_not_whole(self, out: Path, reason: str, bag: bool = True) -> Dict[str, Any]:
        """What a run leaves that a fault ended: the finished episodes, and why; its status."""
        status = status_of(out)
        self.assertEqual(status["exit_code"], 4)
        self.assertRegex(status["reason"], reason)
        self.assertEqual(files(out), UNFINISHED | ({"compare.bag"} if bag else set()))
        episodes = [int(row["episode"]) for row in rows(out)]
        self.assertEqual(sorted(set(episodes)), list(range(status["episodes_finished"])))
        self.assertEqual(len(episodes), ROLLOUTS * status["episodes_finished"])
        self.assertLess(status["episodes_finished"], status["episodes"])
        return status


def result_bytes(out: Path) -> bytes:
    """What the determinism contract covers."""
    return b"".join((out / name).read_bytes() for name in ("metrics.json", "episodes.csv"))


def status_of(out: Path) -> Dict[str, Any]:
    return status_of_file(out / "status.json")


def status_of_file(path: Path) -> Dict[str, Any]:
    status: Dict[str, Any] = json.loads(path.read_text())
    return status


def metrics_of(out: Path) -> Dict[str, Any]:
    metrics: Dict[str, Any] = json.loads((out / "metrics.json").read_text())
    return metrics


def rows(out: Path) -> List[Dict[str, str]]:
    """Rows of episodes.csv."""
    with (out / "episodes.csv").open() as file:
        return list(csv.DictReader(file))


def files(out: Path) -> Set[str]:
    return {file.name for file in out.iterdir()}


def free_port() -> int:
    """One below those that the system hands out by itself: it is still free when it is used."""
    first = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
    while True:
        port = random.randrange(first // 2, first)
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) != 0:
                return port


def pid_of(node: str, master_uri: Optional[str] = None) -> int:
    """The process id of a node."""
    uri = rosgraph.Master(CALLER, master_uri=master_uri).lookupNode(node)
    with xmlrpc.client.ServerProxy(uri) as proxy:
        answer: Any = proxy.getPid(CALLER)
        return int(answer[2])


def answers(master_uri: str) -> bool:
    """Whether there is a master."""
    try:
        return bool(rosgraph.Master(CALLER, master_uri=master_uri).getPid())
    except OSError:
        return False


class Process:
    """A process whose lines can be waited for. Ended with the test."""

    def __init__(
        self,
        test: LiveCase,
        *command: str,
        environment: Optional[Dict[str, str]] = None,
        file_limit: Optional[int] = None,  # [bytes]
    ) -> None:
        def prepare() -> None:
            if file_limit is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (file_limit, file_limit))

        self._lines: List[Tuple[float, str]] = []
        self._changed = threading.Condition()
        self._ended = False
        self._process = subprocess.Popen(
            command,
            cwd=test.folder,
            # roslaunch would keep its lines to itself until there are many.
            env={**os.environ, "PYTHONUNBUFFERED": "1", **(environment or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            preexec_fn=prepare,
        )
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        test.addCleanup(self._clean_up)

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            with self._changed:
                self._lines.append((time.monotonic(), line))
                self._changed.notify_all()
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def output(self) -> str:
        with self._changed:
            return "".join(line for _, line in self._lines)

    def line(self, pattern: str, deadline: float = DEADLINE) -> Tuple[float, str]:
        """The first line that matches, and when [s, monotonic] it came."""

        def found() -> Optional[Tuple[float, str]]:
            return next((line for line in self._lines if re.search(pattern, line[1])), None)

        with self._changed:
            self._changed.wait_for(lambda: found() or self._ended, deadline)
            line = found()
        if line is None:
            raise TimeoutError(f"'{pattern}' is not in:\n{self.output}")
        return line

    def ended(self, deadline: float = DEADLINE) -> int:
        """Waits for the end; the exit code."""
        try:
            code = self._process.wait(deadline)
        except subprocess.TimeoutExpired as late:
            raise TimeoutError(f"runs on after {deadline} s:\n{self.output}") from late
        self._reader.join(deadline)
        return code

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def _clean_up(self) -> None:
        if self._process.poll() is None:
            children = children_of(self.pid)
            self.interrupt()
            try:
                self._process.wait(DEADLINE)
            except subprocess.TimeoutExpired:
                for pid in [self.pid, *children]:
                    kill(pid, signal.SIGKILL)
                self._process.wait(DEADLINE)
        self._reader.join(DEADLINE)
        assert self._process.stdout
        self._process.stdout.close()


def children_of(pid: int) -> List[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def kill(pid: int, number: int) -> None:
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


class OwnMaster(LiveCase):
    """Nodes of a master that only this test knows."""

    environment: Dict[str, str]

    def use_own_master(self) -> str:
        """URI of the master that is to be started."""
        uri = f"http://127.0.0.1:{free_port()}"
        self.environment = {
            "ROS_MASTER_URI": uri,
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(self.folder / "ros"),
            "PWD": str(self.folder),
        }
        return uri

    def start_master(self) -> str:
        """URI of a master that runs."""
        uri = self.use_own_master()
        core = Process(self, "roscore", "-p", uri.split(":")[-1], environment=self.environment)
        core.line(r"started core service \[/rosout\]")
        return uri


def text_of(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def connected(service: str, service_type: Any) -> Any:
    """A service that is there. The connection lasts: others may break (ros_comm issue 1976)."""
    rospy.wait_for_service(service, DEADLINE)
    return rospy.ServiceProxy(service, service_type, persistent=True)


def describe(node: str) -> Any:
    service = connected(f"/{node}/describe", Describe)
    try:
        return service()
    finally:
        service.close()


def goal_of(engine_parameters: Sequence[Any] = (), **fields: Any) -> Any:
    """A goal says nothing of a field, or has one value of it, or several where that is a list."""
    values = {f: value if isinstance(value, list) else [value] for f, value in fields.items()}
    return CompareGoal(engine_parameters=engine_parameters, **values)


class Topic(Inbox):
    """Every message of a node from now on."""

    def __init__(self, name: str, message_type: Any, publisher: str = "/sim2sim") -> None:
        super().__init__(name, message_type)
        self._last = rospy.Time()
        until(lambda: sends(publisher, name), f"{name} from {publisher}")

    def forget(self, last: Any) -> None:
        """What is stamped `last` or before, though it may arrive later."""
        self._last = last

    def until(self, last: Callable[[Any], bool], deadline: float = DEADLINE) -> List[Any]:
        def fresh(message: Any) -> bool:
            return bool(message.header.stamp > self._last)

        messages = super().until(lambda message: fresh(message) and last(message), deadline)
        return list(filter(fresh, messages))


class GoalCase(LiveCase):
    """Sends goals to an evaluator that runs already."""

    client: Any
    control: Any
    # Not by the client: it drops what comes before the goal is known to it, or after the result.
    feedback: Topic

    @classmethod
    def setUpClass(cls) -> None:
        for node in NODES:
            describe(node)  # all have started
        cls.client = actionlib.SimpleActionClient("/sim2sim/compare", CompareAction)
        if not cls.client.wait_for_server(rospy.Duration(DEADLINE)):
            raise TimeoutError("/sim2sim/compare: no action server")
        cls.control = connected("/sim2sim/control", Control)
        cls.feedback = Topic("/sim2sim/compare/feedback", CompareActionFeedback)

    def setUp(self) -> None:
        super().setUp()
        self.out = self.folder / "out"
        self.addCleanup(self.end_run)

    def end_run(self) -> None:
        """Whatever a failed test has left under way."""
        self.accepted("resume")
        if self.client.get_state() in (GoalStatus.PENDING, GoalStatus.ACTIVE):
            self.client.cancel_goal()
            self.client.wait_for_result(rospy.Duration(DEADLINE))

    def accepted(self, command: str, rate: float = 0.0) -> None:
        response = self.control(command=command, rate=rate)
        self.assertTrue(response.success, response.message)

    def send(self, **fields: Any) -> None:
        self.feedback.forget(rospy.Time.now())
        self.client.send_goal(goal_of(**{"out": str(self.out), **fields}))

    def send_and_hold(self, episode: int, step: int, **fields: Any) -> None:
        """Sends a goal whose run stands still at that step, however long the test takes."""
        self.accepted("pause")
        self.send(**fields)
        self.go_on_to(episode, step)

    def go_on_to(self, episode: int, step: int) -> None:
        """Lets a paused run, whose last step has been heard of, take steps until it is there."""
        while self.next_feedback() < (episode, step):
            self.accepted("step")

    def cancel(self) -> None:
        """actionlib gives a goal up for lost if it is cancelled before its acknowledgement came."""
        until(lambda: self.client.get_state() != GoalStatus.PENDING, "an acknowledgement")
        self.client.cancel_goal()

    def result(self, state: int = GoalStatus.SUCCEEDED) -> Any:
        self.assertTrue(self.client.wait_for_result(rospy.Duration(DEADLINE)))
        result = self.client.get_result()
        self.assertEqual(self.client.get_state(), state, result.reason)
        return result

    def compare(self, **fields: Any) -> Any:
        self.send(**fields)
        return self.result()

    def next_feedback(self) -> Tuple[int, int]:
        """The next episode and step that the run tells of. It must be paced, lest some are lost."""
        (message,) = self.feedback.until(lambda _: True)
        at = message.feedback.divergence
        return at.episode, at.step
