"""Public functions, given odd arrays: the right answer or an error of ours, never another."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import abi
from abi import arguments
from abi.arm_planning.motion.liquid import tilts
from abi.arm_planning.paper_arm_model import paper_arm
from abi.curves.bezier import Bezier
from abi.curves.bspline import BSpline, clamped
from abi.curves.clear_quadratic import Target
from abi.curves.clearance.certificate import certify
from abi.curves.cubic_profile import CubicProfile, from_squared_speeds
from abi.curves.curve import arc_length
from abi.curves.quadratic import Quadratic
from abi.curves.three_phase_profile import three_phase
from abi.errors import ArgumentError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Box, Cylinder
from abi.obstacles.triangle_mesh.bvh import build_tree
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.bodies.chain_capsules import segment_distances
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.inverse_dynamics import joint_torques
from abi.robot.paper_arm.paper_arm import PaperArm, forward
from abi.robot.urdf.link import Link, LinkShape
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.arm_settings import ArmSettings
from abi.search.arcs import Arcs
from abi.search.graph import Graph
from abi.search.lifelong_a_star import lifelong_a_star
from abi.search.search import SEARCHES, search
from abi.search.taut.taut_path import polyline_length
from abi.search.taut.tighten_near_meshes import tighten_near_meshes
from abi.search.trace import trace_of
from abi.teach.hidden_scenes import graph_of
from abi.tet_mesh.adjacency import of_rows, rows
from abi.tet_mesh.delaunay import volumes
from abi.tet_mesh.exclusion import Exclusion, FreeMesh, apply, within
from abi.tet_mesh.node_tree import tree_over
from abi.tet_mesh.tet_mesh import TetMesh, edges_of
from tests.abi import meshes
from tests.abi.odd_arrays import EXACT, SAME, WRONG, Array, narrowed, spoilt, widened
from tests.thorough import examples


@dataclass(frozen=True, eq=False)
class Entry:
    """A public function as one of its arrays.

    Attributes:
        call: the function, given that array.
        good: what it takes.
        any_shape: whether it takes numbers in any shape.
        one_for_all: whether it takes one number in place of the array.
        infinite: whether it takes infinity.
    """

    call: Callable[[Any], Any]
    good: Array
    any_shape: bool = False
    one_for_all: bool = False
    infinite: bool = False


POINTS = np.array([[3.0, 0, 0], [0, 4, 1], [0, 1, 0], [9, 2, -7]])
OTHERS = POINTS[::-1] + 1
LIMITS = np.array([1.0, 2, 0, 9])
CURVE = np.array([[0.0, 0, 2], [4, 0, 3], [4, 4, 2], [0, 4, 5]])
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
ANGLES = np.array([[0.0, 1, 1, 0, 0, 2], [1, 1, 2, 0, 0, 0]])
KNOTS = np.array([0.0, 0, 0, 0.5, 1, 1, 1])
BOX = Box(size=(2, 2, 2))
EDGES = np.array([[0, 1], [1, 2], [0, 3], [2, 3]])
LENGTHS = np.array([1.0, 2, 3, 4])
ROWS = rows(EDGES, LENGTHS, 4)


TABLE_ARRAYS = (
    *("before", "origins", "axes", "slides", "source", "factor", "offset", "limits", "direction"),
)


@cache
def ball() -> MeshShape:
    return MeshShape.of(clean(*meshes.sphere(1)))


@cache
def solids() -> ObstacleSet:
    return ObstacleSet((BOX, ball(), Cylinder(radius=1, height=3, position=(5, 5, 5))))


@cache
def graph(lattice: str) -> Graph:
    scene = abi.load_scene("two-boxes").replace(mesh={"lattice": lattice, "pitch": 1.5})
    return graph_of(scene)


@cache
def arcs() -> Arcs:
    return Arcs.of(graph("bcc"), "length")


@cache
def chain() -> Chain:
    scene = abi.load_scene("two-boxes").replace(arm={"model": "urdf", "urdf": "ur5e"})
    robot = scene.arm.robot
    return Chain.of(robot, scene.arm.tool)


@cache
def ur5e() -> UrdfArm:
    return urdf_arm(chain().robot, "tool0", (0.0, 0.0, 0.0))


def of_chain(**fields: Any) -> Any:
    changed = replace(chain(), **fields)
    return changed.poses(np.full((1, 6), 0.3)), changed.limits, changed.speeds, changed.efforts


def of_place(pose: Any) -> Any:
    one = chain()
    return replace(one, places={**one.places, one.robot.root: pose}).places[one.robot.root]


def of_table(field: str) -> Entry:
    good = np.asarray(getattr(chain().table, field))
    return Entry(lambda values: of_chain(table=chain().table._replace(**{field: values})), good)


def of_joint(**fields: Any) -> Any:
    joint = replace(chain().joints[0], **fields)
    return joint.origin, joint.motion(0.3)


def of_shape(**fields: Any) -> Any:
    shape = LinkShape("mesh", (1, 1, 1), np.eye(4), CURVE, TETRAHEDRON, np.zeros((0, 3), np.uint8))
    changed = replace(shape, **fields)
    return changed.pose, changed.vertices, changed.faces


def of_link(**fields: Any) -> Any:
    changed = replace(Link("arm", (), 1.0, np.zeros(3), np.eye(3)), **fields)
    return changed.centre, changed.inertia


def of_arm(**fields: Any) -> Any:
    changed = replace(ur5e(), **fields)
    return changed.base, changed.limits, changed.place(np.full((1, 6), 0.3))


def of_capsule(field: str) -> Entry:
    first, *others = ur5e().capsules

    def call(values: Any) -> Any:
        return of_arm(capsules=(first._replace(**{field: values}), *others))

    return Entry(call, getattr(first, field))


@cache
def usual_arm() -> PaperArm:
    return paper_arm(ArmSettings(), "cm")


def spline() -> BSpline:
    return clamped(CURVE, 2)


def of_set(name: str, *after: Any) -> Callable[[Any], Any]:
    return lambda points: getattr(solids(), name)(points, *after)


def of_mesh(name: str, *after: Any) -> Callable[[Any], Any]:
    return lambda points: getattr(ball(), name)(points, *after)


def of_spline(**fields: Any) -> Any:
    changed = replace(spline(), **fields)
    return changed(np.linspace(0, 1, 5)), certify(changed, solids(), 0.1)


def of_quadratic(**fields: Any) -> Any:
    whole = Quadratic.from_control_points(CURVE, np.array([0.0, 0.5, 1]))
    changed = replace(whole, **fields)
    return changed(np.linspace(0, 1, 5)), arc_length(changed).length


def of_bezier(**fields: Any) -> Any:
    pieces = Bezier(np.array([0.0, 1, 2]), np.stack([CURVE[:3], CURVE[1:]]), 5.0)
    return certify(replace(pieces, **fields), ObstacleSet((BOX,)), 0.1)


def of_tet_mesh(**fields: Any) -> Any:
    made = TetMesh("delaunay", (1, 1, 1), 1.0, CURVE, irregular=np.array([[0, 1, 2, 3]]))
    changed = replace(made, **fields)
    return changed.points, changed.lengths, changed.edges


def of_profile(**fields: Any) -> Any:
    powers = np.array([[0.0, 0], [1, 0], [0, 2], [0, 1]])
    made = CubicProfile(5.0, np.array([0.0, 1, 3]), powers)
    return replace(made, **fields)(np.array([0.0, 0.5, 2]))


def of_graph(lattice: str, field: str) -> Entry:
    def call(values: Any) -> Any:
        changed = replace(graph(lattice), **{field: values})
        return [search(name, changed, "length").cost for name in SEARCHES]

    return Entry(call, getattr(graph(lattice), field), infinite=field == "weights")


def of_arcs(field: str) -> Entry:
    def call(values: Any) -> Any:
        changed = replace(arcs(), rows=arcs().rows._replace(**{field: values}))
        (costs, *_), _ = lifelong_a_star(arcs(), changed)
        return costs[changed.goal]

    return Entry(call, getattr(arcs().rows, field), infinite=field == "weights")


def entries() -> dict[str, Entry]:
    """Public functions by name and argument."""
    box, length = BOX, arc_length(spline())
    return {
        "ConvexShape.signed_distance": Entry(box.signed_distance, POINTS),
        "ConvexShape.signed_distance_gradient": Entry(box.signed_distance_gradient, POINTS),
        "MeshShape.signed_distance": Entry(of_mesh("signed_distance"), POINTS),
        "MeshShape.signed_distance_gradient": Entry(of_mesh("signed_distance_gradient"), POINTS),
        "MeshShape.segment_distance: p": Entry(of_mesh("segment_distance", OTHERS), POINTS),
        "MeshShape.segment_distance: q": Entry(
            lambda q: ball().segment_distance(POINTS, q), OTHERS
        ),
        "MeshShape.segment_distance: most": Entry(
            lambda most: ball().segment_distance(POINTS, OTHERS, most),
            LIMITS,
            one_for_all=True,
            infinite=True,
        ),
        "MeshShape.distance_bounds": Entry(of_mesh("distance_bounds"), POINTS),
        "MeshShape.blocks: p": Entry(of_mesh("blocks", OTHERS, LIMITS), POINTS),
        "MeshShape.blocks: q": Entry(lambda q: ball().blocks(POINTS, q, LIMITS), OTHERS),
        "MeshShape.blocks: margins": Entry(
            lambda most: ball().blocks(POINTS, OTHERS, most), LIMITS
        ),
        "ObstacleSet.nearest": Entry(of_set("nearest"), POINTS),
        "ObstacleSet.signed_distance": Entry(of_set("signed_distance"), POINTS),
        "ObstacleSet.distances_up_to": Entry(lambda at: solids().distances_up_to(9.0, at), POINTS),
        "ObstacleSet.signed_distance_gradient": Entry(of_set("signed_distance_gradient"), POINTS),
        "ObstacleSet.blocked: starts": Entry(of_set("blocked", OTHERS, 0.1), POINTS),
        "ObstacleSet.blocked: ends": Entry(lambda q: solids().blocked(POINTS, q, 0.1), OTHERS),
        "ObstacleSet.blocked: margin": Entry(
            lambda m: solids().blocked(POINTS, OTHERS, m), LIMITS, one_for_all=True
        ),
        "ObstacleSet.polyline_clearance": Entry(of_set("polyline_clearance"), POINTS),
        "ObstacleSet.polyline_clearances": Entry(
            of_set("polyline_clearances"), np.stack([POINTS, OTHERS])
        ),
        "ObstacleSet.segment_clearances": Entry(of_set("segment_clearances"), POINTS),
        "ObstacleSet.near_meshes: starts": Entry(
            lambda p: [rows for _, _, rows in solids().near_meshes(p, OTHERS, LIMITS)], POINTS
        ),
        "ObstacleSet.near_meshes: limits": Entry(
            lambda most: [rows for _, _, rows in solids().near_meshes(POINTS, OTHERS, most)],
            LIMITS,
            infinite=True,
        ),
        "ObstacleSet.most_to_mesh": Entry(of_set("most_to_mesh"), POINTS),
        "clamped": Entry(lambda points: clamped(points, 2)(0.3), CURVE),
        "BSpline: control_points": Entry(lambda at: of_spline(control_points=at), CURVE),
        "BSpline: knots": Entry(lambda knots: of_spline(knots=knots), KNOTS),
        "BSpline: added": Entry(
            lambda flags: replace(spline(), added=flags).inserted, np.array([0, 1, 0, 0], bool)
        ),
        "BSpline.influence": Entry(lambda at: spline().influence(at), np.array([0.0, 1, 1])),
        "BSpline.refined": Entry(lambda e: spline().refined(e)(0.4), np.array([0, 2])),
        "BSpline()": Entry(spline(), np.array([0.0, 1, 0.5]), any_shape=True),
        "Quadratic: coefficients": Entry(
            lambda rows: of_quadratic(coefficients=rows), np.stack([CURVE[:3], CURVE[:3]])
        ),
        "Quadratic: breaks": Entry(lambda at: of_quadratic(breaks=at), np.array([0.0, 0.5, 1])),
        "Quadratic.single": Entry(lambda rows: Quadratic.single(rows)(0.3), CURVE[:3]),
        "Quadratic.from_control_points": Entry(
            lambda at: Quadratic.from_control_points(at, np.array([0, 0.5, 1]))(0.3), CURVE
        ),
        "Quadratic()": Entry(Quadratic.single(CURVE[:3]), np.array([0.0, 1, 0.5]), any_shape=True),
        "Bezier: breaks": Entry(lambda at: of_bezier(breaks=at), np.array([0.0, 1, 2])),
        "Bezier: points": Entry(lambda at: of_bezier(points=at), np.stack([CURVE[:3], CURVE[1:]])),
        "ArcLength.distance": Entry(length.distance, np.array([0.0, 1]), any_shape=True),
        "ArcLength.parameter": Entry(length.parameter, np.array([0.0, 1, 3]), any_shape=True),
        "Graph: excluded": of_graph("bcc", "excluded"),
        "Graph: open_directions": of_graph("bcc", "open_directions"),
        "Graph: weights": of_graph("delaunay", "weights"),
        "Graph: tails": of_graph("delaunay", "tails"),
        "Graph: heads": of_graph("delaunay", "heads"),
        "Graph: link_lengths": of_graph("delaunay", "link_lengths"),
        "Graph.places": Entry(graph("delaunay").places, np.array([0, 3, 1])),
        "Arcs: indptr": of_arcs("indptr"),
        "Arcs: indices": of_arcs("indices"),
        "Arcs: weights": of_arcs("weights"),
        "Chain.poses": Entry(lambda at: chain().poses(at), np.zeros((3, 6))),
        **{f"ChainTable: {name}": of_table(name) for name in TABLE_ARRAYS},
        "Chain: limits": Entry(lambda at: of_chain(limits=at), chain().limits),
        "Chain: speeds": Entry(lambda at: of_chain(speeds=at), chain().speeds, infinite=True),
        "Chain: efforts": Entry(lambda at: of_chain(efforts=at), chain().efforts, infinite=True),
        "Chain: places": Entry(of_place, np.eye(4)),
        "Joint: origin": Entry(lambda at: of_joint(origin=at), np.eye(4)),
        "Joint: axis": Entry(lambda at: of_joint(axis=at), np.array([0.0, 0.6, 0.8])),
        "LinkShape: pose": Entry(lambda at: of_shape(pose=at), np.eye(4)),
        "LinkShape: vertices": Entry(lambda at: of_shape(vertices=at), CURVE),
        "LinkShape: faces": Entry(lambda ids: of_shape(faces=ids), TETRAHEDRON),
        "Link: centre": Entry(lambda at: of_link(centre=at), POINTS[0]),
        "Link: inertia": Entry(lambda at: of_link(inertia=at), np.eye(3)),
        "UrdfArm: base": Entry(lambda at: of_arm(base=at), POINTS[0]),
        "UrdfArm: limits": Entry(lambda at: of_arm(limits=at), ur5e().limits),
        "Body: ends": of_capsule("ends"),
        "Body: points": of_capsule("points"),
        "forward": Entry(lambda at: forward(usual_arm(), at), ANGLES),
        "place": Entry(lambda at: usual_arm().place(at), ANGLES),
        "joint_torques: positions": Entry(
            lambda at: joint_torques(chain(), at, ANGLES, ANGLES), ANGLES
        ),
        "joint_torques: speeds": Entry(
            lambda at: joint_torques(chain(), ANGLES, at, ANGLES), ANGLES
        ),
        "segment_distances": Entry(
            lambda at: segment_distances(at, np.stack([OTHERS, POINTS], axis=1)),
            np.stack([POINTS, OTHERS], axis=1),
        ),
        "tilts": Entry(lambda at: tilts(at, "m"), POINTS),
        "from_squared_speeds": Entry(
            lambda squared: from_squared_speeds(3.0, np.array([0.0, 1, 3]), squared)(0.5),
            np.array([0.0, 4, 1]),
        ),
        "ThreePhaseProfile()": Entry(three_phase(3, 1, 1, 1), np.array([0.0, 1]), any_shape=True),
        "polyline_length": Entry(polyline_length, POINTS),
        "tree_over": Entry(tree_over, np.concatenate([POINTS, OTHERS])),
        "within": Entry(lambda at: within(at, np.zeros(3), np.ones(3)), POINTS),
        "volumes: points": Entry(lambda at: volumes(at, np.array([[0, 1, 2, 3]])), POINTS),
        "volumes: tetrahedra": Entry(lambda ids: volumes(POINTS, ids), np.array([[0, 1, 2, 3]])),
        "rows: edges": Entry(lambda edges: rows(edges, LENGTHS, 4), EDGES),
        "rows: lengths": Entry(lambda lengths: rows(EDGES, lengths, 4), LENGTHS),
        "of_rows: points": Entry(lambda at: of_rows(at, ROWS[0], ROWS[1]), POINTS),
        "of_rows: indptr": Entry(lambda begins: of_rows(POINTS, begins, ROWS[1]), ROWS[0]),
        "of_rows: indices": Entry(lambda ids: of_rows(POINTS, ROWS[0], ids), ROWS[1]),
        "TetMesh: points": Entry(lambda at: of_tet_mesh(points=at), CURVE),
        "TetMesh: irregular": Entry(
            lambda ids: of_tet_mesh(irregular=ids), np.array([[0, 1, 2, 3]])
        ),
        "build_tree": Entry(build_tree, np.stack([CURVE[:3], OTHERS[:3]]), infinite=True),
        "trace_of: order": Entry(
            lambda order: trace_of(arcs(), order, "best_first").examined,
            np.array([arcs().start, 1, 2], dtype=np.int32),
        ),
        "tighten_near_meshes: points": Entry(
            lambda at: tighten_near_meshes(at, ObstacleSet((BOX,)), np.zeros(4)), CURVE * 3
        ),
        "tighten_near_meshes: limits": Entry(
            lambda limits: tighten_near_meshes(CURVE, ObstacleSet((BOX,)), limits),
            np.array([0.0, 1, 0, 0]),
        ),
        "CubicProfile: breaks": Entry(lambda at: of_profile(breaks=at), np.array([0.0, 1, 3])),
        "CubicProfile: coefficients": Entry(
            lambda at: of_profile(coefficients=at), np.array([[0.0, 0], [1, 0], [0, 2], [0, 1]])
        ),
        "Target: breaks": Entry(
            lambda at: Target(at, CURVE, ObstacleSet(()), 0.1).norm, np.array([0.0, 0.5, 1])
        ),
        "Target: control_points": Entry(
            lambda at: Target(np.array([0.0, 0.5, 1]), at, ObstacleSet(()), 0.1).extent, CURVE
        ),
        "Target.distance": Entry(
            Target(np.array([0.0, 0.5, 1]), CURVE, ObstacleSet(()), 0.1).distance, OTHERS
        ),
        "edges_of": Entry(lambda ids: edges_of(ids, 4), np.array([[0, 1, 2, 3]])),
        "clean: vertices": Entry(lambda at: clean(at, TETRAHEDRON).vertices, CURVE),
        "clean: faces": Entry(lambda faces: clean(CURVE, faces).faces, TETRAHEDRON),
        "Surface: vertices": Entry(lambda at: Surface(at, TETRAHEDRON, True).hull, CURVE),
        "Surface: faces": Entry(lambda faces: Surface(CURVE, faces, True).faces, TETRAHEDRON),
        "Chain.follow: start": Entry(lambda at: chain().follow(at, POINTS / 16), np.zeros(6)),
        "Chain.follow: targets": Entry(lambda at: chain().follow(np.zeros(6), at), POINTS / 16),
    }


ENTRIES = entries()


def plain(found: Any) -> list[Any]:
    """The numbers in an answer, for a comparison."""
    if isinstance(found, np.ndarray | int | float | np.generic):
        return [np.asarray(found)]
    if dataclasses.is_dataclass(found):
        found = [one for one in vars(found).values() if one is not None]
    return [part for one in found for part in plain(one)]


def assert_same(found: Any, expected: Any) -> None:
    pairs = zip(plain(found), plain(expected), strict=True)
    for one, other in pairs:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("name", ENTRIES)
def test_the_same_values_in_another_form_have_the_same_answer(name: str) -> None:
    entry = ENTRIES[name]
    expected = entry.call(entry.good)
    forms = dict(SAME)
    if (entry.good == np.round(entry.good)).all() and entry.good.dtype.kind == "f":
        forms |= EXACT
    for form in forms.values():
        assert_same(entry.call(form(entry.good)), expected)


@pytest.mark.parametrize("name", ENTRIES)
def test_what_is_no_such_array_is_an_error_of_ours(name: str) -> None:
    entry = ENTRIES[name]
    wrong = [form(entry.good) for form in WRONG.values()]
    if entry.any_shape:
        wrong = wrong[2:]
    elif entry.one_for_all:
        wrong = wrong[1:]
    elif entry.good.ndim > 1:
        wrong += [widened(entry.good), narrowed(entry.good)]
    if entry.good.dtype.kind == "f":
        wrong += [spoilt(entry.good, k, math.nan) for k in (0, -1)]
        if not entry.infinite:
            wrong += [spoilt(entry.good, k, math.inf) for k in (0, -1)]
    else:
        wrong += [entry.good + 0.5, entry.good.astype(float)]
    if entry.good.dtype.kind in "iu":
        wrong.append(entry.good.astype(np.int64) + 2**40)
    for one in wrong:
        with pytest.raises(abi.AbiError) as caught:
            entry.call(one)
        assert " is " in caught.value.message
        assert "\n" not in caught.value.message


KINDS = ["f8", "f4", ">f8", "i8", "i4", "i2", "u1", "?", "c16", "U3", "O"]


@st.composite
def odd_arrays(draw: st.DrawFn) -> Array:
    """Any few numbers, in any shape, type and layout."""
    shape = draw(st.lists(st.integers(0, 5), max_size=3).map(tuple))
    size = math.prod(shape)
    value = st.sampled_from([0.0, 1.0, -1.0, 0.5, 3.0, 1e9, -1e300, 5e-324, math.nan, math.inf])
    values = draw(st.lists(value, min_size=size, max_size=size))
    kind = draw(st.sampled_from(KINDS))
    with np.errstate(all="ignore"):
        array = np.array(values).reshape(shape).astype(kind)
    return array.T if draw(st.booleans()) else array


@pytest.mark.slow
@settings(max_examples=examples(53))
@given(st.sampled_from(sorted(ENTRIES)), odd_arrays())
def test_any_array_has_the_answer_of_its_numbers_or_an_error_of_ours(
    name: str, array: Array
) -> None:
    try:
        found = ENTRIES[name].call(array)
    except abi.AbiError:
        return
    as_it_should_be = np.ascontiguousarray(array.astype(array.dtype.newbyteorder("=")))
    if as_it_should_be.dtype.kind == "f":
        as_it_should_be = as_it_should_be.astype(float)
    assert_same(found, ENTRIES[name].call(as_it_should_be.reshape(array.shape)))


@pytest.mark.parametrize("wrong", [math.nan, math.inf, "1", None, True, 1j, [1.0]])
@pytest.mark.parametrize(
    "call",
    [
        lambda value: solids().blocked(POINTS[:2], OTHERS[:2], value),
        lambda value: certify(spline(), solids(), value),
        lambda value: arcs().with_arc(0, 1, value),
        lambda value: replace(length_of_spline(), length=value),
        lambda value: replace(spline().bezier(), size=value),
    ],
)
def test_a_number_is_finite(call: Callable[[Any], object], wrong: Any) -> None:
    with pytest.raises(ArgumentError):
        call(wrong)


def length_of_spline() -> Any:
    return arc_length(spline())


@pytest.mark.parametrize("field", ["starts", "lengths", "cut_nodes"])
@pytest.mark.parametrize("wrong", [[10**8], [-1], [0.5], 0, [[0]]])
def test_an_exclusion_names_nodes_that_there_are(field: str, wrong: Any) -> None:
    free = FreeMesh.of(graph("bcc").mesh)
    fields = dict.fromkeys(("starts", "lengths", "cut_nodes", "cut_bits"), np.array([0]))
    with pytest.raises(ArgumentError):
        apply(free, [Exclusion(**{**fields, field: np.array(wrong)})])


@pytest.mark.parametrize("wrong", [-1, 1.5, 10**8, "1", None, True, np.array([1])])
@pytest.mark.parametrize(
    "call",
    [
        lambda value: spline()(0.5, value if value != 10**8 else -2),
        lambda value: clamped(CURVE, value),
        lambda value: arcs().with_arc(value, 0, 1.0),
        lambda value: arcs().with_arc(0, value, 1.0),
        lambda value: replace(graph("bcc"), start=value),
        lambda value: replace(graph("bcc"), goal=value),
    ],
)
def test_an_integer_is_one_and_within_its_range(call: Callable[[Any], object], wrong: Any) -> None:
    with pytest.raises(ArgumentError):
        call(wrong)


def test_a_bezier_s_size_bounds_its_points() -> None:
    with pytest.raises(ArgumentError, match="size is"):
        replace(spline().bezier(), size=1.0)


def test_what_a_caller_gave_stays_his_own() -> None:
    points = CURVE.copy()
    made = clamped(points, 2)
    points[0] = 9.0
    assert made.control_points[0].tolist() == CURVE[0].tolist()
    assert not made.control_points.flags.writeable


@given(st.integers(0, 5), st.sampled_from([1e200, -1e308, math.inf, -math.inf, math.nan]))
def test_only_what_is_not_finite_is_refused_however_large_the_numbers(k: int, odd: float) -> None:
    array = np.full((2, 3), 1e160)  # whose squares overflow
    array.flat[k] = odd
    if math.isfinite(odd):
        assert arguments.numbers("a", array, (-1, 3)) is array
    else:
        with pytest.raises(ArgumentError, match=rf"a\[{k // 3}\]\[{k % 3}\] is {odd}"):
            arguments.numbers("a", array, (-1, 3))
