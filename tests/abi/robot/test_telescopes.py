"""Links into which others slide: their pieces hold them, and leave the way open."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from abi.arm_planning.world.chain_distances import Poses, own_distances
from abi.robot.bodies import telescopes
from abi.robot.bodies.telescopes import open_bodies
from abi.robot.urdf.robot_files import robot_from_archive
from abi.robot.urdf_arm import urdf_arm
from tests.abi.robot.robots import joint, packed, urdf
from tests.abi.robot.test_link_bodies import lacks, surface

TILT = 'xyz="0.1 0 0.4" rpy="0.3 0.2 0.1"'


def tube(bottom: float) -> trimesh.Trimesh:
    """A block 0.4 high with a hole from its top to a height above its middle."""
    block, hole = trimesh.creation.box((0.3, 0.2, 0.4)), trimesh.creation.box((0.12, 0.08, 1.0))
    hole.apply_translation((0.02, 0.01, 0.5 + bottom))
    left = trimesh.boolean.difference([block, hole], engine="manifold")
    assert isinstance(left, trimesh.Trimesh)
    return left


def telescope(bottom: float, rod: float) -> bytes:
    """A rod of that width that two slides move out of a tube, as an archive."""
    solid = tube(bottom)
    content = solid.export(file_type="stl")
    assert isinstance(content, bytes)
    limits = '<limit lower="0" upper="0.2" velocity="1" effort="9"/>'
    first, second = (
        joint(name, parent, child, "prismatic", extra=limits)
        for name, parent, child in ("pab", "qbc")
    )
    origin = 'xyz="0 0 0.4" rpy="0.3 0.2 0.1"'
    text = urdf(
        f'<link name="a"><collision><origin {TILT}/><geometry><mesh filename="a.stl"/></geometry>'
        '</collision></link><link name="b"/><link name="c"><collision>'
        f'<origin xyz="0.02 0.01 0.03"/><geometry><box size="{rod} 0.06 0.3"/></geometry>'
        "</collision></link>",
        first.replace(origin, TILT),
        second.replace(origin, 'xyz="0 0 0"'),
    )
    return packed({"r.urdf": text, "a.stl": content})


@pytest.mark.parametrize("bottom", [-0.15, -0.6])
def test_a_tube_is_held_by_pieces_that_a_rod_passes(bottom: float) -> None:
    arm = urdf_arm(robot_from_archive(telescope(bottom, 0.1)), "c", (0.0, 0.0, 0.0))
    bodies = open_bodies(arm.chain)["a"]
    link = arm.chain.robot.links["a"]
    (shape,) = link.shapes
    inside = np.asarray(trimesh.sample.volume_mesh(tube(bottom), 4000))
    inside = inside @ shape.pose[:3, :3].T + shape.pose[:3, 3]
    assert lacks(bodies, np.concatenate([surface(link), inside])) <= 1e-9

    low, high = arm.limits.T
    positions = np.random.default_rng(0).uniform(low, high, (300, 2))
    distances = own_distances(arm, Poses.of(arm, np.concatenate([arm.limits.T, positions])))
    assert {(arm.capsules[i].link, arm.capsules[j].link) for i, j in arm.pairs} == {("a", "c")}
    # halfway to the walls, which are 0.01 away
    assert distances.min() > 0.004


def test_a_rod_that_is_too_wide_for_its_tube_has_no_way() -> None:
    arm = urdf_arm(robot_from_archive(telescope(-0.15, 0.13)), "c", (0.0, 0.0, 0.0))
    assert open_bodies(arm.chain) == {}


def test_what_is_solid_has_no_way_through_it() -> None:
    # a tube that is closed above, too, encloses its way, as a block does that is solid there
    closed = trimesh.creation.box((0.3, 0.2, 0.4))
    inner = trimesh.creation.box((0.12, 0.08, 0.38))
    inner.invert()
    both: trimesh.Trimesh = trimesh.util.concatenate([closed, inner])  # type: ignore[assignment]
    for solid in (closed, both):
        triangles = np.asarray(solid.triangles)
        ends = np.array(
            [[x, y, z] for x in (-0.05, 0.05) for y in (-0.03, 0.03) for z in (-0.05, 0.05)]
        )
        up, piece = np.array([0.0, 0.0, 1.0]), np.stack([ends, ends + np.array([0.0, 0.0, 0.05])])
        assert telescopes._open_way(triangles, up, [piece]) is None
        assert telescopes._way_into(triangles, up, [piece]) is None
