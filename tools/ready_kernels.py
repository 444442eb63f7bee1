"""Brings compiled kernels into a wheel, where ``ABI_READY_KERNELS=1`` asks its build for them.

    ABI_READY_KERNELS=1 python -m hatchling build --target wheel

The wheel then fits one platform and one version of Python, and numba's version at the build: with
another one its kernels are compiled as without them.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ReadyKernels(BuildHookInterface):  # type: ignore[type-arg]
    """Hook of the wheel's build."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile the kernels for any processor, and name the platform that they fit."""
        if version == "editable" or os.environ.get("ABI_READY_KERNELS") != "1":
            return
        room = Path(self.root, "build", "ready-kernels")
        shutil.rmtree(room, ignore_errors=True)
        compile_kernels(Path(self.root), room)
        for file in room.rglob("*.nbc"):
            build_data["force_include"][str(file)] = f"abi/ready_kernels/{file.name}"
        build_data["pure_python"], build_data["tag"] = False, platform_tag()


def compile_kernels(project: Path, folder: Path) -> None:
    """Compile all kernels of a project for any processor of this platform into a folder."""
    environment = {"NUMBA_CPU_NAME": "generic", "NUMBA_CACHE_DIR": str(folder)}
    step = [sys.executable, "-c", "import abi; abi.compile()"]
    subprocess.run(step, check=True, cwd=project, env=os.environ | environment)


def platform_tag() -> str:
    """Name this Python and platform as numba's wheel does: its kernels run where numba does."""
    [*_, tag] = re.findall(r"^Tag: (\S+)$", distribution("numba").read_text("WHEEL") or "", re.M)
    return str(tag)
