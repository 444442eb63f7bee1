from __future__ import annotations

import numpy as np

from app.layers.drop_line import moved_place
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, drawn_node, until

A, B, C = (0.0, 0.0, 2.0), (5.0, 3.0, 4.0), (1.0, 2.0, 3.0)


def test_the_one_place_that_is_another_is_found() -> None:
    assert moved_place((A, B), (A, B)) is None
    assert moved_place((A, B), (A, C)) == C
    assert moved_place((A, B), (C, C)) is None
    assert moved_place((A, B), (A, B, C)) is None


def test_what_is_dragged_has_a_line_to_the_floor_until_something_else_moves(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    line, start = drawn_node(session, "/drop_line"), session.panels.ends.gizmos["start"]
    until(lambda: session.resting)
    assert not line.visible
    fake.drag(start, [0.0, 2.0, 1.0])
    until(lambda: np.allclose(line.points[0], [[0, 2, 1], [0, 2, 0]], atol=1e-6))
    until(lambda: session.resting)
    assert line.visible
    fake.set(session.panels.files.choice, "two-boxes")
    until(lambda: not line.visible)
