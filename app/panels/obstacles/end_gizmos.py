"""Start and goal in the scene, each under a gizmo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.scene.scene import Scene
from app.panels.widgets import Wake, phase_holds
from app.state.frame import Frame
from app.ui import page, style
from app.ui.numbers import format_setting

_ROUNDING = 1e-9
"""Part of the workspace's size."""
_RADIUS = 0.022
"""Of a ball, as a part of the workspace's size."""


class EndGizmos:
    """Balls under gizmos without rotations, and labels with coordinates.

    Attributes:
        held: whether a hand holds an end or its handles.
        gizmos: by name; to be moved by :meth:`place`.
    """

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        size = max(scene.workspace.size)
        self.gizmos: dict[str, viser.TransformControlsHandle] = {}
        self._labels: dict[str, viser.LabelHandle] = {}
        self._balls: dict[str, viser.IcosphereHandle] = {}
        self._origins: dict[str, FloatArray] = {}
        self._grips: dict[str, FloatArray] = {}
        self._chosen = ""
        self._with_handles = ""
        self._wake = wake
        for name in ("start", "goal"):
            position = np.array(getattr(scene, name))
            gizmo = client.scene.add_transform_controls(
                f"/{name}",
                position=position,
                line_width=3.0,
                disable_axes=True,
                disable_rotations=True,
                disable_sliders=True,
                depth_test=False,
                opacity=0.9,
            )
            gizmo.on_update(self._drag_gizmo)
            page.keep_to_tab(gizmo)
            self.gizmos[name], self._origins[name] = gizmo, position
            self._balls[name] = ball = client.scene.add_icosphere(
                f"/{name}/ball", radius=_RADIUS * size, color=style.POINT
            )
            ball.on_click(self._choose)
            ball.on_drag(self._drag_body)
            self._labels[name] = client.scene.add_label(
                f"/{name}/label", name, anchor="top-center", depth_test=False
            )
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """Read ``start`` and ``goal``."""
        return {
            name: self._within_rounding(gizmo.position).tolist()
            for name, gizmo in self.gizmos.items()
        }

    def place(self, name: str, position: Sequence[float]) -> None:
        """Move an end to ``position`` (3,), [unit], and limit drags to the workspace.

        The page holds the limits against the sum of all drags of a gizmo, wherever else it was put
        meanwhile.
        """
        gizmo = self.gizmos[name]
        shift = np.asarray(position) - gizmo.position
        if np.isfinite(shift).all():
            self._origins[name] = self._origins[name] + shift
        low, high = (side - self._origins[name] for side in self._bounds)
        x, y, z = zip(low.tolist(), high.tolist(), strict=True)
        gizmo.translation_limits = (x, y, z)
        gizmo.position = np.asarray(position)

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        size = max(scene.workspace.size)
        self._chosen, self.held = "", False
        self._bounds = np.array(scene.workspace.min), np.array(scene.workspace.max)
        for name, gizmo in self.gizmos.items():
            self.place(name, getattr(scene, name))
            gizmo.scale = 0.13 * size
            self._balls[name].radius = _RADIUS * size
            self._labels[name].position = (0.0, 0.0, -0.05 * size)
        self._write_labels()

    def draw(self, frame: Frame) -> None:
        """Write the coordinates on the labels; give the handles to the end chosen last."""
        if self._chosen != self._with_handles:
            self._with_handles = self._chosen
            for name, gizmo in self.gizmos.items():
                gizmo.disable_axes = name != self._chosen
        if not frame.outdated and frame.refused is None:
            self._follow_joints(frame.plan.scene)
        for label in self._labels.values():
            label.font_screen_scale = frame.label_scale
        if not frame.outdated or frame.refused is not None:  # an end stays where it was refused
            self._write_labels()

    def _follow_joints(self, scene: Scene) -> None:
        """Put the ends where the joints that are asked for put the tool."""
        for name in self.gizmos:
            if getattr(scene.arm, name) is not None and not self.held:
                self.place(name, getattr(scene, name))

    def _drag_gizmo(self, event: viser.TransformControlsEvent) -> None:
        self.held = phase_holds(event.phase, self.held)
        self._wake(event)

    def _choose(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        self._chosen = self._name_of(event.target)
        self._wake(event)

    def _drag_body(self, event: viser.SceneNodeDragEvent[Any]) -> None:
        """Move an end with the hand, in the plane that faces the camera, within the workspace."""
        self._chosen = name = self._name_of(event.target)
        grip = self._grips.setdefault(
            name, np.subtract(self.gizmos[name].position, event.start_position)
        )
        position = np.add(event.end_position, grip)
        if np.isfinite(position).all():
            self.place(name, np.clip(position, *self._bounds).tolist())
        self.held = phase_holds(event.phase, self.held)
        if event.phase == "end":
            self._grips.pop(name, None)
        self._wake(event)

    def _name_of(self, ball: object) -> str:
        return next(name for name, other in self._balls.items() if other is ball)

    def _write_labels(self) -> None:
        for name, label in self._labels.items():
            place = (format_setting(round(x, 3)) for x in self.gizmos[name].position.tolist())
            label.text = f"{name} ({', '.join(place)})"

    def _within_rounding(self, position: FloatArray) -> FloatArray:
        """``position`` (3,), back in the workspace if only rounding put it outside."""
        low, high = self._bounds
        inside = np.clip(position, low, high)
        rounded = np.abs(position - inside).max() <= _ROUNDING * (high - low).max()
        return inside if rounded else position
