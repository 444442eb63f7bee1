"""Legs of a sequence of tasks over the scene: which one is shown, and buttons to the others.

A leg is a scene of its own, which begins where the plan of the one before has ended: going on to
the next takes the plan that is shown. What plays goes on by itself, and after the last leg begins
with the first.
"""

from __future__ import annotations

import html
import itertools
from collections.abc import Sequence

import viser

from abi.planner.plan import Plan
from abi.planner.task_scenes import next_scene
from abi.scene.leg import Leg
from abi.scene.scene import Scene
from app.panels.widgets import Wake, hidden_button, pressed
from app.state.frame import Frame
from app.state.known_legs import KnownLeg
from app.ui.overlay import button
from app.ui.time_bar import leg_at


class LegsCard:
    """Sentence on the leg that is shown, and buttons to go on and back.

    Attributes:
        number: of the leg that is shown, from 0; None while none is.
        from_time: of the leg asked for, at which it begins to be shown, [s].
    """

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self.go_on = hidden_button(gui, "Next leg", wake)
        self.go_back = hidden_button(gui, "Leg before", wake)
        self.number: int | None = None
        self.from_time = 0.0
        self._legs: list[KnownLeg] = []
        self._complete: list[Plan] = []  # those of which nothing is to come
        self._due = False  # whether the leg that is shown has been played
        self._sought: float | None = None
        self._asked: tuple[int, Scene] | None = None

    def see(self, frame: Frame) -> None:
        """Take note of the plan that is shown: of a leg, or of another scene."""
        plan = frame.plan
        if frame.outdated or frame.plan.coarse:
            return
        if plan.scene.tasks:
            self._take(0, plan)
        elif (number := self._number_of(plan.scene)) is None:
            self.number = None
        else:
            self._take(number, plan)
        complete = self._complete if frame.plan.partial else [*self._complete, plan]
        plans = [leg.plan for leg in self._legs]
        self._complete = [one for one in complete if one in plans]
        self._asked = None

    def restore(self, legs: Sequence[KnownLeg]) -> None:
        """Take up a sequence of which the leg after ``legs`` is about to be shown, if there are."""
        self.number = None
        if legs:
            self.number, self._legs = len(legs), [*legs]

    @property
    def kept(self) -> tuple[KnownLeg, ...]:
        """The legs before the one that is shown: what a reload needs to take up the sequence."""
        return tuple(leg._replace(plan=None) for leg in self._legs[: self.number or 0])

    def _number_of(self, scene: Scene) -> int | None:
        """Number of the leg that begins as a scene does, in the joints in which another ended.

        Where several do, it is the one that was asked for or shown last.
        """
        start = None if scene.arm.start is None else scene.arm.start.joints
        last = min(len(self._legs) + 1, len(self._tasks))
        begin = [
            number for number in range(1, last) if start and start == self._legs[number - 1].joints
        ]
        asked = None if self._asked is None else self._asked[0]
        return min(begin, key=lambda one: (one != asked, one != self.number), default=None)

    def _take(self, number: int, plan: Plan) -> None:
        """Keep the plan of a leg; one that ends elsewhere than before drops what followed it."""
        self.number = number
        leg = KnownLeg.of(plan)
        kept = self._legs[number] if number < len(self._legs) else None
        if kept is not None and kept._replace(plan=plan) == leg:
            self._legs[number] = leg
        else:
            self._legs[number:] = [leg]

    @property
    def _whole(self) -> Scene | None:
        """The scene with all tasks; None before there was one."""
        return self._legs[0].scene if self._legs else None

    @property
    def _tasks(self) -> tuple[Leg, ...]:
        return () if self._whole is None else self._whole.tasks

    def seek(self, time: float) -> None:
        """Ask for the leg at a time of all, [s]."""
        self._sought = time

    def requested(self) -> Scene | None:
        """Scene of the leg that was asked for since the last call."""
        on, back = pressed(self.go_on), pressed(self.go_back)
        due, self._due = self._due, False
        sought, self._sought = self._sought, None
        number, whole, self.from_time = self.number, self._whole, 0.0
        if number is None or whole is None:
            return None
        if back and number > 0:
            number -= 1
        elif sought is not None:
            begins = self._begins()
            number = min(leg_at(begins, sought), self._farthest)
            self.from_time = max(sought - begins[number], 0.0)
        elif (on or due) and self._may_go_on:
            number += 1
        elif due:
            number = 0
        else:
            return None
        if number == self.number:
            return None
        known = number < len(self._legs)
        scene = self._legs[number].scene if known else None
        if scene is None:
            plan = self._legs[number - 1].plan
            assert plan is not None
            scene, self.from_time = next_scene(whole, number, plan), 0.0
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
        number = self.number  # of a leg that is restored there is no plan at first
        known = number is not None and number < len(self._legs)
        return known and frame.plan is self._legs[number or 0].plan

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
        if number is None or number + 1 >= len(self._tasks) or number >= len(self._legs):
            return False
        return _ends_well(self._legs[number])

    @property
    def _farthest(self) -> int:
        """Number of the last leg that can be shown, planned or to be planned next."""
        count = len(self._legs)
        return count if count < len(self._tasks) and _ends_well(self._legs[-1]) else count - 1

    def begins_on_bar(self, frame: Frame) -> tuple[float, ...]:
        """When each leg begins, and when the last one ends, [s]; empty where none is shown.

        Those of which the time is not known yet take as long as the others on average.
        """
        if self.number is None or len(self._tasks) < 2 or not self.shows(frame):
            return ()
        return self._begins()

    def _begins(self) -> tuple[float, ...]:
        times = [leg.duration for leg in self._legs]
        mean = max(sum(times) / len(times), 1e-3)
        times += [mean] * (len(self._tasks) - len(times))
        return (0.0, *itertools.accumulate(times))

    def state(self) -> tuple[object, ...]:
        """Values that the card depends on."""
        return self.number, len(self._legs), self._may_go_on, self._whole

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
        span = "The time bar is of all legs"
        if len(self._legs) == len(self._tasks):
            span += f", {self._begins()[-1]:.1f} s in all"
        return (
            f'<div class="abi-card"><b>Leg {number + 1} of {len(self._tasks)}</b>{name}.{after}'
            f'<small style="display:block">{span}.</small>'
            f'<div class="abi-buttons">{buttons}</div></div>'
        )


def _ends_well(leg: KnownLeg) -> bool:
    """Whether another leg may follow."""
    return leg.plan is not None and leg.plan.error is None and leg.plan.motion is not None
