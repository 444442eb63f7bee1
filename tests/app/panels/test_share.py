from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from abi import load_scene, plan
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.scene import Scene
from app.layers.result.motion_curves import acceleration, links_clearance, tool_clearance
from app.panels.files.share import png
from app.state.frame import Frame
from app.state.tab_state import TabState
from app.tab.session import Session
from app.teach.challenge import GOALS, Challenge, challenge_of, parsed
from app.teach.measures import MEASURES
from tests.app.fake_tab import FakeTab, heard, notified, until

PAPER = load_scene("paper")


def frame_of(scene: Scene) -> Frame:
    return Frame(plan(scene))


@pytest.mark.parametrize("goal", [goal for goal in GOALS if goal != "find a plan"])
def test_a_challenge_is_not_met_by_the_scene_that_it_starts_from(goal: str) -> None:
    frame = frame_of(PAPER)
    challenge = challenge_of(goal, frame)
    assert challenge is not None
    assert not challenge.is_met(frame)
    assert "Challenge" in challenge.html(False, frame)
    assert parsed(challenge.model_dump_json()) == challenge


def test_a_challenge_can_be_met() -> None:
    shorter = challenge_of("make it shorter", frame_of(PAPER))
    assert shorter is not None
    assert shorter.is_met(frame_of(PAPER.replace(search={"taut": True})))
    found = challenge_of("find a plan", frame_of(load_scene("no-way")))
    assert found is not None
    assert not found.is_met(frame_of(load_scene("no-way")))
    assert found.is_met(frame_of(PAPER))
    assert challenge_of("make it shorter", frame_of(load_scene("no-way"))) is None
    assert challenge_of("anything", frame_of(PAPER)) is None


def test_a_challenge_for_the_arm_asks_for_as_much_in_any_unit() -> None:
    arm = {name: getattr(PAPER.arm, name) for name in ("a1", "a2", "a3", "a4", "a5")}
    metres = PAPER.replace(
        unit="m",
        workspace={"max": [0.06, 0.06, 0.06]},
        goal=[0.06, 0.06, 0.06],
        obstacles=[{"shape": "box", "size": [0.02, 0.02, 0.02], "position": [0.03, 0.03, 0.03]}],
        mesh={"pitch": PAPER.mesh.pitch / 100},
        spline={"clearance": 0.002},
        motion={"speed": 0.04, "acceleration": 0.06, "deceleration": 0.06},
        arm={"base": [0.03, -0.03, 0], **{name: a / 100 for name, a in arm.items()}},
    )
    gains = []
    for scene, size in ((PAPER, 1.0), (metres, 0.01)):
        frame = frame_of(scene)
        challenge = challenge_of("keep the arm farther away", frame)
        assert challenge is not None
        asked, now = challenge.until[0].at_least, MEASURES["arm.clearance"](frame)
        assert asked is not None
        assert now is not None
        gains.append((asked - now) / size)
    assert gains[1] == pytest.approx(gains[0], rel=0.05)


def test_a_shorter_curve_than_the_best_possible_is_not_asked_for() -> None:
    (box,) = PAPER.obstacles
    near = frame_of(
        PAPER.replace(obstacles=[{**box.model_dump(mode="json"), "position": [3.5, 3, 3]}])
    )
    length, best = MEASURES["curve.length"](near), MEASURES["optimum.length"](near)
    assert length is not None
    assert best is not None
    assert 0.97 * length < best  # there are no 3 % to gain
    challenge = challenge_of("make it shorter", near)
    assert challenge is not None
    (most,) = (one.at_most for one in challenge.until if one.at_most is not None)
    assert best < most < length
    assert challenge.is_met(frame_of(near.plan.scene.replace(search={"taut": True})))
    taut = frame_of(PAPER.replace(obstacles=[], search={"taut": True}))
    assert challenge_of("make it shorter", taut) is None


