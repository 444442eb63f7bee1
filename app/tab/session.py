"""One browser tab: input, scene, plan, picture.

Callbacks only wake the tab's worker. Its step (:meth:`Session._update`) reads a scene from the
input (:mod:`app.tab.scene_input`), plans it if it is another one (:mod:`app.tab.planner`), and has
every panel and layer draw the same frozen :class:`Frame` (:mod:`app.tab.view`).
"""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from dataclasses import replace

import viser

from abi import compiling, progress
from abi.errors import AbiError
from abi.planner.plan import Plan
from abi.progress import CancelledError
from abi.scene.scene import Scene
from app.panels.files.bug_report import describe_fault, notify_fault, send_bug_report
from app.panels.files.exports import send_plan
from app.panels.widgets import pressed
from app.process import metrics, unused_memory
from app.process.memory_budget import MemoryBudget
from app.process.turns import AT_ONCE, PATIENT
from app.shared.shared_plans import SharedPlans
from app.state.appearance import Appearance
from app.state.frame import Frame
from app.state.tab_state import TabState
from app.tab.browser_storage import TabStorage
from app.tab.pause import IDLE, REST, Pause
from app.tab.planner import TabPlanner
from app.tab.refused_files import hear_of_refused_files
from app.tab.scene_input import SceneInput
from app.tab.view import TabView
from app.tab.worker import TabWorker
from app.teach.classroom import Classroom
from app.teach.exercise_watch import ExerciseWatch
from app.teach.lesson import Library
from app.ui import notices, page
from app.ui.arm_size import oversize
from app.ui.page_area import watch_area

_log = logging.getLogger("abi.tab")

SLOW_MS = 120.0
"""Processor time of a plan, [ms], beyond which it is drawn in grey while the next one is made;
quicker plans save that picture, which matters with many tabs."""


