"""Draw the small pictures of the scenes and lessons anew, from their plans.

    python -m tools.thumbnails [NAME ...]

Names are those of scenes and lessons; without one: all of them.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from PIL import Image, ImageDraw

import abi
from abi import assets
from abi.arrays import FloatArray
from abi.planner.comparison import search_problem
from abi.planner.plan import Plan
from abi.scene.scene import load_scene, scene_names
from abi.search.compare import COMPARED
from abi.search.replay import replay
from app.drawing.box import box_edges
from app.drawing.lines import parameters, rows_at
from app.layers.arm.joint_trees import tree_lines
from app.teach.lesson import Lesson, scene_of
from app.teach.lesson_file import load_lessons
from app.ui import style

SIZE = (168, 104)
"""Width and height of a picture, [px]: twice those on the page."""
FINER = 4
"""Pixels of the drawing for one of the picture, along each side."""
UNDERWAY = 0.55
"""Part of the motion after which the arm is shown."""
GROUND = (32, 36, 42)
ARM = (206, 212, 222)
_EYE = np.array([-0.55, -0.7, 0.45])
_SCENE = frozenset({"workspace", "obstacles", "bspline", "arm", "start"})
_FACES = 4000


@dataclass
class Drawing:
    """What is to be drawn, the farthest first: (depth, points on the picture, colour, width)."""

    eye: FloatArray
    middle: FloatArray
    scale: float
    parts: list[tuple[float, FloatArray, style.Colour, float]] = field(default_factory=list)

    def add(self, points: FloatArray, colour: style.Colour, width: float) -> None:
        """Add a polygon where the width is 0, else a line that wide, or one point's disc, [px]."""
        forward = -self.eye / np.linalg.norm(self.eye)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        seen = points - self.middle
        picture = np.stack([seen @ right, -(seen @ np.cross(right, forward))], axis=1)
        place = FINER * (np.array(SIZE) / 2 + self.scale * picture)
        self.parts.append((float((seen @ forward).mean()), place, colour, FINER * width))

    def line(self, points: FloatArray, colour: style.Colour, width: float) -> None:
        """Add a polyline (n, 3) leg by leg, so that each is in front of what is behind it."""
        for leg in pairwise(points):
            self.add(np.array(leg), colour, width)

    def image(self) -> Image.Image:
        """The picture."""
        image = Image.new("RGB", (FINER * SIZE[0], FINER * SIZE[1]), GROUND)
        pencil = ImageDraw.Draw(image)
        for _, place, colour, width in sorted(self.parts, key=lambda part: -part[0]):
            corners = [(float(x), float(y)) for x, y in place]
            if width == 0:
                pencil.polygon(corners, fill=colour)
                continue
            if len(corners) > 1:
                pencil.line(corners, fill=colour, width=max(round(width), 1))
            for x, y in corners:
                r = width / 2
                pencil.ellipse((x - r, y - r, x + r, y + r), fill=colour)
        return image.resize(SIZE, Image.Resampling.LANCZOS)


def drawn(plan: Plan, shown: frozenset[str], step: int | None, algorithm: str) -> Image.Image:
    """Picture of a plan's layers, and of a search after some steps."""
    scene = plan.scene
    low, high = np.array(scene.workspace.min), np.array(scene.workspace.max)
    size = float((high - low).max())
    drawing = Drawing(_EYE, (low + high) / 2, 0.56 * SIZE[1] / size)
    for leg in box_edges(scene.workspace.min, scene.workspace.max):
        drawing.add(np.asarray(leg, float), style.WORKSPACE, 0.7)
    if "obstacles" in shown:
        _add_obstacles(drawing, plan)
    _add_lines(drawing, plan, shown)
    _add_mesh(drawing, plan, shown)
    if "arm" in shown:
        _add_arm(drawing, plan)
    if step is not None:
        _add_search(drawing, plan, step, algorithm)
    for end in (scene.start, scene.goal):
        drawing.add(np.array([end], float), (240, 240, 240), 5)
    return drawing.image()


