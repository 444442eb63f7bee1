"""The demonstration of a new tab gives way to a hand, whenever the hand comes."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import viser

from app.panels.obstacles.obstacle_gizmos import ObstacleGizmos
from app.panels.widgets import VectorBox
from app.server.server import start
from app.state.appearance import PLAIN
from app.tab.demo import Demo
from app.tab.session import Session
from tests.app.fake_tab import opened


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    running = start(port=0, scene="paper", look=PLAIN)
    fake, session = opened(running, patience=90)
    yield session
    fake.close()
    running.stop()


@pytest.fixture
def obstacles(session: Session) -> ObstacleGizmos:
    """The session's ends, as nobody has touched them."""
    obstacles = session.panels.obstacles
    obstacles.write(session.frame.plan.scene)
    obstacles.dragged = False
    return obstacles


def pull(obstacles: ObstacleGizmos, shift: tuple[float, float, float]) -> None:
    """Drag the first obstacle's body from where it is."""
    event = SimpleNamespace(
        client=None,  # wakes nobody
        target=obstacles.shown[0].body,
        start_position=np.zeros(3),
        end_position=np.array(shift),
        phase="end",
    )
    obstacles._drag_body(cast("viser.SceneNodeDragEvent[Any]", event))


def test_it_moves_an_obstacle_and_puts_it_back(session: Session, obstacles: ObstacleGizmos) -> None:
    (gizmo,) = obstacles.gizmos
    origin = gizmo.position.copy()
    demo = Demo(obstacles)
    demo.begin(session.frame.plan.scene)
    demo._begun -= 1.5
    demo.step()
    assert np.linalg.norm(gizmo.position - origin) > 0.5
    demo.end()
    assert not demo.running
    np.testing.assert_array_equal(gizmo.position, origin)


def test_after_it_the_numbers_are_those_of_the_scene() -> None:
    gui = SimpleNamespace(
        add_vector3=lambda *_, **__: SimpleNamespace(value=None, on_update=lambda _: None)
    )
    box = VectorBox(cast("viser.GuiApi", gui), "position", 0.1, "", lambda _: None)
    handle = cast("Any", box.handle)
    box.write((3.0, 2.9991, 3.0012))  # its last place
    box.show((3.0, 3.0, 3.0))
    assert handle.value == (3.0, 3.0, 3.0)
    handle.value = (3.0004, 3.0, 3.0)  # typed finer than a box writes
    assert box.typed("position") == (3.0004, 3.0, 3.0)
    box.show((3.0004, 3.0, 3.0))
    assert handle.value == (3.0004, 3.0, 3.0)


def test_a_pull_that_comes_amid_a_step_is_kept(session: Session, obstacles: ObstacleGizmos) -> None:
    (gizmo,) = obstacles.gizmos
    demo = Demo(obstacles)
    demo.begin(session.frame.plan.scene)
    demo._begun -= 1.5
    demo.step()
    pull(obstacles, (0.0, 3.0, 0.0))
    pulled = gizmo.position.copy()
    demo.step()  # of a worker that has not yet been told
    np.testing.assert_array_equal(gizmo.position, pulled)
    demo.end()
    np.testing.assert_array_equal(gizmo.position, pulled)


def test_it_does_not_begin_once_a_hand_has_pulled(
    session: Session, obstacles: ObstacleGizmos
) -> None:
    pull(obstacles, (0.0, 3.0, 0.0))
    demo = Demo(obstacles)
    demo.begin(session.frame.plan.scene)
    assert not demo.running


def test_it_does_not_begin_once_there_was_input(obstacles: ObstacleGizmos) -> None:
    demo = Demo(obstacles)
    demo.wanted = True
    demo.end()
    assert not demo.wanted
