"""A robot is planned only where loops and couplings of other programs leave its links in place."""

from __future__ import annotations

import numpy as np
import pytest

from abi.certification.motion import Motion
from abi.certification.robot_motion import robot_motion
from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot import Robot, part_from
from abi.robot.urdf.robot_files import load_robot
from abi.robot.urdf_arm import urdf_arm
from abi.scene.scene import Scene
from abi.verify.exact.robot_chain import exact_chain, exact_joints
from tests.abi.robot.robots import joint, link, urdf

_LIMIT = '<limit lower="-2" upper="2" velocity="1" effort="9"/>'
_MIMIC = f'<mimic joint="p" multiplier="-1"/>{_LIMIT}'
_LOOP = (
    '<gazebo><joint name="loop" type="revolute"><parent>{}</parent><child>{}</child></joint>'
    "</gazebo>"
)
_PLUGIN = "<gazebo><plugin><joint>{}</joint><mimicJoint>{}</mimicJoint>{}</plugin></gazebo>"
_CONTROL = (
    '<ros2_control><joint name="{1}"><param name="mimic">{0}</param>'
    '<param name="multiplier">{2}</param></joint></ros2_control>'
)


def text_of(*more: str, crank: str = _LIMIT, rod: str = _LIMIT) -> bytes:
    """An arm a-b-c-d by joints p, q, s, with a crank e and a rod f by joints u and v beside it."""
    parts = [
        *map(link, "abcdef"),
        *(joint("p", "a", "b"), joint("q", "b", "c"), joint("s", "c", "d")),
        *(joint("u", "a", "e", extra=crank), joint("v", "e", "f", extra=rod)),
    ]
    return urdf(*parts, *more).encode()


def read_of(*more: str, **joints: str) -> Robot:
    """The robot of this text."""
    return load_robot("r.urdf", MeshSource({"r.urdf": text_of(*more, **joints)}))


@pytest.mark.parametrize(
    "element",
    [
        _LOOP.format("f", "c"),  # of a crank and a rod that stand still, to the arm
        _LOOP.format("e", "d"),
        _LOOP.format("nowhere", "c"),
        '<gazebo><joint name="loop" type="ball"/></gazebo>',
        '<loop_joint name="loop" type="revolute"><link1 link="c"/><link2 link="f"/></loop_joint>',
        _LOOP.format("world", "d"),  # what the arm could not move in
        "<linear_bushing_rpy><bushing_frameA name='b'/></linear_bushing_rpy>",
        "<gazebo><plugin><parent_link>f</parent_link><child_link>c</child_link></plugin></gazebo>",
        _PLUGIN.format("p", "u", ""),
        _PLUGIN.format("u", "v", "<offset>0.1</offset>"),
        _PLUGIN.format("u", "p", ""),
        _CONTROL.format("q", "v", 1),
    ],
)
def test_no_motion_is_planned_certified_or_verified_of_links_posed_otherwise(element: str) -> None:
    robot = read_of(element)
    assert robot.notes[-1].startswith("Loops and couplings are followed from <mimic> alone, not: ")
    with pytest.raises(SceneError, match="for other programs alone"):
        urdf_arm(robot, "d", (0, 0, 0))
    with pytest.raises(SceneError, match="for other programs alone"):
        exact_chain(robot, "d", (0, 0, 0), 1)
    with pytest.raises(SceneError, match="for other programs alone"):
        exact_joints(robot, ("p", "q", "s"), (0, 0, 0), 1)

    settings = {"model": "urdf", "urdf": "r.urdf", "tip": "d"}
    scene = Scene.from_dict(
        {"version": 1, "unit": "m", "arm": settings}, MeshSource({"r.urdf": text_of(element)})
    )
    motion = Motion(("p", "q", "s"), np.arange(2.0), np.zeros((2, 3)))
    with pytest.raises(AbiError, match="for other programs alone"):
        robot_motion(motion, scene)


