"""Launcher entry for JupyterLab and JupyterHub, through jupyter-server-proxy."""

from __future__ import annotations

import secrets
import sys


def server() -> dict[str, object]:
    """Configuration for jupyter-server-proxy: the command to start and where its pages are.

    Jupyter knows who its users are. The token keeps others on the same machine out: it goes from
    the proxy to the visualiser with every request, and never to a browser.
    """
    token = secrets.token_urlsafe(24)
    return {
        "command": [sys.executable, "-m", "app", "serve", "--no-open", "--port", "{port}"],
        "environment": {"ABI_TOKEN": token},
        "request_headers_override": {"Authorization": f"Bearer {token}"},
        "timeout": 60,
        "launcher_entry": {"title": "ABI visualiser"},
    }
