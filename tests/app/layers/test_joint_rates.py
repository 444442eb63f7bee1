"""Plots and peaks of the joints: every joint has its line, and what passes a limit is red."""

from __future__ import annotations

import numpy as np
import pytest
import viser

from abi.scene.scene import load_scene
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, open_plots, texts_in, until


@pytest.mark.slow
def test_every_joint_has_its_line_and_torques_where_there_are_masses(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    assert not _plots(session)
    open_plots(fake, session)
    until(lambda: "speeds" in _plots(session) and _plots(session)["speeds"].visible)
    assert not _plots(session)["torques"].visible
    assert "no masses of links" in _peaks(session)
    assert "torque" not in _lines_of_limits(session)
    assert "✗" not in _peaks(session)
    fake.set(session.panels.stages.fields["motion.joint_acceleration"], 0.01)
    until(lambda: "✗" in _peaks(session))

    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: "torques" in _plots(session) and _plots(session)["torques"].visible)
    assert "torque" in _lines_of_limits(session)
    plan = session.plan
    assert plan is not None
    assert plan.scene == load_scene("kitchen-ur5e")
    assert plan.motion is not None
    assert plan.joint_rates is not None
    assert plan.joint_rates.torques is not None
    plots = _plots(session)
    for plot in plots.values():
        assert len(plot.series) == len(plot.data)
    labels = [series["label"] for series in plots["torques"].series]
    assert labels[1:7] == list(plan.motion.joints)
    peak = max(float(np.abs(line).max()) for line in plots["torques"].data[1:7])
    assert abs(peak - np.abs(plan.joint_rates.torques).max()) < 0.05 * peak


def _plots(session: Session) -> dict[str, viser.GuiUplotHandle]:
    """The plots of rates by a word of their titles."""
    children = list(session.panels.layout.plots._children.values())
    plots = [one for one in children if isinstance(one, viser.GuiUplotHandle)]
    words = {"limits": "share of", "speeds": "joint speeds", "torques": "joint torques"}
    words["accelerations"] = "joint accelerations"
    titled = [
        (name, plot) for name, word in words.items() for plot in plots if word in str(plot.title)
    ]
    return dict(titled)


def _peaks(session: Session) -> str:
    return next(one for one in texts_in(session.panels.layout.plots) if "peak / limit" in one)


def _lines_of_limits(session: Session) -> list[object]:
    plot = _plots(session)["limits"]
    assert len(plot.series) == len(plot.data)
    return [series["label"] for series in plot.series if "label" in series]
