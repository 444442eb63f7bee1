"""The scene that a command is given: a name, a file, or standard input."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from abi.scene.scene import Scene

STANDARD = "-"
"""Name that stands for standard input or output."""


def given_scene(name: str) -> Scene:
    """Load a scene by name or path, or from standard input, with its files in this folder.

    Raises:
        SceneError: there is no such scene, it is not readable, or a field is wrong.
    """
    from abi.scene.scene import Scene, load_scene
    from abi.scene.scene_file import parse_bytes

    if name != STANDARD:
        return load_scene(name)
    content = sys.stdin.buffer.read()
    ending = "json" if content.lstrip().startswith(b"{") else "yaml"
    return Scene.from_dict(parse_bytes(content, f"stdin.{ending}"), Path())
