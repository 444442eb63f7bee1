"""Readers of motions: every form gives the same motion, and each wrong input one clear sentence."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from abi.certification.motion import Motion, RobotState
from abi.certification.read_message import read_message
from abi.certification.read_motion import own_joints, read_motion
from abi.certification.robot_motion import bezier_points, robot_motion
from abi.certification.robot_scene import robot_scene
from abi.certification.stated_object import StatedObject
from abi.errors import AbiError
from abi.robot.urdf.tip_pose import tip_pose
from abi.scene.scene import Scene
from abi.scene.scene_file import yaml_text
from abi.verify.exact_path import exact_path
from abi.verify.fault import Fault
from tests.abi.robot.robots import arm, follows, joint, link, urdf

SCENE = robot_scene("ur5e")
ROBOT = SCENE.arm.robot
JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
TABLE = [[0.1 * k + 0.2 * j for j in range(6)] for k in range(3)]
TIMES = [0.0, 0.5, 1.25]


def csv_text(rows: list[list[object]], names: tuple[str, ...] = JOINTS) -> bytes:
    head = ",".join(["time", *names])
    return "\n".join([head, *(",".join(map(str, row)) for row in rows)]).encode()


_COMMAS = str.maketrans(",.", ";,")


def message(**changed: object) -> dict[str, Any]:
    points = [
        {
            "positions": row,
            "velocities": [0.1] * 6,
            "time_from_start": {"sec": int(time), "nanosec": int(time % 1 * 1e9)},
        }
        for row, time in zip(TABLE, TIMES, strict=True)
    ]
    return {"joint_names": list(JOINTS), "points": points} | changed


def written() -> dict[str, bytes]:
    rows: list[list[object]] = [[time, *row] for time, row in zip(TIMES, TABLE, strict=True)]
    degrees: list[list[object]] = [
        [1000 * time, *(math.degrees(one) for one in row)]
        for time, row in zip(TIMES, TABLE, strict=True)
    ]
    in_degrees = csv_text(degrees, tuple(f"{name} [deg]" for name in JOINTS))
    plain = {"joints": list(JOINTS), "times": TIMES, "positions": TABLE}
    return {
        "a.csv": csv_text(rows),
        "b.csv": in_degrees.replace(b"time", b"time [ms]", 1),
        "c.csv": csv_text(rows).replace(b",", b";"),
        # as spreadsheets write it where commas are decimal, with a mark of byte order
        "c2.csv": ("\ufeff" + csv_text(rows).decode().translate(_COMMAS)).encode(),
        "c3.csv": csv_text(rows).decode().replace(",", "\t").encode("utf-16"),
        "d.json": json.dumps(plain).encode(),
        "e.json": json.dumps(message()).encode(),
        "f.yaml": (yaml_text(message()) + "---\n").encode(),
        "g.yaml": yaml_text({"trajectory": [{"joint_trajectory": message()}]}).encode(),
    }


@pytest.mark.parametrize("name", list(written()))
def test_every_form_gives_the_same_motion(name: str) -> None:
    motion = read_motion(name, written()[name], own_joints(ROBOT))
    assert motion.joints == JOINTS
    np.testing.assert_allclose(motion.times, TIMES, atol=1e-12)
    np.testing.assert_allclose(motion.positions, TABLE, atol=1e-12)
    assert motion.interpolation == ("cubic" if name[0] in "efg" else "linear")


def test_waypoints_without_times_are_numbered() -> None:
    text = "\n".join([",".join(JOINTS), *(",".join(map(str, row)) for row in TABLE)])
    motion = read_motion("a.csv", text.encode(), own_joints(ROBOT))
    assert not motion.timed
    assert motion.times.tolist() == [0, 1, 2]


def timed(**parts: object) -> dict[str, Any]:
    points = message()["points"]
    return message(points=[*points[:-1], points[-1] | {"time_from_start": parts}])


@pytest.mark.parametrize(
    ("seconds", "rest"), [("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs")]
)
def test_a_duration_is_read_whole(seconds: str, rest: str) -> None:
    motion = read_message(timed(**{seconds: 1, rest: 250_000_000}), [])
    assert motion.times[-1] == TIMES[-1]
    assert read_message(timed(**{seconds: 1}), []).times[-1] == 1


@pytest.mark.parametrize(
    ("data", "words"),
    [
        *(
            (timed(**parts), "row 3 time_from_start is")
            for parts in (
                {"sec": 1, "nanoseconds": 900_000_000},
                {"secs": 1, "nanosec": 900_000_000},
                {"sec": 1, "nanosec": 1, "nsec": 900_000_000},
                {"nanosec": 900_000_000},
                {"sec": 1, "nanosec": 10**400},
                {"sec": 16**5000, "nanosec": 0},  # of more digits than Python writes
                {},
            )
        ),
        (
            message(points=[one | {"unit": "deg"} for one in message()["points"]]),
            "unit of the motion is 'deg'",
        ),
        ({"joint_trajectory": message(), "trajectory": message()}, "more than one motion"),
        (message(points=[one | {"velocities": [], "accelerations": [0.1] * 6}
                         for one in message()["points"]]), "accelerations but no velocities"),
        ({"joints": ["a"], "positions": [[0], [10**400]]}, "Row 2 of positions"),
        ({"joints": ["a"], "positions": [[0], [1]], "times": [0, 10**400]}, "Row 1 of times"),
    ],
)  # fmt: skip
def test_what_would_be_read_otherwise_is_refused(data: dict[str, Any], words: str) -> None:
    with pytest.raises(AbiError, match=words):
        read_message(data, [])


def test_what_points_say_beside_their_motion_is_told() -> None:
    points = [one | {"velocity": [3.0], "effort": []} for one in message()["points"]]
    notes = read_message(message(points=points), []).notes
    assert notes == ("Not used of the points: velocity.",)


@pytest.mark.parametrize("number", ["010", "-07", "0o17", "00", "1_000", "0.5_5", "0b11", "+0x10"])
def test_numbers_that_two_versions_of_yaml_read_otherwise_are_refused(number: str) -> None:
    text = yaml_text(message()).replace("0.1", number, 1)
    with pytest.raises(AbiError, match="versions of YAML"):
        read_motion("a.yaml", text.encode(), own_joints(ROBOT))


@pytest.mark.parametrize("untimed", [{}, {"timed": False, "times": TIMES}])
def test_velocities_without_times_leave_the_way_open_and_are_refused(
    untimed: dict[str, Any],
) -> None:
    plain = {"joints": list(JOINTS), "positions": TABLE}
    assert read_message({**plain, **untimed}, []).interpolation == "linear"
    with pytest.raises(AbiError, match="velocities but no times"):
        read_message({**plain, **untimed, "velocities": TABLE}, [])
    with pytest.raises(Fault, match="velocities but no times"):
        exact_path({**plain, "times": TIMES, "timed": False, "velocities": TABLE}, [1] * 6)


def test_a_long_motion_is_read_from_json_and_not_from_yaml() -> None:
    table = [[k / 7 + j / 3 for j in range(6)] for k in range(19_000)]
    content = json.dumps({"joints": list(JOINTS), "positions": table}).encode()
    assert len(content) > 2_000_000
    assert len(read_motion("a.json", content, own_joints(ROBOT)).times) == len(table)
    with pytest.raises(AbiError, match="at most 400 kB, or JSON"):
        read_motion("a.yaml", content, own_joints(ROBOT))


def rows_with(row: int, column: int, value: object) -> list[list[object]]:
    rows: list[list[object]] = [[time, *one] for time, one in zip(TIMES, TABLE, strict=True)]
    rows[row][column] = value
    return rows


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.csv", csv_text(rows_with(1, 2, "x")), ["row 2", "shoulder_lift_joint", "'x'"]),
        ("a.csv", csv_text(rows_with(1, 2, "1_0")), ["row 2", "no number"]),
        ("a.csv", csv_text(rows_with(1, 2, "\u0663")), ["row 2", "no number"]),
        ("a.csv", csv_text(rows_with(1, 2, "nan")), ["row 2", "shoulder_lift_joint", "nan"]),
        ("a.csv", csv_text(rows_with(2, 0, 0.5)), ["row 3", "0.5 s", "increase"]),
        ("a.csv", csv_text(rows_with(1, 0, 1e-300)), ["row 2", "1e-300 s", "increase"]),
        ("a.csv", csv_text(rows_with(2, 1, 90)), ["row 3", "shoulder_pan_joint", "rad", "degrees"]),
        ("a.csv", csv_text(rows_with(0, 0, 0), ("x", *JOINTS[1:])), ["shoulder_pan_joint"]),
        ("a.csv", csv_text(rows_with(0, 0, 0), (JOINTS[1], *JOINTS[1:])), [JOINTS[1], "2 times"]),
        ("a.csv", csv_text(rows_with(0, 0, 0), ("elbow_joint [ft]", *JOINTS[1:])), ["unit"]),
        ("a.csv", b"", ["empty"]),
        ("a.csv", b"a" + b"(" * 100_000 + b",b\n0,1\n1,2", ["column", "a(("]),
        ("a.csv", b"a" + b" " * 100_000 + b"x,b\n0,1\n1,2", ["column", "shoulder_pan_joint"]),
        ("a.csv", b"time,a\n0,1\n1,2", ["column", "shoulder_pan_joint"]),
        ("a.csv", csv_text(rows_with(0, 0, 0)[:1]), ["1 waypoint"]),
        ("a.json", json.dumps(message(joint_names=[*JOINTS[:5], "wrist"])).encode(), ["wrist"]),
        ("a.json", json.dumps(message(joint_names=list(JOINTS[:5]))).encode(), ["Row 1", "5"]),
        ("a.json", b"{", ["JSON"]),
        ("a.json", b"[]", ["no motion"]),
        ("a.bag", b"", [".csv"]),
        ("a.csv", b"\xff\xfe\x00", ["UTF-8"]),
        (
            "a.csv",
            csv_text(rows_with(0, 0, 0), ("shoulder", *JOINTS[1:])),
            ["where shoulder_pan_joint is", "ignored: shoulder."],
        ),
    ],
)
def test_wrong_input_is_one_sentence(name: str, content: bytes, words: list[str]) -> None:
    with pytest.raises(AbiError) as caught:
        robot_motion(read_motion(name, content, own_joints(ROBOT)), SCENE)
    said = f"{caught.value.message} {caught.value.hint}"
    assert all(word in said for word in words), said
    assert "\n" not in said


def test_velocities_in_some_rows_only_are_refused() -> None:
    data = message()
    data["points"][1]["velocities"] = []
    with pytest.raises(AbiError, match="Row 2 has 0 velocities for 6 joints"):
        read_motion("a.json", json.dumps(data).encode(), own_joints(ROBOT))


def test_a_first_waypoint_far_from_the_start_state_is_refused() -> None:
    motion = Motion(JOINTS, TIMES, TABLE)  # type: ignore[arg-type]
    robot_motion(motion, SCENE, {JOINTS[2]: 0.41})
    with pytest.raises(AbiError, match=r"Row 1 .* elbow_joint is at 0.4 rad .* at 1 rad"):
        robot_motion(motion, SCENE, {JOINTS[2]: 1.0})


def test_a_joint_in_the_middle_must_be_given() -> None:
    motion = Motion(JOINTS[:2] + JOINTS[3:], TIMES, np.array(TABLE)[:, 1:])  # type: ignore[arg-type]
    with pytest.raises(AbiError, match="does not say where elbow_joint is"):
        robot_motion(motion, SCENE)


def test_the_joints_that_a_plan_moves_are_enough_where_the_tip_follows_another_branch(
    tmp_path: Path,
) -> None:
    path = tmp_path / "r.urdf"
    text = urdf(
        *map(link, "abcdt"),
        joint("held", "a", "b"),
        joint("master", "b", "c"),
        joint("beside", "c", "d"),
        joint("way", "a", "t", extra='<limit lower="-3" upper="3"/>' + follows("master", 1.0, 0)),
    )
    path.write_text(text)
    scene = robot_scene(path).replace(arm={"tip": "t"})
    table = np.array([[0.0], [0.2]])
    moves = robot_motion(Motion(("master",), np.array([0.0, 1.0]), table), scene)
    assert moves.chain.held == {"held": 0.0, "beside": 0.0}
    assert any("held at 0" in note for note in moves.notes)
    with pytest.raises(AbiError, match="does not say where held is"):
        robot_motion(Motion(("beside",), np.array([0.0, 1.0]), table), scene)


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 3, 5]))
def test_polynomials_have_the_derivatives_of_the_waypoints(seed: int, degree: int) -> None:
    random = np.random.default_rng(seed)
    times = np.cumsum(random.uniform(0.1, 2, 4))
    p, v, a = random.normal(size=(3, 4, 2))
    rates = (v if degree > 1 else None, a if degree > 3 else None)
    motion = Motion(("a", "b"), times, p, *rates)
    points = bezier_points(motion)
    assert points.shape == (3, degree + 1, 2)
    np.testing.assert_allclose(points[:, 0], p[:-1])
    np.testing.assert_allclose(points[:, -1], p[1:])
    spans = np.diff(times)[:, None]
    if degree > 1:
        np.testing.assert_allclose(degree * (points[:, 1] - points[:, 0]) / spans, v[:-1])
        np.testing.assert_allclose(degree * (points[:, -1] - points[:, -2]) / spans, v[1:])
    if degree > 3:
        for side, wanted in ((points, a[:-1]), (points[:, ::-1], a[1:])):
            second = side[:, 0] - 2 * side[:, 1] + side[:, 2]
            np.testing.assert_allclose(20 * second / spans**2, wanted, atol=1e-9)


def standing(x: float, turned: float = 0.0) -> dict[str, Any]:
    """A robot's state in a message that says where its root stands."""
    translation, rotation = {"x": x, "y": 0, "z": 0}, {"x": 0, "y": 0, "z": turned, "w": 0.8}
    place = {"translation": translation, "rotation": rotation}
    return {"multi_dof_joint_state": {"joint_names": ["world"], "transforms": [place]}}


