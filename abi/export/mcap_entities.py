"""Parts of messages that Foxglove draws: poses, colours, and entities of solids and triangles.

Fields: https://docs.foxglove.dev/docs/sdk/schemas/scene-entity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.pose import UNTURNED, Quaternion

Part = dict[str, Any]
"""A part of a message as JSON."""
Colour = tuple[float, ...]
"""Red, green, blue and opacity, 0 to 1."""


def entity(label: str, frame: str, parts: Mapping[str, Sequence[Part]]) -> Part:
    """An entity that is fixed in its frame.

    Args:
        label: its name.
        frame: name of the frame that it is in, and moves with.
        parts: by the kinds of parts that an entity has.
    """
    nothing: dict[str, list[Part]] = {
        kind: [] for kind in ("cubes", "spheres", "cylinders", "lines", "triangles")
    }
    return {
        "timestamp": stamp(0.0),
        "frame_id": frame,
        "id": label,
        "lifetime": stamp(0.0),
        "frame_locked": True,
        **nothing,
        **parts,
    }


def by_kind(parts: Sequence[tuple[str, Part]]) -> dict[str, list[Part]]:
    """Parts grouped by kind."""
    found: dict[str, list[Part]] = {}
    for kind, part in parts:
        found.setdefault(kind, []).append(part)
    return found


def solid(kind: str, size: Sequence[float], pose: Part, colour: Colour) -> tuple[str, Part]:
    """A box, sphere or cylinder, with its kind; ``size`` as in :class:`abi.export.solids.Solid`."""
    part = {"pose": pose, "size": by_letter("xyz", size), "color": by_letter("rgba", colour)}
    if kind == "cylinder":
        return "cylinders", {**part, "bottom_scale": 1.0, "top_scale": 1.0}
    return ("cubes" if kind == "box" else "spheres"), part


def triangles(
    points: FloatArray, faces: IntArray, pose: Part, colours: Sequence[Colour]
) -> tuple[str, Part]:
    """Triangles between points (n, 3), with their kind.

    Args:
        points: of the corners, (n, 3), [m].
        faces: indices of the corners, (m, 3); empty if they follow each other.
        pose: of the points.
        colours: one for all, or one for each point.
    """
    part = {
        "pose": pose,
        "points": [by_letter("xyz", point) for point in points.tolist()],
        "color": by_letter("rgba", colours[0]),
        "colors": [by_letter("rgba", colour) for colour in colours] if len(colours) > 1 else [],
        "indices": faces.ravel().tolist(),
    }
    return "triangles", part


def line(points: FloatArray, colour: Colour) -> tuple[str, Part]:
    """A line through points (n, 3), [m], two pixels wide, with its kind."""
    part = {
        "type": 0,  # a strip
        "pose": pose_of(np.zeros(3), UNTURNED),
        "thickness": 2.0,
        "scale_invariant": True,
        "points": [by_letter("xyz", point) for point in points],
        "color": by_letter("rgba", colour),
        "colors": [],
        "indices": [],
    }
    return "lines", part


def pose_of(position: Sequence[float] | FloatArray, wxyz: Quaternion) -> Part:
    """A pose, [m]."""
    return {"position": by_letter("xyz", position), "orientation": by_letter("wxyz", wxyz)}


def by_letter(letters: str, numbers: Sequence[float] | FloatArray) -> dict[str, float]:
    """A vector (``xyz``), quaternion (``wxyz``) or colour (``rgba``) by its components."""
    return dict(zip(letters, map(float, numbers), strict=True))


def stamp(time: float) -> dict[str, int]:
    """A time [s] in seconds and nanoseconds."""
    seconds, nanoseconds = divmod(round(time * 1e9), 10**9)
    return {"sec": seconds, "nsec": nanoseconds}
