"""Positions at which the joints beside the arm are held, such as those of a gripper."""

from __future__ import annotations

from collections.abc import Mapping

import viser

from abi.obstacles.pose import METRES
from abi.robot.urdf.held_joints import held_in_metres, planned_joints, positions_held
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot
from app.panels.widgets import Wake, range_hint

_MOST = 12
"""Joints that have a slider; a hand of more of them is held by its scene file."""
_STEPS = 200
_BY_JOINT = "by its joints"
_LOWEST, _HIGHEST = "at its lower limits", "at its upper limits"


class GripperPanel:
    """A slider for each joint that is held and follows no other, and a choice of named states."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self._gui, self._wake = gui, wake
        self._folder = gui.add_folder("Gripper", visible=False)
        with self._folder:
            self.state = gui.add_dropdown(
                "state",
                (_BY_JOINT,),
                hint="Positions that the arm's SRDF names, such as open and closed, or limits.",
            )
        self.state.on_update(wake)
        self._states: dict[str, dict[str, float]] = {}
        self._chosen = _BY_JOINT
        self.sliders: dict[str, viser.GuiSliderHandle[float]] = {}
        self._of: tuple[tuple[str, float, float], ...] = ()
        self._held: dict[str, float] = {}
        self._shown: dict[str, float] = {}

    def read(self) -> dict[str, float]:
        """Positions of the joints that the scene named or a hand moved, [rad] or [unit]."""
        if self.state.value != self._chosen:
            self._chosen = self.state.value
            for name, at in self._states.get(self._chosen, {}).items():
                self.sliders[name].value = self._held[name] = self._shown[name] = at
        for name, slider in self.sliders.items():
            if slider.value != self._shown[name]:
                self._held[name] = self._shown[name] = slider.value
                self.state.value = self._chosen = _BY_JOINT
        return dict(self._held)

    def write(self, robot: Robot, tip: str, held: Mapping[str, float], unit: str) -> None:
        """Show the joints of a robot that do not move its tip.

        Args:
            robot: from its base link on.
            tip: name of the link.
            held: positions that the scene names, [rad] or [unit].
            unit: of the scene.
        """
        planned, metres = planned_joints(robot, tip), METRES[unit]
        still = positions_held(robot, planned, held_in_metres(robot, held, metres))
        scales = {
            joint.name: metres if joint.kind == "prismatic" else 1.0
            for joint in robot.joints
            if joint.name in still and joint.follows is None and joint.low < joint.high
        }
        joints = [joint for joint in robot.joints if joint.name in scales][:_MOST]
        rows = tuple(
            (one.name, one.low / scales[one.name], one.high / scales[one.name]) for one in joints
        )
        if rows != self._of:
            self._of = rows
            self._add(joints, scales, unit)
        self._list_states(robot, scales)
        self._held = dict(held)
        for name, slider in self.sliders.items():
            slider.value = self._shown[name] = still[name] / scales[name]
        self.show(True)

    def show(self, shown: bool) -> None:
        """Show or hide it; without such joints it stays hidden."""
        self._folder.visible = shown and bool(self.sliders)

    def _list_states(self, robot: Robot, scales: Mapping[str, float]) -> None:
        """List the positions that have a name, of which none is chosen."""
        named = {
            state: {name: at / scales[name] for name, at in positions.items()}
            for state, positions in robot.states.items()
            if positions and positions.keys() <= self.sliders.keys()
        }
        lowest = {name: slider.min for name, slider in self.sliders.items()}
        highest = {name: slider.max for name, slider in self.sliders.items()}
        self._states = {**named, _LOWEST: lowest, _HIGHEST: highest}
        self.state.options = (_BY_JOINT, *self._states)
        self.state.value = self._chosen = _BY_JOINT

    def _add(self, joints: list[Joint], scales: Mapping[str, float], unit: str) -> None:
        for old in self.sliders.values():
            old.remove()
        self.sliders = {}
        with self._folder:
            for one in joints:
                low, high = one.low / scales[one.name], one.high / scales[one.name]
                kind = unit if one.kind == "prismatic" else "rad"
                self.sliders[one.name] = self._gui.add_slider(
                    one.name,
                    min=low,
                    max=high,
                    step=(high - low) / _STEPS,
                    initial_value=low,
                    hint=range_hint("Held here while the arm moves.", low, high, kind),
                )
                self.sliders[one.name].on_update(self._wake)
