"""Motions under the joints' limits, and the liquid that they tilt."""

from __future__ import annotations

import json
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arm_planning.branch.paper_arm_joint_path import PaperArmJointPath
from abi.arm_planning.motion.liquid import tilts
from abi.arm_planning.motion.tool_motion import tool_motion
from abi.arm_planning.motion_law import LAWS, second_derivatives
from abi.curves.curve import ArcLength, Curve
from abi.curves.three_phase_profile import ThreePhaseProfile
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.robot.kinematics.inverse_dynamics import GRAVITY
from abi.robot.paper_arm.paper_arm import JOINT_SPEED, PaperArm
from abi.scene.scene import load_scene
from abi.scene.settings import Law, MotionSettings
from abi.verify import verify_paper_arm
from abi.verify.verify import verify

PLANNER = Planner()
LIMITED = [name for name, one in LAWS.items() if one.keeps_limits]


def planned(scene: str, law: str, **motion: float) -> Plan:
    return PLANNER(load_scene(scene).replace(motion={"law": law, **motion}))


def followed(plan: Plan) -> tuple[Curve, ArcLength]:
    assert plan.followed_curve is not None
    arc = plan.followed_arc
    assert arc is not None
    return plan.followed_curve.curve, arc


def peaks(plan: Plan, samples: int = 3001) -> tuple[float, float]:
    """Largest joint speed and acceleration of q1 to q3, by differences."""
    assert plan.profile is not None
    assert isinstance(plan.arm, PaperArm)
    times = np.linspace(0, plan.profile.duration, samples)
    path = PaperArmJointPath(*followed(plan), plan.arm, plan.scene.arm)
    positions = path.at(plan.profile(times), times)
    speed = np.abs(np.diff(positions, axis=0)).max() / times[1]
    return float(speed), float(np.abs(second_derivatives(positions, times[1])).max())


def test_every_law_of_the_settings_is_in_the_table() -> None:
    assert set(get_args(Law)) == set(LAWS), "a law is missing in LAWS, or in Law of settings.py"
    for law in LAWS.values():
        assert law.uses <= set(MotionSettings.model_fields), law.name


@pytest.mark.slow
@pytest.mark.parametrize("limit", [8.0, 1.5])
@pytest.mark.parametrize("law", LIMITED)
@pytest.mark.parametrize("scene", ["paper", "two-boxes", "wall-with-window"])
def test_joint_limits_hold(scene: str, law: str, limit: float) -> None:
    plan = planned(scene, law, joint_acceleration=limit)
    speed, acceleration = peaks(plan)
    _, arc = followed(plan)

    assert plan.profile is not None
    assert speed <= JOINT_SPEED * (1 + 1e-6)
    assert acceleration <= limit * (1 + 1e-6)
    assert float(plan.profile(plan.profile.duration)) == pytest.approx(arc.length, rel=1e-9)
    assert plan.error is None
    if law == "time_optimal":
        # the fastest motion meets a limit
        assert max(speed / JOINT_SPEED, acceleration / limit) > 0.9


@pytest.mark.parametrize("force", [0.05, 0.5, 2.0])
@pytest.mark.parametrize("law", LIMITED)
def test_joint_limits_hold_while_q5_slides(law: str, force: float) -> None:
    motion = {"law": law, "joint_acceleration": 2.0}
    plan = PLANNER(load_scene("paper").replace(motion=motion, arm={"forces": (0.5, force, 0.6)}))
    speed, acceleration = peaks(plan)
    assert speed <= JOINT_SPEED * (1 + 1e-6)
    assert acceleration <= 2.0 * (1 + 1e-6)


@pytest.mark.parametrize("scene", ["paper", "two-boxes"])
def test_gentler_motions_take_longer(scene: str) -> None:
    three, slowed, gentle, fast = (
        planned(scene, law, joint_acceleration=3.0)
        for law in ("three_phase", "slowed", "jerk_limited", "time_optimal")
    )
    durations = []
    for plan in (fast, three, slowed, gentle):
        assert plan.profile is not None
        durations.append(plan.profile.duration)
    if scene == "paper":  # which is within the limits as it is
        assert durations[1] == durations[2]
        assert durations == sorted(durations)
    assert durations[1] <= durations[2] < durations[3]
    assert durations[0] < durations[2]
    assert isinstance(slowed.profile, ThreePhaseProfile)
    assert slowed.profile.theorem_residual == pytest.approx(0, abs=1e-12)


def test_three_phases_know_nothing_of_joints() -> None:
    first = planned("two-boxes", "three_phase")
    second = planned("two-boxes", "three_phase", joint_acceleration=0.1, jerk=0.1)

    assert first.profile is not None
    assert second.profile is not None
    assert first.profile.duration == second.profile.duration


@settings(max_examples=30)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-5, 5))
def test_the_level_is_across_what_the_cup_feels(x: float, y: float, z: float) -> None:
    (tilt,) = tilts(np.array([[x, y, z]]), "m")
    felt = np.array([x, y, z + GRAVITY])
    assert np.cos(tilt) == pytest.approx(felt[2] / np.linalg.norm(felt))
    assert tilts(np.array([[x, y, z]]) * 100, "cm") == pytest.approx([tilt])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scene", ["paper", "thin-plate", "two-boxes"])
def test_no_moment_tilts_a_liquid_more_than_the_largest_tilt(scene: str, law: str) -> None:
    plan = planned(scene, law)
    assert plan.profile is not None
    assert plan.liquid_tilt is not None
    times = np.linspace(0, plan.profile.duration, 79_999)
    # the bend at the corner of thin-plate lasts a few thousandths of the motion
    dense = tilts(tool_motion(*followed(plan), plan.profile, times, 2), "cm")

    assert dense.max() <= plan.liquid_tilt * (1 + 1e-3)
    assert plan.liquid_tilt <= dense.max() * 1.02
    assert plan.to_dict()["timing"]["liquid_tilt"] == plan.liquid_tilt


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_the_arms_proof_holds_for_every_motion(law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    slides = {"forces": (0.5, 0.05, 0.6), "base": (3.0, -3.5, 0.0)}
    plan = PLANNER(load_scene("paper").replace(motion={"law": law}, arm=slides))
    assert plan.arm_clearance is not None
    data = json.loads(json.dumps(plan.to_dict()))

    assert is_proven(data) == plan.arm_clearance.certified
    phases = isinstance(plan.profile, ThreePhaseProfile)
    assert (data["timing"]["t1"] is None) != phases
    if law != "three_phase":  # a law that the verifier has not heard of
        monkeypatch.setattr(verify_paper_arm, "_PHASES", ())
        monkeypatch.setattr(verify_paper_arm, "_WITHOUT_PHASES", ())
        assert is_proven(data) == plan.arm_clearance.certified


def is_proven(data: dict[str, Any]) -> bool:
    (verdict,) = (one for one in verify(data) if one.curve == "arm")
    return verdict.proven
