"""Uploads that are arriving or waiting to be read: on disk, with a limit on all together.

A page that sends only a part of a file, or files faster than they are read, would fill the memory
otherwise.
"""

from __future__ import annotations

import io
import tempfile
from collections.abc import Iterator, MutableMapping
from typing import IO

from app.process.available_memory import memory_in_all
from app.process.memory_budget import MemoryBudget, memory_for_uploads

IN_MEMORY = 1_000_000
"""Bytes of an upload beyond which it is kept on disk, if one is writable."""


class StoredUpload(MutableMapping[int, bytes]):
    """Content of one upload by part number, deleted with the last reference to it.

    What finds no memory left reads as zeros, of the same length: whoever puts the parts together
    goes by that.

    Attributes:
        lost: why the file cannot be used; empty as long as it can.
    """

    def __init__(self, budget: MemoryBudget) -> None:
        self._budget = budget
        self._places: dict[int, tuple[int, int]] = {}
        self._end = 0
        self._file = _new_file()
        self.lost = ""

    def __setitem__(self, number: int, content: bytes) -> None:
        size = len(content)
        if not self.lost and not self._budget.take(id(self), self._end + size):
            self._lose("a moment in which the server has fewer files to read; add it again then")
        if not self.lost:
            try:
                self._file.seek(self._end)
                self._file.write(content)
            except OSError:
                self._lose("a moment in which the server has a place to keep it")
        self._places[number] = self._end, size
        self._end += 0 if self.lost else size

    def __getitem__(self, number: int) -> bytes:
        place, size = self._places[number]
        if self.lost:
            return bytes(size)
        self._file.seek(place)
        return self._file.read(size)

    def __delitem__(self, number: int) -> None:
        del self._places[number]

    def __iter__(self) -> Iterator[int]:
        return iter(sorted(self._places))

    def __len__(self) -> int:
        return len(self._places)

    def __del__(self) -> None:
        self.close()

    def content(self) -> bytes:
        """The whole content."""
        return b"".join(self[number] for number in self)

    def close(self) -> None:
        """Release its bytes; it cannot be read afterwards."""
        self._budget.leave(id(self))
        self._end = 0
        self._file.close()

    def _lose(self, expected: str) -> None:
        """Discard the content; ``expected`` says what would work."""
        self.close()
        self.lost = expected


def _new_file() -> IO[bytes]:
    try:
        tempfile.gettempdir()
    except FileNotFoundError:  # nothing can be written, as in a container that is read-only
        return io.BytesIO()
    return tempfile.SpooledTemporaryFile(max_size=IN_MEMORY)


BUDGET = MemoryBudget(memory_for_uploads(memory_in_all()))
"""Memory for all uploads of this process."""
