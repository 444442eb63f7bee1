"""One search at one step: closed and open nodes, the current one, tree, path and numbers."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.scene.scene import Scene
from abi.search.compare import COMPARED
from abi.search.replay import SearchState, steps_of_changes
from app import glb, style
from app.frame import Frame, Layer
from app.layers.line_set import LineSet
from app.layers.points import Points
from app.layout import Layout
from app.lines import NO_SEGMENTS, add_line, segments
from app.numbers import format_count, format_length, unbroken
from app.table import table
from app.theatre import Theatre, labels, where

NODE_BUDGET = 20_000
"""Nodes of each kind that a tab is sent at the most."""
_PLACES = ("next", "2nd", "3rd", "4th", "5th")
"""Names of the nodes at the queue's head that are shown."""
_MIX = np.uint64(2654435761)


class TheatreLayer(Layer):
    """Pictures of the frame's theatre; nothing while it has none."""

    def __init__(self, layout: Layout) -> None:
        self._scene = scene = layout.client.scene
        with layout.search:
            self._text = layout.client.gui.add_html("", visible=False)
        self._clouds: dict[str, Points] = {}
        self._tree = LineSet(scene, "/theatre/tree")
        self._path = add_line(scene, "/theatre/path", style.MARK, 5.0)
        self._negative = add_line(scene, "/theatre/negative", style.VIOLATION, 6.0)
        self._cycle = add_line(scene, "/theatre/cycle", style.VIOLATION, 6.0)
        self._drawn: Theatre | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the step; hide all where there is none, or while searches race."""
        theatre = frame.theatre
        if theatre is self._drawn:
            return
        alone = theatre is not None and not theatre.race
        for cloud in self._clouds.values():
            cloud.show(alone)
        for line in (self._path, self._negative, self._cycle):
            line.visible = alone
        if not alone:
            self._tree.draw(b"")
        self._text.visible = alone
        if theatre is not None and alone:
            self._draw_state(theatre)
            self._text.content = unbroken(describe(theatre, frame.plan.scene))
        self._drawn = theatre

    def _draw_state(self, theatre: Theatre) -> None:
        state = theatre.state
        points, n = state.trace.arcs.points, len(state.trace.arcs.points)
        size = _size(state)
        current, clicked = (
            np.array([node], np.int32)[: node >= 0] for node in (state.current, theatre.clicked)
        )
        shown = {
            "closed": (style.CLOSED, size, few(state.closed, n)),
            "open": (style.OPEN, 1.25 * size, few(state.open, n)),
            "current": (style.MARK, 1.9 * size, current),
            "clicked": (style.POINT, 1.6 * size, clicked),
        }
        for name, (colour, diameter, nodes) in shown.items():
            if name not in self._clouds:
                self._clouds[name] = Points(self._scene, f"/theatre/{name}")
            self._clouds[name].draw(points[nodes % n], colour, diameter, len(nodes) > 0)
        self._path.points = segments(points[state.path() % n])
        arc = state.trace.arcs.negative
        self._negative.points = NO_SEGMENTS if arc is None else segments(points[list(arc)])
        cycle = state.trace.cycle if state.done else state.trace.cycle[:0]
        self._cycle.points = segments(points[[*cycle, *cycle[:1]]])
        self._tree.draw(_tree(state))


def _tree(state: SearchState) -> bytes:
    """The edges by which nodes were reached, as binary glTF; empty where there are none."""
    points, n = state.trace.arcs.points, len(state.trace.arcs.points)
    child = few(np.flatnonzero(state.parent >= 0).astype(np.int32), n)
    edges = np.stack([state.parent[child] % n, child % n], axis=1)
    if not len(edges):
        return b""
    used, places = np.unique(edges, return_inverse=True)
    return glb.line_set(points[used], places.reshape(-1, 2).astype(np.int32), style.CLOSED, 0.55)


def few(nodes: IntArray, n: int) -> IntArray:
    """At most about ``NODE_BUDGET`` of the nodes, by a lot that each has drawn for good."""
    if n <= NODE_BUDGET:
        return nodes
    lot = (nodes.astype(np.uint64) * _MIX) & np.uint64(0xFFFFFFFF)
    return nodes[lot < np.uint64(NODE_BUDGET / n * 2**32)]


def order_colours(state: SearchState, nodes: IntArray) -> FloatArray:
    """Place of closed nodes (k,) in the whole search's order, from 0 (early) to 1 (late)."""
    if state.trace.queue == "rounds":
        turn = steps_of_changes(state.trace, state.step)
    else:
        turn = np.zeros(len(state.cost), np.int32)
        turn[state.trace.order[: state.step]] = np.arange(state.step)
    return turn[nodes] / max(state.trace.steps, 1)


def _size(state: SearchState) -> float:
    """Diameter of a node, [unit]."""
    points = state.trace.arcs.points
    box = points.max(axis=0) - points.min(axis=0)
    return 0.2 * float((box.prod() / len(points)) ** (1 / 3))


def describe(theatre: Theatre, scene: Scene) -> str:
    """The step in words and numbers, as HTML."""
    unit = scene.unit
    state = theatre.state
    trace, n = state.trace, len(state.trace.arcs.points)
    what = "round" if trace.queue == "rounds" else "step"
    text = (
        f"<b>{COMPARED[theatre.name].label}</b>, {what} {format_count(state.step)} of "
        f"{format_count(trace.steps)}: "
        f"{_swatch(style.CLOSED)}{format_count(len(state.closed))} visited (closed), "
        f"{_swatch(style.OPEN)}{format_count(len(state.open))} waiting (open), "
        f"{format_count(state.examined)} edges tried."
    )
    if state.done:
        text += f" {_end(state, unit)}"
    named = [
        (f"{_swatch(style.MARK)}now", state.current, ""),
        (f"{_swatch(style.POINT)}clicked", theatre.clicked, ""),
    ]
    if not theatre.asking and trace.queue != "rounds":
        queue = state.queue(len(_PLACES)).tolist()
        sides = (" ←" if node >= n else "" for node in queue)
        named += zip(_PLACES, queue, sides, strict=False)
    rows = [
        (f"{name} {where(state, node)}{side}", *labels(state, node))
        for name, node, side in named
        if node >= 0
    ]
    text = style.paragraph(text)
    if rows:
        cost = unit if scene.search.weight == "length" else "edges"
        text += table(
            (f"node at [{unit}]", f"g so far [{cost}]", f"h to go [{cost}]", f"f [{cost}]"), rows
        )
    if theatre.asking and not state.done:
        asked = "<b>Which node is visited next?</b> Click one of those that wait."
        text += style.paragraph(asked)
    if theatre.answer:
        text += style.paragraph(theatre.answer)
    return text


def _end(state: SearchState, unit: str) -> str:
    trace = state.trace
    if len(trace.cycle):
        return "<b>✗ Negative cycle</b> (red): each turn costs less, so there is no cheapest path."
    if not len(trace.vertices):
        return "<b>✗ No path.</b>"
    found = f"<b>Path found:</b> {format_length(trace.length)} {unit}"
    if trace.arcs.negative is not None:
        found += f", cost {format_length(trace.cost)}"
    return f"{found}."


def _swatch(colour: style.Colour) -> str:
    return (
        '<span style="display:inline-block;width:9px;height:9px;border-radius:50%;margin-right:4px;'
        f'background:{style.css(colour)}"></span>'
    )
