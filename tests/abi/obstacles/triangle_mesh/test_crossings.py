from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.obstacles.triangle_mesh import crossings
from abi.obstacles.triangle_mesh.crossings import crossing_lines, crossing_shells
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.winding import windings
from tests.abi import meshes
from tests.thorough import examples


def pulled(seed: int) -> meshes.Mesh:
    """A sphere some of whose corners are pulled elsewhere, outward on the whole."""
    rng = np.random.default_rng(seed)
    vertices, faces = meshes.sphere(int(rng.integers(1, 3)))
    vertices *= rng.uniform(0.6, 1.4, (len(vertices), 1))
    count = rng.integers(0, 4)
    vertices[rng.choice(len(vertices), count, replace=False)] = rng.uniform(-1.5, 1.5, (count, 3))
    if rng.random() < 0.3:  # on a lattice, so that triangles touch
        vertices = np.round(vertices * 3) / 3
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    turned = np.einsum("ij,ij->i", np.cross(a, b), c).sum() < 0
    return vertices, faces[:, ::-1] if turned else faces


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=examples(10))
def test_shells_that_wind_back_or_twice_are_told_from_those_that_do_not_cross(seed: int) -> None:
    vertices, faces = pulled(seed)
    around = meshes.box((4, 4, 4))
    label = np.repeat([0, 1], [len(faces), 12])
    crosses, winds_back, _ = crossing_shells(*meshes.joined((vertices, faces), around), label)
    assert not crosses[1]
    assert not winds_back[1]
    points = np.random.default_rng(seed).uniform(-1.6, 1.6, (1000, 3))
    number = windings(vertices, faces, points)
    assert winds_back[0] or number.min() >= 0
    assert crosses[0] or number.max() <= 1


def test_a_line_ends_where_an_edge_runs_through_a_triangle() -> None:
    vertices = np.array(
        [[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1], [1, 3.5, 0.5], [9, 9, 9]]
    )
    lines = crossing_lines(vertices, np.array([[0, 1, 2], [3, 4, 5]], dtype=np.int32))
    assert lines is not None
    assert not len(lines.touching)
    np.testing.assert_allclose(np.sort(lines.ends[0], axis=0), [[1.0, 1.0, 0.0], [1.0, 8 / 3, 0.0]])
    beside = crossing_lines(vertices, np.array([[0, 1, 6], [3, 4, 5]], dtype=np.int32))
    assert beside is not None
    assert not len(beside.triangles)
    along = np.concatenate([vertices, np.array([[1.0, 1, 0], [2, 1, 0], [1, 1, 2]])])
    touching = crossing_lines(along, np.array([[0, 1, 2], [7, 8, 9]], dtype=np.int32))
    assert touching is not None
    assert len(touching.touching)


@pytest.mark.parametrize("seed", range(3))
def test_a_spike_through_its_own_solid_hollows_no_other(seed: int) -> None:
    """Where it comes out on the far side, it winds -1 times."""
    vertices, faces = meshes.sphere(1)
    vertices[vertices[:, 2].argmax()] = [0.03, 0.02 * seed, -3]
    box = meshes.box((2, 2, 2), (0.2, 0, -2.2))
    surface = clean(*meshes.joined((vertices, faces), box))
    points = np.random.default_rng(seed).uniform(-0.99, 0.99, (2000, 3)) + np.array([0.2, 0, -2.2])
    assert surface.closed
    assert (windings(surface.vertices, surface.faces, points) != 0).all()
    assert any("thin shell" in note for note in surface.notes)


@pytest.mark.parametrize(
    ("at", "told"),
    [((0.9, 0.9, -1.2), False), ((0.03, 0.02, -1.6), True), ((0.03, 0.02, -2.1), True)],
)
def test_a_shell_that_winds_back_is_solid_where_it_meets_no_other(
    at: tuple[float, float, float], told: bool
) -> None:
    """Beside another, with that in its spike, or about the spike's end."""
    vertices, faces = meshes.sphere(1)
    vertices[vertices[:, 2].argmax()] = [0.03, 0.02, -2]
    box = meshes.box((0.2, 0.2, 0.3) if at[2] < -2 else (0.02, 0.02, 0.02), at)
    surface = clean(*meshes.joined((vertices, faces), box))
    assert any("thin shell" in note for note in surface.notes) == told
    assert windings(surface.vertices, surface.faces, np.array([at]) + 0.005)[0] != 0
    middle = np.array([[0.5, 0, 0]])
    assert told or windings(surface.vertices, surface.faces, middle)[0] != 0


def test_shells_that_cross_themselves_beyond_the_limit_count_as_winding_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(crossings, "_MOST_SHELLS", 1)
    vertices, faces = meshes.sphere(1)
    vertices[vertices[:, 2].argmax()] = [0.03, 0.02, -3]
    spikes = [(vertices + np.array([k, 0, 0]), faces) for k in range(3)]
    label = np.repeat(np.arange(4, dtype=np.int32), [*[len(faces)] * 3, 12])
    crosses, winds_back, _ = crossings.crossing_shells(
        *meshes.joined(*spikes, meshes.box((8, 2, 2))), label
    )
    assert crosses.tolist() == winds_back.tolist() == [True, True, True, False]


def test_what_is_too_finely_divided_to_ask_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = meshes.box((2, 2, 2)), meshes.box((1, 1, 4))
    both = meshes.joined(first, second)
    assert not any("finely" in note for note in clean(*both).notes)
    monkeypatch.setattr(crossings, "_MOST_PAIRS", 10)
    assert any("2 parts are too finely divided" in note for note in clean(*both).notes)
