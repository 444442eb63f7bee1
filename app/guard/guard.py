"""The guard of one server: answers requests, and lets tabs in."""

from __future__ import annotations

import http
import logging
import weakref
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.guard import request_line, responses, token
from app.guard.host_check import host_fault, origin_fault, single
from app.guard.messages import GizmoUpdate
from app.guard.page_file import Pages, file_response, page_response
from app.guard.policy import Policy
from app.guard.porter import Porter
from app.guard.security_headers import secure, security_headers
from app.guard.side_door import SideDoor
from app.ui import page

if TYPE_CHECKING:
    import viser

_log = logging.getLogger("abi.web")

_PAGES = ("/", "/index.html")
_HEALTH = "/healthz"
_CONNECTION = "/connection"
"""Path where a page asks why it gets no connection; see ``assets/page/connecting.js``."""
_MOST = 100
"""Most reasons of refusals that are logged, as anybody can cause more."""
_LONGEST = 80
"""Most characters of a request that are logged."""


class Guard:
    """Decides who is admitted and how requests are answered.

    Attributes:
        policy: the rules.
        connections: all that are open, requests for the page's files included.
        tabs: those of them that are tabs.
        entrance: by which connections come in where several processes serve the address; None
            where this one is alone.
        viser: the server, once it is built.
        ready: whether plans can be made.
    """

    def __init__(self, policy: Policy, entrance: Porter | SideDoor | None = None) -> None:
        self.policy = policy
        self.entrance = entrance
        self.connections: weakref.WeakSet[ServerConnection] = weakref.WeakSet()
        self.tabs: set[ServerConnection] = set()
        self.viser: viser.ViserServer | None = None
        self.ready = False
        self._told: set[str] = set()  # reasons of refusals in the log
        self._headers = security_headers(policy)

    @property
    def is_full(self) -> bool:
        """Whether the server has as many tabs as it takes, those of other processes included."""
        elsewhere = 0 if self.entrance is None else self.entrance.elsewhere
        return len(self.tabs) + elsewhere >= self.policy.max_tabs

    def hang_up(self) -> None:
        """Close the connections that belong to no tab, on the server's loop; some close slowly."""
        for connection in tuple(self.connections - self.tabs):
            connection.transport.abort()

    def answer(
        self, pages: Pages, connection: ServerConnection, request: Request
    ) -> Response | None:
        """Answer to a request; None opens a websocket."""
        found, reason = self._answer(pages, connection, request), ""
        if isinstance(found, str):
            reason, found = found, responses.text(http.HTTPStatus.FORBIDDEN, f"{found}\n")
        # what watches over the server asks again and again while it starts
        is_health = request.path.partition("?")[0] == _HEALTH
        if found is not None and found.status_code >= http.HTTPStatus.BAD_REQUEST and not is_health:
            status = http.HTTPStatus(found.status_code)
            self.note_refusal(status, request.path, connection.remote_address, reason)
        return found

    def note_refusal(
        self, status: http.HTTPStatus, asked: str, address: object, reason: str = ""
    ) -> None:
        """Count a refused request and log it.

        A page that is refused asks again every second, so each reason is told once. None of the
        log's lines has a request's query, which may have the token.

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

    def secured(self, response: Response) -> Response:
        """Add the security headers to an answer."""
        secure(response, self._headers)
        return response

    def widget(self, connection: ServerConnection, uuid: str) -> Any:
        """Find the widget of a tab by its id; None if there is none."""
        return None if self.viser is None else page.widget(self.viser, connection, uuid)

    def move_gizmo(self, connection: ServerConnection, update: GizmoUpdate) -> bool:
        """Move a gizmo of the tab's own; whether viser need not see the message."""
        if self.viser is None or (tab := page.tab(self.viser, connection)) is None:
            return False
        return page.move_gizmo(tab, update.name, update.owner, update.wxyz, update.position)

    def _answer(
        self, pages: Pages, connection: ServerConnection, request: Request
    ) -> Response | str | None:
        """Answer to a request, or what is wrong with it, for the operator to know, too."""
        path = request.path.partition("?")[0]
        if path == _HEALTH:
            return self._health()
        # a proxy that knows the token has its own ways to tell its users from others
        trusted = self.policy.token is not None and token.is_bearer(
            request.headers, self.policy.token
        )
        if not trusted and (fault := host_fault(self.policy, request.headers)):
            return fault
        if (response := self._check_token(connection, request, path in _PAGES)) is not None:
            return response
        if path == "/metrics":
            from app.process import metrics

            return responses.text(http.HTTPStatus.OK, *metrics.text())
        upgrade = (request.headers.get("Upgrade") or "").lower()
        if path == "/" and not upgrade and request.headers.get_all("X-Forwarded-Prefix"):
            # the page opens its websocket without the last slash, and not every proxy below a path
            # takes one there: jupyter-server-proxy does not
            query = request.path.partition("?")[2]
            return responses.see_other(f"./index.html?{query}" if query else "./index.html")
        if upgrade == "websocket":
            if not trusted and (fault := origin_fault(self.policy, request.headers)):
                return fault
            return responses.full(self.policy.max_tabs) if self.is_full else None
        if path == _CONNECTION:
            return responses.text(http.HTTPStatus.OK, "" if trusted else self._lack_of(request))
        if path in _PAGES:
            full = self.is_full
            return responses.full(self.policy.max_tabs) if full else page_response(request)
        return file_response(pages, connection, request)

    def _lack_of(self, request: Request) -> str:
        """Reason why a page with an Origin header gets no connection; empty if none is known."""
        if self.is_full:
            return responses.full_sentence(self.policy.max_tabs)
        query = parse_qs(urlsplit(request.path).query)
        host = single(request.headers, "Host") or ""
        return origin_fault(self.policy, Headers(Host=host, Origin=query.get("origin", [""])[0]))

    def _health(self) -> Response:
        if self.ready:
            return responses.text(http.HTTPStatus.OK, "ok\n")
        return responses.text(http.HTTPStatus.SERVICE_UNAVAILABLE, "starting\n")

    def _check_token(
        self, connection: ServerConnection, request: Request, is_page: bool
    ) -> Response | None:
        """Answer to a request without the token, or with it in the link still; None admits it."""
        secret = self.policy.token
        if secret is None:
            return None
        port = connection.local_address[1]
        if token.in_query(request.path, secret):
            if not is_page:
                return None
            secure = request.headers.get("X-Forwarded-Proto") == "https"
            cookie = token.cookie(secret, port, secure)
            return responses.see_other(token.without_token(request.path), cookie)
        if token.in_headers(request.headers, secret, port):
            return None
        return responses.token_needed()
