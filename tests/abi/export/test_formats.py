from __future__ import annotations

import csv
import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy
import trimesh
import yaml
import yourdfpy
from mcap.reader import make_reader

from abi import assets
from abi.certification.read_motion import read_motion
from abi.errors import AbiError
from abi.export import formats
from abi.export.formats import FORMATS, export
from abi.export.joint_trajectory import joint_trajectory
from abi.obstacles.pose import METRES, rotation
from abi.planner.arm_words import contact_sentence
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.robot.paper_arm.paper_arm import JOINTS, PaperArm, forward
from abi.robot.urdf.robot_files import robot_from_archive
from abi.robot.urdf.urdf_files import files_of
from abi.scene.scene import Scene, load_scene
from tests.abi.robot.robots import arm
from tests.abi.robot.robots import packed as packed_files
from tests.thorough import of_each_kind

ROS_POINT = {
    "positions": float,
    "velocities": float,
    "accelerations": float,
    "effort": float,
}


@pytest.fixture(scope="module")
def planned() -> Plan:
    """A plan whose slide moves, so that lengths and angles differ."""
    return plan(load_scene("paper").replace(motion={"curve": "bspline"}))


@pytest.fixture(scope="module")
def brief(planned: Plan) -> Plan:
    """The same at few moments, for what no moment more would tell."""
    return plan(planned.scene.replace(motion={"samples": 25}))


@pytest.fixture(scope="module")
def sculpture() -> Plan:
    return plan(load_scene("sculpture"))


def content(planned: Plan, name: str, file: str | None = None) -> bytes:
    return FORMATS[name].write(planned, file or FORMATS[name].file)


def test_every_ending_means_its_format() -> None:
    for name, row in FORMATS.items():
        assert formats.format_of(Path(row.file)) == name
        for ending in row.endings:
            assert formats.format_of(Path(f"A{ending}".upper())) == name


def test_an_unknown_ending_names_those_there_are() -> None:
    with pytest.raises(AbiError) as refusal:
        formats.format_of(Path("motion.docx"))

    assert all(
        text in f"{refusal.value.message} {refusal.value.hint}" for text in (".mcap", "urdf")
    )


def test_the_table_is_the_motion_to_the_last_bit(planned: Plan) -> None:
    header, *rows = csv.reader(io.StringIO(content(planned, "csv").decode(), newline=""))
    table = np.array(rows, dtype=float)

    motion = planned.motion
    assert motion is not None
    assert header[0] == "time [s]"
    assert header[1:7] == [f"{q} [{'cm' if q == 'q5' else 'rad'}]" for q in JOINTS]
    assert (table[:, 0] == motion.time).all()
    assert (table[:, 1:7] == motion.positions).all()
    assert (table[:, 7:10] == motion.tool).all()
    assert (table[:, 10:] == motion.tool_velocity).all()


@pytest.mark.parametrize(
    "names",
    [
        ("x", "y", "z", "vx", "q5", "tool_x"),
        ("time", "t", "state", "Time", "tool_state", "timestamp"),
        ("on", "1:30", "1e3", "j(1)", "lift [mm]", "~"),
        ("a;b;c;d", "a;b;c", "; ;", "a,b", "#1", "it's: 0?"),
    ],
)
@pytest.mark.parametrize("file", ["a.csv", "a.ros.yaml", "a.ros.json"])
def test_a_motion_of_joints_of_any_names_is_read_back(
    brief: Plan, names: tuple[str, ...], file: str
) -> None:
    motion = brief.motion
    assert motion is not None
    renamed = replace(brief, motion=replace(motion, joints=names))
    written = content(renamed, formats.format_of(Path(file)), file)
    read = read_motion(file, written, dict(zip(names, motion.slides, strict=True)))
    assert read.joints == names
    np.testing.assert_allclose(read.times, motion.time, atol=1e-8)
    np.testing.assert_allclose(read.positions, joint_trajectory(brief).positions, rtol=1e-12)
    if file == "a.csv":
        header = next(csv.reader(io.StringIO(written.decode(), newline="")))
        assert len({*header}) == len(header)
    if file == "a.ros.yaml":
        assert read_yaml(written)["joint_names"] == list(names)


