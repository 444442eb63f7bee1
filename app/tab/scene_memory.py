"""Memory that a scene takes of its server, or the finest mesh for which some is left.

What a tab takes is nearly all its mesh: tens of bytes a node, and a link may ask for millions.
"""

from __future__ import annotations

from abi.errors import SceneError
from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene
from app.process.memory_budget import MemoryBudget


def fitting_scene(budget: MemoryBudget, tab: int, scene: Scene) -> tuple[Scene, SceneError | None]:
    """Reserve what a tab needs for a scene, if that much is left.

    Returns:
        The scene itself and None, or the same with the finest mesh that would fit and why, which
        names its spacing; then nothing is reserved.
    """
    memory = LATTICES[scene.mesh.lattice].memory
    needed = memory * scene.mesh.node_count(scene.workspace)
    if needed > budget.left(tab):
        budget.collect()
    if budget.take(tab, needed):
        return scene, None
    nodes = budget.left(tab) // memory
    pitch = scene.mesh.model_copy(update={"max_nodes": nodes}).finest_pitch(scene.workspace)
    expected = (
        f"at least {pitch:g} {scene.unit}: less takes more than the {nodes:,} nodes for which "
        "the server has memory left"
    )
    error = SceneError("mesh.pitch", scene.mesh.pitch, expected)
    return scene.replace(mesh={"pitch": pitch}), error
