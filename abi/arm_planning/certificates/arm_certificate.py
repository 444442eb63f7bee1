"""Proof that an arm is clear along its path: the directions that prove it.

:mod:`abi.arm_planning.certificates.paper_arm_certificate` makes it for the paper's arm,
:mod:`abi.arm_planning.certificates.chain_certificate` for a URDF arm; :mod:`abi.verify` checks it.
Where it fails they return a :class:`~abi.curves.clearance.certificate.Refutation`, as of a curve.
"""

from __future__ import annotations

from dataclasses import dataclass

from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr


@dataclass(frozen=True, eq=False, repr=False)
class ArmCertificate(ShortRepr):
    """Directions that prove every capsule clear of its surroundings along a whole curve or motion.

    Of a motion that was planned elsewhere they separate convex bodies instead of capsules.

    Attributes:
        margin: distance that the capsules keep from every obstacle, [unit]; inf without obstacles.
            From floor and column they keep more than 0.
        pieces: first and last parameter for each direction, shape (k, 2).
        poses: parameter, within the piece, of the place x of the tool, shape (k,).
        capsule: number of its capsule, shape (k,).
        obstacle: number of its obstacle, or of what the collision world has besides, shape
            (k,). From a triangle mesh it separates some of the triangles.
        directions: unit vectors towards the capsule, shape (k, 3), world.
        positions: joint positions that the parameters count, shape (m, n), [rad] or [unit], with
            straight motion between them; None if the parameters are the curve's.
        closer: whether a direction separates the hull in the capsule, not the capsule, (k,); None
            where there are no hulls.
    """

    margin: float
    pieces: FloatArray
    poses: FloatArray
    capsule: IntArray
    obstacle: IntArray
    directions: FloatArray
    positions: FloatArray | None = None
    closer: BoolArray | None = None
