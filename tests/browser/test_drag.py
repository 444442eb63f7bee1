"""Dragging gizmos: what the hand leaves in the page is what is planned and drawn."""

from __future__ import annotations

import numpy as np
import pytest

import abi
from app.tab.session import Session
from tests.browser import drawn
from tests.browser.page import Page


def _is_planned(page: Page, session: Session, gizmo: str, field: str) -> None:
    """Wait until the page shows the plan for the pose its gizmo was left in."""

    def arrived() -> bool:
        assert session.plan is not None
        scene = session.plan.scene
        place = scene.obstacles[0].position if field == "obstacles" else getattr(scene, field)
        left = page.position(gizmo)
        return bool(np.allclose(left, place, rtol=0, atol=1e-5)) and drawn.shows(page, session.plan)

    page.until(arrived, f"the plan for the new {field}")
    assert session.plan is not None
    assert drawn.same(session.plan, abi.plan(session.plan.scene))


def test_the_obstacle_goes_where_it_is_dragged(page: Page, session: Session) -> None:
    (gizmo,) = drawn.obstacles(page)
    for axis, length in ((0, 0.8), (2, -1.0)):
        before, old = session.plan, np.array(page.position(gizmo))
        page.drag_arrow(gizmo, axis, length)
        moved = np.array(page.position(gizmo)) - old
        assert moved[axis] == pytest.approx(length, abs=0.15)
        assert np.delete(moved, axis) == pytest.approx([0, 0], abs=1e-6)
        assert page.position(f"{gizmo}/body") == pytest.approx(page.position(gizmo), abs=1e-6)

        _is_planned(page, session, gizmo, "obstacles")
        assert before is not None
        assert session.plan is not None
        assert not drawn.same(before, session.plan)
        assert page.complaints() == []
        # What the plan excludes lies in the obstacle as it stands now.
        low, high = session.plan.scene.obstacles[0].bounds()
        gone = page.points("/mesh/excluded")
        room = session.plan.scene.spline.clearance + 0.01 * max(session.plan.scene.workspace.size)
        assert len(gone) > 0
        assert ((gone > low - room) & (gone < high + room)).all()


def test_bodies_are_dragged_by_themselves(page: Page, session: Session) -> None:
    (obstacle,) = drawn.obstacles(page)
    for gizmo, field in ((obstacle, "obstacles"), ("/goal", "goal")):
        old, start = np.array(page.position(gizmo)), page.pixel(gizmo)
        page.drag(start, (start[0] - 30, start[1] + 24))
        page.until(lambda old=old, g=gizmo: not np.allclose(page.position(g), old), "a move")  # type: ignore[misc]
        _is_planned(page, session, gizmo, field)
        page.settle()
        assert page.pixel(gizmo) == pytest.approx((start[0] - 30, start[1] + 24), abs=12)
    goal = page.position("/goal")
    assert all(-1e-6 <= number <= 6 + 1e-6 for number in goal)
    assert page.complaints() == []


def test_a_drag_is_undone_at_once_though_the_hand_rested_in_it(
    page: Page, session: Session
) -> None:
    assert session.plan is not None
    start = session.plan.scene
    for gizmo in (*drawn.obstacles(page), "/goal"):

        def rest() -> None:
            page.until(lambda: session.plan.scene != start and session.resting, "a rest")  # type: ignore[union-attr]

        page.drag_arrow(gizmo, 2, -0.9, midway=rest)
        page.until(lambda: not session.panels.held and session.resting, "the hand to let go")
        page.click("Undo")
        page.until(lambda: session.plan.scene == start, "the scene before the drag")  # type: ignore[union-attr]
        page.until(lambda: drawn.shows(page, session.plan), "its plan")


def test_the_goal_goes_where_it_is_dragged(page: Page, session: Session) -> None:
    before, old = session.plan, np.array(page.position("/goal"))
    page.drag_arrow("/goal", 1, -2.0)
    moved = np.array(page.position("/goal")) - old
    assert moved == pytest.approx([0, -2.0, 0], abs=0.15)
    assert page.position("/goal/ball") == pytest.approx(page.position("/goal"), abs=1e-6)

    _is_planned(page, session, "/goal", "goal")
    assert before is not None
    assert session.plan is not None
    assert not drawn.same(before, session.plan)
    goal = session.plan.scene.goal
    page.until(lambda: _coordinates(page) == pytest.approx(goal, abs=1e-3), "the goal's label")
    ends = drawn.chain(page.points("/curve/quadratic"))[[0, -1]]
    np.testing.assert_allclose(ends[0], session.plan.scene.start, atol=drawn.SINGLE)
    np.testing.assert_allclose(ends[1], page.position("/goal"), atol=drawn.SINGLE)
    assert page.complaints() == []


def test_no_hand_takes_the_goal_out_of_the_workspace(page: Page, session: Session) -> None:
    page.drag_arrow("/goal", 2, 1)
    _is_planned(page, session, "/goal", "goal")
    assert page.position("/goal") == pytest.approx((6, 6, 6), abs=1e-6)
    assert page.complaints() == []

    # The same after it was put elsewhere by other means.
    page.click("Scene")
    for axis, number in enumerate((5.75, 5.5, 5.125)):
        page.set_number("goal [cm]", number, axis)
    page.until(lambda: session.plan.scene.goal == (5.75, 5.5, 5.125), "the goal as typed")  # type: ignore[union-attr]
    page.settle()
    page.drag_arrow("/goal", 2, 1.2)
    _is_planned(page, session, "/goal", "goal")
    assert page.position("/goal") == pytest.approx((5.75, 5.5, 6), abs=1e-6)
    page.drag_arrow("/goal", 1, -1.0)
    _is_planned(page, session, "/goal", "goal")
    assert page.position("/goal") == pytest.approx((5.75, 4.5, 6), abs=0.15)
    assert page.complaints() == []


def _coordinates(page: Page) -> list[float]:
    """The goal's place by its label."""
    text = page.props("/goal/label")["text"]
    assert text.startswith("goal (")
    return [float(number.replace("−", "-")) for number in text[6:-1].split(", ")]


def test_a_control_point_bends_a_curve_of_the_tabs_own(page: Page, session: Session) -> None:
    page.until(lambda: session.resting, "rest")
    plan = session.plan
    assert plan is not None
    assert plan.bspline is not None
    box = session.panels.layer_switches.boxes["bent"]
    page.click("Layers")
    page.tick("control points to drag", True)
    page.until(lambda: bool(box.value) and "/bend/1" in page.shown(), "the balls")
    page.settle()
    grip = page.pixel("/bend/1")
    page.drag(grip, (grip[0] - 10, grip[1] + 40))

    def follows() -> bool:
        """Whether the curve has followed the hand to its end."""
        bent = session.frame.bent
        if bent is None:
            return False
        return np.allclose(
            page.position("/bend/1"), bent.curve.control_points[1], rtol=0, atol=1e-5
        )

    page.until(follows, "a bent curve")
    assert session.plan is plan
    page.tick("control points to drag", False)
    page.until(lambda: session.frame.bent is None, "the curve to be the plan's again")
    page.until(lambda: "/bend/1" not in page.shown(), "no balls")