def test_the_json_is_the_full_plan(planned: Plan) -> None:
    written = json.loads(content(planned, "json"))
    assert "proven clear" in written["arm"].pop("state")
    assert written == planned.to_dict(full=True)


def read_yaml(text: str | bytes) -> dict[str, Any]:
    """What ROS reads in a message: with PyYAML, which knows YAML 1.1."""
    return dict(yaml.load(text, yaml.CSafeLoader))


@pytest.mark.parametrize("file", ["a.yaml", "a.ros.json"])
def test_the_ros_message_has_the_fields_of_its_definition(planned: Plan, file: str) -> None:
    raw = content(planned, "ros", file)
    message = json.loads(raw) if file.endswith("json") else read_yaml(raw)

    assert list(message) == ["header", "joint_names", "points"]
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "base_link"}
    assert message["joint_names"] == list(JOINTS)
    stamps = [point["time_from_start"] for point in message["points"]]
    for point in message["points"]:
        assert point.keys() == {*ROS_POINT, "time_from_start"}
        assert all(
            isinstance(number, kind) for name, kind in ROS_POINT.items() for number in point[name]
        )
        assert {len(point[name]) for name in ROS_POINT} == {0, len(JOINTS)}
    assert all(isinstance(s["sec"], int) and 0 <= s["nanosec"] < 10**9 for s in stamps)
    times = np.array([s["sec"] + 1e-9 * s["nanosec"] for s in stamps])
    assert (np.diff(times) > 0).all()


def test_the_ros_message_leads_the_tool_along_the_curve(planned: Plan) -> None:
    points = json.loads(content(planned, "ros", "a.json"))["points"]
    positions = np.array([point["positions"] for point in points])
    velocities = np.array([point["velocities"] for point in points])
    arm, motion = planned.arm, planned.motion
    assert isinstance(arm, PaperArm)
    assert motion is not None
    scene_units = positions / np.where(np.array(JOINTS) == "q5", METRES["cm"], 1.0)

    np.testing.assert_allclose(forward(arm, scene_units), motion.target, atol=1e-9)
    assert not velocities[[0, -1]].any()
    # the integral of the velocities is the way between the samples
    steps = np.diff(motion.time)[1:-1, None]
    travelled = (velocities[1:-2] + velocities[2:-1]) / 2 * steps
    np.testing.assert_allclose(travelled, np.diff(positions[1:-1], axis=0), atol=1e-4)


def test_scipy_reads_the_curves_back(planned: Plan, sculpture: Plan) -> None:
    for result in (planned, sculpture):
        curves = json.loads(content(result, "spline"))["curves"]
        assert [curve["name"] for curve in curves] == ["bspline", "quadratic"]
        for curve, fit in zip(curves, (result.bspline, result.quadratic), strict=True):
            assert fit is not None
            knots, points = np.array(curve["knots"]), np.array(curve["control_points"])
            spline = scipy.interpolate.BSpline(knots, points, curve["degree"])
            parameters = np.linspace(0, 1, 200)
            np.testing.assert_allclose(spline(parameters), fit.curve(parameters), atol=1e-12)
            assert curve["certified"] == fit.holds


