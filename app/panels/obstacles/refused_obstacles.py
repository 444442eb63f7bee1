"""Obstacles of which some are refused: each of these falls back by itself."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import Files
from abi.scene.scene import Scene

_NUMBER = re.compile(r"obstacles\[(\d+)\]")


def accepted_obstacles(
    scene: Scene, files: Files, choices: Sequence[Sequence[Any]]
) -> tuple[Scene, list[Any]]:
    """Replace the obstacles of a scene, each by the first of its choices that is not refused.

    Args:
        scene: the scene.
        files: of the scene by name.
        choices: of each obstacle, as in :meth:`Scene.replace`.

    Returns:
        The scene, and the choice made for each obstacle; the scene as it was, and none, if the list
        itself is refused.
    """
    chosen = [0] * len(choices)
    while True:
        obstacles = [some[number] for some, number in zip(choices, chosen, strict=True)]
        try:
            return scene.replace(files, obstacles=obstacles), obstacles
        except SceneError as error:
            found = _NUMBER.match(error.field)
        refused = -1 if found is None else int(found[1])
        if refused < 0 or chosen[refused] + 1 == len(choices[refused]):
            return scene, []
        chosen[refused] += 1
