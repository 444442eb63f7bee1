from __future__ import annotations

import numpy as np

from abi import load_scene
from app.layers.drop_line import DropLineLayer, moved_place
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, layer, until

SCENE = load_scene("two-boxes")


def test_the_one_thing_that_moved_is_found() -> None:
    first, second = SCENE.obstacles
    moved = second.model_copy(update={"position": (1.0, 2.0, 3.0)})
    assert moved_place(SCENE, SCENE) is None
    assert moved_place(SCENE, SCENE.replace(obstacles=[first, moved])) == (1.0, 2.0, 3.0)
    assert moved_place(SCENE, SCENE.replace(start=(0.0, 0.0, 1.0))) == (0.0, 0.0, 1.0)
    assert (
        moved_place(SCENE, SCENE.replace(start=(0.0, 0.0, 1.0), obstacles=[first, moved])) is None
    )
    assert moved_place(SCENE, SCENE.replace(obstacles=[first])) is None


def test_what_is_dragged_has_a_line_to_the_floor_until_it_rests(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    line, start = layer(session, DropLineLayer)._line, session.panels.ends.gizmos["start"]
    until(lambda: session.resting)
    assert not line.visible
    fake.drag(start, [0.0, 2.0, 1.0])
    until(lambda: np.allclose(line.points[0], [[0, 2, 1], [0, 2, 0]], atol=1e-6))
    until(lambda: session.resting and not line.visible)
