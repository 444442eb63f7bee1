"""
The arm and its joints
======================

Read the joints of the arm's motion, find the fastest moment, try other motions and the other elbow.
"""

from __future__ import annotations

import numpy as np

import abi

scene = abi.load_scene("paper")
plan = abi.plan(scene)
motion, profile = plan.motion, plan.profile
assert motion is not None and profile is not None

names = plan.to_dict()["arm"]["joints"]
print("time [s]  " + "  ".join(f"{name:>7}" for name in names) + "   [rad], q5 [cm]")
for row in np.linspace(0, len(motion.time) - 1, 6).astype(int):
    print(f"{motion.time[row]:8.2f}  " + "  ".join(f"{q:7.3f}" for q in motion.positions[row]))

# %%
# The tool follows the curve: inverse and then forward kinematics lead back to its points.
off = np.abs(motion.tool - motion.target).max()
speed = np.linalg.norm(motion.tool_velocity, axis=1)
fastest = int(speed.argmax())
print(f"tool off the curve by {off:.1e} cm at most")
print(f"fastest at {motion.time[fastest]:.2f} s with {speed[fastest]:.2f} cm/s, asked: 4")

# %%
# The paper's three phases consider only the tool. Other motions keep the joints' limits, too, and
# the gentler they are, the less a liquid in a cup tilts.
for law in ("three_phase", "slowed", "jerk_limited", "time_optimal"):
    other = abi.plan(scene.replace(motion={"law": law, "joint_acceleration": 2.0}))
    assert other.profile is not None and other.liquid_tilt is not None
    tilt = np.degrees(other.liquid_tilt)
    print(f"{law:12}  {other.profile.duration:5.2f} s, a liquid tilts by {tilt:.2f}°")

# %%
# The whole arm is checked, too: every link, in capsules, is proven clear between samples or not.
planner = abi.Planner()
for elbow in ("up", "down"):
    plan = planner(scene.replace(arm={"elbow": elbow}))
    arm = plan.arm_clearance
    assert arm is not None
    print(f"elbow {elbow:4}  proven clear: {arm.certified}", end="")
    print(f", {arm.distance:.3f} cm from obstacle {arm.obstacle + 1}: the {arm.link}")
    for contact in arm.contacts[:1]:
        print(f"  {contact.link} touches {contact.obstacle} by {contact.depth:.2f} cm", end="")
        print(f" at {contact.time:.2f} s")
