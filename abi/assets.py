"""Paths of the files that come with the package, such as scenes and arms."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_INSTALLED = _PACKAGE / "assets"


def path(*parts: str) -> Path:
    """Path of a shipped file; a checkout keeps them beside the package, a wheel inside it."""
    root = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "assets"
    return root.joinpath(*parts)
