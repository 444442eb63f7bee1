from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from abi import Planner, load_scene, plan
from abi.explain.reason import Reason
from app.panels.messages import _error
from app.panels.offered_changes import offered_changes
from app.panels.plan_sentence import longer_on_finer


def test_a_finer_grid_is_remarked_just_where_its_path_is_longer() -> None:
    scene = load_scene("drag-a-box")
    plans = [plan(scene.replace(mesh={"pitch": pitch})) for pitch in (1.5, 1.2, 1.0, 0.9)]
    told = []
    for before, after in pairwise(plans):
        assert before.path is not None
        assert after.path is not None
        told.append(bool(longer_on_finer(before, after)))
        assert told[-1] == (after.path.length > before.path.length + 1e-3)
        assert not longer_on_finer(after, before)
    assert set(told) == {False, True}
    moved = plan(plans[2].scene.replace(goal=(5.5, 3.5, 3.9)))
    assert not longer_on_finer(plans[0], moved)


def test_of_a_long_message_the_first_sentence_is_seen_and_the_others_on_demand() -> None:
    told = _error("The gripper goes 0.9 cm into <it>. With 1.5 cm it does not. Nor with 2.", "Go.")
    first, _, more = told.partition("<details>")
    assert "The gripper goes 0.9 cm into &lt;it&gt;.</b> Go." in first
    assert "With 1.5 cm it does not. Nor with 2." in more
    assert "details" not in _error("One sentence of 0.5 cm.", "")


def test_a_plan_does_not_count_the_search_of_joints_of_the_scene_before() -> None:
    planner = Planner()
    searched = planner(load_scene("kitchen-ur5e").replace(arm={"axis": None, "search": "joints"}))
    assert searched.ms["joint_search"] > 0
    assert planner(load_scene("paper")).ms["joint_search"] == 0


def test_no_change_is_offered_that_only_leads_to_the_next_error() -> None:
    change, other = {"spline": {"clearance": 0.5}}, {"mesh": {"pitch": 0.4}}
    reason = Reason("", "", change, np.zeros((0, 3)), others=(other,))
    offered = {"Set clearance to 0.5": change, "Set node spacing to 0.4": other}
    assert offered_changes(reason) == offered
    assert offered_changes(replace(reason, is_whole=False)) == offered_changes(None) == {}
    both = replace(reason, change={**change, "obstacles": []}, moved=0, others=())
    assert [*offered_changes(both)] == ["Set clearance to 0.5 and move obstacle 1 there"]
