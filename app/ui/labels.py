"""The page's names of a scene's fields."""

from __future__ import annotations

import math
import re
from typing import Any

from abi.errors import AbiError, SceneError
from abi.scene.scene import Scene
from app.ui.numbers import format_setting

_DRIVES = (("wrist", "torque"), ("slide", "force"), ("gripper", "torque"))

LABELS = {
    "mesh.pitch": "node spacing",
    "mesh.seed": "random seed",
    "spline.degree": "degree",
    "spline.clearance": "clearance",
    "motion.speed": "cruise speed",
    "motion.acceleration": "acceleration",
    "motion.deceleration": "braking",
    "arm.base": "base",
    "arm.elbow": "elbow",
    "arm.clearance": "link clearance",
    "arm.q5": "slide's extension at start",
    "arm.a1": "pedestal's height",
    "arm.a2": "column's height",
    "arm.a3": "upper arm's length",
    "arm.a4": "forearm's length",
    "arm.a5": "slide's length",
    **{f"arm.forces[{k}]": f"{name}'s {what}" for k, (name, what) in enumerate(_DRIVES)},
    **{f"arm.masses[{k}]": f"{name}'s mass" for k, (name, _) in enumerate(_DRIVES)},
    **{f"arm.radii[{k}]": f"{name}'s radius of gyration" for k, (name, _) in enumerate(_DRIVES)},
}
"""Labels by the name in a file, except for obstacles and coordinates of points."""

_LONGEST = 60
"""Most characters of a wrong value that are shown."""
_OBSTACLE = re.compile(r"obstacles\[(\d+)\]\.?")
_COORDINATE = re.compile(r"\[[012]\]$")


def sentence(error: AbiError) -> str:
    """Message of an error with the page's label for the field, and what would work."""
    if not isinstance(error, SceneError):
        return error.message
    name, expected = label(error.field), error.expected
    if error.field.endswith("file"):
        return f"{error.value} cannot be used: it should be {expected}."
    if expected[:2] in ("x ", "y ", "z "):  # of a point
        return f"The {name}'s {expected[0]} must be {expected[2:]}."
    return f"The {name} must be {expected}; it is {_shown(error.value)}."


def kept(error: AbiError, scene: Scene) -> str:
    """Sentence on the value that ``scene`` keeps for a refused field; empty if it has none."""
    value: Any = scene
    for name in re.findall(r"\w+", getattr(error, "field", "")):
        try:
            value = value[int(name)] if name.isdigit() else getattr(value, name)
        except (AttributeError, IndexError, TypeError):
            return ""
    numbers = value if isinstance(value, tuple) else (value,)
    if not all(isinstance(number, int | float) for number in numbers) or not numbers:
        return ""
    texts = ", ".join(format_setting(float(number)) for number in numbers)
    of_vector = f"({texts})" if len(numbers) > 1 else texts
    return f"Still using {of_vector}; other changes take effect."


def label(field: str) -> str:
    """The page's label of a field, from its name in a file."""
    whole = _COORDINATE.sub("", field)
    name = LABELS.get(field, LABELS.get(whole, field))
    if found := _OBSTACLE.match(field):
        part = whole[found.end() :]
        name = f"{LABELS.get(part, part)} of obstacle {int(found[1]) + 1}".removeprefix(" of ")
    return name


def _shown(value: object) -> str:
    if isinstance(value, float) and math.isfinite(value):
        return format_setting(value)
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
