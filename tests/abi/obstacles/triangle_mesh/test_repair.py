from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray, IntArray
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh import repair, t_junctions, union
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.shells import shells_of
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.welding import weld, weld_nearby
from abi.obstacles.triangle_mesh.winding import windings
from tests.abi import meshes
from tests.abi.meshes import Mesh
from tests.thorough import examples

RNG = np.random.default_rng(5)
PROBES = RNG.uniform(-2.5, 2.5, (4000, 3))


def in_box(points: FloatArray, size: float, x: float = 0.0) -> np.ndarray:
    return np.asarray((np.abs(points - (x, 0, 0)) < size / 2).all(axis=1))


def inside(surface: Surface, points: FloatArray = PROBES) -> np.ndarray:
    return np.asarray(MeshShape.of(surface).signed_distance(points) < 0)


def volume(surface: Surface) -> float:
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6)


def every_edge_has_two_sides(surface: Surface) -> bool:
    sides = np.concatenate([surface.faces[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    return {(a, b) for a, b in sides.tolist()} == {(b, a) for a, b in sides.tolist()}


BOX = meshes.box((2, 2, 2))
SOUP_OF_BOX = (BOX[0][BOX[1]].reshape(-1, 3), np.arange(36, dtype=np.int32).reshape(-1, 3))
HALF_FLIPPED = (BOX[0], np.concatenate([BOX[1][:5, ::-1], BOX[1][5:]]))


@pytest.mark.parametrize(
    ("mesh", "boxes", "note"),
    [
        (BOX, [(2, 0)], None),
        (SOUP_OF_BOX, [(2, 0)], None),
        (meshes.inverted(BOX), [(2, 0)], "was inside out"),
        (HALF_FLIPPED, [(2, 0)], "5 triangles are inside out"),
        (meshes.joined(BOX, BOX), [(2, 0)], "12 triangles are there twice"),
        (meshes.joined(BOX, meshes.inverted(BOX)), [(2, 0)], "there twice"),
        (meshes.joined(BOX, meshes.box((2, 2, 2), (0.7, 0, 0))), [(2, 0), (2, 0.7)], "2 parts"),
        (meshes.joined(BOX, meshes.box((1, 1, 1))), [(2, 0)], "one solid"),
        (meshes.joined(BOX, meshes.inverted(meshes.box((1, 1, 1)))), [(2, 0)], "Hollows"),
        (
            meshes.joined(
                BOX, meshes.inverted(meshes.box((1, 1, 1))), meshes.box((2, 2, 2), (0.7, 0, 0))
            ),
            [(2, 0), (2, 0.7)],
            "Hollows",
        ),
        (meshes.joined(BOX, meshes.box((1, 1, 1), (-1.8, 0, 0))), [(2, 0), (1, -1.8)], "2 parts"),
        (meshes.joined(meshes.box(), meshes.box(at=(2, 0, 0))), [(1, 0), (1, 2)], "2 parts"),
    ],
    ids=[
        "box", "as-in-stl", "inside-out", "half-flipped", "twice", "twice-inverted", "overlapping",
        "nested", "cavity", "cavity-within-two", "overlapping-by-a-part", "apart",
    ],
)  # fmt: skip
def test_what_is_inside_is_the_union_of_what_the_shells_enclose(
    mesh: Mesh, boxes: list[tuple[float, float]], note: str | None
) -> None:
    surface = clean(*mesh)

    assert surface.closed
    assert every_edge_has_two_sides(surface)
    expected = np.any([in_box(PROBES, size, x) for size, x in boxes], axis=0)
    np.testing.assert_array_equal(inside(surface), expected)
    # by Monte Carlo: the volume of what the probes found
    assert volume(surface) == pytest.approx(expected.mean() * 125, rel=0.25)
    assert (surface.notes == ()) if note is None else any(note in said for said in surface.notes)


@pytest.mark.parametrize("turned", range(0, 12, 3))
def test_what_is_there_twice_beside_a_triangle_inside_out_is_solid_or_told(turned: int) -> None:
    vertices, faces = meshes.box((2, 2, 2), (2, 0, 0))
    faces = np.array(faces)
    faces[turned] = faces[turned, ::-1]
    surface = clean(*meshes.joined(BOX, BOX, (vertices, faces)))
    is_solid = MeshShape.of(surface).signed_distance(np.array([[0.0, 0, 0], [2.0, 0, 0]])) < 0
    assert is_solid.all() or any("thin shell" in note for note in surface.notes)
    said = " ".join(surface.notes)
    assert "1 triangle is inside out" in said or "whichever side they face" in said


@pytest.mark.parametrize(
    ("turned", "twice"),
    [
        ([2, 21, 3, 12], [9, 3, 0, 14, 13]),
        ([4, 14, 12], [23, 7, 22, 19, 13, 5]),
        ([19, 10, 8], [6, 22, 21, 3, 20, 1, 17, 5, 9, 13, 2, 18]),
    ],
)
def test_a_union_keeps_all_of_solids_that_touch_in_a_face(
    turned: list[int], twice: list[int]
) -> None:
    vertices, faces = meshes.joined(meshes.box((4, 4, 4)), meshes.box((8, 4, 4), (6, 0, 0)))
    faces = np.array(faces)
    faces[turned] = faces[turned, ::-1]
    mesh = meshes.joined((vertices, faces), (vertices, faces[twice]), meshes.box(at=(20, 0, 0)))
    surface = clean(*mesh)
    assert not any("thin shell" in note for note in surface.notes)
    assert volume(surface) == pytest.approx(4**3 + 8 * 4 * 4 + 1)
    corners = mesh[0][mesh[1]].mean(axis=1)
    assert (MeshShape.of(surface).signed_distance(corners) <= 1e-9).all()


@pytest.mark.parametrize(
    ("turned", "twice"),
    [([], []), (range(24), []), ([3], []), ([21], []), ([20], []), ([], range(12, 24))],
)
def test_a_solid_is_whole_where_another_in_it_is_flush_with_its_side(
    turned: list[int], twice: list[int]
) -> None:
    """Triangles that both have in common are there twice, from the same side."""
    within = meshes.box((4, 2, 4), (0, 1, 0))
    vertices, faces = meshes.joined(meshes.box((4, 4, 4)), within)
    faces = np.array(faces)
    faces[[*turned]] = faces[[*turned], ::-1]
    surface = clean(*meshes.joined((vertices, faces), (vertices, faces[[*twice]])))
    assert surface.closed
    assert not any("thin shell" in note for note in surface.notes)
    assert inside(surface, PROBES[in_box(PROBES, 3.9)]).all()
    assert clean(surface.vertices, surface.faces).digest == surface.digest


@pytest.mark.parametrize("is_sheet", [False, True])
def test_a_wall_between_solids_is_told_from_a_sheet_by_points_of_each_patch(
    is_sheet: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two cubes that touch, or one whose walls are all there with both their sides."""
    touching = BOX[0] * (-1, 1, 1) + (2, 0, 0), BOX[1][:, ::-1]  # mirrored in the common side
    parts = [BOX, meshes.inverted(BOX), touching] if is_sheet else [BOX, touching]
    shells = shells_of(*(mesh := weld(*meshes.joined(*parts))))
    exact = repair._is_thin(mesh[0], shells)
    assert exact.sum() == (20 if is_sheet else 0)
    asked = []

    def counted(vertices: FloatArray, faces: IntArray, points: FloatArray) -> IntArray:
        asked.append(len(points))
        return windings(vertices, faces, points)

    monkeypatch.setattr(repair, "windings", counted)
    monkeypatch.setattr(repair, "_MOST_WOUND", 60)
    np.testing.assert_array_equal(repair._is_thin(mesh[0], shells), exact)
    assert asked == [1, 1]


def test_solids_that_cross_too_often_to_be_united_are_solid_as_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A grating has as many crossings as bars along times bars across."""
    bars = [meshes.box((4, 0.2, 0.2), (0, y, 0.05)) for y in (-1, 0, 1)]
    bars += [meshes.box((0.2, 4, 0.2), (x, 0, 0)) for x in (-1, 0, 1)]
    united = clean(*meshes.joined(*bars))
    assert any("6 parts count as one" in note for note in united.notes)
    for module, name in ((repair, "_MOST"), (union, "_MOST_CROSSING")):
        with monkeypatch.context() as patched:
            patched.setattr(module, name, 100)
            surface = clean(*meshes.joined(*bars))
        assert len(surface.faces) == 12 * len(bars)
        probes = RNG.uniform((-2.2, -2.2, -0.2), (2.2, 2.2, 0.2), (500, 3))
        both = [windings(one.vertices, one.faces, probes) != 0 for one in (united, surface)]
        np.testing.assert_array_equal(*both)


def test_pairs_of_edges_and_corners_are_not_counted_once_they_are_too_many(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    counted = [0]

    class Tree(scipy.spatial.cKDTree):  # type: ignore[misc]
        def query_ball_point(self, *where: Any, **how: Any) -> Any:
            found = super().query_ball_point(*where, **how)
            counted[0] += int(np.sum(found)) if how.get("return_length") else 0
            return found

    monkeypatch.setattr(scipy.spatial, "cKDTree", Tree)
    monkeypatch.setattr(t_junctions, "_MOST", 1000)
    ends = RNG.normal(size=(1000, 3, 3))
    ends[:, 1] = -ends[:, 0]
    faces = np.arange(3000, dtype=np.int32).reshape(-1, 3)
    split, _ = t_junctions.split_at_corners(ends.reshape(-1, 3), faces, 1e-9)
    assert split is faces
    assert counted[0] < 1000 + 3000 * t_junctions._AT_ONCE


def test_the_union_has_no_faces_inside() -> None:
    surface = clean(*meshes.joined(BOX, meshes.box((2, 2, 2), (0.7, 0, 0))))
    assert volume(surface) == pytest.approx(2.7 * 4)
    centre = np.array([[0.35, 0.1, 0.0]])
    assert MeshShape.of(surface).signed_distance(centre)[0] == pytest.approx(-0.9)


@pytest.mark.parametrize(
    "mesh",
    [
        (BOX[0], BOX[1][:-2]),
        meshes.soup(60),
        (np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]], dtype=float), np.array([[0, 1, 2]])),
        (
            np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]], dtype=float),
            np.array([[0, 1, 2], [2, 1, 0]]),
        ),
    ],
    ids=["open-box", "soup", "sheet", "sheet-of-two-sides"],
)
def test_an_open_surface_has_no_inside_and_says_so(mesh: Mesh) -> None:
    surface = clean(*mesh)

    assert not surface.closed
    assert any("without an inside" in note for note in surface.notes)
    assert not inside(surface).any()
    # nothing of it is lost
    corners = mesh[0][mesh[1]].mean(axis=1)
    np.testing.assert_allclose(MeshShape.of(surface).signed_distance(corners), 0, atol=1e-12)


