"""Pictures for the gallery: each plan that an example makes, drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from sphinx_gallery.scrapers import figure_rst

from abi import Plan
from abi.obstacles.pose import rotation
from app.ui import style

_drawn: list[Plan] = []
"""Plans that have a picture; kept, so that no other gets the id of one."""


def arguments(gallery_conf: dict[str, Any], script_vars: dict[str, Any]) -> list[str]:
    """Command line of an example: the one that serves a page has to end."""
    return ["--once"] if "own" in Path(script_vars["src_file"]).name else []


def scrape(block: object, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Draw each new plan among the example's variables."""
    files = []
    for value in list(block_vars["example_globals"].values()):
        if isinstance(value, Plan) and not any(value is plan for plan in _drawn):
            _drawn.append(value)
            file = next(block_vars["image_path_iterator"])
            _draw(value).savefig(file, dpi=110)
            files.append(file)
    text: str = figure_rst(files, gallery_conf["src_dir"])
    return text


def _draw(plan: Plan) -> Figure:
    figure = Figure(figsize=(6.4, 4.8))
    axes: Any = figure.add_axes((0, 0, 1, 1), projection="3d")
    low, high = np.array(plan.scene.workspace.min), np.array(plan.scene.workspace.max)
    bounds = [obstacle.bounds() for obstacle in plan.scene.obstacles]
    for obstacle in plan.scene.obstacles:
        axes.add_collection3d(_solid(obstacle))
    for points, colour, width in _lines(plan):
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        axes.add_collection3d(Line3DCollection(pieces, colors=_rgb(colour), linewidths=width))
    for point in (plan.scene.start, plan.scene.goal):
        axes.scatter(*point, color=_rgb(style.POINT), s=30)
    _frame(axes, low, high)
    low = np.min([low, *(lowest for lowest, _ in bounds)], axis=0)
    high = np.max([high, *(highest for _, highest in bounds)], axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.25)
    return figure


def _frame(axes: Any, low: Any, high: Any) -> None:
    """The workspace as a box of lines."""
    axes.set_axis_off()
    axes.view_init(elev=24, azim=-38)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    edges = [(a, b) for k, a in enumerate(corners) for b in corners[:k] if np.sum(a != b) == 1]
    axes.add_collection3d(Line3DCollection(edges, colors="0.7", linewidths=0.8))


def _lines(plan: Plan) -> list[tuple[Any, style.Colour, float]]:
    """Points (k, 3) of each line, its colour and width."""
    found: list[tuple[Any, style.Colour, float]] = []
    if plan.path is not None:
        found.append((plan.path.points, style.A_STAR, 1.6))
    if plan.quadratic is not None:
        quadratic = plan.quadratic.curve
        points = quadratic(np.linspace(*quadratic.interval, 200))
        found.append((points, style.QUADRATIC, 2.0))
    if plan.bspline is not None:
        found.append((plan.bspline.curve(np.linspace(0, 1, 400)), style.BSPLINE, 2.6))
    return found


def _solid(obstacle: Any) -> Poly3DCollection:
    """The obstacle's triangles, lit from above."""
    triangles = _triangles(obstacle) @ rotation(obstacle.wxyz).T + np.array(obstacle.position)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    light = 0.62 + 0.38 * (normals @ np.array([0.3, -0.5, 0.81])).clip(-0.6, 1)
    colours = np.clip(light[:, None] * np.array(_rgb(style.OBSTACLE)), 0, 1)
    return Poly3DCollection(triangles, facecolors=np.c_[colours, np.full(len(light), 0.55)])


def _triangles(obstacle: Any) -> Any:
    """Corners (n, 3, 3) in the obstacle's own axes, [unit]."""
    make = trimesh.creation
    if obstacle.shape == "mesh":
        surface = obstacle.surface
        return surface.vertices[surface.faces] * obstacle.factor
    solids = {
        "box": lambda: make.box(extents=obstacle.size),
        "sphere": lambda: make.icosphere(3, obstacle.radius),
        "cylinder": lambda: make.cylinder(obstacle.radius, obstacle.height),
        "capsule": lambda: make.capsule(obstacle.height, obstacle.radius).apply_translation(
            [0, 0, -obstacle.height / 2]
        ),
    }
    return solids[obstacle.shape]().triangles


def _rgb(colour: style.Colour) -> tuple[float, float, float]:
    red, green, blue = colour
    return red / 255, green / 255, blue / 255
