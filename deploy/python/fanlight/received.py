# SPDX-License-Identifier: Apache-2.0
"""Messages of the server as pictures and states."""

from __future__ import annotations

import dataclasses
import io
import time
import zlib
from typing import Optional

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from . import fanlight_pb2 as pb
from .picture import Picture, View

_NO_SURFACE = 65535
_SILENCE_S = 2.0  # the server sends a message once a second at least
_STATES = {
    pb.Liveness.WAITING: "waiting",
    pb.Liveness.LIVE: "live",
    pb.Liveness.DELAYED: "delayed",
    pb.Liveness.NOT_LIVE: "not live",
    pb.Liveness.REPLAY: "replay",
    pb.Liveness.FROZEN: "frozen",
    pb.Liveness.RESTING: "resting",
}
_ORIGINS = {
    pb.Liveness.PROBE: "probe",
    pb.Liveness.UNKNOWN: "unknown",
    pb.Liveness.SIMULATED: "simulated",
    pb.Liveness.RECORDING: "recording",
}
_CLOCK_SAMPLES = 20


@dataclasses.dataclass(frozen=True)
class State:
    """Whether the main picture is live."""

    name: str
    """"waiting", "live", "delayed", "not live", "replay", "frozen" or "resting"."""
    sentence: str
    """What holds and why; empty where there is nothing to say."""
    origin: str
    """Where the frames come from: "probe", "unknown", "simulated" or "recording"."""


class StateWatch:
    """Joins what the server says and its silence."""

    def __init__(self) -> None:
        self._told = pb.Liveness()
        self._heard_s = time.monotonic()

    def heard(self) -> None:
        self._heard_s = time.monotonic()

    def tell(self, liveness: pb.Liveness) -> None:
        self._told = liveness

    def now(self) -> State:
        silent_s = time.monotonic() - self._heard_s
        origin = _ORIGINS.get(self._told.origin, "unknown")
        if silent_s > _SILENCE_S:
            return State("not live", f"The server has sent nothing for {silent_s:.0f} s.", origin)
        return State(_STATES.get(self._told.state, "not live"), self._told.sentence, origin)


class ServerClock:
    """The clock of the server, from replies to ClockRequest: the one with the shortest round trip counts."""

    def __init__(self) -> None:
        self._samples: list[tuple[float, float]] = []  # round trip and offset, s

    def add(self, reply: pb.ClockReply) -> None:
        received_s = time.monotonic()
        sent_s = reply.client_time_ms / 1000
        offset_s = reply.server_time_ns / 1e9 - (sent_s + received_s) / 2
        self._samples = [*self._samples[-_CLOCK_SAMPLES + 1 :], (received_s - sent_s, offset_s)]

    def age_s(self, server_time_ns: int) -> Optional[float]:
        """From a time of the server to now; None before the first reply."""
        if not self._samples:
            return None
        return max(0.0, time.monotonic() + min(self._samples)[1] - server_time_ns / 1e9)


def decoded(
    message: pb.Picture, depth_size: tuple[int, int], state: State, age_s: Optional[float], notes: tuple[str, ...]
) -> Picture:
    """`depth_size`: width and height of the server's depth maps. ValueError for a picture that cannot be decoded."""
    with Image.open(io.BytesIO(message.png or message.jpeg)) as image:
        rgb = np.asarray(image.convert("RGB"))
    depth_view = _view(message.view)
    return Picture(
        rgb=rgb,
        depth_mm=_depth_mm(message, depth_size) if message.depth else None,
        view=_scaled(depth_view, depth_size, (message.width, message.height)),
        depth_view=depth_view,
        volume_id=message.volume_id,
        picture_id=message.picture_id,
        scene_revision=message.scene_revision,
        private_view=message.private_view,
        capture_time_ns=message.capture_time_ns,
        age_s=age_s,
        state=state.name,
        origin=state.origin,
        frames_missing=message.frames_missing,
        surface_share=message.surface_share,
        uncertain_share=message.uncertain_share,
        warnings=tuple(warning.sentence for warning in message.warnings),
        notes=notes,
    )


def _depth_mm(message: pb.Picture, size: tuple[int, int]) -> NDArray[np.float32]:
    units = np.frombuffer(zlib.decompress(message.depth), dtype="<u2").reshape(size[1], size[0])
    depth = np.where(units == _NO_SURFACE, np.nan, units * message.depth_unit_mm).astype(np.float32)
    depth.flags.writeable = False
    return depth


def _view(view: pb.View) -> View:
    matrix = np.array(view.matrix, dtype=np.float64).reshape(4, 4)
    return View(matrix, view.mm_per_pixel, view.mm_per_pixel_per_mm, view.middle_column, view.middle_row)


def _scaled(view: View, size: tuple[int, int], to: tuple[int, int]) -> View:
    """The same view in pixels of another size; the edges stay where they are."""
    if size == to or 0 in to:
        return view
    scale = to[0] / size[0]
    return View(
        view.matrix,
        view.mm_per_pixel / scale,
        view.mm_per_pixel_per_mm / scale,
        (view.middle_column + 0.5) * scale - 0.5,
        (view.middle_row + 0.5) * scale - 0.5,
    )
