"""Checks of a request's Host and Origin: no foreign page can drive a server through a browser.

A foreign page may ask for the server by a name that its owner points at the visitor's machine
(DNS rebinding): its Host is refused. It may open a websocket to the server's own address: the
browser then says so in Origin, which is refused. A request without an Origin comes from a program,
not from a page, and a program could send any Origin.
"""

from __future__ import annotations

import ipaddress
import re
from urllib.parse import urlsplit

from websockets.datastructures import Headers

from app.guard.policy import Policy

_LONGEST = 80
"""Most characters of a header that are quoted."""
_ORIGIN = re.compile(r"https?://[\w.:\[\]-]{1,200}", re.ASCII)
"""An origin that is safe to quote."""


def is_known_host(policy: Policy, headers: Headers) -> bool:
    """Check whether the request's Host is a name or address of this server."""
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


def host_fault(policy: Policy, headers: Headers) -> str:
    """Sentence on a Host header that is not this server's; empty if it is."""
    if is_known_host(policy, headers):
        return ""
    host = single(headers, "Host")
    name = "" if host is None else f" {host[:_LONGEST]!r}"
    return (
        f"This server does not go by the name{name}. "
        "If it should, start it with --origin and the whole URL, such as https://abi.example.org"
    )


def origin_fault(policy: Policy, headers: Headers) -> str:
    """Sentence on a websocket's Origin that is not this server's; empty if it is."""
    if is_own_origin(policy, headers):
        return ""
    origin, host = single(headers, "Origin"), single(headers, "Host")
    sentence = "Only this server's own page may open a connection here."
    if origin is None or _ORIGIN.fullmatch(origin) is None or host is None:
        return sentence
    return (
        f"{sentence} This one has the Origin {origin} and the Host {host[:_LONGEST]!r}, which must "
        "be the same. If that page is the server's behind a proxy, let the proxy pass on the whole "
        "Host, its port too (in nginx: proxy_set_header Host $http_host), or start the server with "
        f"--origin {origin}"
    )


def single(headers: Headers, name: str) -> str | None:
    """Value of a header that occurs exactly once; None otherwise."""
    values = headers.get_all(name)
    return values[0] if len(values) == 1 else None


def _name(host: str) -> str | None:
    """Name or address in ``name:port``, in lower case; None if it is neither."""
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
