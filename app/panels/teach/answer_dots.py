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


_Ball = tuple[Vec3, int, bool, float]
"""A ball's place, number of answers, whether that is right, and the workspace's longest side."""


class AnswerDots:
    """The balls of one tab; those that stay are not drawn again when an answer comes.

    Attributes:
        places: at which there is one, [unit], world.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._balls: dict[_Ball, viser.IcosphereHandle] = {}
        self._made = 0
        self.places: tuple[Vec3, ...] = ()

    def draw(self, places: Sequence[Vec3], right: Sequence[Vec3], scene: Scene) -> None:
        """Draw the answers, the right places among them in green; none takes all away.

        Of the right places those that nobody has answered are drawn where nobody was right.
        """
        side = max(scene.workspace.size)
        counts = Counter(places)
        if not counts.keys() & set(right):
            counts.update(dict.fromkeys(right, 0))
        wanted = [(at, count, at in right, side) for at, count in counts.items()]
        self.places = tuple(counts)
        for ball in self._balls.keys() - set(wanted):
            self._balls.pop(ball).remove()
        for ball in wanted:
            if ball not in self._balls:
                self._balls[ball] = self._drawn(*ball)

    def _drawn(self, place: Vec3, answers: int, right: bool, side: float) -> viser.IcosphereHandle:
        self._made += 1
        name = f"/answers/{self._made}"
        drawn = self._scene.add_icosphere(
            name,
            radius=_SIZE * side * max(answers, 1.0) ** (1 / 3),
            color=style.GOOD[0] if right else style.MARK,
            position=place,
        )
        if right or answers > 1:
            self._scene.add_label(f"{name}/count", f"{'✓ ' * right}{answers}")
        return drawn
