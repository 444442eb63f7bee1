"""Hosts and Origins that are the server's own."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.datastructures import Headers

from abi.errors import AbiError
from app.guard.host_check import is_known_host, is_own_origin
from app.guard.policy import Policy, is_loopback, policy_for

LOCAL = policy_for("127.0.0.1")
OPEN = policy_for("0.0.0.0")
PUBLIC = policy_for("127.0.0.1", origins=("https://abi.example.org/demo/",))


@pytest.mark.parametrize(
    ("policy", "host", "known"),
    [
        (LOCAL, "127.0.0.1:8080", True),
        (LOCAL, "localhost:9000", True),
        (LOCAL, "LOCALHOST", True),
        (LOCAL, "[::1]:8080", True),
        (LOCAL, "192.168.1.7:8080", False),
        (LOCAL, "rebind.example.org:8080", False),
        (LOCAL, "127.0.0.1.example.org", False),
        (LOCAL, "localhost@evil.example", False),
        (LOCAL, "localhost/evil", False),
        (LOCAL, "localhost:port", False),
        (LOCAL, "localhost:99999999", False),
        (LOCAL, "[::1", False),
        (LOCAL, "", False),
        (OPEN, "192.168.1.7:8080", True),
        (OPEN, "[fe80::1]:8080", True),
        (OPEN, "rebind.example.org:8080", False),
        (PUBLIC, "abi.example.org", True),
        (PUBLIC, "evil.example", False),
    ],
)
def test_only_names_that_nobody_else_can_point_here_are_known(
    policy: Policy, host: str, known: bool
) -> None:
    assert is_known_host(policy, Headers(Host=host)) is known


def test_a_host_that_stands_twice_or_not_at_all_is_not_known() -> None:
    assert not is_known_host(LOCAL, Headers())
    assert not is_known_host(LOCAL, Headers([("Host", "localhost"), ("Host", "localhost")]))


@pytest.mark.parametrize(
    ("origin", "own"),
    [
        ("http://localhost:8080", True),
        ("https://localhost:8080", True),
        ("https://abi.example.org", True),
        ("http://abi.example.org", False),
        ("http://localhost:8081", False),
        ("http://localhost", False),
        ("https://evil.example", False),
        ("https://localhost:8080.evil.example", False),
        ("https://abi.example.org.evil.example", False),
        ("file://localhost:8080", False),
        ("null", False),
        ("", False),
    ],
)
def test_an_origin_is_compared_as_a_whole(origin: str, own: bool) -> None:
    assert is_own_origin(PUBLIC, Headers(Host="localhost:8080", Origin=origin)) is own


def test_two_origins_are_none_and_no_origin_is_no_page() -> None:
    both = [("Host", "localhost"), ("Origin", "http://localhost"), ("Origin", "http://localhost")]
    assert not is_own_origin(LOCAL, Headers(both))
    assert is_own_origin(LOCAL, Headers(Host="localhost"))


@given(st.text(st.characters(min_codepoint=33, max_codepoint=126), max_size=40))
def test_whatever_the_headers_say_they_are_only_refused(text: str) -> None:
    headers = Headers(Host=text, Origin=text)
    if is_known_host(LOCAL, headers):
        assert text.lower().startswith(("localhost", "127.0.0.1", "[::1]"))
    assert not is_own_origin(LOCAL, headers)


@pytest.mark.parametrize(
    ("host", "token"),
    [("127.0.0.1", False), ("localhost", False), ("::1", False), ("0.0.0.0", True), ("x", True)],
)
def test_a_token_is_needed_where_others_can_come(host: str, token: bool) -> None:
    assert is_loopback(host) is not token
    assert (policy_for(host).token is not None) is token
    assert policy_for(host, needs_token=False).token is None
    assert policy_for(host, "mine").token == "mine"
    assert policy_for(host, origins=("https://abi.example.org",)).token is not None


def test_no_two_tokens_are_equal() -> None:
    tokens = {policy_for("0.0.0.0").token for _ in range(20)}
    assert len(tokens) == 20
    assert all(token is not None and len(token) >= 32 for token in tokens)


@pytest.mark.parametrize(
    "text",
    [
        *("abi.example.org", "ftp://a.b", "https://", "https://[x", "*"),
        *("https://a.b,https://c.d", "https://a.b;", "https://*.a.b"),
    ],
)
def test_what_is_no_origin_is_named(text: str) -> None:
    with pytest.raises(AbiError, match=r"--origin is .*https://abi\.example\.org"):
        policy_for("127.0.0.1", origins=(text,))


@pytest.mark.parametrize(
    "text", ["https://a-b.c_d.org", "http://192.168.1.7:8000", "http://[::1]:8"]
)
def test_an_origin_may_be_a_name_or_an_address(text: str) -> None:
    assert policy_for("127.0.0.1", origins=(text,)).origins == {text}
