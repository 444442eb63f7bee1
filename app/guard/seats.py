"""Tabs of every process behind one address, counted together."""

from __future__ import annotations

import mmap
from pathlib import Path

NAME = "seats"
_ABSENT = -1


class Seats:
    """Memory-mapped file with the number of tabs of each process, -1 while it is not running.

    Attributes:
        own: place of this process.
    """

    def __init__(self, folder: Path, own: int, count: int = 0) -> None:
        """Use entry ``own`` of the folder's file, which has ``count`` entries."""
        path = folder / NAME
        if count:
            path.write_bytes(_ABSENT.to_bytes(4, "little", signed=True) * count)
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)
        self._tabs = memoryview(self._map).cast("i")
        self.own = own

    def note(self, tabs: int) -> None:
        """Publish how many tabs this process has, which also marks it as running."""
        self._tabs[self.own] = tabs

    def vacate(self, place: int) -> None:
        """Mark the process of an entry as gone."""
        self._tabs[place] = _ABSENT

    @property
    def processes(self) -> int:
        """Number of processes, this one included."""
        return len(self._tabs)

    @property
    def elsewhere(self) -> int:
        """Number of tabs of all other processes."""
        return sum(max(tabs, 0) for k, tabs in enumerate(self._tabs) if k != self.own)

    @property
    def are_all_there(self) -> bool:
        """Whether every process is running."""
        return all(tabs != _ABSENT for tabs in self._tabs)
