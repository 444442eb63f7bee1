"""Plots and peaks of the joints: every joint has its line, and what passes a limit is red."""

from __future__ import annotations

import numpy as np
import pytest

from abi.scene.scene import load_scene
from app.layers.result.joint_rates import JointRatesLayer
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, layer, open_plots, until


@pytest.mark.slow
def test_every_joint_has_its_line_and_torques_where_there_are_masses(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    drawn = layer(session, JointRatesLayer)
    until(lambda: session.resting)
    assert not drawn._plots
    open_plots(fake, session)
    until(lambda: bool(drawn._plots) and drawn._plots["speeds"].visible)
    assert not drawn._plots["torques"].visible
    assert "no masses of links" in drawn._peaks.content
    assert "torque" not in _lines_of_limits(drawn)
    assert "✗" not in drawn._peaks.content
    fake.set(session.panels.stages.fields["motion.joint_acceleration"], 0.01)
    until(lambda: "✗" in drawn._peaks.content)

    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: "torques" in drawn._plots and drawn._plots["torques"].visible)
    assert "torque" in _lines_of_limits(drawn)
    plan = session.plan
    assert plan is not None
    assert plan.scene == load_scene("kitchen-ur5e")
    assert plan.motion is not None
    assert plan.joint_rates is not None
    assert plan.joint_rates.torques is not None
    for plot in drawn._plots.values():
        assert len(plot.series) == len(plot.data)
    labels = [series["label"] for series in drawn._plots["torques"].series]
    assert labels[1:7] == list(plan.motion.joints)
    peak = max(float(np.abs(line).max()) for line in drawn._plots["torques"].data[1:7])
    assert abs(peak - np.abs(plan.joint_rates.torques).max()) < 0.05 * peak


def _lines_of_limits(drawn: JointRatesLayer) -> list[object]:
    plot = drawn._plots["limits"]
    assert len(plot.series) == len(plot.data)
    return [series["label"] for series in plot.series if "label" in series]
