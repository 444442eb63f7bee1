"""Places that a class has answered, as balls in the scene with the number of answers at each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import viser

from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from app.ui import style

_SIZE = 0.022
"""Radius of the ball of one answer, as a part of the workspace's longest side."""


class AnswerDots:
    """The balls of one tab.

    Attributes:
        places: at which there is one, [unit], world.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._root: viser.FrameHandle | None = None
        self.places: tuple[Vec3, ...] = ()
        self._drawn: tuple[object, ...] = ()

    def draw(self, places: Sequence[Vec3], right: Sequence[Vec3], scene: Scene) -> None:
        """Draw the answers, the right places among them in green; none takes all away."""
        size = max(scene.workspace.size)
        state = tuple(places), tuple(right), size
        if state == self._drawn:
            return
        self._drawn = state
        self.places = tuple(dict.fromkeys(places))
        if self._root is not None:
            self._root.remove()
            self._root = None
        if not places:
            return
        self._root = self._scene.add_frame("/answers", show_axes=False)
        for number, (place, count) in enumerate(Counter(places).items()):
            colour = style.GOOD[0] if place in right else style.MARK
            self._scene.add_icosphere(
                f"/answers/{number}",
                radius=_SIZE * size * float(count) ** (1 / 3),
                color=colour,
                position=place,
            )
            if count > 1:
                self._scene.add_label(f"/answers/{number}/count", str(count))
