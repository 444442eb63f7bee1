"""A message of a recording of a motion."""

from __future__ import annotations

from typing import Any, NamedTuple


class RecordedMessage(NamedTuple):
    """A message that both recording formats write.

    Attributes:
        topic: its topic.
        kind: name of its schema.
        time: when it is sent, [s].
        data: its fields as plain data.
    """

    topic: str
    kind: str
    time: float
    data: dict[str, Any]
