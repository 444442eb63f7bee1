"""The page behind a proxy, below a path that is not the server's own."""

from __future__ import annotations

import http.client
import http.server
import os
import shutil
import socket
import subprocess
import threading
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, expect
from playwright.sync_api import Page as Tab

from app.guard.policy import policy_for
from app.server.server import Server, start
from app.state.appearance import PLAIN
from tests.app.fake_tab import until
from tests.browser.page import Page
from tests.ports import free_port

SAMPLE = Path(__file__).parents[2] / "hosting" / "nginx.conf"
TOKEN = "a secret"


USUAL = """
events {{}}
http {{
  access_log off;
  server {{
    listen 127.0.0.1:{port};
    location / {{
      proxy_pass http://127.0.0.1:{replica};
      {rules}
    }}
  }}
}}
"""
"""What people write for any site: it drops the port from Host, or speaks HTTP/1.0."""
UPGRADE = 'proxy_set_header Upgrade $http_upgrade; proxy_set_header Connection "upgrade";'


@contextmanager
def _nginx(folder: Path, port: int, replicas: Sequence[int]) -> Iterator[None]:
    """nginx with the sample's rules on ``port``, before replicas on the ports of this machine."""
    text = SAMPLE.read_text(encoding="utf-8")
    servers = " ".join(f"server 127.0.0.1:{replica};" for replica in replicas)
    assert "server abi:8080;" in text
    text = text.replace("server abi:8080;", servers)
    text = text.replace("listen 8000;", f"listen 127.0.0.1:{port};")
    assert "/var/log/nginx/access.log" in text
    text = text.replace("/var/log/nginx/access.log", f"{folder}/requests")
    with _running_nginx(folder, port, text):
        yield


@contextmanager
def _running_nginx(folder: Path, port: int, text: str) -> Iterator[None]:
    """nginx with the rules of a text, which has it listen on ``port``."""
    # Debian keeps it where only root's PATH leads
    program = shutil.which("nginx", path=f"{os.environ['PATH']}:/usr/sbin")
    if program is None:
        pytest.fail("No nginx: 'make test' installs Debian's; 'make check' leaves it out.", False)
    config = folder / "nginx.conf"
    config.write_text(text, encoding="utf-8")
    rules = f"daemon off; pid {folder}/pid; error_log {folder}/errors;"
    process = subprocess.Popen([program, "-p", folder, "-c", config, "-g", rules])
    try:
        until(lambda: _listens(port))
        yield
    finally:
        process.terminate()
        process.wait(timeout=30)


def _listens(port: int) -> bool:
    with suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=5):
        return True
    return False


@pytest.fixture
def hosted(tmp_path: Path) -> Iterator[tuple[Server, str]]:
    """A server, and its address behind nginx."""
    port = free_port()
    public = f"http://127.0.0.1:{port}"
    server = start(
        port=0,
        scene="paper",
        policy=policy_for("127.0.0.1", TOKEN, origins=(public,)),
        look=PLAIN,
    )
    with _nginx(tmp_path, port, [server.viser.get_port()]):
        yield server, f"{public}/abi/"
    server.stop()


def _status(url: str, path: str) -> int:
    connection = http.client.HTTPConnection(url.split("/")[2], timeout=30)
    connection.request("GET", path)
    status = connection.getresponse().status
    connection.close()
    return status


def test_nginx_shows_the_page_below_a_path(
    chromium: Browser, hosted: tuple[Server, str], tmp_path: Path
) -> None:
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
    requests = (tmp_path / "requests").read_text(encoding="utf-8")
    assert '"GET /abi/" 303' in requests
    assert "secret" not in requests


def test_the_page_says_why_nothing_comes_through_a_proxy(
    chromium: Browser, server: Server, tmp_path: Path
) -> None:
    # both at once, since the page waits before it says what it thinks
    cards: list[tuple[Locator, str]] = []
    with ExitStack() as proxies:
        for rules, words in (
            (f"proxy_http_version 1.1; proxy_set_header Host $host; {UPGRADE}", "--origin {url}"),
            ("proxy_http_version 1.1; proxy_set_header Host $http_host;", "Upgrade and Connection"),
        ):
            port = free_port()
            url = f"http://localhost:{port}"
            text = USUAL.format(port=port, replica=server.viser.get_port(), rules=rules)
            (folder := tmp_path / str(port)).mkdir()
            proxies.enter_context(_running_nginx(folder, port, text))
            tab = proxies.enter_context(chromium.new_context()).new_page()
            tab.goto(url)
            cards.append((tab.locator("#abi-connecting"), words.format(url=url)))
        for card, words in cards:
            expect(card).to_contain_text(words, timeout=60_000)
            assert not _is_loading(card.page)
            # as the first word through a websocket does
            card.page.evaluate("window.abi = {}")
            expect(card).to_have_count(0, timeout=60_000)


def _is_loading(tab: Tab) -> bool:
    """Whether the page still says that it is loading."""
    style = "getComputedStyle(document.body, '::after')"
    return bool(tab.evaluate(f"{style}.display !== 'none' && {style}.content !== 'none'"))


def test_a_proxy_of_http_1_0_shows_what_it_has_to_do(server: Server, tmp_path: Path) -> None:
    port = free_port()
    rules = "proxy_http_version 1.0;"
    text = USUAL.format(port=port, replica=server.viser.get_port(), rules=rules)
    with _running_nginx(tmp_path, port, text):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
        connection.request("GET", "/")
        assert "Let the proxy speak HTTP/1.1" in connection.getresponse().read().decode()
        connection.close()


class _Replica(http.server.ThreadingHTTPServer):
    """Answers every request with its port."""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Answer)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def end(self) -> None:
        self.shutdown()
        self.server_close()


class _Answer(http.server.BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        assert isinstance(self.server, _Replica)
        text = str(self.server.server_port).encode()
        self.send_response(200)
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text)

    def log_message(self, *args: object) -> None:
        """Say nothing."""


def _visit(port: int, path: str, cookie: str, upgrade: str = "") -> tuple[int, str]:
    """Port of the replica that answers, and the cookie that it sets."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
    headers = {"Cookie": cookie} if cookie else {}
    connection.request("GET", path, headers=headers | ({"Upgrade": upgrade} if upgrade else {}))
    response = connection.getresponse()
    found = int(response.read()), response.getheader("Set-Cookie", "")
    connection.close()
    return found


def test_each_visitor_stays_with_one_replica_and_all_replicas_have_visitors(
    tmp_path: Path,
) -> None:
    # replicas that share a name, as compose's do, would get turns from a consistent hash
    assert "consistent;" not in SAMPLE.read_text(encoding="utf-8")
    replicas = [_Replica(), _Replica()]
    ports = [replica.server_port for replica in replicas]
    port = free_port()
    visitors: dict[int, list[str]] = defaultdict(list)
    with _nginx(tmp_path, port, ports):
        for _ in range(40):  # all from one address, as a class behind its school's router
            first, cookie = _visit(port, "/abi/", "")
            place = cookie.partition(";")[0]
            assert "HttpOnly" in cookie
            again = [_visit(port, "/abi/", place) for _ in range(3)]
            again += [_visit(port, "/abi?x=1", place, upgrade="websocket")]
            assert again == [(first, "")] * 4
            visitors[first].append(place)
        assert {*visitors} == {*ports}

        # one is gone: its visitors find the other
        gone, other = replicas
        gone.end()
        for place in visitors[ports[0]]:
            assert _visit(port, "/abi/", place)[0] == ports[1]
    other.end()
