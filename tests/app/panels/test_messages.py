from __future__ import annotations

from itertools import pairwise

from abi import load_scene, plan
from app.panels.messages import _longer_on_finer


def test_a_finer_grid_is_remarked_just_where_its_path_is_longer() -> None:
    scene = load_scene("drag-a-box")
    plans = [plan(scene.replace(mesh={"pitch": pitch})) for pitch in (1.5, 1.2, 1.0, 0.9)]
    told = []
    for before, after in pairwise(plans):
        assert before.path is not None
        assert after.path is not None
        told.append(bool(_longer_on_finer(before, after)))
        assert told[-1] == (after.path.length > before.path.length + 1e-3)
        assert not _longer_on_finer(after, before)
    assert set(told) == {False, True}
    moved = plan(plans[2].scene.replace(goal=(5.5, 3.5, 3.9)))
    assert not _longer_on_finer(plans[0], moved)