def touching_box(x: int, y: int) -> Mesh:
    """A box of side 1 at a place of a grid, whose faces have the triangles of its neighbours'."""
    vertices, faces = meshes.box()
    mirrored = np.array([(-1) ** x, (-1) ** y, 1])
    return vertices * mirrored + (x, y, 0), faces if mirrored.prod() > 0 else faces[:, ::-1]


SHEETS = {
    "loose": [[3.0, 0, 0], [4, 0, 0], [3, 1, 0]],
    "needle": [[3.0, 3, 0], [4, 3, 0], [3, 3 + 1e-9, 0]],
    "fin at the edge of a box": [[0.5, 0.5, 0.5], [0.5, 0.5, -0.5], [2, 2, 0]],
    "inside a box": [[0.0, 0.1, 0], [0.2, 0.1, 0], [0, 0.3, 0]],
}


@pytest.mark.slow
@settings(max_examples=40)
@given(
    st.dictionaries(st.tuples(st.integers(-1, 1), st.integers(-1, 1)), st.booleans(), min_size=1),
    st.sets(st.sampled_from(sorted(SHEETS))),
    st.booleans(),
    st.booleans(),
)
def test_solids_stay_solid_and_sheets_stay_beside_them(
    places: dict[tuple[int, int], bool], names: set[str], two_sides: bool, shaken: bool
) -> None:
    solids = [
        meshes.inverted(touching_box(*place)) if inside_out else touching_box(*place)
        for place, inside_out in sorted(places.items())
    ]
    boxes = meshes.joined(*solids)
    if shaken:
        vertices = boxes[0][boxes[1]].reshape(-1, 3)
        faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
        boxes = vertices + RNG.uniform(-1e-9, 1e-9, vertices.shape), faces
    sheets = [(np.array(SHEETS[name]), np.array([[0, 1, 2]])) for name in sorted(names)]
    twice = [meshes.inverted(sheet) for sheet in sheets if two_sides]

    surface = clean(*meshes.joined(boxes, *sheets, *twice))

    centres = np.array([(x, y, 0.0) for x, y in places])
    assert inside(surface, centres + np.array([0.1, 0.2, 0.3])).all()
    corners = centres[:, None] + 0.6 * np.array([[-1, -1, -1], [1, 1, 1], [0, 0, 1]])
    above = [vertices.mean(axis=0) + np.array([0, 0, 0.7]) for vertices, _ in sheets]
    outside = [*corners.reshape(-1, 3), *above]
    assert not inside(surface, np.array(outside)).any()
    for vertices, _ in sheets:
        near = MeshShape.of(surface).signed_distance(vertices.mean(axis=0)[None])
        assert near[0] == pytest.approx(0, abs=1e-7)
    again = clean(surface.vertices, surface.faces)
    assert (again.closed, again.digest) == (surface.closed, surface.digest)


