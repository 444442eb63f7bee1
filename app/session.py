"""One browser tab: its worker thread reads the panels, plans what changed, and draws the frame.

Callbacks only wake the worker. What it draws is one frozen :class:`Frame`, given to every layer
and panel inside one ``atomic`` block; the newest settings win, and what was overtaken is never
computed.
"""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import replace

import viser

from abi import compiling
from abi.errors import AbiError
from abi.planner.diagnosis import explain
from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.camera import Viewpoint
from app.frame import Drawn, Frame, Switched
from app.layers.catalogue import LAYERS, SLOW_LAYERS
from app.panels.all_panels import AllPanels
from app.panels.gizmos import ObstacleGizmos
from app.panels.playback import PlaybackPanel

_log = logging.getLogger(__name__)

SLOW_MS = 120.0
"""A plan that takes longer than this is awaited with the old one in grey."""
REST = 0.3
"""Seconds without a wish after which the hand rests: time to plan in full, and to explain."""
LIGHT = 1.5
"""Seconds after the first plan in which it is drawn, however weak the graphics."""
_SWITCHED: tuple[type[Switched], ...] = (*LAYERS, ObstacleGizmos, *SLOW_LAYERS)
SWITCHES = tuple(switch for drawn in _SWITCHED for switch in drawn.switches)
"""The lines of the legend."""


class Session:
    """Everything that belongs to one tab; nothing is shared with another.

    Attributes:
        frame: what is drawn.
        plans: how many plans were drawn so far, those drawn again included.
        layers: what draws and nobody moves.
    """

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
        self.frame = Frame(Plan(scene))
        self.plans = 0
        self._scene = scene
        self._planner = LivePlanner(compile=False)
        self._wished = 0.0
        self._explained: Plan | None = None
        self._changed = threading.Event()
        self._planned = planned
        self._closing = False
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
    def plan(self) -> Plan | None:
        """The plan that is drawn; None before the first."""
        return self.frame.plan if self.plans else None

    @property
    def resting(self) -> bool:
        """Whether the plan is whole, all of it is drawn, and no wish is waiting."""
        waits = self.frame.hasty or self.frame.partial or self._changed.is_set()
        return self.plans > 0 and not waits

    def wake(self, event: object) -> None:
        """The callback of every widget: the user changed something, see what.

        What the worker writes into a widget comes back here too, without a client. Not ``async``:
        viser would leave the coroutines of those behind when it stops.
        """
        if getattr(event, "client", None) is not None:
            self._changed.set()

    def _build(self, name: str, scene: Scene, dark: bool) -> None:
        """Add panels and layers; where they share a tab or a folder, in the order of the page."""
        self.panels = AllPanels(self.client, name, scene, SWITCHES, self.wake, dark)
        layers: list[Drawn] = [layer(self.panels.layout) for layer in LAYERS]
        slow_layers: list[Drawn] = [layer(self.panels.layout) for layer in SLOW_LAYERS]
        with self.panels.layout.result:
            self.playback = PlaybackPanel(self.client.gui, self.wake)
        self.layers = (*layers, *slow_layers)
        self._groups = ((*self.panels.drawn, *layers), slow_layers)

    def _work(self) -> None:
        """Run the tab's only thread that computes and draws."""
        while True:
            self._changed.wait(self._patience())
            if self._closing:
                return
            # Not what wait() returned: the wish may have come while it gave up.
            if woken := self._changed.is_set():
                self._changed.clear()
            try:
                self._viewpoint.fit()
                if woken:
                    self._wished = time.monotonic()
                    self._follow()
                    continue
                if time.monotonic() - self._wished >= REST:
                    self._rest()
                self._draw(self.frame)
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
        """Time to wait for the user, [s]; for ever when there is nothing else to do."""
        moving = self.playback.timeout()
        idle = self._lit and self._compiled
        idle = idle and not (self.frame.hasty or self.frame.partial or self._unexplained())
        return moving if moving is not None or idle else REST

    def _follow(self) -> None:
        """Bring plan and picture up to the panels."""
        try:
            scene = self.panels.read(self._scene)
        except AbiError as error:
            # what is drawn is of the last good scene; it can be looked at, and saved
            self._draw(replace(self.panels.switched(self.frame), refused=error))
        else:
            self.frame = replace(self.frame, refused=None)
            if self.plans == 0 or scene != self._scene:
                self._show(self._plan_of(scene), hasty=True)
            else:
                self._show(self.frame.plan, hasty=True)
        self.panels.files.save_when_asked(self._scene)

    def _plan_of(self, scene: Scene) -> Plan:
        """The plan of another scene; if it may take long, the last one is in grey meanwhile."""
        if scene.workspace != self._scene.workspace:
            self._viewpoint.show(scene)
        self._scene = scene
        if self.frame.plan.total_ms > SLOW_MS:
            self._draw(replace(self.frame, outdated=True))
        return self._planner(scene)

    def _show(self, plan: Plan, hasty: bool = False) -> None:
        """Draw a plan; ``hasty`` while the hand may still move."""
        frame = self.panels.switched(self.frame)
        if plan is not frame.plan:
            frame = replace(frame, plan=plan, reason=None)
        coarse, partial = self._planner.coarse, self._planner.partial
        self._draw(replace(frame, coarse=coarse, partial=partial, hasty=hasty, outdated=False))
        self.plans += 1
        self._planned.set()

    def _draw(self, frame: Frame) -> None:
        """Draw a frame at the moment that the playback has come to."""
        with self.client.atomic():
            now = self.playback.advance(frame.duration)
            self.frame = replace(frame, time=now, playing=self.playback.playing)
            for drawn in self._groups[0]:
                drawn.draw(self.frame)
        with self.client.atomic():
            for drawn in self._groups[1]:
                drawn.draw(self.frame)

    def _rest(self) -> None:
        """Do what takes longer than a frame, now that the hand rests."""
        if self._planner.partial:
            if self._planner.coarse:
                self._draw(replace(self.frame, outdated=True))
            self._show(self._planner.finish(self._scene))
            return
        if self.frame.hasty:
            self._draw(replace(self.frame, hasty=False))
        if self._unexplained():
            self._explain()
        elif not self._lit and time.monotonic() - self._wished >= LIGHT:
            self._light()
        elif not self._compiled and compiling.is_done():
            self._compiled = True
            if self.plans and self.frame.plan.error is None:
                self._planner = LivePlanner(compile=False)  # for times that do not mislead
                self._show(self._planner.finish(self._scene))

    def _unexplained(self) -> bool:
        return self.frame.plan.error is not None and self.frame.plan is not self._explained

    def _explain(self) -> None:
        """Find out why there is no plan; a new wish ends it."""
        plan = self.frame.plan
        reason = explain(plan.scene, plan, self._changed.is_set)
        if not self._changed.is_set():
            self._explained = plan
            self._draw(replace(self.frame, reason=reason))

    def _light(self) -> None:
        """Add what takes a weak machine seconds, once it shows the plan."""
        self._lit = True
        with self.client.atomic():
            self.client.scene.configure_default_lights()
            self.client.scene.configure_environment_map()
