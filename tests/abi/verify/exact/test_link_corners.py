"""Pieces of a certificate hold the shapes of a link, and not its corners alone."""

from __future__ import annotations

import contextlib
import itertools
from fractions import Fraction
from functools import partial

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from abi.arrays import FloatArray
from abi.robot.bodies.link_bodies import link_bodies
from abi.robot.urdf.link import LinkShape
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import robot_from_archive
from abi.verify.allowed_contacts import check_insides
from abi.verify.exact.link_corners import (
    _corners,
    _facets,
    _from_means,
    _in_hull,
    _in_link,
    check_corners,
    check_lines,
)
from abi.verify.exact.robot_chain import exact_chain
from abi.verify.exact.solids import ExactSolid, LinkPiece, MovedHull, vector
from abi.verify.fault import Fault
from tests.abi.meshes import sphere, stl
from tests.abi.robot.robots import arm, joint, packed, urdf

BOX = '<box size="0.1 0.1 0.3"/>'
SHAPES = {
    "box": BOX,
    "sphere": '<sphere radius="0.1"/>',
    "cylinder": '<cylinder radius="0.1" length="0.3"/>',
    "mesh": '<mesh filename="a.stl" scale="0.1 0.2 0.3"/>',
}
OBJ = '<mesh filename="a.obj"/>'
STRAY = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
"""A tetrahedron, and a corner beside it."""


def robot_of(name: str) -> Robot:
    return robot_from_archive(packed({"r.urdf": arm((BOX, SHAPES[name])), "a.stl": stl(sphere(1))}))


def around(points: FloatArray, radius: float) -> LinkPiece:
    """A piece that is the hull of points with a radius around it."""
    return (MovedHull("", 0, tuple(map(vector, points.tolist())), Fraction(radius)),)


def check(robot: Robot, pieces: list[LinkPiece]) -> None:
    """Check one link; the others are held by whatever is asked of them."""
    all_of_it = around(np.array([*itertools.product((-9.0, 9.0), repeat=3)]), 0.0)
    bodies = {name: [all_of_it] for name in robot.links}
    check_corners(robot, exact_chain(robot, "d", (0, 0, 0), 1), {**bodies, "a": pieces})


@pytest.mark.parametrize("name", SHAPES)
def test_bodies_of_a_link_hold_it_and_balls_at_its_corners_do_not(name: str) -> None:
    robot = robot_of(name)
    bodies = link_bodies(robot.links["a"])
    check(robot, [around(one.points, one.rounding) for one in bodies])
    corners = np.concatenate([_corners(shape)[0] for shape in robot.links["a"].shapes])
    with pytest.raises(Fault, match="the capsules of a are not"):
        check(robot, [around(one[None], 1e-3) for one in corners])


def test_a_shell_of_plates_around_a_box_leaves_its_inside_out() -> None:
    robot = robot_of("box")
    corners = np.concatenate([_corners(shape)[0] for shape in robot.links["a"].shapes])
    sides = [
        corners[np.isclose(corners[:, axis], end)]
        for axis in range(3)
        for end in (corners[:, axis].min(), corners[:, axis].max())
    ]
    with pytest.raises(Fault, match="the capsules of a are not"):
        check(robot, [around(side, 1e-3) for side in sides])


def part_of(shape: LinkShape, points: FloatArray, axis: int, low: float, high: float) -> LinkPiece:
    """A piece that is the hull of a shape's points, moved in between two planes across an axis."""
    limits = np.full((2, 3), [[-9.0], [9.0]])
    limits[:, axis] = low, high
    return around(_in_link(np.clip(points, *limits), shape), 1e-6)


@pytest.mark.parametrize("gap", [3e-4, -1e-6])
def test_a_slit_between_pieces_of_a_box_is_found_each_time(gap: float) -> None:
    robot = robot_of("box")
    (*_, shape) = robot.links["a"].shapes
    corners = np.array([*itertools.product((-0.05, 0.05), (-0.05, 0.05), (-0.15, 0.15))])
    halves = [part_of(shape, corners, 2, -9, 0.02), part_of(shape, corners, 2, 0.02 + gap, 9)]
    for _ in range(4):
        with pytest.raises(Fault) if gap > 0 else contextlib.nullcontext():
            check(robot, halves)


def test_a_mast_beside_a_wide_plate_is_held_all_along() -> None:
    plate, mast = trimesh.creation.box((9, 9, 0.1)), trimesh.creation.box((1e-3, 1e-3, 1))
    parts = [plate, mast.apply_translation((0, 0, 0.5))]
    mesh = '<mesh filename="a.stl"/>'
    corners = np.concatenate([one.vertices for one in parts])
    content = stl((corners, np.concatenate([parts[0].faces, parts[1].faces + 8])))
    robot = robot_from_archive(packed({"r.urdf": arm((BOX, mesh)), "a.stl": content}))
    shape, (flat, high) = robot.links["a"].shapes[-1], (np.array(one.vertices) for one in parts)

    piece = partial(part_of, shape)
    plates = [[piece(flat, 0, -9, 9)], [piece(flat, 0, -9, 0.1), piece(flat, 0, -0.1, 9)]]
    for whole in plates:
        check(robot, [*whole, piece(high, 2, -9, 9)])
        check(robot, [*whole, piece(high, 2, -9, 0.5), piece(high, 2, 0.4, 9)])
        with pytest.raises(Fault, match="the capsules of a are not"):
            check(robot, [*whole, piece(high, 2, -9, 0.5), piece(high, 2, 0.53, 9)])