def test_a_message_may_say_where_the_robot_stands_as_the_scene_does() -> None:
    whole = {"trajectory": [{"joint_trajectory": message()}], "trajectory_start": standing(0.0)}
    motion = read_motion("a.json", json.dumps(whole).encode(), own_joints(ROBOT))
    assert robot_motion(motion, SCENE).motion.joints == JOINTS


def test_start_states_of_one_file_must_be_the_same() -> None:
    for other, fits in ((standing(0.0), True), (standing(0.5), False), (None, True)):
        inner = {"joint_trajectory": message(), "start_state": other}
        whole = {"trajectory": [inner], "trajectory_start": standing(0.0)}
        if fits:
            assert read_message(whole, []).start.base == (0, 0, 0, 0, 0, 0, 0.8)
        else:
            with pytest.raises(AbiError, match="several start states"):
                read_message(whole, [])


@pytest.mark.parametrize(
    "row", ["1,0.5,0.1,0.2,0.3,0.4,0.5,0.6", "0,1,5,0,1,0,2,0,3,0,4,0,5", "0,1_0,1,1,1,1,1"]
)
def test_a_row_that_does_not_fit_its_header_is_refused(row: str) -> None:
    head = ",".join(["time", *JOINTS])
    with pytest.raises(AbiError, match=r"[Rr]ow 2"):
        read_motion("a.csv", f"{head}\n0,0,0,0,0,0,0,,\n{row}\n".encode(), own_joints(ROBOT))


