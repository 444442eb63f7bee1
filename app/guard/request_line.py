"""Validation of a request's first line before anything else reads it."""

from __future__ import annotations

import http
import re

MAX_LINE = 8000
"""Most characters of the line; links that hold a tab's state are the longest."""
_MAX_SEGMENT = 200
_MAX_SEGMENTS = 20
_LINE = re.compile(rb"([A-Z]{1,16}) ([\x21-\x7e]+) HTTP/1\.([01])\r?")


def problem(line: bytes) -> http.HTTPStatus | None:
    """Fault of the line, given without its line break; None if it is valid."""
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
    """The line or path without its query, which may hold secrets, for the log."""
    path, mark, _ = asked.partition("?")
    return f"{path}{mark}..." if mark else path
