"""PLY, OFF, 3MF and DAE: as exported, cut off at any place, and made to harm."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_reader import read
from abi.obstacles.triangle_mesh.repair import clean

SUFFIXES = (".ply", ".off", ".3mf", ".dae")
TETRAHEDRON = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]

ENTITY = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><a>&b;</a>'


def exported(suffix: str) -> bytes:
    mesh = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    mesh.apply_translation((1, 2, 3))
    content = mesh.export(file_type=suffix.removeprefix("."))
    return content if isinstance(content, bytes) else bytes(content, "utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_mesh_is_read_as_it_was_written(suffix: str) -> None:
    surface = clean(*read(exported(suffix), f"ball{suffix}"))

    assert surface.closed
    assert len(surface.faces) == 80
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    np.testing.assert_allclose(middle, (1, 2, 3), atol=1e-6)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_no_part_of_a_file_passes_for_the_whole(suffix: str) -> None:
    content = exported(suffix)
    for share in (0.0, 0.1, 0.5, 0.9, 0.98):
        with pytest.raises(SceneError, match="file is"):
            read(content[: int(share * len(content))], f"ball{suffix}")


def archived(model: bytes) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("3D/3dmodel.model", model)
    return packed.getvalue()


def test_a_3mf_with_two_parts_of_one_name_is_refused() -> None:
    packed = io.BytesIO(exported(".3mf"))
    with zipfile.ZipFile(packed, "a") as archive:
        archive.writestr("3D/3DMODEL.model", b"<model/>")
    with pytest.raises(SceneError, match="each part is once"):
        read(packed.getvalue(), "a.3mf")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "expected"),
    [(lambda: ENTITY, "without a document type"), (lambda: bytes(200_000_001), "200 MB")],
    ids=["entity", "too large"],
)
def test_a_model_in_an_archive_that_is_meant_to_harm_is_refused(
    model: Callable[[], bytes], expected: str
) -> None:
    with pytest.raises(SceneError, match=expected):
        read(archived(model()), "a.3mf")


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("a.dae", ENTITY, "without a document type"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nend_header\n", "vertices and faces"),
        ("a.off", b"OFF\n3 999999999 0\n0 0 0\n", "simplify"),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "line 6 has '7'"),
        ("a.stl", b"ply\n", "a PLY file"),
    ],
)
def test_what_is_damaged_or_meant_to_harm_is_refused(
    name: str, content: bytes, expected: str
) -> None:
    with pytest.raises(SceneError, match=expected):
        read(content, name)


@pytest.mark.parametrize("suffix", ["obj", "off", "ply", "stl"])
@pytest.mark.parametrize("word", ["1_0", "1_0.5e0", "\N{ARABIC-INDIC DIGIT ONE}"])
def test_a_number_that_python_alone_reads_is_refused(suffix: str, word: str) -> None:
    mesh = trimesh.Trimesh([[12345, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]], TETRAHEDRON)
    kind = {"ply": {"encoding": "ascii"}}.get(suffix, {})
    text = mesh.export(file_type="stl_ascii" if suffix == "stl" else suffix, **kind)
    content = text if isinstance(text, bytes) else str(text).encode()
    assert len(read(content, f"a.{suffix}")[1]) == 4
    found = re.sub(rb"(?<=\s)12345(\.0*)?(?=\s)", word.encode(), content)
    found = re.sub(rb"(?<=\s)1\.2345\d*e\+0?4(?=\s)", word.encode(), found)
    assert found != content
    with pytest.raises(SceneError, match=r"numbers|not a number"):
        read(found, f"a.{suffix}")
