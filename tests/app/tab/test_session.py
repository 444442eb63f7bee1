"""A tab's session driven through the wire, without a browser."""

from __future__ import annotations

import itertools
import json
import math
import time
from functools import partial
from typing import Any

import numpy as np
import pytest
import viser

from abi.export.formats import FORMATS
from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.scene.scene import Scene, load_scene
from app.layers.arm.arm import ArmLayer
from app.panels.files.exports import send_plan
from app.server.server import Server, start
from app.shared.shared_plans import SharedPlans
from app.tab import pause
from app.tab.planner import TabPlanner
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, accept, layer, notified, opened, until


def test_a_tab_begins_with_the_complete_plan_of_the_paper(
    tab: tuple[FakeTab, Session],
) -> None:
    _, session = tab
    assert session.plan is not None
    assert session.plan.scene == load_scene("paper")
    assert session.plan.error is None
    assert session.plan.motion is not None


def test_dragging_the_obstacle_ends_on_its_last_position(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    gizmo = session.panels.obstacles.gizmos[0]
    first = session.plan
    for step in range(60):
        fake.drag(gizmo, [3.0, 3.0, 3.0 - step * 0.05])
    last = pytest.approx((3.0, 3.0, 3.0 - 59 * 0.05))
    until(lambda: session.plan.scene.obstacles[0].position == last)  # type: ignore[union-attr]

    assert session.plan is not first
    assert session.plan is not None
    assert session.plan.free is not None
    low, high = session.plan.scene.obstacles[0].bounds()
    points = session.plan.free.mesh.points
    inside = ((points >= low) & (points <= high)).all(axis=1)
    assert session.plan.free.excluded[inside].all()


def test_a_hand_moves_gizmos_of_its_own_tab_only(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    gizmo = session.panels.obstacles.gizmos[0]
    place = gizmo.position.tolist()
    other = FakeTab(f"http://127.0.0.1:{session.client._viser_server.get_port()}")
    message = {
        "type": "TransformControlsUpdateMessage",
        "name": gizmo.name,
        "wxyz": [1.0, 0.0, 0.0, 0.0],
        "position": [1.0, 2.0, 3.0],
    }
    own = gizmo._impl.api._owner_id
    other.send({**message, "owner": own})
    for owner in ("", "none", f"{own} "):
        fake.send({**message, "owner": owner})
    fake.drag(session.panels.ends.gizmos["goal"], [1.0, 1.0, 1.0])
    until(lambda: session.panels.ends.gizmos["goal"].position.tolist() == [1.0, 1.0, 1.0])
    other.close()
    assert gizmo.position.tolist() == place
    fake.send({**message, "owner": own})
    until(lambda: gizmo.position.tolist() == [1.0, 2.0, 3.0])


def test_a_hand_holds_a_gizmo_from_its_grip_until_it_lets_go(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    gizmo, obstacles = session.panels.obstacles.gizmos[0], session.panels.obstacles
    for step in range(5):
        fake.hold(gizmo)
        for k in range(10):
            fake.drag(gizmo, [3.0, 3.0, 2.0 + 0.1 * step + 0.01 * k])
        last = pytest.approx([3.0, 3.0, 2.09 + 0.1 * step])
        until(lambda last=last: gizmo.position.tolist() == last)  # type: ignore[misc]
        until(lambda: obstacles.held)
        fake.let_go(gizmo)
        until(lambda: not obstacles.held)


def test_what_is_typed_during_a_drag_counts(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panels = session.panels
    gizmo, stages = panels.obstacles.gizmos[0], panels.stages
    for step in range(12):
        spacing, clearance = 1.0 + 0.01 * step, 0.1 + 0.01 * step
        for k in range(6):
            fake.drag(gizmo, [3.0, 3.0, 2.0 + 0.1 * step + 0.01 * k])
            if k == step % 6:
                fake.set(stages.fields["mesh.pitch"], spacing)
            if k == step // 2:
                fake.set(stages.fields["spline.clearance"], clearance)
        fake.drag(panels.ends.gizmos["goal"], [5.0, 5.0, 4.0 + 0.1 * step])

        def arrived(step: int, spacing: float, clearance: float) -> bool:
            scene = session.scene
            return (
                scene.obstacles[0].position == pytest.approx((3.0, 3.0, 2.05 + 0.1 * step))
                and scene.goal == pytest.approx((5.0, 5.0, 4.0 + 0.1 * step))
                and scene.mesh.pitch == spacing
                and scene.spline.clearance == clearance
            )

        until(partial(arrived, step, spacing, clearance))


def test_an_end_that_is_refused_is_labelled_with_where_it_stands(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    label = session.panels.ends._labels["start"]
    assert label.text == "start (0, 0, 0)"
    fake.set(session.panels.editor._end_boxes["start"].handle, (9.0, 0.0, 0.0))
    until(lambda: session.frame.refused is not None)
    until(lambda: label.text == "start (9, 0, 0)")
    fake.set(session.panels.editor._end_boxes["start"].handle, (1.0, 0.0, 0.0))
    until(lambda: session.frame.refused is None)
    until(lambda: label.text == "start (1, 0, 0)")


def _stands(session: Session, place: list[float]) -> bool:
    return session.frame.plan.scene.obstacles[0].position == pytest.approx(tuple(place))


def test_what_is_refused_stays_so_while_a_hand_drags(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    gizmo, pitch = session.panels.obstacles.gizmos[0], session.panels.stages.fields["mesh.pitch"]
    fake.set(session.panels.stages.fields["motion.speed"], -1.0)
    until(lambda: session.frame.refused is not None)
    for step in range(5):
        frame = session.frame
        place = [3.0, 3.0, 2.0 + 0.1 * step]
        fake.drag(gizmo, place)
        until(lambda frame=frame: session.frame is not frame)  # type: ignore[misc]
        assert session.frame.refused is not None
        # what was typed wrongly is left out, and all else is planned
        until(partial(_stands, session, place))
        assert session.scene.motion.speed > 0
    fake.set(session.panels.stages.fields["motion.speed"], 1.5)
    fake.set(pitch, 1.1)
    until(lambda: session.frame.refused is None and session.scene.mesh.pitch == 1.1)
    assert session.scene.motion.speed == 1.5
    assert session.scene.obstacles[0].position == pytest.approx((3.0, 3.0, 2.4))


def test_where_a_link_touches_something_a_button_avoids_that(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    shown = session.panels.layout.overlay.shown
    fake.drag(session.panels.obstacles.gizmos[0], [3.5, 2.0, 3.0])
    until(lambda: "into obstacle 1" in shown.get("contact", ""))
    assert not session.plan.scene.arm.avoid  # type: ignore[union-attr]
    accept(fake, session, "Avoid with the whole arm")
    until(lambda: not shown["contact"] and session.resting)
    assert session.plan is not None
    assert session.plan.scene.arm.avoid
    assert session.panels.stages.arm.avoid.value
    assert session.plan.arm_clearance is not None
    assert session.plan.arm_clearance.certified


def test_nothing_is_told_of_the_last_scene_while_another_is_planned(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    shown = session.panels.layout.overlay.shown
    fake.set(session.panels.files.choice, "no-way")
    until(lambda: "Removing obstacle 1 opens a way" in shown["message"])
    planned, told = type(session._planner).__call__, []

    def plan(planner: TabPlanner, scene: Scene, shared: SharedPlans | None) -> Plan:
        told.append((scene, dict(shown)))
        return planned(planner, scene, shared)

    monkeypatch.setattr(TabPlanner, "__call__", plan)
    fake.set(session.panels.files.choice, "two-boxes")
    until(lambda: session.plan is not None and session.plan.bspline is not None)
    scene, parts = told[0]
    assert scene == load_scene("two-boxes")
    assert "Planning this scene" in parts["message"]
    assert "obstacle" not in parts["message"]
    until(lambda: "8.713 cm" in shown["message"])


@pytest.mark.slow
def test_an_unused_tab_gives_its_memory_back_and_goes_on_as_if_it_had_not(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    shown, planner = session.plan, session._planner.live._planner
    monkeypatch.setattr(pause, "UNUSED", 0.1)
    until(lambda: session._planner.live._planner is not planner)
    monkeypatch.undo()
    forgotten = session._planner.live._planner
    assert session.plan is shown

    fake.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 2.0])
    until(lambda: session.plan.scene.obstacles[0].position[2] == 2.0 and session.resting)  # type: ignore[union-attr]
    assert session.plan is not None
    assert session.plan.error is None
    assert len(session.plan.searches) == 3
    assert session._planner.live._planner is forgotten


def test_what_was_overtaken_is_not_planned(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.35)
    until(lambda: session.plan.scene.mesh.pitch == 0.35)  # type: ignore[union-attr]
    before = session.plans
    for step in range(200):
        fake.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 3.0 - step * 0.01])
    until(
        lambda: math.isclose(session.plan.scene.obstacles[0].position[2], 1.01)  # type: ignore[union-attr]
    )

    # one or two sufficed for a quick plan, and a slow one is overtaken all the more
    assert session.plans - before < 100


@pytest.mark.slow
def test_a_fine_mesh_is_coarser_while_the_hand_moves_and_whole_once_it_rests(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    seen: set[int] = set()

    def moved() -> bool:
        assert session.plan is not None
        assert session.plan.mesh is not None
        seen.add(len(session.plan.mesh.points))
        place = session.plan.scene.obstacles[0].position
        pitch = session.plan.scene.mesh.pitch  # one is heard by another thread than the other
        return math.isclose(place[2], 2.0) and pitch == 0.25 and len(session.plan.searches) == 3

    session._planner.live.budget.nodes = 6_000
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.25)
    for step in range(20):
        fake.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 3.0 - step * 0.05])
    fake.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 2.0])
    until(moved)

    assert session.plan is not None
    assert session.plan.scene.mesh.pitch == 0.25
    assert session.plan.error is None
    assert any(189 < count < 7_000 for count in seen)
    assert max(seen) > 15_000


@pytest.mark.slow
@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0, 0.0, 1e-9, 1e300])
def test_a_bad_number_keeps_the_last_plan_and_says_why(
    tab: tuple[FakeTab, Session], value: float
) -> None:
    fake, session = tab
    good = session.plan
    shown = session.panels.layout.overlay.shown
    fake.set(session.panels.stages.fields["mesh.pitch"], value)
    until(lambda: "✗" in shown["message"])

    assert session.plan is good
    assert "The node spacing must be " in shown["message"]

    fake.set(session.panels.stages.fields["mesh.pitch"], 1.0)
    until(lambda: session.plan.scene.mesh.pitch == 1.0)  # type: ignore[union-attr]
    until(lambda: "✗" not in shown["message"])


