"""Another arm in a tab: chosen, drawn, uploaded, refused."""

from __future__ import annotations

import base64
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser
import viser.transforms

from abi import compiling, plan
from abi.obstacles.pose import rotation
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.kinematics.chain_kernels import POSE
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene, load_scene
from app.layers.arm.arm import ArmLayer
from app.layers.arm.arm_ghosts import _poses_of
from app.layers.arm.arm_nodes import JointNode
from app.layers.arm.arm_playback import samples_of
from app.layers.arm.link_body import link_mesh
from app.layers.arm.urdf_arm import _muted, joint_origin, joint_values
from app.layers.arm.urdf_poses import end_pose, other_poses, poses_at
from app.panels.stages.arm import ArmPanel
from app.tab.session import Session
from tests.abi.robot import robots
from tests.abi.robot.robots import OWN, arm, packed
from tests.abi.robot.test_visuals import dae, looking
from tests.app.fake_tab import FakeTab, accept, drawn_node, heard, layer, notified, send_file, until


def panel(session: Session) -> ArmPanel:
    return session.panels.stages.arm


def planned_arm(session: Session) -> object:
    return None if session.plan is None else session.plan.arm


def upload(session: Session, name: str, content: bytes) -> None:
    """Hand over an uploaded file as viser does."""
    send_file(session, panel(session).model.upload, name, content)


@pytest.mark.slow
def test_an_arm_is_chosen_drawn_and_left(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: isinstance(planned_arm(session), UrdfArm))
    until(lambda: session.resting)
    drawn = layer(session, ArmLayer)

    assert session.plan is not None
    assert session.plan.scene == load_scene("kitchen-ur5e")
    assert session.panels.read(session.plan.scene) == session.plan.scene
    assert panel(session).model.model.value == "UR5e"
    assert panel(session).model.tip.value == "tool0"
    assert panel(session).model.direction.value == "down"
    assert not panel(session).links.visible
    assert drawn._nodes.root.name == "/robot"
    assert drawn._nodes.root.visible
    assert len(drawn._nodes.joint_nodes) == 6

    fake.set(panel(session).model.model, "xArm7")
    until(lambda: session.plan is not None and session.plan.scene.arm.urdf == "xarm7")
    until(lambda: len(drawn._nodes.joint_nodes) == 7)
    assert panel(session).model.tip.value == "link_eef"

    fake.set(panel(session).model.mount, "on the ceiling")
    until(lambda: session.plan is not None and session.plan.scene.arm.base_wxyz == (0, 1, 0, 0))
    until(lambda: np.allclose(drawn._nodes._base.wxyz, (0, 1, 0, 0)))  # type: ignore[union-attr]
    assert session.plan is not None
    again = Scene.from_dict(session.plan.scene.to_dict())
    assert again.arm.base_wxyz == (0, 1, 0, 0)
    panel(session).write(again)
    assert panel(session).model.mount.value == "on the ceiling"

    fake.set(panel(session).model.model, "the paper's arm")
    until(lambda: isinstance(planned_arm(session), PaperArm))
    until(lambda: drawn._nodes.root.name == "/arm" and drawn._nodes.root.visible)
    assert not drawn._kinds[UrdfArm].root.visible
    assert panel(session).links.visible


