"""A guarded server, asked and talked to over the wire."""

from __future__ import annotations

import http.client
import logging
import math
import socket
import time
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
import viser
from websockets.exceptions import InvalidStatus

from abi.errors import AbiError
from app.guard import token
from app.guard.connection import BURST, MAX_REFUSED, MESSAGES_PER_SECOND
from app.guard.policy import policy_for
from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.tab.session import Session
from app.ui import page
from tests.app.fake_tab import FakeTab, until

MUCH = 2_000_000
"""Bytes that a page does not read."""
TOO_MANY = 800
"""Moves that a page would send in 40 s."""
TOKEN = "a secret/?&"
HEADERS = (
    "content-security-policy",
    "x-content-type-options",
    "referrer-policy",
    "x-frame-options",
    "cross-origin-opener-policy",
)


@pytest.fixture(scope="module")
def locked() -> Iterator[Server]:
    """A server that needs a token and takes two tabs."""
    running = start(
        port=0,
        scene="paper",
        policy=policy_for("127.0.0.1", TOKEN, max_tabs=2),
        look=PLAIN,
    )
    yield running
    running.stop()


def ask(server: Server, path: str, **headers: str) -> tuple[int, dict[str, str], str]:
    """Status, headers and text of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.viser.get_port(), timeout=30)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    content = answer.read().decode()
    connection.close()
    return answer.status, {name.lower(): value for name, value in answer.getheaders()}, content


def say(server: Server, line: bytes) -> bytes:
    """All that comes back for raw bytes."""
    with socket.create_connection(("127.0.0.1", server.viser.get_port()), timeout=30) as wire:
        wire.sendall(line)
        return b"".join(iter(lambda: wire.recv(65536), b""))


def test_below_a_proxys_path_the_page_has_a_name(locked: Server) -> None:
    """A websocket at the path without its last slash does not come through every proxy."""
    proxy = {"Authorization": f"Bearer {TOKEN}", "X-Forwarded-Prefix": "/user/me/abi"}
    status, headers, _ = ask(locked, "/?darkMode=1", **proxy)
    assert (status, headers["location"]) == (303, "./index.html?darkMode=1")
    assert ask(locked, "/", **proxy)[1]["location"] == "./index.html"
    assert ask(locked, "/index.html", **proxy)[0] == 200
    assert ask(locked, "/", **{**proxy, "Authorization": "Bearer x"})[0] == 401


def test_the_link_leads_to_a_cookie_and_the_cookie_to_the_page(locked: Server) -> None:
    assert ask(locked, "/")[0] == 401
    assert ask(locked, "/?token=wrong")[0] == 401
    assert ask(locked, "/", Cookie="abi_token=x")[0] == 401
    path = locked.link.removeprefix(locked.url)
    status, headers, _ = ask(locked, f"{path}&darkMode=1")
    assert (status, headers["location"]) == (303, "./?darkMode=1")
    cookie = headers["set-cookie"].partition(";")[0]
    status, headers, page = ask(locked, "/", Cookie=cookie)
    assert status == 200
    assert '<div id="root">' in page
    assert all(name in headers for name in HEADERS)

    for good, extra in ((True, {"Cookie": cookie}), (False, {}), (False, {"Cookie": cookie[:-1]})):
        if good:
            FakeTab(locked.url, extra).close()
        else:
            with pytest.raises(InvalidStatus, match="401"):
                FakeTab(locked.url, extra)


@pytest.mark.parametrize("level", ["INFO", "DEBUG"])
def test_no_log_has_the_token(locked: Server, level: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(level, "abi")
    query = locked.link.partition("?")[2]
    port = locked.viser.get_port()
    cookie = token.cookie(TOKEN, port, False).partition(";")[0]
    assert ask(locked, f"/?{query}")[0] == 303
    assert ask(locked, f"/?{query}", Host="evil.example")[0] == 403
    assert ask(locked, f"/none?{query}", Authorization=f"Bearer {TOKEN}", Cookie=cookie)[0] == 404
    # as a proxy asks that was not told to speak HTTP/1.1
    assert b"505" in say(locked, f"GET /?{query} HTTP/1.0\r\n\r\n".encode())
    text = "\n".join(f"{record.getMessage()} {vars(record)}" for record in caplog.records)
    assert "request refused" in text
    assert ("GET /none" in text) is (level == "DEBUG")
    assert all(secret not in text for secret in (TOKEN, query, cookie.partition("=")[2]))


def test_a_foreign_host_or_origin_is_refused_and_the_page_s_own_is_not(server: Server) -> None:
    assert ask(server, "/", Host="evil.example")[0] == 403
    for origin in ("https://evil.example", "null", server.url.replace("http", "https", 1) + "0"):
        with pytest.raises(InvalidStatus, match="403"):
            FakeTab(server.url, {"Origin": origin})
    until(lambda: not server.sessions)
    FakeTab(server.url, {"Origin": server.url}).close()
    until(lambda: not server.sessions)


def test_why_a_page_gets_no_connection_is_told_to_it_and_to_the_log_once(
    server: Server, caplog: pytest.LogCaptureFixture
) -> None:
    """As behind a proxy that leaves the port out of the Host."""
    port = server.viser.get_port()
    page, headers = f"http://localhost:{port + 1}", {"Host": "localhost"}
    request = f"GET / HTTP/1.1\r\nHost: localhost\r\nOrigin: {page}\r\nUpgrade: websocket\r\n\r\n"
    with caplog.at_level(logging.INFO, "abi.web"):
        answers = [say(server, request.encode()).decode() for _ in range(3)]
    assert all(answer.startswith("HTTP/1.1 403 ") for answer in answers)
    body = answers[0].partition("\r\n\r\n")[2]
    for words in (f"Origin {page} ", "Host 'localhost'", f"--origin {page}", "$http_host"):
        assert words in body
    (record,) = (each for each in caplog.records if each.name == "abi.web")
    assert record.levelno == logging.WARNING
    assert vars(record)["why"] == body.strip()

    query = f"/connection?origin={page}"
    assert ask(server, query, **headers)[::2] == (200, body.strip())
    assert ask(server, query, Host=f"localhost:{port + 1}")[::2] == (200, "")
    assert (
        ask(server, "/connection?origin=<b>x</b>", **headers)[2] == body.partition(" This one")[0]
    )
    assert ask(server, query, Host="evil.example")[0] == 403


def test_http_1_0_is_answered_with_what_the_proxy_has_to_do(
    server: Server, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO, "abi.web"):
        answers = [say(server, b"GET / HTTP/1.0\r\nHost: localhost\r\n\r\n") for _ in range(3)]
    assert all(b"proxy_http_version 1.1" in answer for answer in answers)
    (record,) = caplog.records
    assert "proxy_http_version 1.1" in vars(record)["why"]


def test_one_tab_too_many_is_told_so_kindly(locked: Server) -> None:
    cookie = {"Cookie": token.cookie(TOKEN, locked.viser.get_port(), False).partition(";")[0]}
    until(lambda: not locked.sessions)
    tabs = [FakeTab(locked.url, cookie) for _ in range(2)]
    until(lambda: len(locked.guard.tabs) == 2)
    status, headers, page = ask(locked, "/", **cookie)
    assert status == 503
    assert "All places are taken" in page
    assert all(name in headers for name in HEADERS)
    with pytest.raises(InvalidStatus, match="503"):
        FakeTab(locked.url, cookie)
    assert "2 tabs at once" in ask(locked, f"/connection?origin={locked.url}", **cookie)[2]
    tabs[0].close()
    until(lambda: len(locked.guard.tabs) == 1)
    assert ask(locked, "/", **cookie)[0] == 200
    tabs[1].close()
    until(lambda: not locked.sessions)


@pytest.mark.parametrize(
    ("line", "status"),
    [
        (b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc", 405),
        (b"HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\n", 405),
        (b"GET /" + b"a" * 300 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n", 414),
        (b"GET /" + b"a/" * 5000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n", 414),
        (b"GET / HTTP/1.0\r\n\r\n", 505),
        (b"GET  / HTTP/1.1\r\nHost: localhost\r\n\r\n", 400),
        (b"GET http://evil.example/ HTTP/1.1\r\nHost: localhost\r\n\r\n", 400),
        (b"GET /%00 HTTP/1.1\r\nHost: localhost\r\n\r\n", 400),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\n", 400),
        (b"GET /../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n", 404),
        (b"GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n", 404),
        (b"GET /%ff%fe HTTP/1.1\r\nHost: localhost\r\n\r\n", 404),
        (b"GET /assets HTTP/1.1\r\nHost: localhost\r\n\r\n", 404),
        (b"GET / HTTP/1.1\r\n\r\n", 403),
        (b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n\r\n", 426),
    ],
)
def test_odd_requests_get_a_clean_answer(
    server: Server, caplog: pytest.LogCaptureFixture, line: bytes, status: int
) -> None:
    with caplog.at_level(logging.INFO, "abi.web"):
        answer = say(server, line)
    assert answer.startswith(b"HTTP/1.1 %d " % status)
    assert b"\r\nContent-Security-Policy: " in answer
    assert not any(record.exc_info for record in caplog.records)


def test_a_proxy_that_knows_the_token_may_use_any_name(locked: Server) -> None:
    bearer = {"Authorization": f"Bearer {TOKEN}".encode().decode("latin-1")}
    assert ask(locked, "/metrics", Host="hub.example.org")[0] == 403
    assert ask(locked, "/metrics", Host="hub.example.org", Authorization="Bearer x")[0] == 403
    assert ask(locked, "/metrics", Host="hub.example.org", **bearer)[0] == 200


def test_health_is_told_without_a_token(locked: Server) -> None:
    assert ask(locked, "/healthz", Host="evil.example")[::2] == (200, "ok\n")


def test_a_server_that_starts_is_no_refusal(
    locked: Server, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(locked.guard, "ready", False)
    with caplog.at_level(logging.INFO, "abi.web"):
        assert ask(locked, "/healthz")[0] == 503
        assert not caplog.records
        # of a host that no test before has asked for, as each reason is told once
        assert ask(locked, "/nothing", Host="nobody.example")[0] == 403
        assert caplog.records


def test_malformed_messages_are_dropped_and_many_of_them_close_only_their_tab(
    server: Server, tab: tuple[FakeTab, Session], caplog: pytest.LogCaptureFixture
) -> None:
    fake, session = tab
    pitch = session.panels.stages.fields["mesh.pitch"]
    frames: list[bytes | str] = [
        "text",
        b"\xc1",
        msgspec.msgpack.encode({"type": "ShareUrlRequest"}),
    ]
    for frame in frames:
        fake.send_raw(frame)
    updates: list[Any] = [{"removed": True}, {"update_cb": []}, {"value": 1.0, "label": "x"}, [], 1]
    for update in updates:
        fake.send({"type": "GuiUpdateMessage", "uuid": pitch._impl.uuid, "updates": update})
    for value in ("junk", None, [math.nan], {"a": 1}, True):
        fake.set(pitch, value)
    fake.set(pitch, 0.9)
    until(lambda: session.plan.scene.mesh.pitch == 0.9)  # type: ignore[union-attr]

    known = set(server.sessions)
    hostile = FakeTab(server.url)
    until(lambda: bool(set(server.sessions) - known))
    (number,) = set(server.sessions) - known
    for _ in range(MAX_REFUSED + 1):
        hostile.send_raw(b"\xc1")
    until(lambda: number not in server.sessions)
    hostile.close()
    fake.set(pitch, 1.0)
    until(lambda: session.plan.scene.mesh.pitch == 1.0)  # type: ignore[union-attr]
    assert not any(record.exc_info for record in caplog.records)


def test_moves_that_come_too_fast_wait_and_end_where_the_hand_does(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    (gizmo, *_) = session.panels.obstacles.gizmos
    x, y, z = (float(number) for number in gizmo.position)
    begin = time.monotonic()
    for step in range(TOO_MANY):
        fake.drag(gizmo, [x + 1e-3 * step, y, z])
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.7)
    last = x + 1e-3 * (TOO_MANY - 1)
    until(lambda: session.plan.scene.mesh.pitch == 0.7)  # type: ignore[union-attr]
    # what came before the other is done before it, and all of it at the rate that is let through
    assert gizmo.position[0] == pytest.approx(last)
    assert time.monotonic() - begin > (TOO_MANY / MESSAGES_PER_SECOND - BURST) / 2
    until(lambda: session.plan.scene.obstacles[0].position[0] == pytest.approx(last))  # type: ignore[union-attr]


@pytest.mark.skipif(not hasattr(socket, "TCP_NOTSENT_LOWAT"), reason="the system has no such limit")
def test_what_a_page_does_not_read_is_not_in_the_system_s_hands(server: Server) -> None:
    """A picture is old by the time a slow line has carried it, and newer ones follow it."""
    version = f"Sec-WebSocket-Protocol: viser-v{viser.__version__}\r\n"
    request = (
        f"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {'A' * 22}==\r\n{version}\r\n"
    )
    known = set(server.guard.tabs)
    with socket.socket() as wire:
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16_384)
        wire.connect(("127.0.0.1", server.viser.get_port()))
        wire.sendall(request.encode())
        until(lambda: len(set(server.guard.tabs) - known) == 1)
        (tab,) = set(server.guard.tabs) - known
        page.run_on_loop(server.viser, lambda: tab.transport.write(bytes(MUCH)))
        until(lambda: tab.transport.get_write_buffer_size() > 0)
        assert tab.transport.get_write_buffer_size() > 0.8 * MUCH
    until(lambda: tab not in server.guard.tabs)


def test_a_file_that_no_button_takes_is_not_stored(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    upload = session.panels.files.upload
    begin = {
        "type": "FileTransferStartUpload",
        "source_component_uuid": upload._impl.uuid,
        "mime_type": "",
        "part_count": 1,
    }
    for name, size in (("scene.exe", 3), ("scene.yaml", 10**12)):
        fake.send({**begin, "transfer_uuid": name, "filename": name, "size_bytes": size})
    part = {"type": "FileTransferPart", "source_component_uuid": None, "part_index": 0}
    fake.send({**part, "transfer_uuid": "scene.exe", "content": b"abc"})
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.8)
    until(lambda: session.plan.scene.mesh.pitch == 0.8)  # type: ignore[union-attr]
    assert session.client.gui._current_file_upload_states == {}
    assert session.panels.files.upload.value.content == b""


def test_a_busy_port_ends_with_a_sentence(server: Server) -> None:
    port = server.viser.get_port()
    with pytest.raises(AbiError, match=f"--port is {port}, which another program uses"):
        start(port=port, scene="paper")
    with socket.socket() as busy:
        busy.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        busy.bind(("127.0.0.1", 65535))
        busy.listen()
        with pytest.raises(AbiError, match="65535"):
            start(port=65535)