@pytest.mark.parametrize("goal", ["make it shorter", "keep the quadratic clear"])
def test_an_obstacle_taken_away_meets_no_challenge_of_the_curve(goal: str) -> None:
    challenge = challenge_of(goal, frame_of(PAPER))
    assert challenge is not None
    away = frame_of(PAPER.replace(search={"taut": True}, obstacles=[]))
    assert all(condition.holds(away) for condition in challenge.until)
    assert not challenge.is_met(away)
    assert "have changed" in challenge.html(False, away)
    assert "have changed" not in challenge.html(False, frame_of(PAPER))


def test_a_challenge_is_not_met_through_a_wall() -> None:
    wall = frame_of(load_scene("wall-with-window"))
    assert wall.plan.error is None
    assert MEASURES["plan.complete"](wall) == 0
    assert MEASURES["plan.tool_complete"](wall) == 1
    for goal in ("find a plan", "keep the quadratic clear", "make it shorter"):
        challenge = challenge_of(goal, frame_of(PAPER))
        assert challenge is not None
        assert "with the whole arm clear" in challenge.text
        assert not challenge.is_met(wall)


@pytest.mark.slow
def test_a_motion_found_in_the_space_of_the_joints_is_complete() -> None:
    kitchen = load_scene("kitchen-ur5e").replace(arm={"axis": None, "search": "joints"})
    found = frame_of(kitchen)
    assert found.plan.joint_search is not None
    assert MEASURES["plan.complete"](found) == 1
    assert MEASURES["curve.length"](found) is None


def test_a_challenge_through_a_wall_says_that_it_is_for_the_tool_alone() -> None:
    wall = frame_of(load_scene("wall-with-window"))
    challenge = challenge_of("find a plan", wall)
    assert challenge is not None
    assert "for the tool tip alone" in challenge.text
    assert challenge.is_met(wall)
    farther = challenge_of("keep the arm farther away", wall)
    assert farther is not None
    assert "plan.complete" in {condition.measure for condition in farther.until}


@pytest.mark.parametrize("data", ["", "{", "[]", '{"text": "a", "until": []}', '{"text": 1}'])
def test_a_link_with_a_wrong_challenge_has_none(data: str) -> None:
    assert parsed(data) is None


def test_what_somebody_wrote_into_a_challenge_is_no_html() -> None:
    condition = {"measure": "plan.complete", "at_least": 1}
    challenge = Challenge.model_validate({"text": "<img onerror=x>", "until": [condition]})
    assert "<img" not in challenge.html(True, frame_of(PAPER))


def test_a_picture_is_a_png() -> None:
    rng = np.random.default_rng(1)
    for channels in (3, 4):
        picture = rng.integers(0, 256, (7, 5, channels), dtype=np.uint8)
        with Image.open(io.BytesIO(png(picture))) as read:
            assert np.array_equal(np.asarray(read), picture)