def test_a_row_that_is_a_remark_is_told_of() -> None:
    rows: list[list[object]] = [[time, *row] for time, row in zip(TIMES, TABLE, strict=True)]
    text = csv_text(rows).decode()
    told = [
        read_motion("a.csv", one.encode(), own_joints(ROBOT)).notes
        for one in (f"# by hand\n{text}", text.replace("\n1.25", "\n#1.25"))
    ]
    assert told == [("The file says: by hand",), ("1 row is left out: # begins a remark.",)]


@pytest.mark.parametrize("unit", ["deg", "degrees", ["rad", "mm"]])
def test_a_plain_motion_in_other_units_is_refused(unit: object) -> None:
    plain = {"joints": list(JOINTS), "times": TIMES, "positions": TABLE}
    with pytest.raises(AbiError, match="unit of the motion is"):
        read_message({**plain, "unit": unit}, [])
    with pytest.raises(AbiError, match="angle_units of the motion is"):
        read_message({**plain, "angle_units": unit}, [])
    assert read_message({**plain, "units": "rad"}, []).joints == JOINTS


def test_what_is_not_read_of_a_file_is_told() -> None:
    plain = {"joints": list(JOINTS), "times": TIMES, "positions": TABLE}
    wrapped = {"trajectory": [{"joint_trajectory": message(), "at": 1}], "robot": "r"}
    assert read_message(plain, []).notes == ()
    for data, names in (
        ({**plain, "base": [1, 0, 0], "time": TIMES}, "base, time"),
        ({**message(), "speed": 2}, "speed"),
        (wrapped, "robot"),
    ):
        assert f"Not used of the file: {names}." in read_message(data, []).notes
    told = "The file says: From 1 to 2 s its tool holds obstacle 1."
    assert told in read_message({**message(), "state": told[15:]}, []).notes


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"multi_dof_joint_trajectory": {"joint_names": ["base"], "points": [{}]}}, "base"),
        (
            {"trajectory_start": {"attached_collision_objects": [{"object": {"id": "rod"}}]}},
            "rod",
        ),
        (
            {"trajectory_start": {"joint_state": {"name": [JOINTS[0]], "position": [2.5]}}},
            f"{JOINTS[0]}.* 2.5",
        ),
        (
            {"trajectory_start": standing(0.5)},
            r"stands at \(0.5, 0, 0\) m, and here at \(0, 0, 0\) m",
        ),
        ({"trajectory_start": standing(0.0, turned=0.6)}, "turned otherwise"),
        ({"trajectory_start": {"multi_dof_joint_state": {"transforms": [{}]}}}, "no single place"),
        ({"trajectory_start": standing(5.0, turned=1e101)}, "no single place"),
        ({"trajectory_start": standing(5.0, turned=1e200)}, "no single place"),
        ({"multi_dof_joint_trajectory": [1]}, "in space"),
        ({"trajectory": [{"joint_trajectory": message()}] * 2}, "holds 2 motions"),
        ({"trajectory_start": ["a"]}, "and no state"),
        ({"trajectory_start": {"multi_dof_joint_state": ["a"]}}, "no single place"),
        ({"trajectory_start": {"joint_state": [1]}}, "not one position for each joint"),
        (
            {"trajectory_start": {"joint_state": {"name": [JOINTS[0]], "position": 5}}},
            "not one position for each joint",
        ),
    ],
)
def test_what_else_a_message_says_of_the_robot_is_not_passed_over(
    changed: dict[str, Any], why: str
) -> None:
    whole = {"trajectory": [{"joint_trajectory": message()}], **changed}
    with pytest.raises(AbiError, match=why):
        robot_motion(read_motion("a.json", json.dumps(whole).encode(), own_joints(ROBOT)), SCENE)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("type", [1]),
        ("dimensions", [1e300, 1e-320, 0.05]),
        ("orientation", [0, 0, 0, 1e-200]),
        ("orientation", [1e200, 0, 0, 1]),
        ("position", [1e200, 0, 0]),
        ("position", [10**400, 0, 0]),
    ],
)
def test_an_object_that_cannot_be_is_not_compared(field: str, value: list[float]) -> None:
    given = {"type": 1, "dimensions": [0.1] * 3, "position": [0] * 3, "orientation": [0, 0, 0, 1]}
    kind, *rest = (given | {field: value}).values()
    assert StatedObject.of(a_solid(kind, rest[0], "tool0", rest[1], rest[2])).solid is None  # type: ignore[arg-type]