def test_a_moebius_strip_is_left_open() -> None:
    turn = np.linspace(0, 2 * np.pi, 31)[:-1]
    across = np.stack([np.cos(turn / 2) * np.cos(turn), np.cos(turn / 2) * np.sin(turn)], axis=1)
    rim = np.stack([np.cos(turn), np.sin(turn), np.zeros(30)], axis=1)
    half = np.concatenate([across, np.sin(turn / 2)[:, None]], axis=1) / 3
    vertices = np.concatenate([rim + half, rim - half])
    k = np.arange(30)
    then = (k + 1) % 30
    a, b, c, d = k, then, k + 30, then + 30
    b[-1], d[-1] = 30, 0
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
    assert not clean(vertices, faces.astype(np.int32)).closed


def test_a_flat_shell_is_a_surface_not_a_solid_of_nothing() -> None:
    vertices, faces = meshes.box((2, 2, 2))
    surface = clean(vertices * (1, 1, 0), faces)
    assert not surface.closed
    assert MeshShape.of(surface).signed_distance(np.zeros((1, 3)))[0] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("width", [1e-3, 1e-8, 1e-15])
def test_needles_keep_what_touches_them_away(width: float) -> None:
    """Joined where they nearly meet, their corners would leave nothing."""
    vertices = np.array(
        [[0.0, 0, 0], [2, 1, 0], [0, width, 0], [0, 0, 3], [2, 1, 3], [0, width, 3]]
    )
    surface = clean(vertices, np.array([[0, 1, 2], [3, 5, 4]], dtype=np.int32))
    assert not surface.closed
    assert len(surface.faces) == 2
    beside = np.array([[1.0, 0.5, 0.25], [0, 0, 2]])
    np.testing.assert_allclose(MeshShape.of(surface).signed_distance(beside), [0.25, 1], atol=1e-6)


