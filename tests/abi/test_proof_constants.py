"""Constants that proofs rest on: each covers what is derived here, and half of it would not.

Every derivation bounds what floating point, or a tolerance of the verifier, may take from a proof.
It uses the standard model: an operation is wrong by at most ``U`` of its result. Lengths of vectors
are Euclidean; S is the sum of the largest coordinates of curve and obstacle, so that a point is at
most √3 S from the origin, and the corner of a core at most S from its centre.
"""

from __future__ import annotations

import importlib
import itertools
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.arm_planning.certificates import paper_arm_certificate
from abi.arm_planning.certificates.separate_paper_arm_kernels import allowance_of
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES
from abi.curves.bspline import clamped
from abi.curves.clearance import certificate, separation_kernels
from abi.curves.clearance.certificate import Certificate, certify
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.repair import clean
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.robot.paper_arm import pose_kernels
from abi.robot.paper_arm.pose_kernels import ArmTable, neighbourhood_of, pose_of, reaches
from abi.robot.urdf.robot import MOST_JOINTS
from abi.robot.urdf.urdf_reader import MAX_LINKS
from abi.scene.scene import load_scene
from abi.search.taut import geodesic_kernels
from abi.search.taut.geodesic_kernels import around_box
from abi.verify import verify_paper_arm
from abi.verify.exact import chain as exact_chain
from abi.verify.exact import frame as exact_frame
from abi.verify.exact import robot_chain
from abi.verify.exact.interval import Interval
from abi.verify.exact.paper_arm import ExactArm
from abi.verify.exact.solids import vector
from abi.verify.plan_curves import curve_of
from tests.abi import meshes
from tests.kernel_forms import kernels_as
from tests.thorough import examples

U = 2.0**-53
NO_CAPSULES = np.zeros(0)
ROOT3 = math.sqrt(3)
DEGREE = 5  # the largest that a scene may ask for


def step_of_convex_combination(share: float) -> float:
    """Rounding of (1 - s) a + s b for points within √3 of the origin, in U.

    ``1 - s``, both products and the sum round: 2 (1 - s) |a| + s |b| + |result|. The share s itself
    is a quotient of differences, wrong by 3 s, which moves the point by that times |b - a|.
    """
    return ROOT3 * (2 * (1 - share) + share + 1) + 3 * share * 2 * ROOT3


def per_halving() -> float:
    """De Casteljau in the middle: as many steps in a row as the degree."""
    return step_of_convex_combination(0.5)


def per_degree() -> float:
    """De Boor's blossom: as many steps as the degree, with any share."""
    return step_of_convex_combination(1.0)


def rotation_matrix() -> float:
    """Rounding of a quaternion's matrix, in U, Frobenius norm.

    s = 2 / |q|² is wrong by 5. An entry of the diagonal is 1 less s times two squares, at most 2:
    that is 16, and 1 for the difference. Others are s times a difference of products, at most 1:
    6 and 2.
    """
    return math.hypot(*3 * [17.0], *6 * [8.0])


def direction_in_world() -> float:
    """Rounding of a unit vector turned back, in U: three products and sums, rows within √3."""
    return 3 * ROOT3


def normal_length() -> float:
    """How far a normal's length may be from 1, in U: 8 in the body, and what turning it adds."""
    return 8.0 + rotation_matrix() + direction_in_world()


def per_size() -> float:
    """What is always there, in U S, where curve and obstacle share S: the larger of both parts.

    Of the curve: the difference to the centre, turned into the body (three products and sums, rows
    and all within √3 each); the product with the normal; and the normal turned back times all that.
    Of the obstacle: its support is that of the normal as written, turned by the matrix and back;
    products and sums, 4; the radius counts as long as the normal is. And the difference of both.
    """
    curve = ROOT3 + 9 + 3 * ROOT3 + direction_in_world() * ROOT3 + ROOT3
    support = rotation_matrix() + direction_in_world() + 4
    return max(curve, support + normal_length() + 1)