@pytest.mark.slow
@pytest.mark.parametrize("value", ["junk", None, [1, 2], {"a": 1}, "B-spline"])
def test_a_value_of_another_kind_never_ends_the_session(
    tab: tuple[FakeTab, Session], value: Any
) -> None:
    fake, session = tab
    fake.set(session.panels.stages.fields["motion.curve"], value)
    fake.set(session.panels.stages.arm.elbow, value)
    fake.set(session.panels.stages.fields["spline.degree"], 3)
    fake.set(session.panels.stages.fields["motion.curve"], "quadratic")
    fake.set(session.panels.stages.arm.elbow, "down")
    until(lambda: session.plan.scene.arm.elbow == "down")  # type: ignore[union-attr]

    assert session.plan is not None
    assert session.plan.scene.spline.degree == 3


def test_a_speed_runs_the_motion_only(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    # the first plan may be another tab's
    fake.set(session.panels.stages.fields["spline.degree"], 3)
    until(lambda: session.plan.scene.spline.degree == 3 and session.resting)  # type: ignore[union-attr]
    before = session.plan
    fake.set(session.panels.stages.fields["motion.speed"], 2.0)
    until(lambda: session.plan is not before)

    assert before is not None
    assert session.plan is not None
    assert session.plan.quadratic is before.quadratic
    assert session.plan.profile is not before.profile


def test_another_scene_fills_the_panels(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "no-way")
    until(lambda: session.plan.scene == load_scene("no-way"))  # type: ignore[union-attr]

    assert session.plan is not None
    assert session.plan.error is not None
    shown = session.panels.layout.overlay.shown
    assert "No path" in shown["message"]
    assert session.panels.stages.fields["mesh.pitch"].value == load_scene("no-way").mesh.pitch

    fake.set(session.panels.files.choice, "paper")
    until(lambda: session.plan.scene == load_scene("paper"))  # type: ignore[union-attr]
    until(lambda: "✗" not in shown["message"])


def test_play_moves_the_arm_and_pause_holds_it(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    slider = session.playback.slider
    until(lambda: session.frame.playing)
    fake.set(slider, 1.25)
    until(lambda: not session.playback.playing)

    assert session.plan is not None
    assert session.plan.motion is not None
    assert slider.value == pytest.approx(1.25)
    motion = session.plan.motion
    index = int(np.searchsorted(motion.time, 1.25))

    def traced() -> bool:
        drawn = layer(session, ArmLayer)._trace.points.reshape(-1, 3)[-1]
        return bool(np.linalg.norm(drawn[:2] - motion.tool[index][:2]) < 0.05)

    until(traced)


def test_a_time_set_right_after_a_pause_is_said_again(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    until(lambda: session.frame.playing)
    fake.set(session.playback.slider, 0.5)
    until(lambda: not session.frame.playing)
    fake.set(session.playback.button, True)
    until(lambda: session.frame.playing)
    fake.set(session.playback.button, True)
    until(lambda: not session.playback.playing)
    fake.set(session.playback.slider, 1.25)
    # by a last bit, since a frame still on its way may have taken it from the page
    until(lambda: session.playback.slider.value == math.nextafter(1.25, 0.0))
    until(lambda: session.playback._time == session.playback.slider.value)


def test_two_tabs_share_nothing(server: Server, tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    other, second = opened(server)
    before = second.plan
    fake.set(session.panels.stages.fields["spline.degree"], 5)
    until(lambda: session.plan.scene.spline.degree == 5)  # type: ignore[union-attr]

    assert second.plan is before
    assert second.panels.stages.fields["spline.degree"].value == 4
    other.close()
    until(lambda: len(server.sessions) == 1)


@pytest.mark.slow
def test_surroundings_come_once_after_the_first_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[Any, bool]] = []
    sessions: dict[int, Session] = {}

    def configure(_: object, hdri: str | None = "some") -> None:
        calls.append((hdri, any(session.plan is not None for session in sessions.values())))

    monkeypatch.setattr(viser.SceneApi, "configure_environment_map", configure)
    running = start(port=0, scene="paper")
    sessions = running.sessions
    fake = FakeTab(running.url)
    until(lambda: len(calls) == 2)
    (session,) = sessions.values()
    plans = session.plans
    fake.set(session.panels.stages.fields["motion.speed"], 3.0)
    until(lambda: session.plans > plans)
    fake.close()
    running.stop()
    assert calls == [(None, False), ("some", True)]


@pytest.mark.slow
def test_without_a_graphics_card_there_are_no_lights(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pause, "LIGHTS_DELAY", math.inf)
    running = start(port=0, scene="paper")
    fake, session = opened(running)
    until(lambda: session.resting)
    assert session._pause.timeout(session.frame) == pause.REST  # for lights that are to come
    fake.set(session._memory._box, json.dumps({"software": True}))
    until(lambda: session._pause.timeout(session.frame) == pause.IDLE)
    fake.close()
    running.stop()


@pytest.mark.slow
def test_a_plan_is_downloaded_in_the_format_chosen(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    sent: dict[str, bytes] = {}
    monkeypatch.setattr(
        session.client,
        "send_file_download",
        lambda file, content, save_immediately: sent.update({file: content}),
    )
    refused = notified(monkeypatch, session)
    panels = session.panels
    for row in (row for name, row in FORMATS.items() if name != "urscript"):
        fake.set(panels.export_format, row.label)
        until(lambda label=row.label: panels.export_format.value == label)  # type: ignore[misc]
        fake.set(panels.export, True)
        until(lambda file=row.file: file in sent)  # type: ignore[misc]
        assert session.plan is not None
        if row.file != "plan.json":  # which holds how long the plan took
            assert sent[row.file] == row.write(session.plan, row.file)

    fake.set(panels.export_format, FORMATS["csv"].label)
    fake.set(session.panels.files.choice, "no-way")
    until(lambda: session.plan is not None and session.plan.motion is None)
    fake.set(panels.export, True)
    until(lambda: bool(refused))
    assert refused[0][1].startswith("There is no motion to export: ")


def test_a_motion_through_a_wall_is_exported_with_a_notice(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, session = tab
    sent: list[str] = []
    monkeypatch.setattr(
        session.client,
        "send_file_download",
        lambda file, content, save_immediately: sent.append(file),
    )
    told = notified(monkeypatch, session)
    until(lambda: session.resting)
    send_plan(session.client, FORMATS["csv"].label, plan(load_scene("paper")))
    assert (sent, told) == (["motion.csv"], [])
    send_plan(session.client, FORMATS["csv"].label, plan(load_scene("wall-with-window")))
    assert len(sent) == 2
    assert told[0][1].startswith("The slide goes 0.549 cm into obstacle 2")


def test_tabs_that_open_alike_share_their_first_plan_and_no_other(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    until(lambda: not server.sessions)
    planned: list[object] = []
    make = LivePlanner.__call__

    def counted(planner: LivePlanner, scene: Scene) -> Plan:
        planned.append(scene)
        return make(planner, scene)

    monkeypatch.setattr(LivePlanner, "__call__", counted)
    fakes = [opened(server) for _ in range(3)]
    sessions = [session for _, session in fakes]
    assert len({id(session.plan) for session in sessions}) == 1
    assert len(planned) <= 1
    # where one goes on, it goes on alone
    fakes[0][0].set(sessions[0].panels.stages.fields["spline.degree"], 3)
    until(lambda: sessions[0].plan.scene.spline.degree == 3)  # type: ignore[union-attr]
    assert sessions[1].plan is sessions[2].plan
    assert sessions[1].plan.scene.spline.degree == 4  # type: ignore[union-attr]
    for fake, _ in fakes:
        fake.close()
    until(lambda: not server.sessions)


def test_a_clock_that_is_set_back_holds_nothing_up(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    now = time.time()
    hours = itertools.count(1)
    monkeypatch.setattr(time, "time", lambda: now - 3600.0 * next(hours))
    (gizmo, *_) = session.panels.obstacles.gizmos
    for x in (2.5, 3.5, 3.0):
        fake.drag(gizmo, [x, 3.0, 3.0])
        until(lambda x=x: session.plan.scene.obstacles[0].position[0] == x)  # type: ignore[misc, union-attr]
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.9)
    until(lambda: session.plan.scene.mesh.pitch == 0.9 and session.resting)  # type: ignore[union-attr]
    until(lambda: session._memory._kept is None or session._memory._kept.scene.mesh.pitch == 0.9)
    assert session._fault is None