def a_solid(kind: int, sizes: list[float], link: str, at: list[float], turn: list[float]) -> Any:
    """A message's object that a link holds."""
    place = {"position": dict(zip("xyz", at, strict=True))}
    place["orientation"] = dict(zip("xyzw", turn, strict=True))
    solid = {"type": kind, "dimensions": sizes}
    inner = {"id": "part", "primitives": [solid], "primitive_poses": [place]}
    return {"link_name": link, "object": inner}


@pytest.mark.parametrize(
    ("shape", "given"),
    [
        ({"shape": "box", "size": [2, 4, 6]}, (1, [0.02, 0.04, 0.06])),
        ({"shape": "sphere", "radius": 3}, (2, [0.03])),
        ({"shape": "cylinder", "radius": 2, "height": 9}, (3, [0.09, 0.02])),
    ],
    ids=["box", "sphere", "cylinder"],
)
def test_what_a_message_says_is_held_is_what_the_scene_has(
    shape: dict[str, Any], given: tuple[int, list[float]]
) -> None:
    half = math.sqrt(0.5)
    attached = {**shape, "position": [1, 2, 8], "wxyz": [half, half, 0, 0]}
    room = {"min": [-300] * 3, "max": [300] * 3}
    scene = SCENE.replace(
        unit="cm", workspace=room, mesh={"pitch": 90}, arm={"tip": "tool0", "attached": attached}
    )
    kind, sizes = given
    at, turn = [0.01, 0.02, 0.08], [half, 0.0, 0.0, half]
    rest = dict.fromkeys(JOINTS, 0.0)
    tool, wrist = (tip_pose(ROBOT, name, rest) for name in ("tool0", "wrist_3_link"))
    offset = np.linalg.inv(wrist) @ tool
    flange = Rotation.from_matrix(offset[:3, :3])
    on_wrist = (flange.apply(at) + offset[:3, 3]).tolist()
    turned = (flange * Rotation.from_quat(turn)).as_quat().tolist()

    def notes(*objects: Any, **state: Any) -> tuple[str, ...]:
        state |= {"attached_collision_objects": [*objects]} if objects else {}
        whole = {"trajectory": [{"joint_trajectory": message()}], "trajectory_start": state}
        motion = read_motion("a.json", json.dumps(whole).encode(), own_joints(scene.robot))
        return robot_motion(motion, scene).notes

    held = "The robot holds the object that is arm.attached of the scene"
    none = f"{held}, and not as in the file, by which it holds nothing."
    assert none in notes()
    assert none in notes(attached_collision_objects=[])
    assert f"{held}." in notes(is_diff=True)  # it may hold what it held before
    same = a_solid(kind, sizes, "tool0", at, turn)
    for one in (same, a_solid(kind, sizes, "wrist_3_link", on_wrist, turned)):
        assert not any(held in note for note in notes(one))
        assert not any("as it is here" in note or "part" in note for note in notes(one))
    near = a_solid(kind, sizes, "tool0", [0.0105, 0.02, 0.08], turn)
    assert any("'part' by 0.0005 m" in note for note in notes(near))
    larger = [1.1 * size for size in sizes]
    for other in (
        a_solid(kind, larger, "tool0", at, turn),
        a_solid(kind, sizes, "tool0", [0.03, 0.02, 0.08], turn),
    ):
        with pytest.raises(AbiError, match="another object than the scene's or elsewhere"):
            notes(other)
    with pytest.raises(AbiError, match="holds 2 objects"):
        notes(same, same)
    unread = {"link_name": "tool0", "object": {"id": "part", "meshes": [{}]}}
    for one in (unread, a_solid(kind, sizes, "forearm_link", at, turn)):
        assert any("'part', which is not compared" in note for note in notes(one))