def per_margin() -> float:
    """The margin counts as long as the normal is; adding it rounds twice, in U."""
    return normal_length() + 2


def least_direction() -> float:
    """Shortest vector whose squares, each wrong by 2^-1075 where small, are right to U together."""
    return math.sqrt(3 * 2.0**-1022 * 2.0**-53 / U)


def arm_allowance() -> float:
    """Rounding of an elbow and of the way to it, as a part of S (1 + L).

    Pieces below 2^-26 S are not halved. A piece's control polygon is halved with it, so that takes
    26 + log2(2 √3 p) halvings of a curve within √3 S. The tool is wrong by what they add up to,
    which counts three times: where the pose is, and at both ends of the farthest way from it.
    The pose itself is wrong by less than 100 U.
    """
    halvings = math.ceil(26 + math.log2(2 * ROOT3 * DEGREE))
    tool = (per_degree() + per_halving() * halvings) * DEGREE
    return (3 * tool + 100) * U


def chain_allowance() -> float:
    """Rounding of a chain's capsules, as a part of S.

    Each joint's pose is a product (three terms, Frobenius norms √3: 9) and a turn by Rodrigues'
    formula (entries wrong by 5: 15, and its product: 9); its origin adds 4. Its angle is factor
    times coordinate and offset, wrong by 2 of at most 64 rad. All turn what is behind them, which
    is within √3 S. Directions and products are those of a curve.
    """
    largest = exact_frame._LARGEST_ANGLE
    return (MOST_JOINTS * ROOT3 * (9 + 15 + 9 + 4 + 2 * largest) + per_size()) * U


def cosine_of_elbow() -> float:
    """Rounding of cos q3 in :func:`neighbourhood_of`, as a part of the squares D² + a3² + a6².

    The nearest and the farthest distance of shoulder and tool are wrong by 6 (of the root of a sum
    of squares, and the difference), their squares by 13; the forearm's square by 3, the upper arm's
    by 1; two differences add 2 of D² and a3² together. The denominator and the quotient add 4 of
    the cosine, at most 1; and 1 less its square is wrong by 1, of which half counts. The squares
    are at least the denominator, so all that is part of them.
    """
    return (13 + 2 + 4 + 0.5) * U


def longer() -> float:
    """Distance of two points: differences; squares and sums, halved by the root; root; product."""
    return (1 + (1 + 2) / 2 + 1 + 1) * U


def verifier_wider() -> float:
    """How much the nearly-rotations of a chain may lengthen a vector, as the verifier admits them.

    An origin T with |T Tᵀ - 1| within e in each entry has a norm of at most 1 + 3 e / 2; a turn
    about an axis with |a|² within e of 1 one of at most 1 + 2 e, and moves a point |a| times as
    fast.
    """
    e = float(robot_chain._NEARLY)
    return ((MAX_LINKS - 1) * 1.5 + MOST_JOINTS * 2 + 0.5) * e


def wider() -> float:
    """What the verifier takes for the matrices, and the rounding of a lever of so many lengths."""
    return float(exact_chain.WIDER - 1) + (3 * MOST_JOINTS + 10) * U


def mesh_rounding() -> float:
    """Product of a corner with a rounded direction: 1, three terms, the error added, the limit."""
    return 5 * U


def mesh_smallest() -> float:
    """Numbers below the normal ones are wrong by 2^-1075: three products and the limit."""
    return 4 * 2.0**-1074 / 2


def slide_moved() -> float:
    """Ends in 2^-60 are wrong by 2^-61 along each axis: two of them."""
    return 2 * ROOT3 * 2.0**-61


def round_down() -> float:
    """Distance of start and goal: right to a unit in the last place, which is 2, and a product."""
    return 3 * U


