"""All panels of a tab except the playback: built in the order of the page, read as one."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import viser

from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.mesh_source import Files
from abi.scene.scene import Scene
from abi.scene.without_obstacles import without_obstacles
from app.panels.files.bug_report import add_bug_report_button
from app.panels.files.check_motion import CheckMotionPanel
from app.panels.files.exports import add_export
from app.panels.files.files import FilesPanel
from app.panels.files.history import History, HistoryStep
from app.panels.files.share import SharePanel
from app.panels.layer_switches import LayerSwitches
from app.panels.messages import Messages
from app.panels.obstacles.control_handles import ControlHandles
from app.panels.obstacles.end_gizmos import EndGizmos
from app.panels.obstacles.obstacle_editor import ObstacleEditor
from app.panels.obstacles.obstacle_gizmos import ObstacleGizmos
from app.panels.stages.stages import StagePanels, stage_folders
from app.panels.stages.studies import studies
from app.panels.teach.figures import FiguresPanel
from app.panels.teach.lecture import Lecture
from app.panels.teach.lessons import LessonPanel
from app.panels.teach.practice import PracticePanel
from app.panels.teach.search_theatre import TheatrePanel
from app.panels.teach.sheet import ABOUT, KEYS, sheet
from app.panels.teach.tour import tour
from app.panels.toolbar import toolbar
from app.panels.widgets import Wake, hidden_button
from app.state.frame import Draw, Frame
from app.state.tab_state import TabState
from app.teach.challenge import parsed
from app.teach.lesson import Library, Setting
from app.ui import style
from app.ui.arm_size import MADE_FOR_ARMS
from app.ui.layout import Layout


class AllPanels:
    """The panels, and the layout that they leave to the layers.

    Attributes:
        layout: of the tab.
        drawn: what shows a frame, of the panels that do.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        name: str,
        scene: Scene,
        wake: Wake,
        dark: bool,
        library: Library,
    ) -> None:
        self._client = client
        self.layout = Layout.of(client, scene.unit, stage_folders(client.gui))
        self.stages = StagePanels(self.layout, scene, wake)
        self.layer_switches = LayerSwitches(self.layout, wake, dark)
        self.obstacles = ObstacleGizmos(client, scene, wake)
        self.ends = EndGizmos(client, scene, wake)
        self.control = ControlHandles(client, wake)
        with self.layout.search:
            self.theatre = TheatrePanel(client, wake)
            self._draw_studies = studies(client.gui, wake)
        with self.layout.scene:
            self.files = FilesPanel(client, name, scene, wake)
            client.gui.add_html(style.heading("Points and obstacles"))
            self.editor = ObstacleEditor(client, self.obstacles, self.ends, wake)
            client.gui.add_html(style.heading("Share and export"))
            self.share = SharePanel(client, self.layout.overlay, wake)
            self.export_format, self.export = add_export(client.gui, wake)
            self.bug_report = add_bug_report_button(client.gui, wake)
        with self.layout.plots:
            self.check = CheckMotionPanel(client, scene, wake)
        self.history = History(client.gui, self.step(scene), wake)
        with self.layout.learn:
            self.lessons = LessonPanel(client, library, wake, lambda: self.held)
            self.practice = PracticePanel(client.gui, wake)
            self.figures = FiguresPanel(client.gui, wake)
        self.messages = Messages(
            self.layout,
            self.stages.bases,
            self.lessons,
            self.share,
            self.check,
            self.history.undo,
            wake,
        )
        self.open_keys = hidden_button(client.gui, "Show the keys", wake)
        self.open_about = hidden_button(client.gui, "What is this?", wake)
        self.begin_tour = hidden_button(client.gui, "Tour", wake)
        self.lecture = Lecture(self.layout, self.theatre, wake)
        self._inputs = (self.stages, self.obstacles, self.ends)
        self._typed = True
        self.refused: AbiError | None = None
        self.drawn = self._draws(wake)

    def _draws(self, wake: Wake) -> tuple[Draw, ...]:
        """What shows something of a frame, panel by panel, in their order."""
        layout, gui = self.layout, self._client.gui
        begin_tour, about = self.begin_tour, self.open_about
        return (
            self.messages.draw,
            toolbar(layout, self.history, about, begin_tour, self.lecture),
            tour(layout, begin_tour, wake),
            self.lecture.draw,
            self.stages.draw,
            self.stages.draw_inputs,
            self.stages.bases.draw,
            self.stages.arm.draw,
            self.ends.draw,
            self.control.draw,
            self.obstacles.draw,
            self.files.draw,
            self.check.draw,
            self.editor.draw,
            self.layer_switches.draw,
            self._draw_studies,
            self.lessons.draw,
            self.practice.draw,
            self.figures.draw,
            self.share.draw,
            sheet(gui, wake, self.open_keys, "Keys", KEYS, "H"),
            sheet(gui, wake, about, "What is this?", ABOUT),
        )

    def close(self) -> None:
        """Stop reading uploads, because the tab is closed."""
        arms = self.stages.arm.model
        for panel in (self.files, self.check, self.editor, arms):
            panel.uploads.close()

    @property
    def held(self) -> bool:
        """Whether the user drags an obstacle or an end: a drag is one change in the history."""
        return self.obstacles.held or self.ends.held

    def note(self, event: object) -> None:
        """Take note of an input, from any thread.

        A hand that drags sends twenty a second, none of which changes what the stages' widgets
        show: they are read again only after another.
        """
        moved = event.target if isinstance(event, viser.TransformControlsEvent) else None
        gizmos = (*self.obstacles.gizmos, *self.ends.gizmos.values())
        if moved is None or all(gizmo is not moved for gizmo in gizmos):
            self.read_all()

    def chooses(self, event: object) -> bool:
        """Check whether an input chooses another scene, arm or file, from any thread.

        What is planned until then is not wanted any more.
        """
        target, model = getattr(event, "target", None), self.stages.arm.model
        files = self.files.choice, self.files.reset, self.files.upload
        choosers = (*files, model.model, model.upload, self.lessons.choice)
        return any(target is one for one in (*choosers, self.history.undo, self.history.redo))

    def read_all(self) -> None:
        """Read every widget the next time: the scene may not have what they show."""
        self._typed = True

    def read(self, scene: Scene) -> Scene:
        """Read the scene that the panels show; only what differs from ``scene`` is checked.

        A section that is refused stays as it was, and so does an obstacle: all others count, so
        that a drag goes on beside a field that was typed wrongly. ``refused`` says why.

        Args:
            scene: the last valid one.

        Raises:
            AbiError: it is neither a section nor an obstacle that is refused.
        """
        if typed := self._typed:
            self._typed = False  # before they are read: what is typed meanwhile counts next time
        self.refused = None
        try:
            return self._read(scene, typed)
        except AbiError:
            self.read_all()
            raise
        finally:
            if self.refused is not None:
                self.read_all()
            self._pause_challenge()

    def _pause_challenge(self) -> None:
        """End the challenge, or put it aside while another scene is shown than its own."""
        self.share.end_if_requested()
        challenge, told = (
            self.share.challenge,
            self.lessons.progress.chosen or self.figures.number > 0,
        )
        other = challenge is not None and challenge.scene != self.files.name
        self.share.paused = told or other

    def _read(self, scene: Scene, typed: bool) -> Scene:
        """Read what is posed and, where it was used, what is ``typed`` or chosen."""
        shown = self.step(scene)
        requested = self.files.requested(self.editor.meshes(scene))
        if self.messages.asks_for_other_scene():
            requested = self.files.open_shipped(MADE_FOR_ARMS)
        leg = self.messages.legs.requested()
        requested = leg if requested is None else requested
        for panel in (self.messages, self.stages.bases):
            if requested is None and (change := panel.accepted_change()) is not None:
                requested = scene.replace(**change)
        if requested is None and (step := self.history.requested(shown)) is not None:
            self.show(step)
            return step.scene
        if requested is not None:
            self.history.note(shown)  # it may not have been left alone for a moment
            self._write(requested)
            return requested
        if (number := self.messages.pointed_out()) is not None:
            self.obstacles.point_out(number)
        try:
            self.editor.apply(scene)
        except SceneError as error:
            self.refused = error
        if (number := self.editor.removed()) is not None:
            self.stages.arm.model.forget_obstacle(number)
            scene = scene.replace(**without_obstacles(scene, (number,)))
        inputs = self._inputs if typed else (self.obstacles, self.ends)
        sections = {name: part for panel in inputs for name, part in panel.read().items()}
        files: Files = {**self.editor.surfaces, **self.stages.arm.model.files}
        try:
            return scene.replace(files, **sections)
        except AbiError as error:
            self.refused = self.refused or error
        scene = self.obstacles.accept(scene, files)
        for name, section in sections.items():
            if name == "obstacles":
                continue
            with contextlib.suppress(AbiError):
                scene = scene.replace(files, **{name: section})
        return scene

    def step(self, scene: Scene) -> HistoryStep:
        """Step that the history is to note of ``scene``, which is shown."""
        return HistoryStep(scene, self.files.name, self.files.loaded)

    def show(self, step: HistoryStep) -> None:
        """Show a scene of before, and what it was made from."""
        self.files.show(step.name, step.loaded)
        self._write(step.scene)

    def refuse(self, error: AbiError) -> None:
        """Leave what is typed as it is, to be read again, and say why it does not count."""
        self.refused = error
        self.read_all()

    def cue(self, scene: Scene) -> tuple[Setting, Scene] | None:
        """Setting of a lesson or a figure now and its scene, from ``scene`` on; None for none."""
        return self.lessons.cue(scene) or self.figures.cue(scene) or self.practice.cue()

    def follow(self, setting: Setting, scene: Scene) -> None:
        """Show a scene, and a setting's layers and search."""
        self._write(scene)
        if setting.shown is not None:
            self.layer_switches.restore(frozenset(setting.shown), None)
        if setting.search is not None:
            self.theatre.set(**setting.search.model_dump(exclude_none=True))
        if setting.bend is not None:
            self.control.move(setting.bend)

    def left(self) -> bool:
        """Check whether a lesson or the figures were left since the last call."""
        left = [self.lessons.left(), self.figures.left(), self.practice.left()]
        return any(left)

    def go_back(self, state: TabState) -> None:
        """Show the scene, layers and search that a lesson or a figure replaced."""
        self.figures.close()
        self.files.restore(state.name, state.scene)
        self.layer_switches.restore(state.shown, None)
        self.theatre.restore(state.theatre)
        self._write(state.scene)

    def restore(self, state: TabState) -> None:
        """Show what a tab showed before."""
        self.files.restore(state.name, state.scene)
        self.layer_switches.restore(state.shown, state.dark)
        self.lessons.restore(state.lessons)
        self.theatre.restore(state.theatre)
        self.practice.restore(state.practice)
        self.messages.legs.restore(state.tasks)
        if state.challenge != self.share.kept:
            challenge = parsed(state.challenge)
            if challenge is not None and not challenge.scene:
                challenge = challenge.model_copy(update={"scene": self.files.name})
            self.share.challenge = challenge
        self._write(state.scene)

    def apply_switches(self, frame: Frame) -> Frame:
        """The frame as the switches have it."""
        shown = self.lecture.shown(self.layer_switches.shown())
        if self.lecture.shows_search and not self.lessons.progress.chosen:
            shown = self.theatre.uncovered(shown)
        return replace(
            frame,
            shown=shown,
            lesson=self.lessons.progress.chosen,
            asks=self.lessons.progress.asks,
            lecture=self.lecture.on,
            stage=self.lecture.stage,
            mesh_view=self.layer_switches.chosen_mesh_view(),
            visited=self.stages.visited_nodes(),
        )

    def _write(self, scene: Scene) -> None:
        """Show another scene."""
        self.read_all()
        with self._client.atomic():
            for panel in self._inputs:
                panel.write(scene)
            self.editor.write(scene)