def read_moveit(text: str) -> dict[str, list[tuple[str, list[float], list[float]]]]:
    """Shapes of each object: kind, numbers and pose, as MoveIt's own reader goes through them."""
    words = iter(text.split())
    assert next(words) == "abi"
    found: dict[str, list[tuple[str, list[float], list[float]]]] = {}
    while (marker := next(words)) == "*":
        shapes = found.setdefault(next(words), [])
        *place, x, y, z, w = (float(next(words)) for _ in range(7))
        frame = scipy.spatial.transform.Rotation.from_quat((x, y, z, w))
        for _ in range(int(next(words))):
            kind = next(words)
            counts = {"box": 3, "sphere": 1, "cylinder": 2, "mesh": 2}
            numbers = [float(next(words)) for _ in range(counts[kind])]
            if kind == "mesh":
                numbers += [float(next(words)) for _ in range(3 * int(sum(numbers)))]
            pose = [float(next(words)) for _ in range(7)]
            turn = frame * scipy.spatial.transform.Rotation.from_quat(pose[3:])
            there = frame.apply(pose[:3]) + place
            shapes.append((kind, numbers, [*there.tolist(), *turn.as_quat().tolist()]))
            assert [next(words) for _ in range(4)] == ["0"] * 4
        assert next(words) == "0"
    assert marker == "."
    return found


def test_moveit_reads_every_obstacle_in_metres(sculpture: Plan) -> None:
    forest = Plan(load_scene("forest").replace(arm={"base": [0, 0, 0]}))
    objects = read_moveit(content(forest, "moveit").decode())

    assert list(objects) == [f"obstacle_{n}" for n in range(1, 7)]
    (kind, size, pose), *_ = objects["obstacle_6"]
    assert (kind, size) == ("box", [0.012] * 3)
    np.testing.assert_allclose(pose[:3], [0.046, 0.014, 0.042])
    np.testing.assert_allclose(pose[3:], [0, 0.3826834324, 0, 0.9238795325])
    column, *balls = objects["obstacle_5"]
    assert column[0] == "cylinder"
    np.testing.assert_allclose(column[1], [0.004, 0.024])
    # the capsule lies along -y: its balls are at the ends of that axis
    places = [ball[2][:3] for ball in balls]
    np.testing.assert_allclose(sorted(places), [[0.044, 0.039, 0.022], [0.044, 0.063, 0.022]])

    ((kind, numbers, _),) = read_moveit(content(sculpture, "moveit").decode())["obstacle_1"]
    count = int(numbers[0])
    corners = np.array(numbers[2 : 2 + 3 * count]).reshape(-1, 3)
    faces = np.array(numbers[2 + 3 * count :], dtype=int).reshape(-1, 3)
    (mesh,) = sculpture.scene.obstacles
    assert kind == "mesh"
    np.testing.assert_array_equal(corners[faces], mesh.triangles() * METRES["cm"])


def test_moveit_has_obstacles_where_they_are_for_the_robots_root() -> None:
    stands = {"model": "urdf", "urdf": "ur5e", "base": [3, -30, 2], "base_wxyz": [0.6, 0, 0, 0.8]}
    scene = load_scene("forest").replace(arm=stands, start=[0, 0, 0], goal=[0, 0, 1])
    here = np.array([shape.position for shape in scene.obstacles])
    objects = read_moveit(content(Plan(scene), "moveit").decode())
    found = np.array(
        [np.mean([pose[:3] for _, _, pose in one], axis=0) for one in objects.values()]
    )
    turned = scipy.spatial.transform.Rotation.from_quat((0, 0, 0.8, 0.6))
    np.testing.assert_allclose(turned.apply(100 * found) + stands["base"], here, atol=1e-9)


def test_a_scene_without_obstacles_is_no_moveit_scene() -> None:
    with pytest.raises(AbiError, match="no obstacles"):
        content(Plan(Scene(version=1)), "moveit")


def conforms(data: Any, schema: dict[str, Any]) -> bool:
    """Check whether ``data`` is of a JSON schema, as far as ours go."""
    kinds = {"number": int | float, "integer": int, "string": str, "boolean": bool}
    if schema["type"] == "array":
        return isinstance(data, list) and all(conforms(item, schema["items"]) for item in data)
    if schema["type"] != "object":
        return isinstance(data, kinds[schema["type"]])
    fields = schema.get("properties", {})
    return data.keys() == fields.keys() and all(conforms(data[k], fields[k]) for k in fields)


