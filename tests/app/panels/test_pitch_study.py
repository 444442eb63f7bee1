from __future__ import annotations

from typing import Any

import numpy as np

from abi import load_scene, plan
from app.panels.stages.pitch_study import STEPS, study
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, labelled, until


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


def _results(session: Session) -> tuple[Any, ...]:
    """The note, the plot of lengths and that of nodes, which come last in their tab."""
    children = session.panels.layout.search._children.values()
    return tuple(sorted(children, key=lambda one: one.order)[-3:])  # type: ignore[attr-defined]


def test_the_plots_go_with_the_scene(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    note, length, nodes = _results(session)
    fake.set(labelled(session, "Plot against the spacing"), True)
    until(lambda: length.visible and nodes.visible)
    assert len(length.data[0]) >= 4
    assert length.title == "path length [cm] against spacing [cm]"
    assert not note.visible
    fake.drag(session.panels.ends.gizmos["start"], [0.0, 1.0, 0.0])
    until(lambda: not length.visible)


def test_a_scene_without_a_path_is_told_so(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    note, length, nodes = _results(session)
    fake.set(session.panels.files.choice, "no-way")
    until(lambda: session.panels.files.name == "no-way" and session.resting)
    fake.set(labelled(session, "Plot against the spacing"), True)
    until(lambda: note.visible)
    assert not length.visible
    assert not nodes.visible
