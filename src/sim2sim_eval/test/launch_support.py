# SPDX-License-Identifier: BSD-3-Clause
"""Launches of a file of tests, on a master that they share.

A `Launch` is the user's own: roslaunch, with a launch file. A `Start` starts the nodes of the same
file by itself, with the parameters and arguments that the file gives them, in a fraction of the
time. What roslaunch does (it ends with the evaluator, hands on signals, starts a node again) shows
in a `Launch` only.
"""

import atexit
import functools
import os
import shlex
import signal
import socket
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Optional, Set, Tuple
from unittest import mock
from urllib.parse import urlparse

import actionlib  # type: ignore[import]
import rosgraph  # type: ignore[import]
import roslaunch  # type: ignore[import]
import roslib.packages  # type: ignore[import]
import rospkg  # type: ignore[import]
import rospy  # type: ignore[import]
from pusht_msgs.msg import CompareAction  # type: ignore[import]
from pusht_msgs.srv import Control  # type: ignore[import]

from live_support import (
    CALLER,
    DEADLINE,
    LiveCase,
    Process,
    answers,
    connected,
    free_port,
    goal_of,
    kill,
    pid_of,
    status_of,
    text_of,
    until,
)

LAUNCHES = Path(rospkg.RosPack().get_path("sim2sim_eval")) / "launch"
ROLES = ("reference", "engine")
WORDS = {"bc", "expert", "planner", "fresh-untrained"}  # policies that are no files


class Node(NamedTuple):
    """A node of a launch file."""

    command: Tuple[str, ...]
    parameters: Tuple[Tuple[str, Any], ...]
    key: Any  # what it is: two nodes with the same key can stand for each other


def configuration(path: Path, *arguments: str) -> Any:
    """What roslaunch reads in a launch file."""
    config = roslaunch.config.ROSLaunchConfig()
    loader = roslaunch.xmlloader.XmlLoader()
    loader.load(str(path), config, argv=list(arguments), verbose=False)
    return config


def parameters_of(path: Path, *arguments: str) -> Dict[str, Any]:
    """Parameters that a launch file sets."""
    found = configuration(path, *arguments).params
    return {name: parameter.value for name, parameter in found.items()}


@functools.lru_cache(maxsize=None)
def node_file(package: str, node_type: str) -> str:
    """The file that roslaunch would run."""
    found: List[str] = roslib.packages.find_node(package, node_type)
    assert found, f"{package} has no node {node_type}"
    return found[0]


def environment_of(test: LiveCase, uri: str, display: str = "") -> Dict[str, str]:
    """The environment of a user who stands in the folder of the test."""
    return {
        "ROS_MASTER_URI": uri,
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(test.folder / "ros"),
        "ROS_LOG_DIR": str(test.folder / "ros"),
        "DISPLAY": display,
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "PWD": str(test.folder),
    }


def listens(uri: str) -> bool:
    """Whether there is still a process at the address of a node."""
    address = urlparse(uri)
    with socket.socket() as probe:
        return probe.connect_ex((address.hostname, address.port)) == 0


