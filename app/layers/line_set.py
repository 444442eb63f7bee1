"""Sets of many straight lines as all layers draw them."""

from __future__ import annotations

import viser


class LineSet:
    """One set, of which only what changes is sent."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._handle: viser.GlbHandle | None = None

    def __bool__(self) -> bool:
        """Check if anything is drawn."""
        return self._handle is not None

    def draw(self, data: bytes) -> None:
        """Draw lines of :mod:`app.drawing.glb`; empty data take away those there are."""
        if self._handle is not None and data:
            self._handle.glb_data = data
        elif self._handle is not None:
            self._handle.remove()
            self._handle = None
        elif data:
            self._handle = self._scene.add_glb(
                self._name, data, cast_shadow=False, receive_shadow=False
            )

    def show(self, on: bool) -> None:
        """Show or hide the lines, if there are any."""
        if self._handle is not None:
            self._handle.visible = on
