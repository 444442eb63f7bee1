"""What planning does not need is let pass with a note; what it needs stays strict."""

from __future__ import annotations

import math

import numpy as np
import pytest

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.inverse_dynamics import has_masses
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import load_robot
from tests.abi.robot.robots import LIMIT, arm, follows, joint, link, urdf

ALL_OF_P = '<limit lower="-2" upper="2" velocity="1" effort="9"/>'
INERTIAL = '<inertial><mass value="1"/><inertia ixx="{}" iyy="1" izz="1"/></inertial></link>'
BARE = '<inertial><mass value="1"/></inertial></link>'


def read_of(text: str) -> Robot:
    """The robot of a URDF."""
    return load_robot("r.urdf", MeshSource({"r.urdf": text.encode()}))


def limited(text: str, more: str = "") -> Robot:
    """A robot whose first joint has another limit."""
    return read_of(arm((ALL_OF_P, text + more)))


def test_a_joint_without_limits_stands_still_and_a_note_says_so() -> None:
    still = limited('<limit velocity="1" effort="9"/>')
    bare = limited("")
    held = limited('<limit lower="0" upper="0" velocity="1" effort="9"/>')

    for robot in (still, bare):
        assert (robot.joints[0].low, robot.joints[0].high) == (0, 0)
        (note,) = robot.notes
        assert note == "Stands still, as its <limit> has no lower and upper: joint p."
    assert [one.high for one in held.joints] == [one.high for one in still.joints]
    assert held.notes == ("Stands still, as its lower limit is the upper: joint p.",)


@pytest.mark.parametrize("kind", ["fixed", "floating", "planar", "spherical"])
@pytest.mark.parametrize("axis", ["0 0 0", "", "nan 0 0"])
def test_a_joint_that_does_not_move_needs_no_axis(kind: str, axis: str) -> None:
    parts = [*map(link, "abc"), joint("p", "a", "b"), joint("q", "b", "c", kind, axis, extra="")]
    robot = read_of(urdf(*parts))
    chain = Chain.of(robot, "c")

    assert chain.names == ("p",)
    assert robot.joints[1].kind == "fixed"
    held = f"Held at the origin, as its kind is {kind}: joint q."
    assert robot.notes == (() if kind == "fixed" else (held,))


@pytest.mark.parametrize("huge", ["1e16", "999999", "1.7976931348623157e+308", "1e999", "inf"])
def test_a_limit_beyond_sense_is_none(huge: str) -> None:
    both = limited(f'<limit lower="-{huge}" upper="{huge}"/>').joints[0]
    above = limited(f'<limit lower="5" upper="{huge}" effort="9"/>').joints[0]
    rates = limited(f'<limit lower="-1" upper="1" velocity="{huge}" effort="-1"/>').joints[0]
    endless = f'<limit lower="0" upper="{huge}"/></joint></robot>'
    slide = read_of(arm((LIMIT + "</joint></robot>", endless))).joints[2]

    assert (both.low, both.high) == (-2 * math.pi, 2 * math.pi)
    assert above.low == 5
    assert above.high == pytest.approx(5 + 2 * math.pi)
    assert rates.effort == math.inf
    assert rates.speed == (999999 if huge == "999999" else math.inf)
    assert (slide.low, slide.high) == (0, 10)


def test_notes_tell_of_limits_that_are_none() -> None:
    limit = '<limit lower="-1e16" upper="1e16" velocity="-1" effort="1e16"/>'
    notes = limited(limit).notes
    assert len(notes) == 3
    assert "Without limit, so taken to go as far as 6.28 rad: joint p." in notes
    assert {name for note in notes for name in ("velocity", "effort") if name in note} == {
        "velocity",
        "effort",
    }
    notes = limited('<limit lower="-1" upper="1" velocity="0"/>').notes
    assert "Without limit of velocity, as that is 0: joint p." in notes


