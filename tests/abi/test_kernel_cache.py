"""The cache of compiled kernels: shared by clones, cleared of what is old, and always somewhere."""

from __future__ import annotations

import logging
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import abi
from abi import compiler_process, compiling
from abi.compilation import kernel_cache
from abi.compilation.dispatcher import compile_once, is_kept, make_dispatcher
from abi.compilation.kernel_cache import KernelCache
from abi.compilation.kernel_folder import kernel_folder
from abi.compiled import FLOATS, KERNELS, NEW_FLOATS, Kernel, compiled
from tests.abi.test_compiled import CACHED, run


def halved(numbers: Any, found: Any) -> float:
    for i in range(len(numbers)):
        found[i] = numbers[i] / 2
    return 0.0


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    kernel_folder.cache_clear()
    yield tmp_path / "cache" / "abi-visualiser"
    kernel_folder.cache_clear()


EXAMPLE = FLOATS, NEW_FLOATS


def dispatcher() -> Any:
    return make_dispatcher(halved, EXAMPLE, {})


def compiled_dispatcher() -> Any:
    found = dispatcher()
    compile_once(found, EXAMPLE)
    return found


def test_a_damaged_file_is_compiled_anew(folder: Path) -> None:
    compiled_dispatcher()
    [file] = folder.iterdir()
    file.write_bytes(file.read_bytes()[:-20])
    compiled_dispatcher()(np.ones(2), found := np.zeros(2))
    assert found.tolist() == [0.5, 0.5]
    assert is_kept(dispatcher())
    assert not compiled_dispatcher()._cache_misses


def test_what_nobody_has_used_for_long_is_removed(folder: Path) -> None:
    folder.mkdir(parents=True)
    month_ago = time.time() - 31 * 24 * 3600
    files = [folder / name for name in ("used.nbc", "unused.nbc", "older.nbi", "new.nbc")]
    for file in files:
        file.write_bytes(b"")
        os.utime(file, (month_ago, month_ago) if file.stem != "new" else None)
    KernelCache(files[0]).note_use()
    KernelCache(files[1]).remove_unused()
    assert sorted(file.stem for file in folder.iterdir()) == ["new", "used"]


def test_what_cannot_be_kept_where_it_should_is_kept_for_a_while_and_logged(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder.parent.write_text("a file in the way")
    with caplog.at_level(logging.WARNING):
        compiled_dispatcher()
        assert is_kept(dispatcher())
    [line] = caplog.messages
    chosen = kernel_folder()
    assert chosen is not None
    assert chosen.is_relative_to(folder.parents[1])
    assert str(chosen) in line
    assert "NUMBA_CACHE_DIR" in line


def test_where_nothing_can_be_kept_each_kernel_is_compiled_once(
    folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    folder.parent.write_text("a file in the way")
    user = f"-{os.getuid()}" if hasattr(os, "getuid") else ""
    (folder.parents[1] / f"abi-visualiser{user}").write_text("and another")
    kernel: Kernel[..., Any] = compiled(example=(FLOATS, NEW_FLOATS))(halved)
    del KERNELS[kernel.name]

    def start(_: bool) -> subprocess.Popen[str]:
        raise AssertionError("another process could not hand over what it compiles")

    monkeypatch.setattr(compiling, "all_kernels", lambda: [kernel])
    monkeypatch.setattr(compiler_process, "start", start)
    with caplog.at_level(logging.WARNING):
        compiling._Compilation()._work()
    assert kernel.compiled
    assert not kernel.cached
    [line] = caplog.messages
    assert "not kept" in line
    assert "NUMBA_CACHE_DIR" in line


@pytest.mark.slow
def test_clones_share_what_they_compile_and_an_edit_affects_what_depends_on_it(
    tmp_path: Path,
) -> None:
    package, ignored = Path(abi.__file__).parent, shutil.ignore_patterns("__pycache__")
    first, second = (
        shutil.copytree(package, tmp_path / name / "abi", ignore=ignored) for name in "ab"
    )
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    of_first, of_second = (cache | {"PYTHONPATH": str(clone.parent)} for clone in (first, second))
    assert run(CACHED, **of_first).split() == ["0", "0"]

    # a comment, and lines that move
    source = first / "tet_mesh" / "exclusion_kernels.py"
    source.write_text(source.read_text().replace("@compiled", "# a comment\n\n@compiled"))

    # in a file that the other kernel takes functions from
    helper = first / "obstacles" / "primitive_kernels.py"
    before = helper.read_text()
    helper.write_text(
        before.replace("return most - core.radius", "return most - 1.0 * core.radius")
    )
    assert helper.read_text() != before
    assert run(CACHED, **of_first).split() == ["1", "0"]
    assert run(CACHED, **of_second).split() == ["1", "1"]

    # in the compiler
    source = second / "compilation" / "borrowing.py"
    source.write_text(source.read_text() + "\n_ANOTHER = 1\n")
    assert run(CACHED, **of_second).split() == ["0", "0"]


@pytest.fixture(scope="module")
def brought(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the compiled form for any processor, as another process wrote it for a wheel."""
    code = "from tests.abi.test_kernel_cache import compiled_dispatcher; compiled_dispatcher()"
    place = tmp_path_factory.mktemp("wheel")
    environment = {"NUMBA_CPU_NAME": "generic", "NUMBA_CACHE_DIR": str(place)}
    subprocess.run([sys.executable, "-c", code], check=True, env=os.environ | environment)
    return place / "abi-visualiser"


@pytest.fixture
def ready(folder: Path, brought: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of that folder, where kernels are looked for first."""
    copy = shutil.copytree(brought, tmp_path / "wheel")
    monkeypatch.setattr(kernel_cache, "READY", copy)
    return copy


@pytest.mark.slow
def test_what_a_wheel_brings_is_neither_compiled_nor_written(folder: Path, ready: Path) -> None:
    before = {file: file.read_bytes() for file in ready.iterdir()}
    assert is_kept(dispatcher())
    loaded = compiled_dispatcher()
    assert not loaded._cache_misses
    loaded(np.ones(2), found := np.zeros(2))
    assert found.tolist() == [0.5, 0.5]
    with pytest.raises(TypeError):
        loaded(np.ones(2, int), found)
    assert not list(folder.glob("*"))
    assert {file: file.read_bytes() for file in ready.iterdir()} == before


@pytest.mark.slow
def test_what_is_missing_of_a_wheel_is_compiled_and_kept_for_the_user(
    folder: Path, ready: Path
) -> None:
    [file] = ready.iterdir()
    file.unlink()
    compiled_dispatcher()
    assert list(folder.glob("*.nbc"))
    assert is_kept(dispatcher())
    assert not list(ready.iterdir())
