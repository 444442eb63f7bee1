"""Paths of the files that come with the package, such as scenes and arms."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_INSTALLED = _PACKAGE / "assets"


def path(*parts: str) -> Path:
    """Path of a shipped file, beside the package in a checkout and inside it in a wheel."""
    root = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "assets"
    return root.joinpath(*parts)
