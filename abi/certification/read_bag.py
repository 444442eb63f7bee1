"""Reader of trajectories in ROS 2 bags: MCAP files, and the older SQLite ones.

Messages are encoded in CDR. MCAP files bring their definitions along, as SQLite ones do since ROS 2
Iron; in older ones a ``JointTrajectory`` alone can be read.
"""

from __future__ import annotations

import io
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from mcap.records import Schema

from abi.errors import MotionError, SeveralTrajectoriesError, short

KINDS = (
    "trajectory_msgs/msg/JointTrajectory",
    "moveit_msgs/msg/RobotTrajectory",
    "moveit_msgs/msg/DisplayTrajectory",
)
"""Messages that hold a trajectory."""
_MOST = 10_000
"""Trajectories in a bag, at most."""
_LISTED = 100
"""Trajectories of which one can be chosen from a list, at most."""
_BAR = "=" * 80
JOINT_TRAJECTORY = f"""std_msgs/Header header
string[] joint_names
JointTrajectoryPoint[] points
{_BAR}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_BAR}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{_BAR}
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
{_BAR}
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""
"""Definition of the first of them."""


class BagMessage(NamedTuple):
    """A trajectory in a bag: its topic, its number among those of the topic from 1, its data."""

    topic: str
    number: int
    data: Any


def read_bag(content: bytes, topic: str | None = None) -> Any:
    """Read a trajectory of a bag as plain data.

    Args:
        content: of the bag's file.
        topic: of the trajectory, ``TOPIC`` or ``TOPIC:NUMBER`` where it has several; None for the
            only one in the bag.

    Raises:
        SeveralTrajectoriesError: it has several, and none is named.
        MotionError: it is no bag, or has no such trajectory.
    """
    found = list[BagMessage]()
    numbers: Counter[str] = Counter()
    read = _sqlite_messages if content.startswith(b"SQLite format 3") else _mcap_messages
    try:
        for name, data in read(content):
            numbers[name] += 1
            found.append(BagMessage(name, numbers[name], data))
            if len(found) > _MOST:
                raise MotionError(f"The bag has more than {_MOST:,} trajectories.")
    except MotionError:
        raise
    except Exception as error:  # readers of damaged bags raise whatever they meet
        reason = short(str(error) or type(error).__name__)
        raise MotionError(f"The bag cannot be read ({reason}).") from None
    return _chosen(found, topic).data


def _chosen(found: list[BagMessage], topic: str | None) -> BagMessage:
    """The trajectory that is asked for.

    Raises:
        MotionError: there is none, or it is not said which of several.
    """
    asked = [one for one in found if topic in (None, one.topic, f"{one.topic}:{one.number}")]
    if len(asked) == 1:
        return asked[0]
    counts = Counter(one.topic for one in found)
    told = ", ".join(
        name if count == 1 else f"{name}:1 to {name}:{count}" for name, count in counts.items()
    )
    if not found:
        raise MotionError(
            "The bag holds no trajectory.",
            f"Record a topic with messages of the kind {KINDS[0]}, or MoveIt's.",
        )
    if not asked:
        raise MotionError(f"The bag has no trajectory {short(topic)}.", f"It has {told}.")
    raise SeveralTrajectoriesError(
        f"The bag has {len(asked)} trajectories.",
        f"Choose one by its topic and number, abi certify --topic: {told}.",
        tuple(
            one.topic if counts[one.topic] == 1 else f"{one.topic}:{one.number}"
            for one in asked[:_LISTED]
        ),
    )


def _mcap_messages(content: bytes) -> Iterator[tuple[str, Any]]:
    """Topic and data of each trajectory of an MCAP file."""
    from mcap.reader import make_reader  # here, since few need it
    from mcap_ros2.decoder import DecoderFactory

    reader = make_reader(io.BytesIO(content), decoder_factories=[DecoderFactory()])
    summary = reader.get_summary()
    kinds = {one.name for one in summary.schemas.values()} if summary else {*KINDS}
    if kinds.isdisjoint(KINDS):
        return
    topics = None
    if summary:
        schemas = {key for key, one in summary.schemas.items() if one.name in KINDS}
        topics = [one.topic for one in summary.channels.values() if one.schema_id in schemas]
    for schema, channel, _, message in reader.iter_decoded_messages(topics=topics):
        if schema is not None and schema.name in KINDS:
            yield channel.topic, _plain(message)


def _sqlite_messages(content: bytes) -> Iterator[tuple[str, Any]]:
    """Topic and data of each trajectory of an SQLite file."""
    bag = sqlite3.connect(":memory:")
    try:
        bag.deserialize(content)
        bag.execute("PRAGMA temp_store = MEMORY")  # no file may be written where others' are read
        definitions = {KINDS[0]: JOINT_TRAJECTORY} | _definitions(bag)
        decoders = {kind: _decoder(kind, text) for kind, text in definitions.items()}
        rows = bag.execute(
            "SELECT topics.name, topics.type, messages.data FROM messages "
            "JOIN topics ON topics.id = messages.topic_id ORDER BY messages.timestamp"
        )
        for topic, kind, data in rows:
            if kind in decoders:
                yield str(topic), _plain(decoders[kind](data))
            elif kind in KINDS:
                raise MotionError(
                    f"The bag does not say what a message of the kind {kind} holds.",
                    "Convert it to MCAP: ros2 bag convert.",
                )
    finally:
        bag.close()


def _definitions(bag: sqlite3.Connection) -> dict[str, str]:
    """Definitions of kinds of trajectories; none in bags of ROS 2 Humble and before."""
    tables = bag.execute("SELECT name FROM sqlite_master WHERE name = 'message_definitions'")
    if tables.fetchone() is None:
        return {}
    rows = bag.execute(
        "SELECT topic_type, encoded_message_definition FROM message_definitions "
        "WHERE encoding = 'ros2msg'"
    )
    return {str(kind): str(text) for kind, text in rows if kind in KINDS}


def _decoder(kind: str, text: str) -> Callable[[bytes], Any]:
    from mcap_ros2.decoder import DecoderFactory

    schema = Schema(data=text.encode(), encoding="ros2msg", id=1, name=kind)
    decoder = DecoderFactory().decoder_for("cdr", schema)
    assert decoder is not None
    return decoder


def _plain(value: Any) -> Any:
    """A message as mappings, lists and numbers."""
    if isinstance(value, str | int | float | bool | bytes) or value is None:
        return value
    if isinstance(value, np.ndarray | list | tuple | memoryview):
        return [_plain(one) for one in (value.tolist() if hasattr(value, "tolist") else value)]
    names = getattr(value, "__slots__", None) or vars(value)
    return {name: _plain(getattr(value, name)) for name in names if not name.startswith("_")}
