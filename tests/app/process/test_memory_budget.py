"""Memory for meshes, shared by all tabs: a scene gets what is left, or is told what would fit."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.scene.lattices import LATTICES, Lattice
from abi.scene.scene import Scene, load_scene
from app.process.memory_budget import SMALL, MemoryBudget, memory_for_tabs
from app.server.server import Server
from app.state.tab_state import TabState
from app.tab.scene_memory import fitting_scene
from app.ui import notices
from tests.app.fake_tab import opened, until

PAPER = load_scene("paper")
SIZE = 50_000_000


def _needed(scene: Scene) -> int:
    return LATTICES[scene.mesh.lattice].memory * scene.mesh.node_count(scene.workspace)


def _scene(pitch: float, lattice: Lattice = "bcc") -> Scene:
    return PAPER.replace(mesh={"pitch": pitch, "lattice": lattice, "max_nodes": 20_000_000})


@given(
    st.lists(
        st.tuples(
            st.integers(0, 4), st.floats(0.03, 2.0), st.sampled_from(list(LATTICES)), st.booleans()
        ),
        max_size=12,
    )
)
def test_tabs_never_take_more_than_there_is_but_for_a_little_each(
    asked: list[tuple[int, float, Lattice, bool]],
) -> None:
    budget = MemoryBudget(SIZE, SMALL)
    for tab, pitch, lattice, leaves in asked:
        if leaves:
            budget.leave(tab)
        scene = _scene(pitch, lattice)
        before = budget.taken(tab)
        fitting, error = fitting_scene(budget, tab, scene)
        if error is None:
            assert fitting is scene
            assert budget.taken(tab) == _needed(scene)
        else:
            assert budget.taken(tab) == before
            # what it says is right: that spacing fits, and is told in the sentence
            assert fitting.mesh.pitch > scene.mesh.pitch
            assert f"at least {fitting.mesh.pitch:g} cm" in error.expected
            assert fitting_scene(budget, tab, fitting) == (fitting, None)
        taken = [budget.taken(tab) for tab in range(5)]
        assert sum(one for one in taken if one > SMALL) <= SIZE
        assert sum(taken) <= SIZE + 5 * SMALL


def test_a_scene_of_too_many_nodes_is_refused_with_the_spacing_that_fits() -> None:
    budget = MemoryBudget(SIZE, SMALL)
    _, error = fitting_scene(budget, 1, _scene(0.0282))
    assert error is not None
    assert "mesh.pitch is 0.0282; expected at least" in error.message
    assert "nodes for which the server has memory left" in error.message
    assert budget.taken(1) == 0
    assert _fits(budget, 1, _scene(0.2))
    assert _fits(budget, 2, _scene(0.2))
    assert not _fits(budget, 3, _scene(0.0645))
    # a tab that asks again counts once
    assert _fits(budget, 2, _scene(0.21))
    # of a random lattice a node takes more
    assert not _fits(budget, 2, _scene(0.2, "delaunay"))


def _fits(budget: MemoryBudget, tab: int, scene: Scene) -> bool:
    return fitting_scene(budget, tab, scene)[1] is None


@pytest.mark.parametrize(
    ("memory", "processes"), [(None, 1), (512 << 20, 1), (2 << 30, 4), (64 << 30, 1), (2**27, 8)]
)
def test_the_tabs_have_a_part_of_the_memory(memory: int | None, processes: int) -> None:
    each = memory_for_tabs(memory, processes)
    assert 0 < each * processes <= (4_000_000_000 if memory is None else memory) / 2
    assert memory_for_tabs(2 * (memory or 4_000_000_000), processes) >= each


_MEASURE = """
import json, multiprocessing, os, pathlib
import abi
def resident():
    pages = pathlib.Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")
def measure(lattice, nodes):
    planner, scene = abi.Planner(), abi.load_scene("two-boxes")
    planner(scene.replace(mesh=dict(lattice=lattice, pitch=0.5)))
    mesh = scene.mesh.model_copy(update=dict(lattice=lattice, max_nodes=nodes))
    scene = scene.replace(mesh=dict(lattice=lattice, pitch=mesh.finest_pitch(scene.workspace)))
    before = resident()
    planner(scene)
    plan = planner(scene.replace(start=(0.1, 0.1, 0.1)))
    return lattice, (resident() - before) / scene.mesh.node_count(scene.workspace)
abi.compile()
# in a process each: a mesh finds no room that another has left
with multiprocessing.get_context("fork").Pool(1, maxtasksperchild=1) as pool:
    sizes = ("bcc", 150_000), ("kuhn", 150_000), ("delaunay", 25_000)
    print(json.dumps(dict(pool.starmap(measure, sizes, chunksize=1))))
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="only Linux tells so easily")
def test_a_plan_takes_no_more_memory_than_is_counted() -> None:
    run = subprocess.run(
        [sys.executable, "-c", _MEASURE], capture_output=True, text=True, check=True
    )
    found = json.loads(run.stdout)
    assert found.keys() == LATTICES.keys()
    for lattice, kind in LATTICES.items():
        assert 0.1 * kind.memory < found[lattice] < kind.memory


def test_a_link_gets_the_mesh_that_fits_and_a_typed_spacing_is_refused(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    monkeypatch.setattr(notices, "notify_warning", lambda client, *words: told.extend(words))
    monkeypatch.setattr(server.budget, "_size", SMALL)
    fake, session = opened(server)
    text = TabState("paper", _scene(0.05)).encode()
    fake.set(session._memory._box, json.dumps({"state": text, "query": {}, "dark": False}))
    until(lambda: session.scene.mesh.pitch != PAPER.mesh.pitch and session.resting)
    pitch = session.scene.mesh.pitch
    assert told[0] == "Coarser than asked for"
    assert f"at least {pitch:g} cm" in told[1]
    assert session.panels.stages.fields["mesh.pitch"].value == pitch
    assert _needed(session.scene) <= SMALL

    fake.set(session.panels.stages.fields["mesh.pitch"], 0.06)
    until(lambda: session.frame.refused is not None)
    assert session.scene.mesh.pitch == pitch
    (gizmo, *_) = session.panels.obstacles.gizmos
    fake.drag(gizmo, [3.5, 3.0, 3.0])
    until(lambda: session.scene.obstacles[0].position[0] == 3.5)  # a drag goes on beside it
    assert session.scene.mesh.pitch == pitch
    fake.set(session.panels.stages.fields["mesh.pitch"], 1.0)
    until(lambda: session.scene.mesh.pitch == 1.0 and session.frame.refused is None)
    number = session.client.client_id
    assert server.budget.taken(number) == _needed(session.scene)
    fake.close()
    until(lambda: not server.sessions)


def test_a_closed_tab_gives_back_what_it_had_where_another_needs_it(server: Server) -> None:
    budget = server.budget
    fake, session = opened(server)
    number = session.client.client_id
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.9)
    until(lambda: budget.taken(number) > 0)
    fake.close()
    until(lambda: number not in server.sessions)
    del session

    def is_given_back() -> bool:
        budget._looked = 0.0
        fitting_scene(budget, -1, _scene(0.0282).replace(mesh={"pitch": 0.02819}))
        return budget.taken(number) == 0

    budget_size, budget._size = budget._size, 1
    try:
        until(is_given_back)
    finally:
        budget._size = budget_size
        budget.leave(-1)
