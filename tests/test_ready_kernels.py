"""The build hook that brings compiled kernels into a wheel."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from tools import ready_kernels
from tools.ready_kernels import ReadyKernels, platform_tag


def _build_data(root: Path, version: str = "standard") -> dict[str, Any]:
    """What the hook makes of the data of a wheel's build."""
    data: dict[str, Any] = {"force_include": {}, "pure_python": True}
    hook: Any = ReadyKernels(str(root), {}, None, None, str(root), "wheel")  # type: ignore[arg-type]
    hook.initialize(version, data)
    return data


def _write(project: Path, folder: Path) -> None:
    """Stand for the compilation, which takes a minute."""
    (folder / "abi-visualiser").mkdir(parents=True)
    for name in ("search.best_first-0123.py311.nbc", "search.estimates-4567.py311.nbc"):
        (folder / "abi-visualiser" / name).write_text(project.name)


def test_a_wheel_fits_any_platform_unless_kernels_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ready_kernels, "compile_kernels", _write)
    monkeypatch.delenv("ABI_READY_KERNELS", raising=False)
    assert _build_data(tmp_path) == {"force_include": {}, "pure_python": True}
    monkeypatch.setenv("ABI_READY_KERNELS", "1")
    assert _build_data(tmp_path, "editable") == {"force_include": {}, "pure_python": True}


def test_kernels_go_where_an_installed_package_looks_for_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ready_kernels, "compile_kernels", _write)
    monkeypatch.setenv("ABI_READY_KERNELS", "1")
    for _ in range(2):  # files of an earlier build are gone
        data = _build_data(tmp_path)
    assert sorted(data["force_include"].values()) == [
        "abi/ready_kernels/search.best_first-0123.py311.nbc",
        "abi/ready_kernels/search.estimates-4567.py311.nbc",
    ]
    assert all(Path(file).read_text() == tmp_path.name for file in data["force_include"])
    assert data["tag"] == platform_tag()
    assert not data["pure_python"]


def test_the_platform_is_that_of_this_python() -> None:
    python, _, platform = platform_tag().split("-")
    assert python == f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert platform != "any"
