"""Places for files that are read at once, shared out fairly among those who wait."""

from __future__ import annotations

import threading
import time
from collections.abc import Hashable
from dataclasses import dataclass


@dataclass(frozen=True, eq=False)
class Ticket:
    """A file that waits for a place, or has one.

    Attributes:
        owner: whose file it is.
    """

    owner: Hashable


class ReadingPlaces:
    """Places that are given in the order in which files come, one an owner at a time.

    Once an owner has one, its other files go behind those that wait already: whoever comes waits
    for one more file of each of the others at most.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._changed = threading.Condition()
        self._waiting: list[Ticket] = []
        self._reading: list[Ticket] = []

    def queue(self, owner: Hashable) -> Ticket:
        """Line up; every ticket is to be given back, whether or not it got a place."""
        ticket = Ticket(owner)
        with self._changed:
            self._waiting.append(ticket)
        return ticket

    def wait(self, ticket: Ticket, seconds: float) -> bool:
        """Check whether the ticket has a place, waited for as long as ``seconds``."""
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
        """Leave the place, or the line."""
        with self._changed:
            for tickets in (self._waiting, self._reading):
                if ticket in tickets:
                    tickets.remove(ticket)
            self._changed.notify_all()

    def _next(self) -> Ticket | None:
        """Whose turn it is; None where there is no place."""
        if len(self._reading) >= self._count:
            return None
        busy = {ticket.owner for ticket in self._reading}
        return next((ticket for ticket in self._waiting if ticket.owner not in busy), None)