def around_a_ball() -> float:
    """Length around a ball or a capsule's side, as a part of S.

    Both ends are turned into the body: the difference, and rows as above, each for √3 S; a length
    changes by what they move. Then come two distances to the centre and two tangents, 2.5 each;
    the angle at the centre, from products of three terms, 9; three arctangents of at most a half
    turn, wrong by 2, all times the radius; and the sum.
    """
    ends = 2 * (ROOT3 * rotation_matrix() + 9 + ROOT3)
    return (ends + 4 * 2.5 * ROOT3 + 9 + 3 * 2 * math.pi + 3 * (2 * ROOT3 + math.pi)) * U


@dataclass(frozen=True)
class Constant:
    """A constant of proofs.

    Attributes:
        module, name: where it is.
        derived: least value that proofs need, in the constant's own measure.
        beyond: 1 of a factor, of which the difference from 1 counts.
    """

    module: str
    name: str
    derived: Callable[[], float]
    beyond: int = 0


SEPARATION = "abi.curves.clearance.separation_kernels"
CONSTANTS = [
    Constant(SEPARATION, "PER_SIZE", per_size),
    Constant(SEPARATION, "PER_DEGREE", per_degree),
    Constant(SEPARATION, "PER_HALVING", per_halving),
    Constant(SEPARATION, "PER_MARGIN", per_margin),
    Constant(SEPARATION, "TINY", least_direction),
    Constant("abi.arm_planning.certificates.separate_pairs_kernels", "ALLOWANCE", arm_allowance),
    Constant("abi.arm_planning.certificates.separate_pairs_kernels", "ALLOWANCE", chain_allowance),
    Constant("abi.arm_planning.certificates.separate_pairs_kernels", "LONGER", longer, 1),
    Constant("abi.robot.paper_arm.pose_kernels", "COSINE_ROUNDING", cosine_of_elbow),
    Constant("abi.arm_planning.certificates.separate_chain_kernels", "WIDER", wider, 1),
    Constant("abi.verify.exact.chain", "WIDER", verifier_wider, 1),
    Constant("abi.verify.exact.mesh", "_ROUNDING", mesh_rounding),
    Constant("abi.verify.exact.mesh", "_SMALLEST", mesh_smallest),
    Constant("abi.verify.exact.slide", "_MOVED", slide_moved),
    Constant("abi.search.taut.lower_bound", "_ROUND_DOWN", round_down, 1),
    Constant("abi.search.taut.lower_bound", "_ROUNDING", around_a_ball),
]


def covers(constant: Constant) -> None:
    value = getattr(importlib.import_module(constant.module), constant.name)
    assert abs(value - constant.beyond) >= constant.derived()


@pytest.mark.parametrize(
    "constant", CONSTANTS, ids=lambda one: f"{one.name} {one.derived.__name__}"
)
def test_a_constant_covers_what_is_derived_and_its_half_does_not(
    constant: Constant, monkeypatch: pytest.MonkeyPatch
) -> None:
    covers(constant)
    module = importlib.import_module(constant.module)
    value = getattr(module, constant.name)
    for part in (Fraction(1, 2), 0):
        spared = type(value)(part * (value - constant.beyond) + constant.beyond)
        monkeypatch.setattr(module, constant.name, spared)
        with pytest.raises(AssertionError):
            covers(constant)


@cache
def cube(kind: str) -> Box | MeshShape:
    if kind == "primitive":
        return Box(size=(2, 2, 2))
    found = MeshShape.of(clean(*meshes.box((2, 2, 2))))
    found.prepare()  # compiled
    return found


def is_proven(obstacle: Box | MeshShape, margin: float) -> bool:
    """Whether a line in the exact distance 2 of an obstacle's face is proven to keep a margin."""
    line = clamped(np.array([[3.0, -0.5, 0.25], [3, 0.5, 0.25]]), 1)
    return isinstance(certify(line, ObstacleSet((obstacle,)), margin), Certificate)


