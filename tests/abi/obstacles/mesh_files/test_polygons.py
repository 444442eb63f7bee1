"""Polygons of any form become triangles of the same area."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.mesh_files.polygons import cut, triangulate
from abi.obstacles.pose import rotation
from abi.obstacles.triangle_mesh.mesh_reader import read, read_file

DOORWAY = [(0, 0), (1, 0), (1, 2), (2, 2), (2, 0), (3, 0), (3, 3), (0, 3)]
"""A wall of 9 with a doorway of 2."""
CROSSED = [(0, 0), (1, 1), (1, 0), (0, 1)]
STAR = [(math.cos(0.8 * math.pi * k), math.sin(0.8 * math.pi * k)) for k in range(5)]
"""Its corners all turn left, twice around."""


def in_space(corners: object, wxyz: tuple[float, float, float, float] = (1, 2, 3, 4)) -> FloatArray:
    flat = np.array(corners, dtype=float)
    return np.column_stack([flat, np.full(len(flat), 0.5)]) @ rotation(wxyz).T


def areas(points: FloatArray) -> FloatArray:
    ids, counts = np.arange(len(points), dtype=np.int32), np.array([len(points)], dtype=np.int32)
    return areas_of(points[triangulate(points, ids, counts, str, Counter())])


def areas_of(triangles: FloatArray) -> FloatArray:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


@given(st.lists(st.tuples(st.floats(0.2, 1), st.floats(0.2, 1)), min_size=3, max_size=30))
def test_a_polygon_seen_whole_from_its_middle_keeps_its_area(
    steps: list[tuple[float, float]],
) -> None:
    angles = np.cumsum([step for step, _ in steps]) * 2 * math.pi / sum(s for s, _ in steps)
    radii = np.array([radius for _, radius in steps])
    if len(steps) == 3 and max(np.diff(angles, prepend=0)) > 3:
        radii[:] = 1  # the middle may be outside of a triangle
        angles = np.arange(3) * 2 * math.pi / 3
    corners = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    following = np.roll(corners, -1, axis=0)
    wanted = (corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]).sum() / 2

    found = areas(in_space(corners))
    assert len(found) == len(corners) - 2
    assert found.sum() == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("start", range(8))
def test_a_doorway_stays_open(start: int) -> None:
    turned = [*DOORWAY[start:], *DOORWAY[:start]]
    for corners in (turned, turned[::-1]):
        assert areas(in_space(corners)).sum() == pytest.approx(9 - 2)


def test_a_hole_that_an_edge_there_and_back_joins_stays_open() -> None:
    outline, hole = [(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (1, 2), (2, 2), (2, 1)]
    joined = [*outline, outline[0], *hole, hole[0]]
    assert areas(in_space(joined)).sum() == pytest.approx(16 - 1)
    for turned in (hole, hole[::-1]):
        rings = [in_space(outline), in_space(turned)]
        assert len(cut(rings, "it")) == 8


def test_corners_in_a_line_keep_their_place() -> None:
    line = areas(in_space([(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (1, 0.5), (0, 0.5)]))
    assert (len(line), line.sum()) == (5, pytest.approx(1.5))
    assert areas(in_space([(0, 0), (1, 0), (2, 0), (3, 0)])).sum() < 1e-12


@pytest.mark.parametrize("corners", [CROSSED, [(0, 0), (1, 1), (1, 0), (0, 3)], STAR])
def test_a_polygon_that_crosses_itself_is_refused(corners: Sequence[tuple[float, float]]) -> None:
    points = in_space(corners)
    with pytest.raises(ValueError, match="4711"):
        triangulate(
            points,
            np.arange(len(points), dtype=np.int32),
            np.array([len(points)], dtype=np.int32),
            lambda k: f"4711 {k}",
            Counter(),
        )


def files_of(corners: Sequence[tuple[float, float]]) -> dict[str, bytes]:
    """A polygon in every format that has polygons."""
    count, ids = len(corners), range(len(corners))
    rows = "".join(f"{x} {y} 0\n" for x, y in corners)
    obj = re.sub(r"(?m)^(?=.)", "v ", rows) + f"f {' '.join(str(k + 1) for k in ids)}\n"
    face = f"{count} {' '.join(map(str, ids))}\n"
    header = f"ply\nformat ascii 1.0\nelement vertex {count}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    axes = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    dae = (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>'
        '<library_geometries><geometry id="g"><mesh><source id="s">'
        f'<float_array id="a" count="{3 * count}">{rows}</float_array><technique_common>'
        f'<accessor source="#a" count="{count}" stride="3">{axes}</accessor></technique_common>'
        '</source><vertices id="v"><input semantic="POSITION" source="#s"/></vertices>'
        '<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/>'
        f"<vcount>{count}</vcount><p>{' '.join(map(str, ids))}</p></polylist></mesh></geometry>"
        '</library_geometries><library_visual_scenes><visual_scene id="n"><node>'
        '<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#n"/></scene></COLLADA>'
    )
    return {
        "a.obj": obj.encode(),
        "a.ply": (header + rows + face).encode(),
        "a.off": f"OFF\n{count} 1 0\n{rows}{face}".encode(),
        "a.dae": dae.encode(),
    }


@pytest.mark.parametrize("name", files_of(DOORWAY))
def test_every_format_keeps_a_doorway_and_names_what_crosses_itself(name: str) -> None:
    vertices, faces = read(files_of(DOORWAY)[name], name)
    assert areas_of(vertices[faces]).sum() == pytest.approx(7)
    with pytest.raises(SceneError, match=r"do not cross themselves, (line|face|polygon) \S+"):
        read(files_of(CROSSED)[name], name)


def test_a_hole_of_a_dae_stays_open() -> None:
    square, hole = [(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (1, 2), (2, 2), (2, 1)]
    text = files_of([*square, *hole])["a.dae"].decode()
    start, end = text.index("<vcount>"), text.index("</polylist>")
    holed = f"{text[:start]}<ph><p>0 1 2 3</p><h>4 5 6 7</h></ph>{text[end:]}"
    holed = holed.replace("polylist", "polygons")
    vertices, faces = read(holed.encode(), "a.dae")
    assert "not flat" not in str(read_file(holed.encode(), "a.dae").notes)
    bent = holed.replace("1 1 0", "1 1 0.5", 1).encode()
    assert "not flat" in str(read_file(bent, "a.dae").notes)
    assert areas_of(vertices[faces]).sum() == pytest.approx(16 - 1)


def test_a_polygon_in_no_plane_is_noted() -> None:
    bent = b"v 0 0 0\nv 1 0 0\nv 1 1 0.3\nv 0 1 0\n"
    assert "not flat" in read_file(bent + b"f 1 2 3 4\n", "a.obj").notes[0]
    assert read_file(bent + b"f 1 2 3\nf 1 3 4\n", "a.obj").notes == ()
