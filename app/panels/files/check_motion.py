"""Check of a motion that was planned elsewhere: its upload, its verdict, and its repair.

The robot and the scene are those of the tab. While a motion is checked it is shown in place of the
tab's own plan, and checked again whenever the scene changes.
"""

from __future__ import annotations

import html
import json
import time

import viser

from abi.certification.certify_motion import certify_motion
from abi.certification.checked_plan import checked_plan
from abi.certification.motion import Motion
from abi.certification.read_motion import BAGS, FORMATS, own_joints
from abi.certification.repair import repair
from abi.certification.verdict import MotionVerdict
from abi.certification.verdict_words import direction_sentences, limit_sentences
from abi.errors import AbiError
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.panels.files.file_uploads import FileUploads
from app.panels.files.upload_job import UploadJob
from app.panels.widgets import Wake, hidden_button, pressed
from app.reading.reader import READER
from app.state.frame import Frame
from app.ui import notices
from app.ui.overlay import button
from app.ui.time_bar import legend

_SIGNS = {"clear": "✓", "touches": "✗", "undecided": "?"}


class CheckMotionPanel:
    """Widgets to check a motion; the worker asks what they were used for.

    Attributes:
        upload: the button for a file.
        processor_ms: time that the last check took, [ms].
        verdict: on the motion that is shown; None while the tab shows its own plan.
    """

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        self._client, self._scene = client, scene
        gui = client.gui
        self.upload = gui.add_upload_button(
            "Check a motion…",
            mime_type=",".join((*FORMATS, *BAGS)),
            hint="A trajectory that another planner made for this arm: is it clear at all times? "
            "ROS 2 JointTrajectory, bag, CSV with joint names, or JSON.",
        )
        self.uploads = FileUploads(
            gui,
            self.upload,
            self._deal,
            wake,
            choice="trajectory in the bag",
            choice_hint="Its topic, and its number there.",
        )
        self.save = gui.add_button(
            "Save the verdict",
            color="gray",
            visible=False,
            hint="Downloads it as JSON, with its certificate: abi verify checks that again.",
        )
        self.save.on_click(wake)
        self.repair = hidden_button(gui, "Repair", wake)
        self.back = hidden_button(gui, "Back to your own plan", wake)
        self._motion: Motion | None = None
        self._name = self._repaired = ""
        self.verdict: MotionVerdict | None = None
        self._plan: Plan | None = None  # the motion as one, in the scene in which it was checked
        self.processor_ms = 0.0

    @property
    def has_motion(self) -> bool:
        """Whether there is a motion to be checked."""
        return self._motion is not None

    def leave(self) -> None:
        """Show the tab's own plan."""
        self._motion = self.verdict = self._plan = None

    def changed(self, scene: Scene) -> bool:
        """Take files and buttons into account; whether there is something else to show.

        Args:
            scene: the tab's.
        """
        self._scene = scene
        before = self._motion
        for one in self.uploads.ended():
            if isinstance(one.result, Motion):
                self._motion, self._name = one.result.from_zero(), one.name
                self.verdict, self._plan, self._repaired = None, None, ""
            elif one.result is not None:
                self._refuse(one.name, one.result)
        if pressed(self.back):
            self.leave()
        if pressed(self.repair) and self.verdict is not None:
            self._mend(self.verdict)
        if pressed(self.save) and self.verdict is not None:
            content = json.dumps(self.verdict.to_dict(), allow_nan=False).encode()
            self._client.send_file_download("verdict.json", content, save_immediately=True)
        return self._motion is not before

    def plan(self, scene: Scene) -> Plan | None:
        """The motion in a scene, checked, as a plan; None where there is none to be checked."""
        if self._motion is None:
            return None
        if self._plan is None or self._plan.scene != scene:
            begin = time.thread_time()
            try:
                most = scene.motion.joint_acceleration
                verdict = certify_motion(self._motion, _with_robot(scene), acceleration=most)
            except AbiError as error:
                self._refuse(self._name, error)
                self.leave()
                return None
            self.verdict, self._plan = verdict, checked_plan(verdict)
            self.processor_ms = 1e3 * (time.thread_time() - begin)
        return self._plan

    def draw(self, frame: Frame) -> None:
        """Offer to save the verdict while there is one."""
        self.save.visible = frame.checked is not None

    def card(self, verdict: MotionVerdict) -> str:
        """The verdict with its legend and buttons, as HTML over the scene."""
        sign, motion = _SIGNS[verdict.state], verdict.problem.motion.motion
        sentence = f"<b>{sign} {html.escape(verdict.sentence)}</b>"
        more = len(verdict.touches) + len(verdict.doubts) - 1
        words = [self._name, self._repaired]
        if verdict.state != "clear" and more > 0:
            words.append(f"{more} more place{'s' * (more > 1)} like this.")
        if not motion.timed:
            words.append("Without times: a waypoint a second.")
        limits, passed = limit_sentences(verdict), len(verdict.limits.passed)
        words += [f"✗ {limits[0]}" if passed else limits[0]]
        if passed > 1:
            words.append(f"{passed} limits are passed in all; Plots shows the joints.")
        if verdict.direction is not None:
            sign = "" if verdict.direction.state == "kept" else "✗ "
            words += [f"{sign}{one}" for one in direction_sentences(verdict)]
        buttons = ""
        if verdict.state != "clear":
            buttons = button(
                self.repair, "Repair", hint="Plan anew what is not proven, by another way."
            )
        buttons += button(self.back, "Back to your own plan")
        look = "abi-card abi-error" if verdict.state == "touches" else "abi-card"
        text = html.escape(" · ".join(filter(None, words)))
        return (
            f'<div class="{look}" role="status">{sentence} {text}'
            f"{legend(verdict.stretches)}</div>"
            f'<div class="abi-buttons" style="margin-top:6px">{buttons}</div>'
        )

    def _mend(self, verdict: MotionVerdict) -> None:
        """Take a repaired motion in place of the one that is checked."""
        try:
            repaired, words = repair(verdict, verdict.scene.motion.joint_acceleration)
        except AbiError as error:
            notices.notify_refusal(self._client, "Not repaired", _sentence(error))
            return
        self._motion, self._repaired = repaired.problem.motion.motion, words
        self.verdict, self._plan = repaired, checked_plan(repaired)

    def _refuse(self, name: str, error: AbiError) -> None:
        notices.notify_refusal(self._client, f"{name} is not checked", _sentence(error), stays=True)

    def _deal(self, job: UploadJob[Motion]) -> Motion:
        """Read a motion's file for the robot that the tab has now."""
        job.step("reading", 0.5)
        slides = own_joints(_with_robot(self._scene).arm.robot)
        return READER.motion(
            job.content, job.name, slides, job.chosen or None, job.stopped, job.wait
        )


def _with_robot(scene: Scene) -> Scene:
    """The scene, if its arm is a robot."""
    if scene.arm.model != "urdf":
        raise AbiError(
            "The paper's arm has no shapes to check.", "Choose a robot in stage 6 first."
        )
    return scene


def _sentence(error: AbiError) -> str:
    return f"{error.message} {error.hint}".strip()
