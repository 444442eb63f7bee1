"""The first view, without a click."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser

import abi
from app.server.server import Server
from app.tab.session import Session
from tests.browser import drawn
from tests.browser.conftest import Tabs
from tests.browser.page import Page

_CHARTS = """() => Object.values(window.__viserTestpoints.uplots).map(
  ({chart}) => [chart.scales.x.min, chart.scales.x.max, chart.data[0][0], chart.data[0].at(-1)])"""

# Layers by their switches, and a node of each: meshes, thin lines, points, fat lines, labels.
_IN_THE_PICTURE = {
    "arm": "/arm",
    "mesh edges": "/mesh/edges",
    "mesh nodes": "/mesh/nodes",
    "quadratic": "/curve/quadratic",
    "names and distance": "/name/line",
}


@pytest.fixture(scope="module")
def page(chromium: Browser, server: Server) -> Iterator[Page]:
    """A tab in which nothing was touched, its canvas large enough for a picture."""
    tabs = Tabs(chromium, server)
    yield tabs("?fixedDpr=0.4")
    tabs.close()


def _plan(session: Session) -> abi.Plan:
    assert session.plan is not None
    return session.plan


def test_the_plan_is_that_of_the_paper(session: Session) -> None:
    assert drawn.same(_plan(session), abi.plan(abi.load_scene("paper")))


def test_the_page_tells_that_no_graphics_card_draws(page: Page) -> None:
    assert page.tab.evaluate("() => window.abi.drawsInSoftware()")


def test_paths_are_the_plans(page: Page, session: Session) -> None:
    plan = _plan(session)
    found = {result.algorithm: result.points for result in plan.searches}
    assert drawn.shows_path(page, plan)

    # The others lie beside theirs, all of it by one small step, so that none hides another.
    beside = 0.01 * max(plan.scene.workspace.size)
    whole = drawn.chain(page.points("/path/bellman_ford"))
    steps = whole - found["bellman_ford"]
    np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=drawn.SINGLE)
    assert 0 < np.linalg.norm(steps[0]) < beside

    dashes = page.points("/path/dijkstra")
    assert (drawn.distance(dashes.reshape(-1, 3), found["dijkstra"]) < beside).all()
    inked = np.linalg.norm(dashes[:, 1] - dashes[:, 0], axis=1).sum()
    length = next(r.length for r in plan.searches if r.algorithm == "dijkstra")
    assert 0.5 * length < inked < 0.7 * length


def test_curves_are_the_plans(page: Page, session: Session) -> None:
    plan = _plan(session)
    assert plan.bspline is not None
    assert drawn.shows_curve(page, "bspline", plan.bspline)
    assert drawn.shows_curve(page, "quadratic", plan.quadratic)
    control = plan.bspline.curve.control_points
    np.testing.assert_allclose(page.points("/curve/control_points"), control, atol=drawn.SINGLE)
    polygon = drawn.chain(page.points("/curve/control_polygon"))
    np.testing.assert_allclose(polygon, control, atol=drawn.SINGLE)


def test_the_mesh_is_the_plans(page: Page, session: Session) -> None:
    plan = _plan(session)
    assert plan.mesh is not None
    assert plan.free is not None
    assert plan.graph is not None
    gone = plan.free.excluded
    for name, points in (("nodes", plan.mesh.points[~gone]), ("excluded", plan.mesh.points[gone])):
        np.testing.assert_allclose(page.points(f"/mesh/{name}"), points, atol=drawn.SINGLE)
    # each edge is in the lengths twice
    assert page.ink("/mesh/edges") == pytest.approx(plan.graph.lengths.sum() / 2, rel=1e-5)


def test_what_is_placed_by_hand_is_in_its_place(page: Page) -> None:
    scene = abi.load_scene("paper")
    (gizmo,) = drawn.obstacles(page)
    for name, place in (
        (gizmo, scene.obstacles[0].position),
        (f"{gizmo}/body", scene.obstacles[0].position),
        ("/start/ball", scene.start),
        ("/goal/ball", scene.goal),
    ):
        np.testing.assert_allclose(page.position(name), place, atol=drawn.SINGLE)
    box = page.points("/workspace").reshape(-1, 3)
    np.testing.assert_array_equal(box.min(axis=0), scene.workspace.min)
    np.testing.assert_array_equal(box.max(axis=0), scene.workspace.max)
    assert page.props("/goal/label")["text"] == "goal (6, 6, 6)"


def test_every_layer_is_to_be_seen(page: Page) -> None:
    shown = page.shown()
    for folder, names in (
        ("/mesh", ("edges", "nodes", "excluded")),
        ("/path", ("a_star", "dijkstra", "bellman_ford")),
        ("/curve", ("bspline", "control_polygon", "control_points", "quadratic")),
        ("", ("workspace", "start/ball", "goal/ball", "obstacle_1/body", "trace", "arm/links")),
    ):
        assert {f"{folder}/{name}" for name in names} <= shown


def test_the_tool_moves_along_the_curve(page: Page, session: Session) -> None:
    plan = _plan(session)
    assert plan.motion is not None
    parts = {"turret", "upper_arm", "elbow", "forearm", "rod", "gripper"}
    meshes = [name for name in page.names() if name.startswith("/arm/") and name.endswith("/mesh")]
    assert parts <= {name.split("/")[-2] for name in meshes}

    seen = [np.array(page.position(drawn.TOOL))]

    def moved() -> bool:
        here = np.array(page.position(drawn.TOOL))
        if np.linalg.norm(here - seen[-1]) > 0.05:
            seen.append(here)
        return len(seen) > 4

    page.until(moved, "the arm to move")
    # A page may hold some joints of one frame and some of the next for a moment.
    assert (drawn.distance(np.array(seen), plan.motion.tool) < 0.5).all()


def test_headings_carry_the_results(page: Page, session: Session) -> None:
    plan = _plan(session)
    assert plan.mesh is not None
    assert plan.free is not None
    assert plan.graph is not None
    assert plan.path is not None
    assert plan.bspline_arc is not None
    text = page.text()
    for heading in (
        f"1 · Mesh — {plan.free.nodes} free nodes",
        f"2 · Graph — {plan.graph.edge_count} edges",
        f"3 · Search — A* {plan.path.length:.3f}",
        f"4 · B-spline — {plan.bspline_arc.length:.3f} cm ✓",
        "5 · Quadratic — too close ✗",
        "too close: 0.012 cm, wanted 0.2 cm",
        "6 · Arm — proven clear ✓",
    ):
        assert heading in text
    assert page.complaints() == []


def test_the_table_holds_the_three_algorithms(page: Page, session: Session) -> None:
    rows = [line.split("\t") for line in page.text().splitlines() if "\t" in line]
    table = {row[0]: row[1:] for row in rows if len(row) == 6}
    for label, result in zip(
        ("A*", "Dijkstra", "Bellman-Ford (queue)"), _plan(session).searches, strict=True
    ):
        vertices, length, expanded, relaxed, _ = table[label]
        assert int(vertices) == len(result.vertices)
        assert float(length) == round(result.length, 3)
        assert int(expanded) == result.expanded
        assert int(relaxed.replace(",", "")) == result.relaxed


def test_the_plot_spans_the_motion(page: Page, session: Session) -> None:
    def spans() -> bool:
        profile = _plan(session).profile
        assert profile is not None
        charts = page.tab.evaluate(_CHARTS)
        # a chart that is drawn anew, as when the kernels are compiled, has no scale for a moment
        return bool(charts) and all(
            (low, first) == (0, 0) and high == last and abs(high - profile.duration) < 1e-6
            for low, high, first, last in charts
        )

    page.until(spans, "the plots over the whole motion")


def test_nothing_comes_from_elsewhere(page: Page, server: Server) -> None:
    loaded = page.tab.evaluate("performance.getEntriesByType('resource').map(entry => entry.name)")
    elsewhere = [url for url in loaded if not re.match(r"(data|blob):", url)]
    assert [url for url in elsewhere if not url.startswith(server.url)] == []
    assert page.tab.title() == "ABI visualiser"


def test_what_is_shown_is_in_the_picture(page: Page) -> None:
    page.click("Pause")
    page.click("Layers")
    page.settle()
    assert set(_IN_THE_PICTURE.values()) <= page.shown()
    before = page.picture()
    for layer, node in _IN_THE_PICTURE.items():
        page.tick(layer, False)
        page.until(lambda node=node: node not in page.shown(), f"{node} to go")  # type: ignore[misc]
        page.settle()
        after = page.picture()
        assert (after != before).sum() > 20, f"{node} was in the picture"
        before = after
    assert (page.picture() == before).all(), "it stands still"
