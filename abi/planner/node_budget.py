"""Node budget: the number of mesh nodes that can be planned within a frame."""

from __future__ import annotations

from abi.scene.scene import Scene

FRAME_MS = 1000 / 60
LEAST_NODES = 5_000
"""Smallest budget: meshes of up to this many nodes are never made coarser."""

_COARSER = 2 ** (1 / 3)  # a pitch so much coarser has half the nodes
_MOST_HALVINGS = 40
_FIRST_GUESS = 20_000
_FAR_TOO_MANY = 2.5
_ALL_SEARCHES = 5  # ratio of time of all searches to that of one and all later stages


class NodeBudget:
    """Number of nodes that can be planned within a frame, learnt from earlier plans.

    Attributes:
        nodes: the present estimate.
    """

    def __init__(self) -> None:
        self.nodes = float(_FIRST_GUESS)
        self._halvings = 0
        self._held = False

    def coarser(self, scene: Scene) -> Scene | None:
        """``scene`` with a pitch that can be planned within a frame; None if its own can.

        The pitch changes in steps and with hysteresis, because each change builds a new mesh. Until
        :meth:`release` it only gets coarser, and only if the present one takes far too long.
        """
        held = self._held and self._halvings > 0
        if scene.mesh.node_count(scene.workspace) <= self.nodes and not held:
            self._halvings = 0
            return None
        pitches = [scene.mesh.pitch * _COARSER**times for times in range(_MOST_HALVINGS)]
        meshes = [scene.mesh.model_copy(update={"pitch": pitch}) for pitch in pitches]
        counts = [mesh.node_count(scene.workspace) for mesh in meshes]
        last = _MOST_HALVINGS - 1
        fits = next((k for k, count in enumerate(counts) if count <= self.nodes), last)
        if held:
            if counts[self._halvings] > _FAR_TOO_MANY * self.nodes:
                self._halvings = fits
        elif fits != self._halvings and not self._still_fits(counts):
            self._halvings = fits
        self._held = True
        return scene.model_copy(update={"mesh": meshes[max(self._halvings, 1)]})

    def release(self) -> None:
        """Allow any next pitch: the drag has ended."""
        self._held = False

    def fits_all_searches(self, scene: Scene) -> bool:
        """Check whether there is time for all searches, two of which visit all nodes."""
        most = max(self.nodes / _ALL_SEARCHES, LEAST_NODES)
        return scene.mesh.node_count(scene.workspace) <= most

    def learn(self, nodes: int, ms: float) -> None:
        """Learn from a plan that searched a mesh of ``nodes`` nodes in ``ms``."""
        # part of the time does not depend on the nodes, so a small mesh says little of large ones:
        # a fast plan can only prove that more nodes fit, a slow one that fewer do
        fits = nodes * FRAME_MS / ms
        if (fits > self.nodes) == (ms < FRAME_MS) and 4 * nodes >= self.nodes:
            self.nodes = max((self.nodes + fits) / 2, LEAST_NODES)

    def _still_fits(self, counts: list[int]) -> bool:
        """Check whether the last pitch is a little too fine at most, and not far too coarse."""
        last = self._halvings
        return (
            last > 0 and counts[last] <= 1.3 * self.nodes and counts[last - 1] >= 0.7 * self.nodes
        )
