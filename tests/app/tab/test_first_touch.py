"""The scene that the page opens on shows nothing red that is not the visitor's doing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import abi
from abi.arrays import FloatArray
from abi.planner.live_planner import LivePlanner
from abi.scene.scene import load_scene
from app.cli.serve import serve
from app.state.appearance import OPENING
from app.tab import demo
from benchmarks.first_touch import measure, verdict


def test_a_server_opens_on_it_where_no_scene_is_named() -> None:
    assert serve.make_context("serve", []).params["scene"] == OPENING


@pytest.mark.slow
def test_the_arm_has_a_proven_motion_wherever_the_box_is() -> None:
    found = measure(15, seed=7)
    assert (found["proven"], found["verdicts"]) == (15, {})


@pytest.mark.slow
def test_the_demonstration_touches_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    abi.compile()
    scene, planner = load_scene(OPENING), LivePlanner()
    went: list[FloatArray] = []
    gizmo = SimpleNamespace(position=np.array(scene.obstacles[0].position))
    obstacles: Any = SimpleNamespace(
        shown=[SimpleNamespace(gizmo=gizmo)],
        dragged=False,
        place=lambda number, place: went.append(np.array(place)),
    )
    moves, now = demo.Demo(obstacles), [0.0]
    monkeypatch.setattr(demo, "time", SimpleNamespace(monotonic=lambda: now[0]))
    moves.begin(scene)
    while moves.running:
        now[0] += 0.4
        moves.step()
    assert np.ptp(went, axis=0).max() > 1.0
    for place in went:
        box = scene.obstacles[0].model_dump(mode="json") | {"position": place.tolist()}
        assert verdict(planner(scene.replace(obstacles=[box]))) == "", place
