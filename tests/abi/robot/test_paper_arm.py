from __future__ import annotations

import io
import itertools
import math
import re
from typing import Literal

import numpy as np
import pytest
import trimesh
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from abi import assets
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arrays import FloatArray
from abi.errors import AbiError
from abi.robot.bodies.link_solid import LinkSolid
from abi.robot.bodies.urdf_writer import DENSITY, inertia
from abi.robot.paper_arm import arm_links
from abi.robot.paper_arm.paper_arm import JOINTS, STROKE, PaperArm, forward, urdf
from abi.scene.arm_settings import ArmSettings

LENGTH = st.floats(-1.5, 1.5).map(lambda power: 10.0**power)
COORDINATE = st.floats(-20, 20)
Unit = Literal["m", "cm", "mm"]
METRES: dict[Unit, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}


@st.composite
def arms(draw: st.DrawFn) -> PaperArm:
    lengths = {name: draw(LENGTH) for name in ("a1", "a2", "a3", "a4", "a5")}
    base = (draw(COORDINATE), draw(COORDINATE), draw(COORDINATE))
    return paper_arm(ArmSettings(base=base, **lengths), draw(st.sampled_from(list(METRES))))


def load(text: str) -> yourdfpy.URDF:
    return yourdfpy.URDF.load(io.BytesIO(text.encode()), build_scene_graph=True, load_meshes=False)


def random_positions(arm: PaperArm, count: int, seed: int) -> FloatArray:
    low, high = arm.limits.T
    return np.asarray(low + np.random.default_rng(seed).random((count, 6)) * (high - low))


def solids(arm: PaperArm) -> list[LinkSolid]:
    links = arm_links.links(arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)
    return [solid for link in links.values() for solid in link]


@pytest.mark.slow
@settings(max_examples=8)
@given(arms(), st.integers(0, 2**32 - 1))
def test_the_urdf_moves_as_forward_says(arm: PaperArm, seed: int) -> None:
    positions = random_positions(arm, 4, seed)
    tool = (forward(arm, positions) - arm.base) * arm.metres
    robot = load(urdf(arm))
    size = (arm.a1 + arm.a2 + arm.a3 + arm.a4 * 2 + arm.a5) * arm.metres
    for row, expected in zip(positions, tool, strict=True):
        robot.update_cfg(row * np.where(np.array(JOINTS) == "q5", arm.metres, 1.0))
        found = robot.get_transform("tool", "base_link")[:3, 3]
        # trimesh takes a move of up to 1e-8 for none
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 + 1e-9 * min(1.0, size))


@pytest.mark.slow
@settings(max_examples=40)
@given(arms(), st.integers(0, 2**32 - 1))
def test_forward_is_the_printed_formula(arm: PaperArm, seed: int) -> None:
    positions = random_positions(arm, 10, seed)
    q1, q2, q3, _, q5, _ = positions.T
    a6 = arm.a4 + arm.a5 + q5
    r = np.sin(q2) * arm.a3 + np.sin(q2 + q3) * a6
    z = arm.a1 + arm.a2 + np.cos(q2) * arm.a3 + np.cos(q2 + q3) * a6
    printed = np.stack([np.sin(q1) * r, -np.cos(q1) * r, z], axis=1)
    np.testing.assert_allclose(forward(arm, positions) - arm.base, printed, rtol=0, atol=1e-11)


@pytest.mark.slow
@settings(max_examples=20)
@given(arms(), st.integers(0, 2**32 - 1))
def test_links_keep_their_lengths_and_their_plane(arm: PaperArm, seed: int) -> None:
    positions = random_positions(arm, 10, seed)
    folded = positions.copy()
    folded[:, 4] = -arm.a4 - arm.a5  # a forearm of no length: the tool is at the elbow
    elbow, tool = forward(arm, folded), forward(arm, positions)
    upper, fore = (np.linalg.norm(way, axis=1) for way in (elbow - arm.shoulder, tool - elbow))
    np.testing.assert_allclose(upper, arm.a3, rtol=1e-9)
    np.testing.assert_allclose(fore, arm.a4 + arm.a5 + positions[:, 4], rtol=1e-9)
    points = np.stack([elbow, tool], axis=1)
    sideways = np.stack([np.cos(positions[:, 0]), np.sin(positions[:, 0])], axis=1)
    out_of_plane = np.einsum("nkd,nd->nk", points[:, :, :2] - arm.base[:2], sideways)
    np.testing.assert_allclose(out_of_plane, 0, atol=1e-11)