@pytest.mark.parametrize("name", ["box", "cylinder", "mesh"])
def test_what_is_inside_of_a_link_is_found_whatever_its_pieces_leave_out(name: str) -> None:
    robot = robot_of(name)
    chain = exact_chain(robot, "d", (0, 0, 0), 1)
    row = [Fraction(0)] * len(chain.coordinates)
    (*_, shape) = robot.links["a"].shapes
    for share, inside in ((0.0, True), (9.0, False)):
        place = vector((shape.pose[:3, 3] + share).tolist())
        small = ExactSolid(vector([0.01] * 3), Fraction(0), Fraction(0), place, (1, 0, 0, 0))
        if inside:
            with pytest.raises(Fault, match="a and obstacle 1 are inside each other"):
                check_insides(robot, chain, row, [small], [("a", 0)])
        else:
            check_insides(robot, chain, row, [small], [("a", 0)])


def test_corners_of_a_file_that_no_triangle_uses_are_no_part_of_a_link() -> None:
    robot = robot_from_archive(packed({"r.urdf": arm((BOX, OBJ)), "a.obj": STRAY}))
    bodies = link_bodies(robot.links["a"])
    check(robot, [around(one.points, one.rounding) for one in bodies])


def test_one_piece_stands_for_all_of_a_line_between_two_joints() -> None:
    joints = [joint(name, *pair) for name, pair in zip("pq", ("ab", "bc"), strict=True)]
    bare = [f'<link name="{name}"/>' for name in "abcd"]
    beside = joint("fixed", "b", "d", "fixed")
    robot = robot_from_archive(packed({"r.urdf": urdf(*bare, *joints, beside)}))
    chain = exact_chain(robot, "c", (0, 0, 0), 1)
    ends = np.array([[0.0] * 3, [*map(float, chain.origins[1][:3, 3])]])
    assert np.linalg.norm(ends[1]) > 0.1
    tip = around(np.zeros((1, 3)), 1e-3)
    check_lines(chain, robot, {"b": [around(ends, 1e-3)], "c": [tip]})
    balls = [around(end[None], 1e-3) for end in ends]
    halves = [around(np.stack([end, ends.mean(axis=0)]), 1e-3) for end in ends]
    whole = [around(ends, 1e-3)]
    for bodies in ({"b": balls}, {"b": halves[:1]}, {"d": whole}, {"a": whole}):
        with pytest.raises(Fault, match="no lines stand"):
            check_lines(chain, robot, {**bodies, "c": [tip]})


@pytest.mark.parametrize("width", [0.02, 1e-6])
@pytest.mark.parametrize("flat", [False, True])
def test_a_hull_with_a_radius_holds_what_is_as_near_to_it(flat: bool, width: float) -> None:
    random = np.random.default_rng(3)
    for _ in range(10):  # needles, beyond whose ends planes moved outward meet far away
        points = random.normal(size=(5, 3)) * [width, width, 1.0]
        points[:, 0] *= not flat
        directions = random.normal(size=(20, 3)) * [1.0, 1.0, 1 / width]
        tips = points[(directions @ points.T).argmax(axis=1)]
        # a tip's distance from its hull along a direction in which no point is farther
        away = 0.2 * directions / np.linalg.norm(directions, axis=1)[:, None]
        (piece,) = around(points, 0.2)
        assert _in_hull(tips + 0.99 * away, _facets(piece, 1e-6)).all()
        assert not _in_hull(tips + 1.01 * away, _facets(piece, 1e-6)).any()


def test_a_hull_holds_nothing_by_rounding_of_its_corners_or_facets() -> None:
    for seed in range(20):  # plates so thin that their facets may stand anyhow
        random, turn = np.random.default_rng(seed), Rotation.random(random_state=seed)
        points = turn.apply(random.normal(size=(8, 3)) * [1.0, 1.0, 1.5e-14])
        middle = points.mean(axis=0)
        farther = np.concatenate([middle + way * (points - middle) for way in (1.05, 1.2, 2.0)])
        outside = farther[[_from_means(one, points) > 1e-3 for one in farther]]
        assert not _in_hull(outside, _facets(around(points, 0.0)[0], 1e-6)).any()
    near = turn.apply(random.normal(size=(9, 3)))
    for corners in (2, 3, 4):  # far away, where numbers are 0.1 apart
        points = turn.apply(1e15 * random.normal(size=(corners, 3)))
        assert not _in_hull(near, _facets(around(points, 0.1)[0], 1e-6)).any()