@pytest.mark.slow
def test_the_recorded_tool_points_where_the_scene_holds_it() -> None:
    scene = load_scene("kitchen-ur5e")
    assert scene.arm.axis == (0.0, 0.0, -1.0)
    reader = make_reader(io.BytesIO(content(plan(scene), "mcap")))
    turns = [
        json.loads(message.data)["pose"]["orientation"]
        for _, _, message in reader.iter_messages(topics=["/tool"])
    ]
    x, y, z, w = np.array([[one[name] for name in "xyzw"] for one in turns]).T
    # third column of the rotation that a quaternion stands for
    axis = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
    np.testing.assert_allclose(axis, np.tile(scene.arm.axis, (len(axis), 1)), atol=1e-5)


def test_the_recording_plays_the_motion(planned: Plan) -> None:
    reader = make_reader(io.BytesIO(content(planned, "mcap")))
    messages: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    for schema, channel, message in reader.iter_messages():
        assert schema is not None
        data = json.loads(message.data)
        assert conforms(data, json.loads(schema.data)), channel.topic
        messages.setdefault(channel.topic, []).append((message.log_time, data))
    attached = {part.name: part.data.decode(errors="replace") for part in reader.iter_attachments()}

    arm, motion = planned.arm, planned.motion
    assert isinstance(arm, PaperArm)
    assert motion is not None
    assert len(messages["/joint_states"]) == len(messages["/tool"]) == len(motion.time)
    stamps = [stamp for stamp, _ in messages["/tool"]]
    np.testing.assert_allclose(np.array(stamps) * 1e-9, motion.time, atol=1e-9)
    tool = [list(data["pose"]["position"].values()) for _, data in messages["/tool"]]
    np.testing.assert_allclose(tool, motion.tool * METRES["cm"])
    ((_, scene),) = messages["/scene"]
    assert [entity["id"] for entity in scene["entities"]] == ["obstacle 1", "curve"]
    assert Scene.from_dict(json.loads(attached["scene.json"])) == planned.scene
    ((_, description),) = messages["/robot_description"]
    assert description["data"] == attached["arm.urdf"]


def matrix_of(message: dict[str, Any], place: str, turn: str) -> Any:
    """Pose (4, 4) that a part of a message gives under these names."""
    pose = np.eye(4)
    wxyz = tuple(message[turn][key] for key in "wxyz")
    pose[:3, :3], pose[:3, 3] = rotation(wxyz), [message[place][key] for key in "xyz"]
    return pose


def place_of(frames: dict[str, tuple[str, Any]], link: str) -> Any:
    """World from link, (4, 4), through the frames of a recording by their children."""
    pose = np.eye(4)
    while link in frames:
        link, message = frames[link]
        pose = matrix_of(message, "translation", "rotation") @ pose
    assert link == ("scene_world" if "world" in frames else "world")
    return pose