@pytest.mark.parametrize(
    ("column", "state", "why"),
    [
        ([0.1, 0.7], {}, None),  # as the master and the <mimic> have it
        ([0.1, 0.1], {}, "row 2 v is at 0.1, and by its <mimic> it follows p to 0.7"),
        (None, {"v": 0.1, "w": 0.3}, None),
        (None, {"v": 1.5}, "state has v at 1.5, and by its <mimic> it follows p to 0.1"),
        (None, {"w": 0.5}, "state has w at 0.5"),
    ],
)
def test_a_file_may_not_have_followers_elsewhere_than_they_follow(
    tmp_path: Path, column: list[float] | None, state: dict[str, float], why: str | None
) -> None:
    path = tmp_path / "r.urdf"
    limit = '<limit lower="-3" upper="3"/>'
    text = urdf(
        *map(link, "abcde"),
        joint("p", "a", "b"),
        joint("v", "b", "c", extra=limit + follows("p", 3.0, 0.1)),
        joint("m", "a", "d"),  # stands still
        joint("w", "d", "e", extra=limit + follows("m", 1.0, 0.3)),
    )
    path.write_text(text)
    start = RobotState({**state, "elsewhere": 1.0})
    columns = {"p": [0.0, 0.2]} | ({} if column is None else {"v": column})
    table = np.array([*columns.values()]).T
    motion = Motion(tuple(columns), np.array([0.0, 1.0]), table, start=start)
    if why is None:
        moves = robot_motion(motion, robot_scene(path))
        assert moves.motion.joints == ("p",)
        assert any("nothing moves them: elsewhere" in note for note in moves.notes)
    else:
        with pytest.raises(AbiError, match=why):
            robot_motion(motion, robot_scene(path))


