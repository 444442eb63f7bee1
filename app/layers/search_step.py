"""One search at one step: visited and waiting nodes, the current one, tree, path and numbers."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping

import numpy as np
import viser

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.scene.scene import Scene
from abi.search.replay import SearchState, steps_of_changes
from app.drawing import glb
from app.drawing.lines import NO_SEGMENTS, add_line, segments
from app.layers.points import add_points, set_lines, set_points
from app.state.frame import Draw, Frame
from app.theatre.compared import asks_for_sums, letter_label, lettered, lots
from app.theatre.text import describe
from app.theatre.theatre import Theatre, decimals, formula, priorities, rounded
from app.ui import page, style
from app.ui.colour_scale import scale_colours
from app.ui.layout import Layout
from app.ui.numbers import unbroken

NODE_BUDGET = 20_000
"""Nodes of each kind that a tab is sent at the most."""
_LINES = (
    ("path", style.MARK, 5.0),
    ("negative", style.VIOLATION, 6.0),
    ("cycle", style.VIOLATION, 6.0),
)
"""Lines of a search: name, colour and thickness, [px]."""


def search_step_layer(layout: Layout) -> Draw:
    """Pictures of the frame's theatre; nothing while it has none, or while searches race."""
    client, scene = layout.client, layout.client.scene
    with layout.search:
        text = client.gui.add_html("", visible=False)
    clouds: dict[str, viser.PointCloudHandle] = {}
    lines = {
        name: add_line(scene, f"/theatre/{name}", colour, thickness)
        for name, colour, thickness in _LINES
    }
    tree: viser.GlbHandle | None = None
    drawn: Theatre | None = None

    def draw(frame: Frame) -> None:
        nonlocal tree, drawn
        theatre, told = frame.theatre, drawn is not None and not drawn.race
        if theatre is drawn:
            return
        drawn = theatre
        alone = theatre is not None and not theatre.race
        for node in (*clouds.values(), *lines.values()):
            node.visible = alone
        text.visible = alone
        edges = _tree(theatre.state) if theatre is not None and alone else b""
        tree = set_lines(scene, "/theatre/tree", tree, edges)
        if theatre is not None and alone:
            _draw_nodes(scene, clouds, theatre)
            _draw_lines(lines, theatre.state)
            text.content = unbroken(describe(theatre, frame.plan.scene))
            page.call(client, "showNodes", node_numbers(theatre, frame.plan.scene))
        elif told:
            page.call(client, "showNodes", None)

    return draw


def _draw_nodes(
    scene: viser.SceneApi, clouds: dict[str, viser.PointCloudHandle], theatre: Theatre
) -> None:
    """Draw the nodes of each kind as a cloud, which is added where there is none yet."""
    state = theatre.state
    points, n = state.trace.arcs.points, len(state.trace.arcs.points)
    size = _size(state)
    current, clicked = (
        np.array([node], np.int32)[: node >= 0] for node in (state.current, theatre.clicked)
    )
    waiting = few(state.open, n)
    shown: dict[str, tuple[style.Colour | ByteArray, float, IntArray]] = {
        "closed": (style.CLOSED, size, few(state.closed, n)),
        "open": (waiting_colours(theatre, waiting), 1.25 * size, waiting),
        "current": (style.MARK, 1.9 * size, current),
        "clicked": (style.POINT, 1.6 * size, clicked),
    }
    for name, (colour, diameter, nodes) in shown.items():
        if name not in clouds:
            clouds[name] = add_points(scene, f"/theatre/{name}")
        set_points(clouds[name], points[nodes % n], colour, diameter)
        clouds[name].visible = len(nodes) > 0


def _draw_lines(lines: Mapping[str, viser.LineSegmentsHandle], state: SearchState) -> None:
    """Draw the path, the negative edge and the cycle that it makes, where there are any."""
    points, arc = state.trace.arcs.points, state.trace.arcs.negative
    lines["path"].points = segments(points[state.path() % len(points)])
    lines["negative"].points = NO_SEGMENTS if arc is None else segments(points[list(arc)])
    cycle = state.trace.cycle if state.done else state.trace.cycle[:0]
    lines["cycle"].points = segments(points[[*cycle, *cycle[:1]]])


def waiting_colours(theatre: Theatre, nodes: IntArray) -> ByteArray:
    """Colours (k, 3) of open nodes: how soon they are visited, or one while that is asked.

    By their rank, and the first ones farther apart than the last: priorities alone would give all
    that may be next the same colour.
    """
    if theatre.open_question:
        return np.array([style.WAITING[0]], np.uint8).repeat(len(nodes), axis=0)
    state = theatre.state
    ranks = np.zeros(len(state.cost))
    _, ranks[state.open] = np.unique(np.round(priorities(state), 9), return_inverse=True)
    return scale_colours(style.WAITING, np.sqrt(ranks[nodes] / max(ranks.max(initial=0.0), 1.0)))


def node_numbers(theatre: Theatre, scene: Scene) -> dict[str, object]:
    """What the page says of a node at the pointer, and which nodes it rings or gives letters.

    g, h and f of visited and waiting nodes are in the order in which these are drawn.
    """
    state = theatre.state
    n = len(state.trace.arcs.points)
    kinds = {"closed": few(state.closed, n), "open": few(state.open, n)}
    digits = decimals(state)
    both = {kind: rounded(state, k, digits) for kind, k in kinds.items()}
    tells_sums = state.trace.queue == "best_first" and not asks_for_sums(theatre)
    line = priorities(state)[np.isin(state.open, kinds["open"])]
    return {
        **{kind: _packed(table) for kind, table in both.items()},
        "ringed": np.flatnonzero(np.isin(kinds["open"], theatre.ringed)).tolist(),
        "size": 1.25 * _size(state),
        "decimals": digits,
        "formula": formula(state) if tells_sums else None,
        "line": _packed(line) if state.trace.queue == "first_in" else None,
        "letters": [
            {
                "letter": letter,
                "number": letter_label(theatre, node),
                "place": state.trace.arcs.points[node % n].tolist(),
            }
            for letter, node in lettered(theatre).items()
        ],
        "answer": theatre.widget,
        "unit": scene.unit if scene.search.weight == "length" else "edges",
    }


def _packed(numbers: FloatArray) -> str:
    return b64encode(numbers.astype("<f4").tobytes()).decode()


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
    """Choose about ``NODE_BUDGET`` of the nodes at random, the same ones each time."""
    if n <= NODE_BUDGET:
        return nodes
    return nodes[lots(nodes) < NODE_BUDGET / n * 2.0**31]


def order_colours(state: SearchState, nodes: IntArray) -> FloatArray:
    """Place of visited nodes (k,) in the whole search's order, from 0 (early) to 1 (late)."""
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
