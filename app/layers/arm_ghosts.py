"""Ghosts of the arm: the other elbow, the poses at start and goal, and the tool's own curve."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser
from numpy.typing import NDArray

from abi.arm.arm import Arm, place
from abi.arm.inverse_kinematics import solve
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.scene.settings import Elbow
from app import style
from app.frame import Frame, Switch
from app.layers.lines import NO_SEGMENTS, add_line, dashes, parameters
from app.layout import Layout

_SIDES, _RINGS = 14, 4
_SAMPLES = 120
_GHOSTS = {"other_elbow": ("now",), "end_poses": ("start", "goal")}
"""Names of the ghosts of each switch."""


class ArmGhostsLayer:
    """The arm's capsules, see-through."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("other_elbow", "other elbow (ghost)", style.FADED, on=False),
        Switch("end_poses", "poses at start and goal (ghosts)", style.POINT, on=False),
        Switch("tool_only", "curve of the tool alone", style.FADED),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._meshes: dict[str, viser.MeshHandle] = {}
        self._drawn: dict[str, tuple[object, ...]] = {}
        self._line = add_line(self._scene, "/tool_only", style.FADED, 4.0)
        self._curve: object = None

    def draw(self, frame: Frame) -> None:
        """Draw what is switched on."""
        plan = frame.plan
        for switch, names in _GHOSTS.items():
            shown = switch in frame.shown and isinstance(plan.arm, Arm)
            for name in names:
                if shown and isinstance(plan.arm, Arm):
                    self._pose(name, plan, plan.arm, *_place_of(name, frame))
                if name in self._meshes:
                    self._meshes[name].visible = shown
        if plan.tool_only is not self._curve:
            self._curve = plan.tool_only
            self._line.points = NO_SEGMENTS
            if plan.tool_only is not None:
                curve = plan.tool_only.curve
                points = curve(parameters(curve.interval, _SAMPLES))
                self._line.points = dashes(points, 0.03 * max(plan.scene.workspace.size))
        self._line.visible = "tool_only" in frame.shown

    def _pose(self, name: str, plan: Plan, arm: Arm, tool: FloatArray, elbow: Elbow) -> None:
        state = (arm, elbow, *np.round(tool, 9).tolist(), plan.scene.arm.q5)
        if self._drawn.get(name) == state:
            return
        self._drawn[name] = state
        q5 = np.array([plan.scene.arm.q5])
        found = solve(arm, tool[None], q5, elbow, np.zeros((1, 3)))
        joints = np.array([[found.q1[0], found.q2[0], found.q3[0], 0.0, q5[0], 0.0]])
        vertices, faces = _capsule_meshes(
            place(arm, joints)[0], np.array([capsule.radius for capsule in arm.capsules])
        )
        colour = style.FADED if name == "now" else style.POINT
        self._meshes[name] = self._scene.add_mesh_simple(
            f"/arm_ghost/{name}", vertices, faces, color=colour, opacity=0.22, cast_shadow=False
        )


def _place_of(name: str, frame: Frame) -> tuple[FloatArray, Elbow]:
    """Place of a ghost's tool, (3,), [unit], world, and its branch."""
    plan, elbow = frame.plan, elbow_of(frame.plan)
    if name == "now":
        return _tool_at(plan, frame.time), _other(elbow)
    return np.array(plan.scene.start if name == "start" else plan.scene.goal), elbow


def elbow_of(plan: Plan) -> Elbow:
    """Branch of the plan's arm."""
    return plan.scene.arm.branches[0] if plan.motion is None else plan.motion.elbow


def _other(elbow: Elbow) -> Elbow:
    return "down" if elbow == "up" else "up"


def _tool_at(plan: Plan, time: float) -> FloatArray:
    """Place of the tool at a time, (3,), [unit], world."""
    motion = plan.motion
    if motion is None:
        return np.array(plan.scene.start)
    return np.array([np.interp(time, motion.time, column) for column in motion.tool.T])


def _capsule_meshes(
    ends: FloatArray, radii: FloatArray
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Vertices and faces of all capsules as one mesh.

    Args:
        ends: of the segments, (c, 2, 3), [unit], world.
        radii: (c,), [unit].
    """
    rise = np.linspace(-np.pi / 2, np.pi / 2, 2 * _RINGS)
    turn = 2 * np.pi * np.arange(_SIDES) / _SIDES
    height, width = np.sin(rise), np.cos(rise)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    top = (np.arange(2 * _RINGS) >= _RINGS).astype(int)
    vertices, faces = [], []
    grid = np.arange(2 * _RINGS * _SIDES).reshape(2 * _RINGS, _SIDES)
    a, b = grid[:-1], grid[1:]
    c, d = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    quads = np.stack([a, c, d, a, d, b], axis=-1).reshape(-1, 3)
    for k, (segment, radius) in enumerate(zip(ends, radii, strict=True)):
        way = segment[1] - segment[0]
        length = float(np.linalg.norm(way))
        axis = way / length if length > 0 else np.array([0.0, 0.0, 1.0])
        side = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
        side /= np.linalg.norm(side)
        across = ring @ np.stack([side, np.cross(axis, side)])
        points = segment[top][:, None] + radius * (
            height[:, None, None] * axis + width[:, None, None] * across
        )
        vertices.append(points.reshape(-1, 3))
        faces.append(quads + k * 2 * _RINGS * _SIDES)
    return (
        np.concatenate(vertices).astype(np.float32),
        np.concatenate(faces).astype(np.uint32),
    )