@pytest.mark.parametrize(
    ("element", "crank"),
    [
        (_LOOP.format("f", "e"), _LIMIT),  # of joints that all rest where the file closes it
        (_LOOP.format("world", "a"), _LIMIT),
        (_PLUGIN.format("u", "v", "<multiplier>-2</multiplier>"), _LIMIT),  # both rest
        (_PLUGIN.format("p", "u", "<multiplier>-1</multiplier>"), _MIMIC),  # as by <mimic>
        (_CONTROL.format("p", "u", -1), _MIMIC),
        ('<transmission><joint name="p"/></transmission><gazebo reference="p"/>', _LIMIT),
    ],
)
def test_a_robot_is_planned_whose_links_are_where_they_are_posed(element: str, crank: str) -> None:
    robot = read_of(element, crank=crank)
    assert urdf_arm(robot, "d", (0, 0, 0)).joints == ("p", "q", "s")
    assert exact_chain(robot, "d", (0, 0, 0), 1).coordinates == ("p", "q", "s")


@pytest.mark.parametrize(("rod", "closed"), [(-1.0, True), (1.0, False), (None, False)])
@pytest.mark.parametrize(("follows", "child_first"), [(True, False), (True, True), (False, False)])
def test_a_loop_counts_as_told_where_what_follows_keeps_it_closed(
    rod: float | None, closed: bool, follows: bool, child_first: bool
) -> None:
    # a parallelogram: b and e turn alike on a, and f, on b, stays as it was
    def turn(name: str, parent: str, child: str, place: str, factor: float | None) -> str:
        mimic = "" if factor is None else f'<mimic joint="p" multiplier="{factor}"/>'
        whole = joint(name, parent, child, axis="0 1 0", extra=mimic + _LIMIT)
        return whole.replace("0 0 0.4", place).replace('rpy="0.3 0.2 0.1"', "")

    text = urdf(
        *map(link, "abef"),
        turn("p", "a", "b", "0 0 0.2", None),
        turn("v", "b", "f", "0 0 0.4", rod),
        turn("u", "a", "e", "0.3 0 0.2", 1.0 if follows else None),
        _LOOP.format("f", "e")
        .replace("</parent>", "</parent><pose>0 0 0.4 0 0 0</pose>")
        .replace("</child>", "</child><axis><xyz>0 1 0</xyz></axis>"),
    )
    if not follows:  # limits that leave no room to open it are none for motions from elsewhere
        text = text.replace('lower="-2" upper="2"', 'lower="-1e-4" upper="1e-4"')
    if child_first:
        text = text.replace("<parent>f</parent>", "").replace(
            "</child>", "</child><parent>f</parent>"
        )
    robot = load_robot("r.urdf", MeshSource({"r.urdf": text.encode()}))
    # at another place, or welded, it would not stay closed
    for other in (
        ("0 0 0.4 0", "0 0 0.1 0"),
        ('name="loop" type="revolute"', 'name="loop" type="fixed"'),
    ):
        assert other[0] in text
        changed = load_robot("r.urdf", MeshSource({"r.urdf": text.replace(*other).encode()}))
        with pytest.raises(SceneError, match="joint loop, which closes a loop"):
            urdf_arm(changed, "f", (0, 0, 0))
    if closed and follows:
        assert urdf_arm(robot, "f", (0, 0, 0)).joints == ("p",)
        # so it does while it is held, beside an arm or on it
        beside = text.replace("</robot>", link("z") + joint("w", "a", "z") + "</robot>")
        holding = load_robot("r.urdf", MeshSource({"r.urdf": beside.encode()}))
        assert urdf_arm(holding, "z", (0, 0, 0), held={"p": 0.4}).joints == ("w",)
    else:
        with pytest.raises(SceneError, match="joint loop, which closes a loop"):
            urdf_arm(robot, "f", (0, 0, 0))


