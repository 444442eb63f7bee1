"""Rules for visitors: who may come, and how many."""

from __future__ import annotations

import ipaddress
import re
import secrets
import socket
from dataclasses import dataclass
from urllib.parse import urlsplit

MAX_TABS = 60
_NAMES = ("localhost",)
_HOST = re.compile(r"[\w.-]+|[0-9a-f:.]+")
"""A host name, or an IPv6 address without brackets."""


@dataclass(frozen=True)
class Policy:
    """Rules of one server.

    Attributes:
        token: secret that a visitor must know; None lets everybody in.
        hosts: names and addresses, without a port, under which the server may be asked.
        any_address: whether every numeric address is one of them.
        origins: whole origins, e.g. ``https://abi.example.org``, besides the server's own.
        embedders: origins whose pages may show the visualiser in a frame.
        max_tabs: number of tabs at once.
    """

    token: str | None = None
    hosts: frozenset[str] = frozenset({*_NAMES, "127.0.0.1", "::1"})
    any_address: bool = False
    origins: frozenset[str] = frozenset()
    embedders: tuple[str, ...] = ()
    max_tabs: int = MAX_TABS


def policy_for(
    host: str,
    token: str | None = None,
    needs_token: bool = True,
    origins: tuple[str, ...] = (),
    embedders: tuple[str, ...] = (),
    max_tabs: int = MAX_TABS,
) -> Policy:
    """Rules for a server that listens on ``host``.

    Args:
        host: a name or address of this machine.
        token: the secret; without one, one is made where others can reach the server.
        needs_token: False: whoever can reach the server may use it.
        origins: public URLs under which a proxy shows the server.
        embedders: origins whose pages may show it in a frame.
        max_tabs: number of tabs at once.

    Raises:
        AbiError: an origin is none.
    """
    public = frozenset(_origin("--origin", text) for text in origins)
    framing = tuple(_origin("--embed-in", text) for text in embedders)
    local = is_loopback(host)
    if token is None and needs_token and not (local and not public):
        token = secrets.token_urlsafe(24)
    names = {*Policy.hosts, *(urlsplit(origin).hostname or "" for origin in public)}
    if not local:
        name = socket.gethostname().lower()
        names |= {host.lower(), name, name.partition(".")[0], f"{name.partition('.')[0]}.local"}
    return Policy(
        token=token if needs_token else None,
        hosts=frozenset(names),
        any_address=not local,
        origins=public,
        embedders=framing,
        max_tabs=max_tabs,
    )


def is_loopback(host: str) -> bool:
    """Check whether only this machine can reach a server on ``host``."""
    if host in _NAMES:
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _origin(option: str, text: str) -> str:
    """The origin of a URL, as browsers write it."""
    try:
        parts = urlsplit(text)
        port = parts.port
    except ValueError:
        parts, port = urlsplit(""), None
    host = parts.hostname or ""
    if parts.scheme not in ("http", "https") or not _HOST.fullmatch(host) or not text.isascii():
        from abi.errors import AbiError  # the method takes a second to load

        raise AbiError(f"{option} is {text!r}; expected a URL such as https://abi.example.org.")
    name = f"[{host}]" if ":" in host else host
    default = port in (None, 443 if parts.scheme == "https" else 80)
    return f"{parts.scheme}://{name}" + ("" if default else f":{port}")
