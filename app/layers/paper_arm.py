"""Scene nodes of the paper's arm, drawn from its URDF."""

from __future__ import annotations

import viser

from abi.arm.any_arm import AnyArm
from abi.arm.arm import JOINTS, Arm
from abi.arm.trajectory import rest_pose
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.layers.arm_nodes import JointNode
from app.layers.arm_solids import ArmSolids, Solid, solids_of


class PaperArmNodes:
    """One node a joint, fixed ones too, nested as in the URDF."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.root = scene.add_frame("/arm", show_axes=False)
        self.joint_nodes: list[JointNode] = []
        self._lengths: tuple[float, ...] = ()
        self._built: ArmSolids | None = None
        self._meshes: dict[str, viser.GlbHandle] = {}
        self._red: dict[str, viser.GlbHandle] = {}
        self._solids: dict[str, Solid] = {}
        self._names: dict[str, str] = {}
        self._touching: frozenset[str] = frozenset()

    def place(self, arm: AnyArm) -> None:
        """Put the arm on its base; build it anew when its links changed."""
        assert isinstance(arm, Arm)
        self.root.position = arm.base
        lengths = arm.a1, arm.a2, arm.a3, arm.a4, arm.a5, arm.metres
        if lengths == self._lengths:
            return
        if (solids := solids_of(arm)) is not self._built:
            self._build(solids)
            self._built = solids
        self._lengths = lengths

    def rest_pose(self, plan: Plan) -> FloatArray:
        """Pose with the tool on the start."""
        assert isinstance(plan.arm, Arm)
        return rest_pose(plan.arm, plan.scene.arm, plan.scene.start)

    def values(self, positions: FloatArray) -> FloatArray:
        """The same."""
        return positions

    def redden(self, links: frozenset[str]) -> None:
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

    def _build(self, arm: ArmSolids) -> None:
        """Add the nodes of an arm."""
        for node in self.joint_nodes[:1]:
            node.frame.remove()
        self.joint_nodes = []
        self._touching = frozenset()
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
            self.joint_nodes.append(
                JointNode(
                    frame,
                    column=JOINTS.index(joint.name) if joint.name in JOINTS else None,
                    prismatic=joint.prismatic,
                    axis=joint.axis,
                    origin=joint.origin,
                )
            )

    def _add_mesh(self, link: str) -> None:
        if link in self._solids:
            name = f"{self._names[link]}/mesh"
            self._meshes[link] = self._scene.add_glb(name, self._solids[link].glb)
