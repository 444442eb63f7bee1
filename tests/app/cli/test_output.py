"""Output of commands on terminals and in files that are not UTF-8."""

from __future__ import annotations

import io
import os
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.__main__ import main
from app.cli.output import ensure_streams, print_text

_ENCODINGS = ("ascii", "latin-1", "cp1252", "cp437", "shift_jis", "utf-8")


def _printed(text: str, encoding: str) -> bytes:
    """Bytes of a text on a standard output of that encoding."""
    raw = io.BytesIO()
    before, sys.stdout = sys.stdout, io.TextIOWrapper(raw, encoding, newline="\n")
    try:
        ensure_streams()
        print_text(text)
        return raw.getvalue()
    finally:
        sys.stdout = before


@given(st.sampled_from(_ENCODINGS), st.text(max_size=40))
def test_any_text_can_be_printed_and_what_the_output_has_is_there(encoding: str, text: str) -> None:
    printed = _printed(text, encoding).decode(encoding)
    try:
        kept = text.encode(encoding).decode(encoding) == text
    except UnicodeEncodeError:
        kept = False
    if kept:
        assert printed == f"{text}\n"
    else:
        assert len(printed) > len(text)


def test_signs_are_spelled_and_stay_apart() -> None:
    signs = "✓≈✗"
    assert _printed("✓ −1.5 … 90°", "ascii") == b"+ -1.5 ... 90 deg\n"
    assert _printed("90° ü", "latin-1") == "90° ü\n".encode("latin-1")
    assert _printed("木 ü", "ascii") == b"\\u6728 \\xfc\n"
    assert len({*_printed(signs, "ascii").decode().strip()}) == len(signs)


def test_a_file_s_name_that_is_no_text_comes_out_as_it_went_in() -> None:
    name = b"sc\xe4ne.yaml"
    for encoding in ("utf-8", "ascii"):
        assert _printed(os.fsdecode(name), encoding) == name + b"\n"


@pytest.mark.slow
def test_the_paper_s_table_is_printed_in_another_encoding(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "argv", ["abi", "reproduce"])
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, "ascii", newline="\n"))
    main()
    table = raw.getvalue().decode("ascii")
    for word in ("+ holds", "~ depends on the mesh", "x does not hold", "Dijkstra"):
        assert word in table
