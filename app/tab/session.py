"""One browser tab: its worker reads the panels, plans what changed, and draws the frame.

Callbacks only wake the worker. It gives one frozen :class:`Frame` to every layer and panel.
"""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from dataclasses import replace

import viser

from abi import assets, compiling, progress
from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.plan import Plan
from abi.progress import CancelledError
from abi.scene.scene import Scene
from app.panels.files.bug_report import describe_fault, send_bug_report
from app.panels.teach.classroom import ClassroomPanel
from app.panels.teach.exercise import ExercisePanel
from app.panels.widgets import pressed
from app.process import metrics, unused_memory
from app.process.memory_budget import MemoryBudget
from app.process.turns import AT_ONCE, PATIENT
from app.shared.shared_plans import SharedPlans
from app.state.appearance import Appearance
from app.state.frame import Frame
from app.state.tab_state import TabState
from app.tab.browser_storage import Report, TabStorage
from app.tab.budget import TabBudget
from app.tab.pause import IDLE, REST, Pause
from app.tab.planner import TabPlanner
from app.tab.refused_files import hear_of_refused_files
from app.tab.view import TabView
from app.tab.worker import TabWorker
from app.teach.classroom import Classroom
from app.teach.cue import Cue
from app.teach.exercise_watch import ExerciseWatch
from app.teach.lesson import Library
from app.ui import notices, page
from app.ui.arm_size import oversize
from app.ui.labels import sentence
from app.ui.page_area import PageWatch

_log = logging.getLogger("abi.tab")

SLOW_MS = 120.0
"""Processor time of a plan, [ms], beyond which it is drawn in grey while the next one is made;
quicker plans save that picture, which matters with many tabs."""


