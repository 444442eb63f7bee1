"""Places that a class has answered, as balls in the scene with the number of answers at each."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence

import viser

from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from app.ui import style

_SIZE = 0.022
"""Radius of the ball of one answer, as a part of the workspace's longest side."""


Balls = dict[tuple[Vec3, int, bool, float], viser.IcosphereHandle]
"""Balls by place, number of answers, whether that is right, and the workspace's longest side."""
_NUMBERS = itertools.count()
"""Of the balls' nodes."""


def draw_answers(
    nodes: viser.SceneApi, balls: Balls, places: Sequence[Vec3], right: Sequence[Vec3], scene: Scene
) -> None:
    """Draw the places answered; none takes all balls away, and those that stay are not sent again.

    Of the right places, in green, those that nobody has answered are drawn where nobody was right.

    Args:
        nodes: where to draw.
        balls: that there are, which this changes.
        places: one for each answer, [unit], world.
        right: places that are right.
        scene: whose workspace sets the balls' size.
    """
    counts, side = Counter(places), max(scene.workspace.size)
    if not counts.keys() & set(right):
        counts.update(dict.fromkeys(right, 0))
    wanted = [(place, count, place in right, side) for place, count in counts.items()]
    for ball in balls.keys() - set(wanted):
        balls.pop(ball).remove()
    for ball in wanted:
        if ball not in balls:
            balls[ball] = _drawn(nodes, *ball)


def _drawn(
    nodes: viser.SceneApi, place: Vec3, answers: int, right: bool, side: float
) -> viser.IcosphereHandle:
    name = f"/answers/{next(_NUMBERS)}"
    drawn = nodes.add_icosphere(
        name,
        radius=_SIZE * side * max(answers, 1.0) ** (1 / 3),
        color=style.GOOD[0] if right else style.MARK,
        position=place,
    )
    if right or answers > 1:
        nodes.add_label(f"{name}/count", f"{'✓ ' * right}{answers}")
    return drawn
