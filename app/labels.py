"""The page's names of a scene's fields."""

from __future__ import annotations

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
"""By the name in a file, but for obstacles and the coordinates of points."""

_OBSTACLE = re.compile(r"obstacles\[(\d+)\]\.?")
_COORDINATE = re.compile(r"\[[012]\]$")


def with_labels(message: str, error: AbiError) -> str:
    """``message`` with the page's name of the field that ``error`` names by its name in a file."""
    if not isinstance(error, SceneError):
        return message
    field = _COORDINATE.sub("", error.field)
    label = LABELS.get(error.field, LABELS.get(field, error.field))
    if found := _OBSTACLE.match(error.field):
        part = field[found.end() :]
        label = f"obstacle {int(found[1]) + 1}" + (f": {LABELS.get(part, part)}" if part else "")
    return message.replace(error.field, label, 1)
