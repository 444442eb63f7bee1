"""Certificate of an arm's clearance as plain data, for :mod:`abi.verify.verify_paper_arm`."""

from __future__ import annotations

import math
from typing import Any

from abi.arm_planning.motion.arm_clearance import ArmClearance, named
from abi.arm_planning.world.collision_world import OWN
from abi.robot.any_arm import AnyArm


def arm_certificate(arm: AnyArm, clearance: ArmClearance) -> dict[str, Any] | None:
    """Capsules and directions, allowed contacts, and the joints' path if that is what is proven."""
    proof = clearance.certificate
    if proof is None:
        return None
    columns = (
        *(proof.pieces.tolist(), proof.poses.tolist(), proof.capsule.tolist()),
        *(proof.obstacle.tolist(), proof.directions.tolist()),
        [False] * len(proof.poses) if proof.closer is None else proof.closer.tolist(),
    )
    data: dict[str, Any] = {
        "margin": float(proof.margin) if math.isfinite(proof.margin) else None,
        "planes": [
            {"t0": t0, "t1": t1, "at": at, "capsule": capsule}
            | ({"hull": True} if closer else {})
            | {"obstacle": named(obstacle, arm), "direction": way}
            | ({"other": OWN - obstacle} if obstacle <= OWN else {})
            for (t0, t1), at, capsule, obstacle, way, closer in zip(*columns, strict=True)
        ],
    }
    if proof.positions is not None:
        data["positions"] = proof.positions.tolist()
        data["allowed"] = [contact._asdict() for contact in clearance.allowed]
    return data | arm.proof_data()