@pytest.mark.slow
@pytest.mark.parametrize("name", of_each_kind(["abi", "ur5e", "xarm7"], "abi", "xarm7"))
def test_the_recording_has_all_of_the_arm_and_moves_it(
    planned: Plan, name: str, tmp_path: Path
) -> None:
    result = planned
    if name != "abi":
        turned = {"urdf": name, "avoid": False, "base_wxyz": (1, 0, 0, 1)}
        result = plan(load_scene("kitchen-ur5e").replace(arm=turned, obstacles=[]))
    arm, motion = result.arm, result.motion
    assert arm is not None
    assert motion is not None
    reader = make_reader(io.BytesIO(content(result, "mcap")))
    found: dict[str, list[Any]] = {}
    for schema, channel, message in reader.iter_messages():
        assert schema is not None
        data = json.loads(message.data)
        assert conforms(data, json.loads(schema.data)), channel.topic
        found.setdefault(channel.topic, []).append(data)
    assert len(found["/tf"]) == len(motion.time)

    for path, data in arm.files().items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes(data)
    robot = yourdfpy.URDF.load(str(next(tmp_path.glob("*.urdf"))))
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = rotation(arm.wxyz), arm.base * arm.metres
    (drawn,) = found["/arm"]
    entities = {entity["frame_id"]: entity for entity in drawn["entities"]}
    assert entities.keys() == {link for link, one in robot.link_map.items() if one.visuals}
    ends = arm.place(motion.positions)
    for sample in (0, 100, len(motion.time) - 1):
        state = found["/joint_states"][sample]
        robot.update_cfg(dict(zip(state["name"], state["position"], strict=True)))
        frames = {
            one["child_frame_id"]: (one["parent_frame_id"], one)
            for message in (found["/tf_static"][0], found["/tf"][sample])
            for one in message["transforms"]
        }
        assert {*robot.link_map} <= {*frames}
        for link in robot.link_map:
            expected = base @ robot.get_transform(link)
            np.testing.assert_allclose(place_of(frames, link), expected, atol=1e-9)
        for link, entity in entities.items():
            own = [k for k, name in enumerate(arm.capsule_links) if name == link]
            for part in (*entity["cubes"], *entity["spheres"], *entity["cylinders"]):
                pose = place_of(frames, link) @ matrix_of(part["pose"], "position", "orientation")
                gaps = [
                    segment_gap(pose[:3, 3] / arm.metres, ends[sample, k]) - arm.radii[k]
                    for k in own
                ]
                assert min(gaps) < 1e-6 * arm.reach
    for link, entity in entities.items():
        if entity["triangles"]:
            np.testing.assert_allclose(
                bounds_drawn(entity["triangles"]), bounds_of_link(robot, link), atol=1e-6
            )
    attached = {one.name: one.data for one in reader.iter_attachments()}
    assert ("arm.zip" in attached) == (len(arm.files()) > 1)
    if "arm.zip" in attached:
        again = robot_from_archive(attached["arm.zip"])
        assert again.links.keys() == arm.chain.robot.links.keys()


def bounds_drawn(parts: list[dict[str, Any]]) -> Any:
    """Low and high corner (2, 3) of triangles of a link, in its frame, [m]."""
    corners = []
    for part in parts:
        pose = matrix_of(part["pose"], "position", "orientation")
        points = np.array([[*point.values()] for point in part["points"]])
        corners.append(points @ pose[:3, :3].T + pose[:3, 3])
    every = np.concatenate(corners)
    return np.stack([every.min(axis=0), every.max(axis=0)])


def bounds_of_link(robot: yourdfpy.URDF, link: str) -> Any:
    """Low and high corner (2, 3) of what yourdfpy shows of a link, in its frame, [m]."""
    graph = robot.scene.graph
    corners = []
    for node in graph.nodes_geometry:
        if graph.transforms.parents[node] == link:
            pose, name = graph.get(node, link)
            vertices = robot.scene.geometry[name].vertices
            corners.append(vertices @ pose[:3, :3].T + pose[:3, 3])
    every = np.concatenate(corners)
    return np.stack([every.min(axis=0), every.max(axis=0)])


def segment_gap(point: Any, ends: Any) -> float:
    """Distance of a point from a segment."""
    way = ends[1] - ends[0]
    share = np.clip((point - ends[0]) @ way / max(way @ way, 1e-300), 0, 1)
    return float(np.linalg.norm(point - ends[0] - share * way))


def test_the_recording_holds_meshes(sculpture: Plan) -> None:
    reader = make_reader(io.BytesIO(content(sculpture, "mcap")))
    ((_, _, message),) = reader.iter_messages(topics=["/scene"])
    (mesh,) = sculpture.scene.obstacles
    entity, _curve = json.loads(message.data)["entities"]

    corners = [list(point.values()) for point in entity["triangles"][0]["points"]]
    np.testing.assert_allclose(corners, mesh.triangles().reshape(-1, 3) * METRES["cm"])