def test_a_plan_holds_its_object_with_the_same_link(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(arm())
    room = {"min": [-300] * 3, "max": [300] * 3}
    whole = {"version": 1, "unit": "cm", "workspace": room, "mesh": {"pitch": 60}}
    whole |= {"start": [0, 0, 1], "goal": [0, 0, 1]}
    held = {"shape": "sphere", "radius": 5.0}
    arms = {tip: {"model": "urdf", "urdf": "r.urdf", "tip": tip, "attached": held} for tip in "cd"}
    scenes = {tip: Scene.from_dict({**whole, "arm": one}, tmp_path) for tip, one in arms.items()}
    table = {"joints": ["p", "q", "s"], "time": [0.0, 1.0], "positions": [[0.0] * 3, [0.1] * 3]}
    motion = read_message({"scene": scenes["d"].to_dict(), "arm": table}, ["s"])
    robot_motion(motion, scenes["d"])
    with pytest.raises(AbiError, match="holds its object with d, and the scene's with c"):
        robot_motion(motion, scenes["c"])


@pytest.mark.parametrize(
    "wrong", [{"unit": ["m"]}, {"arm": {"base": [0, 0, 0], "base_wxyz": [1e-200, 0, 0, 0]}}]
)
def test_a_plan_of_a_scene_that_cannot_be_is_refused(wrong: dict[str, Any]) -> None:
    scene = {"unit": "m", "arm": {"base": [0, 0, 0]}} | wrong
    table = {"joints": ["p"], "time": [0.0, 1.0], "positions": [[0.0], [0.1]]}
    with pytest.raises(AbiError, match="he plan's scene"):
        read_message({"scene": scene, "arm": table}, [])


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({}, None),
        ({"base": [50.0, 0.0, 0.0]}, r"stands at \(0.5, 0, 0\) m, and here at \(0, 0, 0\) m"),
        ({"base": [0.0, 0.0, 0.09]}, "its base by 0.0009"),
        ({"base_wxyz": [0.9, 0.1, 0.0, 0.0]}, "turned otherwise"),
        ({"base_link": "b"}, "on its link b, and here on a"),
        ({"gripper": {"s": 50.0}}, "state has s at 0.5, and here it stands at 0"),
        ({"gripper": {"s": 0.05}}, "s by 0.0005"),
        ({"attached": {"shape": "sphere", "radius": 5.0}}, "holds an object that"),
    ],
)
def test_a_plan_is_certified_only_where_its_robot_stands_and_holds_the_same(
    tmp_path: Path, changed: dict[str, Any], why: str | None
) -> None:
    (tmp_path / "r.urdf").write_text(arm())
    own = {"model": "urdf", "urdf": "r.urdf", "tip": "c", "base": [0, 0, 0]}
    room = {"min": [-300] * 3, "max": [300] * 3}
    data = {"version": 1, "unit": "cm", "workspace": room, "mesh": {"pitch": 60}}
    data["obstacles"] = [{"shape": "sphere", "radius": 1.0, "position": [200, 0, 0]}]
    scenes = [
        Scene.from_dict({**data, "start": [0, 0, 1], "goal": [0, 0, 1], "arm": one}, tmp_path)
        for one in (own, {**own, **changed})
    ]
    table = {"joints": ["p", "q"], "time": [0.0, 1.0], "positions": [[0.0, 0.0], [0.1, 0.1]]}
    motion = read_message({"scene": scenes[1].to_dict(), "arm": table}, ["s"])
    # as a verdict has it
    beside = read_message({"scene": scenes[1].to_dict(), "motion": table}, ["s"])
    assert beside.start == motion.start
    moved = {"joints": ["p", "q", "s"], "positions": [[0.0] * 3, [0.1] * 3]}
    own_column = read_message({"scene": scenes[1].to_dict(), "motion": moved}, ["s"])
    assert own_column.start == motion.start._replace(joints={})
    with pytest.raises(AbiError, match="and no scene"):
        read_message({"scene": [scenes[1].to_dict()], "motion": table}, ["s"])
    if "base_link" not in changed:  # from which p does not move anything
        assert not any("as it is here" in one for one in robot_motion(motion, scenes[1]).notes)
    if why is None or " by " in why:
        told = " ".join(robot_motion(motion, scenes[0]).notes)
        assert ("as it is here" in told and why in told) if why else "as it is here" not in told
        assert "none is compared" not in told
        alone = robot_motion(motion, scenes[0].replace(obstacles=[]))
        assert any("has 1 obstacle, and none is compared" in one for one in alone.notes)
    else:
        with pytest.raises(AbiError, match=why):
            robot_motion(motion, scenes[0])