def test_corners_that_nearly_meet_are_joined_where_that_closes_it() -> None:
    vertices, faces = SOUP_OF_BOX
    shaken = vertices + RNG.uniform(-1e-8, 1e-8, vertices.shape)
    assert clean(shaken, faces).closed
    assert np.abs(np.abs(clean(shaken, faces).vertices) - 1).max() < 1e-7
    torn = vertices + RNG.uniform(-1e-3, 1e-3, vertices.shape)
    assert not clean(torn, faces).closed


@given(st.integers(0, 2**32 - 1), st.sampled_from([0, 1e-8]), st.booleans())
@settings(max_examples=examples(12))
def test_a_solid_with_corners_on_the_edges_of_others_stays_solid(
    seed: int, noise: float, many: bool
) -> None:
    """As programs for construction write them: one of two neighbours is split along their edge."""
    rng = np.random.default_rng(seed)
    corners, faces = meshes.bumpy(1) if many else BOX
    vertices, soup = [*corners], [*faces]
    for _ in range(rng.integers(1, 9)):
        # two corners on one edge at times, and pieces that are split again
        a, b, c = soup.pop(rng.integers(len(soup)))
        for share in np.sort(rng.uniform(0.05, 0.95, rng.integers(1, 3))):
            place = (1 - share) * vertices[a] + share * vertices[b]
            vertices.append(place + rng.uniform(-noise, noise, 3))
            soup.append((a, len(vertices) - 1, c))
            a = len(vertices) - 1
        soup.append((a, b, c))
    order = rng.permutation(len(soup))
    surface = clean(np.array(vertices), np.array(soup, dtype=np.int32)[order])
    assert surface.closed
    expected = volume(clean(corners, faces))
    assert volume(surface) == pytest.approx(expected, rel=1e-12 if noise == 0 else 1e-6)
    assert noise or every_edge_has_two_sides(surface)
    assert "Triangles were split where corners of others lie on their edges." in surface.notes[0]
    again = clean(surface.vertices, surface.faces)
    assert again == surface
    # what lay on the surface is not beyond it
    weights = rng.dirichlet(np.ones(3), 5)
    points = (weights @ np.array(vertices)[np.array(soup)]).reshape(-1, 3)
    assert MeshShape.of(surface).signed_distance(points).max() < 1e-15


