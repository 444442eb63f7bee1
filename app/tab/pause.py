"""Idle work of a tab: what takes longer than a frame is done while there is no input."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import viser

from abi import compiling
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.panels.all_panels import AllPanels
from app.process import unused_memory
from app.shared.diagnoses import diagnose, reason_of
from app.state.frame import Frame
from app.tab.demo import FRAME, Demo
from app.tab.planner import TabPlanner

REST = 0.3
"""Seconds without input after which the tab plans in full and diagnoses."""
IDLE = 1.0
"""Seconds between two checks of an idle tab whether the user has moved the camera."""
UNUSED = 300.0
"""Seconds without input after which a tab releases caches that only speed up planning."""
LIGHTS_DELAY = 1.5
"""Seconds within which even weak graphics have drawn the first plan."""
_AMBIENT = 1.2
"""Intensity of ambient light that makes obstacles as bright as an environment map does."""


class Pause:
    """Idle work of a tab.

    Attributes:
        demo: of a new tab.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        panels: AllPanels,
        planner: TabPlanner,
        interrupted: Callable[[], bool],
        has_lights: bool,
    ) -> None:
        """Begin with nothing done; ``interrupted`` tells whether there is new input."""
        self.demo = Demo(panels.obstacles)
        self._client, self._panels, self._planner = client, panels, planner
        self._interrupted = interrupted
        self._has_lights = has_lights
        self._has_memory = True
        self._begun = 0.0
        self._diagnosed: Plan | None = None

    def stay_plain(self) -> None:
        """Use ambient light only, which costs no rendering time."""
        self._has_lights = True
        self._client.scene.add_light_ambient("/lights/ambient", intensity=_AMBIENT)

    def begin(self, input: bool = True) -> None:
        """Restart the count at the last ``input`` or the last picture of the demonstration."""
        self._begun = time.monotonic()
        self._has_memory |= input

    @property
    def seconds(self) -> float:
        """Seconds since the last input."""
        return time.monotonic() - self._begun

    def timeout(self, frame: Frame) -> float:
        """Time until there is something to do, [s]."""
        if self.demo.running:
            return FRAME
        incomplete = frame.interactive or frame.plan.partial or self._is_undiagnosed(frame.plan)
        idle = self._has_lights and not incomplete and not self.demo.wanted
        bases = self._panels.stages.bases.timeout()
        usual = IDLE if idle else REST
        return usual if bases is None else min(bases, usual)

    def use(self, frame: Frame, scene: Scene) -> Frame:
        """Do the first piece of outstanding work; the frame to draw, or the same frame."""
        if self._is_undiagnosed(frame.plan):
            return self._diagnose(frame)
        if self._panels.stages.bases.running:
            self._panels.stages.bases.step(scene, self._panels.messages.legs.number)
            return replace(frame)  # another frame, since the bases are drawn with it
        if not self._has_lights and self.seconds >= LIGHTS_DELAY:
            self._add_lights()
        elif self.demo.wanted and compiling.is_done():
            self.demo.begin(scene)
        elif self._has_memory and self.seconds >= UNUSED:
            self._has_memory = False
            self._planner.live.forget()
            unused_memory.give_back_soon()
        return frame

    def _is_undiagnosed(self, plan: Plan) -> bool:
        return plan.error is not None and plan is not self._diagnosed

    def _diagnose(self, frame: Frame) -> Frame:
        """The frame with the reason why there is no plan; without it if that has to wait."""
        if not diagnose(frame.plan, self._interrupted):
            return frame
        self._diagnosed = frame.plan
        return replace(frame, reason=reason_of(frame.plan))

    def _add_lights(self) -> None:
        """Add lights and an environment map, which weak graphics take seconds to draw."""
        self._has_lights = True
        with self._client.atomic():
            self._client.scene.configure_default_lights()
            self._client.scene.configure_environment_map()
