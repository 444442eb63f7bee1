"""One connection, whose messages are checked before viser reads them."""

from __future__ import annotations

import asyncio
import logging
import socket
import time
from typing import TYPE_CHECKING, Any

from websockets.asyncio.server import ServerConnection
from websockets.frames import Frame, Opcode
from websockets.protocol import Event
from websockets.typing import Data

from app.guard import request_line, responses
from app.guard.messages import (
    CameraMoved,
    GizmoUpdate,
    Message,
    UploadPart,
    UploadStart,
    WidgetUpdate,
)
from app.guard.messages import decode as decode_message
from app.guard.porter import LONGEST_HEAD
from app.guard.uploads import Uploads
from app.guard.values import fits

if TYPE_CHECKING:
    from app.guard.guard import Guard

_log = logging.getLogger("abi.web")

MESSAGES_PER_SECOND = 240.0
BYTES_PER_SECOND = 8e6
BURST = 2.0  # [s] of those rates
REQUEST_TIMEOUT = 10.0
"""Seconds within which a request must arrive."""
UNREAD = 60.0
"""Seconds within which a page with a full backlog must have read some of it."""
MAX_UNSENT = 65_536
"""Bytes handed to the system's send buffer, beyond which messages can still be dropped."""
MAX_REFUSED = 100
"""Refused messages after which a tab is disconnected."""
_POLICY_VIOLATION = 1008


class GuardedConnection(ServerConnection):
    """A browser's connection that passes on only what a page may send."""

    def __init__(self, guard: Guard, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._guard = guard
        self._head: bytes | None = b""
        self._messages_paid = self._bytes_paid = 0.0
        self._uploads = Uploads()
        self._refused = 0
        self._looking: asyncio.TimerHandle | None = None
        guard.connections.add(self)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Close connections that send no request in time."""
        super().connection_made(transport)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            wire = transport.get_extra_info("socket")
            wire.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MAX_UNSENT)
        self.loop.call_later(REQUEST_TIMEOUT, self._hang_up_on_silence)

    def _hang_up_on_silence(self) -> None:
        if self.request is None:
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop counting the connection."""
        super().connection_lost(exc)
        self._look_no_more()
        if self._guard.entrance is not None:
            self._guard.entrance.leave(self)

    def data_received(self, data: bytes) -> None:
        """Pass the bytes on once the request's first line is known to be valid.

        Where several processes serve the address, the whole request decides whose it is.
        """
        if self._head is None:
            super().data_received(data)
            return
        self._head += data
        line, end, _ = self._head.partition(b"\n")
        if not end and len(line) <= request_line.MAX_LINE:
            return
        if (status := request_line.problem(line)) is None:
            if self._guard.entrance is not None:
                if b"\r\n\r\n" not in self._head and len(self._head) < LONGEST_HEAD:
                    return
                if not self._guard.is_full and self._guard.entrance.hands_on(self, self._head):
                    self._head = b""
                    self.transport.abort()
                    return
            data, self._head = self._head, None
            super().data_received(data)
            return
        self._head = b""
        if not self.transport.is_closing():
            asked, reason = line.decode("ascii", "replace"), responses.odd_reason(status)
            self._guard.note_refusal(status, asked, self.remote_address, reason)
            answer = self._guard.secured(responses.misunderstood(status))
            self.transport.write(answer.serialize())
            self.transport.close()

    def pause_writing(self) -> None:
        """Drop the connection if the page reads nothing for long.

        A ping, which is to find that out, would wait behind it.
        """
        super().pause_writing()
        self._look_later()

    def resume_writing(self) -> None:
        """Cancel the drop: the page has read."""
        super().resume_writing()
        self._look_no_more()

    def _look_later(self) -> None:
        unread = self.transport.get_write_buffer_size()
        self._looking = self.loop.call_later(UNREAD, self._look, unread)

    def _look(self, unread: int) -> None:
        if self.transport.get_write_buffer_size() < unread:
            self._look_later()
        else:
            self.transport.abort()

    def _look_no_more(self) -> None:
        if self._looking is not None:
            self._looking.cancel()
            self._looking = None

    def process_event(self, event: Event) -> None:
        """Apply a gizmo's move at once; every other message, and moves after it, wait for ``recv``.

        Hands send twenty moves a second, and a queue and two turns of the loop take longer than
        the move.
        """
        if not (isinstance(event, Frame) and self._has_moved(event)):
            super().process_event(event)

    def _has_moved(self, frame: Frame) -> bool:
        """Check whether a frame was a gizmo's move that is now applied."""
        if frame.opcode is not Opcode.BINARY or not frame.fin or len(self.recv_messages.frames):
            return False
        message = decode_message(frame.data)
        # who is too fast waits with the others
        return (
            isinstance(message, GizmoUpdate)
            and self._delay(len(frame.data)) <= 0
            and self._guard.move_gizmo(self, message)
        )

    def _delay(self, size: int) -> float:
        """Delay before the next message after one of this size in bytes, [s]."""
        now = time.monotonic()
        self._messages_paid = paid_until(self._messages_paid, now, 1 / MESSAGES_PER_SECOND)
        self._bytes_paid = paid_until(self._bytes_paid, now, size / BYTES_PER_SECOND)
        return max(self._messages_paid, self._bytes_paid) - now - BURST

    async def recv(self, decode: bool | None = None) -> Data:  # type: ignore[override]
        """The next message for viser to read; delayed if they come too fast."""
        while True:
            frame = await super().recv(decode)
            if (pause := self._delay(len(frame))) > 0:
                await asyncio.sleep(pause)
            message = decode_message(frame)
            reason = self._refusal(message)
            if reason is not None:
                await self._refuse(reason)
            elif not (isinstance(message, GizmoUpdate) and self._guard.move_gizmo(self, message)):
                return frame

    def _refusal(self, message: Message | None) -> str | None:
        """Reason to refuse a message; None to pass it."""
        if message is None:
            return "malformed"
        if isinstance(message, CameraMoved):
            return None if message.looks_somewhere else "camera"
        if isinstance(message, UploadPart):
            return None if self._uploads.continues(message) else "unannounced"
        if isinstance(message, WidgetUpdate):
            widget = self._guard.widget(self, message.uuid)
            allowed = widget is not None and fits(widget, message.updates["value"])
            return None if allowed else "value"
        if isinstance(message, UploadStart):
            button = self._guard.widget(self, message.source_component_uuid)
            allowed = hasattr(button, "mime_type") and self._uploads.begins(message, button)
            return None if allowed else "upload"
        return None

    async def _refuse(self, reason: str) -> None:
        # takes a tenth of a second to load, and the page is waiting
        from app.process import metrics

        metrics.REFUSED_MESSAGES.labels(reason).inc()
        self._refused += 1
        if self._refused == 1:
            address = self.remote_address
            _log.warning("messages refused", extra={"why": reason, "address": str(address)})
        if self._refused > MAX_REFUSED:
            await self.close(_POLICY_VIOLATION, "too many messages that no page sends")


def paid_until(paid: float, now: float, cost: float) -> float:
    """Moment until which a sender has used up a rate, after a message that takes ``cost`` of it.

    Args:
        paid: the moment before this message, [s].
        now: when it came, [s].
        cost: time in which the rate lets one such message through, [s].
    """
    return max(paid, now) + cost
