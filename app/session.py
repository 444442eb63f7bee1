"""One browser tab: its worker thread reads the panels, plans what changed, and draws the frame.

Callbacks only wake the worker. It gives one frozen :class:`Frame` to every layer and panel inside
an ``atomic`` block. Only the newest input is planned; what came before it is skipped.
"""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import replace

import viser

from abi import assets, compiling
from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.diagnosis import explain
from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app import memory, metrics, page
from app.bug_report import bug_report, describe_fault
from app.classroom import Classroom
from app.demo import FRAME, Demo
from app.frame import Frame
from app.labels import sentence
from app.layout import TITLE
from app.lessons.cue import Cue
from app.lessons.lesson import Library
from app.look import Look
from app.panels.classroom import ClassroomPanel
from app.shared_plans import SharedPlans
from app.tab_memory import Report, TabMemory
from app.tab_state import TabState
from app.tab_view import TabView
from app.turns import TURNS

_log = logging.getLogger("abi.tab")

SLOW_MS = 120.0
"""Where the last plan took longer, it is drawn in grey while the next is made."""
LOGGED_MS = 1000.0
"""A plan that takes longer has a line in the log."""
REST = 0.3
"""Seconds without input that make a pause: time to plan in full, and to diagnose."""
IDLE = 1.0
"""Seconds after which an idle tab looks whether the hand has moved its camera."""
UNUSED = 300.0
"""Seconds without input after which a tab gives back what it keeps only to plan faster."""
PHONE = 600
"""Width of a page, [px], below which viser makes the panels one sheet over the scene."""
NARROW = 1000
"""Width of a page, [px], below which both panels would leave the scene little room."""
LIGHTS_DELAY = 1.5
"""Seconds in which even weak graphics have drawn the first plan."""


