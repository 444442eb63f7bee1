"""One browser tab: its panels, its planner, its layers, one worker thread and the playback clock.

Callbacks only wake the worker. It reads the panels, plans what changed, and draws inside one
``atomic`` block; the newest settings win, and what was overtaken is never computed.
"""

from __future__ import annotations

import functools
import logging
import threading
import time
from typing import Any

import viser

from abi import assets, compiling
from abi.errors import AbiError
from abi.planner.diagnosis import Reason, explain
from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app import page, style
from app.camera import Viewpoint
from app.formulas import with_formulas
from app.labels import as_labelled
from app.layers.arm import ArmLayer
from app.layers.curves import CurvesLayer
from app.layers.markers import MarkersLayer
from app.layers.mesh import MeshLayer
from app.layers.paths import PathsLayer
from app.layers.plots import PlotsLayer
from app.layers.search_order import SearchOrderLayer
from app.layers.tables import TablesLayer
from app.layers.workspace import WorkspaceLayer
from app.panels.files import FilesPanel
from app.panels.gizmos import EndGizmos, ObstacleGizmos
from app.panels.layer_switches import LayerSwitches
from app.panels.obstacle_editor import FIELDS, ObstacleEditor
from app.panels.playback import PlaybackPanel
from app.panels.stage_headers import StageHeaders
from app.panels.stages import ArmPanel, MeshPanel, MotionPanel, SearchPanel, SplinePanel

_log = logging.getLogger(__name__)

SLOW_MS = 120.0
"""A plan that takes longer than this is awaited with the old one in grey."""
REST = 0.3
"""Seconds without a wish after which the hand rests: time to plan in full, and to explain."""
LIGHT = 1.5
"""Seconds after the first plan in which it is drawn, however weak the graphics."""


