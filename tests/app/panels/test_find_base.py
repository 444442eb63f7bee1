"""The search for a base in a tab: stopped, taken, undone, and out of the way of the hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from abi.explain.base_map import BaseMap, BaseTrial
from abi.explain.find_base import default_region
from abi.scene.scene import load_scene
from app.panels.base_offer import base_card
from app.panels.stages import find_base
from app.tab.session import Session
from app.ui import page
from tests.app.fake_tab import FakeTab, drawn_node, until

Tab = tuple[FakeTab, Session]


@pytest.fixture
def behind_a_wall(tab: Tab, monkeypatch: pytest.MonkeyPatch) -> Tab:
    monkeypatch.setattr(find_base, "_PORTION", 0.0)  # there is no other tab to leave a turn to
    fake, session = tab
    fake.set(session.panels.files.choice, "find-a-base")
    until(lambda: session.frame.plan.error is not None and session.resting)
    return tab


def _search(fake: FakeTab, session: Session) -> Any:
    panel = session.panels.stages.bases
    fake.set(panel.find, True)
    until(lambda: session.frame.bases is not None and session.frame.bases.is_done)
    assert session.frame.bases is not None
    return session.frame.bases


@pytest.mark.slow
def test_the_best_base_is_taken_and_undone(behind_a_wall: Tab) -> None:
    fake, session = behind_a_wall
    panel, before = session.panels.stages.bases, session.frame.plan.scene
    until(lambda: session.panels.history.noted == before)
    found = _search(fake, session)
    until(lambda: bool(panel.put.visible) and not panel.progress.visible)
    tiles = drawn_node(session, "/bases/tiles")
    assert len(tiles.batched_positions) == len(found.cells)
    assert len(np.unique(np.array(tiles.batched_colors), axis=0)) > 3

    fake.set(panel.put, True)
    until(lambda: session.frame.plan.scene.arm.base == found.best.base)
    until(lambda: session.frame.plan.error is None and session.resting)
    clearance = session.frame.plan.arm_clearance
    assert clearance is not None
    assert clearance.certified
    assert session.frame.bases is found, "the map stays, to try another place"

    fake.set(session.panels.history.undo, True)
    until(lambda: session.frame.plan.scene == before)


@pytest.mark.slow
def test_it_stops_when_asked_and_when_the_scene_changes(behind_a_wall: Tab) -> None:
    fake, session = behind_a_wall
    panel = session.panels.stages.bases
    fake.set(panel.find, True)
    until(lambda: session.frame.bases is not None)
    fake.set(panel.find, True)
    until(lambda: not panel.running)
    stopped = session.frame.bases
    assert stopped is not None
    assert not stopped.is_done

    fake.set(panel.find, True)
    until(lambda: session.frame.bases is not stopped)
    x, y, z = session.frame.plan.scene.obstacles[3].position
    fake.drag(session.panels.obstacles.gizmos[3], [x, y + 0.5, z])
    until(lambda: session.frame.plan.scene.obstacles[3].position[1] == y + 0.5)
    until(lambda: session.frame.bases is None and not panel.running)
    until(lambda: "/bases/tiles" not in session.client.scene._handle_from_node_name)
    until(lambda: not panel.gizmo.visible)  # the search has shown it

    fake.set(panel.show_region, True)
    fake.set(panel.find, True)
    until(lambda: session.frame.bases is not None)
    fake.drag(session.panels.obstacles.gizmos[3], [x, y, z])
    until(lambda: session.frame.bases is None and not panel.running)
    until(lambda: session.resting)
    assert panel.gizmo.visible, "a hand has shown it"


@pytest.mark.slow
def test_the_region_is_typed_and_dragged(behind_a_wall: Tab) -> None:
    fake, session = behind_a_wall
    region = session.panels.stages.bases
    np.testing.assert_allclose(region.corners, default_region(load_scene("find-a-base")))
    fake.set(region.sides.handle, [4.0, 2.0, 0.0])
    fake.drag(region.gizmo, [2.0, 8.0, 0.0])
    until(lambda: np.allclose(region.corners, [(0, 7, 0), (4, 9, 0)]))
    until(lambda: np.allclose(region.middle.handle.value, (2, 8, 0)))
    found = _search(fake, session)
    assert found.low == (0, 7, 0)
    assert all(7 <= trial.base[1] <= 9 and 0 <= trial.base[0] <= 4 for trial in found.trials)

    fake.set(region.sides.handle, [-1.0, 2.0, 0.0])
    until(lambda: np.allclose(region.sides.handle.value, (4, 2, 0)))
    np.testing.assert_allclose(region.corners, [(0, 7, 0), (4, 9, 0)])


def test_a_place_that_was_found_stands_over_the_scene_until_the_arm_stands_there(tab: Tab) -> None:
    _, session = tab
    until(lambda: session.resting)
    bases, frame = session.panels.stages.bases, session.frame
    scene = frame.plan.scene
    found = BaseMap(
        scene,
        *default_region(scene),
        trials=(BaseTrial((1.0, -4.0, 0.0), (1.0, 1.0, 0.0), length=7.5),),
        is_done=True,
    )
    assert base_card(bases, frame) == ""
    card = base_card(bases, replace(frame, bases=found))
    assert "7.500 cm" in card
    assert f'data-press="{page.uuid(bases.put)}"' in card
    there = replace(frame.plan, scene=scene.replace(arm={"base": [1.0, -4.0, 0.0]}))
    assert base_card(bases, replace(frame, bases=found, plan=there)) == ""
