"""Common interface of the paper's arm and of URDF arms, for everything except the planner."""

from __future__ import annotations

from typing import Any, Protocol

from abi.arrays import FloatArray
from abi.obstacles.pose import Quaternion
from abi.robot.kinematics.chain import Chain


class AnyArm(Protocol):
    """An arm: its chain of joints, and the capsules around its links."""

    @property
    def chain(self) -> Chain:
        """The chain with all its links as it stands in the scene, in [m]."""

    @property
    def scales(self) -> FloatArray:
        """Factors from positions in [rad] or [m] to [rad] or [unit], (n,)."""

    @property
    def root(self) -> str:
        """Name of the link that stands at its base."""

    @property
    def tip(self) -> str:
        """Name of the link whose origin is the tool."""

    @property
    def base(self) -> FloatArray:
        """Position of its base, (3,), [unit], world."""

    @property
    def wxyz(self) -> Quaternion:
        """Orientation of the base, as a quaternion."""

    @property
    def metres(self) -> float:
        """One [unit] in metres."""

    @property
    def reach(self) -> float:
        """Length of the arm stretched out, [unit]."""

    @property
    def limits(self) -> FloatArray:
        """Lowest and highest position of each joint, (n, 2), [rad] or [unit]."""

    @property
    def capsule_links(self) -> tuple[str, ...]:
        """Name of the link of each capsule, those that stand still first."""

    @property
    def radii(self) -> FloatArray:
        """Radius of each capsule, (c,), [unit]."""

    @property
    def has_elbow(self) -> bool:
        """Whether its branches are the two sides of its elbow."""

    @property
    def has_exact_bodies(self) -> bool:
        """Whether a link touches what its body overlaps, and not only may."""

    @property
    def has_nominal_rates(self) -> bool:
        """Whether the limits of its joints' rates are assumed, and so none is passed."""

    def rate_limits(self, acceleration: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Largest speeds, accelerations and torques of its joints, (n,) each, inf where none is.

        They are in [rad/s] or [unit/s], [rad/s²] or [unit/s²], and [N·m] or [N].

        Args:
            acceleration: the largest, [rad/s²], of sliding joints [m/s²].
        """

    def torques(
        self, positions: FloatArray, speeds: FloatArray, accelerations: FloatArray
    ) -> FloatArray | None:
        """Torques (k, n) that a motion takes, [N·m] or [N]; None where no masses are known."""

    def tool(self, positions: FloatArray) -> FloatArray:
        """Positions (k, 3) of the tool at joint positions (k, n), [unit], world."""

    def place(self, positions: FloatArray) -> FloatArray:
        """Ends of the capsules' segments at joint positions (k, n), (k, c, 2, 3), [unit], world."""

    def description(self) -> str:
        """URDF of the arm, in metres, standing at the origin of its root link."""

    def files(self) -> dict[str, bytes]:
        """Its URDF and the meshes that this names, by their paths."""

    def proof_data(self) -> dict[str, Any]:
        """Subject of a certificate as plain data: the capsules, and pairs of them."""
