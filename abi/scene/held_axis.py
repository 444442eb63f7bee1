"""The direction of an arm's tool, held within a tolerance for a part of a motion."""

import math
from typing import Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_serializer, model_validator

from abi.errors import SceneError
from abi.obstacles.pose import Number, Vec3
from abi.scene.section import Settings

_LEAST = 1e-100
"""Least entry of a direction, whose square has to be a number."""
Share = Annotated[Number, Field(ge=0, le=1)]


class HeldAxis(Settings):
    """A direction that the tip's z axis keeps within ``tolerance`` [rad] for a part of a motion.

    In a file the part's begin and end are ``from`` and ``to``, shares of the motion's time: 0 is
    its first moment, 1 its last. Outside of it the tip may point anywhere. The motion is sought in
    the space of the joints.
    """

    direction: Vec3
    tolerance: Annotated[Number, Field(ge=0.001, le=math.pi / 2)] = 0.1
    begin: Annotated[Share, Field(alias="from")] = 0.0
    end: Annotated[Share, Field(alias="to")] = 1.0

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if not is_direction(self.direction):
            raise ValueError("a direction that is not zero")
        if self.begin >= self.end:
            raise ValueError(f"from below to, and {self.begin:g} is not below {self.end:g}")
        return self

    @model_serializer
    def _given(self) -> dict[str, Any]:
        """The given fields as plain data, with the names of a file."""
        return {
            "direction": self.direction,
            "tolerance": self.tolerance,
            "from": self.begin,
            "to": self.end,
        }


_HELD, _EXACT = "a held direction", "a direction"
AXIS_TAGS = {_HELD: HeldAxis, _EXACT: None}
"""Names that pydantic inserts into the location of an error in an axis, by what was checked."""


def _tag(value: object) -> str:
    """Tag that decides whether a value is parsed as a direction alone."""
    return _HELD if isinstance(value, dict | HeldAxis) else _EXACT


Axis = Annotated[
    Annotated[Vec3, Tag(_EXACT)] | Annotated[HeldAxis, Tag(_HELD)], Discriminator(_tag)
]
"""A direction held exactly and throughout, or within a tolerance and for a part of the motion."""


def check_axis(field: str, axis: Vec3 | HeldAxis | None, model: str, search: str) -> None:
    """Raise a SceneError if an axis is invalid, or no arm or search can hold it.

    Args:
        field: of the scene that has it.
        axis: the direction, or None.
        model: of the arm.
        search: where its motion is sought.
    """
    if axis is None:
        return
    if model != "urdf":
        raise SceneError(field, plain_axis(axis), "none for the paper's arm, only a URDF's is held")
    if isinstance(axis, HeldAxis):
        if search == "mesh":
            expected = "auto or joints where axis has a tolerance: the mesh holds it exactly"
            raise SceneError("arm.search", search, expected)
    elif not is_direction(axis):
        raise SceneError(field, axis, "a direction, or none for any")


def is_direction(axis: Vec3) -> bool:
    """Whether a vector is not zero, also once its numbers are squared."""
    return max(map(abs, axis)) >= _LEAST


def plain_axis(axis: Vec3 | HeldAxis | None) -> Any:
    """An axis as plain data."""
    return axis.model_dump(mode="json") if isinstance(axis, HeldAxis) else axis
