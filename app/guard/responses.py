"""Responses of the server itself: short texts for programs, small pages for people."""

from __future__ import annotations

import html
import http

from websockets.datastructures import Headers
from websockets.http11 import Response

_STYLE = (
    "body{font:18px/1.5 system-ui,sans-serif;max-width:34em;margin:18vh auto;padding:0 1em;"
    "color-scheme:light dark}"
)
_RELOAD = 15
"""Seconds after which the page of a full server reloads."""

_ODD = {
    http.HTTPStatus.BAD_REQUEST: "The first line of the request is not one of HTTP/1.1.",
    http.HTTPStatus.METHOD_NOT_ALLOWED: "This server answers GET alone.",
    http.HTTPStatus.REQUEST_URI_TOO_LONG: "The address is too long.",
    http.HTTPStatus.HTTP_VERSION_NOT_SUPPORTED: (
        "The request is one of HTTP/1.0, which has no websockets. Let the proxy speak HTTP/1.1 "
        "(in nginx: proxy_http_version 1.1)."
    ),
}
"""Explanations of invalid request lines."""


def text(status: http.HTTPStatus, body: str, kind: str = "text/plain; charset=utf-8") -> Response:
    """Plain-text response."""
    content = body.encode()
    headers = Headers()
    headers["Content-Type"] = kind
    headers["Content-Length"] = str(len(content))
    headers["Connection"] = "close"
    headers["Cache-Control"] = "no-store"
    return Response(status.value, status.phrase, headers, content)


def misunderstood(status: http.HTTPStatus) -> Response:
    """Answer to a request whose first line is invalid."""
    response = text(status, f"{_ODD.get(status, status.phrase)}\n")
    if status is http.HTTPStatus.METHOD_NOT_ALLOWED:
        response.headers["Allow"] = "GET"
    return response


def odd_reason(status: http.HTTPStatus) -> str:
    """Reason of an invalid first line that the operator should know; empty for none."""
    return _ODD[status] if status is http.HTTPStatus.HTTP_VERSION_NOT_SUPPORTED else ""


def full(tabs: int) -> Response:
    """Page of a server that is full."""
    response = _page(
        http.HTTPStatus.SERVICE_UNAVAILABLE,
        "All places are taken",
        f"{full_sentence(tabs)} The page looks again every {_RELOAD} seconds.",
        f'<meta http-equiv="refresh" content="{_RELOAD}">',
    )
    response.headers["Retry-After"] = str(_RELOAD)
    return response


def full_sentence(tabs: int) -> str:
    """Sentence on why nobody else is admitted."""
    return f"This visualiser is shown in {tabs} tabs at once, and all of them are in use."


def token_needed() -> Response:
    """Page for visitors without the token."""
    return _page(
        http.HTTPStatus.UNAUTHORIZED,
        "The link is not complete",
        "Open the whole link that the server printed when it started; it ends in ?token=… "
        "Whoever started the server can give it to you.",
    )


def see_other(place: str, cookie: str = "") -> Response:
    """Redirect to ``place``, setting ``cookie`` unless it is empty."""
    response = text(http.HTTPStatus.SEE_OTHER, "")
    response.headers["Location"] = place
    if cookie:
        response.headers["Set-Cookie"] = cookie
    return response


def _page(status: http.HTTPStatus, title: str, sentence: str, head: str = "") -> Response:
    body = (
        f'<!doctype html><html lang="en"><meta charset="utf-8">{head}'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style>"
        f"<h1>{html.escape(title)}</h1><p>{html.escape(sentence)}</p></html>"
    )
    return text(status, body, "text/html; charset=utf-8")
