"""Places in the reader's pool, shared fairly among waiting owners."""

from __future__ import annotations

import threading
import time
from collections.abc import Hashable
from dataclasses import dataclass


@dataclass(frozen=True, eq=False)
class Ticket:
    """A file that waits for a place or has one.

    Attributes:
        owner: whose file it is.
    """

    owner: Hashable


class ReadingPlaces:
    """Places given in the order of arrival, one an owner at a time.

    Once an owner has one, its other files go behind those that wait already: whoever comes waits
    for one more file of each of the others at most.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._changed = threading.Condition()
        self._waiting: list[Ticket] = []
        self._reading: list[Ticket] = []

    def queue(self, owner: Hashable) -> Ticket:
        """Join the line; every ticket must be given back, with or without a place."""
        ticket = Ticket(owner)
        with self._changed:
            self._waiting.append(ticket)
        return ticket

    def wait(self, ticket: Ticket, seconds: float) -> bool:
        """Wait up to ``seconds`` for a place; whether the ticket has one."""
        end = time.monotonic() + seconds
        with self._changed:
            while self._next() is not ticket:
                left = end - time.monotonic()
                if left <= 0 or not self._changed.wait(left):
                    return False
            self._waiting.remove(ticket)
            self._reading.append(ticket)
            # the owner's other files go behind those of others; the sort keeps all else in order
            self._waiting.sort(key=lambda other: other.owner == ticket.owner)
            self._changed.notify_all()
        return True

    def give_back(self, ticket: Ticket) -> None:
        """Leave the place or the line."""
        with self._changed:
            for tickets in (self._waiting, self._reading):
                if ticket in tickets:
                    tickets.remove(ticket)
            self._changed.notify_all()

    def _next(self) -> Ticket | None:
        """The next ticket; None if no place is free."""
        if len(self._reading) >= self._count:
            return None
        busy = {ticket.owner for ticket in self._reading}
        return next((ticket for ticket in self._waiting if ticket.owner not in busy), None)