def _add_obstacles(drawing: Drawing, plan: Plan) -> None:
    for obstacle in plan.scene.obstacles:
        faces = obstacle.triangles()
        faces = faces[:: -(-len(faces) // _FACES)]
        normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        light = 0.62 + 0.38 * normals @ (np.array([-0.35, -0.5, 0.8]))
        for face, normal, share in zip(faces, normals, light, strict=True):
            if normal @ drawing.eye > 0:
                red, green, blue = (round(min(share, 1.0) * c) for c in style.OBSTACLE)
                drawing.add(face, (red, green, blue), 0)


def _add_lines(drawing: Drawing, plan: Plan, shown: frozenset[str]) -> None:
    for result in plan.searches:
        if result.algorithm in shown:
            drawing.line(result.points, style.ALGORITHMS[result.algorithm][1], 2)
    if plan.taut is not None and "taut" in shown:
        drawing.line(plan.taut.points, style.TAUT, 2)
    for name, fit in plan.curves.items():
        if fit is not None and name in shown:
            points = fit.curve(parameters(fit.curve.interval, 60))
            drawing.line(points, style.CURVES[name][1], 2.6)
    if "edges" in shown:
        trees = tree_lines(plan)
        colours = (style.DIJKSTRA, style.BELLMAN_FORD, style.QUADRATIC)
        for lines, colour, width in zip(trees, colours, (1.0, 1.0, 2.6), strict=True):
            for piece in lines:
                drawing.line(piece, colour, width)
    if plan.bspline is not None and "control" in shown:
        for point in plan.bspline.curve.control_points:
            drawing.add(point[None], style.BSPLINE, 5)


def _add_mesh(drawing: Drawing, plan: Plan, shown: frozenset[str]) -> None:
    if plan.mesh is None or plan.free is None:
        return
    if "edges" in shown and plan.joint_search is None:
        for edge in plan.mesh.edges:
            drawing.add(plan.mesh.points[edge], (74, 90, 108), 0.4)
    if "nodes" in shown:
        for point in plan.mesh.points[~plan.free.excluded]:
            drawing.add(point[None], style.MESH, 2.4)
    if "excluded" in shown:
        for point in plan.mesh.points[plan.free.excluded]:
            drawing.add(point[None], style.EXCLUDED, 3)


def _add_arm(drawing: Drawing, plan: Plan) -> None:
    if plan.arm is None or plan.motion is None:
        return
    time = UNDERWAY * plan.motion.time[-1]
    pose = rows_at(time, plan.motion.time, plan.motion.positions)
    for ends, radius in zip(plan.arm.place(pose[None])[0], plan.arm.radii.tolist(), strict=True):
        line = ends[0] + np.linspace(0, 1, 9)[:, None] * (ends[1] - ends[0])
        drawing.line(line, ARM, 2 * radius * drawing.scale)


def _add_search(drawing: Drawing, plan: Plan, step: int, algorithm: str) -> None:
    trace = COMPARED[algorithm].find(search_problem(plan))
    state = replay(trace, min(step, trace.steps))
    points = trace.arcs.points
    for nodes, colour in ((state.closed, style.CLOSED), (state.open, style.WAITING[1])):
        for point in points[nodes % len(points)]:
            drawing.add(point[None], colour, 6)
    drawing.line(points[state.path()], style.MARK, 2.6)


def _of_lesson(name: str, lesson: Lesson) -> Image.Image:
    """The first page once it is answered, or as it begins where a search is stepped through."""
    scene, shown, step, algorithm = load_scene("paper"), _SCENE, None, "a_star"
    folder = assets.path("lessons")
    for setting in (lesson.steps[0].set, lesson.steps[0].reveal):
        if setting is None:
            continue
        scene = scene_of(setting, scene, folder)
        shown = shown if setting.shown is None else frozenset(setting.shown)
        cue = setting.search
        if cue is not None and cue.on:
            algorithm = cue.algorithm or algorithm
            step = cue.step if step is None else step
    return drawn(abi.plan(scene), shown, step, algorithm)


def main() -> None:
    """Draw the pictures that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    lessons = load_lessons()
    known = {*scene_names(), *lessons}
    wanted = set(parser.parse_args().names) or known
    if unknown := wanted - known:
        parser.error(f"no scene or lesson {min(unknown)!r}")
    for name in sorted(wanted):
        if name in lessons:
            kind, image = "lessons", _of_lesson(name, lessons[name][0])
        else:
            kind, image = "scenes", drawn(abi.plan(load_scene(name)), _SCENE, None, "a_star")
        image.save(assets.path("pictures", kind) / f"{name}.webp", quality=80, method=6)
        print(name, flush=True)


if __name__ == "__main__":
    main()