class Session:
    """State and worker of one tab; nothing is shared with another.

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
        look: Look,
        planned: threading.Event,
        library: Library,
        classroom: Classroom | None = None,
    ) -> None:
        """Build the tab and start its worker; sets ``planned`` whenever a plan has been drawn."""
        self.client = client
        self.frame = Frame(Plan(scene))
        self.plans = 0
        self._scene = scene
        self._planner = LivePlanner(compile=False)
        self._last_input = self._woken = 0.0
        self._diagnosed: Plan | None = None
        self._fault: str | None = None
        self._broken = False
        self._changed = threading.Event()
        self._planned = planned
        self._closing = False
        self._has_lights = look.plain
        self._has_memory = True
        self._compiled = compiling.is_done()
        page.install(client)
        self._memory = TabMemory(client, self.wake)
        self._look = look
        with client.atomic():
            self._view = TabView(client, name, scene, self.wake, bool(look.dark), library)
            self.panels, self.playback = self._view.panels, self._view.playback
            self._class: ClassroomPanel | None = None
            if classroom is not None:
                self._class = self._view.join(classroom, self.wake, self._changed.set)
        self._demo = Demo(self.panels.obstacles)
        self._demonstrated = False  # whether the scene is where the demonstration left it
        self._changed.set()
        self._worker = threading.Thread(
            target=self._work, name=f"tab-{client.client_id}", daemon=True
        )
        self._worker.start()
        self._opened = time.monotonic()
        metrics.SESSIONS.inc()
        metrics.TABS.inc()
        _log.info("tab opened", extra={"tab": client.client_id})

    def close(self) -> None:
        """End the worker of a closed tab."""
        if self._closing:
            return
        self._closing = True
        if self._class is not None:
            self._class.close()
        self._changed.set()
        if threading.current_thread() is not self._worker:
            self._worker.join(timeout=5)
        metrics.TABS.dec()
        memory.give_back_soon()
        seconds = time.monotonic() - self._opened
        fields = {"tab": self.client.client_id, "seconds": seconds, "plans": self.plans}
        _log.info("tab closed", extra=fields)

    def tell_end(self) -> None:
        """Tell the tab that the server is about to stop."""
        self.client.add_notification(
            "The server has stopped",
            "This tab keeps its scene. Once the server runs again, the page connects by itself.",
            color="yellow",
            auto_close_seconds=None,
        )
        self.client.flush()

    @property
    def plan(self) -> Plan | None:
        """The plan drawn last; None before the first."""
        return self.frame.plan if self.plans else None

    @property
    def resting(self) -> bool:
        """Whether the plan is complete, all of it is drawn, and no input is waiting."""
        waiting = self.frame.interactive or self.frame.partial or self._changed.is_set()
        return self.plans > 0 and not waiting

    def wake(self, event: object) -> None:
        """Wake the worker after an input: the callback of every widget.

        What the worker writes into a widget comes back here too, without a client. Not ``async``:
        viser leaves coroutines behind when it stops.
        """
        if getattr(event, "client", None) is not None:
            if not self._changed.is_set():
                self._woken = time.monotonic()
            self._changed.set()

    def _work(self) -> None:
        """Plan and draw until the tab is closed: the worker's thread."""
        self._memory.wait()
        while True:
            self._changed.wait(self._timeout())
            if self._closing:
                return
            with TURNS:
                # not what wait() returned: the input may have come while it gave up
                if woken := self._changed.is_set():
                    self._changed.clear()
                try:
                    self._step(woken)
                except Exception as error:
                    self._recover(error)

    def _step(self, woken: bool) -> None:
        """Do what there is to do: on input, in a pause, and for the playback."""
        self._view.viewpoint.fit()
        if woken:
            self._demonstrated = self._demo.running
            self._demo.end()
            self._broken = False
            self._has_memory = True
            self._last_input = time.monotonic()
            self._update()
        elif self._demo.running:
            self._demo.step()
            self._last_input = time.monotonic()
            self._update()
        elif not self._broken:
            if time.monotonic() - self._last_input >= REST:
                self._use_pause()
            if self._view.timeout(self.frame) is not None:
                self._draw(self.frame)
        if not self._demo.running:
            state = self._state()
            self._memory.keep(state)
            if self._class is not None:
                self._class.publish(state)

    def _recover(self, error: Exception) -> None:
        """Go back to the last plan after a fault of our own, and say so, until there is input."""
        self._broken = True
        self._scene = self.frame.plan.scene
        self._fault = describe_fault(error)
        metrics.FAULTS.inc()
        _log.exception("fault", extra={"tab": self.client.client_id})
        sentence = (
            "There was not enough memory for this; a coarser mesh takes less."
            if isinstance(error, MemoryError)
            else "The visualiser met a fault of its own. The Scene tab has a text for a bug report."
        )
        page.notify_refusal(self.client, "This did not work", f"{sentence} The last picture stays.")

    def _timeout(self) -> float:
        """Time to wait for input, [s]."""
        if self._broken:
            return IDLE
        if self._demo.running:
            return FRAME
        incomplete = self.frame.interactive or self.frame.partial or self._undiagnosed()
        idle = self._has_lights and self._compiled and not incomplete and not self._demo.wanted
        pending = (self._view.timeout(self.frame), self.panels.stages.bases.timeout())
        due = [seconds for seconds in pending if seconds is not None]
        return min(due, default=IDLE if idle else REST)

    def _update(self) -> None:
        """Plan and draw what the panels show."""
        report = self._memory.report()
        restored = report is not None and self._restore(report)
        shared: SharedPlans | None = None
        if self._class is not None:
            if report is not None:
                self._class.recognise(report.query.get("teach", ""))
            if view := self._class.view():
                restored |= self._restore(Report(state=view))
                shared = self._class.plans
        if (cue := self.panels.cue(self._scene)) is not None:
            restored |= self._follow(cue)
        elif self.panels.left():
            before, self._scene = self._scene, self._view.go_back(self._scene)
            restored |= self._scene != before
        if (direction := self.panels.lecture.requested_view()) is not None:
            self._view.viewpoint.look_from(direction)
        try:
            scene = self._read()
        except AbiError as error:
            # the last valid scene stays, to be looked at and saved
            self._draw(replace(self.panels.apply_switches(self.frame), refused=error))
        else:
            self.frame = replace(self.frame, refused=None)
            if self.plans == 0 or restored or scene != self._scene:
                self._show(self._replan(scene, shared), interactive=True)
            else:
                self._show(self.frame.plan, interactive=True)
        self.panels.files.save_if_requested(self._scene)
        self.panels.share.share(self._state(), self.frame)
        if self.panels.exports.requested:
            self._export()
        if self.panels.bug_report.requested:
            self.panels.bug_report.send(bug_report(self.frame, self._fault))

    def _export(self) -> None:
        """Send the plan as a file, in full."""
        if self._planner.partial:
            self._show(self._observed(self._planner.finish(self._scene)))
        self.panels.exports.send(self.frame.plan)

    def _read(self) -> Scene:
        """Read the panels; what is refused but once, as a file is, is told of and left.

        Raises:
            SceneError: what they show is no scene.
        """
        try:
            return self.panels.read(self._scene)
        except AbiError as error:
            scene = self.panels.read(self._scene)
            page.notify_refusal(self.client, "Not changed", sentence(error))
            return scene

    def _restore(self, report: Report) -> bool:
        """Bring back what the page or a link remembers; False where that is nothing."""
        if self._look.dark is None:
            self.panels.layer_switches.restore(None, report.dark)
        if report.width < PHONE:
            page.fold_sheet(self.client, TITLE)
        elif report.width < NARROW:
            self.panels.fold()
        self.panels.lessons.recall(report.lessons)
        if not report.state:
            self._demo.wanted = self._look.demo and report.query.get("demo") != "0"
            return False
        meshes = MeshSource(self._scene.meshes.files, assets.path("scenes"))
        try:
            state = TabState.decode(report.state, meshes)
        except SceneError as error:
            page.notify_refusal(self.client, "The link cannot be opened", error.message)
            return False
        if state.missing:
            page.notify_missing(self.client, state.missing)
        self._view.restore(state)
        self._scene = state.scene
        return True

    def _follow(self, cue: Cue) -> bool:
        """Show what a lesson or a figure sets; whether there is another scene to plan."""
        if not self._demonstrated:
            self.panels.history.note(self._scene)
        own = replace(self._state(), scene=self.panels.history.noted)
        before, self._scene = self._scene, cue.scene
        self._view.follow(cue, own)
        return cue.scene != before

    def _state(self) -> TabState:
        """State that the page is to remember."""
        return self._view.state(self._scene, self.frame.time)

    def _replan(self, scene: Scene, shared: SharedPlans | None) -> Plan:
        """Plan another scene, with the last plan in grey where that may take long.

        One that a teacher shows may be among ``shared``.
        """
        if scene.workspace != self._scene.workspace or self.panels.files.loaded is scene:
            self._view.look_at(scene)
        self._scene = scene
        if shared is not None and (made := shared.find(scene)) is not None:
            self._planner.adopt(scene)
            return made
        if self.frame.plan.total_ms > SLOW_MS:
            self._draw(replace(self.frame, outdated=True))
        plan = self._observed(self._planner(scene))
        if shared is not None and not self._planner.partial:
            shared.keep(plan)
        return plan

    def _observed(self, plan: Plan) -> Plan:
        """The plan, counted."""
        metrics.observe_plan(plan.total_ms / 1e3, self.frame.plan.ms, plan.ms)
        if plan.total_ms > LOGGED_MS:
            nodes = 0 if plan.mesh is None else len(plan.mesh.points)
            _log.info(
                "slow plan",
                extra={"tab": self.client.client_id, "ms": plan.total_ms, "nodes": nodes},
            )
        return plan

    def _show(self, plan: Plan, interactive: bool = False) -> None:
        """Draw a plan; ``interactive`` while the input may still change."""
        frame = self.panels.apply_switches(self.frame)
        if plan is not frame.plan:
            frame = replace(frame, plan=plan, reason=None)
        coarse, partial = self._planner.coarse, self._planner.partial
        self._view.face(plan)
        frame = replace(frame, coarse=coarse, partial=partial, interactive=interactive)
        self._draw(replace(frame, outdated=False))
        if interactive and self.plans:
            metrics.UPDATES.observe(time.monotonic() - self._woken)
        self.plans += 1
        self._planned.set()

    def _draw(self, frame: Frame) -> None:
        """Draw a frame at the time of the playback."""
        self.frame = self._view.draw(frame)
        if self.panels.lessons.waiting:
            self._changed.set()

    def _use_pause(self) -> None:
        """Do one thing that takes longer than a frame, since there is no input."""
        if self._planner.partial:
            if self._planner.coarse:
                self._draw(replace(self.frame, outdated=True))
            self._show(self._observed(self._planner.finish(self._scene)))
            return
        if not self.panels.held:
            self.panels.history.note(self._scene)
        if self.frame.interactive:
            self._draw(replace(self.frame, interactive=False))
        if self._undiagnosed():
            self._diagnose()
        elif self.panels.stages.bases.running:
            self.panels.stages.bases.step(self._scene)
            self._draw(self.frame)
        elif not self._has_lights and time.monotonic() - self._last_input >= LIGHTS_DELAY:
            self._add_lights()
        elif not self._compiled and compiling.is_done():
            self._compiled = True
            if self.plans and self.frame.plan.error is None:
                self._planner = LivePlanner(compile=False)  # for the times of compiled code
                self._show(self._observed(self._planner.finish(self._scene)))
        elif self._demo.wanted and self._compiled:
            self._demo.begin(self._scene)
        elif self._has_memory and time.monotonic() - self._last_input >= UNUSED:
            self._has_memory = False
            self._planner.forget()
            memory.give_back_soon()

    def _undiagnosed(self) -> bool:
        return self.frame.plan.error is not None and self.frame.plan is not self._diagnosed

    def _diagnose(self) -> None:
        """Find out why there is no plan, until there is input."""
        plan = self.frame.plan
        reason = explain(plan.scene, plan, self._changed.is_set)
        if not self._changed.is_set():
            self._diagnosed = plan
            self._draw(replace(self.frame, reason=reason))

    def _add_lights(self) -> None:
        """Add lights and surroundings, which take weak graphics seconds to draw."""
        self._has_lights = True
        with self.client.atomic():
            self.client.scene.configure_default_lights()
            self.client.scene.configure_environment_map()
