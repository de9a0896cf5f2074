# SPDX-License-Identifier: Apache-2.0
"""The WebSocket of a display: opens it, pairs requests with replies, and hands on everything else."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import ssl
import urllib.parse
from collections.abc import Callable
from typing import Any, Optional

import websockets
import websockets.exceptions

from . import fanlight_pb2 as pb
from .errors import ConnectionFailed, ConnectionLost, NotAuthenticated, TimedOut

PROTOCOL_VERSION = 2
_SUBPROTOCOL = "fanlight.v2"
_CONNECT_TIMEOUT_S = 10


def stream_address(url: str) -> str:
    """The address of the stream of a server: "http://HOST:PORT/", "https://...", "HOST:PORT" or "PORT". ValueError for
    anything else."""
    text = url if "://" in url else f"http://{'127.0.0.1:' + url if url.isdigit() else url}"
    parts = urllib.parse.urlsplit(text)
    schemes = {"http": "ws", "https": "wss", "ws": "ws", "wss": "wss"}
    if parts.scheme not in schemes or not parts.hostname:
        raise ValueError(f"the address is {url!r}, expected http://HOST:PORT, https://HOST, HOST:PORT or PORT")
    path = parts.path if parts.path.endswith("/stream") else parts.path.rstrip("/") + "/stream"
    return urllib.parse.urlunsplit((schemes[parts.scheme], parts.netloc, path, "", ""))


class Session:
    """One connection. Its loop reads all the time, so that the server never waits for this client."""

    def __init__(self, take: Callable[[pb.ServerMessage], None], request_timeout_s: float) -> None:
        """`take` is called with each message that is no reply."""
        self._take = take
        self._request_timeout_s = request_timeout_s
        self._replies: dict[int, asyncio.Future[pb.ServerMessage]] = {}
        self._numbers = itertools.count(1)
        self._socket: Any = None
        self._reader: Optional[asyncio.Task[None]] = None
        self.failure: Optional[ConnectionLost] = None
        """Why the connection has ended; None while it is open."""

    async def open(self, url: str, token: Optional[str], name: str, tls: Optional[ssl.SSLContext]) -> pb.Hello:
        """Connect and log in. Return the server's Hello. Raises ConnectionFailed and NotAuthenticated."""
        address = stream_address(url)
        options: dict[str, Any] = {"ssl": tls} if address.startswith("wss:") else {}
        try:
            self._socket = await asyncio.wait_for(
                websockets.connect(  # type: ignore[attr-defined]
                    address, subprotocols=[_SUBPROTOCOL], max_size=None, compression=None, **options
                ),
                _CONNECT_TIMEOUT_S,
            )
        except (OSError, asyncio.TimeoutError, websockets.exceptions.WebSocketException) as failure:
            raise ConnectionFailed(f"{url}: {str(failure) or 'no answer'}") from failure
        try:
            return await asyncio.wait_for(self._welcome(url, token, name), _CONNECT_TIMEOUT_S)
        except BaseException as failure:
            await self.close()
            if isinstance(failure, asyncio.TimeoutError):
                raise ConnectionFailed(f"{url}: the server accepted the connection and said nothing") from failure
            raise

    async def _welcome(self, url: str, token: Optional[str], name: str) -> pb.Hello:
        logged_in = False
        while True:
            try:
                message = pb.ServerMessage.FromString(await self._socket.recv())
            except websockets.exceptions.ConnectionClosed as closed:
                raise NotAuthenticated(_reason(closed)) if logged_in else ConnectionFailed(_reason(closed)) from closed
            kind = message.WhichOneof("body")
            if kind == "login_needed":
                if not token:
                    raise NotAuthenticated("the server asks for a token, expected connect(url, token)")
                await self.send(login=pb.Login(token=token, name=name))
                logged_in = True
            elif kind == "error":
                raise NotAuthenticated(message.error.message)
            elif kind == "hello":
                if message.hello.protocol_version != PROTOCOL_VERSION:
                    raise ConnectionFailed(
                        f"{url} speaks protocol {message.hello.protocol_version}, this package {PROTOCOL_VERSION}"
                    )
                if name and not logged_in:
                    await self.send(login=pb.Login(name=name))
                self._reader = asyncio.create_task(self._read())
                hello: pb.Hello = message.hello
                return hello

    async def close(self) -> None:
        if self._reader:
            self._reader.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._reader
        if self._socket:
            await self._socket.close()

    async def send(self, **body: Any) -> None:
        """Send a message without waiting for an answer: send(login=Login(...)). Raises ConnectionLost."""
        if self.failure:
            raise self.failure
        try:
            await self._socket.send(pb.ClientMessage(**body).SerializeToString())
        except websockets.exceptions.ConnectionClosed as closed:
            raise ConnectionLost(_reason(closed)) from closed

    async def ask(self, kind: str, request: Any) -> pb.ServerMessage:
        """Send a request and return its reply. Raises ConnectionLost and TimedOut."""
        number = next(self._numbers)
        request.request_id = number
        reply: asyncio.Future[pb.ServerMessage] = asyncio.get_running_loop().create_future()
        self._replies[number] = reply
        try:
            await self.send(**{kind: request})
            return await asyncio.wait_for(reply, self._request_timeout_s)
        except asyncio.TimeoutError as late:
            raise TimedOut(f"the server did not answer within {self._request_timeout_s} s") from late
        finally:
            del self._replies[number]

    async def _read(self) -> None:
        failure = "the connection was closed"
        try:
            while True:
                message = pb.ServerMessage.FromString(await self._socket.recv())
                kind = message.WhichOneof("body") or ""
                if not kind.endswith("_reply") or kind == "clock_reply":
                    self._take(message)
                    continue
                reply = self._replies.get(getattr(message, kind).request_id)
                if reply and not reply.done():
                    reply.set_result(message)
        except websockets.exceptions.ConnectionClosed as closed:
            failure = _reason(closed)
        except Exception as other:  # such as a message that cannot be read
            failure = f"the session failed: {other}"
        finally:
            self.failure = ConnectionLost(failure)
            for reply in self._replies.values():
                if not reply.done():
                    reply.set_exception(self.failure)
            self._take(pb.ServerMessage())  # wakes who waits for a picture


def _reason(closed: websockets.exceptions.ConnectionClosed) -> str:
    frame = closed.rcvd
    if frame is not None and frame.reason:
        return f"the server closed the session: {frame.reason}"
    return "the connection broke" if frame is None else "the server closed the session"
