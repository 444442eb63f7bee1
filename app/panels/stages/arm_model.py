"""Choice of the arm: the paper's, a shipped one, or a URDF of the user's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any

import viser

from abi.obstacles.pose import METRES, UNTURNED, Quaternion, Vec3
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.held_joints import NOT_HELD, planned_sentence
from abi.robot.urdf.robot import Robot, bases_to, part_from
from abi.robot.urdf.robot_files import SHIPPED, load_robot
from abi.robot.urdf.usual_tip import usual_tip
from abi.scene.held_axis import HeldAxis, plain_axis
from abi.scene.scene import Scene
from abi.scene.without_obstacles import contacts_without
from app.panels.files.file_uploads import FileUploads
from app.panels.files.upload_job import UploadJob
from app.panels.stages.gripper import GripperPanel
from app.panels.stages.tool_direction import DIRECTIONS, add_direction, shown_axis, typed_axis
from app.panels.widgets import Wake
from app.reading.reader import READER
from app.ui import notices

_PAPER = "the paper's arm"
_SHIPPED = {"ur5e": "UR5e", "panda": "Franka Panda", "xarm7": "xArm7"}
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
_OF_ONE_ARM: Mapping[str, Any] = {"srdf": None, "allowed": ()}
"""Fields that hold for one arm with one tip only, as they are for another."""


class ArmModelPanel:
    """Widgets to choose arm, tip, base link, tool's direction and mounting, and to upload a URDF.

    Attributes:
        files: the arms that were uploaded, by name.
    """

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        self._client = client
        gui = client.gui
        self.files: dict[str, Robot] = {}
        self.model = gui.add_dropdown(
            "arm", (_PAPER, *_SHIPPED.values()), hint="The paper's arm, or a robot by its URDF."
        )
        self.upload = gui.add_upload_button(
            "Add an arm…", mime_type=".zip,.urdf", hint="A URDF file, or a zip with its meshes."
        )
        self.uploads = FileUploads(
            gui,
            self.upload,
            _read,
            wake,
            choice="robot in the file",
            choice_hint="The URDF file to take.",
        )
        self.tip = gui.add_dropdown(
            "tip", ("–",), hint="The link whose origin follows the curve.", visible=False
        )
        self.base_link = gui.add_dropdown(
            "base link",
            ("–",),
            hint="The link that stands at the base; what does not hang from it is left out.",
            visible=False,
        )
        self.direction, self.within, self.part = add_direction(gui)
        self.mount = gui.add_dropdown(
            "stands",
            tuple(_MOUNTS),
            hint="How the base is turned: up is its z axis.",
            visible=False,
        )
        self.gripper = GripperPanel(gui, wake)
        self._model_shown = self.model.value
        self._kept = _OF_ONE_ARM
        self._kept_of: tuple[str, str, str] | None = None
        self._scene_mount: Quaternion = UNTURNED
        self._axis: Vec3 | HeldAxis | None = None
        self._tips_of: str | None = None
        self._unnamed_tip: tuple[str, str] | None = None
        self._unnamed_base: str | None = None
        self._bases_of: tuple[str, str] | None = None
        self._unit = "m"
        self._of_urdf = self.tip, self.base_link, self.mount
        for handle in (self.model, *self._of_urdf, self.direction, self.within, self.part):
            handle.on_update(wake)

    @property
    def is_paper(self) -> bool:
        """Whether the paper's arm is chosen."""
        return self.model.value == _PAPER

    def read(self) -> dict[str, Any]:
        """Read the fields of the section ``arm`` as typed."""
        if self.model.value != self._model_shown:
            self.uploads.drop()
        for one in self.uploads.ended():
            if isinstance(one.result, Robot):
                self._take(one.chosen or one.name, one.result)
            elif one.result is not None:
                title = f"{one.name} is not added"
                notices.notify_refusal(self._client, title, one.result.message, stays=True)
        self._model_shown = self.model.value
        name = self._name()
        if name is None:
            self._show(False)
            return {"model": "abi", "base_wxyz": UNTURNED, "axis": None, **_OF_ONE_ARM}
        if name != self._tips_of:
            self._list_tips(name, None)
        if (name, self.tip.value) != self._bases_of:
            self._list_bases(name, None)
        self._show(True)
        mount = _MOUNTS.get(self.mount.value, self._scene_mount)
        # what a scene leaves to be found stays so, or it would be another scene
        tip, base = self.tip.value, self.base_link.value
        if (name, tip, base) != self._kept_of:
            # joints of another arm, or those that another tip moves, cannot be held there
            self._show_gripper(name, {})
            self._kept = _OF_ONE_ARM
        return {
            "model": "urdf",
            "urdf": name,
            "tip": None if (tip, base) == self._unnamed_tip else tip,
            "base_link": None if base == self._unnamed_base else base,
            "axis": self._read_axis(),
            "base_wxyz": mount,
            **self._kept,
            "gripper": self.gripper.read(),
        }

    def _read_axis(self) -> Any:
        """The field ``arm.axis`` as typed: the scene's own while nothing has changed."""
        shown = shown_axis(self._axis)
        first, last = self.part.value
        direction = DIRECTIONS.get(self.direction.value, shown[0])
        typed = direction, self.within.value, (first, last)
        return plain_axis(self._axis) if typed == shown else typed_axis(*typed)

    def forget_obstacle(self, number: int) -> None:
        """Let contacts refer to the same obstacles as before obstacle ``number`` was deleted."""
        allowed = contacts_without(self._kept["allowed"], (number,))
        self._kept = {**self._kept, "allowed": allowed}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self._unit = scene.unit
        arm = scene.arm
        is_urdf = arm.model == "urdf"
        self._show(is_urdf)
        if not is_urdf:
            self.model.value = self._model_shown = _PAPER
            return
        if arm.urdf not in SHIPPED:
            is_new = self.files.get(arm.urdf) != arm.whole_robot
            self._add(arm.urdf, arm.whole_robot)
            if is_new:
                self._tell(arm.urdf, arm.notes(METRES[scene.unit]))
        self.model.value = self._model_shown = _SHIPPED.get(arm.urdf, arm.urdf)
        self._list_tips(arm.urdf, arm.tip, arm.base_link)
        self._list_bases(arm.urdf, arm.base_link)
        self._scene_mount = arm.base_wxyz
        self._show_gripper(arm.urdf, arm.gripper)
        self._kept = {name: getattr(arm, name) for name in _OF_ONE_ARM}
        _choose(self.mount, _MOUNTS, arm.base_wxyz)
        self._axis = arm.axis
        direction, self.within.value, self.part.value = shown_axis(arm.axis)
        _choose(self.direction, DIRECTIONS, direction)
        self._show(True)

    def _name(self) -> str | None:
        """Name in the scene of the arm that is chosen; None for the paper's."""
        by_label = {label: name for name, label in _SHIPPED.items()}
        chosen = by_label.get(self.model.value, self.model.value)
        # a page may send anything: only listed arms are taken
        return chosen if chosen in SHIPPED or chosen in self.files else None

    def _take(self, name: str, robot: Robot) -> None:
        """Choose an arm that was read."""
        name = _zip_of(name)
        self._add(name, robot)
        self.model.value = name
        self._list_tips(name, None)
        planned = planned_sentence(robot, self.tip.value, NOT_HELD)
        self._tell(name, (planned, *robot.notes))

    def _tell(self, name: str, notes: Sequence[str]) -> None:
        """Notify the user of what of an arm is planned, and what was left out."""
        for note in notes:
            self._client.add_notification(name, note, auto_close_seconds=8)

    def _add(self, name: str, robot: Robot) -> None:
        self.files[name] = robot
        self.model.options = (_PAPER, *_SHIPPED.values(), *self.files)

    def _show(self, shown: bool) -> None:
        """Show or hide what only a URDF has."""
        for handle in self._of_urdf:
            handle.visible = shown
        # an angle means nothing without a direction, and a part of the time none without an angle
        points = shown and self.direction.value != "any"
        self.direction.visible, self.within.visible = shown, points
        self.part.visible = points and self.within.value != 0
        self.gripper.show(shown)

    def _list_tips(self, name: str, tip: str | None, base: str | None = None) -> None:
        """List the links of an arm that may be its tip, and choose one, else its usual one."""
        robot = load_robot(name, MeshSource(self.files))
        base = base or robot.root
        self.tip.options = tuple(joint.child for joint in robot.joints)
        self.tip.value = tip or SHIPPED.get(name) or usual_tip(part_from(robot, base))
        self._unnamed_tip = None if tip else (self.tip.value, base)
        self._tips_of = name

    def _list_bases(self, name: str, base: str | None) -> None:
        """List the links that may be the base of the tip, and choose one, else the first."""
        robot = load_robot(name, MeshSource(self.files))
        bases = bases_to(robot, self.tip.value) or (robot.root,)
        self.base_link.options = bases
        self.base_link.value = base or bases[0]
        self._unnamed_base = None if base else robot.root
        self._bases_of = name, self.tip.value

    def _show_gripper(self, name: str, held: Mapping[str, float]) -> None:
        """Show the joints beside an arm, held where a scene says."""
        tip, base = self.tip.value, self.base_link.value
        robot = part_from(load_robot(name, MeshSource(self.files)), base)
        self.gripper.write(robot, tip, held, self._unit)
        self._kept_of = name, tip, base


def _zip_of(file: str) -> str:
    """Name under which the robot of a file is listed."""
    return f"{PurePosixPath(file).stem}.zip"


def _read(job: UploadJob[Robot]) -> Robot:
    """Read the file of an arm; of an archive with several the one chosen."""
    job.step("reading", 0.5)
    name = f"robots.zip/{job.chosen}" if job.chosen else job.name
    return READER.arm(job.content, name, job.stopped, job.wait)


def _choose(box: viser.GuiDropdownHandle[str], values: Mapping[str, object], value: object) -> None:
    """Choose a value of a list, or that of the scene where the list has it not."""
    known = next((label for label, other in values.items() if other == value), None)
    if known is None and _OTHER not in box.options:
        box.options = (*values, _OTHER)
    box.value = known or _OTHER