def test_a_link_opens_with_its_challenge(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    links = heard(monkeypatch, "copyLink")
    until(lambda: session.resting)
    fake.set(session.panels.share.goal, "keep the quadratic clear")
    fake.set(session.panels.share.challenge_link, True)
    until(lambda: len(links) == 1)
    state = TabState.decode(links[0], MeshSource({}, None))
    assert state.scene == session.frame.plan.scene
    challenge = parsed(state.challenge)
    assert challenge is not None
    session.panels.restore(replace(state, lessons=""))
    challenge = challenge.model_copy(update={"scene": "paper"})
    assert session.panels.share.challenge == challenge
    session.panels.share.draw(session.frame)
    assert "Challenge" in session.panels.layout.overlay.shown["challenge"]
    fake.set(session.panels.share.link, True)
    until(lambda: len(links) == 2)
    assert parsed(TabState.decode(links[1], MeshSource({}, None)).challenge) == challenge


def test_a_challenge_that_is_met_already_is_not_offered(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    told = notified(monkeypatch, session)
    links = heard(monkeypatch, "copyLink")
    until(lambda: session.resting)
    share = session.panels.share
    fake.set(share.goal, "find a plan")
    fake.set(share.challenge_link, True)
    until(lambda: told == [("No challenge", "This scene meets it already.")])
    assert not links


def test_a_challenge_waits_while_another_scene_is_shown_and_can_be_ended(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    panels, shown = session.panels, session.panels.layout.overlay.shown
    challenge = challenge_of("make it shorter", session.frame)
    assert challenge is not None
    state = replace(session.state(), challenge=challenge.model_dump_json())
    panels.restore(state)
    fake.set(panels.files.choice, "two-boxes")
    until(lambda: panels.files.name == "two-boxes" and not shown.get("challenge"))
    fake.set(panels.files.choice, "paper")
    until(lambda: panels.files.name == "paper" and "Challenge" in shown.get("challenge", ""))
    fake.set(panels.figures.buttons[0], "1")
    until(lambda: panels.figures.number == 1 and not shown["challenge"])
    fake.set(panels.figures.back, True)
    until(lambda: panels.figures.number == 0 and "Challenge" in shown["challenge"])
    fake.set(panels.share._end, True)
    until(lambda: not shown["challenge"])
    assert panels.share.kept == ""


@pytest.mark.parametrize("goal", list(GOALS))
def test_nobody_is_invited_to_drag_what_a_challenge_keeps(
    tab: tuple[FakeTab, Session], goal: str
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    panels, shown = session.panels, session.panels.layout.overlay.shown
    until(lambda: "Drag the orange box." in shown["message"])
    challenge = challenge_of(goal, session.frame)
    assert challenge is not None
    panels.restore(replace(session.state(), challenge=challenge.model_dump_json()))
    fake.set(panels.stages.fields["spline.degree"], 3)
    until(lambda: bool(shown.get("challenge")))
    until(lambda: ("Drag" in shown["message"]) == (challenge.task == ""))
    assert "B-spline" in shown["message"]  # what was done is told all the same
    fake.set(panels.share._end, True)
    until(lambda: "Drag the orange box." in shown["message"])


def test_curves_over_time_are_derivatives_and_distances() -> None:
    result = plan(PAPER)
    motion = result.motion
    assert motion is not None
    pull = acceleration(result)
    middle = slice(5, 40)
    # in the first phase the tool's speed grows by a1
    along = motion.tool_velocity / np.linalg.norm(motion.tool_velocity, axis=1, keepdims=True).clip(
        1e-9
    )
    tangential = (pull[:, 1:] * along).sum(axis=1)
    assert np.allclose(tangential[middle], PAPER.motion.acceleration, rtol=0.02)
    assert result.joint_rates is not None
    change = np.trapezoid(result.joint_rates.speeds, motion.time, axis=0)
    assert np.allclose(change, motion.positions[-1] - motion.positions[0], atol=1e-2)
    distances = tool_clearance(result)
    assert distances is not None
    assert distances.min() >= PAPER.spline.clearance - 1e-6
    assert tool_clearance(plan(PAPER.replace(obstacles=[]))) is None


def test_the_clearance_of_the_links_is_measured_at_all_times_beside_a_mesh() -> None:
    result = plan(load_scene("sculpture"))
    motion, arm = result.motion, result.arm
    assert motion is not None
    assert isinstance(arm, PaperArm)
    stride = 20
    distances = links_clearance(result, stride)
    assert distances is not None
    ends = arm.place(motion.positions[::stride])
    parts = np.linspace(0, 1, 400)[:, None]
    points = ends[:, :, None, 0] * (1 - parts) + ends[:, :, None, 1] * parts
    gaps = ObstacleSet(result.scene.obstacles).nearest(points.reshape(-1, 3))[0]
    radii = np.array([capsule.radius for capsule in arm.capsules])
    sampled = (gaps.reshape(points.shape[:3]).min(axis=2) - radii).min(axis=1)
    spacing = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).max() / 399
    assert (distances <= sampled + 1e-9).all()
    assert (distances >= sampled - spacing).all()
    assert links_clearance(plan(PAPER.replace(obstacles=[])), stride) is None


def test_h_shows_the_keys(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    gui = session.client.gui
    (command,) = (
        one for one in gui._command_handle_from_uuid.values() if one.label == "Show the keys"
    )
    fake.send({"type": "CommandTriggerMessage", "uuid": command._impl.uuid})
    until(lambda: len(gui._modal_handle_from_uuid) == 1)
