"""The capsules hold the arm as it is drawn, wherever its joints are."""

from __future__ import annotations

import io
from collections import defaultdict

import numpy as np
import pytest
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arm_planning.paper_arm_model import paper_arm
from abi.arrays import FloatArray
from abi.robot.paper_arm.link_capsules import FOREARM, SLIDE, UPPER_ARM
from abi.robot.paper_arm.paper_arm import JOINTS, PaperArm, forward, urdf
from abi.scene.arm_settings import ArmSettings

LENGTH = st.floats(-0.7, 0.7).map(lambda power: 3 * 10.0**power)


@st.composite
def arms(draw: st.DrawFn) -> PaperArm:
    lengths = {name: draw(LENGTH) for name in ("a1", "a2", "a3", "a4", "a5")}
    return paper_arm(ArmSettings(base=(1.0, -2.0, 0.5), **lengths))


def from_segment(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Distances (n,) of points from the segment a..b."""
    way = b - a
    square = float(way @ way)
    share = np.clip((points - a) @ way / square, 0, 1) if square > 0 else np.zeros(len(points))
    return np.asarray(np.linalg.norm(points - a - share[:, None] * way, axis=1))


@pytest.mark.slow
@settings(max_examples=8)
@given(arms(), st.integers(0, 2**32 - 1))
def test_every_solid_drawn_is_in_a_capsule_of_its_link(arm: PaperArm, seed: int) -> None:
    low, high = arm.limits.T
    positions = low + np.random.default_rng(seed).random(6) * (high - low)
    # one metre of the text is one unit of the scene
    robot = yourdfpy.URDF.load(io.BytesIO(urdf(arm, 1.0).encode()), load_meshes=False)
    robot.update_cfg(dict(zip(JOINTS, positions, strict=True)))
    ends = arm.place(positions[None])[0] - arm.base
    segments = defaultdict(list)
    for capsule, (a, b) in zip(arm.capsules, ends, strict=True):
        segments[capsule.link].append((a, b, capsule.radius))
    (a, _, radius), (_, b, _) = segments["upper_arm"]  # two halves of one capsule
    segments["upper_arm"] = [(a, b, radius)]

    graph, drawn = robot.scene.graph, 0
    for node in graph.nodes_geometry:
        link = graph.transforms.parents[node]
        matrix, geometry = graph.get(node, robot.base_link)
        vertices = robot.scene.geometry[geometry].vertices @ matrix[:3, :3].T + matrix[:3, 3]
        outside = min(
            float((from_segment(vertices, a, b) - radius).max()) for a, b, radius in segments[link]
        )
        assert outside <= 1e-9 * (arm.a3 + arm.a4 + arm.a5), link
        drawn += 1
    assert drawn > 30


@settings(max_examples=50)
@given(arms(), st.integers(0, 2**32 - 1))
def test_capsules_lie_along_the_links(arm: PaperArm, seed: int) -> None:
    low, high = arm.limits.T
    positions = low + np.random.default_rng(seed).random((3, 6)) * (high - low)
    ends, tools = arm.place(positions), forward(arm, positions)
    for c, capsule in enumerate(arm.capsules):
        lengths = np.linalg.norm(ends[:, c, 1] - ends[:, c, 0], axis=1)
        np.testing.assert_allclose(lengths, capsule.high - capsule.low, rtol=0, atol=1e-9)
        if capsule.grips:  # the fingers end at the tool
            np.testing.assert_array_less(
                np.linalg.norm(ends[:, c, 1] - tools, axis=1), 1.01 * capsule.radius
            )


@settings(max_examples=50)
@given(arms(), st.floats(0, 1))
def test_at_the_limit_of_q3_the_forearms_end_keeps_off_the_upper_arm(
    arm: PaperArm, share: float
) -> None:
    extension = share * arm.limits[4, 1]
    positions = np.array([[0.3, 0.4, arm.limits[2, 1], 0.0, extension, 0.0]])
    ends = arm.place(positions)[0]
    upper = [c for c, capsule in enumerate(arm.capsules) if capsule.body == UPPER_ARM]
    a, b = ends[upper[0], 0], ends[upper[-1], 1]
    radius = arm.capsules[upper[0]].radius
    for c, capsule in enumerate(arm.capsules):
        past = capsule.low >= arm.a4
        if capsule.body in (FOREARM, SLIDE) and past and capsule.low > radius + capsule.radius:
            dense = ends[c, 0] + np.linspace(0, 1, 50)[:, None] * (ends[c, 1] - ends[c, 0])
            assert from_segment(dense, a, b).min() >= radius + capsule.radius - 1e-9
