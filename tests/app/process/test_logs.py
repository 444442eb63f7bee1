"""The log keeps to one line an event, whatever came from outside."""

from __future__ import annotations

import io
import logging

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.process import logs


def _line(event: str, **fields: object) -> str:
    record = logging.makeLogRecord({"msg": event, "name": "abi.web", "levelname": "INFO", **fields})
    return logs.Terminal().format(record)


@given(st.text(max_size=30))
def test_no_text_makes_a_second_line_or_another_field(text: str) -> None:
    for line in (_line(text), _line("event", asked=text)):
        assert line.isascii()
        assert line.isprintable()
    assert _line("event", asked=text, status=404).endswith(" status=404")


def test_a_line_tells_when_where_what_and_the_fields() -> None:
    line = _line("tab closed", created=0.0, msecs=7.0, tab=3, seconds=1.23456, name_="x y")
    assert line == (
        "1970-01-01T00:00:00.007Z INFO abi.web tab closed tab=3 seconds=1.235 name_='x y'"
    )


def test_the_level_switches_what_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr("sys.stderr", stream)
    logs.configure("warning")
    logs.configure("warning")
    logging.getLogger("abi.tab").info("quiet")
    logging.getLogger("abi.tab").warning("loud")
    logs.configure("info")
    assert [line.split()[-1] for line in stream.getvalue().splitlines()] == ["loud"]