def test_yourdfpy_moves_the_arm_to_where_the_motion_does(planned: Plan) -> None:
    robot = yourdfpy.URDF.load(io.BytesIO(content(planned, "urdf")))
    points = json.loads(content(planned, "ros", "a.json"))["points"]
    arm, motion = planned.arm, planned.motion
    assert isinstance(arm, PaperArm)
    assert motion is not None

    for index in (0, 100, 400):
        robot.update_cfg(dict(zip(JOINTS, points[index]["positions"], strict=True)))
        tool = robot.get_transform("tool")[:3, 3] + arm.base * METRES["cm"]
        np.testing.assert_allclose(tool, motion.target[index] * METRES["cm"], atol=1e-9)


@pytest.mark.slow
def test_the_archive_has_all_that_the_arm_is_drawn_with(tmp_path: Path) -> None:
    kitchen = plan(load_scene("kitchen-ur5e"))
    with pytest.raises(AbiError, match=r"as a \.zip"):
        content(kitchen, "urdf")
    packed = content(kitchen, "urdf-zip")
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        archive.extractall(tmp_path)
    found, expected = (
        yourdfpy.URDF.load(str(path))
        for path in (tmp_path / "ur5e.urdf", assets.path("urdf", "ur5e", "ur5e.urdf"))
    )
    assert len(expected.scene.geometry) == 7
    assert found.scene.geometry.keys() == expected.scene.geometry.keys()
    np.testing.assert_allclose(found.scene.bounds, expected.scene.bounds)
    assert robot_from_archive(packed).links.keys() == kitchen.scene.arm.robot.links.keys()


