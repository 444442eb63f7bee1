"""A viser server behind a guard.

viser opens its port with ``websockets.asyncio.server.serve`` and offers no way to change how. While
the server is built, that name is replaced by a function that adds the guard.

A process that does not listen takes its connections through a side door: while ``serve`` runs, the
side door replaces the loop's ``create_server``, which it calls at once.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import http
import io
import logging
import threading
from collections.abc import Awaitable, Callable
from typing import Any

import viser
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from app.guard.connection import GuardedConnection
from app.guard.guard import Guard
from app.guard.request_line import without_query
from app.guard.side_door import SideDoor

MAX_MESSAGE = 8_000_000
"""Largest message in bytes; viser's page sends files in parts of 512 kB."""
_SLOW = 60.0
"""Seconds within which the page, 0.7 MB, must be sent over the slowest line."""
_PING_TIMEOUT = 60.0
"""Seconds without a ping's answer after which a connection counts as lost, even when busy."""
_TRY_AGAIN_LATER = 1013
_SECRET_HEADERS = frozenset({"authorization", "cookie", "set-cookie"})

_log = logging.getLogger("abi.web")
_lock = threading.Lock()
_Handler = Callable[[ServerConnection], Awaitable[None]]


def _one_line(record: logging.LogRecord) -> bool:
    """Log filter that shortens connection faults to one line; the rest is for the debug level.

    No level has the token, nor what else lets somebody in.
    """
    vars(record).pop("websocket", None)
    if isinstance(record.args, tuple):
        record.args = _without_secrets(record.args)
    error = record.exc_info[1] if record.exc_info else None
    if error is None:
        return record.levelno >= logging.WARNING or _log.isEnabledFor(logging.DEBUG)
    causes = f"{type(error).__name__}: {error.__cause__ or error}"
    if record.getMessage() == "opening handshake failed":
        # whoever connects and says nothing, as port scanners and health probes do
        record.levelno, record.levelname = logging.DEBUG, "DEBUG"
    if not _log.isEnabledFor(logging.DEBUG):
        record.exc_info = None
    record.msg, record.args = f"{record.getMessage()} ({causes})"[:300], ()
    return _log.isEnabledFor(record.levelno)


def _without_secrets(words: tuple[object, ...]) -> tuple[object, ...]:
    """Hide secrets in a log message's arguments: header values and paths."""
    if len(words) == 2 and str(words[0]).lower() in _SECRET_HEADERS:
        return words[0], "..."
    return tuple(without_query(word) if isinstance(word, str) else word for word in words)


_protocol_log = logging.getLogger("abi.web.protocol")
_protocol_log.addFilter(_one_line)


def build(guard: Guard, host: str, port: int, label: str) -> viser.ViserServer:
    """Open the port, or the guard's side door, and serve the guarded page."""
    plain = websockets.asyncio.server.serve
    with _lock:
        websockets.asyncio.server.serve = functools.partial(_serve, plain, guard)  # type: ignore[assignment, misc]
        try:
            # viser prints addresses, which lack the token
            with contextlib.redirect_stdout(io.StringIO()):
                server = viser.ViserServer(host=host, port=port, label=label, verbose=False)
        finally:
            websockets.asyncio.server.serve = plain  # type: ignore[misc]
    guard.viser = server
    return server


def _serve(
    plain: Callable[..., websockets.asyncio.server.serve],
    guard: Guard,
    handler: _Handler,
    host: str,
    port: int,
    **options: Any,
) -> websockets.asyncio.server.serve:
    """Serve as viser does, with the guard in front."""
    options.update(
        process_request=functools.partial(guard.answer, options["process_request"]),
        process_response=functools.partial(_add_headers, guard),
        create_connection=functools.partial(GuardedConnection, guard),
        max_size=MAX_MESSAGE,
        open_timeout=_SLOW,
        close_timeout=_SLOW,
        ping_timeout=_PING_TIMEOUT,
        server_header=None,
        logger=_protocol_log,
    )
    guarded = functools.partial(_handle, guard, handler)
    if not isinstance(guard.entrance, SideDoor):
        return plain(guarded, host, port, **options)
    loop: Any = asyncio.get_running_loop()
    loop.create_server = guard.entrance.open
    try:
        return plain(guarded, host, port, **options)
    finally:
        del loop.create_server


async def _handle(guard: Guard, handler: _Handler, connection: ServerConnection) -> None:
    """Run a tab's connection, counted."""
    if guard.is_full:
        # others came between its request and now
        await connection.close(_TRY_AGAIN_LATER, "all places are taken")
        return
    guard.tabs.add(connection)
    try:
        await handler(connection)
    finally:
        guard.tabs.discard(connection)


def _add_headers(
    guard: Guard, connection: ServerConnection, request: Request, response: Response
) -> None:
    if response.status_code != http.HTTPStatus.SWITCHING_PROTOCOLS:
        guard.secured(response)