class Session:
    """Everything that belongs to one tab; nothing is shared with another."""

    def __init__(
        self,
        client: viser.ClientHandle,
        name: str,
        scene: Scene,
        plain: bool,
        dark: bool,
        planned: threading.Event,
    ) -> None:
        """Begin a tab; ``planned`` is set whenever a plan has been drawn."""
        self.client = client
        self.plan: Plan | None = None
        self.plans = 0
        self._scene = scene
        self._planner = LivePlanner(compile=False)
        self._wished = 0.0
        self._reason: Reason | None = None
        self._explained: Plan | None = None
        self._refused: AbiError | None = None
        self._changed = threading.Event()
        self._planned = planned
        self._closing = False
        self._faded = False
        self._lit = plain
        self._viewpoint = Viewpoint(client.camera, scene)
        self._compiled = compiling.is_done()
        with client.atomic():
            self._build(name, scene, dark)
        self._changed.set()
        self._worker = threading.Thread(
            target=self._work, name=f"tab-{client.client_id}", daemon=True
        )
        self._worker.start()

    def close(self) -> None:
        """End the worker; the tab has gone."""
        self._closing = True
        self._changed.set()
        if threading.current_thread() is not self._worker:
            self._worker.join(timeout=5)

    @property
    def resting(self) -> bool:
        """Whether the plan is whole and no wish is waiting."""
        drawn = self.plan is not None and not self.mesh.behind
        return drawn and not self._planner.partial and not self._changed.is_set()

    def wake(self, event: object) -> None:
        """The callback of every widget: the user changed something, see what.

        What the worker writes into a widget comes back here too, without a client. Not ``async``:
        viser would leave the coroutines of those behind when it stops.
        """
        if getattr(event, "client", None) is not None:
            self._changed.set()

    def _build(self, name: str, scene: Scene, dark: bool) -> None:
        client, gui = self.client, self.client.gui
        page.set_title(client, "ABI visualiser")
        gui.set_panel_label("ABI path planner")
        gui.main_panel.dock_left()
        gui.main_panel.set_width(style.LEFT_WIDTH)
        right = gui.add_panel()
        result, plots = right.add_tab("Result"), right.add_tab("Joints")
        scenes, view = right.add_tab("Scene"), right.add_tab("Layers")
        lesson = right.add_tab("Paper")
        right.dock_right()
        right.set_width(style.RIGHT_WIDTH)

        self.stage_headers = StageHeaders(gui, self.wake)
        folders = self.stage_headers.folders
        with folders["mesh"]:
            self.mesh_panel = MeshPanel(gui, scene, self.wake)
        with folders["search"]:
            self.search_panel = SearchPanel(gui, scene, self.wake)
        with folders["bspline"]:
            self.spline_panel = SplinePanel(gui, scene, self.wake)
        with folders["quadratic"]:
            self.motion_panel = MotionPanel(gui, scene, self.wake)
        with folders["arm"]:
            self.arm_panel = ArmPanel(gui, scene, self.wake)
        self.tables = TablesLayer(
            gui,
            result,
            folders["graph"],
            folders["bspline"],
            folders["quadratic"],
            folders["arm"],
        )
        self.plots = PlotsLayer(gui, result, plots, scene.unit)
        with result:
            self.playback = PlaybackPanel(gui, self.wake)
        with view:
            self.layer_switches = LayerSwitches(client, self.wake, dark)
        with lesson:
            self._lesson = gui.add_markdown("")
        self._dark = dark
        self._theme()

        self.workspace = WorkspaceLayer(client)
        self.markers = MarkersLayer(client)
        self.mesh = MeshLayer(client)
        self.paths = PathsLayer(client)
        self.reached = SearchOrderLayer(client)
        self.curves = CurvesLayer(client)
        self.arm = ArmLayer(client)
        self.obstacles = ObstacleGizmos(client, scene, self.wake)
        self.ends = EndGizmos(client, scene, self.wake)
        with scenes:
            self.files = FilesPanel(client, name, scene, self.wake)
            self.editor = ObstacleEditor(gui, self.obstacles, self.ends, self.wake)
        self._inputs = (
            self.mesh_panel,
            self.search_panel,
            self.spline_panel,
            self.motion_panel,
            self.arm_panel,
            self.obstacles,
            self.ends,
        )

    def _work(self) -> None:
        """The tab's only thread that computes and draws."""
        while True:
            self._changed.wait(self._patience())
            if self._closing:
                return
            # Not what wait() returned: the wish may have come while it gave up.
            if woken := self._changed.is_set():
                self._changed.clear()
            try:
                if woken:
                    self._wished = time.monotonic()
                    self._follow()
                elif time.monotonic() - self._wished >= REST:
                    self._rest()
                self._play()
            except Exception:
                _log.exception("tab %s", self.client.client_id)
                self.client.add_notification(
                    "This did not work",
                    "The visualiser met a fault of its own; the last picture stays. "
                    "Details are in the server's log.",
                    color="red",
                    auto_close_seconds=8,
                )

    def _patience(self) -> float | None:
        """How long to wait for the user, [s]; for ever when there is nothing else to do."""
        frame = self.playback.timeout()
        idle = self._lit and self._compiled
        idle = idle and not (self._planner.partial or self.mesh.behind or self._unexplained())
        return frame if frame is not None or idle else REST

    def _rest(self) -> None:
        """Do what takes longer than a frame, now that the hand rests."""
        if self._planner.partial:
            self._fade(self._planner.coarse)
            self.plan = self._planner.finish(self._scene)
            self._show_plan(self.plan)
        elif self.mesh.behind and self.plan is not None:
            self._show_plan(self.plan)
        elif self._unexplained():
            self._explain()
        elif not self._lit and time.monotonic() - self._wished >= LIGHT:
            self._light()
        elif not self._compiled and compiling.is_done():
            self._compiled = True
            if self.plan is not None and self.plan.error is None:
                self._planner = LivePlanner(compile=False)  # for times that do not mislead
                self.plan = self._planner.finish(self._scene)
                self._show_plan(self.plan)

    def _light(self) -> None:
        """Add what takes a weak machine seconds, once it shows the plan."""
        self._lit = True
        with self.client.atomic():
            self.client.scene.configure_default_lights()
            self.client.scene.configure_environment_map()

    def _unexplained(self) -> bool:
        plan = self.plan
        return plan is not None and plan.error is not None and plan is not self._explained

    def _explain(self) -> None:
        """Find out why there is no plan; a new wish ends it."""
        plan = self.plan
        assert plan is not None
        reason = explain(plan.scene, plan, self._changed.is_set)
        if self._changed.is_set():
            return
        self._explained, self._reason = plan, reason
        with self.client.atomic():
            self._complain()
            self.markers.draw(reason, plan.scene)

    def _complain(self) -> None:
        """Say what is wrong: with what was typed last, or else with the plan."""
        if self._refused is not None:
            self.stage_headers.complain(self._refused)
        elif self.plan is not None:
            self.stage_headers.complain(self.plan.error, self._reason)

    def _follow(self) -> None:
        """Bring plan and picture up to the panels."""
        try:
            scene = self._read()
        except AbiError as error:
            # what is drawn is of the last good scene; it can be looked at, and saved
            before, self._refused = self._refused, error
            if str(error) != str(before) and getattr(error, "field", "").startswith(FIELDS):
                # typed far from the heading that complains
                page.refuse(self.client, "Not taken over", as_labelled(error, error.message))
            self._fade(True)
            with self.client.atomic():
                self._complain()
                self._switch()
            self.files.save_when_asked(self._scene)
            return
        self._refused = None
        if self.plan is None or scene != self._scene:
            self._scene = scene
            self._fade(self.plan is not None and self.plan.total_ms > SLOW_MS)
            self.plan = self._planner(scene)
            self._reason = None
        self._show_plan(self.plan, hasty=True)
        self.files.save_when_asked(scene)

    def _show_plan(self, plan: Plan, hasty: bool = False) -> None:
        self._draw(plan, hasty)
        self._fade(False)
        self._planned.set()

    def _read(self) -> Scene:
        """The scene that the panels show, checked.

        Raises:
            SceneError: names the field; the last good scene stays.
        """
        requested = self.files.requested(self.editor.meshes(self._scene))
        if requested is not None:
            self._show(requested)
            return requested
        if (change := self.stage_headers.accepted()) is not None:
            changed = self._scene.replace(**change)
            self._show(changed)
            return changed
        self.editor.apply(self._scene)
        data: dict[str, Any] = self._scene.to_dict()
        for panel in self._inputs:
            data |= panel.read()
        return Scene.from_dict(data, self.editor.meshes(self._scene))

    def _show(self, scene: Scene) -> None:
        """Put another scene into the panels, and the camera in front of it."""
        with self.client.atomic():
            for panel in self._inputs:
                panel.write(scene)
            self.editor.write(scene)
            if scene.workspace != self._scene.workspace:
                self._viewpoint.show(scene)

    def _draw(self, plan: Plan, hasty: bool) -> None:
        with self.client.atomic():
            self.stage_headers.draw(plan, self._planner.coarse)
            self._complain()
            self.markers.draw(self._reason, plan.scene)
            self.mesh_panel.offer(plan.scene)
            self.ends.label(plan.scene)
            self.obstacles.draw(plan.scene.obstacles)
            self.editor.suggest(plan.scene)
            self.workspace.draw(plan.scene.workspace, plan.scene.arm.base)
            self.mesh.draw(plan, self.layer_switches.mesh_part(), hasty)
            self.paths.draw(plan)
            self.reached.draw(plan, self.search_panel.share())
            self.curves.draw(plan)
            self.tables.draw(plan, self.mesh.note, self._planner.coarse, self._planner.partial)
            self.plots.draw(plan)
            self._switch()
        # by themselves: the first time the arm and the lesson take longer than all the rest
        with self.client.atomic():
            self.arm.draw(plan)
            if self.plans == 0:
                self._lesson.content = _lesson()
        self.plans += 1

    def _switch(self) -> None:
        """Layers on and off, dark and light."""
        shown = self.layer_switches.read()
        self.workspace.show(shown["workspace"])
        self.mesh.show(shown["edges"], shown["nodes"], shown["excluded"])
        self.paths.show(shown)
        self.curves.show(shown["bspline"], shown["quadratic"], shown["control"])
        self.obstacles.show(shown["obstacles"])
        self.arm.show(shown["arm"], shown["trace"])
        if bool(self.layer_switches.dark.value) != self._dark:
            self._dark = bool(self.layer_switches.dark.value)
            self._theme()

    def _theme(self) -> None:
        self.client.gui.configure_theme(
            dark_mode=self._dark, show_logo=False, show_share_button=False
        )

    def _fade(self, faded: bool) -> None:
        """Grey the curves while they are older than the hand."""
        faded = faded or self._refused is not None
        if faded != self._faded:
            self._faded = faded
            with self.client.atomic():
                self.paths.fade(faded)
                self.curves.fade(faded)

    def _play(self) -> None:
        """One frame of the motion."""
        self._viewpoint.fit()
        if self.plan is None:
            return
        duration = self.plan.profile.duration if self.plan.motion and self.plan.profile else 0.0
        with self.client.atomic():
            now = self.playback.advance(duration)
            self.arm.pose(self.plan, now)
            self.plots.cursor(now, self.playback.playing)


@functools.cache
def _lesson() -> str:
    """The method and the paper's misprints, ready for the page."""
    return with_formulas(assets.path("lessons", "paper.md").read_text(encoding="utf-8"))
