"""Three searches in three copies of the workspace, at equal steps, coloured by their order."""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.scene.scene import Scene
from abi.search.replay import SearchState
from app.camera.camera import View, aspect
from app.drawing.box import box_edges
from app.drawing.lines import add_line, segments
from app.drawing.obstacle_body import add_body
from app.layers.points import add_points, set_points
from app.layers.search_step import few, order_colours
from app.state.frame import Frame
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


class RaceLayer:
    """The copies, above the workspace; the camera looks at them while there are any."""

    def __init__(self, layout: Layout) -> None:
        self._client = layout.client
        self._scene = layout.client.scene
        with layout.search:
            self._text = layout.client.gui.add_html("", visible=False)
        self._root: viser.FrameHandle | None = None
        self._labels: list[viser.LabelHandle] = []
        self._built: tuple[object, ...] = ()
        self._drawn: Theatre | None = None
        self._scale = 1.0
        self._view: View | None = None

    def __call__(self, frame: Frame) -> None:
        """Draw the race; take the copies away where there is none."""
        theatre = frame.theatre if frame.theatre is not None and frame.theatre.race else None
        if theatre is self._drawn and frame.label_scale == self._scale:
            return
        self._drawn, self._scale = theatre, frame.label_scale
        self._text.visible = theatre is not None
        if theatre is None:
            self._clear()
            return
        scene = frame.plan.scene
        built = (scene.obstacles, scene.workspace, len(theatre.race))
        if built != self._built or self._root is None:
            self._clear()
            self._build(scene, len(theatre.race))
            self._built = built
        for place, (name, state) in enumerate(theatre.race):
            self._draw_one(place, name, state, scene)
        for label in self._labels:
            label.font_screen_scale = frame.label_scale
        unit = frame.plan.scene.unit
        lines = [report(name, state, unit) for name, state in theatre.race]
        self._text.content = style.paragraph("<br>".join([*lines, _LEGEND]))

    def _build(self, scene: Scene, count: int) -> None:
        """Add boxes and obstacles, and turn the camera to them."""
        longest = max(scene.workspace.size)
        self._root = self._scene.add_frame("/race", show_axes=False)
        for place in range(count):
            shift = offset(scene, place, count)
            name = f"/race/{place}"
            self._scene.add_frame(name, show_axes=False, position=tuple(shift.tolist()))
            box = add_line(self._scene, f"{name}/box", style.WORKSPACE, 1.5)
            box.points = box_edges(scene.workspace.min, scene.workspace.max).astype(np.float32)
            for number, obstacle in enumerate(scene.obstacles):
                self._scene.add_frame(
                    f"{name}/obstacle_{number}",
                    show_axes=False,
                    position=obstacle.position,
                    wxyz=obstacle.wxyz,
                )
                add_body(self._scene, f"{name}/obstacle_{number}/body", obstacle)
            middle = np.add(scene.workspace.min, scene.workspace.max) / 2
            top = (middle[0], middle[1], scene.workspace.max[2] + 0.3 * longest)
            self._labels.append(
                self._scene.add_label(f"{name}/label", "", position=top, anchor="bottom-center")
            )
        camera = self._client.camera
        self._view = View.of_camera(camera)
        centre = np.add(scene.workspace.min, scene.workspace.max) / 2
        target = centre + offset(scene, 0, 1)
        away = np.array([_ROW[1], -_ROW[0], 0.42])
        sideways = np.tan(camera.fov / 2) * min(aspect(camera), 1.5)
        camera.position = target + max(2.5 / sideways, 2.5) * longest * away
        camera.look_at = target

    def _clear(self) -> None:
        """Take the copies away, and give the camera back."""
        if self._root is None:
            return
        self._root.remove()
        self._root, self._built = None, ()
        self._labels.clear()
        if self._view is not None:
            self._view.show(self._client.camera)

    def _draw_one(self, place: int, name: str, state: SearchState, scene: Scene) -> None:
        points, n = state.trace.arcs.points, len(state.trace.arcs.points)
        closed, front = few(state.closed, n), few(state.open, n)
        visited = scale_colours(_COLOURS, order_colours(state, closed))
        visited[closed == state.current] = style.MARK
        waiting = np.tile(np.array(style.WAITING[1], np.uint8), (len(front), 1))
        colours = np.concatenate([visited, waiting])
        nodes = np.concatenate([closed, front])
        size = 0.24 * float((np.prod(scene.workspace.size) / n) ** (1 / 3))
        cloud = add_points(self._scene, f"/race/{place}/nodes")
        set_points(cloud, points[nodes % n], colours, size)
        cloud.visible = True
        path = add_line(self._scene, f"/race/{place}/path", style.MARK, 5.0)
        path.points = segments(points[state.trace.vertices]) if state.done else path.points
        self._labels[place].text = _label(name, state, scene.unit)


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
