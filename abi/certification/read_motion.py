"""Reader of motion files: by the ending of their name, a table of formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath

from abi.certification.motion import Motion
from abi.certification.read_csv import read_csv
from abi.certification.read_message import read_message
from abi.errors import MotionError, SceneError, short
from abi.robot.urdf.robot import Robot
from abi.scene.scene_file import parse_bytes

MOST_BYTES = 20_000_000
"""Largest motion file; YAML and JSON have lower limits."""


def read_motion(name: str, content: bytes, slides: Mapping[str, bool]) -> Motion:
    """Read a motion file.

    Args:
        name: of the file; its ending chooses the format: one of :data:`FORMATS`.
        content: of the file.
        slides: the robot's joints as :func:`own_joints` has them.

    Raises:
        MotionError: the format is unknown, or the file is wrong; names row, joint and unit.
    """
    ending = PurePosixPath(name).suffix.lower()
    if ending not in FORMATS:
        raise MotionError(
            f"{short(name)} is no motion file.", f"Use one that ends in {', '.join(FORMATS)}."
        )
    if len(content) > MOST_BYTES:
        raise MotionError(f"{short(name)} is larger than {MOST_BYTES // 10**6} MB.")
    return FORMATS[ending](name, content, slides)


def load_motion(path: Path, robot: Robot) -> Motion:
    """Read the motion file at ``path``.

    Raises:
        MotionError: it cannot be read, or :func:`read_motion` refuses it.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or "no path").lower()
        raise MotionError(f"{short(str(path))} cannot be read ({reason}).") from None
    return read_motion(path.name, content, own_joints(robot))


def own_joints(robot: Robot) -> dict[str, bool]:
    """The joints of a robot that can move by themselves, from the root on, and which of them slide.

    They are by their names.
    """
    own = (one for one in robot.joints if one.kind != "fixed" and one.mimic is None)
    return {one.name: one.kind == "prismatic" for one in own}


def joint_names(robot: Robot) -> tuple[str, ...]:
    """Names of these joints."""
    return tuple(own_joints(robot))


def _csv(name: str, content: bytes, slides: Mapping[str, bool]) -> Motion:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise MotionError(f"{short(name)} is no text in UTF-8.") from None
    return read_csv(text, slides.keys())


def _mapping(name: str, content: bytes, slides: Mapping[str, bool]) -> Motion:
    # what ``ros2 topic echo`` prints ends with a line that begins another document
    if not name.lower().endswith(".json"):
        content = content.strip().removesuffix(b"---")
    try:
        data = parse_bytes(content, name)
    except SceneError as error:
        raise MotionError(f"{short(name)} cannot be read; expected {error.expected}.") from None
    return read_message(data, [joint for joint, is_slide in slides.items() if is_slide])


FORMATS: dict[str, Callable[[str, bytes, Mapping[str, bool]], Motion]] = {
    ".csv": _csv,
    ".yaml": _mapping,
    ".yml": _mapping,
    ".json": _mapping,
}
"""Reader of each ending."""
