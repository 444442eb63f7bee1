"""Choice of the arm: the paper's, one that comes along, or a URDF of the user's."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

import viser

from abi.errors import SceneError
from abi.obstacles.pose import UNTURNED, Quaternion
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.robot import usual_tip
from abi.robot.robot_files import SHIPPED, load_robot
from abi.scene.scene import Scene
from app import page
from app.guard.reader import READER
from app.panels.files import shown_name
from app.panels.widgets import Wake

_PAPER = "the paper's arm"
_SHIPPED = {"ur5e": "UR5e", "panda": "Franka Panda", "xarm7": "xArm7"}
_AXES: dict[str, tuple[float, float, float] | None] = {
    "any": None,
    "down": (0.0, 0.0, -1.0),
    "up": (0.0, 0.0, 1.0),
    "along x": (1.0, 0.0, 0.0),
    "along −x": (-1.0, 0.0, 0.0),
    "along y": (0.0, 1.0, 0.0),
    "along −y": (0.0, -1.0, 0.0),
}
_HALF = 0.5**0.5
_MOUNTS: dict[str, Quaternion] = {
    "on the floor": UNTURNED,
    "on the ceiling": (0.0, 1.0, 0.0, 0.0),
    "on a wall, along x": (_HALF, 0.0, _HALF, 0.0),
    "on a wall, along −x": (_HALF, 0.0, -_HALF, 0.0),
    "on a wall, along y": (_HALF, -_HALF, 0.0, 0.0),
    "on a wall, along −y": (_HALF, _HALF, 0.0, 0.0),
}
_OTHER = "as in the scene"


class ArmModelPanel:
    """Widgets to choose arm, tip, direction of the tool and mounting, and to upload a URDF.

    Attributes:
        files: archives of the arms that were uploaded, by name.
    """

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        self._client = client
        gui = client.gui
        self.files: dict[str, bytes] = {}
        self.model = gui.add_dropdown(
            "arm", (_PAPER, *_SHIPPED.values()), hint="The paper's arm, or one by its URDF."
        )
        self.upload = gui.add_upload_button(
            "Add an arm…", mime_type=".zip,.urdf", hint="A URDF, or a zip of it and its meshes."
        )
        self.tip = gui.add_dropdown(
            "tip", ("–",), hint="The link whose origin is the tool.", visible=False
        )
        self.axis = gui.add_dropdown(
            "tool points",
            tuple(_AXES),
            hint="Direction that the tip's z axis is held to.",
            visible=False,
        )
        self.mount = gui.add_dropdown(
            "stands",
            tuple(_MOUNTS),
            hint="How the base is turned: up is its z axis.",
            visible=False,
        )
        self._uploaded: object = self.upload.value
        self._scene_axis: tuple[float, float, float] | None = None
        self._scene_mount: Quaternion = UNTURNED
        self._tips_of: str | None = None
        self._unnamed_tip: str | None = None
        for handle in (self.model, self.tip, self.axis, self.mount):
            handle.on_update(wake)
        self.upload.on_upload(wake)

    @property
    def is_paper(self) -> bool:
        """Whether the paper's arm is chosen."""
        return self.model.value == _PAPER

    def read(self) -> dict[str, Any]:
        """Read the fields of the section ``arm`` as typed."""
        self._take_upload()
        name = self._name()
        if name is None:
            self.tip.visible = self.axis.visible = self.mount.visible = False
            return {"model": "abi"}
        if name != self._tips_of:
            self._list_tips(name, None)
        self.tip.visible = self.axis.visible = self.mount.visible = True
        axis = _AXES.get(self.axis.value, self._scene_axis)
        mount = _MOUNTS.get(self.mount.value, self._scene_mount)
        # what a scene leaves to be found stays so, or it would be another scene
        tip = None if self.tip.value == self._unnamed_tip else self.tip.value
        return {"model": "urdf", "urdf": name, "tip": tip, "axis": axis, "base_wxyz": mount}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        arm = scene.arm
        is_urdf = arm.model == "urdf"
        self.tip.visible = self.axis.visible = self.mount.visible = is_urdf
        if not is_urdf:
            self.model.value = _PAPER
            return
        if arm.urdf not in SHIPPED:
            self._add(arm.urdf, arm.robot.archive)
        self.model.value = _SHIPPED.get(arm.urdf, arm.urdf)
        self._list_tips(arm.urdf, arm.tip)
        self._scene_axis, self._scene_mount = arm.axis, arm.base_wxyz
        _choose(self.axis, _AXES, arm.axis)
        _choose(self.mount, _MOUNTS, arm.base_wxyz)

    def _name(self) -> str | None:
        """Name in the scene of the arm that is chosen; None for the paper's."""
        by_label = {label: name for name, label in _SHIPPED.items()}
        chosen = by_label.get(self.model.value, self.model.value)
        # a page may send anything: only listed arms are taken
        return chosen if chosen in SHIPPED or chosen in self.files else None

    def _take_upload(self) -> None:
        if self.upload.value is self._uploaded:
            return
        self._uploaded = self.upload.value
        name = shown_name(self.upload.value.name)
        try:
            robot = READER.arm(self.upload.value.content, name)
        except SceneError as error:
            page.notify_refusal(self._client, f"{name} is not added", error.message)
            return
        name = f"{PurePosixPath(name).stem}.zip"
        self._add(name, robot.archive)
        self.model.value = name
        self._list_tips(name, None)
        for note in robot.notes:
            self._client.add_notification(name, note, auto_close_seconds=8)

    def _add(self, name: str, archive: bytes) -> None:
        self.files[name] = archive
        self.model.options = (_PAPER, *_SHIPPED.values(), *self.files)

    def _list_tips(self, name: str, tip: str | None) -> None:
        """List the links of an arm that may be its tip, and choose one."""
        robot = load_robot(name, MeshSource(self.files))
        moved = [joint.child for joint in robot.joints]
        self.tip.options = tuple(moved)
        usual = SHIPPED.get(name) or usual_tip(robot)
        self.tip.value = tip or usual
        self._unnamed_tip = None if tip else usual
        self._tips_of = name


def _choose(box: viser.GuiDropdownHandle[str], values: Mapping[str, object], value: object) -> None:
    """Choose a value of a list, or that of the scene where the list has it not."""
    known = next((label for label, other in values.items() if other == value), None)
    if known is None and _OTHER not in box.options:
        box.options = (*values, _OTHER)
    box.value = known or _OTHER
