"""Scenes without a plan: the reason at rest, and the change that helps at a press."""

from __future__ import annotations

import re

import numpy as np

import abi
from app.tab.session import Session
from tests.browser import drawn
from tests.browser.page import Page

DO_THAT = "Move the start"


def _offers(page: Page) -> int:
    name = re.compile("^(Move|Set|Change|Remove) ")
    return page.tab.get_by_role("button", name=name).filter(visible=True).count()


def _shows_no_curve(page: Page, session: Session) -> None:
    """Wait until no line of an older plan is left."""
    page.until(lambda: drawn.shows(page, session.plan), "the old curves to go")
    for line in ("/path/dijkstra", "/path/bellman_ford", "/curve/control_polygon", "/trace"):
        page.until(lambda line=line: drawn.is_nothing(page.points(line)), f"no {line}")  # type: ignore[misc]


def test_a_walled_in_goal_says_by_what_and_draws_no_path(page: Page, session: Session) -> None:
    page.click("Scene")
    page.choose("scene", "no-way")
    page.until(lambda: session.plan.scene == abi.load_scene("no-way"), "the scene")  # type: ignore[union-attr]
    _shows_no_curve(page, session)
    page.reads("No path: the goal is walled in by obstacles 1–6.")
    # a scene that is shipped so says it calmly
    assert page.complaints() == []
    sentence = page.tab.locator("#abi-overlay [data-part=message]").inner_text()
    assert "This scene asks for a change." in sentence
    assert "A smaller clearance or a finer grid does not help (tested)." in sentence
    assert _offers(page) == 1
    player = page.tab.locator(".abi-player")
    page.until(lambda: not player.is_visible(), "the player of no motion to go")
    page.click("Result")
    page.reads("No motion, nothing to plot.")
    page.click("Scene")

    assert session.plan is not None
    assert session.plan.graph is not None
    assert session.plan.quadratic is None
    # What the goal can reach is marked, and lies inside the walls.
    page.until(lambda: "/marks" in page.shown(), "the marks")
    marks = page.points("/marks")
    assert (np.abs(marks - (4.2, 4.2, 3)) < 1.2).all()
    assert np.linalg.norm(marks - session.plan.scene.goal, axis=1).min() < 1e-5
    headings = [line for line in page.text().splitlines() if re.match(r"[3-6] · ", line)]
    later = [f"{title} — not reached" for title in ("4 · B-spline", "5 · Quadratic", "6 · Arm")]
    assert headings == ["3 · Search — no path ✗", *later]
    assert len(drawn.obstacles(page)) == 6

    named = re.search(r"Removing obstacle (\d) opens a way", sentence)
    assert named is not None
    page.click(f"Show obstacle {named[1]}")
    gizmo = drawn.obstacles(page)[int(named[1]) - 1]
    page.until(lambda: not page.props(gizmo)["disable_axes"], "its arrows")
    page.click(f"Remove obstacle {named[1]}")
    page.until(lambda: session.plan.path is not None, "a path")  # type: ignore[union-attr]
    page.until(player.is_visible, "the player")
    page.until(lambda: len(drawn.obstacles(page)) == 5, "one obstacle less")
    page.click("Undo")
    page.until(lambda: session.plan.scene == abi.load_scene("no-way"), "the scene as it was")  # type: ignore[union-attr]
    page.until(lambda: len(drawn.obstacles(page)) == 6, "all obstacles")

    page.choose("scene", "paper")
    page.until(lambda: session.plan.scene == abi.load_scene("paper"), "the paper's scene")  # type: ignore[union-attr]
    page.until(lambda: drawn.shows(page, session.plan), "its curves")
    page.until(lambda: page.complaints() == [], "no complaint")
    page.until(lambda: "/marks" not in page.shown(), "the marks to go")
    assert session.plan.quadratic is not None
    assert drawn.same(session.plan, abi.plan(abi.load_scene("paper")))
    (gizmo,) = drawn.obstacles(page)
    page.node(f"{gizmo}/body")


def test_the_change_that_helps_is_made_at_a_press(page: Page, session: Session) -> None:
    page.click("Scene")
    for axis, number in enumerate((2.25, 3, 3)):
        page.set_number("start [cm]", number, axis)
        # the page tells only the last of two edits within 50 ms
        page.until(lambda: session.frame.plan.scene.start[axis] == number, "it")  # noqa: B023
    page.until(lambda: _offers(page) == 1, "the offer")
    (sentence,) = page.complaints()
    assert "The start is 0.25 cm inside obstacle 1." in sentence
    found = re.search(r"Move the start to \((.+)\) cm, the nearest free point found", sentence)
    assert found is not None
    free = tuple(float(number) for number in found.group(1).split(","))
    assert free[0] < 2
    _shows_no_curve(page, session)
    page.until(lambda: "/marks" in page.shown(), "the mark")
    np.testing.assert_allclose(page.points("/marks"), [free], atol=drawn.SINGLE)

    page.click(DO_THAT)
    page.until(lambda: session.plan.path is not None, "a path")  # type: ignore[union-attr]
    page.until(lambda: drawn.shows(page, session.plan), "its picture")
    page.until(lambda: page.complaints() == [] and _offers(page) == 0, "no complaint, no offer")
    assert session.plan is not None
    assert session.plan.scene == abi.load_scene("paper").replace(start=free)
    np.testing.assert_allclose(page.position("/start"), free, atol=drawn.SINGLE)
    page.until(lambda: "/marks" not in page.shown(), "the mark to go")
