"""Headers with which the browser runs only the page's own script and loads nothing else."""

from __future__ import annotations

import base64
import hashlib
import re
from functools import lru_cache

from websockets.http11 import Response

from app.guard.page_file import page_text
from app.guard.policy import Policy

_CLIENT = "sha256-o/BTEGoB4UnTxqb+3RxwUFQZkWXpqUxouHkbDNrAkqE="
"""Digest of the script that viser 1.1.1's page unpacks, as a browser's console reports it when it
is blocked."""
_SCRIPT = re.compile(r"<script(?![^>]*\bsrc=)[^>]*>(.+?)</script>", re.DOTALL)


def security_headers(policy: Policy) -> dict[str, str]:
    """Headers of every answer."""
    headers = {
        "Content-Security-Policy": _content_policy(policy),
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
    }
    if not policy.embedders:
        headers["X-Frame-Options"] = "SAMEORIGIN"
    return headers


def secure(response: Response, headers: dict[str, str]) -> None:
    """Add the headers to an answer."""
    for name, value in headers.items():
        if name not in response.headers:
            response.headers[name] = value


def _content_policy(policy: Policy) -> str:
    return "; ".join(
        (
            "default-src 'self'",
            # eval: viser runs what the server sends as text, such as the tab's title
            f"script-src 'self' {_digests(page_text())} 'unsafe-eval' 'wasm-unsafe-eval' blob:",
            "worker-src 'self' blob: data:",
            "style-src 'self' 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src 'self' data:",
            "connect-src 'self' data: blob:",
            "object-src 'none'",
            "frame-src 'none'",
            "base-uri 'none'",
            "form-action 'none'",
            " ".join(("frame-ancestors 'self'", *policy.embedders)),
        )
    )


@lru_cache(maxsize=2)  # to look through the page takes half as long as to start a server
def _digests(page: str) -> str:
    return " ".join(f"'{digest}'" for digest in (*map(_digest, _SCRIPT.findall(page)), _CLIENT))


def _digest(script: str) -> str:
    # browsers normalise line ends before they take the digest
    content = script.replace("\r\n", "\n").encode()
    return "sha256-" + base64.b64encode(hashlib.sha256(content).digest()).decode()