@pytest.mark.slow
def test_an_upload_is_an_arm_or_a_sentence(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    told = notified(monkeypatch, session)
    upload(session, "bad.zip", b"PK\x03\x04")
    until(lambda: any("zip" in sentence for _, sentence in told))
    assert isinstance(planned_arm(session), PaperArm)

    upload(session, "own arm.zip", packed({"x/own.urdf": arm()}))
    until(lambda: isinstance(planned_arm(session), UrdfArm))
    assert session.plan is not None
    assert session.plan.scene.arm.urdf == "own arm.zip"
    assert panel(session).model.tip.value == "d"

    damaged = packed({"own.urdf": looking("a.dae"), "a.dae": b"<COLLADA>"})
    upload(session, "damaged.zip", damaged)
    until(lambda: any("visuals cannot be read: a." in sentence for _, sentence in told))

    upload(session, "plain.urdf", arm().encode())
    until(lambda: session.plan is not None and session.plan.scene.arm.urdf == "plain.zip")
    assert panel(session).model.base_link.options == ("a", "b", "c")
    fake.set(panel(session).model.base_link, "b")
    until(lambda: session.plan is not None and session.plan.scene.arm.base_link == "b")
    drawn = layer(session, ArmLayer)
    until(lambda: len(drawn._nodes.joint_nodes) == 2)
    assert session.plan is not None
    panel(session).write(session.plan.scene)
    assert panel(session).model.base_link.value == "b"
    fake.set(panel(session).model.tip, "c")
    until(lambda: session.plan is not None and session.plan.scene.arm.tip == "c")
    assert panel(session).model.base_link.options == ("a", "b")
    assert session.plan.scene.arm.base_link is None


@pytest.mark.slow
def test_one_of_several_robots_in_a_file_is_chosen_by_name(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    told = notified(monkeypatch, session)
    other = arm(('type="prismatic"', 'type="revolute"'))
    files: dict[str, str | bytes] = {"p/urdf/one.urdf": arm(), "p/urdf/two.urdf": other}
    upload(session, "package.zip", packed(files))
    choice = panel(session).model.uploads.choice
    assert choice is not None
    until(lambda: choice.visible and len(choice.options) > 1)
    assert choice.options[1:] == ("p/urdf/one.urdf", "p/urdf/two.urdf")
    assert isinstance(planned_arm(session), PaperArm)
    for name in ("two", "one"):
        fake.set(choice, f"p/urdf/{name}.urdf")
        until(lambda: session.plan.scene.arm.urdf == f"{name}.zip")  # type: ignore[union-attr]  # noqa: B023
        until(lambda: session.resting)
        assert choice.visible
        assert session.plan is not None
        kinds = [joint.kind for joint in session.plan.scene.arm.robot.joints]
        assert kinds[2] == ("revolute" if name == "two" else "prismatic")
    upload(session, "single.urdf", arm().encode())
    until(lambda: session.plan.scene.arm.urdf == "single.zip")  # type: ignore[union-attr]
    assert not choice.visible
    assert not [sentence for title, sentence in told if "not added" in title]


@pytest.mark.slow
def test_a_gripper_takes_the_states_that_its_srdf_names(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    until(lambda: session.resting)
    hand = robots.urdf(
        *map(robots.link, "abcde"),
        robots.joint("p", "a", "b"),
        robots.joint("q", "b", "c", axis="1 0 0"),
        robots.joint("left", "c", "d", axis="1 0 0"),
        robots.joint("right", "c", "e", axis="1 0 0"),
    )
    states = "".join(
        f'<group_state name="{name}" group="hand"><joint name="left" value="{at}"/>'
        f'<joint name="right" value="{-at}"/></group_state>'
        for name, at in (("open", 0.7), ("closed", 0.1))
    )
    group = '<group name="hand"><joint name="left"/><joint name="right"/></group>'
    srdf = f'<robot name="r">{group}{states}</robot>'
    upload(session, "hand.zip", packed({"hand.urdf": hand, "hand.srdf": srdf}))
    until(lambda: session.plan.scene.arm.urdf == "hand.zip")  # type: ignore[union-attr]
    assert panel(session).model.tip.value == "c"
    gripper = panel(session).model.gripper
    assert gripper.state.options[1:3] == ("open", "closed")
    fake.set(gripper.state, "open")
    until(lambda: session.plan.scene.arm.gripper == {"left": 0.7, "right": -0.7})  # type: ignore[union-attr]
    fake.set(gripper.sliders["left"], 0.3)
    until(lambda: session.plan.scene.arm.gripper == {"left": 0.3, "right": -0.7})  # type: ignore[union-attr]
    assert gripper.state.value == "by its joints"


@pytest.mark.slow
def test_a_grippers_joints_are_held_where_their_sliders_are(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    until(lambda: session.resting)
    fake.set(panel(session).model.model, "Franka Panda")
    until(lambda: session.plan.scene.arm.urdf == "panda")  # type: ignore[union-attr]
    until(lambda: session.resting)
    gripper = panel(session).model.gripper
    (finger,) = gripper.sliders.values()  # the other follows it
    assert (finger.min, finger.max) == pytest.approx((0, 4))  # in cm, as the scene
    fake.set(finger, 3.0)
    until(lambda: session.plan.scene.arm.gripper == {"panda_finger_joint1": 3.0})  # type: ignore[union-attr]
    made = planned_arm(session)
    assert isinstance(made, UrdfArm)
    assert made.chain.held["panda_finger_joint1"] == pytest.approx(0.03)

    fake.set(gripper.state, "at its lower limits")
    until(lambda: session.plan.scene.arm.gripper == {"panda_finger_joint1": 0.0})  # type: ignore[union-attr]
    assert finger.value == 0

    assert session.plan is not None
    closed = session.plan.scene.replace(arm={"gripper": {"panda_finger_joint1": 0.5}})
    panel(session).write(closed)
    assert finger.value == pytest.approx(0.5)
    assert session.panels.read(closed) == closed
    fake.set(panel(session).model.tip, "panda_leftfinger")
    until(lambda: session.plan.scene.arm.tip == "panda_leftfinger")  # type: ignore[union-attr]
    assert not gripper.sliders
    assert session.plan.scene.arm.gripper == {}


@pytest.mark.slow
def test_a_scene_that_is_opened_tells_what_is_left_out_of_its_arm(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, session = tab
    told = notified(monkeypatch, session)
    damaged = packed({"own.urdf": looking("a.dae"), "a.dae": b"<COLLADA>"})
    data = {"version": 1, "arm": {"model": "urdf", "urdf": "damaged.zip"}}
    scene = Scene.from_dict(data, MeshSource({"damaged.zip": damaged}))
    until(lambda: session.resting)
    for _ in range(2):  # once for an arm
        panel(session).model.write(scene)
        assert [sentence for _, sentence in told] == [
            "The tool tip is d; p, q, s are planned.",
            "Drawn by collision shapes, as visuals cannot be read: a.",
        ]


def test_the_papers_arm_in_a_scene_of_another_size_says_so_and_is_fitted(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    kitchen = load_scene("kitchen-ur5e")
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: session.plan.scene == kitchen and session.resting)  # type: ignore[union-attr]
    shown = session.panels.layout.overlay.shown
    model = panel(session).model.model
    fake.set(model, model.options[0])
    until(lambda: session.frame.plan.scene.arm.model == "abi" and session.resting)

    def told() -> str:
        return shown["message"] + shown.get("contact", "")

    until(lambda: "This arm is too large for the scene" in told())
    assert "Find a base" not in told()
    usual = ArmSettings()
    accept(fake, session, "Fit the arm to the scene")
    until(lambda: session.frame.plan.scene.arm.a1 < usual.a1 and session.resting)
    until(lambda: "too large" not in told())
    # as in the paper, whose workspace is six times as large as this, in its unit
    fitted = session.frame.plan.scene.arm
    for name in ("a1", "a2", "a3", "a4", "a5"):
        assert getattr(fitted, name) == pytest.approx(getattr(usual, name) / 6, rel=1e-2)
    assert (fitted.base, fitted.clearance) == (kitchen.arm.base, kitchen.arm.clearance)


def test_an_arm_of_another_size_than_the_scene_says_so(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    told = notified(monkeypatch, session)
    for scene, name in (("kitchen-ur5e", "Franka Panda"), ("paper", "UR5e")):
        loaded = load_scene(scene)
        fake.set(session.panels.files.choice, scene)
        until(lambda: session.plan.scene == loaded and session.resting)  # type: ignore[union-attr]  # noqa: B023
        fake.set(panel(session).model.model, name)
        until(lambda: session.plan.scene != loaded and session.resting)  # type: ignore[union-attr]  # noqa: B023
        assert isinstance(planned_arm(session), UrdfArm)
        assert panel(session).model.model.value == name
        assert not told
    # it stands over the scene, where no other base is offered
    shown = session.panels.layout.overlay.shown
    until(lambda: "This arm is too large for the scene" in shown["message"])  # out of reach
    assert "kitchen-ur5e" in shown["message"]
    assert "Find a base" not in shown["message"]
    fake.set(panel(session).model.direction, "any")
    until(lambda: session.frame.plan.scene.arm.axis is None)
    until(lambda: "This arm is too large for the scene" in shown.get("contact", ""))
    # one step to the scene that is made for it, and one back
    assert "Open kitchen-ur5e</button>" in shown["contact"]
    before = session.frame.plan.scene
    fake.set(session.panels.messages._other_scene, True)
    until(lambda: session.frame.plan.scene == load_scene("kitchen-ur5e") and session.resting)
    assert session.panels.files.choice.value == "kitchen-ur5e"
    assert session.frame.plan.is_arm_clear
    fake.set(session.panels.history.undo, True)
    until(lambda: session.frame.plan.scene == before and session.resting)
    assert session.panels.files.choice.value == "paper"


def posed(sent: dict[str, Any], row: int) -> viser.transforms.SE3:
    """Last node of the joints, in the base, as ``assets/page/page.js`` poses it at a sample."""
    table = np.frombuffer(base64.b64decode(sent["samples"]), "<f4").reshape(-1, sent["columns"])
    pose, name = viser.transforms.SE3.identity(), ""
    for joint in sent["joints"]:
        assert joint["name"].rpartition("/")[0] == name or not name
        name, value = joint["name"], float(table[row, joint["column"]])
        axis, place = np.array(joint["axis"]), np.array(joint["position"])
        turn = viser.transforms.SO3(np.array(joint["wxyz"]))
        if joint["prismatic"]:
            place = place + value * axis
        else:
            turn = turn @ viser.transforms.SO3.exp(value * axis)
        pose = pose @ viser.transforms.SE3.from_rotation_and_translation(turn, place)
    return pose


@pytest.mark.slow
def test_the_page_plays_an_arm_of_a_urdf_by_itself(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    sent = heard(monkeypatch, "play")
    compiling.compile()
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: isinstance(planned_arm(session), UrdfArm) and session.resting)
    until(lambda: session.frame.playing and bool(sent) and len(sent[-1]["joints"]) == 6)
    assert session._view.timeout(session.frame) is None
    assert not session._view.is_due(session.frame)

    assert session.plan is not None
    made, motion = session.plan.arm, session.plan.motion
    assert isinstance(made, UrdfArm)
    assert motion is not None
    rows = samples_of(motion)
    tip = made.chain.table.origins[-POSE:]
    for number in (0, 50, 100):
        at = posed(sent[-1], number) @ (tip[9:] / made.metres) + made.base
        np.testing.assert_allclose(at, motion.tool[rows[number]], atol=1e-5 * made.reach)


def _is_shown(session: Session, node: str) -> bool:
    handle = session.client.scene._handle_from_node_name.get(node)
    return handle is not None and handle.visible


@pytest.mark.slow
def test_ghosts_and_regions_are_those_of_any_arm(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: isinstance(planned_arm(session), UrdfArm) and session.resting)
    fake.set(session.playback.slider, 1.0)
    nodes = {
        "other_elbow": ("/arm_ghost/now",),
        "end_poses": ("/arm_ghost/start", "/arm_ghost/goal"),
        "shadow": ("/arm_region/shadow",),
        "reach": ("/arm_region/reach",),
    }
    for switch, names in nodes.items():
        fake.set(session.panels.layer_switches.boxes[switch], True)
        until(lambda: all(_is_shown(session, name) for name in names))  # noqa: B023
    for region in ("shadow", "reach"):
        assert len(drawn_node(session, f"/arm_region/{region}").vertices) > 100
    for switch in nodes:
        fake.set(session.panels.layer_switches.boxes[switch], False)
    for names in nodes.values():
        until(lambda: not any(_is_shown(session, name) for name in names))  # noqa: B023


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "kitchen-ur5e"])
def test_the_page_plays_the_other_poses_by_itself(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    fake, session = tab
    sent = heard(monkeypatch, "follow")
    compiling.compile()
    scene = load_scene(name)
    fake.set(session.panels.files.choice, name)
    fake.set(session.panels.layer_switches.boxes["other_elbow"], True)
    until(lambda: session.plan is not None and session.plan.scene == scene and session.resting)
    until(lambda: session.frame.playing and bool(sent) and sent[-1] is not None)
    frame = session.frame
    count = len(sent)
    assert session._view.timeout(frame) is None  # nothing is sent while it plays
    plan = frame.plan
    assert plan.arm is not None
    assert plan.motion is not None
    names = sent[-1]["names"]
    table = np.frombuffer(base64.b64decode(sent[-1]["places"]), "<f4")
    places = table.reshape(-1, len(names), 7)
    rows = samples_of(plan.motion)
    assert len(places) == len(rows)
    assert all(name.startswith("/arm_ghost/now/") for name in names)
    checked = 0
    for number in (0, 37, 100):
        shown = replace(frame, time=float(plan.motion.time[rows[number]]), playing=False)
        positions = _poses_of("now", shown)
        own = places[number][~np.isnan(places[number]).any(axis=1)]
        ends = plan.arm.place(positions).reshape(-1, 2, 3)
        assert len(own) == len(ends)
        ways = (ends[:, 1] - ends[:, 0]) / 2
        size = np.linalg.norm(ways, axis=1)
        along = np.array([rotation(tuple(turn))[:, 2] for turn in own[:, 3:].astype(float)])
        np.testing.assert_allclose(own[:, :3], ends.mean(axis=1), atol=1e-4 * plan.arm.reach)
        np.testing.assert_allclose(along * size[:, None], ways, atol=1e-4 * plan.arm.reach)
        checked += len(own)
    assert checked > 10

    fake.set(session.playback.slider, float(plan.motion.time[-1]) / 2)
    until(lambda: not session.frame.playing and sent[-1] is None)
    assert len(sent) == count + 1
    positions = _poses_of("now", session.frame)
    ends = plan.arm.place(positions).reshape(-1, 2, 3)
    drawn_scene = session.client.scene
    until(lambda: f"/arm_ghost/now/{len(ends)}" not in drawn_scene._handle_from_node_name)
    for number, end in enumerate(ends):
        place = drawn_node(session, f"/arm_ghost/now/{number}").position
        np.testing.assert_allclose(place, end.mean(axis=0), atol=1e-6 * plan.arm.reach)


def test_other_poses_hold_the_tool_where_it_is() -> None:
    made = plan(load_scene("kitchen-ur5e"))
    arm, motion = made.arm, made.motion
    assert isinstance(arm, UrdfArm)
    assert motion is not None
    some = 0
    for time in np.linspace(0.0, motion.time[-1], 5):
        tool, own = (
            np.array([np.interp(time, motion.time, row) for row in rows.T])
            for rows in (motion.tool, motion.positions)
        )
        others = other_poses(made, arm, float(time))
        some += len(others)
        for pose in others:
            # between two samples joints go straight, the tool does not
            np.testing.assert_allclose(arm.tool(pose[None])[0], tool, atol=1e-3 * arm.reach)
            assert np.abs(arm.place(pose[None]) - arm.place(own[None])).max() > 0.02 * arm.reach
    assert some >= 5
    for name in ("start", "goal"):
        pose, place = end_pose(made, arm, name), getattr(made.scene, name)
        assert pose is not None
        np.testing.assert_allclose(arm.tool(pose[None])[0], place, atol=1e-4 * arm.reach)
    assert poses_at(arm, (9.0, 9.0, 9.0)) == ()


@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_joints_in_each_other_stand_where_the_chain_has_them(name: str) -> None:
    if name in SHIPPED:
        robot = load_robot(name, MeshSource())
    else:
        robot = robot_from_archive(packed({"a.urdf": OWN[name]}))
    turned = (0.1, -0.5, 0.7, 0.5)
    made = urdf_arm(robot, SHIPPED.get(name, "d"), (30.0, -20.0, 10.0), None, "cm", turned)
    random = np.random.default_rng(1)
    low, high = made.limits.T.clip(-10, 10)
    positions = random.uniform(low, high, (20, len(made.joints)))
    expected = made.chain.poses(positions / made.scales)
    for row, values in enumerate(joint_values(made, positions)):
        base = viser.transforms.SE3.from_rotation_and_translation(
            viser.transforms.SO3(np.array(turned)), made.base
        )
        poses: list[viser.transforms.SE3] = []
        for number, joint in enumerate(made.chain.joints):
            node = JointNode(
                SimpleNamespace(name="", wxyz=None, position=None),  # type: ignore[arg-type]
                *(number, bool(made.chain.table.slides[number])),
                axis=joint.axis,
                origin=joint_origin(made, number),
            )
            node.frame.wxyz = node.origin.rotation().wxyz
            node.frame.position = node.origin.translation()
            node.move(values)
            turn = viser.transforms.SO3(np.asarray(node.frame.wxyz))
            place = np.asarray(node.frame.position)
            before = int(made.chain.table.before[number])
            pose = poses[before] if before >= 0 else base
            pose = pose @ viser.transforms.SE3.from_rotation_and_translation(turn, place)
            poses.append(pose)
            found = np.column_stack([pose.rotation().as_matrix(), pose.translation() / 100])
            np.testing.assert_allclose(found, expected[row, number], atol=1e-9)


def test_a_link_is_drawn_with_the_triangles_of_its_visual() -> None:
    robot = robot_from_archive(packed({"r.urdf": looking("a.dae"), "a.dae": dae(0.3)}))
    shapes = [[_muted(shape, 0) for shape in robot.links[name].drawn] for name in "ab"]
    (vertices, faces, _), (_, others, _) = (link_mesh(own, np.eye(4), 100.0) for own in shapes)

    assert [len(faces), len(others)] == [320, 12]
    corners = vertices.min(axis=0), vertices.max(axis=0)
    np.testing.assert_allclose(corners, [[-30, -28, -30], [30, 32, 30]], atol=1e-3)
