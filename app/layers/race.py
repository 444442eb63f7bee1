"""Three searches in three copies of the workspace, at equal steps, coloured by their order."""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.scene.scene import Scene
from abi.search.replay import SearchState
from app.camera.camera import aspect
from app.camera.view import View
from app.drawing.box import box_edges
from app.drawing.lines import add_line, segments
from app.drawing.obstacle_body import add_body
from app.layers.points import add_points, set_points
from app.layers.search_step import few, order_colours
from app.state.frame import Draw, Frame
from app.theatre.theatre import Theatre, label_of
from app.ui import style
from app.ui.colour_scale import scale_colours
from app.ui.layout import Layout
from app.ui.numbers import format_count, format_length

_ROW = np.array([0.42, 0.82, 0.0]) / np.hypot(0.42, 0.82)
"""Direction of the row: across the first view."""
_GAP = 1.7
_COLOURS = ((30, 44, 84), (150, 182, 232))
"""Of visited nodes, early to late: blue, as in the picture of one search."""
_HEIGHT = 9.0
"""Height of the copies over the workspace, in its sizes: so far that it is out of their picture."""
_LEGEND = (
    "Dark blue nodes were visited early, light ones late, the magenta one last; green ones wait."
)


def race_layer(layout: Layout) -> Draw:
    """The copies, above the workspace; the camera looks at them while there are any."""
    client, scene_nodes = layout.client, layout.client.scene
    with layout.search:
        text = client.gui.add_html("", visible=False)
    root: viser.FrameHandle | None = None
    labels: list[viser.LabelHandle] = []
    built: tuple[object, ...] = ()
    drawn: tuple[Theatre | None, float] = (None, 1.0)
    view: View | None = None

    def draw(frame: Frame) -> None:
        nonlocal root, labels, built, drawn, view
        theatre = frame.theatre if frame.theatre is not None and frame.theatre.race else None
        if drawn == (theatre, frame.label_scale):
            return
        drawn = theatre, frame.label_scale
        text.visible = theatre is not None
        scene, before = frame.plan.scene, built
        built = ()
        if theatre is not None:
            built = scene.obstacles, scene.workspace, len(theatre.race)
        if root is not None and built != before:
            root.remove()
            root = None
            if view is not None:
                view.show(client.camera)
        if theatre is None:
            return
        if root is None:
            view = View.of_camera(client.camera)
            root, labels = _build(scene_nodes, scene, len(theatre.race))
            _look_at_copies(client.camera, scene)
        for place, (name, state) in enumerate(theatre.race):
            _draw_one(scene_nodes, place, state, scene)
            labels[place].text = _label(name, state, scene.unit)
            labels[place].font_screen_scale = frame.label_scale
        lines = [report(name, state, scene.unit) for name, state in theatre.race]
        text.content = style.paragraph("<br>".join([*lines, _LEGEND]))

    return draw


def _build(
    nodes: viser.SceneApi, scene: Scene, count: int
) -> tuple[viser.FrameHandle, list[viser.LabelHandle]]:
    """Add boxes and obstacles; the node that all are in, and the label of each copy."""
    longest, labels = max(scene.workspace.size), []
    root = nodes.add_frame("/race", show_axes=False)
    for place in range(count):
        shift = offset(scene, place, count)
        name = f"/race/{place}"
        nodes.add_frame(name, show_axes=False, position=tuple(shift.tolist()))
        box = add_line(nodes, f"{name}/box", style.WORKSPACE, 1.5)
        box.points = box_edges(scene.workspace.min, scene.workspace.max).astype(np.float32)
        for number, obstacle in enumerate(scene.obstacles):
            nodes.add_frame(
                f"{name}/obstacle_{number}",
                show_axes=False,
                position=obstacle.position,
                wxyz=obstacle.wxyz,
            )
            add_body(nodes, f"{name}/obstacle_{number}/body", obstacle)
        middle = np.add(scene.workspace.min, scene.workspace.max) / 2
        top = (middle[0], middle[1], scene.workspace.max[2] + 0.3 * longest)
        labels.append(nodes.add_label(f"{name}/label", "", position=top, anchor="bottom-center"))
    return root, labels


def _look_at_copies(camera: viser.CameraHandle, scene: Scene) -> None:
    centre = np.add(scene.workspace.min, scene.workspace.max) / 2
    target = centre + offset(scene, 0, 1)
    away = np.array([_ROW[1], -_ROW[0], 0.42])
    sideways = np.tan(camera.fov / 2) * min(aspect(camera), 1.5)
    camera.position = target + max(2.5 / sideways, 2.5) * max(scene.workspace.size) * away
    camera.look_at = target


def _draw_one(scene_nodes: viser.SceneApi, place: int, state: SearchState, scene: Scene) -> None:
    points, n = state.trace.arcs.points, len(state.trace.arcs.points)
    closed, front = few(state.closed, n), few(state.open, n)
    visited = scale_colours(_COLOURS, order_colours(state, closed))
    visited[closed == state.current] = style.MARK
    waiting = np.tile(np.array(style.WAITING[1], np.uint8), (len(front), 1))
    colours = np.concatenate([visited, waiting])
    nodes = np.concatenate([closed, front])
    size = 0.24 * float((np.prod(scene.workspace.size) / n) ** (1 / 3))
    cloud = add_points(scene_nodes, f"/race/{place}/nodes")
    set_points(cloud, points[nodes % n], colours, size)
    cloud.visible = True
    path = add_line(scene_nodes, f"/race/{place}/path", style.MARK, 5.0)
    path.points = segments(points[state.trace.vertices]) if state.done else path.points


def offset(scene: Scene, place: int, count: int) -> FloatArray:
    """Step from the workspace to a copy, (3,), [unit]."""
    longest = max(scene.workspace.size)
    across = (place - (count - 1) / 2) * _GAP * longest * _ROW
    return np.asarray(across + np.array([0.0, 0.0, _HEIGHT * longest]))


def report(name: str, state: SearchState, unit: str) -> str:
    """Counters of one search, as HTML."""
    length = f"found {format_length(state.trace.length)} {unit}"
    done = length if _found(state) else _without_path(name)
    return (
        f"<b>{label_of(name)}</b>: {_steps(state)}, "
        f"{format_count(state.examined)} edges tried, {done if state.done else 'searching'}"
    )


def _label(name: str, state: SearchState, unit: str) -> str:
    """State of a search in short lines, since the three stand side by side."""
    lines = [label_of(name), _steps(state), f"{format_count(state.examined)} edges"]
    if state.done:
        length = f"{format_length(state.trace.length)} {unit}"
        lines.append(length if _found(state) else _without_path(name))
    return "\n".join(lines)


def _without_path(name: str) -> str:
    """How a search ended that has no path: a student's is followed to its first wrong step."""
    return "this step is wrong" if name == "yours" else "no path"


def _steps(state: SearchState) -> str:
    what = "rounds" if state.trace.queue == "rounds" else "nodes"
    return f"{format_count(state.step)} {what}"


def _found(state: SearchState) -> bool:
    return len(state.trace.vertices) > 0
