"""Versions that affect how the visualiser behaves, for ``abi --version`` and bug reports."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version

_PACKAGES = (
    "viser",
    "websockets",
    "numpy",
    "numba",
    "scipy",
    "pydantic",
    "trimesh",
    "manifold3d",
    "lxml",
)


def versions() -> dict[str, str]:
    """Versions by name, and the machine."""
    return {
        "abi": _version("abi-visualiser"),
        "Python": f"{platform.python_version()} ({platform.python_implementation()})",
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "cores": str(os.cpu_count()),
        **{name: _version(name) for name in _PACKAGES},
    }


def version_text() -> str:
    """The versions as text, one a line."""
    found = versions()
    lines = [f"{name:<10}  {value}" for name, value in found.items() if name != "abi"]
    return "\n".join((f"abi, version {found['abi']}", *lines))


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