def test_a_number_may_have_as_many_digits_as_its_author_likes() -> None:
    robot = limited(f'<limit lower="-1" upper="{math.pi}{"0" * 30}" velocity="1" effort="9"/>')
    assert robot.joints[0].high == math.pi
    with pytest.raises(SceneError, match=r"joint p, upper .* a number of at most 400 letters"):
        limited(f'<limit upper="3.{"1" * 400}"/>')


@pytest.mark.parametrize(
    ("soft", "expected", "note"),
    [
        ('soft_lower_limit="-0.5" soft_upper_limit="1.5"', (-0.5, 1.5), "Planned within the soft"),
        ('soft_lower_limit="-3" soft_upper_limit="1.5"', (-2, 1.5), "Planned within the soft"),
        ('soft_lower_limit="-3" soft_upper_limit="3"', (-2, 2), None),
        ('soft_upper_limit="1"', (0, 1), "Planned within the soft"),
        ('k_velocity="10"', (-2, 2), None),
        ('soft_lower_limit="4" soft_upper_limit="5"', (-2, 2), "Soft limits are not used"),
    ],
)
def test_soft_limits_are_kept(soft: str, expected: tuple[float, float], note: str | None) -> None:
    robot = limited(ALL_OF_P, f"<safety_controller {soft}/>")
    assert (robot.joints[0].low, robot.joints[0].high) == expected
    assert [one for one in robot.notes if note and one.startswith(note)] == [*robot.notes]
    assert len(robot.notes) == (note is not None)


@pytest.mark.parametrize(
    ("inertial", "counts"),
    [
        (INERTIAL.format("1"), True),
        (INERTIAL.format("-5.42101e-20"), True),
        (INERTIAL.format("nan"), False),
        (INERTIAL.format("-3"), False),
        (INERTIAL.replace('ixx="{}"', ""), False),
        (BARE, False),
        (BARE.replace("1", "0"), None),
    ],
)
def test_masses_without_sense_cost_the_torques_alone(inertial: str, counts: bool | None) -> None:
    weighed = ("</link>", INERTIAL.format("2"))
    robot = read_of(arm(weighed, ("</link><joint", inertial + "<joint")))
    assert has_masses(Chain.of(robot, "d")) == (counts is True)
    note = "No torques, as masses make no sense: d."
    assert robot.notes == ((note,) if counts is False else ())


def test_what_is_not_used_is_named_once() -> None:
    text = arm(
        ("</joint>", '<calibration rising="0"/><dynamics damping="1"/></joint>'),
        ("</joint>", '<calibration rising="0"/></joint>'),
        ("</robot>", "<transmission/><gazebo/><transmission/></robot>"),
    )
    (note,) = read_of(text).notes
    assert note == "Not used: transmission, gazebo, calibration, dynamics."


def test_attributes_that_are_not_used_are_named_too() -> None:
    turned = read_of(arm(('rpy="0.3 0.2 0.1"', 'quat="0 0 1 0"'), ("<axis ", '<axis rpy="1 0 0" ')))
    assert turned.notes == ("Not used: quat of <origin>, rpy of <axis>.",)


def test_a_unit_that_a_comment_names_is_told_of_and_does_not_count_in_an_arm() -> None:
    triangle = "# File units = inches\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    text = arm(('<box size="0.1 0.1 0.3"/>', '<mesh filename="a.obj"/>'))
    robot = load_robot("r.urdf", MeshSource({"r.urdf": text.encode(), "a.obj": triangle.encode()}))
    assert robot.links["a"].shapes[0].vertices.max() == 1
    (note,) = robot.notes
    assert note == "a.obj: Its comment names a unit of 0.0254 m; of an arm it counts in metres."


