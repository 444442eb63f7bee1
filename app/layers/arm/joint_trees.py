"""Trees of a search in the space of the joints: the tool tip's path along each of their edges."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.joint_search.joint_tree import JointTree
from abi.arm_planning.joint_search.search_joints import JointSearch
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from app.drawing.lines import NO_SEGMENTS, Segments, add_line, segments
from app.shared.computed_once import once_a_plan
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.layout import Layout

_MOST = 2_000
"""Edges of a tree that are drawn, at most: the first ones."""
_PARTS = 6
"""Straight pieces that the path along an edge is drawn with."""


_NAMES = {"tried": "arm poses tried", "path": "way found by joints"}
_NARROW = 480
"""Width of a picture, [px], in which there is room for but one of them."""


def joint_trees_layer(layout: Layout) -> Draw:
    """Both trees, and the path that was found, with their names; shown with the mesh's edges."""
    scene, camera = layout.client.scene, layout.client.camera
    lines = [
        add_line(scene, f"/joint_tree/{name}", style.JOINT_SPACE, width)
        for name, width in (("start", 1.5), ("goal", 1.5), ("path", 4.0))
    ]
    labels = {
        name: scene.add_label(f"/joint_tree/{name}_name", text, visible=False)
        for name, text in _NAMES.items()
    }
    drawn: JointSearch | None = None

    def draw(frame: Frame) -> None:
        nonlocal drawn
        plan = frame.plan
        if plan.joint_search is not drawn:
            drawn = plan.joint_search
            start, goal, path = found = tree_lines(plan)
            for line, points in zip(lines, found, strict=True):
                line.points = points
            # at the pose tried last in the larger tree, and in the middle of the path
            labels["tried"].position = max(start, goal, key=len)[-1, 1]
            labels["path"].position = path[len(path) // 2, 0]
        visible = drawn is not None and frame.theatre is None and "edges" in frame.shown
        for line in lines:
            line.visible = visible
        named = visible and drawn is not None and drawn.path is not None and "names" in frame.shown
        for name, label in labels.items():
            room = name == "tried" or not 0 < camera.image_width < _NARROW
            label.visible = named and room
            label.font_screen_scale = frame.label_scale

    return draw


@once_a_plan
def tree_lines(plan: Plan) -> tuple[Segments, Segments, Segments]:
    """Paths of the tool tip along the edges of a plan's trees, and along the path found.

    In this order: the tree of the start, the tree of the goal, the path.
    """
    search, arm = plan.joint_search, plan.arm
    if search is None or search.path is None or arm is None:
        return NO_SEGMENTS, NO_SEGMENTS, NO_SEGMENTS
    rows = np.arange(len(search.path), dtype=np.int32)
    path = JointTree(search.path, rows - 1)
    start, goal, found = (_along_edges(tree, arm) for tree in (*search.trees, path))
    return start, goal, found


def _along_edges(tree: JointTree, arm: AnyArm) -> Segments:
    """Paths of the tool tip along the edges of a tree."""
    ends = tree.positions[tree.edges[:_MOST]]
    if not len(ends):
        return NO_SEGMENTS
    share = np.linspace(0.0, 1.0, _PARTS + 1)[:, None]
    positions = ends[:, :1] + share * (ends[:, 1:] - ends[:, :1])
    points = arm.tool(positions.reshape(-1, positions.shape[2])).reshape(len(ends), -1, 3)
    return np.concatenate([segments(path) for path in points])
