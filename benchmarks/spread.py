"""Spread of a server's tabs over its processes, on Linux."""

from __future__ import annotations

import contextlib
import os
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

_ESTABLISHED = "01"
_FAMILIES = ("tcp", "tcp6")


def process_family(number: int) -> list[int]:
    """A process, and all that it and they have started.

    By each process's parent: a list of children leaves out some while another of them ends.
    """
    children = defaultdict(list)
    for entry in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            children[_parent(int(entry.name))].append(int(entry.name))
    found = [number]
    for one in found:  # which grows meanwhile
        found += children[one]
    return found


def _parent(number: int) -> int:
    status = Path(f"/proc/{number}/stat").read_text()
    return int(status.rpartition(")")[2].split()[1])


def serving_processes(number: int) -> list[int]:
    """The processes of ``abi serve``, without those that compile or read files.

    These look like the one that starts them for a moment; only the first one starts workers.
    """
    found = [number]
    for one in process_family(number):
        with contextlib.suppress(OSError):
            command = Path(f"/proc/{one}/cmdline").read_bytes()
            if _parent(one) == number and b"\0--joins\0" in command:
                found.append(one)
    return found


def spread(number: int, url: str) -> list[int]:
    """Number of open connections of each process, of a server of this number at this address."""
    wanted = set(_connections(urlsplit(url).port or 0))
    return [len(wanted & set(_sockets(one))) for one in serving_processes(number)]


def _connections(port: int) -> Iterator[str]:
    """Identities of the open connections that others have made to a port of this machine."""
    for family in _FAMILIES:
        with contextlib.suppress(OSError):
            for line in Path(f"/proc/net/{family}").read_text("ascii").splitlines()[1:]:
                fields = line.split()
                own_port = int(fields[1].rpartition(":")[2], 16)
                if own_port == port and fields[3] == _ESTABLISHED:
                    yield fields[9]


def _sockets(number: int) -> Iterator[str]:
    """Identities of a process's sockets."""
    for file in Path(f"/proc/{number}/fd").glob("*"):
        with contextlib.suppress(OSError):
            target = os.readlink(file)
            if target.startswith("socket:["):
                yield target.removeprefix("socket:[").removesuffix("]")
