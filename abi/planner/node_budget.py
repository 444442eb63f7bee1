"""How fine a mesh may be while the hand moves, so that the path keeps up with it."""

from __future__ import annotations

from abi.scene.scene import MeshSettings, Scene

FRAME_MS = 1000 / 60
LEAST_NODES = 5_000
"""No mesh up to this size is made coarser."""

_FINER = 2 ** (1 / 3)  # a pitch so much coarser has half the nodes
_MOST_FINER = 40
_FIRST_GUESS = 20_000
_ALL = 5  # times as long all three searches may take as one with all that follows


class Pace:
    """Learns how many nodes are planned within a frame.

    Attributes:
        nodes: the number, as far as known.
    """

    def __init__(self) -> None:
        self.nodes = float(_FIRST_GUESS)
        self._halvings = 0

    def coarser(self, scene: Scene) -> Scene | None:
        """``scene`` with a pitch whose mesh is planned within a frame; None when its own is.

        The pitch changes in steps, and not to and fro: each change builds a new mesh.
        """
        if scene.mesh.node_count(scene.workspace) <= self.nodes:
            self._halvings = 0
            return None
        meshes = [_coarser(scene.mesh, times) for times in range(_MOST_FINER)]
        counts = [mesh.node_count(scene.workspace) for mesh in meshes]
        fits = next((k for k, count in enumerate(counts) if count <= self.nodes), _MOST_FINER - 1)
        if fits != self._halvings and not self._still_good(counts):
            self._halvings = fits
        return scene.model_copy(update={"mesh": meshes[max(self._halvings, 1)]})

    def fits_thrice(self, scene: Scene) -> bool:
        """Whether there is time for all three searches in its mesh; two visit all nodes."""
        return scene.mesh.node_count(scene.workspace) <= max(self.nodes / _ALL, LEAST_NODES)

    def took(self, nodes: int, ms: float) -> None:
        """Learn from a plan that searched a mesh of ``nodes`` nodes in ``ms``."""
        # A small mesh says little of large ones, for part of its time does not depend on its nodes:
        # what was quick can only prove that more would fit, what was slow that less does.
        fits = nodes * FRAME_MS / ms
        if (fits > self.nodes) == (ms < FRAME_MS) and 4 * nodes >= self.nodes:
            self.nodes = max((self.nodes + fits) / 2, LEAST_NODES)

    def _still_good(self, counts: list[int]) -> bool:
        """Whether the last choice is a little too fine at most, and not far too coarse."""
        last = self._halvings
        return (
            last > 0 and counts[last] <= 1.3 * self.nodes and counts[last - 1] >= 0.7 * self.nodes
        )


def _coarser(mesh: MeshSettings, times: int) -> MeshSettings:
    """The nodes halved so many times."""
    return mesh.model_copy(update={"pitch": mesh.pitch * _FINER**times})