@pytest.mark.slow
@settings(max_examples=8)
@given(arms())
def test_the_urdf_is_sound(arm: PaperArm) -> None:
    robot = load(urdf(arm))
    assert robot.validate(), robot.errors
    assert tuple(robot.actuated_joint_names) == JOINTS
    for joint in robot.actuated_joints:
        limit = joint.limit
        assert all(map(math.isfinite, (limit.lower, limit.upper, limit.velocity, limit.effort)))
        assert limit.lower < limit.upper
        assert limit.velocity > 0
        assert limit.effort > 0
    for name, link in robot.link_map.items():
        if name == "tool":
            continue
        assert link.inertial.mass > 0
        principal = np.linalg.eigvalsh(link.inertial.inertia)
        assert principal[0] > 0
        # No mass distribution has a principal moment above the sum of the other two.
        assert principal[2] <= (principal[0] + principal[1]) * (1 + 1e-5)


def test_the_urdf_can_be_written_in_the_scenes_unit() -> None:
    arm = paper_arm(ArmSettings(), "cm")
    robot = load(urdf(arm, 1.0))
    positions = np.array([[0.4, 0.3, 1.1, 0.2, 1.5, 0.5]])
    robot.update_cfg(positions[0])
    found = robot.get_transform("tool", "base_link")[:3, 3]
    np.testing.assert_allclose(found, forward(arm, positions)[0] - arm.base, atol=1e-12)


def test_the_tool_can_reach_its_limits_in_every_unit() -> None:
    for unit, metres in METRES.items():
        arm = paper_arm(ArmSettings(a4=3.0), unit)
        slide = load(urdf(arm)).joint_map["q5"].limit
        assert slide.upper == pytest.approx(STROKE * 3.0 * metres, rel=1e-12)


def test_equal_link_lengths_give_equal_text_wherever_the_arm_stands() -> None:
    here = paper_arm(ArmSettings(base=(0.0, 0.0, 0.0)))
    there = paper_arm(ArmSettings(base=(1.0, 2.0, 3.0), elbow="down", q5=1.0))
    assert urdf(here) == urdf(there)
    assert urdf(here) != urdf(paper_arm(ArmSettings(a3=6.5)))


def test_the_shipped_file_is_the_generators() -> None:
    shipped = assets.path("urdf", "abi.urdf").read_text(encoding="utf-8")
    assert shipped == urdf(paper_arm(ArmSettings(), "cm"))


def test_the_text_has_no_rounding_noise() -> None:
    text = urdf(paper_arm(ArmSettings(), "m"))
    for number in re.findall(r"[\d.]+e-\d+", text):
        assert float(number) > 1e-9


@pytest.mark.slow
@settings(max_examples=24)
@given(arms())
def test_every_solid_has_a_size(arm: PaperArm) -> None:
    for solid in solids(arm):
        assert min(solid.size) > 0
        assert all(map(math.isfinite, (*solid.size, *solid.xyz, *solid.rpy)))
        assert solid.material in arm_links.COLOURS


@pytest.mark.slow
@settings(max_examples=24)
@given(arms())
def test_solids_of_different_colours_never_share_a_face(arm: PaperArm) -> None:
    """Faces in one plane flicker: caps of cylinders along one axis must lie apart or inside."""
    links = arm_links.links(arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)
    for link in links.values():
        upright = [s for s in link if s.shape == "cylinder" and not any(s.rpy)]
        for a, b in itertools.combinations(upright, 2):
            if a.material == b.material or a.xyz[:2] != b.xyz[:2]:
                continue
            # A larger cap may sit on a smaller one end to end: it hides it.
            for side in (-1, 1):
                top_a, top_b = (s.xyz[2] + side * s.size[2] / 2 for s in (a, b))
                assert abs(top_a - top_b) > 1e-3 * min(a.size[2], b.size[2])


@pytest.mark.slow
@settings(max_examples=24)
@given(arms())
def test_the_base_stands_on_the_floor_and_the_fingers_end_at_the_tool(arm: PaperArm) -> None:
    links = arm_links.links(arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)
    lows = [solid.xyz[2] - solid.size[2] / 2 for solid in links["base_link"]]
    assert min(lows) == pytest.approx(0, abs=1e-12)
    highs = [solid.xyz[2] + solid.size[2] / 2 for solid in links["gripper"]]
    *_, tool = arm_links.joint_heights(arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)
    assert max(highs) == pytest.approx(tool, rel=1e-9)


