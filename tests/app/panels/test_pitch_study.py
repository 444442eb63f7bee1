from __future__ import annotations

import numpy as np

from abi import load_scene, plan
from app.panels.stages.pitch_study import STEPS, study
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until


def test_each_point_is_the_plan_of_its_pitch() -> None:
    scene = load_scene("paper")
    pitches, lengths, expanded = study(scene)
    assert 4 <= len(pitches) <= STEPS
    assert (np.diff(pitches) > 0).all()
    for k in (0, -1):
        other = plan(scene.replace(mesh={"pitch": float(pitches[k])}))
        assert other.path is not None
        assert (other.path.length, other.path.expanded) == (lengths[k], expanded[k])
    assert expanded[0] > expanded[-1]


def test_without_a_path_there_is_nothing_to_plot() -> None:
    pitches, lengths, expanded = study(load_scene("no-way"))
    assert len(pitches) == len(lengths) == len(expanded) == 0


def test_the_plots_go_with_the_scene(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel = session.panels.studies
    fake.set(panel.plot, True)
    until(lambda: panel.length.visible and panel.expanded.visible)
    assert len(panel.length.data[0]) >= 4
    assert panel.length.title == "path length [cm] against spacing [cm]"
    fake.drag(session.panels.ends.gizmos["start"], [0.0, 1.0, 0.0])
    until(lambda: not panel.length.visible)


def test_a_scene_without_a_path_is_told_so(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel = session.panels.studies
    fake.set(session.panels.files.choice, "no-way")
    until(lambda: session.panels.files.name == "no-way" and session.resting)
    fake.set(panel.plot, True)
    until(lambda: panel.note.visible)
    assert not panel.length.visible
    assert not panel.expanded.visible