@pytest.mark.parametrize("name", ["PER_SIZE", "PER_DEGREE", "PER_MARGIN"])
@pytest.mark.parametrize(("kind", "extent"), [("primitive", 3.0), ("mesh", 2.0)])
def test_what_rounding_may_take_is_not_claimed(
    kind: str, extent: float, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    allowance = separation_kernels.allowance_of(3 + extent, 1, 0, 2.0)
    obstacle = cube(kind)
    with kernels_as(compiled=False):
        assert not is_proven(obstacle, 2 - 0.99 * allowance)
        assert is_proven(obstacle, 2 - 1.01 * allowance)
        monkeypatch.setattr(separation_kernels, name, getattr(separation_kernels, name) / 2)
        assert is_proven(obstacle, 2 - 0.99 * allowance)


@pytest.mark.slow
@settings(max_examples=examples(40))
@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 1e-3, 1e-6]))
def test_an_elbow_is_as_near_as_the_allowance_says(seed: int, near_axis: float) -> None:
    """In exact numbers, with the tool as wrong as a curve's pieces may be, also near the axis."""
    random = np.random.default_rng(seed)
    # of few digits, so that the shoulder's height is exact
    base = np.round(random.uniform(-5, 5, 3) * 2**20) / 2**20
    height, upper, lower = (np.round(random.uniform(0.5, 6, 3) * 2**20) / 2**20).tolist()
    side = float(random.choice([-1.0, 1.0]))
    x, y, z = base.tolist()
    numbers = ArmTable(x, y, z, z + height, upper, lower, side, -1.0, -1.0, NO_CAPSULES)
    away = random.normal(size=3) * (near_axis, near_axis, 1)
    reach = random.uniform(abs(upper - lower), upper + lower)
    tool = np.array([x, y, z + height]) + away / np.linalg.norm(away) * reach
    size = float(np.abs(base).max() + height + upper + lower)
    moved = tool + (arm_allowance() - 100 * U) / 3 * size * random.uniform(-1, 1, 3) / ROOT3
    assume(reaches(numbers, tuple(tool.tolist()), lower))
    assume(reaches(numbers, tuple(moved.tolist()), lower))
    pose = pose_of(numbers, tuple(moved.tolist()), lower)
    near = neighbourhood_of(numbers, pose, float(np.linalg.norm(moved - tool)), 0.0)
    assume(not math.isinf(near.by_tool))
    exact = ExactArm(
        vector(base.tolist()), Fraction(height), Fraction(upper), Fraction(lower), int(side)
    )
    found = exact.near(vector(tool.tolist()), Interval(exact.lower, exact.lower), Fraction(0))
    assert found is not None
    elbow = [float(part.low) for part in found.elbow]
    around = NO_OBSTACLES._replace(size=size)
    assert math.dist(elbow, pose.elbow) <= allowance_of(around, near)


def elbow_is_bounded(seed: int) -> bool:
    """Check in exact numbers if the bound of 1 / |sin q3| holds near a pose, often near its end."""
    random = np.random.default_rng(seed)
    upper, lower = np.exp(random.uniform(-2, 2, 2)).tolist()
    reach = (upper + lower) * (1 - 10.0 ** random.uniform(-7, -2))
    away = reach * 10.0 ** random.uniform(-12, -3)
    numbers = ArmTable(0.0, 0.0, 0.0, 0.0, upper, lower, 1.0, -1.0, -1.0, NO_CAPSULES)
    tool = (0.6 * reach, 0.0, 0.8 * reach)
    near = neighbourhood_of(numbers, pose_of(numbers, tool, lower), away, 0.0)
    if math.isinf(near.by_slide):
        return True
    far = Fraction(math.hypot(tool[0], tool[2])) + Fraction(away)
    a, b = Fraction(upper), Fraction(lower)
    cosine = (far * far - a * a - b * b) / (2 * a * b)
    # the roots of both sides and the quotient round, too, by 3 U in all
    return Fraction(near.by_slide) ** 2 * (1 - cosine * cosine) >= 1 - Fraction(8, 2**53)


