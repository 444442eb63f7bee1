"""The page's files: viser's, the first with a script that says why there is no connection.

viser's page goes on connecting for ever, and no page can read why its websocket was refused.
"""

from __future__ import annotations

import functools
import gzip
import http
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import viser
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from abi import assets
from app.guard import responses

Pages: TypeAlias = Callable[[ServerConnection, Request], Response | None]
"""viser's own handler, which serves the page's files."""

_END = "</head>"


@functools.cache
def page_text() -> str:
    """The whole page, as HTML."""
    file = Path(viser.__file__).parent / "client" / "build" / "index.html"
    script = assets.path("page", "connecting.js").read_text(encoding="utf-8")
    head, end, body = file.read_text(encoding="utf-8").rpartition(_END)
    assert end, "viser's page has no head"
    return f"{head}<script>{script}</script>{end}{body}"


def page_response(request: Request) -> Response:
    """Answer with the page, compressed where the browser takes that."""
    is_small = "gzip" in request.headers.get("Accept-Encoding", "")
    content = _compressed() if is_small else page_text().encode()
    headers = Headers()
    headers["Content-Type"] = "text/html; charset=utf-8"
    headers["Content-Length"] = str(len(content))
    if is_small:
        headers["Content-Encoding"] = "gzip"
    headers["Cache-Control"] = "no-cache"
    headers["Vary"] = "Accept-Encoding"
    return Response(http.HTTPStatus.OK.value, http.HTTPStatus.OK.phrase, headers, content)


def file_response(pages: Pages, connection: ServerConnection, request: Request) -> Response:
    """Answer with another of the page's files, if there is such a one."""
    try:
        response = pages(connection, request)
    except (OSError, ValueError):
        response = None
    if response is None or response.status_code >= http.HTTPStatus.BAD_REQUEST:
        return responses.text(http.HTTPStatus.NOT_FOUND, "There is no such page.\n")
    response.headers["Cache-Control"] = "no-cache"
    return response


@functools.cache
def _compressed() -> bytes:
    return gzip.compress(page_text().encode())
