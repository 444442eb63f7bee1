"""A few hostile files; ``make fuzz`` has a thousand."""

from __future__ import annotations

import contextlib
import socket
from pathlib import Path

import pytest

from benchmarks.fuzz import fuzz
from benchmarks.outside import Outside


@pytest.mark.slow
def test_hostile_files_are_refused_or_whole() -> None:
    found = fuzz(8, seed=5000)
    assert found["faults"] == []
    assert found["crashes"] == found["hangs"] == found["outside"] == 0
    assert found["taken"] + found["refused"] == 8
    assert sum(found["files"].values()) == 8


def test_what_is_outside_is_seen_to_be_asked(tmp_path: Path) -> None:
    with contextlib.closing(Outside(tmp_path)) as outside:
        assert outside.asked() == 0
        outside.file.read_bytes()
        assert outside.asked() == 1
        host, _, port = outside.address.partition("/")[0].partition(":")
        socket.create_connection((host, int(port))).close()
        assert outside.asked() == 1
        assert outside.asked() == 0
