# SPDX-License-Identifier: Apache-2.0
"""Fanlight from Python: render() an array or a recording, connect() to a server. Guide: deploy/PYTHON.md. Not for
diagnosis."""

from ._version import __version__
from .display import Display, Recording, connect
from .errors import (
    ConnectionFailed,
    ConnectionLost,
    ControlHeld,
    FanlightError,
    NotAuthenticated,
    NotPermitted,
    ProgramMissing,
    Refused,
    RenderFailed,
    TimedOut,
    ValueNotAllowed,
)
from .geometry import Fan, Grid
from .offline import render
from .picture import Picture, View
from .received import State

__all__ = [
    "ConnectionFailed",
    "ConnectionLost",
    "ControlHeld",
    "Display",
    "Fan",
    "FanlightError",
    "Grid",
    "NotAuthenticated",
    "NotPermitted",
    "Picture",
    "ProgramMissing",
    "Recording",
    "Refused",
    "RenderFailed",
    "State",
    "TimedOut",
    "ValueNotAllowed",
    "View",
    "__version__",
    "connect",
    "render",
]
