"""Cue: a view that a lesson, a figure of the paper or a teacher has a tab show."""

from __future__ import annotations

from dataclasses import dataclass

from abi.scene.scene import Scene
from app.teach.lesson import Setting


@dataclass(frozen=True, eq=False)
class Cue:
    """A setting, and the scene that results from it.

    Attributes:
        setting: layers, camera, search and time.
        scene: to be planned.
        look: whether the camera turns to the scene, though the setting names none.
    """

    setting: Setting
    scene: Scene
    look: bool = False