@pytest.mark.parametrize("noise", [0, 2e-8])
def test_a_box_and_its_flush_half_stay_solid_with_corners_on_their_edges(noise: float) -> None:
    """Edges of one that are split on one side lie on edges and triangles of the other."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        vertices, faces = meshes.joined(meshes.box((4, 4, 4)), meshes.box((2, 4, 4), (-1, 0, 0)))
        soup = []
        for a, b, c in np.roll(vertices[faces], rng.integers(3), axis=1):
            is_cut = rng.random() < 0.3
            soup += [(a, (a + b) / 2, c), ((a + b) / 2, b, c)] if is_cut else [(a, b, c)]
        corners = np.reshape(soup, (-1, 3))
        corners += rng.uniform(-noise, noise, corners.shape)
        surface = clean(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))
        assert surface.closed
        assert inside(surface, PROBES[in_box(PROBES, 3.9)]).all()
        assert not any("inside out" in note for note in surface.notes)


def test_a_corner_beside_an_edge_closes_nothing() -> None:
    vertices, faces = BOX
    a, b, c = faces[0]
    middle = (vertices[a] + vertices[b]) / 2 + 1e-4 * vertices[c]
    torn = [*faces[1:], (a, 8, c), (8, b, c)]
    surface = clean(np.concatenate([vertices, [middle]]), np.array(torn, dtype=np.int32))
    assert not surface.closed
    assert "has holes" in surface.notes[0]


@pytest.mark.parametrize("gap", [1e-9, 2e-7])
@pytest.mark.parametrize("apart", [False, True])
def test_nothing_of_a_surface_is_lost_where_its_gaps_are_closed(gap: float, apart: bool) -> None:
    """Be it a plate that is thinner than the gap, or a needle."""
    cracked = BOX[0][BOX[1]].reshape(-1, 3)
    cracked[0] += gap
    thin = meshes.box((0.4, 0.4, 3e-7), at=(0, 0, 2 if apart else 1))
    soup = thin[0][thin[1]].reshape(-1, 3)
    needle = np.array([[0.5, 0.5, 2], [0.9, 0.9, 2], [0.9 + 1e-8, 0.9, 2]])
    vertices = np.concatenate([cracked, soup, needle])
    faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    surface = clean(vertices, faces)

    assert inside(surface, np.zeros((1, 3))).all()
    assert surface.notes[0].startswith("Small gaps between its triangles were closed.")
    weights = RNG.dirichlet(np.ones(3), 20)
    points = (weights @ vertices[faces]).reshape(-1, 3)
    assert MeshShape.of(surface).signed_distance(points).max() < 1e-15


def test_a_triangle_without_area_is_told_of_only_where_no_other_has_its_line() -> None:
    vertices, faces = BOX
    ends = vertices[faces[0, :2]]
    vertices = np.concatenate([vertices, [ends.mean(axis=0)]])
    along = [[*faces[0, :2], 8], [faces[0, 0]] * 3]
    assert clean(vertices, np.concatenate([faces, along]).astype(np.int32)).notes == ()
    beyond = np.concatenate([vertices, [ends[0] + 2 * (ends[1] - ends[0])]])
    loose = np.concatenate([faces, [[*faces[0, :2], 9]]]).astype(np.int32)
    (note,) = clean(beyond, loose).notes
    assert note == "1 triangle is left out: without area, and along no other."


def test_boxes_that_share_an_edge_stay_closed() -> None:
    mesh = meshes.joined(meshes.box(), meshes.box(at=(1, 1, 0)))
    surface = clean(*mesh)
    assert surface.closed
    expected = in_box(PROBES, 1) | in_box(PROBES - (0, 1, 0), 1, 1)
    np.testing.assert_array_equal(inside(surface), expected)


def test_needles_and_points_are_left_out() -> None:
    vertices = np.concatenate([BOX[0], [[0, 0, 3], [0, 0, 4], [0, 0, 5]]])
    needles = np.array([[8, 9, 10], [8, 8, 9], [0, 0, 0]], dtype=np.int32)
    surface = clean(vertices, np.concatenate([BOX[1], needles]))
    assert len(surface.faces) == 12
    assert surface.notes == ("2 triangles are left out: without area, and along no other.",)
    with pytest.raises(SceneError, match="area"):
        clean(vertices, needles)


def test_surfaces_compare_by_content() -> None:
    surface, again = clean(*BOX), clean(*SOUP_OF_BOX)
    assert clean(*BOX) == surface
    assert hash(clean(*BOX)) == hash(surface)
    assert surface != clean(*meshes.box((2, 2, 2.0000001)))
    assert surface != "surface"
    assert again.closed
    with pytest.raises(ValueError, match="read-only"):
        surface.vertices[0] = 1


def test_a_closed_mesh_of_many_faces_stays_as_it_is() -> None:
    vertices, faces = meshes.bumpy(4)
    surface = clean(vertices, faces)
    assert surface.closed
    assert surface.notes == ()
    assert len(surface.faces) == len(faces)
    assert volume(surface) > 0
    assert surface.extent == np.ptp(vertices, axis=0).max()
    low, high = surface.hull.min(axis=0), surface.hull.max(axis=0)
    np.testing.assert_array_equal([low, high], [vertices.min(axis=0), vertices.max(axis=0)])


@pytest.mark.parametrize("crosses", [True, False])
def test_a_closed_surface_that_crosses_itself_is_not_said_to_have_holes(crosses: bool) -> None:
    ring = [(0, 0), (1, 1), (1, 0), (0, 1)]  # whose two lobes turn against each other
    vertices = np.array([(x, y, z) for z in (0, 1) for x, y in ring], dtype=np.float64)
    walls = [(k, (k + 1) % 4, (k + 1) % 4 + 4) for k in range(4)]
    walls += [(k, (k + 1) % 4 + 4, k + 4) for k in range(4)]
    caps = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)]
    surface = clean(vertices, np.array([*walls, *caps] if crosses else walls, np.int32))
    assert not surface.closed
    (note,) = surface.notes
    assert ("crosses itself" in note, "has holes" in note) == (crosses, not crosses)


@pytest.mark.parametrize("beside", [False, True])
def test_shells_that_run_into_themselves_are_solid_where_several_do(beside: bool) -> None:
    """Rings that go round twice, one over the other, and perhaps a larger box beside them."""
    rings = []
    for count, height in ((40, 0.12), (44, 0.1)):
        angle = 4 * np.pi * np.arange(count) / count
        radius, level = 2 + height * np.cos(angle / 2), height * np.sin(angle / 2)
        corners = [
            ((radius + x) * np.cos(angle), (radius + x) * np.sin(angle), level + z)
            for x, z in ((-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5))
        ]
        vertices = np.stack([np.stack(one, axis=1) for one in corners], axis=1).reshape(-1, 3)
        here, side = np.meshgrid(np.arange(count), np.arange(4), indexing="ij")
        a, b = 4 * here + side, 4 * here + (side + 1) % 4
        c, d = ((one + 4) % (4 * count) for one in (b, a))
        quads = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
        rings.append((vertices, quads.astype(np.int32)))
    parts = [*rings, *([meshes.box((4, 4, 4), at=(8, 0, 0))] if beside else [])]
    surface = clean(*meshes.joined(*parts))
    assert surface.closed
    around = np.linspace(0, 2 * np.pi, 12)
    middles = np.stack([2 * np.cos(around), 2 * np.sin(around), 0 * around], axis=1)
    assert inside(surface, middles).all()
    assert not inside(surface, np.array([[0, 0, 0], [2, 0, 0.9]])).any()


@pytest.mark.parametrize(("low", "high"), [(1, 7), (-20, 28)])
@pytest.mark.parametrize("beside", [False, True])
def test_a_lobe_that_winds_the_other_way_leaves_no_solid_hollow_that_it_runs_through(
    low: float, high: float, beside: bool
) -> None:
    """A prism whose outline crosses itself winds -1 times around one of its two lobes."""
    outline = [(2, 1), (14, 10), (14, 1), (2, 5.5)]
    vertices = np.array([(x, y, z) for z in (low, high) for x, y in outline], dtype=np.float64)
    walls = [(k, (k + 1) % 4, (k + 1) % 4 + 4) for k in range(4)]
    walls += [(k, (k + 1) % 4 + 4, k + 4) for k in range(4)]
    caps = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)]
    prism = vertices, np.array([*walls, *caps], np.int32)
    ball = meshes.sphere(3)
    more = [(ball[0] + 6.0, ball[1])] if beside else []
    surface = clean(*meshes.joined(*more, meshes.box((4, 8, 8), at=(2, 4, 4)), prism))
    probes = np.random.default_rng(1).uniform((0.1, 0.1, 0.1), (3.9, 7.9, 7.9), (500, 3))
    assert inside(surface, probes).all()
    assert inside(surface, np.array([[13.5, 5.5, 4.0]])).all()
    apart = clean(*meshes.joined(meshes.box((4, 8, 8), at=(-9, 4, 4)), prism))
    assert apart.closed


@pytest.mark.parametrize("noise", [1e-10, 1e-8, 6e-8])
def test_gaps_much_smaller_than_the_tolerance_are_closed_wherever_they_are(noise: float) -> None:
    """Each corner of a triangle has coordinates of its own, some on another side of a border."""
    vertices, faces = meshes.sphere(2)
    apart = vertices[faces].reshape(-1, 3)
    for seed in range(5):
        shaken = apart + np.random.default_rng(seed).uniform(-noise, noise, apart.shape)
        surface = clean(shaken, np.arange(len(shaken), dtype=np.int32).reshape(-1, 3))
        assert surface.closed
        assert inside(surface, vertices * 0.9).all()


def test_a_chain_of_near_corners_is_not_drawn_together() -> None:
    """Triangles of which one corner each is nearer to the next one's than the tolerance."""
    along, zero = np.arange(60.0), np.zeros(60)
    chain = np.stack([along * 0.9e-6, zero, zero], axis=1)
    far = np.stack([along, zero + 1, zero], axis=1), np.stack([along, zero + 2, zero], axis=1)
    faces = np.arange(180, dtype=np.int32).reshape(3, 60).T.copy()
    near, near_faces, _ = weld_nearby(np.concatenate([chain, *far]), faces, 1e-6)
    moved = near[near_faces[:, 0]] - chain
    assert np.abs(moved).max() < 2e-6


