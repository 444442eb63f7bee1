"""Limits on the files that one tab sends."""

from __future__ import annotations

import time
from pathlib import PurePosixPath
from typing import Any

from app.guard.messages import UploadPart, UploadStart
from app.ui import page

MAX_TRANSFERS = 2
"""Most files that one tab sends at once."""


class Uploads:
    """Uploads of one tab: what was announced of each and has not arrived yet."""

    def __init__(self) -> None:
        self._missing: dict[str, tuple[int, int]] = {}
        self._begun: dict[str, float] = {}

    def begins(self, start: UploadStart, button: Any) -> bool:
        """Check whether an announced file may come: the button accepts its kind."""
        kinds = [kind.strip().lower() for kind in str(button.mime_type).split(",")]
        suffix = PurePosixPath(start.filename).suffix.lower()
        named = [kind for kind in kinds if kind.startswith(".")]
        if named and suffix not in named:
            return False
        self._forget_late()
        if len(self._missing) >= MAX_TRANSFERS or start.transfer_uuid in self._missing:
            return False
        if start.part_count > 0:
            self._missing[start.transfer_uuid] = (start.size_bytes, start.part_count)
            self._begun[start.transfer_uuid] = time.monotonic()
        return True

    def continues(self, part: UploadPart) -> bool:
        """Check whether a part belongs to a file that was announced with room for it."""
        size, count = self._missing.get(part.transfer_uuid, (0, 0))
        size, count = size - len(part.content), count - 1
        if size < 0 or count < 0:
            return False
        if count == 0:
            self._forget(part.transfer_uuid)
        else:
            self._missing[part.transfer_uuid] = (size, count)
        return True

    def _forget_late(self) -> None:
        """Forget overdue uploads, so that others may come."""
        end = time.monotonic() - page.LIFETIME
        for transfer in [name for name, begin in self._begun.items() if begin <= end]:
            self._forget(transfer)

    def _forget(self, transfer: str) -> None:
        del self._missing[transfer], self._begun[transfer]