@pytest.mark.parametrize(
    ("kind", "axis", "mimic", "closed"),
    [
        ("prismatic", "1 0 0", 'multiplier="-1"', True),
        ("prismatic", "0 1 0", 'multiplier="-1"', False),
        ("revolute", "1 0 0", 'multiplier="-1"', False),
        ("fixed", "1 0 0", 'multiplier="-1"', False),
        ("fixed", "1 0 0", 'multiplier="1"', True),
        ("fixed", "1 0 0", 'multiplier="1" offset="0.1"', False),  # not as where all are at 0
    ],
)
@pytest.mark.parametrize("limits", ["", "<limit><lower>-1e16</lower><upper>0.2</upper></limit>"])
def test_a_loop_that_slides_is_closed_by_a_slide_along_its_axis(
    kind: str, axis: str, mimic: str, closed: bool, limits: str
) -> None:
    follows = f'<mimic joint="p" {mimic}/>{_LIMIT}'
    slides = (
        joint("p", "a", "b", "prismatic", "1 0 0"),
        joint("u", "a", "c", "prismatic", "1 0 0", follows),
    )
    loop = _LOOP.format("b", "c").replace("revolute", kind)
    loop = loop.replace("</child>", f"</child><axis><xyz>{axis}</xyz>{limits}</axis>")
    text = urdf(*map(link, "abc"), *slides, loop).replace('rpy="0.3 0.2 0.1"', "")
    robot = load_robot("r.urdf", MeshSource({"r.urdf": text.encode()}))
    told = "Limits of joints that close a loop are not looked at: joint loop."
    assert (told in robot.notes) == bool(limits)
    if closed:
        assert urdf_arm(robot, "b", (0, 0, 0)).joints == ("p",)
    else:
        with pytest.raises(SceneError, match="joint loop, which closes a loop"):
            urdf_arm(robot, "b", (0, 0, 0))


def test_a_loop_is_not_held_where_one_of_its_joints_is_not_where_the_file_closes_it() -> None:
    robot = read_of(_LOOP.format("f", "e"))
    with pytest.raises(SceneError, match="joint loop, which closes a loop"):
        urdf_arm(robot, "d", (0, 0, 0), held={"v": 0.1})


def test_a_follower_that_the_same_mimic_tells_of_is_not_noted() -> None:
    (note,) = read_of(_CONTROL.format("p", "u", -1), crank=_MIMIC).notes
    assert note == "Not used: ros2_control."
    *_, other = read_of(_CONTROL.format("p", "u", 2), crank=_MIMIC).notes
    assert other == "Loops and couplings are followed from <mimic> alone, not: joint u."


def test_a_follower_that_ros2_control_moves_by_itself_is_noted() -> None:
    element = '<ros2_control><joint name="u" mimic="{}"/></ros2_control>'
    told = [any("joint u" in one for one in read_of(element.format(says), crank=_MIMIC).notes)
            for says in ("true", "false")]  # fmt: skip
    assert told == [False, True]


@pytest.mark.parametrize("tag", ["group", "group_state"])
def test_a_joint_that_a_group_names_closes_no_loop(tag: str) -> None:
    named = f'<{tag} name="arm"><joint name="p" type="fixed"/><joint name="q"/></{tag}>'
    robot = read_of(named)
    assert robot.couplings == ()
    assert not [note for note in robot.notes if "Loops" in note]
    other = read_of(named.replace('"p"', '"loop"'))
    assert [one.name for one in other.couplings] == ["loop"]


def test_a_loop_that_a_base_link_cuts_is_refused() -> None:
    robot = read_of(_LOOP.format("c", "a"), _LOOP.format("e", "f").replace("loop", "other"))
    part = part_from(robot, "b")  # p, and what it turns, is left out
    assert [one.name for one in part.couplings] == ["loop"]
    with pytest.raises(SceneError, match="joint loop, which closes a loop"):
        urdf_arm(part, "d", (0, 0, 0))