def test_an_origin_is_turned_by_a_quaternion_as_by_its_angles() -> None:
    angles = np.array([0.3, 0.2, 0.1])
    (a, b, c), (u, v, w) = np.cos(angles / 2), np.sin(angles / 2)
    quaternion = (u * b * c - a * v * w, a * v * c + u * b * w, a * b * w - u * v * c)
    words = " ".join(repr(float(2 * part)) for part in (*quaternion, a * b * c + u * v * w))
    given = f'quat_xyzw="{words}"'
    plain, turned = read_of(arm()), read_of(arm(('rpy="0.3 0.2 0.1"', given)))
    (note,) = set(turned.notes) - {*plain.notes}
    assert note == "quat_xyzw turns, which readers of URDF before version 1.1 ignore: joint p."

    states = np.random.default_rng(1).uniform(-1, 1, (9, 3))
    poses = [Chain.of(one, "d").poses(states) for one in (plain, turned)]
    assert np.abs(poses[0] - poses[1]).max() < 1e-15
    for wrong in ('quat_xyzw="0 0 0 0"', 'quat_xyzw="0 0 1"', f'{given} rpy="0 0 0"'):
        with pytest.raises(SceneError, match="joint p, quat_xyzw"):
            read_of(arm(('rpy="0.3 0.2 0.1"', wrong)))


@pytest.mark.parametrize(
    "name", ["left/b", "b (1)", "[b]", "底座", "основа", "b#2", "ä b", "{b}", "b,c", "@b:=1"]
)
def test_links_and_joints_may_have_any_printable_name(name: str) -> None:
    text = arm().replace('"b"', f'"{name}"').replace('"q"', f'"{name}"')
    robot = read_of(text)
    assert name in robot.links
    assert robot.joints[1].name == name
    assert np.isfinite(Chain.of(robot, "d").poses(np.zeros((1, 3)))).all()


@pytest.mark.parametrize("name", ["", " b", "b\u2028", "a&lt;b", "b`", "../b", "b/..", "x" * 101])
def test_a_refused_name_is_told_what_names_may_be(name: str) -> None:
    with pytest.raises(SceneError, match="1 to 100 letters of any script"):
        read_of(arm(('link name="b"', f'link name="{name}"')))


def test_a_joint_whose_limits_are_swapped_stands_still() -> None:
    robot = limited('<limit lower="1" upper="-1" velocity="1"/>')
    assert (robot.joints[0].low, robot.joints[0].high) == (0, 0)
    note = "Stands still at 0, as its lower limit is above the upper: joint p."
    assert robot.notes == (note,)


@pytest.mark.parametrize("text", ["0, 0, 0.4", "0,\t0, 0.4,", "0 0 0.4 0 7"])
def test_three_numbers_may_be_written_in_other_ways(text: str) -> None:
    robot = read_of(arm(('xyz="0 0 0.4"', f'xyz="{text}"')))
    np.testing.assert_array_equal(robot.joints[0].origin[:3, 3], [0, 0, 0.4])
    told = "Of more numbers than three the first three count, as xyz of joint p."
    assert robot.notes == ((told,) if text.endswith("7") else ())
    for wrong in ("0,0,0.4", "0 0,4", "0,4 0 0"):
        with pytest.raises(SceneError, match="xyz"):
            read_of(arm(('xyz="0 0 0.4"', f'xyz="{wrong}"')))


def test_a_text_may_end_in_zeros() -> None:
    assert load_robot("r.urdf", MeshSource({"r.urdf": arm().encode() + b"\r\n\0\0"})).links
    with pytest.raises(SceneError, match="XML"):
        read_of(arm(("<robot", "\0<robot")))


def test_a_capsule_is_a_cylinder_and_two_balls() -> None:
    box = '<box size="0.1 0.1 0.3"/>'
    text = arm((box, '<capsule radius="0.1" length="0.4"/>'))
    turned = text.replace(
        "<collision>", '<collision><origin xyz="1 2 3" rpy="0 1.5707963268 0"/>', 1
    )
    shapes = read_of(turned).links["a"].shapes
    assert [shape.kind for shape in shapes] == ["cylinder", "sphere", "sphere"]
    places = np.array([shape.pose[:3, 3] for shape in shapes])
    np.testing.assert_allclose(
        places, [[1.0, 2.0, 3.0], [0.8, 2.0, 3.0], [1.2, 2.0, 3.0]], atol=1e-9
    )
    with pytest.raises(SceneError, match="a, length"):
        read_of(arm((box, '<capsule radius="0.1"/>')))


