"""Choice of the arm: the paper's, a shipped one, or a URDF of the user's."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Any

import viser

from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.robot import Robot, usual_tip
from abi.robot.robot_files import SHIPPED, load_robot
from abi.scene.scene import Scene
from app import page
from app.guard.reader import READER
from app.panels.file_uploads import Dealing, FileKind, FileUploads, shown_name
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
_OTHER = "as in the scene"


class ArmModelPanel:
    """Widgets to choose arm, tip and direction of the tool, and to upload a URDF.

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
        self.uploads = FileUploads(gui, self.upload, FileKind(_read, shown_name), wake)
        self.tip = gui.add_dropdown(
            "tip", ("–",), hint="The link whose origin is the tool.", visible=False
        )
        self.axis = gui.add_dropdown(
            "tool points",
            tuple(_AXES),
            hint="Direction that the tip's z axis is held to.",
            visible=False,
        )
        self._scene_axis: tuple[float, float, float] | None = None
        self._tips_of: str | None = None
        self._unnamed_tip: str | None = None
        for handle in (self.model, self.tip, self.axis):
            handle.on_update(wake)

    @property
    def is_paper(self) -> bool:
        """Whether the paper's arm is chosen."""
        return self.model.value == _PAPER

    def read(self) -> dict[str, Any]:
        """Read the fields of the section ``arm`` as typed."""
        for one in self.uploads.news():
            if isinstance(one.result, Robot):
                self._take(one.name, one.result)
            elif one.result is not None:
                title = f"{one.name} is not added"
                page.notify_refusal(self._client, title, one.result.message)
        name = self._name()
        if name is None:
            self.tip.visible = self.axis.visible = False
            return {"model": "abi"}
        if name != self._tips_of:
            self._list_tips(name, None)
        self.tip.visible = self.axis.visible = True
        axis = _AXES.get(self.axis.value, self._scene_axis)
        # what a scene leaves to be found stays so, or it would be another scene
        tip = None if self.tip.value == self._unnamed_tip else self.tip.value
        return {"model": "urdf", "urdf": name, "tip": tip, "axis": axis}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        arm = scene.arm
        is_urdf = arm.model == "urdf"
        self.tip.visible = self.axis.visible = is_urdf
        if not is_urdf:
            self.model.value = _PAPER
            return
        if arm.urdf not in SHIPPED:
            is_new = self.files.get(arm.urdf) != arm.robot.archive
            self._add(arm.urdf, arm.robot.archive)
            if is_new:
                self._tell(arm.urdf, arm.robot)
        self.model.value = _SHIPPED.get(arm.urdf, arm.urdf)
        self._list_tips(arm.urdf, arm.tip)
        self._scene_axis = arm.axis
        known = next((label for label, axis in _AXES.items() if axis == arm.axis), None)
        if known is None and _OTHER not in self.axis.options:
            self.axis.options = (*_AXES, _OTHER)
        self.axis.value = known or _OTHER

    def _name(self) -> str | None:
        """Name in the scene of the arm that is chosen; None for the paper's."""
        by_label = {label: name for name, label in _SHIPPED.items()}
        chosen = by_label.get(self.model.value, self.model.value)
        # a page may send anything: only listed arms are taken
        return chosen if chosen in SHIPPED or chosen in self.files else None

    def _take(self, name: str, robot: Robot) -> None:
        """Choose an arm that was read."""
        name = f"{PurePosixPath(name).stem}.zip"
        self._add(name, robot.archive)
        self.model.value = name
        self._list_tips(name, None)
        self._tell(name, robot)

    def _tell(self, name: str, robot: Robot) -> None:
        """Notify the user of what was left out of an arm, as visuals that cannot be read."""
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


def _read(content: bytes, dealing: Dealing[Robot]) -> Robot:
    """Read the file of an arm."""
    dealing.step("reading", 0.5)
    return READER.arm(content, dealing.name, dealing.stopped)
