"""Tabs of every process behind one address, counted together."""

from __future__ import annotations

import mmap
from pathlib import Path

NAME = "seats"
_ABSENT = -1


class Seats:
    """A file that all processes map, with a number for each: its tabs, or -1 while it is not there.

    Attributes:
        own: place of this process.
    """

    def __init__(self, folder: Path, own: int, count: int = 0) -> None:
        """Take the place ``own`` in the folder's file, which is made for ``count`` processes."""
        path = folder / NAME
        if count:
            path.write_bytes(_ABSENT.to_bytes(4, "little", signed=True) * count)
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)
        self._tabs = memoryview(self._map).cast("i")
        self.own = own

    def note(self, tabs: int) -> None:
        """Tell the others how many tabs this process has: from now on, it is there."""
        self._tabs[self.own] = tabs

    def vacate(self, place: int) -> None:
        """Note that the process at a place is gone."""
        self._tabs[place] = _ABSENT

    @property
    def processes(self) -> int:
        """Number of processes, this one included."""
        return len(self._tabs)

    @property
    def elsewhere(self) -> int:
        """Number of tabs of all the other processes."""
        return sum(max(tabs, 0) for k, tabs in enumerate(self._tabs) if k != self.own)

    @property
    def are_all_there(self) -> bool:
        """Whether every process listens."""
        return all(tabs != _ABSENT for tabs in self._tabs)
