"""Folders of processes that are gone are removed, and no others."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from app.process import scratch
from app.process.scratch import PREFIX, remove_abandoned, scratch_folder

needs_locks = pytest.mark.skipif(not scratch.are_possible(), reason="no such locks")
_HOLD = (
    "from app.process.scratch import scratch_folder; f = scratch_folder(); "
    "print(f.name, flush=True); input()"
)


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


def _holder() -> tuple[subprocess.Popen[str], Path]:
    """A process with a folder, and that folder."""
    process = subprocess.Popen(
        [sys.executable, "-c", _HOLD], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    return process, Path(process.stdout.readline().strip())


@needs_locks
def test_the_folder_of_a_killed_process_is_removed_and_that_of_a_living_one_kept() -> None:
    (killed, left), (alive, used) = _holder(), _holder()
    (left / "figures.db").write_bytes(b"0")
    try:
        assert remove_abandoned() == 0
        killed.kill()
        killed.wait()
        assert remove_abandoned() == 1
        assert (left.exists(), used.exists()) == (False, True)
    finally:
        for process in (killed, alive):
            process.kill()
            process.communicate()


def test_a_folder_goes_with_its_owner() -> None:
    folder = scratch_folder()
    assert remove_abandoned() == 0
    assert Path(folder.name).is_dir()
    folder.cleanup()
    assert not Path(folder.name).exists()


@needs_locks
def test_what_only_has_such_a_name_stays(place: Path) -> None:
    without_lock, elsewhere = place / f"{PREFIX}other", place / "elsewhere"
    for folder in (without_lock, elsewhere):
        folder.mkdir()
    (elsewhere / "lock").touch()
    (place / f"{PREFIX}link").symlink_to(elsewhere)
    (place / f"{PREFIX}file").touch()
    assert remove_abandoned() == 0
    assert without_lock.is_dir()
    assert (elsewhere / "lock").exists()