def end(process: "subprocess.Popen[bytes]") -> None:
    """Interrupts a process, and waits for its end."""
    if process.poll() is None:
        process.send_signal(signal.SIGCONT)
        process.send_signal(signal.SIGINT)
    try:
        process.wait(DEADLINE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait(DEADLINE)


class SharedMaster:
    """A master with rosout, and the nodes of the last `Start` for the next one that wants the same.

    This process is a node of it, too.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.uri = f"http://127.0.0.1:{free_port()}"
        # rospy reads these when it begins.
        os.environ.update(
            ROS_MASTER_URI=self.uri, ROS_IP="127.0.0.1", ROS_LOG_DIR=self._folder.name
        )
        self._core = [subprocess.Popen(("rosmaster", "--core", "-p", self.uri.split(":")[-1]))]
        atexit.register(self._end)
        until(lambda: answers(self.uri), "a master")
        self._core.append(subprocess.Popen((node_file("rosout", "rosout"), "__name:=rosout")))
        self._nodes: Dict[str, Tuple[Any, "subprocess.Popen[bytes]"]] = {}
        self._master = rosgraph.Master(CALLER, master_uri=self.uri)
        rospy.init_node(CALLER[1:], argv=[], disable_signals=True)

    def _end(self) -> None:
        rospy.signal_shutdown("the tests are over")
        self.end_nodes()
        for process in reversed(self._core):
            end(process)

    def start(self, nodes: Dict[str, Node], environment: Dict[str, str]) -> None:
        """Starts those nodes that are not there yet; ends the others, and forgets all of theirs."""
        for name, (key, process) in list(self._nodes.items()):
            if name not in nodes or nodes[name].key != key or process.poll() is not None:
                end(self._nodes.pop(name)[1])
        self.forget(keep=set(self._nodes))
        for name in nodes.keys() - self._nodes.keys():
            for parameter, value in nodes[name].parameters:
                self._master.setParam(parameter, value)
            process = subprocess.Popen(nodes[name].command, env={**os.environ, **environment})
            self._nodes[name] = nodes[name].key, process

    def end_nodes(self) -> None:
        """Ends all of them."""
        for _, process in self._nodes.values():
            kill(process.pid, signal.SIGINT)
        for _, process in self._nodes.values():
            end(process)
        self._nodes.clear()

    def _uri_of(self, name: str) -> str:
        """Empty if the node has just said that it ends."""
        try:
            return str(self._master.lookupNode(name))
        except rosgraph.MasterError:
            return ""

    def forget(self, keep: Set[str]) -> None:
        """Forgets who has ended without a word, and all parameters but those of some nodes."""
        publishers, subscribers, services = self._master.getSystemState()
        names = {n for kind in (publishers, subscribers, services) for _, ns in kind for n in ns}
        for name in names:
            uri = self._uri_of(name)
            if uri and not listens(uri):
                lost = rosgraph.Master(name, master_uri=self.uri)
                for topic in (topic for topic, ns in publishers if name in ns):
                    lost.unregisterPublisher(topic, uri)
                for topic in (topic for topic, ns in subscribers if name in ns):
                    lost.unregisterSubscriber(topic, uri)
                for service in (service for service, ns in services if name in ns):
                    lost.unregisterService(service, self._master.lookupService(service))
        for name in self._master.getParam("/"):
            if f"/{name}" not in keep:
                self._master.deleteParam(f"/{name}")


@functools.lru_cache(maxsize=None)
def shared_master() -> SharedMaster:
    """That of this process."""
    return SharedMaster()


class Run(Process):
    """An evaluator on the shared master, under way or waiting for goals, with results in `out`."""

    out: Path
    uri: str
    environment: Dict[str, str]
    _test: LiveCase

    def tool(self, *command: str) -> str:
        """What a command prints that must succeed in the run's environment."""
        return self._test.succeed(*command, environment=self.environment)

    def first(self, topic: str) -> Any:
        """Waits for a message."""
        return rospy.wait_for_message(topic, rospy.AnyMsg, DEADLINE)

    def control(self, command: str, **fields: Any) -> None:
        """Calls ~control of the evaluator, as soon as it is there."""
        service = connected("/sim2sim/control", Control)
        answer = service(command=command, **fields)
        service.close()
        self._test.assertTrue(answer.success, answer.message)

    def send_goal(self, **fields: Any) -> Any:
        """Sends a goal to the evaluator, as soon as it is there; the client."""
        client = actionlib.SimpleActionClient("/sim2sim/compare", CompareAction)
        self._test.assertTrue(client.wait_for_server(rospy.Duration(DEADLINE)))
        client.send_goal(goal_of(**fields))
        return client

    def node(self, name: str) -> int:
        """Process id of a node."""
        return pid_of(name, self.uri)

    def status(self) -> Dict[str, Any]:
        return status_of(self.out)


class Launch(Run):
    """The user's own launch of compare.launch; headless."""

    def __init__(
        self,
        test: LiveCase,
        parameters: Optional[Dict[str, Any]] = None,  # set beside those of compare.launch
        beside: str = "",  # what else is in the user's launch file
        display: str = "",  # none
        master_uri: str = "",  # of a master that runs already; empty: the launch's own
        **arguments: Any,
    ) -> None:
        self._test = test
        self.out = test.folder / str(arguments.setdefault("out", "out"))
        self.uri = master_uri or f"http://127.0.0.1:{free_port()}"
        self.environment = environment_of(test, self.uri, display)
        launch = ["sim2sim_eval", "compare.launch"]
        if parameters is not None or beside:
            launch = [extended_launch(test.folder, arguments, parameters or {}, beside)]
        given = [f"{name}:={text_of(value)}" for name, value in arguments.items()]
        port = [] if master_uri else ["-p", self.uri.split(":")[-1]]
        command = ("roslaunch", *port, *launch, *given)
        super().__init__(test, *command, environment=self.environment)


class SharedLaunch(Launch):
    """A launch on the shared master; without rviz, if that is not given."""

    def __init__(self, test: LiveCase, **arguments: Any) -> None:
        master = shared_master()
        master.end_nodes()
        master.forget(keep=set())
        arguments.setdefault("rviz", False)
        super().__init__(test, master_uri=master.uri, **arguments)


class Start(Run):
    """The last node of a launch file without roslaunch, and the others of that file beside it."""

    def __init__(
        self,
        test: LiveCase,
        parameters: Optional[Dict[str, Any]] = None,  # set beside those of the launch file
        file: str = "compare",
        keep: bool = True,  # the nodes, for the next one that wants the same
        file_limit: Optional[int] = None,  # [bytes] of the last node
        environment: Optional[Dict[str, str]] = None,
        **arguments: Any,
    ) -> None:
        master = shared_master()
        self._test = test
        self.out = test.folder / str(arguments.get("out", "out"))
        if file == "compare":
            arguments = {"out": "out", **arguments}
        if file != "audit":
            arguments = {"rviz": False, **arguments}
        self.uri = master.uri
        self.environment = {**environment_of(test, master.uri), **(environment or {})}
        given = [f"{name}:={text_of(value)}" for name, value in arguments.items()]
        with mock.patch.dict(os.environ, self.environment):
            config = configuration(LAUNCHES / f"{file}.launch", *given)
        values = {name: parameter.value for name, parameter in config.params.items()}
        values.update({f"/{name}": value for name, value in (parameters or {}).items()})
        nodes = nodes_of(config, values)
        if not keep:
            test.addCleanup(master.end_nodes)
        main = list(nodes)[-1]
        command = nodes[main].command
        parameters_of_main = nodes.pop(main).parameters
        master.start(nodes, self.environment)
        for name, value in parameters_of_main:
            rospy.set_param(name, value)
        super().__init__(test, *command, environment=self.environment, file_limit=file_limit)


def nodes_of(config: Any, values: Dict[str, Any]) -> Dict[str, Node]:
    """The nodes of a launch file, by name, in its order."""
    main = config.nodes[-1].name
    # A world stays what the evaluator has made of it.
    made = [f"/{main}/{name}" for role in ROLES for name in (role, f"{role}_parameters")]
    nodes = {}
    for node in config.nodes:
        name = rosgraph.names.ns_join(node.namespace, node.name)
        own = tuple((n, v) for n, v in sorted(values.items()) if n.startswith(f"{name}/"))
        settings = dict(own)
        folder = settings.pop(f"{name}/working_directory", None)
        if node.type == "simulator_node":
            settings.update((n, values.get(n)) for n in made)
        files = settings.get(f"{name}/policy", "expert") not in WORDS or "scene=" in str(settings)
        arguments = (*shlex.split(node.args), f"__name:={node.name}")
        key = (node.type, arguments, str(settings), folder if files else None)
        nodes[name] = Node((node_file(node.package, node.type), *arguments), own, key)
    return nodes


def extended_launch(
    folder: Path, arguments: Dict[str, Any], parameters: Dict[str, Any], beside: str
) -> str:
    """A launch file of a user who wants more than compare.launch has arguments for."""
    lines = ["<launch>"]
    lines += [f'<arg name="{name}"/>' for name in arguments]
    lines += ['<include file="$(find sim2sim_eval)/launch/compare.launch" pass_all_args="true"/>']
    lines += [f'<param name="{k}" value="{text_of(v)}"/>' for k, v in parameters.items()]
    path = folder / "mine.launch"
    path.write_text("\n".join([*lines, beside, "</launch>"]))
    return str(path)
