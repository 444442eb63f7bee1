"""Addresses that a server can listen on, and their URLs."""

from __future__ import annotations

import errno
import os
import socket
from typing import TYPE_CHECKING

import viser

if TYPE_CHECKING:
    from abi.errors import AbiError

_ANY_ADDRESS = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}
"""Wildcard addresses, each with one that a browser can open."""


def usable_address(host: str, port: int) -> str:
    """A bindable address, since viser would otherwise move on to another port.

    It is ``host``; of a name with addresses that are not this machine's, such as ``::1`` without
    IPv6, the first that is.

    Raises:
        AbiError: no address of ``host`` is this machine's, or the port is not to be had.
    """
    usable: list[str] = []
    refused: list[OSError | ValueError] = []
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, ValueError) as error:  # ValueError: cannot be a host's name
        addresses, refused = [], [error]
    for family, kind, protocol, _, address in addresses:
        try:
            with socket.socket(family, kind, protocol) as probe:
                if os.name == "posix":  # as asyncio does; elsewhere it would share a busy port
                    probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind(address)
        except OSError as error:
            refused.append(error)
        else:
            usable.append(str(address[0]))
    for refusal in refused:
        if getattr(refusal, "errno", 0) in (errno.EADDRINUSE, errno.EACCES):
            raise _port_error(port, refusal)
    if usable:
        return usable[0] if refused else host
    from abi.errors import AbiError  # the method takes a second to load

    reason = (getattr(refused[0], "strerror", None) or "no name of a host").lower()
    expected = "an address of this machine, such as 127.0.0.1, or 0.0.0.0 for all of them"
    raise AbiError(f"--host is {host!r}; expected {expected} ({reason}).")


def ensure_port(server: viser.ViserServer, port: int) -> None:
    """Stop a server whose ``port`` was taken since the test.

    Raises:
        AbiError: it listens on another one.
    """
    if port not in (0, server.get_port()):
        server.stop()
        raise _port_error(port, OSError(errno.EADDRINUSE, os.strerror(errno.EADDRINUSE)))


def listening_url(host: str, port: int) -> str:
    """URL that a browser on this machine can open."""
    if host in _ANY_ADDRESS:
        host = _ANY_ADDRESS[host]
    elif ":" in host:
        host = f"[{host}]"
    return f"http://{host}:{port}"


def _port_error(port: int, error: OSError | ValueError) -> AbiError:
    from abi.errors import AbiError

    if getattr(error, "errno", None) == errno.EACCES:
        return AbiError(
            f"--port is {port}, which this user may not open.", "Take one from 1024 on."
        )
    return AbiError(
        f"--port is {port}, which another program uses.",
        "End that one, or take another; 0 stands for any that is free.",
    )