def test_a_united_surface_with_sheets_is_the_same_when_it_is_read_again() -> None:
    rng = np.random.default_rng(1)
    for _ in range(12):
        sizes, places = rng.integers(1, 4, (3, 3)) * 0.5, rng.integers(0, 4, (3, 3)) * 0.5
        boxes = [
            meshes.box(tuple(a), tuple(b))
            for a, b in zip(sizes.tolist(), places.tolist(), strict=True)
        ]
        corners = np.concatenate([vertices for vertices, _ in boxes])
        fin = corners[rng.choice(len(corners), 3, replace=False)], np.array([[0, 1, 2]])
        surface = clean(*meshes.joined(*boxes, fin))
        assert clean(surface.vertices, surface.faces).digest == surface.digest


@pytest.mark.parametrize(
    ("is_flapped", "most", "told"),
    [
        (False, 2000, ""),
        (True, 2000, "3 triangles are no part of a solid"),
        (True, 10, "At least 1 triangle is no part of a solid"),
    ],
)
def test_triangles_of_a_repaired_solid_that_fold_onto_each_other_are_told(
    is_flapped: bool, most: int, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A flap at one of its edges, which all have two sides, since it is split on one side only."""
    monkeypatch.setattr(repair, "_MOST_FOLDED", most)
    vertices, faces = meshes.box((2, 2, 2))
    a, b, x = faces[0].tolist()
    (other,) = (k for k, one in enumerate(faces[1:].tolist(), 1) if {a, b} < {*one})
    (y,) = {*faces[other].tolist()} - {a, b}
    middle = (vertices[a] + vertices[b]) / 2
    vertices = np.vstack([vertices, middle, 3 * middle + vertices[x]])
    m, c = 8, 9
    flap = [(b, a, c), (a, m, c), (m, b, c), (b, m, y), (m, a, y)] if is_flapped else [(b, a, y)]
    rest = np.delete(faces, other, axis=0)
    rest[-1] = rest[-1, ::-1]  # which is turned
    surface = clean(vertices, np.vstack([rest, flap]).astype(np.int32))
    assert surface.closed
    assert any("no part of a solid" in one for one in surface.notes) == is_flapped
    assert any(one.startswith(told) for one in surface.notes)
