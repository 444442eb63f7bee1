"""Token of a server that others can reach: first in the link, then in a cookie."""

from __future__ import annotations

import hmac
from urllib.parse import parse_qsl, quote, unquote, urlencode

from websockets.datastructures import Headers

QUERY = "token"


def link(url: str, token: str | None) -> str:
    """The URL that admits whoever opens it."""
    return url if token is None else f"{url}/?{urlencode({QUERY: token})}"


def in_query(path: str, token: str) -> bool:
    """Check whether a request's path carries the token."""
    given = [value for key, value in _query(path) if key == QUERY]
    return len(given) == 1 and _equal(given[0], token)


def is_bearer(headers: Headers, token: str) -> bool:
    """Check whether a request carries the token as programs do, ``Authorization: Bearer TOKEN``."""
    values = headers.get_all("Authorization")
    scheme, _, bearer = values[0].partition(" ") if len(values) == 1 else ("", "", "")
    return scheme.lower() == "bearer" and _equal(bearer.strip(), token)


def in_headers(headers: Headers, token: str, port: int) -> bool:
    """Check whether a request carries the token in the cookie or the Authorization header."""
    if is_bearer(headers, token):
        return True
    pairs = [
        part.strip().partition("=")
        for line in headers.get_all("Cookie")
        for part in line.split(";")
    ]
    return any(
        name == _cookie_name(port) and _equal(unquote(value), token) for name, _, value in pairs
    )


def cookie(token: str, port: int, secure: bool) -> str:
    """Header that stores the token in a cookie that scripts and other sites cannot read."""
    flags = "; Secure" if secure else ""
    # Lax, not Strict: a link in a message must lead in although the redirect follows at once
    return f"{_cookie_name(port)}={quote(token, safe='')}; HttpOnly; SameSite=Lax; Path=/{flags}"


def without_token(path: str) -> str:
    """Path of the same page, relative to ``path``, without the token."""
    rest = urlencode([(key, value) for key, value in _query(path) if key != QUERY])
    return f"./?{rest}" if rest else "./"


def _query(path: str) -> list[tuple[str, str]]:
    try:
        return parse_qsl(path.partition("?")[2], keep_blank_values=True, max_num_fields=32)
    except ValueError:
        return []


def _cookie_name(port: int) -> str:
    # browsers keep cookies by host, whatever the port
    return f"abi_token_{port}"


def _equal(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(errors="replace"), token.encode(errors="replace"))
