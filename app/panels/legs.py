"""Legs of a sequence of tasks over the scene: which one is shown, and buttons to the others.

A leg is a scene of its own, which begins where the plan of the one before has ended: going on to
the next takes the plan that is shown. What plays goes on by itself, and after the last leg begins
with the first.
"""

from __future__ import annotations

import html

import viser

from abi.planner.plan import Plan
from abi.planner.task_scenes import next_scene
from abi.scene.leg import Leg
from abi.scene.scene import Scene
from app.panels.widgets import Wake, hidden_button, pressed
from app.state.frame import Frame
from app.ui import style
from app.ui.overlay import button


class LegsCard:
    """Sentence on the leg that is shown, the time bar of all legs, and buttons to go on and back.

    Attributes:
        number: of the leg that is shown, from 0; None while none is.
    """

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self.go_on = hidden_button(gui, "Next leg", wake)
        self.go_back = hidden_button(gui, "Leg before", wake)
        self.number: int | None = None
        self._whole: Scene | None = None
        self._plans: list[Plan] = []
        self._complete: list[Plan] = []  # those of them of which nothing is to come
        self._due = False  # whether the leg that is shown has been played
        self._asked: tuple[int, Scene] | None = None

    def see(self, frame: Frame) -> None:
        """Take note of the plan that is shown: of a leg, or of another scene."""
        plan = frame.plan
        if frame.outdated or frame.coarse:
            return
        if plan.scene.tasks:
            self._whole = plan.scene
            self._take(0, plan)
        elif (number := self._number_of(plan.scene)) is None:
            self.number = None
        else:
            self._take(number, plan)
        complete = self._complete if frame.partial else [*self._complete, plan]
        self._complete = [one for one in self._plans if one in complete]
        self._asked = None

    def _number_of(self, scene: Scene) -> int | None:
        """Number of the leg that begins as a scene does, in the joints in which another ended.

        Where several do, it is the one that was asked for or shown last.
        """
        start = None if scene.arm.start is None else scene.arm.start.joints
        last = min(len(self._plans) + 1, len(self._tasks))
        begin = [
            number
            for number in range(1, last)
            if start is not None and start == _end(self._plans[number - 1])
        ]
        asked = None if self._asked is None else self._asked[0]
        return min(begin, key=lambda one: (one != asked, one != self.number), default=None)

    def _take(self, number: int, plan: Plan) -> None:
        """Keep the plan of a leg; one that ends elsewhere than before drops what followed it."""
        self.number = number
        kept = self._plans[number] if number < len(self._plans) else None
        if kept is not None and kept.scene == plan.scene and _end(kept) == _end(plan):
            self._plans[number] = plan
        else:
            self._plans[number:] = [plan]

    @property
    def _tasks(self) -> tuple[Leg, ...]:
        return () if self._whole is None else self._whole.tasks

    def requested(self) -> Scene | None:
        """Scene of the leg that was asked for since the last call."""
        on, back = pressed(self.go_on), pressed(self.go_back)
        due, self._due = self._due, False
        number, whole = self.number, self._whole
        if number is None or whole is None:
            return None
        if back and number > 0:
            number -= 1
        elif (on or due) and self._may_go_on:
            number += 1
        elif due:
            number = 0
        else:
            return None
        planned = number < len(self._plans)
        scene = self._plans[number].scene if planned else None
        scene = scene or next_scene(whole, number, self._plans[number - 1])
        self._asked = number, scene
        return scene

    def begins(self, scene: Scene) -> bool:
        """Whether ``scene`` is that of the leg asked for last, of which nothing has been shown."""
        return self._asked is not None and scene is self._asked[1]

    def planned(self, scene: Scene) -> Plan | None:
        """The plan of the leg asked for if it has been shown in full; None for another scene."""
        plans = self._complete if self.begins(scene) else []
        return next((one for one in plans if one.scene is scene), None)

    def shows(self, frame: Frame) -> bool:
        """Whether the plan of ``frame`` is that of a leg."""
        return self.number is not None and frame.plan is self._plans[self.number]

    def plays_on(self, frame: Frame) -> bool:
        """Whether another leg follows once the motion of ``frame`` has been played."""
        ready = self.shows(frame) and frame.plan in self._complete and frame.plan.motion is not None
        return ready and len(self._tasks) > 1 and frame.current and frame.theatre is None

    def play_next(self) -> None:
        """Ask for the leg after the one that has been played; after the last, for the first."""
        self._due = True

    @property
    def _may_go_on(self) -> bool:
        number = self.number
        if number is None or number + 1 >= len(self._tasks):
            return False
        plan = self._plans[number]
        return plan.error is None and plan.motion is not None

    def state(self) -> tuple[object, ...]:
        """Values that the card depends on."""
        return self.number, len(self._plans), self._may_go_on, self._whole

    def html(self) -> str:
        """The card as HTML; empty where no leg is shown."""
        if self.number is None or len(self._tasks) < 2:
            return ""
        number, leg = self.number, self._tasks[self.number]
        name = f": {html.escape(leg.name)}" if leg.name else ""
        after = ""
        if leg.attach is not None:
            after = f" At its end the gripper takes obstacle {leg.attach + 1}."
        elif leg.release:
            after = " At its end the gripper lets go."
        buttons = button(self.go_back, "Leg before", enabled=number > 0)
        buttons += button(self.go_on, "Next leg", enabled=self._may_go_on)
        return (
            f'<div class="abi-card"><b>Leg {number + 1} of {len(self._tasks)}</b>{name}.{after}'
            f'{self._bar()}<div class="abi-buttons">{buttons}</div></div>'
        )

    def _bar(self) -> str:
        """Time bar of all legs: each as long as it takes, those not planned yet as the mean."""
        times = [
            0.0 if plan.motion is None else float(plan.motion.time[-1]) for plan in self._plans
        ]
        number = self.number or 0
        mean = max(sum(times) / len(times), 1e-3)
        widths = [*times, *[mean] * (len(self._tasks) - len(times))]
        shown, others = style.css(style.BSPLINE), style.css(style.FADED)
        place = "height:6px;border-radius:2px"
        parts = "".join(
            f'<span style="flex:{width:.3f};{place};background:{shown if k == number else others}">'
            "</span>"
            for k, width in enumerate(widths)
        )
        span = "Play goes through all legs"
        if len(times) == len(self._tasks):
            span += f", {sum(times):.1f} s in all"
        return f'<div style="display:flex;gap:2px;margin:4px 0">{parts}</div><small>{span}.</small>'


def _end(plan: Plan) -> tuple[tuple[str, float], ...] | None:
    """Joints by name in which a plan ends; None without a motion."""
    motion = plan.motion
    if motion is None:
        return None
    return tuple(zip(motion.joints, motion.positions[-1].tolist(), strict=True))