class Session:
    """One browser tab, whose worker reads its input, plans and draws.

    Attributes:
        frame: what is drawn.
        plans: number of plans drawn so far, counting one as often as it was drawn.
        panels: the tab's.
        playback: the tab's.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        name: str,
        scene: Scene,
        look: Appearance,
        planned: threading.Event,
        library: Library,
        budget: MemoryBudget,
        opening: SharedPlans,
        classroom: Classroom | None = None,
        exercise: ExerciseWatch | None = None,
    ) -> None:
        """Build the tab and start its worker.

        It sets ``planned`` whenever a plan has been drawn, and takes memory for its scenes, but the
        first, out of ``budget``. A first plan that another tab has made is in ``opening``.
        """
        self.client = client
        self.frame = Frame(Plan(scene))
        self.plans = 0
        self._planner = TabPlanner(client.client_id, self._tell)
        self._overdue: Frame | None = None  # to be drawn once the plan under way is slow
        self._unplanned = False  # whether the plan of the scene was ended by another choice
        self._woken = 0.0
        self._fault: str | None = None
        self._broken = False
        self._planned = planned
        self._built = self._closed = False
        self._touched = False  # whether there was input of a hand since the last step
        self._worker = worker = TabWorker(f"tab-{client.client_id}", self._run)
        page.install(client)
        area = watch_area(client, worker.wake)
        hear_of_refused_files(client)
        self._memory = TabStorage(client, self._hear)
        with client.atomic():
            self._view = TabView(
                client,
                name,
                scene,
                self.wake,
                bool(look.dark),
                library,
                area,
                lambda: self._planner.overtaken,
            )
            self.panels, self.playback = self._view.panels, self._view.playback
            self._built = True
            if classroom is not None:
                self._view.join(classroom, self.wake, worker.wake, worker.hurry)
            if exercise is not None:
                self._view.watch_exercise(exercise, self.wake, worker.wake)
        self._pause = Pause(client, self.panels, self._planner, worker.is_woken, bool(look.plain))
        self._input = SceneInput(
            client, scene, look, self._view, self._memory, self._pause, budget, opening
        )
        self._input.keep_memory_for(self)
        self._drawn = self.panels.step(scene)
        worker.start()
        self._opened = time.monotonic()
        metrics.SESSIONS.inc()
        metrics.TABS.inc()
        _log.info("tab opened", extra={"tab": client.client_id})

    def close(self) -> None:
        """End the worker of a closed tab."""
        if self._closed:
            return
        self._closed = True
        self._view.close()
        self._worker.close()
        metrics.TABS.dec()
        unused_memory.give_back_soon()
        seconds = time.monotonic() - self._opened
        fields = {"tab": self.client.client_id, "seconds": seconds, "plans": self.plans}
        _log.info("tab closed", extra=fields)

    @property
    def scene(self) -> Scene:
        """The scene that is shown, or about to be."""
        return self._input.scene

    def state(self) -> TabState:
        """State for the page to store."""
        return self._input.state(self.frame.time)

    @property
    def plan(self) -> Plan | None:
        """The plan drawn last; None before the first."""
        return self.frame.plan if self.plans else None

    @property
    def resting(self) -> bool:
        """Whether the plan is complete, all of it is drawn, and no input is waiting."""
        waiting = self.frame.interactive or self.frame.plan.partial or self._worker.is_woken()
        return self.plans > 0 and not waiting

    def wake(self, event: object) -> None:
        """Wake the worker after an input: the callback of every widget.

        What the worker writes into a widget comes back here too, without a client. Not ``async``:
        viser leaves coroutines behind when it stops.
        """
        self._touched |= getattr(event, "client", None) is not None
        self._hear(event)

    def _hear(self, event: object) -> None:
        """Wake the worker after a word of the page that no hand has caused, or after an input."""
        if getattr(event, "client", None) is not None:
            if self._built:  # until then no widget has been read
                self.panels.note(event)
                self._planner.overtaken |= self.panels.chooses(event)
            if not self._worker.is_woken():
                self._woken = time.monotonic()
            self._worker.hurry()

    def _run(self) -> None:
        """Take steps until the tab is closed: after input, or when something is due."""
        self._memory.wait()
        while True:
            self._worker.wait(self._timeout())
            if self.plans:  # the thread that loads kernels comes first, once there is a picture
                compiling.wait_for_kept()
            if self._worker.closed:
                return
            with self._worker.turn(self._patience()) as woken:
                self._work(woken)

    def _work(self, woken: bool) -> None:
        """Take a step; after a fault return to the last plan."""
        try:
            self._step(woken)
        except CancelledError:
            self._unplanned = True  # what was chosen instead has woken the worker
        except Exception as error:
            self._recover(error)

    def _step(self, woken: bool) -> None:
        """Process input, idle work and playback."""
        demo = self._pause.demo
        touched, self._touched = self._touched, False
        resized = self._view.fit(self.frame, touched)
        if woken:
            self._planner.overtaken = False  # before it is read what was chosen
            demo.interrupt()
            self._broken = False
            self._pause.begin()
            self._update()
        elif demo.running:
            demo.step()
            self._pause.begin(input=False)
            self._update()
        elif not self._broken:
            if self._pause.seconds >= REST:
                self._work_in_pause()
            if self._view.leg_is_over(self.frame):
                self.panels.messages.legs.play_next()
                self._pause.begin(input=False)
                self._update()
                if self.panels.messages.legs.shows(self.frame):
                    self.panels.history.replace(self.panels.step(self.scene))
            elif resized or self._view.is_due(self.frame):
                self._draw(self.frame)
        classroom = self._view.classroom
        leads = classroom is not None and classroom.teaches
        if not demo.running and (leads or self._memory.is_due):
            state = self.state()
            self._memory.keep(state)
            if classroom is not None:
                classroom.publish(state)

    def _update(self) -> None:
        """Read the input, plan its scene if that is another one, and draw the picture."""
        replaced = self._input.receive(self.frame.time)
        if (direction := self.panels.lecture.requested_view()) is not None:
            self._view.viewpoint.look_from(direction)
        self._view.seek_leg()
        try:
            scene = self._input.read()
        except AbiError as error:
            # the last scene stays, to be looked at and saved
            self._draw(replace(self.panels.apply_switches(self.frame), refused=error))
        else:
            self.frame = replace(self.frame, refused=self.panels.refused)
            if replaced:
                self.panels.check.leave()
            replaced |= self.panels.check.changed(scene) or self._unplanned
            is_new = self.plans == 0 or replaced or scene != self.scene
            self._show(self._replan(scene) if is_new else self.frame.plan, interactive=True)
        self._answer_requests()

    def _answer_requests(self) -> None:
        """Send the files and links that the panels are asked for."""
        self.panels.files.save_if_requested(self.scene)
        self.panels.share.share(self.state, self.frame, self.panels.practice.quiz_link())
        if pressed(self.panels.export):
            self._export()
        if pressed(self.panels.bug_report):
            send_bug_report(self.client, self.frame, self._fault)

    def _export(self) -> None:
        """Send the plan as a file, in full."""
        if self.frame.checked is not None:
            reason = "The motion that is checked is a file already. Go back to your own plan first."
            notices.notify_refusal(self.client, "Not exported", reason)
            return
        if self.frame.plan.partial:
            self._show(self._planner.finish(self.scene, self._input.shared_plans))
        send_plan(self.client, self.panels.export_format.value, self.frame.plan)

    def _replan(self, scene: Scene) -> Plan:
        """Turn to another scene, and plan it."""
        # a scene noted before is gone back to, with the camera as it is
        legs = self.panels.messages.legs
        leg = legs.begins(scene)
        new = not leg and scene is not self.panels.history.noted
        loaded = new and self.panels.files.loaded is scene
        grown = scene.arm is not self.scene.arm and oversize(scene) != oversize(self.scene)
        if scene.workspace != self.scene.workspace or loaded or grown:
            self._view.look_at(scene)
        self._input.scene = scene
        if self.plans == 0:
            self._input.first = scene
        plan = self._known_plan(scene)
        if plan is None:
            plan = self._new_plan(scene, loaded, leg)
        if leg:
            self.playback.restore(legs.from_time, self.playback.playing)
        return plan

    def _known_plan(self, scene: Scene) -> Plan | None:
        """The motion that is checked, a leg shown before, or another tab's plan; else None."""
        check, live = self.panels.check, self._planner.live
        if check.has_motion:
            live.adopt(scene)
            if self.frame.checked is None:
                self.panels.messages.wait("Checking the motion")
            elif check.processor_ms > SLOW_MS:
                self._draw(replace(self.frame, outdated=True))
        if (checked := check.plan(scene)) is not None:
            return checked
        if (leg := self.panels.messages.legs.planned(scene)) is not None:
            live.adopt(scene)
            return leg
        shared = self._input.shared_plans
        return None if shared is None else self._planner.take(scene, shared)

    def _new_plan(self, scene: Scene, loaded: bool, leg: bool) -> Plan:
        """Plan a scene, with the last plan in grey if that may take long.

        Args:
            scene: the scene.
            loaded: whether it is another one than what is shown, not a change of that.
            leg: whether it is a leg of a sequence, of which nothing has been shown.
        """
        if loaded and self.plans:
            # nothing that is told of the last scene is true of this one, nor of the right size
            self.playback.restore(0.0, self.playback.playing)
            frame = replace(self.frame, plan=Plan(scene), reason=None)
            self._view.draw(replace(frame, outdated=True))
        elif self._planner.processor_ms > SLOW_MS:
            self._draw(replace(self.frame, outdated=True))
        elif self.plans:
            self._overdue = replace(self.frame, outdated=True)
        try:
            # what of a leg came later would move the arm while it plays
            plan = self._planner.finish if leg else self._planner
            return plan(scene, self._input.shared_plans)
        finally:
            self._overdue = None

    def _tell(self, doing: str) -> None:
        """Show the progress of the plan that is being made, and that the last one is outdated."""
        if self._overdue is not None:
            frame, self._overdue = self._overdue, None
            # a picture that is begun is drawn to its end
            with progress.watched_by(lambda: False):
                self._draw(frame)
        self.panels.messages.tell(doing)

    def _show(self, plan: Plan, interactive: bool = False) -> None:
        """Draw a plan; ``interactive`` while the input may still change."""
        self._unplanned = False
        frame = self.panels.apply_switches(self.frame)
        if plan is not frame.plan:
            frame = replace(frame, plan=plan, reason=None, checked=self.panels.check.verdict)
        self._view.face(plan)
        frame = replace(frame, interactive=interactive, demonstrates=self._pause.demo.running)
        self._draw(replace(frame, outdated=False))
        if interactive and self.plans:
            metrics.UPDATES.observe(time.monotonic() - self._woken)
        self._drawn = self.panels.step(plan.scene)
        self.plans += 1
        self._planned.set()

    def _draw(self, frame: Frame) -> None:
        """Draw a frame at the time of the playback."""
        self.frame = self._view.draw(frame)
        if self.panels.lessons.waiting:
            self._worker.wake()

    def _work_in_pause(self) -> None:
        """Complete what a drag has left incomplete; after that do idle work."""
        if not self.panels.held:  # before what takes longer, in which there may be a hand again
            self.panels.history.note(self.panels.step(self.scene), self._woken)
        if self.frame.plan.partial:
            self._complete()
            return
        if not self.panels.held:
            self._view.viewpoint.follow()
        if self.frame.interactive:
            self._draw(replace(self.frame, interactive=False))
        frame = self._pause.use(self.frame, self.scene)
        if frame.plan is not self.frame.plan:
            self._show(frame.plan)
        elif frame is not self.frame:
            self._draw(frame)

    def _complete(self) -> None:
        """Plan in full; of a class in which all tabs need the plan, the first makes it."""
        shared = self._input.shared_plans
        with contextlib.nullcontext(True) if shared is None else shared.claim(self.scene) as mine:
            if not mine:
                return
            if self.frame.plan.coarse:
                self._draw(replace(self.frame, outdated=True))
            self._show(self._planner.finish(self.scene, shared))

    def _recover(self, error: Exception) -> None:
        """Return to the last plan after a fault of our own, and say so, until there is input."""
        self._broken = True
        self._input.scene = self._drawn.scene
        self.panels.read_all()  # what was typed or dragged stays with the hand
        self._fault = describe_fault(error)
        metrics.FAULTS.inc()
        _log.exception("fault", extra={"tab": self.client.client_id})
        notify_fault(self.client, error)
        with contextlib.suppress(Exception):  # the fault may be in what draws
            if self.panels.files.loaded is not self._drawn.loaded:
                self.panels.show(self._drawn)
                self._view.look_at(self.scene, face=False)
                self._draw(self.frame)
            else:  # what is proven of the last plan is not of what the hand has changed
                self._draw(replace(self.frame, outdated=True))

    def _patience(self) -> float:
        """Maximum delay of the next step behind drags in other tabs, [s]."""
        moving = self._pause.demo.running or self._view.is_due(self.frame)
        return AT_ONCE if moving or self.plans == 0 else PATIENT

    def _timeout(self) -> float:
        """Time to wait for input, [s]."""
        if self._broken:
            return IDLE
        picture, pause = self._view.timeout(self.frame), self._pause.timeout(self.frame)
        return pause if picture is None else min(picture, pause)
