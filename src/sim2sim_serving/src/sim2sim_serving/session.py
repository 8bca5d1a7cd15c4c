# SPDX-License-Identifier: BSD-3-Clause
"""Shared parts of all served objects: identity, refused requests, failures of foreign code."""

import json
import logging
import platform
import traceback
import uuid
from dataclasses import dataclass, field
from typing import Any, Mapping

import numpy as np
from pusht_msgs.srv import DescribeResponse  # type: ignore[import]

from pusht_task.error import Error, ExitCode, clipped

LOG = logging.getLogger("rosout")  # log of the node
TASK = "task"  # parameter of what holds other tasks than full_circle
FOREIGN = (Exception, SystemExit)  # what foreign code may end with; sys.exit() ends no node


@dataclass(frozen=True)
class Identity:
    """Identity of a node, as it tells."""

    name: str  # kind of simulator or policy
    version: str
    title: str = ""  # title of a simulator, for people
    # [m, rad, m/s, rad/s] maximum deviation of a state after a reset from the requested state;
    # 0: the simulator does not say
    start_tolerance: float = 0.0
    instance_id: str = field(default_factory=lambda: str(uuid.uuid4()))


class FailedStart:
    """A node that failed at start: it answers only to describe, with the error."""

    def __init__(self, failure: BaseException, identity: Identity) -> None:
        error = failure if isinstance(failure, Error) else unforeseen(failure)
        self.message = clipped(str(error))
        self.exit_code = error.exit_code
        self._identity = identity

    def describe(self, _request: Any = None) -> DescribeResponse:
        return DescribeResponse(
            success=False,
            message=self.message,
            exit_code=self.exit_code,
            instance_id=self._identity.instance_id,
            name=self._identity.name,
            version=self._identity.version,
        )


def refused(response_type: Any, refusal: Error, identity: Identity) -> Any:
    """The answer that says no."""
    return response_type(
        success=False,
        message=clipped(str(refusal)),
        exit_code=refusal.exit_code,
        instance_id=identity.instance_id,
    )


def unforeseen(failure: BaseException) -> Error:
    """The error for a failure that is a defect of foreign code."""
    return Error(reported(failure), ExitCode.INTERNAL_ERROR)


def reported(failure: BaseException) -> str:
    """A failure and its place on one line; the whole traceback goes into the node's log."""
    trace = traceback.format_exception(type(failure), failure, failure.__traceback__)
    LOG.error("%s", "".join(trace))
    message = " ".join(str(failure).split())
    place = traceback.extract_tb(failure.__traceback__)[-1]
    return f"{type(failure).__name__}: {message} ({place.name}, line {place.lineno})"


def provenance(more: Mapping[str, Any]) -> str:
    """JSON text: what numbers depend on besides the parameters, and what more there is to say."""
    versions = {"numpy": np.__version__, "python": platform.python_version()}
    return json.dumps({**versions, **more})
