"""The paper's arm, drawn from its URDF, and the trace that the tool of any arm leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import viser
import viser.transforms

from abi.arm.arm import JOINTS, Arm
from abi.arm.trajectory import ArmMotion, rest_pose
from abi.arm.urdf_arm import UrdfArm
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layers.arm_playback import ArmPlayback, JointPose, samples_of
from app.layers.arm_solids import ArmSolids, Solid, solids_of
from app.layers.lines import NO_SEGMENTS, Segments, add_line, segments
from app.layout import Layout

_TRACE_SAMPLES = 100


@dataclass
class _JointNode:
    """Scene node of a joint: its place in the parent link, and its axis.

    Attributes:
        frame: the node.
        column: of the joint's position among all; None where it is fixed.
        prismatic: whether it slides along the axis instead of turning about it.
        axis: (3,), in the joint's frame.
        origin: the joint's frame in the parent link's.
    """

    frame: viser.FrameHandle
    column: int | None
    prismatic: bool
    axis: FloatArray
    origin: viser.transforms.SE3

    @property
    def pose(self) -> JointPose | None:
        """Motion of the node with its joint; None where it is fixed."""
        if self.column is None:
            return None
        rotation = self.origin.rotation()
        return JointPose(
            name=self.frame.name,
            column=self.column,
            wxyz=np.asarray(rotation.wxyz, float),
            position=np.asarray(self.origin.translation(), float),
            axis=np.asarray(rotation @ self.axis if self.prismatic else self.axis, float),
            prismatic=self.prismatic,
        )

    def move(self, positions: FloatArray) -> None:
        """Pose the node at joint positions (6,), [rad] and [unit]."""
        if self.column is None:
            return
        value = float(positions[self.column])
        if self.prismatic:
            self.frame.position = self.origin @ (self.axis * value)
        else:
            rotation = viser.transforms.SO3.exp(self.axis * value)
            self.frame.wxyz = (self.origin.rotation() @ rotation).wxyz


class ArmLayer:
    """One node a joint, nested as in the URDF: a frame sends six poses and no geometry."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("trace", "tool trace", style.TRACE),
        Switch("arm", "arm", style.POINT),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._playback = ArmPlayback(layout.client)
        self._base = self._scene.add_frame("/arm", show_axes=False)
        self._joint_nodes: list[_JointNode] = []
        self._joint_poses: list[JointPose] = []
        self._arm: Arm | None = None
        self._lengths: tuple[float, ...] = ()
        self._built: ArmSolids | None = None
        self._posed: object = None
        self._meshes: dict[str, viser.GlbHandle] = {}
        self._red: dict[str, viser.GlbHandle] = {}
        self._solids: dict[str, Solid] = {}
        self._names: dict[str, str] = {}
        self._touching: frozenset[str] = frozenset()
        self._trace = add_line(self._scene, "/trace", style.TRACE, 4.0)
        self._traced: tuple[object, int] = (None, -1)

    def draw(self, frame: Frame) -> None:
        """Draw the arm at the frame's time, and the trace up to then."""
        arm = frame.plan.arm
        if isinstance(arm, Arm) and arm is not self._arm:
            self._place(arm)
        if frame.playing and frame.plan.motion is not None and not isinstance(arm, UrdfArm):
            self._play(frame, frame.plan.motion)
        else:
            if self._playback.stop(frame.time):
                self._posed, self._traced = None, (None, -1)
            self._pose(frame.plan, frame.time)
        clearance = frame.plan.arm_clearance
        self._redden(frozenset() if clearance is None else clearance.touching(frame.time))
        self._base.visible = "arm" in frame.shown and not isinstance(arm, UrdfArm)
        self._trace.visible = "trace" in frame.shown

    def _place(self, arm: Arm) -> None:
        """Put the arm on its base; build it anew when its links changed."""
        self._arm = arm
        self._base.position = arm.base
        lengths = arm.a1, arm.a2, arm.a3, arm.a4, arm.a5, arm.metres
        if lengths == self._lengths:
            return
        if (solids := solids_of(arm)) is not self._built:
            self._build(solids)
            self._built = solids
        self._lengths = lengths

    def _play(self, frame: Frame, motion: ArmMotion) -> None:
        """Have the page move the arm, and lengthen a trace of the whole motion."""
        if self._playback.play(motion, self._joint_poses, self._trace.name, frame.time, frame.rate):
            self._trace.points = self._trace_of(frame.plan, motion.tool[samples_of(motion)])

    def _pose(self, plan: Plan, time: float) -> None:
        """Move the arm to its pose at ``time`` [s], and draw the trace up to then."""
        motion = plan.motion
        moment = (motion if motion is not None else plan, time)
        if moment == self._posed:
            return
        self._posed = moment
        if motion is None:
            self._trace.points = NO_SEGMENTS
            if isinstance(plan.arm, Arm):
                self._move(rest_pose(plan.arm, plan.scene.arm, plan.scene.start))
            return
        if isinstance(plan.arm, Arm):
            self._move(np.array([np.interp(time, motion.time, q) for q in motion.positions.T]))
        count = int(np.searchsorted(motion.time, time, side="right"))
        if self._traced != (motion, count):
            self._traced = (motion, count)
            samples = np.linspace(0, count - 1, min(count, _TRACE_SAMPLES)).astype(int)
            self._trace.points = self._trace_of(plan, motion.tool[samples])

    def _trace_of(self, plan: Plan, points: FloatArray) -> Segments:
        """Trace through points (n, 3) of the tool, just above them, so that the curve is seen."""
        height = 0.008 * max(plan.scene.workspace.size)
        return segments(points + np.array([0.0, 0.0, height]))

    def _redden(self, links: frozenset[str]) -> None:
        """Draw links in red, and the others in their own colours."""
        if links == self._touching:
            return
        self._touching = links
        for link, mesh in self._meshes.items():
            touching = link in links
            if touching and link not in self._red:
                red = self._solids[link].red
                self._red[link] = self._scene.add_glb(f"{self._names[link]}/red", red)
            if link in self._red:
                self._red[link].visible = touching
            mesh.visible = not touching

    def _move(self, positions: FloatArray) -> None:
        for node in self._joint_nodes:
            node.move(positions)

    def _build(self, arm: ArmSolids) -> None:
        """Add the nodes of an arm."""
        for node in self._joint_nodes[:1]:
            node.frame.remove()
        self._joint_nodes = []
        self._posed, self._touching = None, frozenset()
        self._meshes, self._red = {}, {}
        self._solids = arm.solids
        self._names = names = {arm.base: "/arm/links"}
        self._add_mesh(arm.base)
        for joint in arm.joints:
            names[joint.child] = name = f"{names[joint.parent]}/{joint.child}"
            frame = self._scene.add_frame(
                name,
                show_axes=False,
                wxyz=joint.origin.rotation().wxyz,
                position=joint.origin.translation(),
            )
            self._add_mesh(joint.child)
            self._joint_nodes.append(
                _JointNode(
                    frame,
                    column=JOINTS.index(joint.name) if joint.name in JOINTS else None,
                    prismatic=joint.prismatic,
                    axis=joint.axis,
                    origin=joint.origin,
                )
            )
        self._joint_poses = [pose for node in self._joint_nodes if (pose := node.pose) is not None]

    def _add_mesh(self, link: str) -> None:
        if link in self._solids:
            name = f"{self._names[link]}/mesh"
            self._meshes[link] = self._scene.add_glb(name, self._solids[link].glb)
