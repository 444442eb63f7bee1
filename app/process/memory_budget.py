"""Memory of a server, shared out among its tabs: what a scene may ask for is what is left.

What a tab takes is nearly all its mesh: tens of bytes a node, and a link may ask for millions.
"""

from __future__ import annotations

import gc
import math
import threading
import time

from abi.errors import SceneError
from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene

SMALL = 8_000_000
"""Bytes that every tab may take, however much the others have: a mesh of 30,000 nodes."""
_SERVER = 400_000_000
"""Bytes that a process takes without a tab."""
_PERIOD = 5.0
"""Seconds between two looks for tabs that are closed."""
_UNKNOWN = 4_000_000_000
"""Bytes of a machine that does not tell how many it has."""


def memory_for_tabs(memory: int | None, processes: int = 1) -> int:
    """Bytes that the tabs of a process may take together.

    Half of all is for the processes that read files from outside.

    Args:
        memory: bytes of the machine or container; None where nobody tells.
        processes: those that share it.
    """
    half = (_UNKNOWN if memory is None else memory) // 2
    return max(half // processes - _SERVER, half // (4 * processes))


class MemoryBudget:
    """Bytes for the meshes of all tabs of a process, from any thread."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._lock = threading.Lock()
        self._taken: dict[int, int] = {}
        self._looked = -math.inf

    def taken(self, tab: int) -> int:
        """Bytes that a tab has."""
        return self._taken.get(tab, 0)

    def take(self, tab: int, scene: Scene) -> None:
        """Take what a tab needs for a scene, in place of what it had.

        Raises:
            SceneError: that is not left; names the spacing whose mesh would fit.
        """
        if (error := self.fitting(tab, scene)[1]) is not None:
            raise error

    def fitting(self, tab: int, scene: Scene) -> tuple[Scene, SceneError | None]:
        """Take what a tab needs for a scene, unless that is not left.

        Returns:
            The scene itself and None, or the same with the finest mesh that would fit and why.
        """
        memory = LATTICES[scene.mesh.lattice].memory
        needed = memory * scene.mesh.node_count(scene.workspace)
        if needed > self._left(tab):
            self._look_for_garbage()
        with self._lock:
            nodes = self._left(tab) // memory
            if needed <= nodes * memory:
                self._taken[tab] = needed
                return scene, None
        limited = scene.mesh.model_copy(update={"max_nodes": nodes})
        pitch = limited.finest_pitch(scene.workspace)
        expected = (
            f"at least {pitch:g} {scene.unit}: less takes more than the {nodes:,} nodes for which "
            "the server has memory left"
        )
        error = SceneError("mesh.pitch", scene.mesh.pitch, expected)
        return scene.replace(mesh={"pitch": pitch}), error

    def leave(self, tab: int) -> None:
        """Give back what a tab had."""
        with self._lock:
            self._taken.pop(tab, None)

    def _left(self, tab: int) -> int:
        """Bytes that a tab may have, with those that it has."""
        return max(self._size - sum(list(self._taken.values())) + self.taken(tab), SMALL)

    def _look_for_garbage(self) -> None:
        """Let tabs that are closed give back what they had, but not at every step of a drag."""
        if time.monotonic() - self._looked > _PERIOD:
            self._looked = time.monotonic()
            gc.collect()
