"""Checks of a request's Host and Origin: no foreign page can drive a server through a browser.

A foreign page may ask for the server by a name that its owner points at the visitor's machine
(DNS rebinding): its Host is refused. It may open a websocket to the server's own address: the
browser then says so in Origin, which is refused. A request without an Origin comes from a program,
not from a page, and a program could send any Origin.
"""

from __future__ import annotations

import ipaddress
from urllib.parse import urlsplit

from websockets.datastructures import Headers

from app.guard.policy import Policy


def is_known_host(policy: Policy, headers: Headers) -> bool:
    """Check whether the request asks for a name or address that is the server's."""
    host = single(headers, "Host")
    name = None if host is None else _name(host)
    if name is None:
        return False
    return name in policy.hosts or (policy.any_address and _is_address(name))


def is_own_origin(policy: Policy, headers: Headers) -> bool:
    """Check whether a websocket comes from the server's own page, or from no page at all."""
    if not headers.get_all("Origin"):
        return True
    origin = single(headers, "Origin")
    if origin is None:
        return False
    if origin in policy.origins:
        return True
    scheme, _, place = origin.partition("://")
    return scheme in ("http", "https") and place != "" and place == single(headers, "Host")


def single(headers: Headers, name: str) -> str | None:
    """Value of a header that stands once; None otherwise."""
    values = headers.get_all(name)
    return values[0] if len(values) == 1 else None


def _name(host: str) -> str | None:
    """Name or address in ``name:port``, in lower case; None where it is neither."""
    try:
        parts = urlsplit(f"//{host}")
        port = parts.port
    except ValueError:
        return None
    if parts.hostname is None or parts.username is not None or parts.path or parts.query:
        return None
    del port  # reading it has checked it
    return parts.hostname.lower()


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
