"""Memory available to the processes of this machine or container together."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

_GROUPS = Path("/sys/fs/cgroup")
_OWN = Path("/proc/self/cgroup")


def memory_in_all(groups: Path = _GROUPS, own: Path = _OWN) -> int | None:
    """Bytes of the machine, or of the container if that is less; None if unknown.

    Args:
        groups: where the system shows control groups, of version 2 or 1.
        own: file that names those of this process.
    """
    found = [*_machine(), *_limits(groups, own)]
    return min(found, default=None)


def _machine() -> Iterator[int]:
    try:
        yield os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # Windows has no sysconf
        return


def _limits(groups: Path, own: Path) -> Iterator[int]:
    """Memory limits of the control group and its visible parents.

    A container often sees its own group as the top one, under whatever path its host knows it.
    """
    try:
        lines = own.read_text().splitlines()
    except OSError:
        return
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            top, name = groups, "memory.max"
        elif "memory" in controllers.split(","):
            top, name = groups / "memory", "memory.limit_in_bytes"
        else:
            continue
        group = PurePosixPath(path.lstrip("/"))
        for folder in (group, *group.parents):
            try:
                text = (top / folder / name).read_text().strip()
            except OSError:
                continue
            if text.isdecimal():  # "max" is no limit
                yield int(text)
