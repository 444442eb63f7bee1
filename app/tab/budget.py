"""One tab's share of the server's memory."""

from __future__ import annotations

import weakref

import viser

from abi.scene.scene import Scene
from app.process.memory_budget import MemoryBudget
from app.ui import notices
from app.ui.labels import sentence


class TabBudget:
    """Memory reserved for a tab's scenes, released when the tab is collected."""

    def __init__(self, budget: MemoryBudget, client: viser.ClientHandle, tab: object) -> None:
        """Share ``budget`` while the object ``tab``, which holds the tab's plans, is alive."""
        self._budget, self._client = budget, client
        # not when it is closed: its plans are in memory until garbage is looked for
        weakref.finalize(tab, budget.leave, client.client_id).atexit = False

    def take(self, scene: Scene) -> None:
        """Reserve memory for a scene.

        Raises:
            SceneError: it is not left; names the spacing whose mesh would fit.
        """
        self._budget.take(self._client.client_id, scene)

    def fitting(self, scene: Scene) -> Scene:
        """Reserve memory for a scene, or with a notice for it with a coarser mesh."""
        fitting, error = self._budget.fitting(self._client.client_id, scene)
        if error is not None:
            notices.notify_warning(self._client, "Coarser than asked for", sentence(error))
            fitting, _ = self._budget.fitting(self._client.client_id, fitting)
        return fitting
