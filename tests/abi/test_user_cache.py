"""Folders of the user: where they are, and that nobody else can put something there."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

from abi.user_cache import temporary_cache, user_cache

of_users = pytest.mark.skipif(not hasattr(os, "getuid"), reason="each user has a directory")


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_the_cache_is_where_the_user_wants_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert user_cache() == Path("/somewhere/abi-visualiser")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert user_cache().is_relative_to(Path.home())


def test_who_has_no_home_has_a_temporary_cache(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def homeless() -> Path:
        raise RuntimeError

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    assert user_cache().parent == temporary


@of_users
def test_a_temporary_cache_is_for_one_user_alone(temporary: Path) -> None:
    folder = temporary_cache()
    assert folder == temporary_cache()
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    with pytest.raises(PermissionError):
        temporary_cache()


@of_users
def test_a_temporary_cache_is_no_link(temporary: Path) -> None:
    folder = temporary_cache()
    folder.rename(temporary / "elsewhere")
    folder.symlink_to(temporary / "elsewhere")
    with pytest.raises(PermissionError):
        temporary_cache()
