"""Refused requests: counted, and reported to the log."""

from __future__ import annotations

import http
import logging

from app.guard import request_line

_log = logging.getLogger("abi.web")
_MOST = 100
"""Most reasons that are logged, as anybody can cause more."""
_LONGEST = 80
"""Most characters of a request that are logged."""


class Refusals:
    """Refused requests of one server.

    A page that is refused asks again every second, so each reason is told once. None of the log's
    lines has a request's query, which may have the token.
    """

    def __init__(self) -> None:
        self._told: set[str] = set()

    def note(self, status: http.HTTPStatus, asked: str, address: object, reason: str = "") -> None:
        """Count a refusal and log it.

        Args:
            status: that is answered.
            asked: the request's path or first line.
            address: of whoever asks.
            reason: a sentence for whoever runs the server; empty where the status says it all.
        """
        # takes a tenth of a second to load, and the page is waiting
        from app.process import metrics

        metrics.REFUSED_REQUESTS.labels(status.value).inc()
        fields = {
            "status": status.value,
            "asked": request_line.without_query(asked)[:_LONGEST],
            "address": str(address),
        }
        level = logging.INFO
        if reason:
            is_new = reason not in self._told and len(self._told) < _MOST
            level = logging.WARNING if is_new else logging.DEBUG
            fields["why"] = reason
            if is_new:
                self._told.add(reason)
        _log.log(level, "request refused", extra=fields)
