"""Memory of the container where it is less than the machine's."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.process.available_memory import memory_in_all

MACHINE = memory_in_all(Path("nowhere"), Path("nowhere"))


def told(folder: Path, own: str, files: dict[str, str]) -> int | None:
    (folder / "own").write_text(own)
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return memory_in_all(folder, folder / "own")


@pytest.mark.parametrize(
    ("own", "files"),
    [
        ("0::/\n", {"memory.max": "1000\n"}),
        ("0::/\n0::/a/b\n", {"a/b/memory.max": "max\n", "a/memory.max": "1000\n"}),
        ("0::/a/b\n", {"a/b/memory.max": "1000\n", "a/memory.max": "2000\n"}),
        ("0::/of/the/host\n", {"memory.max": "1000\n"}),
        ("3:cpu:/\n4:memory:/a\n0::/\n", {"memory/a/memory.limit_in_bytes": "1000\n"}),
        ("4:memory:/docker/1\n", {"memory/memory.limit_in_bytes": "1000\n"}),
    ],
)
def test_the_least_limit_that_can_be_seen_counts(
    tmp_path: Path, own: str, files: dict[str, str]
) -> None:
    assert told(tmp_path, own, files) == 1000


@pytest.mark.parametrize("limit", ["max", "9223372036854771712", "nonsense", ""])
def test_without_a_limit_it_is_the_machine_s(tmp_path: Path, limit: str) -> None:
    assert told(tmp_path, "0::/\n", {"memory.max": limit}) == MACHINE