class Session:
    """One browser tab: its state, and the thread that reads its controls, plans and draws.

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
        self._scene = scene
        self._planner = TabPlanner(client.client_id, self._tell)
        self._overdue: Frame | None = None  # to be drawn once the plan under way is slow
        self._held = False  # whether a hand dragged when the panels were read last
        self._unplanned = False  # whether the plan of the scene was ended by another choice
        self._budget = TabBudget(budget, client, self)
        self._opening, self._first = opening, scene
        self._woken = 0.0
        self._fault: str | None = None
        self._broken = False
        self._planned = planned
        self._built = self._closed = False
        self._touched = False  # whether there was input of a hand since the last step
        self._worker = worker = TabWorker(
            f"tab-{client.client_id}",
            prepare=lambda: self._memory.wait(),
            timeout=self._timeout,
            ready=self._wait_for_kernels,
            patience=self._patience,
            step=self._work,
        )
        page.install(client)
        watch = PageWatch(client, worker.wake)
        hear_of_refused_files(client)
        self._memory = TabStorage(client, self._hear)
        self._look = look
        with client.atomic():
            self._view = TabView(
                client,
                name,
                scene,
                self.wake,
                bool(look.dark),
                library,
                watch,
                lambda: self._planner.overtaken,
            )
            self.panels, self.playback = self._view.panels, self._view.playback
            self._built = True
            self._class: ClassroomPanel | None = None
            if classroom is not None:
                self._class = self._view.join(classroom, self.wake, worker.wake, worker.hurry)
            self._exercise: ExercisePanel | None = None
            if exercise is not None:
                self._exercise = self._view.watch_exercise(exercise, self.wake, worker.wake)
        self._pause = Pause(client, self.panels, self._planner, worker.is_woken, bool(look.plain))
        self._drawn = self.panels.step(scene)
        self._demonstrated = False  # whether the scene is where the demonstration left it
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
        if self._class is not None:
            self._class.close()
        if self._exercise is not None:
            self._exercise.close()
        self.panels.close()
        self._worker.close()
        metrics.TABS.dec()
        unused_memory.give_back_soon()
        seconds = time.monotonic() - self._opened
        fields = {"tab": self.client.client_id, "seconds": seconds, "plans": self.plans}
        _log.info("tab closed", extra=fields)

    @property
    def plan(self) -> Plan | None:
        """The plan drawn last; None before the first."""
        return self.frame.plan if self.plans else None

    @property
    def resting(self) -> bool:
        """Whether the plan is complete, all of it is drawn, and no input is waiting."""
        waiting = self.frame.interactive or self.frame.partial or self._worker.is_woken()
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

    def _work(self, woken: bool) -> None:
        """Take a step; after a fault return to the last plan."""
        try:
            self._step(woken)
        except CancelledError:
            self._unplanned = True  # what was chosen instead has woken the worker
        except Exception as error:
            self._recover(error)

    def _wait_for_kernels(self) -> None:
        """Yield the interpreter to the thread that loads kernels, once there is a picture."""
        if self.plans:
            compiling.wait_for_kept()

    def _patience(self) -> float:
        """Maximum delay of the next step behind drags in other tabs, [s]."""
        moving = self._pause.demo.running or self._view.is_due(self.frame)
        return AT_ONCE if moving or self.plans == 0 else PATIENT

    def _step(self, woken: bool) -> None:
        """Process input, idle work and playback."""
        demo = self._pause.demo
        touched, self._touched = self._touched, False
        resized = self._view.fit(self.frame, touched)
        if woken:
            self._planner.overtaken = False  # before it is read what was chosen
            self._demonstrated = demo.running
            demo.end()
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
                    self.panels.history.replace(self.panels.step(self._scene))
            elif resized or self._view.is_due(self.frame):
                self._draw(self.frame)
        leads = self._class is not None and self._class.teaches
        if not demo.running and (leads or self._memory.is_due):
            state = self._state()
            self._memory.keep(state)
            if self._class is not None:
                self._class.publish(state)

    def _recover(self, error: Exception) -> None:
        """Return to the last plan after a fault of our own, and say so, until there is input."""
        self._broken = True
        self._scene = self._drawn.scene
        self.panels.read_all()  # what was typed or dragged stays with the hand
        self._fault = describe_fault(error)
        metrics.FAULTS.inc()
        _log.exception("fault", extra={"tab": self.client.client_id})
        words = (
            "There was not enough memory for this; a coarser mesh takes less."
            if isinstance(error, MemoryError)
            else "The visualiser met a fault of its own. The Scene tab has a text for a bug report."
        )
        notices.notify_refusal(self.client, "This did not work", f"{words} The last picture stays.")
        with contextlib.suppress(Exception):  # the fault may be in what draws
            if self.panels.files.loaded is not self._drawn.loaded:
                self.panels.show(self._drawn)
                self._view.look_at(self._scene, face=False)
                self._draw(self.frame)
            else:  # what is proven of the last plan is not of what the hand has changed
                self._draw(replace(self.frame, outdated=True))

    def _timeout(self) -> float:
        """Time to wait for input, [s]."""
        if self._broken:
            return IDLE
        picture, pause = self._view.timeout(self.frame), self._pause.timeout(self.frame)
        return pause if picture is None else min(picture, pause)

    def _update(self) -> None:
        """Plan and draw what the panels show."""
        report = self._memory.report()
        restored = report is not None and self._restore(report)
        if self._class is not None:
            if report is not None:
                fresh = not report.state
                self._class.recognise(report.query.get("teach", ""), report.student, fresh)
            restored |= self._mirror(self._class)
        written = None if self._exercise is None else self._exercise.cue()
        if (cue := self.panels.cue(self._scene) or written) is not None:
            restored |= self._follow(cue)
        elif self.panels.left() or (self._exercise is not None and self._exercise.left()):
            before, self._scene = self._scene, self._view.go_back(self._scene)
            self._scene = self._budget.fitting(self._scene)
            restored |= self._scene != before
        if (direction := self.panels.lecture.requested_view()) is not None:
            self._view.viewpoint.look_from(direction)
        self._view.seek_leg()
        held, self._held = self._held, self.panels.held
        if self._held and not held and not self._demonstrated:
            # what was changed just before a drag is a step of its own
            self.panels.history.note(self.panels.step(self._scene))
        try:
            scene = self._read()
        except AbiError as error:
            # the last scene stays, to be looked at and saved
            self._draw(replace(self.panels.apply_switches(self.frame), refused=error))
        else:
            self.frame = replace(self.frame, refused=self.panels.refused)
            if restored:
                self.panels.check.leave()
            changed = self.panels.check.changed(scene)
            if self.plans == 0 or restored or changed or self._unplanned or scene != self._scene:
                begins = self.panels.messages.legs.begins(scene)
                plan = self._replan(scene)
                if begins:
                    legs = self.panels.messages.legs
                    self.playback.restore(legs.from_time, self.playback.playing)
                self._show(plan, interactive=True)
            else:
                self._show(self.frame.plan, interactive=True)
        self.panels.files.save_if_requested(self._scene)
        self.panels.share.share(self._state, self.frame, self.panels.practice.quiz_link())
        if self.panels.exports.requested():
            self._export()
        if pressed(self.panels.bug_report):
            send_bug_report(self.client, self.frame, self._fault)

    def _export(self) -> None:
        """Send the plan as a file, in full."""
        if self.frame.checked is not None:
            reason = "The motion that is checked is a file already. Go back to your own plan first."
            notices.notify_refusal(self.client, "Not exported", reason)
            return
        if self._planner.live.partial:
            self._show(self._planner.finish(self._scene, self._shared))
        self.panels.exports.send(self.frame.plan)

    def _read(self) -> Scene:
        """Read the panels; one-off rejections, as of a file, are reported, then ignored.

        Raises:
            SceneError: what they show is no scene.
        """
        try:
            return self._within_memory(self.panels.read(self._scene))
        except AbiError as error:
            scene = self.panels.read(self._scene)
            notices.notify_refusal(self.client, "Not changed", sentence(error))
            return scene

    def _within_memory(self, scene: Scene) -> Scene:
        """The scene of the panels, with the last mesh if theirs would exceed the memory.

        One that was opened gets the finest mesh that is not.
        """
        if (scene.mesh, scene.workspace) == (self._scene.mesh, self._scene.workspace):
            return scene
        if self.panels.files.loaded is scene:
            fitting = self._budget.fitting(scene)
            if fitting is not scene:
                self.panels.show(self.panels.step(fitting))
            return fitting
        try:
            self._budget.take(scene)
        except SceneError as error:
            self.panels.refuse(error)
            last = self._scene
            return scene.replace(mesh=last.mesh.model_dump(), workspace=last.workspace.model_dump())
        return scene

    def _restore(self, report: Report) -> bool:
        """Restore what the page or a link holds; False if that is nothing."""
        self._view.take(report, self._look.dark)
        if report.software and self._look.plain is None:
            self._pause.stay_plain()
        if report.oversize:
            reason = (
                f"What this tab remembers has {report.oversize:,} letters, more than the server "
                "takes. Open the scene from its file."
            )
            notices.notify_refusal(self.client, "Not brought back", reason, stays=True)
        if not report.state:
            self._pause.demo.wanted = self._look.demo and report.query.get("demo") != "0"
            return False
        meshes = MeshSource(self._scene.meshes.files, assets.path("scenes"))
        try:
            state = TabState.decode(report.state, meshes)
        except SceneError as error:
            notices.notify_refusal(
                self.client, "The link cannot be opened", error.message, stays=True
            )
            return False
        if state.missing:
            notices.notify_missing(self.client, state.missing)
        if state.faults:
            notices.notify_warning(
                self.client, "Part of the link is left out", " ".join(state.faults), stays=True
            )
        state = replace(state, scene=self._budget.fitting(state.scene))
        self._view.restore(state)
        self._scene = state.scene
        return True

    def _mirror(self, classroom: ClassroomPanel) -> bool:
        """Show what the teacher has sent; whether there is another scene to plan."""
        view = classroom.view()
        if view is not None:
            view = replace(view, scene=self._budget.fitting(view.scene))
            before, self._scene = self._scene, view.scene
            self._view.mirror(before, view)
            return view.scene != before
        return False

    @property
    def _shared(self) -> SharedPlans | None:
        """Plans shared with other tabs: of the teacher's scene, or of this tab's first one."""
        of_class = None if self._class is None else self._class.shared_plans(self._scene)
        opened = self.plans == 0 or self._scene is self._first
        return self._opening if of_class is None and opened else of_class

    def _follow(self, cue: Cue) -> bool:
        """Show what a lesson or a figure sets; whether there is another scene to plan."""
        if not self._demonstrated:
            self.panels.history.note(self.panels.step(self._scene))
        own = replace(self._state(), scene=self.panels.history.noted)
        cue = replace(cue, scene=self._budget.fitting(cue.scene))
        before, self._scene = self._scene, cue.scene
        self._view.follow(cue, own)
        return cue.scene != before

    def _state(self) -> TabState:
        """State for the page to store."""
        return self._view.state(self._scene, self.frame.time)

    def _replan(self, scene: Scene) -> Plan:
        """Plan another scene, with the last plan in grey if that may take long.

        One that a teacher shows has been planned already.
        """
        # a scene noted before is gone back to, with the camera as it is
        leg = self.panels.messages.legs.begins(scene)
        new = not leg and scene is not self.panels.history.noted
        loaded = new and self.panels.files.loaded is scene
        grown = scene.arm is not self._scene.arm and oversize(scene) != oversize(self._scene)
        if scene.workspace != self._scene.workspace or loaded or grown:
            self._view.look_at(scene)
        self._scene = scene
        if self.plans == 0:
            self._first = scene
        if (checked := self._check(scene)) is not None:
            return checked
        if (known := self.panels.messages.legs.planned(scene)) is not None:
            self._planner.live.adopt(scene)
            return known
        shared = self._shared
        if shared is not None and (made := self._planner.take(scene, shared)) is not None:
            return made
        if loaded and self.plans:
            # nothing that is told of the last scene is true of this one, nor of the right size
            self.playback.restore(0.0, self.playback.playing)
            frame = replace(self.frame, plan=Plan(scene), reason=None, coarse=False, partial=False)
            self._view.draw(replace(frame, outdated=True))
        elif self._planner.processor_ms > SLOW_MS:
            self._draw(replace(self.frame, outdated=True))
        elif self.plans:
            self._overdue = replace(self.frame, outdated=True)
        try:
            # what of a leg came later would move the arm while it plays
            return self._planner.finish(scene, shared) if leg else self._planner(scene, shared)
        finally:
            self._overdue = None

    def _check(self, scene: Scene) -> Plan | None:
        """The checked motion in place of a plan; None if the tab shows its own plan."""
        if self.panels.check.has_motion:
            self._planner.live.adopt(scene)
            if self.frame.checked is None:
                self.panels.messages.wait("Checking the motion")
            elif self.panels.check.processor_ms > SLOW_MS:
                self._draw(replace(self.frame, outdated=True))
        return self.panels.check.plan(scene)

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
        live = self._planner.live
        self._view.face(plan)
        frame = replace(frame, coarse=live.coarse, partial=live.partial, interactive=interactive)
        demonstrates = self._pause.demo.running
        self._draw(replace(frame, outdated=False, demonstrates=demonstrates))
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
            self.panels.history.note(self.panels.step(self._scene), self._woken)
        if self._planner.live.partial:
            self._complete()
            return
        if not self.panels.held:
            self._view.viewpoint.follow()
        if self.frame.interactive:
            self._draw(replace(self.frame, interactive=False))
        frame = self._pause.use(self.frame, self._scene)
        if frame.plan is not self.frame.plan:
            self._show(frame.plan)
        elif frame is not self.frame:
            self._draw(frame)

    def _complete(self) -> None:
        """Plan in full; of a class in which all tabs need the plan, the first makes it."""
        shared = self._shared
        with contextlib.nullcontext(True) if shared is None else shared.claim(self._scene) as mine:
            if not mine:
                return
            if self._planner.live.coarse:
                self._draw(replace(self.frame, outdated=True))
            self._show(self._planner.finish(self._scene, shared))
