"""Names of a scene's fields on the page, and lengths as it writes them."""

from __future__ import annotations

import math
import re

from abi.errors import AbiError, SceneError

LABELS = {
    "mesh.pitch": "pitch",
    "mesh.seed": "seed",
    "spline.degree": "degree",
    "spline.clearance": "clearance",
    "motion.speed": "V",
    "motion.acceleration": "a1",
    "motion.deceleration": "a3",
    "arm.base": "base",
    "arm.q5": "q5 at start",
    **{f"arm.a{k}": f"link length a{k}" for k in range(1, 6)},
    **{f"arm.forces[{k}]": f"Q{k + 4}" for k in range(3)},
    **{f"arm.masses[{k}]": f"m{k + 4}" for k in range(3)},
    **{f"arm.radii[{k}]": f"i{k + 4}" for k in range(3)},
}
"""By the name in a file; of an obstacle's fields and a point's coordinates see below."""

_OBSTACLE = re.compile(r"obstacles\[(\d+)\]\.?")


def as_labelled(error: AbiError, message: str) -> str:
    """The message with what a field is called on the page in the place of its name in a file."""
    if not isinstance(error, SceneError):
        return message
    field = error.field.removesuffix("[0]").removesuffix("[1]").removesuffix("[2]")
    label = LABELS.get(error.field, LABELS.get(field, error.field))
    if found := _OBSTACLE.match(error.field):
        part = LABELS.get(field[found.end() :], field[found.end() :])
        label = f"obstacle {int(found[1]) + 1}" + (f": {part}" if part else "")
    return message.replace(error.field, label, 1)


def at_least(distance: float) -> str:
    """A distance in three decimals, rounded down: it is a bound, and less than it is also one."""
    return f"{math.floor(1000 * distance + 1e-6) / 1000:.3f}"
