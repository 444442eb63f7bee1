"""View of one tab: panels, layers, playback and camera, drawn and restored as one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import viser

from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.camera.camera import Viewpoint
from app.camera.extent import extent
from app.camera.view import View
from app.drawing.box import box_corners
from app.layers.catalogue import DETAILS, LAYERS, SLOW_LAYERS
from app.layers.details import lagging
from app.panels.all_panels import AllPanels
from app.panels.playback import PlaybackPanel
from app.panels.teach.classroom import ClassroomPanel
from app.panels.teach.exercise import ExercisePanel
from app.panels.widgets import Wake
from app.process.turns import TURNS
from app.state.frame import Draw, Frame
from app.state.legend import SHOWN
from app.state.tab_state import TabState
from app.tab.browser_storage import Report
from app.teach.classroom import Classroom
from app.teach.exercise_watch import ExerciseWatch
from app.teach.lesson import Library, Setting
from app.ui import notices
from app.ui.page_area import Area, label_scale, shows_plots
from app.ui.panel_folding import folding


class TabView:
    """Panels, layers, playback and viewpoint of a tab.

    Attributes:
        panels: all panels but the playback.
        layers: what draws each layer.
        parts: all that draws a frame: at once, and after that what takes longer.
        viewpoint: the tab's camera.
        classroom: panel of the class that the tab has joined; None for none.
        exercise: panel of a student's file; None for none.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        name: str,
        scene: Scene,
        wake: Wake,
        dark: bool,
        library: Library,
        area: Area,
        overtaken: Callable[[], bool],
    ) -> None:
        """Add panels and layers, in the order of the page where they share a tab or a folder.

        What takes long to draw waits once the frame is ``overtaken`` by another choice.
        """
        self._client = client
        self._area = area
        self.viewpoint = Viewpoint(client.camera, scene)
        self._to_face = True
        self._faced: Plan | None = None
        self._surrounded: tuple[Plan, bool] | None = None
        self._arm: object = self
        self._before: TabState | None = None
        self._rested: Plan | None = None
        self._rested_before: Plan | None = None
        self.classroom: ClassroomPanel | None = None
        self.exercise: ExercisePanel | None = None
        self.panels = AllPanels(client, name, scene, wake, dark, library)
        left, right = self.panels.layout.panels
        self._foldings = folding(left, is_left=True), folding(right, is_left=False)
        self.layers = {layer: layer(self.panels.layout) for layer in (*LAYERS, *SLOW_LAYERS)}
        with self.panels.layout.result:
            self.playback = PlaybackPanel(client.gui, self.panels.layout.overlay, wake)
        drawn = (*self.panels.drawn, *(self.layers[layer] for layer in LAYERS))
        may_lag = (self.panels.stages.draw, *(self.layers[layer] for layer in DETAILS))
        details = [draw for draw in drawn if draw in may_lag]
        others = [draw for draw in drawn if draw not in may_lag]
        self.parts: tuple[tuple[Draw, ...], ...] = (
            (*others, lagging(details, lambda: TURNS.waiting, overtaken)),
            tuple(self.layers[layer] for layer in SLOW_LAYERS),
        )

    def join(
        self,
        classroom: Classroom,
        wake: Wake,
        nudge: Callable[[], None],
        hurry: Callable[[], None],
    ) -> None:
        """Add the panel of the class that the tab joins; ``hurry`` wakes a teacher's tab."""
        with self.panels.layout.learn:
            overlay = self.panels.layout.overlay
            lessons = self.panels.lessons
            panel = ClassroomPanel(self._client, overlay, classroom, lessons, wake, nudge, hurry)
        self.classroom = panel
        self._add(panel.draw)

    def watch_exercise(self, watch: ExerciseWatch, wake: Wake, nudge: Callable[[], None]) -> None:
        """Add the panel of a student's file."""
        with self.panels.layout.learn:
            panel = ExercisePanel(self._client, watch, self.panels.theatre, wake, nudge)
        self.exercise = panel
        self._add(panel.draw)

    def _add(self, draw: Draw) -> None:
        quick, slow = self.parts
        self.parts = ((*quick, draw), slow)

    def close(self) -> None:
        """Leave the class and the student's file, and stop reading uploads."""
        for panel in (self.classroom, self.exercise, self.panels):
            if panel is not None:
                panel.close()

    def draw(self, frame: Frame) -> Frame:
        """Draw a frame at the playback's time; the frame as drawn.

        What takes the page longer comes in a message of its own, but for an arm that it has: then
        one message takes less.
        """
        quick, slow = self.parts
        same, self._arm = frame.plan.arm is self._arm, frame.plan.arm
        with self._client.atomic():
            frame = self._now(frame)
            self._fit(frame)
            for draw in (*quick, *slow) if same else quick:
                draw(frame)
        if not same:
            with self._client.atomic():
                for draw in slow:
                    draw(frame)
        return frame

    def timeout(self, frame: Frame) -> float | None:
        """Time until the next picture, [s]; None if only the page's own playback moves.

        Nor does anything follow from the time alone where nobody sees the page.
        """
        if self._is_hidden:
            return None
        times = self.panels.theatre.timeout(), self._until_contact(frame), self._until_leg(frame)
        return min((max(seconds, 0.0) for seconds in times if seconds is not None), default=None)

    def is_due(self, frame: Frame) -> bool:
        """Check whether another picture is due after a wait for :meth:`timeout`."""
        if self._is_hidden:
            return False
        left = self._until_contact(frame)
        return self.panels.theatre.timeout() is not None or (left is not None and left <= 0)

    def leg_is_over(self, frame: Frame) -> bool:
        """Check whether the motion of ``frame`` has been played, and another leg follows."""
        left = None if self._is_hidden else self._until_leg(frame)
        return left is not None and left <= 0

    def seek_leg(self) -> None:
        """Ask for the leg to which the player's slider was set, if another one is shown."""
        if (time := self.playback.sought()) is not None:
            self.panels.messages.legs.seek(time)

    @property
    def _is_hidden(self) -> bool:
        area = self._area()
        return area is not None and area.hidden

    def _until_contact(self, frame: Frame) -> float | None:
        """Time until other links of the playing arm turn red, [s]; None if none ever do."""
        return self.playback.until_contact(frame.duration) if self.playback.playing else None

    def _until_leg(self, frame: Frame) -> float | None:
        """Time until the next leg is to be shown, [s]; None if none is, as while a hand drags."""
        if self.panels.held or frame.interactive or not self._plays_on(frame):
            return None
        return self.playback.until_end(frame.duration)

    def _plays_on(self, frame: Frame) -> bool:
        follows = self.classroom is not None and not self.classroom.teaches  # the teacher's tab
        return not follows and self.panels.messages.legs.plays_on(frame)

    def _now(self, frame: Frame) -> Frame:
        """The frame at the present time of playback and search, with the plan before its own."""
        frame = replace(frame, before=self._plan_before(frame))
        legs = self.panels.messages.legs
        legs.see(frame)
        again = not self._plays_on(frame)
        frame = replace(frame, again=again)
        bar = legs.begins_on_bar(frame)
        now = self.playback.advance(frame.duration, again, bar, (legs.number or 0) if bar else 0)
        playing, rate = self.playback.playing, self.playback.rate
        scale = label_scale(self._area(), frame.lecture)
        frame = replace(frame, time=now, playing=playing, rate=rate, label_scale=scale)
        frame = replace(frame, plots=shows_plots(self._area()))
        frame = replace(frame, bent=self.panels.control.bent(frame))
        if self.classroom is not None:
            self.classroom.hold_back(self.panels.theatre)
        theatre = self.panels.theatre.advance(frame)
        told = frame.lecture or frame.lesson  # what is shown is chosen for the student
        hidden = theatre is not None or (told and "arm" not in frame.shown)
        stretches = () if frame.checked is None else frame.checked.stretches
        plan = frame.plan
        self.playback.mark(
            plan.arm_clearance, frame.duration, not hidden, stretches, plan.held_spans
        )
        bases = self.panels.stages.bases.found(frame.plan.scene)
        return replace(frame, theatre=theatre, bases=bases)

    def _plan_before(self, frame: Frame) -> Plan | None:
        """The last plan at rest before that of a frame, which is kept once it rests itself."""
        if frame.plan is not self._rested:
            self._rested_before = self._rested
            if not (frame.interactive or frame.plan.partial or frame.outdated):
                self._rested = frame.plan
        return self._rested_before

    def _fit(self, frame: Frame) -> None:
        """Adapt panels and camera to lecture mode, or end that."""
        for fold in self._foldings:
            fold(self._area(), frame.lecture)
        # stages that do not show the arm need no room for it
        alone = frame.stage not in ("", "arm")
        surrounded = (frame.plan, alone) if frame.lecture else None
        if not frame.lecture:
            self.viewpoint.surround(None)
        elif surrounded != self._surrounded:
            workspace = frame.plan.scene.workspace
            corners = box_corners(workspace.min, workspace.max)
            self.viewpoint.surround(corners if alone else extent(frame.plan), wide=alone)
        self._surrounded = surrounded

    def fit(self, frame: Frame, touched: bool) -> bool:
        """Adapt panels and camera to the page's size; whether ``frame`` must be drawn anew.

        Once a hand has ``touched`` the page, no text about a scene moves its camera. The page's own
        words are no hand, nor is the demonstration.
        """
        if touched:
            self._faced = None
        area = self._area()
        for fold in self._foldings:
            fold(area, self.panels.lecture.on)
        arrives = self._faced is not None and (frame.plan is self._faced or frame.demonstrates)
        self.viewpoint.fit(area, arrives=arrives)
        shown = label_scale(area, frame.lecture), shows_plots(area)
        return shown != (frame.label_scale, frame.plots)

    def take(self, report: Report, dark: bool | None) -> None:
        """Apply what the browser remembers, and the system's colours unless ``dark`` is given."""
        if dark is None:
            self.panels.layer_switches.restore(None, report.dark)
        self.panels.lessons.recall(report.lessons)

    def face(self, plan: Plan) -> None:
        """Turn the camera to a side from which a scene's first plan is seen well."""
        if self._to_face and plan.bspline is not None:
            self._to_face, self._faced = False, plan
            self.viewpoint.face(plan)

    def look_at(self, scene: Scene, face: bool = True) -> None:
        """Show another scene; with ``face`` the camera turns to its curve once planned."""
        self.viewpoint.show(scene)
        self._to_face = face

    def restore(self, state: TabState) -> None:
        """Show what a tab showed before."""
        self.panels.restore(state)
        self.viewpoint.show(state.scene)
        if state.view is not None:
            self._to_face = False
            self.viewpoint.take(state.view)
        self.playback.restore(state.time, state.playing)
        self.panels.history.begin(self.panels.step(state.scene))
        if state.before is not None:
            self.panels.figures.restore(state.figure)
            # of a lesson that this server does not have there is no end
            if self.panels.lessons.progress.chosen or self.panels.figures.number:
                self._before = state.before

    def mirror(self, own: Scene, state: TabState) -> None:
        """Show what another tab shows instead of ``own``, changing only what differs."""
        before = self.panels.step(own)
        self.panels.restore(state)
        if self.panels.lessons.follow(state.lessons):
            self._before = None  # undo leads there
        self.viewpoint.mirror(state.scene, state.view)
        self._to_face &= state.view is None
        self.playback.follow(state.time, state.playing)
        self.panels.history.follow(before, self.panels.step(state.scene))

    def follow(self, setting: Setting, scene: Scene, before: TabState) -> None:
        """Show what a lesson or a figure sets.

        Args:
            setting: layers, camera, search and time.
            scene: that results from it.
            before: what is shown now, to which :meth:`go_back` leads unless an earlier one waits.
        """
        self._before = self._before or before
        self.panels.follow(setting, scene)
        if setting.scene is not None:
            self.look_at(scene, setting.camera is None)
        if setting.camera is not None:
            self.viewpoint.take(setting.camera)
        if setting.time is not None or setting.play is not None:
            self.playback.restore(setting.time or 0.0, bool(setting.play))

    def go_back(self, scene: Scene) -> Scene:
        """Show what was shown before a lesson or a figure; the scene to plan.

        Who came by a link had none: then ``scene``, with the layers of a new tab.
        """
        before, self._before = self._before, None
        if before is not None:
            self._client.add_notification(
                "Your scene is back", "Undo returns to the other one.", auto_close_seconds=5
            )
        state = before or replace(self.state(scene, 0.0), shown=SHOWN, view=None, theatre="")
        if state.missing:
            notices.notify_missing(self._client, state.missing)
        self.panels.go_back(state)
        self.look_at(state.scene, state.view is None)
        if state.view is not None:
            self.viewpoint.take(state.view)
        self.playback.restore(state.time, state.playing)
        return state.scene

    def state(self, scene: Scene, time: float) -> TabState:
        """State for the page to store; without the arm's position while it moves."""
        playing = self.playback.playing
        return TabState(
            name=self.panels.files.name,
            scene=scene,
            view=View.of_camera(self._client.camera),
            time=0.0 if playing else time,
            playing=playing,
            shown=self.panels.layer_switches.shown(),
            dark=bool(self.panels.layer_switches.dark.value),
            lessons=self.panels.lessons.progress.kept,
            challenge=self.panels.share.kept,
            tasks=self.panels.messages.legs.kept,
            theatre=self.panels.theatre.kept,
            practice=self.panels.practice.kept,
            before=self._before,
            figure=self.panels.figures.number,
        )