def test_the_elbow_is_bounded_near_where_the_arm_is_stretched(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert all(map(elbow_is_bounded, range(400)))
    monkeypatch.setattr(pose_kernels, "COSINE_ROUNDING", 0.0)
    assert not all(map(elbow_is_bounded, range(400)))


def behind_its_box(margin: float) -> bool:
    """Whether a short line is separated from a large mesh's box, in the exact distance 1 of it."""
    large = MeshShape.of(clean(*meshes.box((2e5, 2e5, 2e5)))).model_copy(
        update={"position": (-1e5, 0.0, 0.0)}
    )
    other = large.model_copy(update={"position": (-4e5, 0.0, 0.0)})
    line = clamped(np.array([[1.0, -1e-3, 0], [1, 1e-3, 0]]), 1)
    near, _ = certificate._behind_boxes(line.bezier(), ObstacleSet((large, other)), margin)
    return not near[0]


def test_of_a_large_mesh_the_error_of_its_place_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    error = certificate._PLACED * 5e5
    allowance = separation_kernels.allowance_of(2e5 + 1, 1, 0, 1.0)
    with kernels_as(compiled=False):
        assert not behind_its_box(1 - 0.99 * error)
        assert behind_its_box(1 - 1.01 * error - allowance)
        monkeypatch.setattr(certificate, "_PLACED", certificate._PLACED / 2)
        assert behind_its_box(1 - 0.99 * error)


def is_within_proven(plan: Plan) -> bool:
    """Whether the verifier's bounds of q5 lie in those for which a motion is proven."""
    assert plan.motion is not None
    assert plan.followed is not None
    data, slide = plan.to_dict(), plan.motion.slide
    curve = curve_of(plan.followed, data[plan.followed])
    checked = verify_paper_arm._slide(plan.scene, data["timing"], curve)
    # the proof takes 16 parts of each polynomial
    parts = [one.start + (one.end - one.start) * k / 16 for one in curve for k in range(16)]
    found = [checked(*ends) for ends in itertools.pairwise([*parts, curve[-1].end])]
    low, high = slide.low[:-1].tolist(), slide.high[1:].tolist()
    return all(
        least <= float(one.low) and float(one.high) <= most
        for one, least, most in zip(found, low, high, strict=True)
    )


@pytest.mark.slow
def test_a_proof_leaves_room_for_coarser_bounds_of_the_slide(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = load_scene("paper").replace(arm={"forces": [0.0, 0.2, 0.0]})
    assert is_within_proven(Planner(compile=False)(scene))
    monkeypatch.setattr(paper_arm_certificate, "_SLIDE_PAD", 0.0)
    assert not is_within_proven(Planner(compile=False)(scene))


def grazes(seed: int) -> bool:
    """Whether the bound around a box is no longer than a straight line that grazes a face of it."""
    random = np.random.default_rng(seed)
    half, radius = random.uniform(0.3, 3, 3), float(random.uniform(0.1, 2))
    axis = int(random.integers(2))
    start, goal = np.zeros((2, 3))
    start[axis], goal[axis] = random.uniform(1.1, 3, 2) * (half[axis] + radius) * (-1, 1)
    start[2] = goal[2] = half[2] + radius
    found, _ = around_box(tuple(half), radius, tuple(start), tuple(goal))
    return bool(found <= math.dist(start, goal) * (1 + 8 * U))


@pytest.mark.slow
def test_a_path_that_grazes_a_face_of_a_box_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    assert all(map(grazes, range(60)))
    monkeypatch.setattr(geodesic_kernels, "_ROUNDING", 0.0)
    assert not all(map(grazes, range(60)))


def test_the_table_in_the_documentation_has_them_all() -> None:
    page = (Path(__file__).parents[2] / "docs" / "certificates.md").read_text(encoding="utf-8")
    for constant in CONSTANTS:
        line = f"{constant.module.removeprefix('abi.')}.{constant.name.lstrip('_')}"
        assert re.search(rf"^\| `{re.escape(line)}` \|", page, re.MULTILINE), line
