"""Colours of what a link is drawn with: of its URDF's materials, else of its meshes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from abi.obstacles.mesh_files import stl
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import SHIPPED, load_robot
from app.layers.arm.link_colours import muted
from tests.abi.robot.robots import arm
from tests.abi.robot.test_visuals import dae, read

BLUE, GREEN = (51, 102, 204), (10, 200, 30)


def painted(*colours: tuple[int, int, int]) -> bytes:
    """A DAE of one ball of 320 triangles in each of these colours."""
    scene = trimesh.Scene()
    for k, colour in enumerate(colours):
        ball = trimesh.creation.icosphere(2, 0.05)
        ball.apply_translation((0, 0, 0.2 * k))
        material = trimesh.visual.material.PBRMaterial(baseColorFactor=[*colour, 255])  # type: ignore[no-untyped-call]
        ball.visual = trimesh.visual.TextureVisuals(material=material)  # type: ignore[no-untyped-call]
        scene.add_geometry(ball, geom_name=f"g{k}")
    parts = scene.dump()
    content = trimesh.exchange.dae.export_collada(parts)  # type: ignore[no-untyped-call]
    assert isinstance(content, bytes)
    return content


def looking(materials: str, visual: str) -> str:
    """The arm whose link ``a`` has a visual ``a.dae`` with that material beside its box."""
    look = f'<visual><geometry><mesh filename="a.dae"/></geometry>{visual}</visual>'
    text = arm().replace("</link>", f"{look}</link>", 1)
    return text.replace("<link", f"{materials}<link", 1)


def colours(robot: Robot, link: str = "a") -> list[list[int]]:
    """Colours of what a link is drawn with, each once."""
    rows = np.concatenate([shape.colours for shape in robot.links[link].drawn])
    return [list(map(int, row)) for row in np.unique(rows, axis=0)]


LOCAL = '<material name="m"><color rgba="0.2 0.4 0.8 1"/></material>'


@pytest.mark.parametrize(
    ("materials", "visual", "wanted"),
    [
        ("", LOCAL, [[*BLUE]]),
        (LOCAL, '<material name="m"/>', [[*BLUE]]),
        (LOCAL.replace("0.2", "0.9"), LOCAL, [[*BLUE]]),
        ("", '<material name="m"/>', []),
        ("", "", []),
        ("", '<material name="m"><color rgba="a b c 1"/></material>', []),
        ("", '<material name="m"><color rgba="2 0 0 1"/></material>', []),
        ("", '<material name="m"><color rgba="nan 0 0 1"/></material>', []),
        ("", '<material name="m"><color/></material>', []),
        ("", '<material name="m"><texture filename="/etc/passwd"/></material>', []),
    ],
)
def test_a_visual_has_the_colour_of_its_material(
    materials: str, visual: str, wanted: list[list[int]]
) -> None:
    for robot in read({"a.urdf": looking(materials, visual), "a.dae": dae(0.1)}):
        assert [len(shape.faces) for shape in robot.links["a"].drawn] == [320]
        found = colours(robot)
        # a ball without a colour may have its file's grey
        assert found == wanted or (not wanted and all(len({*row}) == 1 for row in found))
        assert colours(robot, "b") == []


def test_a_material_stands_for_a_visual_that_cannot_be_read() -> None:
    for robot in read({"a.urdf": looking("", LOCAL), "a.dae": b"<a/>"}):
        assert [shape.kind for shape in robot.links["a"].drawn] == ["box"]
        assert colours(robot) == [[*BLUE]]


def test_parts_of_a_mesh_keep_their_colours_where_no_dae_may_be_left() -> None:
    whole, plain = read({"a.urdf": looking("", ""), "a.dae": painted(BLUE, GREEN)})
    assert colours(whole) == sorted([[*BLUE], [*GREEN]])
    np.testing.assert_allclose(colours(plain), colours(whole), atol=8)
    for robot in (whole, plain):
        (shape,) = robot.links["a"].drawn
        high = shape.vertices[shape.faces].mean(axis=1)[:, 2] > 0.1
        assert high.sum() == 320
        for side, colour in ((high, GREEN), (~high, BLUE)):
            wanted = np.tile(colour, (320, 1))
            np.testing.assert_allclose(shape.colours[side], wanted, atol=8)


def test_an_stl_of_another_program_has_no_colours() -> None:
    mesh = trimesh.creation.box()
    content = bytearray(stl.write(mesh.vertices, mesh.faces.astype(np.int32)))
    assert len(mesh_reader.read_file(bytes(content), "a.stl").parts.colours) == 0
    content[:80] = b"other".ljust(80)
    content[84 + 48 :: 50] = b"\xff" * 12
    content[84 + 49 :: 50] = b"\xff" * 12
    assert len(mesh_reader.read_file(bytes(content), "a.stl").parts.colours) == 0


@pytest.mark.parametrize("name", SHIPPED)
def test_every_solid_of_a_shipped_arm_has_a_colour(name: str) -> None:
    robot = load_robot(name, MeshSource())
    shapes = [shape for link in robot.links.values() for shape in link.drawn]
    assert len(shapes) > 5
    assert all(len(shape.colours) in (1, len(shape.faces)) for shape in shapes)


def test_no_link_is_as_orange_or_as_red_as_what_has_a_meaning() -> None:
    steps = np.arange(0, 256, 17)
    cube = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3).astype(np.uint8)
    for second in (False, True):
        drawn = muted(cube, second).astype(float)
        for meaning in ((215, 124, 71), (168, 16, 22), (169, 57, 22), (255, 90, 54)):
            assert np.linalg.norm(drawn - meaning, axis=1).min() > 60
    greys = muted(np.repeat(steps[:, None], 3, axis=1).astype(np.uint8), False).astype(int)
    assert (np.ptp(greys, axis=1) <= 1).all()
    assert (np.diff(greys.sum(axis=1)) >= 0).all()
    assert greys.min() >= 40
    blue = muted(np.array([BLUE], dtype=np.uint8), False)[0].astype(int)
    assert blue[2] > blue[1] > blue[0]
