# SPDX-License-Identifier: BSD-3-Clause
"""Demonstrations as they are recorded in rosbags: reading and checking."""

import contextlib
import errno
import hashlib
import json
import struct
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Sequence

import numpy as np
import rosbag  # type: ignore[import]
from pusht_msgs.msg import DemonstrationEnd, DemonstrationStep  # type: ignore[import]
from pusht_policy.formats import DEMONSTRATION_FORMAT
from pusht_task.error import Error
from pusht_task.files import require_plain_file
from pusht_task.json_file import require_format

ORIGIN_TOPIC = "/demonstration/origin"
STEP_TOPIC = "/demonstration/step"
END_TOPIC = "/demonstration/end"
MESSAGE_TYPES = {STEP_TOPIC: DemonstrationStep, END_TOPIC: DemonstrationEnd}


@dataclass(frozen=True)
class Demonstration:
    """A complete demonstration of n control steps."""

    seed: int
    success: bool
    observations: np.ndarray  # float32 [n, 10], m and sin/cos; see DemonstrationStep.msg
    actions: np.ndarray  # float32 [n, 2], commanded pusher velocity [m/s]


@dataclass
class _Recording:
    """A demonstration while it is being read."""

    observations: List[Sequence[float]] = field(default_factory=list)
    actions: List[Sequence[float]] = field(default_factory=list)
    success: Optional[bool] = None  # None until its end has been read


def sha256_of_frames(demonstrations: Sequence[Demonstration]) -> str:
    """Hash of what is learned from: seed, steps, success and every number of each demonstration."""
    digest = hashlib.sha256()
    for demonstration in demonstrations:
        steps = len(demonstration.actions)
        digest.update(struct.pack("<QIB", demonstration.seed, steps, demonstration.success))
        digest.update(demonstration.observations.astype("<f4").tobytes())
        digest.update(demonstration.actions.astype("<f4").tobytes())
    return digest.hexdigest()


def read_origin(path: Path) -> Optional[Dict[str, Any]]:
    """Origin of the demonstrations of a readable bag; None if the bag does not say."""
    with _opened(path) as bag:
        return _origin(path, bag)


def read_demonstrations(bags: Sequence[Path]) -> List[Demonstration]:
    """Demonstrations of all bags, in the order of their seeds."""
    bag_of_seed: Dict[int, Path] = {}
    demonstrations: List[Demonstration] = []
    for bag in bags:
        for demonstration in _read_bag(bag):
            seed = demonstration.seed
            if seed in bag_of_seed:
                raise Error(
                    f"{bag}: seed {seed}: also in {bag_of_seed[seed]}; a seed must occur only once"
                )
            bag_of_seed[seed] = bag
            demonstrations.append(demonstration)
    return sorted(demonstrations, key=lambda demonstration: demonstration.seed)


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A bag to read. What cannot be written is in the temporary folder: modules of rosbag."""
    try:
        require_plain_file(path)
        with rosbag.Bag(str(path)) as bag:
            yield bag
    except OSError as error:
        if error.errno is None:  # raised by a library for compressed data
            raise Error(f"{path}: {error}; a readable rosbag is needed") from None
        if error.filename is None:
            unwritable = error.errno in (errno.EDQUOT, errno.EFBIG, errno.ENOSPC, errno.EROFS)
            error.filename = tempfile.gettempdir() if unwritable else str(path)
        raise


def _origin(path: Path, bag: Any) -> Optional[Dict[str, Any]]:
    for _, message, _ in bag.read_messages(topics=[ORIGIN_TOPIC]):
        try:
            origin = json.loads(message.data)
        except (RecursionError, ValueError) as error:
            raise Error(f"{path}: {ORIGIN_TOPIC}: {error}; it must be JSON") from None
        if not isinstance(origin, dict):
            raise Error(f"{path}: {ORIGIN_TOPIC} is {message.data}; it must be a JSON object")
        if origin.get("format", 1) != 1:  # the first format lacks only what training does not read
            require_format(f"{path}: {ORIGIN_TOPIC}", origin, DEMONSTRATION_FORMAT)
        return origin
    return None


def _read_bag(path: Path) -> List[Demonstration]:
    recordings: Dict[int, _Recording] = {}
    try:
        with _opened(path) as bag:
            _check_topics(path, bag)
            _origin(path, bag)
            for topic, message, _ in bag.read_messages(topics=list(MESSAGE_TYPES)):
                recording = recordings.setdefault(message.seed, _Recording())
                if topic == STEP_TOPIC:
                    _add_step(path, recording, message)
                else:
                    _add_end(path, recording, message)
    except FileNotFoundError:
        raise Error(f"{path}: no such file; a rosbag is needed") from None
    except (Error, MemoryError, OSError):
        raise
    except rosbag.ROSBagUnindexedException:
        raise Error(f"{path}: not indexed; run `rosbag reindex` on it first") from None
    except Exception as error:  # damaged bytes make rosbag raise anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise Error(f"{path}: {reason}; a readable rosbag is needed") from None
    if not recordings:
        raise Error(f"{path}: 0 demonstrations; at least one is needed")
    return [_finished(path, seed, recording) for seed, recording in recordings.items()]


def _check_topics(path: Path, bag: Any) -> None:
    types, topics = bag.get_type_and_topic_info()
    for topic, message_type in MESSAGE_TYPES.items():
        expected = message_type._type
        if topic not in topics:
            raise Error(f"{path}: no messages on {topic}; {expected} is needed there")
        found = topics[topic].msg_type
        if found != expected:
            raise Error(f"{path}: {topic} is of type {found}; it must be {expected}")
        if types[found] != message_type._md5sum:
            raise Error(
                f"{path}: {found} has MD5 {types[found]}; it must be {message_type._md5sum}"
            )


def _add_step(path: Path, recording: _Recording, message: Any) -> None:
    where = f"{path}: seed {message.seed}: step {message.step}"
    if recording.success is not None:
        raise Error(f"{where}: comes after the end; a seed must occur only once")
    expected = len(recording.actions)
    if message.step != expected:
        raise Error(f"{where}: steps must be consecutive from 0, expected {expected}")
    for name, values in (("observation", message.observation), ("action", message.action)):
        if not np.isfinite(values).all():
            numbers = ", ".join(f"{value:g}" for value in values)
            raise Error(f"{where}: {name} is [{numbers}]; all numbers must be finite")
    recording.observations.append(message.observation)
    recording.actions.append(message.action)


def _add_end(path: Path, recording: _Recording, message: Any) -> None:
    where = f"{path}: seed {message.seed}: end"
    if recording.success is not None:
        raise Error(f"{where}: appears twice; a seed must occur only once")
    found = len(recording.actions)
    if message.steps != found or found == 0:
        raise Error(
            f"{where}: says {message.steps} steps, found {found}; the counts must agree, at least 1"
        )
    recording.success = bool(message.success)


def _finished(path: Path, seed: int, recording: _Recording) -> Demonstration:
    if recording.success is None:
        last = len(recording.actions) - 1
        raise Error(f"{path}: seed {seed}: step {last}: is the last, but no end follows it")
    return Demonstration(
        seed=seed,
        success=recording.success,
        observations=np.array(recording.observations, dtype=np.float32),
        actions=np.array(recording.actions, dtype=np.float32),
    )