def test_a_variable_that_xacro_left_counts_by_its_default() -> None:
    plain = arm(('xyz="0 0 0.4" rpy="0.3 0.2 0.1"', 'xyz="1 0 -2.5" rpy="0 0 0"'))
    left = plain.replace('"1 0 -2.5"', '"$(optenv CAMERA_XYZ 1 0 -2.5)"', 1)
    robot = read_of(left)
    np.testing.assert_array_equal(robot.joints[0].origin, read_of(plain).joints[0].origin)
    told = "The default of $(optenv …) counts, as no environment is asked: joint p."
    assert robot.notes == (told,)
    for other in ("$(optenv CAMERA_XYZ)", "$(env X)", "${x}", "$(optenv A $(optenv B 1 0 0))"):
        with pytest.raises(SceneError, match="xacro"):
            read_of(plain.replace("1 0 -2.5", other, 1))


def test_what_follows_a_joint_that_is_not_there_is_fixed_at_its_offset() -> None:
    robot = read_of(
        urdf(
            *map(link, "abcd"),
            joint("p", "a", "b", extra=LIMIT + follows("nothing", 2, 0.3)),
            joint("q", "b", "c", extra=LIMIT + follows("p", 0.5, 0.1)),
            joint("s", "c", "d", "prismatic"),
        )
    )
    p, q, _ = robot.joints
    assert Chain.of(robot, "d").names == ("s",)
    plain = read_of(urdf(*map(link, "ab"), joint("p", "a", "b"))).joints[0]
    for found, at in ((p, 0.3), (q, 0.5 * 0.3 + 0.1)):
        np.testing.assert_allclose(found.origin, plain.origin @ plain.motion(at), atol=1e-15)
    told = "Fixed, as it follows a joint that is not there: joint p, joint q."
    assert robot.notes == (told,)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("<collision>", '<collision><origin/><origin xyz="1 0 0"/>', "<origin>"),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><axis xyz="1 0 0"/>', "<axis>"),
        ('<child link="b"/>', '<child link="b"/><child link="c"/>', "<child>"),
        (LIMIT, LIMIT + '<limit lower="-9" upper="9"/>', "<limit>"),
    ],
)
def test_what_stands_there_twice_is_told(old: str, new: str, told: str) -> None:
    robot, plain = read_of(arm((old, new))), read_of(arm())
    assert [note for note in robot.notes if f"Of more than one {told} the first counts" in note]
    for one, other in zip(robot.joints, plain.joints, strict=True):
        np.testing.assert_array_equal(one.axis, other.axis)
        assert (one.low, one.high, one.child) == (other.low, other.high, other.child)
    np.testing.assert_array_equal(robot.links["a"].shapes[0].pose, np.eye(4))


def test_no_solid_of_a_link_is_left_out_without_a_word() -> None:
    box, ball = '<box size="0.1 0.1 0.3"/>', '<sphere radius="3"/>'
    for second in (box + ball, f"{box}</geometry><geometry>{ball}"):
        with pytest.raises(SceneError, match=r"link a, geometry is 'box and sphere'"):
            read_of(arm((box, second)))
    several = f"</collision><collision><geometry>{ball}</geometry></collision>"
    robot = read_of(arm(("</collision>", several)))
    assert [shape.kind for shape in robot.links["a"].shapes] == ["box", "sphere"]
    assert not robot.notes
    group = f"</geometry><group><geometry>{ball}</geometry></group>"
    assert read_of(arm(("</geometry>", group))).notes == ("Not used: group.",)


def test_prefixes_that_nothing_declares_are_let_pass_and_broken_text_is_not() -> None:
    text = '<limit drake:acceleration="2" lower="-1" upper="1" velocity="1" effort="9"/>'
    robot = read_of(arm((ALL_OF_P, text), ("</robot>", "<sensor:camera name='rgb'/></robot>")))
    assert (robot.joints[0].low, robot.joints[0].high) == (-1, 1)
    for broken in (text.replace("/>", ">"), text.replace('"2"', "2")):
        with pytest.raises(SceneError, match="a whole XML text"):
            read_of(arm((ALL_OF_P, broken)))


