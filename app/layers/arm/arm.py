"""The arm, whichever it is, and the trace that its tool leaves."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from app.drawing.lines import NO_SEGMENTS, Segments, add_line, rows_at, segments
from app.layers.arm.arm_nodes import ArmNodes
from app.layers.arm.arm_playback import samples_of, table_of
from app.layers.arm.kinds import KINDS, kind_of
from app.state.frame import Frame
from app.ui import page, style
from app.ui.layout import Layout

_TRACE_SAMPLES = 100


def prepare_bodies(arm: AnyArm) -> None:
    """Make what takes long to make of an arm's picture, before a tab needs it."""
    kind_of(arm).bodies(arm)


class ArmLayer:
    """An arm's nodes: a frame sends the poses of its joints and no geometry.

    While the motion plays, the page poses them by itself.
    """

    def __init__(self, layout: Layout) -> None:
        self._client, scene = layout.client, layout.client.scene
        self._playing: tuple[object, ...] = ()
        self._kinds = {kind: ArmNodes(scene, one) for kind, one in KINDS.items()}
        self._nodes = next(iter(self._kinds.values()))
        self._arm: AnyArm | None = None
        self._posed: object = None
        self._trace = add_line(scene, "/trace", style.TRACE, 4.0)
        self._traced: tuple[object, int] = (None, -1)

    def __call__(self, frame: Frame) -> None:
        """Draw the arm at the frame's time, and the trace up to then."""
        arm = frame.plan.arm
        shown = "arm" in frame.shown
        if arm is not None and shown and arm is not self._arm:
            # the page would move the nodes of the next arm as those of the last
            self._stand(frame.time)
            self._place(arm)
        started = False
        if plays := frame.playing and frame.plan.motion is not None:
            started = self._play(frame, frame.plan.motion)
        else:
            self._stand(frame.time)
            self._pose(frame.plan, frame.time)
        clearance = frame.plan.arm_clearance
        links = frozenset[str]() if clearance is None else clearance.touching(frame.time)
        if self._nodes.redden(links) and plays and not started:
            # the page's clock may be behind: a link is to turn red as it touches
            page.call(self._client, "seek", frame.time)
        for nodes in self._kinds.values():
            nodes.root.visible = shown and arm is not None and nodes is self._nodes
        self._trace.visible = "trace" in frame.shown

    def _place(self, arm: AnyArm) -> None:
        """Show another arm."""
        self._arm, self._posed = arm, None
        self._nodes = self._kinds[type(arm)]
        self._nodes.place(arm)

    def _stand(self, time: float) -> None:
        """Have a motion that the page plays end at ``time`` [s]."""
        if self._playing:
            self._playing = ()
            page.call(self._client, "stand", time)
            self._nodes.forget_poses()
            self._posed, self._traced = None, (None, -1)

    def _play(self, frame: Frame, motion: ArmMotion) -> bool:
        """Have the page move the arm and lengthen the trace of a motion; whether that is new."""
        # one that was changed while it is not to be seen has no nodes yet
        joints = self._nodes.joint_nodes if frame.plan.arm is self._arm else []
        playing = motion, frame.rate, frame.again, joints
        if playing == self._playing:
            return False
        self._playing = playing
        rows = samples_of(motion)
        positions = motion.positions[rows]
        page.call(
            self._client,
            "play",
            {
                **table_of(motion, self._nodes.values(positions) if joints else positions),
                "joints": [joint.played for joint in joints],
                "trace": self._trace.name,
                "time": frame.time,
                "rate": frame.rate,
                "again": frame.again,
            },
        )
        self._trace.points = self._trace_of(frame.plan, motion.tool[rows])
        return True

    def _pose(self, plan: Plan, time: float) -> None:
        """Move the arm to its pose at ``time`` [s], and draw the trace up to then."""
        motion = plan.motion
        moment = (motion if motion is not None else plan, time)
        if moment == self._posed:
            return
        self._posed = moment
        if motion is None:
            self._trace.points = NO_SEGMENTS
            if plan.arm is not None and plan.arm is self._arm:
                self._nodes.rest(plan.scene)
            return
        if plan.arm is self._arm:
            self._nodes.move(rows_at(time, motion.time, motion.positions))
        count = int(np.searchsorted(motion.time, time, side="right"))
        if self._traced != (motion, count):
            self._traced = (motion, count)
            samples = np.linspace(0, count - 1, min(count, _TRACE_SAMPLES)).astype(int)
            self._trace.points = self._trace_of(plan, motion.tool[samples])

    def _trace_of(self, plan: Plan, points: FloatArray) -> Segments:
        """Trace through points (n, 3) of the tool, just above them, so that the curve is seen."""
        height = 0.008 * max(plan.scene.workspace.size)
        return segments(points + np.array([0.0, 0.0, height]))