@pytest.mark.slow
@settings(max_examples=24)
@given(arms())
def test_the_rod_never_leaves_its_sleeve(arm: PaperArm) -> None:
    links = arm_links.links(arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)
    rod = links["rod"][0]
    tail = rod.xyz[2] - rod.size[2] / 2
    assert tail + arm.limits[4, 1] < 0
    assert tail + arm.a4 > 0
    assert rod.size[0] < min(solid.size[0] for solid in links["forearm"])


@pytest.mark.slow
@settings(max_examples=40)
@given(arms())
def test_the_upper_arm_is_the_hull_of_its_ends(arm: PaperArm) -> None:
    link = arm_links.links(arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)["upper_arm"]
    shoulder, elbow = arm_links.radii(arm.a1, arm.a2, arm.a3, arm.a4, arm.a5)
    lower, upper = 0.88 * shoulder, 0.9 * elbow
    plates = [s for s in link if s.shape == "box" and s.material == "shell"]
    angles = np.linspace(0, 2 * np.pi, 720)
    normals = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    support = np.maximum(lower, normals[:, 1] * arm.a3 + upper)
    corners = np.concatenate([_corners(plate) for plate in plates])
    reached = (corners @ normals.T).max(axis=0)
    assert np.all(reached <= support + 1e-9 * arm.a3)
    # The plates reach the tangents: there is a direction on each side where they are the hull.
    assert np.min((support - reached)[normals[:, 0] > 0]) < 1e-3 * arm.a3
    assert np.min((support - reached)[normals[:, 0] < 0]) < 1e-3 * arm.a3
    # And they meet in the middle: no gap along the axis.
    for z in np.linspace(0, arm.a3, 30):
        assert any(_inside(plate, z) for plate in plates)


def _corners(plate: LinkSolid) -> FloatArray:
    """The corners of a box that is turned about x only, in (y, z)."""
    cos, sin = math.cos(plate.rpy[0]), math.sin(plate.rpy[0])
    half = np.array(plate.size[1:]) / 2 * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
    return np.asarray(np.array(plate.xyz[1:]) + half @ np.array([[cos, sin], [-sin, cos]]))


def _inside(plate: LinkSolid, z: float) -> bool:
    """Check whether a box that is turned about x only holds (y, z) = (0, z) or ends beside it."""
    cos, sin = math.cos(plate.rpy[0]), math.sin(plate.rpy[0])
    y, z = -plate.xyz[1], z - plate.xyz[2]
    across, along = cos * y + sin * z, -sin * y + cos * z
    slack = 1e-9 * plate.size[2] + 0.2 * plate.size[1]
    return abs(across) <= plate.size[1] / 2 + 1e-9 and abs(along) <= plate.size[2] / 2 + slack


def test_inertia_is_that_of_the_solid_geometry() -> None:
    parts = (
        LinkSolid("box", (0.1, 0.2, 0.3), "shell", (0.0, 0.0, 0.1), (0.3, -0.4, 0.5)),
        LinkSolid("cylinder", (0.05, 0.05, 0.4), "joint", (1.0, 0.5, -0.2), (1.1, 0.2, -0.7)),
        LinkSolid("box", (1.0, 1.0, 1.0), "steel", body=False),
    )
    meshes: list[trimesh.Trimesh] = []
    for part in parts[:2]:
        mesh = (
            trimesh.creation.box(part.size)
            if part.shape == "box"
            else trimesh.creation.cylinder(part.size[0], part.size[2], sections=2000)
        )
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_euler("xyz", part.rpy).as_matrix()
        turn[:3, 3] = part.xyz
        meshes.append(mesh.apply_transform(turn))
    whole = trimesh.util.concatenate(meshes)
    assert isinstance(whole, trimesh.Trimesh)
    mass, centre, tensor = inertia(parts)
    assert mass == pytest.approx(DENSITY * whole.volume, rel=1e-5)
    np.testing.assert_allclose(centre, whole.center_mass, atol=1e-5)
    np.testing.assert_allclose(tensor, DENSITY * whole.moment_inertia, rtol=0, atol=1e-4)


def test_an_arm_that_no_urdf_holds_is_refused_by_its_own_lengths() -> None:
    large = PaperArm.of((0.0, 0.0, 0.0), (1.0, 2.0, 20_000.0, 3.0, 2.5), "cm")
    assert np.isfinite(large.tool(np.zeros((1, 6)))).all()
    with pytest.raises(AbiError, match=r"reaches 200\.1 m"):
        _ = large.chain