def test_a_quote_that_none_closes_takes_no_rows_along() -> None:
    content = b'time,a,note\n0,0,\n1,1,"open\n2,2,\n3,0,'
    with pytest.raises(AbiError, match="Row 2"):
        read_motion("a.csv", content, {"a": False})


@pytest.mark.parametrize(("joint", "unit"), [(0, "mm"), (1, "deg")])
def test_a_unit_of_another_kind_than_the_joint_is_refused(joint: int, unit: str) -> None:
    names = ["turns", "slides"]
    head = [f"{name} [{unit}]" if k == joint else name for k, name in enumerate(names)]
    content = "\n".join(["time," + ",".join(head), "0,0,0", "1,1,1"]).encode()
    with pytest.raises(AbiError, match=f"{names[joint]} is '{unit}'"):
        read_motion("a.csv", content, {"turns": False, "slides": True})


def test_the_samples_of_all_legs_are_in_the_unit_of_their_scene() -> None:
    motion = {
        "joints": ["turn", "slide"],
        "time": [0.0, 1.0],
        "positions": [[0.1, 5.0], [0.2, 10.0]],
    }
    tasks: list[dict[str, Any]] = [{"goal": None}, {"goal": None, "release": False}]
    scene = {"unit": "cm", "tasks": tasks}
    for plan in (
        {"scene": scene, "arm": motion},
        {"scene": scene, "legs": [], "trajectory": motion},
    ):
        found = read_message(plan, ["slide"])
        np.testing.assert_allclose(found.positions, [[0.1, 0.05], [0.2, 0.1]])
    for changed in ({"attach": 2}, {"release": True}, {"gripper": {"finger": 0.0}}):
        held = {**scene, "tasks": [tasks[0], changed]}
        with pytest.raises(AbiError, match=f"Leg 2 has {next(iter(changed))}"):
            read_message({"scene": held, "legs": [], "trajectory": motion}, ["slide"])
