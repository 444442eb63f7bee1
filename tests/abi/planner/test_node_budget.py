from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.planner.node_budget import FRAME_MS, LEAST_NODES, NodeBudget
from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene, load_scene


def scene_of(pitch: float, lattice: str = "bcc") -> Scene:
    return load_scene("paper").replace(mesh={"pitch": pitch, "lattice": lattice})


def nodes(scene: Scene) -> int:
    return scene.mesh.node_count(scene.workspace)


@pytest.mark.slow
@settings(max_examples=24)
@given(
    pitch=st.floats(0.07, 3),
    lattice=st.sampled_from(list(LATTICES)),
    limit=st.integers(LEAST_NODES, 1_000_000),
)
def test_a_mesh_that_is_too_fine_is_made_just_coarse_enough(
    pitch: float, lattice: str, limit: int
) -> None:
    budget = NodeBudget()
    budget.nodes = limit
    scene = scene_of(pitch, lattice)
    coarser = budget.coarser(scene)
    if nodes(scene) <= limit:
        assert coarser is None
        return
    assert coarser is not None
    assert limit / 3 < nodes(coarser) <= limit
    assert coarser.model_copy(update={"mesh": scene.mesh}) == scene


@pytest.mark.slow
@settings(max_examples=24)
@given(rate=st.floats(300, 60_000), pitch=st.floats(0.07, 0.2))
def test_it_learns_how_many_nodes_fit_a_frame_and_stays_there(rate: float, pitch: float) -> None:
    budget, scene = NodeBudget(), scene_of(pitch)
    pitches = []
    for _ in range(40):
        made = budget.coarser(scene) or scene
        pitches.append(made.mesh.pitch)
        budget.learn(nodes(made), nodes(made) / rate)
        budget.release()
    # a steady hand sees a steady mesh
    assert len(set(pitches[-10:])) == 1
    assert nodes(made) <= max(2 * rate * FRAME_MS, LEAST_NODES)
    assert nodes(made) >= min(nodes(scene), rate * FRAME_MS / 4)


@settings(max_examples=30)
@given(rate=st.floats(300, 60_000), pitch=st.floats(0.07, 0.2))
def test_during_one_drag_the_mesh_gets_no_finer(rate: float, pitch: float) -> None:
    budget, scene = NodeBudget(), scene_of(pitch)
    pitches = []
    for _ in range(20):
        made = budget.coarser(scene) or scene
        pitches.append(made.mesh.pitch)
        budget.learn(nodes(made), nodes(made) / rate)
    if pitches[0] > pitch:
        assert pitches == sorted(pitches)
    if rate * FRAME_MS >= 20_000:  # as fast as was guessed, or faster
        assert len(set(pitches)) == 1


def test_a_small_mesh_says_nothing_of_large_ones() -> None:
    budget = NodeBudget()
    before = budget.nodes
    budget.learn(189, 500.0)
    assert budget.nodes == before
