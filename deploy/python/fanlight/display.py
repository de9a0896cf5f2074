# SPDX-License-Identifier: Apache-2.0
"""connect(): the pictures of a server, and what changes them."""

from __future__ import annotations

import asyncio
import contextlib
import ssl
import time
from collections.abc import AsyncIterator, Generator
from types import TracebackType
from typing import Any, Literal, NoReturn, Optional

from . import fanlight_pb2 as pb
from . import received, scene as scenes
from .errors import ConnectionLost, ControlHeld, FanlightError, NotPermitted, Refused, TimedOut, ValueNotAllowed
from .picture import Picture
from .received import State
from .session import Session

_CLOCK_PERIOD_S = 0.5
_NO_FILE_S = 1.5  # after a stop: a file that there is has been named by then
_CODECS = {"jpeg": pb.StreamRequest.JPEG, "png": pb.StreamRequest.PNG}
_ROLES = {pb.VIEWER: "viewer", pb.OPERATOR: "operator", pb.ADMIN: "admin"}


class Display:
    """A session with a server. Use it as `async with connect(...) as display`; `async for picture in display` gives the
    newest picture each time, and counts those in between in `skipped`.

    Methods raise Refused, or one of its kinds, where the server does not carry out a request; ConnectionLost once the
    connection has ended; TimedOut without an answer. For one event loop.
    """

    def __init__(
        self,
        url: str,
        token: Optional[str],
        name: str,
        codec: Literal["jpeg", "png"],
        size: Optional[tuple[int, int]],
        rate_hz: float,
        depth: bool,
        tls: Optional[ssl.SSLContext],
        timeout_s: float,
    ) -> None:
        if codec not in _CODECS:
            raise ValueError(f"codec is {codec!r}, expected jpeg or png")
        self._login = (url, token, name, tls)
        width, height = size or (0, 0)
        self._stream = pb.StreamRequest(
            codec=_CODECS[codec], width=width, height=height, rate_hz=rate_hz, with_depth=depth
        )
        self._timeout_s = timeout_s
        self._session = Session(self._take, timeout_s)
        self._hello = pb.Hello()
        self._clock = received.ServerClock()
        self._watch = received.StateWatch()
        self._clock_task: Optional[asyncio.Task[None]] = None
        self._scene = pb.SceneState()
        self._control = pb.ControlState()
        self._recording = pb.RecordingStatus()
        self._cine = pb.CineStatus()
        self._newest: Optional[tuple[pb.Picture, Optional[float]]] = None  # with its age at its arrival
        self._news = asyncio.Event()
        self._revision = 0  # of the last change by this client
        self._own_revision: Optional[int] = None  # of its own view; None: it shows the main view
        self.skipped = 0
        """Pictures that came and were not taken, since a newer one had come."""

    async def __aenter__(self) -> Display:
        self._hello = await self._session.open(*self._login)
        self._scene = self._hello.scene
        self._control = self._hello.control
        self._clock_task = asyncio.create_task(self._ask_clock())
        try:
            await self._ask("stream", self._stream)
        except BaseException:
            await self.close()
            raise
        self._newest = None  # one of before that request
        return self

    async def __aexit__(
        self, kind: Optional[type[BaseException]], failure: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """End the session. What was recorded and who is in control follows as at the end of any session."""
        if self._clock_task:
            self._clock_task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._clock_task
        await self._session.close()

    # What the server says.

    @property
    def source(self) -> str:
        """Where the frames come from, for people."""
        return self._hello.title or self._hello.source

    @property
    def notes(self) -> tuple[str, ...]:
        """What is assumed of the source, a sentence each."""
        return tuple(self._hello.notes)

    @property
    def role(self) -> str:
        """ "viewer", "operator" or "admin"."""
        return _ROLES.get(self._hello.role, "viewer")

    @property
    def state(self) -> State:
        """Whether the main picture is live, now."""
        return self._watch.now()

    @property
    def scene(self) -> dict[str, Any]:
        """All fields of the main scene, by groups: scene["light"]["up_mm"]."""
        return scenes.values(self._scene.scene, self._hello.fields)

    @property
    def fields(self) -> dict[str, pb.SceneField]:
        """Unit, help, range and choices of each field, by its dotted name."""
        return {field.name: field for field in self._hello.fields}

    @property
    def in_control(self) -> bool:
        """Whether this client is the one that may change the scene; where no client is, a change acquires control."""
        return self._control.holder_session == self._hello.session_id

    # Pictures.

    async def __aiter__(self) -> AsyncIterator[Picture]:
        while True:
            yield await self._next(timeout_s=None)

    async def picture(self, timeout_s: Optional[float] = None) -> Picture:
        """The next picture that shows this client's last change. Raises TimedOut; None: the timeout of requests."""
        limit_s = self._timeout_s if timeout_s is None else timeout_s
        until_s = time.monotonic() + limit_s
        while True:
            left_s = until_s - time.monotonic()
            if left_s <= 0:
                raise TimedOut(f"no picture with the last change came within {limit_s:g} s: {self.state.sentence}")
            picture = await self._next(left_s)
            if self._own_revision is None:
                if not picture.private_view and picture.scene_revision >= self._revision:
                    return picture
            elif picture.private_view and picture.scene_revision >= self._own_revision:
                return picture

    async def _next(self, timeout_s: Optional[float]) -> Picture:
        while self._newest is None:
            if self._session.failure:
                raise self._session.failure
            self._news.clear()
            try:
                await asyncio.wait_for(self._news.wait(), timeout_s)
            except asyncio.TimeoutError as late:
                raise TimedOut(f"no picture came within {timeout_s:.3g} s: {self.state.sentence}") from late
        message, age_s = self._newest
        self._newest = None
        size = (self._hello.picture_width, self._hello.picture_height)
        # It takes milliseconds, in which the loop goes on reading.
        return await asyncio.to_thread(received.decoded, message, size, self.state, age_s, self.notes)

    # Changes.

    async def set(self, *, own: bool = False, **scene: Any) -> int:
        """Change fields of the scene: set(light={"up_mm": 20}, mode="surface"). Return the revision that has them.

        own: only this client's pictures change: camera, lights, filter, material, shadow and finish. It begins a
        private view, which leave_own_view() ends.
        """
        change = scenes.message(scene, self._hello.fields)
        if own:
            outcome = await self._ask("view", pb.ViewChange(scene=change))
            self._own_revision = outcome.revision
            return int(outcome.revision)
        outcome = await self._ask("scene_change", pb.SceneChange(scene=change))
        self._scene = outcome
        self._revision = outcome.revision
        return int(outcome.revision)

    async def leave_own_view(self) -> None:
        await self._ask("view", pb.ViewChange(leave=True))
        self._own_revision = None

    async def find_surface(self) -> tuple[str, ...]:
        """Choose camera, rays, detector and light for the surface of the last volume. Return why, a sentence each."""
        found = await self._ask("survey", pb.SurveyRequest())
        outcome = await self._ask("scene_change", pb.SceneChange(scene=found.scene))
        self._scene = outcome
        self._revision = outcome.revision
        return tuple(found.choices)

    # The last volumes. It holds for all displays.

    async def freeze(self) -> None:
        """Keep the newest volume on show."""
        await self._cine_wish(pb.CineRequest.FREEZE, pb.CineStatus.FROZEN)

    async def live(self) -> None:
        """Show new volumes again."""
        await self._cine_wish(pb.CineRequest.LIVE, pb.CineStatus.LIVE)

    async def step(self, volumes: int) -> None:
        """While frozen: show another of the last volumes; negative: an earlier one."""
        if self._cine.state == pb.CineStatus.LIVE:
            raise Refused("the picture is live, expected freeze() before step()")
        await self._ask("cine", pb.CineRequest(wish=pb.CineRequest.STEP, value=volumes))

    async def _cine_wish(self, wish: int, state: int) -> None:
        await self._ask("cine", pb.CineRequest(wish=wish))  # type: ignore[arg-type]
        await self._until(lambda: self._cine.state == state, "the picture is as it was")

    # The recorder of the server.

    def record(self) -> StartedRecording:
        """Record the frames of the source to a file on the server: `async with display.record() as recording`, or
        `recording = await display.record()` and later `await recording.stop()`."""
        return StartedRecording(self)

    # Control.

    async def ask_control(self) -> bool:
        """Acquire control if it is free, else wait for it. Return in_control; it may become true later."""
        self._control = await self._ask("control", pb.ControlRequest(wish=pb.ControlRequest.ASK))
        return self.in_control

    async def take_control(self) -> None:
        """Acquire control from another client; for admins."""
        self._control = await self._ask("control", pb.ControlRequest(wish=pb.ControlRequest.TAKE_OVER))

    async def release_control(self) -> None:
        self._control = await self._ask("control", pb.ControlRequest(wish=pb.ControlRequest.RELEASE))

    # Messages.

    async def _ask(self, kind: str, request: Any) -> Any:
        """The outcome of a request that was carried out."""
        reply = await self._session.ask(kind, request)
        body = getattr(reply, reply.WhichOneof("body") or "")
        outcome = body.WhichOneof("outcome")
        if outcome == "refused":
            self._raise(body.refused)
        return getattr(body, outcome)

    def _raise(self, refusal: pb.Error) -> NoReturn:
        sentence = refusal.message
        if refusal.field:
            is_range = refusal.minimum != refusal.maximum
            limits = (refusal.minimum, refusal.maximum) if is_range else (None, None)
            raise ValueNotAllowed(sentence, refusal.field, *limits, choices=refusal.choices)
        if self._hello.role == pb.VIEWER:
            raise NotPermitted(sentence)
        if self._control.holder_session not in (0, self._hello.session_id):
            raise ControlHeld(sentence, self._control.holder_name)
        raise Refused(sentence)

    async def _until(self, holds: Any, sentence: str) -> None:
        """Wait for a state that a request brings about."""
        until_s = time.monotonic() + self._timeout_s
        while not holds():
            if self._session.failure:
                raise self._session.failure
            if time.monotonic() > until_s:
                raise TimedOut(f"after {self._timeout_s:g} s {sentence}")
            await asyncio.sleep(0.02)

    async def _ask_clock(self) -> None:
        with contextlib.suppress(ConnectionLost):
            while True:
                await self._session.send(clock_request=pb.ClockRequest(client_time_ms=time.monotonic() * 1000))
                await asyncio.sleep(_CLOCK_PERIOD_S)

    def _take(self, message: pb.ServerMessage) -> None:
        kind = message.WhichOneof("body")
        if kind is not None:
            self._watch.heard()
        if kind == "picture":
            self.skipped += self._newest is not None
            self._newest = (message.picture, self._clock.age_s(message.picture.capture_time_ns))
        elif kind == "liveness":
            self._watch.tell(message.liveness)
        elif kind == "clock_reply":
            self._clock.add(message.clock_reply)
        elif kind == "scene":
            self._scene_changed(message.scene)
        elif kind == "view" and not message.view.is_private:
            self._own_revision = None
        elif kind == "control":
            self._control = message.control
        elif kind == "recording":
            self._recording = message.recording
        elif kind == "cine":
            self._cine = message.cine
        if kind in (None, "picture"):
            self._news.set()

    def _scene_changed(self, state: pb.SceneState) -> None:
        self._scene = state
        if state.HasField("default_scene"):
            del self._hello.notes[:]
            self._hello.notes.extend(state.notes)


class Recording:
    """A recording that a server makes. `file` is its name in the folder of the server."""

    def __init__(self, display: Display, file: str) -> None:
        self._display = display
        self.file = file

    async def stop(self) -> None:
        """End it, and wait until the file is whole. Raises Refused where there is none, or it could not be finished."""
        display = self._display
        await display._ask("recording", pb.RecordingRequest(wish=pb.RecordingRequest.STOP))
        stopped_s = time.monotonic()

        def is_over() -> bool:
            status = display._recording
            if status.state in (pb.RecordingStatus.RECORDING, pb.RecordingStatus.FINISHING):
                return False
            return status.last_file == self.file or time.monotonic() - stopped_s > _NO_FILE_S

        await display._until(is_over, f"{self.file} is not finished")
        if display._recording.last_file != self.file:
            raise Refused(f"no frame came while {self.file} was recorded: there is no such file")
        if display._recording.last_trouble:
            raise Refused(display._recording.last_trouble)


class StartedRecording:
    """What record() returns: to be awaited, or entered."""

    def __init__(self, display: Display) -> None:
        self._display = display
        self._recording: Optional[Recording] = None

    def __await__(self) -> Generator[Any, None, Recording]:
        return self._start().__await__()

    async def _start(self) -> Recording:
        file = await self._display._ask("recording", pb.RecordingRequest(wish=pb.RecordingRequest.START))
        return Recording(self._display, file)

    async def __aenter__(self) -> Recording:
        self._recording = await self._start()
        return self._recording

    async def __aexit__(
        self, kind: Optional[type[BaseException]], failure: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        if self._recording is None:
            return
        try:
            await self._recording.stop()
        except FanlightError:
            if failure is None:  # else that one is to be seen
                raise


def connect(
    url: str = "http://127.0.0.1:8080",
    token: Optional[str] = None,
    *,
    name: str = "",
    codec: Literal["jpeg", "png"] = "jpeg",
    size: Optional[tuple[int, int]] = None,
    rate_hz: float = 0,
    depth: bool = False,
    tls: Optional[ssl.SSLContext] = None,
    timeout_s: float = 10,
) -> Display:
    """Connect to a server: `async with connect(url, token) as display`.

    url: "http://HOST:PORT", "https://HOST", "HOST:PORT" or "PORT".
    token: of `fanlight token add`, where the server asks for one.
    name: what other displays see, at most 64 bytes.
    codec: "png" has the exact values of the pixels, and costs the server more.
    size: a frame that pictures are fitted into; None: the usual size of the server.
    rate_hz: pictures a second at most; 0: each one.
    depth: pictures have depth_mm, in the usual size of the server.
    tls: for https, such as ssl.create_default_context(cafile="ca.pem"); None: the authorities of the system.
    timeout_s: of each request.

    Raises ConnectionFailed or NotAuthenticated when it is entered, ValueError for an address or a codec. It does not
    reconnect.
    """
    return Display(url, token, name, codec, size, rate_hz, depth, tls, timeout_s)
