"""Reader of motion files: by the ending of their name, a table of formats."""

from __future__ import annotations

import codecs
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

from abi.certification.motion import Motion
from abi.certification.read_bag import read_bag, state_of_bag
from abi.certification.read_csv import read_csv
from abi.certification.read_message import read_message, told
from abi.certification.yaml_points import parse_yaml_points
from abi.errors import AbiError, SceneError, short
from abi.robot.urdf.robot import Robot
from abi.scene.scene_file import parse_bytes

MOST_BYTES = 20_000_000
"""Largest motion file; YAML has a lower limit but for its points."""


def read_motion(
    name: str, content: bytes, slides: Mapping[str, bool], topic: str | None = None
) -> Motion:
    """Read a motion file.

    Args:
        name: of the file; its ending chooses the format: one of :data:`FORMATS`.
        content: of the file.
        slides: the robot's joints as :func:`own_joints` has them.
        topic: of a trajectory in a bag, see :func:`abi.certification.read_bag.read_bag`.

    Raises:
        AbiError: the format is unknown, or the file is wrong; names row, joint and unit.
    """
    ending = PurePosixPath(name).suffix.lower()
    if ending in BAGS:
        bag = _within(name, content)
        return _from_plain(read_bag(bag, topic), slides, state_of_bag(bag))
    if topic is not None:
        raise AbiError(f"{short(name)} is no bag, so it has no topic {short(topic)}.")
    if ending not in FORMATS:
        raise AbiError(
            f"{short(name)} is no motion file.",
            f"Use one that ends in {', '.join((*FORMATS, *BAGS))}.",
        )
    return FORMATS[ending](name, _within(name, content), slides)


def _within(name: str, content: bytes) -> bytes:
    """The content of a file that is not too large."""
    if len(content) > MOST_BYTES:
        raise AbiError(f"{short(name)} is larger than {MOST_BYTES // 10**6} MB.")
    return content


def load_motion(path: Path, robot: Robot, topic: str | None = None) -> Motion:
    """Read the motion file at ``path``, or the only bag in that folder.

    Raises:
        AbiError: it cannot be read, or :func:`read_motion` refuses it.
    """
    try:
        if path.is_dir():
            path = _bag_in(path)
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or "no path").lower()
        raise AbiError(f"{short(str(path))} cannot be read ({reason}).") from None
    return read_motion(path.name, content, own_joints(robot), topic)


def _bag_in(folder: Path) -> Path:
    """The only bag in a folder, as ROS 2 records it."""
    bags = sorted(one for one in folder.iterdir() if one.suffix in BAGS)
    if len(bags) != 1:
        names = ", ".join(short(one.name) for one in bags[:6]) or "none"
        raise AbiError(f"The folder has not one bag: {names}.", "Name the file.")
    return bags[0]


def own_joints(robot: Robot) -> dict[str, bool]:
    """The joints of a robot that can move by themselves, from the root on, and which of them slide.

    They are by their names.
    """
    own = (one for one in robot.joints if one.kind != "fixed" and one.follows is None)
    return {one.name: one.kind == "prismatic" for one in own}


def joint_names(robot: Robot) -> tuple[str, ...]:
    """Names of these joints."""
    return tuple(own_joints(robot))


def _csv(name: str, content: bytes, slides: Mapping[str, bool]) -> Motion:
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = content.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        raise AbiError(f"{short(name)} is no text in UTF-8 or UTF-16.") from None
    return read_csv(text, slides)


def _mapping(name: str, content: bytes, slides: Mapping[str, bool]) -> Motion:
    said: list[str] = []
    is_yaml = not name.lower().endswith(".json")
    # what ``ros2 topic echo`` prints ends with a line that begins another document
    if is_yaml:
        content = content.strip().removesuffix(b"---")
        lines = itertools.takewhile(lambda line: line.startswith(b"#"), content.splitlines())
        said = [line.lstrip(b"# ").decode(errors="replace") for line in lines]
    try:
        data = (
            parse_yaml_points(content, name) if is_yaml else parse_bytes(content, name, MOST_BYTES)
        )
    except SceneError as error:
        raise AbiError(f"{short(name)} cannot be read; expected {error.expected}.") from None
    return _from_plain(data, slides, said)


def _from_plain(data: object, slides: Mapping[str, bool], said: Sequence[str] = ()) -> Motion:
    """The motion of a message, with a note on what a file says beside it."""
    motion = read_message(data, [joint for joint, is_slide in slides.items() if is_slide])
    text = " ".join(filter(None, said))
    return replace(motion, notes=(*motion.notes, *told(text))) if text else motion


FORMATS: dict[str, Callable[[str, bytes, Mapping[str, bool]], Motion]] = {
    ".csv": _csv,
    ".yaml": _mapping,
    ".yml": _mapping,
    ".json": _mapping,
}
"""Reader of each ending."""
BAGS = (".mcap", ".db3")
"""Endings of bags of ROS 2."""
