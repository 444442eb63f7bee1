"""Shipped scenes that show what is amiss: it is told calmly, until one changes something."""

from __future__ import annotations

import functools

from abi.scene.scene import Scene, load_scene

PUZZLES = ("find-a-base", "no-way", "wall-with-window")
"""Their names; all others have a whole plan."""


def is_puzzle(scene: Scene) -> bool:
    """Check whether a scene is one of these, as it is shipped."""
    return scene in _scenes()


@functools.cache
def _scenes() -> tuple[Scene, ...]:
    return tuple(map(load_scene, PUZZLES))
