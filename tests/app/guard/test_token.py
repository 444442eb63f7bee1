"""The token comes in the link, stays in the cookie, and nothing else will do."""

from __future__ import annotations

from http.cookies import SimpleCookie
from urllib.parse import urlsplit

from hypothesis import given
from hypothesis import strategies as st
from websockets.datastructures import Headers

from app.guard import token

TOKENS = st.text(st.characters(exclude_categories=("C", "Z")), min_size=1, max_size=40)


@given(TOKENS)
def test_link_and_cookie_carry_the_token_there_and_back(secret: str) -> None:
    parts = urlsplit(token.link("http://127.0.0.1:8080", secret))
    assert token.in_query(f"{parts.path}?{parts.query}", secret)

    value = token.cookie(secret, 8080, secure=True).partition(";")[0]
    assert value.isascii()
    assert token.in_headers(Headers(Cookie=f"other=1; {value}"), secret, 8080)
    assert not token.in_headers(Headers(Cookie=value), secret, 8081)
    (morsel,) = SimpleCookie(token.cookie(secret, 8080, secure=True)).values()
    assert (morsel["httponly"], morsel["secure"], morsel["samesite"]) == (True, True, "Lax")


@given(TOKENS, TOKENS)
def test_another_token_does_not_open(secret: str, other: str) -> None:
    opens = secret == other
    parts = urlsplit(token.link("http://127.0.0.1:8080", other))
    assert token.in_query(f"/?{parts.query}", secret) is opens
    cookie = token.cookie(other, 8080, secure=False).partition(";")[0]
    assert token.in_headers(Headers(Cookie=cookie), secret, 8080) is opens


def test_a_program_says_bearer() -> None:
    assert token.in_headers(Headers(Authorization="Bearer abc"), "abc", 1)
    assert not token.in_headers(Headers(Authorization="Basic abc"), "abc", 1)
    assert not token.in_headers(Headers(Authorization="abc"), "abc", 1)
    twice = [("Authorization", "Bearer abc")] * 2
    assert not token.in_headers(Headers(twice), "abc", 1)


def test_a_token_given_twice_is_none() -> None:
    assert not token.in_query("/?token=abc&token=abc", "abc")
    assert not token.in_query("/?" + "&".join(["token=abc"] * 50), "abc")


def test_the_address_bar_loses_the_token_and_nothing_else() -> None:
    assert token.without_token("/?token=abc") == "./"
    assert token.without_token("/?a=1&token=abc&b=%2F") == "./?a=1&b=%2F"
