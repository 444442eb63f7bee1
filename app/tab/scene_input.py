"""Scene that a tab is to show: the panels' own, or what a link, a lesson or the teacher sets."""

from __future__ import annotations

import weakref
from dataclasses import replace

import viser

from abi import assets
from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene
from app.panels.teach.classroom import ClassroomPanel
from app.process.memory_budget import MemoryBudget
from app.shared.shared_plans import SharedPlans
from app.state.appearance import Appearance
from app.state.tab_state import TabState
from app.tab.browser_storage import Report, TabStorage
from app.tab.pause import Pause
from app.tab.scene_memory import fitting_scene
from app.tab.view import TabView
from app.teach.lesson import Setting
from app.ui import notices
from app.ui.labels import sentence


class SceneInput:
    """The scene that a tab shows, and whatever puts another in its place.

    Each scene takes its share of the server's memory, until the tab is collected.

    Attributes:
        scene: as it was read last, or is about to be shown.
        first: the scene that the tab opened with.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        scene: Scene,
        look: Appearance,
        view: TabView,
        storage: TabStorage,
        pause: Pause,
        budget: MemoryBudget,
        opening: SharedPlans,
    ) -> None:
        """Begin with a scene, which takes nothing of the ``budget`` and may be in ``opening``."""
        self.scene = self.first = scene
        self._client, self._look, self._view, self._storage = client, look, view, storage
        self._panels, self._pause = view.panels, pause
        self._held = False  # whether a hand dragged when the panels were read last
        self._budget, self._opening = budget, opening

    def keep_memory_for(self, tab: object) -> None:
        """Keep the memory while the object ``tab``, which holds the tab's plans, is alive."""
        # not when it is closed: its plans are in memory until garbage is looked for
        weakref.finalize(tab, self._budget.leave, self._client.client_id).atexit = False

    @property
    def shared_plans(self) -> SharedPlans | None:
        """Plans shared with other tabs: of the teacher's scene, or of this tab's first one."""
        classroom = self._view.classroom
        of_class = None if classroom is None else classroom.shared_plans(self.scene)
        return self._opening if of_class is None and self.scene is self.first else of_class

    def receive(self, time: float) -> bool:
        """Show what the page remembers, the teacher sends, or a lesson or figure sets or leaves.

        Args:
            time: since the begin of the motion that is shown, [s].

        Returns:
            Whether there is something else to plan.
        """
        report = self._storage.report()
        replaced = report is not None and self._restore(report)
        if (classroom := self._view.classroom) is not None:
            if report is not None:
                fresh = not report.state
                classroom.recognise(report.query.get("teach", ""), report.student, fresh)
            replaced |= self._mirror(classroom)
        exercise = self._view.exercise
        written = None if exercise is None else exercise.cue()
        if (cue := self._panels.cue(self.scene) or written) is not None:
            replaced |= self._follow(*cue, time)
        elif self._panels.left() or (exercise is not None and exercise.left()):
            before = self.scene
            self.scene = self._fitting(self._view.go_back(before))
            replaced |= self.scene != before
        return replaced

    def read(self) -> Scene:
        """The scene of the panels; one-off rejections, as of a file, are reported, then ignored.

        Raises:
            SceneError: what they show is no scene.
        """
        held, self._held = self._held, self._panels.held
        if self._held and not held and not self._pause.demo.interrupted:
            # what was changed just before a drag is a step of its own
            self._panels.history.note(self._panels.step(self.scene))
        try:
            return self._within_memory(self._panels.read(self.scene))
        except AbiError as error:
            scene = self._panels.read(self.scene)
            notices.notify_refusal(self._client, "Not changed", sentence(error))
            return scene

    def state(self, time: float) -> TabState:
        """State for the page to store, at a time of the motion, [s]."""
        return self._view.state(self.scene, time)

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
            notices.notify_refusal(self._client, "Not brought back", reason, stays=True)
        if not report.state:
            self._pause.demo.wanted = self._look.demo and report.query.get("demo") != "0"
            return False
        meshes = MeshSource(self.scene.meshes.files, assets.path("scenes"))
        try:
            state = TabState.decode(report.state, meshes)
        except SceneError as error:
            notices.notify_refusal(
                self._client, "The link cannot be opened", error.message, stays=True
            )
            return False
        if state.missing:
            notices.notify_missing(self._client, state.missing)
        if state.faults:
            notices.notify_warning(
                self._client, "Part of the link is left out", " ".join(state.faults), stays=True
            )
        self.scene = self._fitting(state.scene)
        self._view.restore(replace(state, scene=self.scene))
        return True

    def _mirror(self, classroom: ClassroomPanel) -> bool:
        """Show what the teacher has sent; whether there is another scene to plan."""
        if (view := classroom.view()) is None:
            return False
        before, self.scene = self.scene, self._fitting(view.scene)
        self._view.mirror(before, replace(view, scene=self.scene))
        return self.scene != before

    def _follow(self, setting: Setting, scene: Scene, time: float) -> bool:
        """Show what a lesson or a figure sets; whether there is another scene to plan."""
        history = self._panels.history
        if not self._pause.demo.interrupted:
            history.note(self._panels.step(self.scene))
        own = replace(self.state(time), scene=history.noted)
        before, self.scene = self.scene, self._fitting(scene)
        self._view.follow(setting, self.scene, own)
        return self.scene != before

    def _fitting(self, scene: Scene) -> Scene:
        """Reserve memory for a scene, or with a notice for it with a coarser mesh."""
        tab = self._client.client_id
        fitting, error = fitting_scene(self._budget, tab, scene)
        if error is not None:
            notices.notify_warning(self._client, "Coarser than asked for", sentence(error))
            fitting, _ = fitting_scene(self._budget, tab, fitting)
        return fitting

    def _within_memory(self, scene: Scene) -> Scene:
        """The scene of the panels, with the last mesh if theirs would exceed the memory.

        One that was opened gets the finest mesh that is not.
        """
        last = self.scene
        if (scene.mesh, scene.workspace) == (last.mesh, last.workspace):
            return scene
        if self._panels.files.loaded is scene:
            fitting = self._fitting(scene)
            if fitting is not scene:
                self._panels.show(self._panels.step(fitting))
            return fitting
        _, error = fitting_scene(self._budget, self._client.client_id, scene)
        if error is not None:
            self._panels.refuse(error)
            return scene.replace(mesh=last.mesh.model_dump(), workspace=last.workspace.model_dump())
        return scene