def test_meshes_of_a_package_are_named_where_they_are(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(1, 0.1).export(file_type="stl")
    text = arm(('<box size="0.1 0.1 0.3"/>', '<mesh filename="package://mine/parts/ball.stl"/>'))
    text = text.replace("collision", "visual")
    robot = robot_from_archive(packed_files({"x/r.urdf": text, "x/deep/ball.stl": ball}))
    for name, data in files_of(robot).items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(data)
    read = yourdfpy.URDF.load(str(tmp_path / "r.urdf"))
    np.testing.assert_allclose(read.scene.geometry["ball.stl"].extents, 0.2, rtol=0.1)


@pytest.mark.parametrize("name", ["urdf", "urdf-zip"])
def test_an_arm_without_meshes_is_one_file(planned: Plan, name: str) -> None:
    raw = content(planned, name)
    if name == "urdf-zip":
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            assert archive.namelist() == ["arm.urdf", "arm.srdf"]
            raw = archive.read("arm.urdf")
    assert planned.arm is not None
    assert raw.decode() == planned.arm.description()


def test_a_plan_without_motion_says_why() -> None:
    blocked = plan(load_scene("no-way"))

    for name in ("csv", "ros", "mcap"):
        with pytest.raises(AbiError, match="no motion to export: No path"):
            content(blocked, name)
    assert json.loads(content(blocked, "json"))["error"]["kind"] == "no_path"


def test_a_motion_that_the_arm_cannot_execute_is_for_no_robot() -> None:
    far = plan(load_scene("paper").replace(arm={"base": (30.0, 0.0, 0.0)}))
    pushed = plan(load_scene("paper").replace(arm={"q5": 2.5}))

    for result, cause in ((far, "too far away"), (pushed, "q5 passes its limit")):
        with pytest.raises(AbiError, match=cause):
            content(result, "ros")
        assert content(result, "csv")


def test_the_ending_gives_the_format_and_a_path_may_be_text(planned: Plan, tmp_path: Path) -> None:
    path = tmp_path / "trajectory.ros.json"
    formats.export(planned, str(path))
    assert path.read_bytes() == content(planned, "ros-json")
    with pytest.raises(AbiError, match="'cvs'; expected one of csv, json"):
        formats.export(planned, path, "cvs")
    with pytest.raises(AbiError, match="means no format"):
        formats.export(planned, tmp_path / "motion.docx")


def test_a_file_is_replaced_whole_or_not_at_all(planned: Plan, tmp_path: Path) -> None:
    path = tmp_path / "motion.csv"
    path.write_text("old")
    formats.export(planned, path, "csv")
    assert path.read_bytes() == content(planned, "csv")

    with pytest.raises(AbiError, match="cannot be written"):
        formats.export(planned, tmp_path / "none" / "motion.csv", "csv")
    blocked = plan(load_scene("no-way"))
    with pytest.raises(AbiError):
        formats.export(blocked, path, "csv")
    assert path.read_bytes() == content(planned, "csv")
    assert [file.name for file in tmp_path.iterdir()] == ["motion.csv"]


TEXTS = "csv", "json", "ros", "ros-json", "html"
"""Formats of motions that are text."""


def test_every_file_of_a_motion_tells_what_its_arm_touches(planned: Plan) -> None:
    wall = plan(load_scene("wall-with-window"))
    assert wall.arm_clearance is not None
    worst = contact_sentence(wall.arm_clearance.contacts[0], "cm")
    warnings = {name for name, row in FORMATS.items() if worst in row.warning(wall)}
    assert warnings == {name for name, row in FORMATS.items() if row.holds_motion}
    assert "spline" not in warnings
    assert not any(row.warning(planned) for row in FORMATS.values())

    written = {name: content(wall, name).decode() for name in TEXTS}
    comment, *_ = written["ros"].splitlines()
    assert comment.startswith("# ")
    assert worst in comment
    assert len(read_yaml(written["ros"])["points"]) > 100
    for result, words in ((wall, worst), (planned, "whole motion is proven clear")):
        (record,) = make_reader(io.BytesIO(content(result, "mcap"))).iter_metadata()
        assert words in record.metadata["state"]
    assert worst in written["html"]
    for name in TEXTS:
        assert "NOT proven clear" in written[name]
        assert "NOT proven clear" not in content(planned, name).decode()
    assert json.loads(written["json"])["arm"]["contacts"]
    header, *rows = csv.reader(io.StringIO(written["csv"], newline=""))
    assert header[-1] == "state"
    assert all(worst in row[-1] for row in rows)


def test_a_plan_with_an_error_writes_no_motion_unless_asked(tmp_path: Path) -> None:
    collides = plan(load_scene("wrong-elbow").replace(arm={"elbow": "up"}))
    assert collides.error is not None
    assert collides.motion is not None
    for name in ("csv", "json", "ros", "ros-json", "html"):
        path = tmp_path / FORMATS[name].file
        with pytest.raises(AbiError, match="has an error") as refusal:
            formats.export(collides, path, name)
        assert "allow_unproven=True" in refusal.value.hint
        assert not path.exists()
        formats.export(collides, path, name, allow_unproven=True)
        assert "NOT proven clear" in path.read_text(encoding="utf-8")
    formats.export(collides, tmp_path / "obstacles.scene", "moveit")  # which holds no motion


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"arm": {"base": (30.0, 0.0, 0.0)}}, "cannot reach"),
        ({"arm": {"q5": 2.5}, "obstacles": []}, "passes its limit"),
        ({"arm": {"clearance": 0.5, "avoid": False}}, "of the 0.5 cm wanted"),
    ],
)
def test_a_motion_that_is_not_proven_clear_has_a_warning(
    change: dict[str, Any], words: str
) -> None:
    assert words in FORMATS["csv"].warning(plan(load_scene("paper").replace(**change)))


@pytest.mark.parametrize("name", ["ros", "ros-json", "mcap", "rosbag"])
def test_a_motion_longer_than_times_of_ros_is_refused_in_a_sentence(
    planned: Plan, tmp_path: Path, name: str
) -> None:
    assert planned.motion is not None
    longer = replace(planned.motion, time=planned.motion.time * 2.0**32)
    with pytest.raises(AbiError, match="times of ROS hold 68 years"):
        export(replace(planned, motion=longer), tmp_path / "a", name)
