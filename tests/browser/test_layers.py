"""Switches: each hides and shows its nodes and no other."""

from __future__ import annotations

from fnmatch import fnmatch

from app.state.legend import SWITCHES
from app.tab.session import Session
from tests.browser.page import Page

NODES = {
    "workspace": ("/workspace",),
    "axes": ("/axes",),
    "edges": ("/mesh/edges",),
    "nodes": ("/mesh/nodes",),
    "excluded": ("/mesh/excluded",),
    "a_star": ("/path/a_star", "/name/path"),
    "dijkstra": ("/path/dijkstra",),
    "bellman_ford": ("/path/bellman_ford",),
    "taut": ("/path/taut",),
    # the arm follows it in this scene: the distance shown is the one that it keeps
    "bspline": ("/curve/bspline", "/name/bspline", "/name/distance", "/name/line"),
    "control": ("/curve/control_points", "/curve/control_polygon"),
    "quadratic": ("/curve/quadratic", "/curve/entering", "/name/quadratic"),
    "ghost": ("/ghost",),
    "bases": ("/bases",),
    "names": ("/name/*",),
    "bent": ("/bend",),
    "obstacles": ("/obstacle_*",),
    "trace": ("/trace",),
    "arm": ("/arm",),
    "other_elbow": ("/arm_ghost/now",),
    "end_poses": ("/arm_ghost/start", "/arm_ghost/goal"),
    "tool_only": ("/tool_only",),
    "shadow": ("/arm_region/shadow",),
    "reach": ("/arm_region/reach",),
}
_GROUPS = ("/arm_ghost", "/arm_region")
"""Parents without a look, which stay once a child has been there."""
_BACKGROUND = "() => getComputedStyle(document.body).backgroundColor"


def _nodes(page: Page, layer: str) -> set[str]:
    """The nodes of a layer and all below them; obstacles are numbered on from test to test."""
    tops = NODES[layer]
    return {
        name
        for name in page.names()
        if any(fnmatch(name, top) or fnmatch(name, f"{top}/*") for top in tops)
    }


def _switch(page: Page, session: Session, layer: str, on: bool) -> None:
    """Tick a switch, and wait for the server: of two ticks within 50 ms the page tells the last."""
    (label,) = (switch.label for switch in SWITCHES if switch.name == layer)
    page.tick(label, on)
    box = session.panels.layer_switches.boxes[layer]
    page.until(lambda: box.value == on, f"the switch of {layer}")


def test_every_layer_has_its_switch(page: Page) -> None:
    page.click("Layers")
    assert list(NODES) == [switch.name for switch in SWITCHES]
    for switch in SWITCHES:
        box = page.row(switch.label).locator("input[type=checkbox]")
        assert box.is_checked() == switch.on


def test_a_switch_hides_and_shows_its_nodes_and_no_other(page: Page, session: Session) -> None:
    page.click("Layers")
    page.settle()
    before = page.shown()
    for switch in SWITCHES:
        layer, own = switch.name, _nodes(page, switch.name)
        _switch(page, session, layer, not switch.on)
        if switch.on:
            rest = before - own  # links in red are there, and hidden while clear
            assert rest < before
            page.until(lambda rest=rest: _shown(page) == rest, f"{layer} alone to go")  # type: ignore[misc]
        else:
            page.until(lambda layer=layer: _came(page, before, layer), f"{layer} alone to come")  # type: ignore[misc]
        _switch(page, session, layer, switch.on)
        page.until(lambda: _shown(page) == before, f"{layer} as before")


def _shown(page: Page) -> set[str]:
    return page.shown() - set(_GROUPS)


def _came(page: Page, before: set[str], layer: str) -> bool:
    """Check whether nodes of a layer are seen besides what was seen before, and no others."""
    more = _shown(page) - before
    return before <= _shown(page) and len(more) > 0 and more <= _nodes(page, layer)


def test_what_is_hidden_stays_hidden_in_a_new_plan(page: Page, session: Session) -> None:
    page.click("Layers")
    before = page.shown()
    on = [switch.name for switch in SWITCHES if switch.on]
    for layer in on:
        _switch(page, session, layer, False)
    hidden = set().union(*(_nodes(page, layer) for layer in on))
    page.until(lambda: not page.shown() & hidden, "all layers to go")
    page.set_number("spacing [cm]", 1.0)
    page.set_number("degree", 3)
    page.until(
        lambda: session.plan.scene.spline.degree == 3,  # type: ignore[union-attr]
        "another plan",
    )
    page.reads(f"{session.plan.free.nodes} free nodes")  # type: ignore[union-attr]
    page.settle()
    assert not page.shown() & hidden

    for layer in on:
        _switch(page, session, layer, True)
    page.until(lambda: page.shown() == before, "all layers")


def test_the_dark_switch_darkens_the_page(page: Page) -> None:
    page.click("Layers")
    light = page.tab.evaluate(_BACKGROUND)
    assert light == "rgb(255, 255, 255)"
    page.tick("dark page", True)
    page.until(lambda: page.tab.evaluate(_BACKGROUND) == "rgb(36, 36, 36)", "a dark page")
    page.tick("dark page", False)
    page.until(lambda: page.tab.evaluate(_BACKGROUND) == light, "a light page")


def test_the_search_slider_shows_what_was_expanded(page: Page, session: Session) -> None:
    assert session.plan is not None
    assert session.plan.path is not None
    assert "/search/reached" not in page.shown()
    order = session.plan.path.order.tolist()
    page.until(lambda: session.panels.stages.visited.max == len(order), "the slider's end")
    page.set_number("show visited", len(order))
    page.until(lambda: "/search/reached" in page.shown(), "the expanded nodes")
    points = page.points("/search/reached")
    assert len(points) == len(set(order))
    assert len(page.props("/search/reached")["colors"]) == points.size
    page.picture()  # draws them, or says what WebGL lacks
    page.set_number("show visited", 0)
    page.until(lambda: "/search/reached" not in page.shown(), "them to go")
