"""
Certify a motion
================

Prove that another planner's motion is clear, and find the thin plate that a thousand samples miss.
"""

from __future__ import annotations

import json

import numpy as np

import abi
from abi.verify.verify import verify

joints = [
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
]
times = [0.0, 2.0]
positions = np.array([[2.0, -1.6, 1.2, -1.2, -1.57, 0.0], [0.8, -1.6, 1.2, -1.2, -1.57, 0.0]])

# The robot is a URDF file, a zip with its meshes, or one that comes along.
alone = abi.certify("ur5e", joints, times, positions)
print(alone.sentence)
print(f"Assumed: {alone.assumed}.")

# %%
# With an obstacle the least distance is proven, too. The proof is part of the verdict, and the
# verifier checks it in exact rational numbers.
box = {"shape": "box", "size": [0.2, 0.2, 0.2], "position": [-0.7, -0.2, 0.3]}
verdict = abi.certify(None, joints, times, positions, alone.scene.replace(obstacles=[box]))
print(verdict.sentence)
(checked,) = verify(json.loads(json.dumps(verdict.to_dict())))
print(checked)

# %%
# A plate a tenth of a millimetre thin stands in the way. A thousand samples of the motion are 1.2
# milliradians apart, and between two of them the tool moves by more than the plate is thick.
chain, motion = alone.problem.chain, alone.problem.motion
x, y, z = chain.poses(motion.positions_at(np.array([0.5003])))[0, -1, :, 3].tolist()
plate = {"shape": "box", "size": [0.0001, 0.3, 0.3], "position": [x, y, z]}
scene = alone.scene.replace(obstacles=[plate])
print(abi.certify(None, joints, times, positions, scene).sentence)
