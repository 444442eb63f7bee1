"""Check of a request's first line, before anything else reads it."""

from __future__ import annotations

import http
import re

MAX_LINE = 8000
"""Characters of the line; a link to a tab's state has most of them."""
_MAX_SEGMENT = 200
_MAX_SEGMENTS = 20
_LINE = re.compile(rb"([A-Z]{1,16}) ([\x21-\x7e]+) HTTP/1\.([01])\r?")


def problem(line: bytes) -> http.HTTPStatus | None:
    """Fault of the line, without its end; None for none."""
    if len(line) > MAX_LINE:
        return http.HTTPStatus.REQUEST_URI_TOO_LONG
    match = _LINE.fullmatch(line)
    if match is None:
        return http.HTTPStatus.BAD_REQUEST
    method, path, version = match[1], match[2], match[3]
    if version == b"0":
        return http.HTTPStatus.HTTP_VERSION_NOT_SUPPORTED
    if method != b"GET":
        return http.HTTPStatus.METHOD_NOT_ALLOWED
    segments = path.partition(b"?")[0].split(b"/")
    if len(segments) > _MAX_SEGMENTS or max(map(len, segments)) > _MAX_SEGMENT:
        return http.HTTPStatus.REQUEST_URI_TOO_LONG
    if not path.startswith(b"/") or b"%00" in path:
        return http.HTTPStatus.BAD_REQUEST
    return None


def without_query(asked: str) -> str:
    """A request's first line or path as a log may have it: secrets stand in its query."""
    path, mark, _ = asked.partition("?")
    return f"{path}{mark}..." if mark else path
