"""The page behind a proxy, below a path that is not the server's own."""

from __future__ import annotations

import http.client
import shutil
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from app.guard.policy import policy_for
from app.server import Server, start
from tests.browser.page import Page

SAMPLE = Path(__file__).parents[2] / "hosting" / "nginx.conf"
TOKEN = "a secret"


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def hosted(tmp_path: Path) -> Iterator[tuple[Server, str]]:
    """A server, and its address behind nginx."""
    port = _free_port()
    public = f"http://127.0.0.1:{port}"
    server = start(port=0, plain=True, policy=policy_for("127.0.0.1", TOKEN, origins=(public,)))
    text = SAMPLE.read_text(encoding="utf-8")
    text = text.replace("server abi:8080;", f"server 127.0.0.1:{server.viser.get_port()};")
    text = text.replace("listen 8000;", f"listen 127.0.0.1:{port};")
    config = tmp_path / "nginx.conf"
    config.write_text(text.replace("http {", "http { access_log off;", 1), encoding="utf-8")
    rules = f"daemon off; pid {tmp_path}/pid; error_log {tmp_path}/errors;"
    process = subprocess.Popen(["nginx", "-p", tmp_path, "-c", config, "-g", rules])
    yield server, f"{public}/abi/"
    process.terminate()
    process.wait(timeout=30)
    server.stop()


def _status(url: str, path: str) -> int:
    connection = http.client.HTTPConnection(url.split("/")[2], timeout=30)
    connection.request("GET", path)
    status = connection.getresponse().status
    connection.close()
    return status


@pytest.mark.skipif(shutil.which("nginx") is None, reason="there is no nginx on this machine")
def test_nginx_shows_the_page_below_a_path(chromium: Browser, hosted: tuple[Server, str]) -> None:
    server, url = hosted
    page = Page(chromium, f"{url}?token={TOKEN}")
    page.until(lambda: bool(server.sessions), "a session through nginx")
    (session,) = server.sessions.values()
    page.until(lambda: session.plan is not None, "a plan")
    page.node("/obstacle_1")
    page.set_number("degree", 3)
    page.until(lambda: session.plan.scene.spline.degree == 3, "an input through nginx")  # type: ignore[union-attr]
    assert page.tab.url.startswith(url)
    assert TOKEN not in page.tab.url
    assert page.errors == []
    assert _status(url, "/abi/") == 401
    assert _status(url, "/abi/metrics") == 404
    page.close()
