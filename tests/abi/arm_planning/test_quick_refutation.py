"""Tests of a few poses that spare a motion, against the proof of the whole motion."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from abi.arm_planning.models import model_of
from abi.arm_planning.motion.arm_clearance import is_clear
from abi.arm_planning.motion_law import motion_law
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from abi.scene.settings import SAMPLES

LAWS = ("three_phase", "slowed", "time_optimal")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kitchen-ur5e", "arm-in-the-way", "wrong-elbow"])
def test_what_a_few_poses_refute_is_never_proven_clear(name: str) -> None:
    random = np.random.default_rng(0)
    scene = load_scene(name).replace(arm={"avoid": False})
    extent = np.array(scene.workspace.max) - scene.workspace.min
    planner = Planner()
    seen, quick = set(), set()
    for trial in range(12):
        moves = (0.03, 0.6)[trial % 2] * extent
        places = [np.array(one.position) + random.normal(0, moves) for one in scene.obstacles]
        moved = scene.replace(
            obstacles=[
                one.model_copy(update={"position": tuple(place.tolist())})
                for one, place in zip(scene.obstacles, places, strict=True)
            ]
        )
        made = planner(moved)
        if made.motion is None:
            continue
        model, obstacles = model_of(moved.arm, moved.unit), ObstacleSet(moved.obstacles)
        collision_world = model.collision_world(obstacles, moved.workspace.min[2])
        arc = made.bspline_arc if made.followed == "bspline" else made.quadratic_arc
        assert arc is not None
        required = moved.arm.clearance
        along = made.motion.curve, arc, collision_world, required
        none, some = model.is_refuted(*along), False
        for joint_path in model.joint_paths(made.motion.curve, arc, moved.arm, collision_world):
            settings = moved.motion.model_copy(update={"law": LAWS[trial % len(LAWS)]})
            make_profile = partial(motion_law, joint_path, settings)
            motion = joint_path.motion(make_profile(), SAMPLES)
            clear = is_clear(motion, joint_path.clearance(motion, collision_world, required))
            refuted = joint_path.is_refuted(make_profile, collision_world, required)
            assert not (refuted and clear)
            some |= clear
            seen.add((refuted, clear))
        assert not (none and some)
        quick.add(none)
    assert {(True, False), (False, True)} <= seen
    assert quick == ({False, True} if scene.arm.model == "urdf" else {False})
