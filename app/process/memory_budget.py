"""Memory of a server, divided among its tabs: a scene may use what is left.

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
"""Bytes that every tab may use regardless of the others: a mesh of 30,000 nodes."""
_SERVER = 400_000_000
"""Bytes that a process uses without a tab."""
_PERIOD = 5.0
"""Seconds between two checks for closed tabs."""
_UNKNOWN = 4_000_000_000
"""Assumed bytes of a machine whose memory is unknown."""


def memory_for_tabs(memory: int | None, processes: int = 1) -> int:
    """Bytes that the tabs of a process may use together.

    Half of all is for the processes that read files from outside.

    Args:
        memory: bytes of the machine or container; None where nobody tells.
        processes: those that share it.
    """
    half = (_UNKNOWN if memory is None else memory) // 2
    return max(half // processes - _SERVER, half // (4 * processes))


class MemoryBudget:
    """Bytes for the meshes of all tabs of a process; thread-safe."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._lock = threading.Lock()
        self._taken: dict[int, int] = {}
        self._looked = -math.inf

    def taken(self, tab: int) -> int:
        """Bytes that a tab uses."""
        return self._taken.get(tab, 0)

    def take(self, tab: int, scene: Scene) -> None:
        """Reserve what a tab needs for a scene, in place of its previous reservation.

        Raises:
            SceneError: that is not left; names the spacing whose mesh would fit.
        """
        if (error := self.fitting(tab, scene)[1]) is not None:
            raise error

    def fitting(self, tab: int, scene: Scene) -> tuple[Scene, SceneError | None]:
        """Reserve what a tab needs for a scene, if that much is left.

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
        """Release a tab's reservation."""
        with self._lock:
            self._taken.pop(tab, None)

    def _left(self, tab: int) -> int:
        """Bytes that a tab may use, including those that it uses already."""
        return max(self._size - sum(list(self._taken.values())) + self.taken(tab), SMALL)

    def _look_for_garbage(self) -> None:
        """Release the reservations of closed tabs, but not at every step of a drag."""
        if time.monotonic() - self._looked > _PERIOD:
            self._looked = time.monotonic()
            gc.collect()
