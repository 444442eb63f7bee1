"""Files that are replaced in one step keep what writing into them would keep."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from abi.atomic_file import replace_file

_NOBODY = 65534


@pytest.fixture
def place() -> Iterator[Path]:
    """A folder of an ordinary user, whom permissions hold for, with this process as that user."""
    with tempfile.TemporaryDirectory() as name:
        if os.geteuid():
            yield Path(name)
            return
        os.chown(name, _NOBODY, _NOBODY)
        os.seteuid(_NOBODY)
        try:
            yield Path(name)
        finally:
            os.seteuid(0)


def test_a_link_stays_and_its_target_is_written(tmp_path: Path) -> None:
    target, link, other = tmp_path / "data" / "a", tmp_path / "a", tmp_path / "b"
    target.parent.mkdir()
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to("data/a")
    other.symlink_to(link)
    replace_file(other, b"new")
    assert other.is_symlink()
    assert os.readlink(link) == "data/a"
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640
    # nothing but the file: whatever is written for a moment is beside it
    assert sorted(tmp_path.rglob("*")) == [link, other, target.parent, target]


def test_a_link_to_nothing_gets_a_file_as_a_shell_makes_one(tmp_path: Path) -> None:
    link = tmp_path / "a"
    link.symlink_to("b")
    replace_file(link, b"new")
    assert (tmp_path / "b").read_text() == "new"
    assert link.is_symlink()


def test_a_link_to_itself_is_an_error(tmp_path: Path) -> None:
    link = tmp_path / "a"
    link.symlink_to("a")
    with pytest.raises(OSError, match="symbolic link"):
        replace_file(link, b"new")
    assert list(tmp_path.iterdir()) == [link]


def test_a_protected_file_stays_as_it_is(place: Path) -> None:
    for link in (False, True):
        file = place / f"a{link}"
        file.write_text("old")
        file.chmod(0o444)
        path = place / "link" if link else file
        if link:
            path.symlink_to(file)
        with pytest.raises(PermissionError):
            path.write_text("new")  # the oracle
        with pytest.raises(PermissionError):
            replace_file(path, b"new")
        assert file.read_text() == "old"
    assert len(list(place.iterdir())) == 3


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="files have no owner there")
def test_the_owner_stays_where_this_user_may_give_files_away(tmp_path: Path) -> None:
    file = tmp_path / "a"
    file.write_text("old")
    file.chmod(0o604)
    if not os.geteuid():
        os.chown(file, _NOBODY, _NOBODY)
    before = file.stat()
    replace_file(file, b"new")
    after = file.stat()
    assert file.read_text() == "new"
    for name in ("st_uid", "st_gid", "st_mode"):
        assert getattr(after, name) == getattr(before, name)