@pytest.mark.parametrize(
    ("follower", "passes"),
    [
        ('multiplier="-1"', False),
        ('multiplier="1.005"', False),
        ('multiplier="2"', True),
        ('multiplier="1" offset="0.2"', True),
        ('multiplier="0.3" offset="0.2"', False),
        ('multiplier="1" locked="0.3"', True),
        ('multiplier="1" locked="0"', False),  # as where a limit has neither
    ],
)
def test_a_follower_that_its_master_takes_past_its_limits_is_told_of(
    follower: str, passes: bool
) -> None:
    limit = '<limit lower="-0.5" upper="0.5"/>'
    follower, _, locked = follower.partition(" locked=")
    own = f"<limit lower={locked} upper={locked}/>" if locked else limit
    ends = '<parent link="{}"/><child link="{}"/>'
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><link name="c"/>'
        f'<joint name="m" type="prismatic">{ends.format("a", "b")}{limit}</joint>'
        f'<joint name="f" type="prismatic">{ends.format("a", "c")}{own}'
        f'<mimic joint="m" {follower}/></joint></robot>'
    )
    notes = " ".join(read_of(text).notes)
    assert ("past its own limits, which do not count: joint f" in notes) == passes


@pytest.mark.parametrize(
    ("follower", "velocity", "most"),
    [
        ('multiplier="-2" offset="0.1"', "0.5", 0.25),
        ('multiplier="0.5"', "0.5", 1.0),
        ('multiplier="2"', "0", 1.0),  # no limit
        ('multiplier="0"', "0.5", 1.0),
    ],
)
def test_no_joint_is_faster_than_one_that_follows_it_may_be(
    follower: str, velocity: str, most: float
) -> None:
    follows_m = f'<limit lower="-9" upper="9" velocity="{velocity}"/><mimic joint="m" {follower}/>'
    text = urdf(
        *map(link, "abcd"),
        joint("m", "a", "b"),
        joint("f", "b", "c", extra=follows_m),
        joint("g", "b", "d", extra=LIMIT + follows("f", 0.1)),
    )
    robot = read_of(text)
    assert Chain.moved_by(robot, ("m",)).speeds.tolist() == [most]
    said = "No faster than the limits of speed of those that follow allow: joint m."
    assert (said in robot.notes) == (most < 1)


@pytest.mark.parametrize(("axis", "told"), [("0 0 -2", True), ("0.577 0.577 0.577", False)])
def test_a_slide_whose_axis_is_long_is_told_of_and_goes_by_its_position(
    axis: str, told: bool
) -> None:
    robot = read_of(
        urdf(
            *map(link, "abc"),
            *(
                joint(name, first, second, kind, axis)
                for name, first, second, kind in (
                    ("s", "a", "b", "prismatic"),
                    ("t", "b", "c", "revolute"),
                )
            ),
        )
    )
    assert np.linalg.norm(robot.joints[0].motion(0.3)[:3, 3]) == pytest.approx(0.3)
    note = "Slides by its position, however long its axis is: joint s."
    assert (note in robot.notes) == told


def test_a_default_namespace_changes_nothing() -> None:
    named = arm(('<robot name="r">', '<robot xmlns="http://example.org/x" name="r">'))
    plain, read = read_of(arm()), read_of(named)
    assert [*read.links] == [*plain.links]
    assert [one.name for one in read.joints] == [one.name for one in plain.joints]
    assert read != plain  # no archive tells that they are the same


def test_of_a_robot_without_shapes_slides_that_no_line_stands_for_are_told() -> None:
    bare = [f'<link name="{name}"/>' for name in "abc"]
    text = urdf(*bare, joint("turn", "a", "b"), joint("out", "b", "c", "prismatic"))
    notes = read_of(text).notes
    assert any(note.endswith("stand for them, but none where a slide goes: out.") for note in notes)
