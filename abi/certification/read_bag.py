"""Reader of trajectories in ROS 2 bags: MCAP files, and the older SQLite ones.

Messages are encoded in CDR. MCAP files bring their definitions along, as SQLite ones do since ROS 2
Iron; in older ones a ``JointTrajectory`` alone can be read.
"""

from __future__ import annotations

import io
import itertools
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np
from mcap.records import Schema

from abi.errors import AbiError, short

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
_UNPACKED, _PIECE = 200_000_000, 1 << 20
"""Most bytes of a bag once it is unpacked, and those that are unpacked at a time to count them."""
_LARGEST = 20_000_000
"""Most bytes of a message."""
_STEPS, _BETWEEN = 20_000_000, 100_000
"""Most steps of SQLite for a query, and those between two looks at their number."""
_PLAIN_CDR = (b"\0\0", b"\0\1")
"""Beginnings of messages whose bytes are big- and little-endian."""
_PADDING = 4
"""Bytes at the end of a message, less than which may fill it up to a multiple of four."""
_SQLITE = b"SQLite format 3"
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


def read_bag(content: bytes, topic: str | None = None) -> Any:
    """Read a trajectory of a bag as plain data.

    Args:
        content: of the bag's file.
        topic: of the trajectory, ``TOPIC`` or ``TOPIC:NUMBER`` where it has several; None for the
            only one in the bag.

    Raises:
        AbiError: it is no bag, has no such trajectory, or several, of which none is named; it then
            has their topics.
    """
    found = dict[tuple[str, int], Any]()  # by topic, and number among those of the topic from 1
    numbers: Counter[str] = Counter()
    read = _sqlite_messages if content.startswith(_SQLITE) else _mcap_messages
    try:
        for name, data in read(content):
            numbers[name] += 1
            found[name, numbers[name]] = data
            _check_number(len(found))
    except AbiError:
        raise
    except Exception as error:  # readers of damaged bags raise whatever they meet
        reason = short(str(error) or type(error).__name__)
        raise AbiError(f"The bag cannot be read ({reason}).") from None
    return found[_chosen([*found], topic)]


def state_of_bag(content: bytes) -> list[str]:
    """What the metadata of an MCAP file say of a motion that was exported into it, in words."""
    if content.startswith(_SQLITE):
        return []
    from mcap.reader import NonSeekingReader  # here, since few need it

    said = []
    with suppress(Exception):  # the reader raises whatever it meets in a damaged bag
        for one in NonSeekingReader(io.BytesIO(content)).iter_metadata():
            said += [one.metadata["state"]] if one.name == "arm" else []
    return said


def _chosen(found: list[tuple[str, int]], topic: str | None) -> tuple[str, int]:
    """Topic and number of the trajectory that is asked for, of those in a bag.

    Raises:
        AbiError: there is none, or it is not said which of several.
    """
    asked = [(name, k) for name, k in found if topic in (None, name, f"{name}:{k}")]
    if len(asked) == 1:
        return asked[0]
    counts = Counter(name for name, _ in found)
    told = ", ".join(
        name if count == 1 else f"{name}:1 to {name}:{count}" for name, count in counts.items()
    )
    if not found:
        raise AbiError(
            "The bag holds no trajectory.",
            f"Record a topic with messages of the kind {KINDS[0]}, or MoveIt's.",
        )
    if not asked:
        raise AbiError(f"The bag has no trajectory {short(topic)}.", f"It has {told}.")
    raise AbiError(
        f"The bag has {len(asked)} trajectories.",
        f"Choose one by its topic and number, abi certify --topic: {told}.",
        tuple(name if counts[name] == 1 else f"{name}:{k}" for name, k in asked[:_LISTED]),
    )


def _mcap_messages(content: bytes) -> Iterator[tuple[str, Any]]:
    """Topic and data of each trajectory of an MCAP file, in the order of their times.

    The file is read from its beginning, since what its end lists of it need not be complete.
    """
    from mcap.reader import NonSeekingReader  # here, since few need it

    _check_size(content)
    reader = NonSeekingReader(io.BytesIO(content), validate_crcs=True)
    found = []
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        if schema is not None and schema.name in KINDS:
            found.append((message.log_time, schema, channel, message.data))
            _check_number(len(found))
    decoders: dict[tuple[int, str], Callable[[bytes], Any]] = {}
    for _, schema, channel, data in sorted(found, key=lambda one: one[0]):
        key = schema.id, channel.message_encoding
        if key not in decoders:
            decoders[key] = _decoder(schema, channel.message_encoding)
        yield channel.topic, _decoded(decoders[key], data)


def _check_size(content: bytes) -> None:
    """Raise where an MCAP file is much larger once it is unpacked, whatever it says itself."""
    import lz4.frame  # type: ignore[import-untyped]
    import zstandard
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader

    size = 0
    for record in StreamReader(io.BytesIO(content), emit_chunks=True).records:
        if not isinstance(record, Chunk) or record.compression not in ("zstd", "lz4"):
            continue
        packed = io.BytesIO(record.data)
        is_zstd = record.compression == "zstd"
        unpacked = (
            zstandard.ZstdDecompressor().stream_reader(packed)
            if is_zstd
            else lz4.frame.open(packed)
        )
        with unpacked:
            while piece := unpacked.read(_PIECE):
                size += len(piece)
                if size > _UNPACKED:
                    raise AbiError(
                        f"The bag holds more than {_UNPACKED // 10**6} MB once it is unpacked.",
                        "Record the trajectory's topic alone.",
                    )


def _sqlite_messages(content: bytes) -> Iterator[tuple[str, Any]]:
    """Topic and data of each trajectory of an SQLite file."""
    bag = sqlite3.connect(":memory:")
    try:
        bag.deserialize(content)
        bag.execute("PRAGMA temp_store = MEMORY")  # no file may be written where others' are read
        bag.execute("PRAGMA trusted_schema = OFF")
        steps = itertools.count(_BETWEEN, _BETWEEN)
        bag.set_progress_handler(lambda: next(steps) > _STEPS, _BETWEEN)
        if missing := {"topics", "messages"} - _tables(bag):
            raise AbiError(f"The bag has no table {min(missing)}.", "Record it with ROS 2.")
        definitions = {KINDS[0]: JOINT_TRAJECTORY} | _definitions(bag)
        rows = bag.execute(
            "SELECT topics.name, topics.type, topics.serialization_format, messages.data "
            "FROM messages JOIN topics ON topics.id = messages.topic_id ORDER BY messages.timestamp"
        )
        decoders: dict[tuple[str, str], Callable[[bytes], Any]] = {}
        for topic, kind, encoding, data in rows:
            if kind in definitions:
                if (kind, encoding) not in decoders:
                    text = definitions[kind].encode()
                    schema = Schema(data=text, encoding="ros2msg", id=1, name=kind)
                    decoders[kind, encoding] = _decoder(schema, str(encoding))
                yield str(topic), _decoded(decoders[kind, encoding], data)
            elif kind in KINDS:
                raise AbiError(
                    f"The bag does not say what a message of the kind {kind} holds.",
                    "Convert it to MCAP: ros2 bag convert.",
                )
    finally:
        bag.close()


def _definitions(bag: sqlite3.Connection) -> dict[str, str]:
    """Definitions of kinds of trajectories; none in bags of ROS 2 Humble and before."""
    if "message_definitions" not in _tables(bag):
        return {}
    rows = bag.execute(
        "SELECT topic_type, encoded_message_definition FROM message_definitions "
        "WHERE encoding = 'ros2msg'"
    )
    return {str(kind): str(text) for kind, text in rows if kind in KINDS}


def _tables(bag: sqlite3.Connection) -> set[str]:
    """Names of its tables; a view may stand for anything, also for a query without an end."""
    rows = bag.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
    return {str(name) for (name,) in rows}


def _decoder(schema: Schema, encoding: str) -> Callable[[bytes], Any]:
    """Decoder of the messages of a schema.

    Raises:
        AbiError: they are in another encoding than CDR, or are defined in another language.
    """
    from mcap_ros2.decoder import DecoderFactory

    decoder = DecoderFactory().decoder_for(encoding, schema)
    if decoder is None:
        raise AbiError(
            f"The bag has messages in {short(encoding)}, defined in {short(schema.encoding)}.",
            "Record them with ROS 2, in CDR and with definitions in ros2msg.",
        )
    return decoder


def _decoded(decoder: Callable[[bytes], Any], data: bytes) -> Any:
    """A message as plain data.

    Raises:
        AbiError: it is compressed, in a newer CDR, whose numbers are aligned otherwise, or goes
            on where its definition ends.
    """
    if len(data) > _LARGEST:
        raise AbiError(f"A message of the bag is larger than {_LARGEST // 10**6} MB.")
    if bytes(data[:2]) not in _PLAIN_CDR:
        raise AbiError(
            "A message of the bag does not begin as one in CDR does.",
            "If its messages are compressed, convert it: ros2 bag convert.",
        )
    message = _plain(decoder(data))
    if _is_decoded(decoder, data[:-_PADDING]):
        raise AbiError(
            "A message of the bag is longer than its definition says.",
            "It may be of another version of its kind: record it with the definition that it has.",
        )
    return message


def _is_decoded(decoder: Callable[[bytes], Any], data: bytes) -> bool:
    """Check whether a message is whole: it ends with a number, without which it is not."""
    whole = False
    with suppress(Exception):  # the decoder raises whatever it meets
        decoder(data)
        whole = True
    return whole


def _check_number(count: int) -> None:
    if count > _MOST:
        raise AbiError(f"The bag has more than {_MOST:,} trajectories.")


def _plain(value: Any) -> Any:
    """A message as mappings, lists and numbers."""
    if isinstance(value, str | int | float | bool | bytes) or value is None:
        return value
    if isinstance(value, np.ndarray | list | tuple | memoryview):
        return [_plain(one) for one in (value.tolist() if hasattr(value, "tolist") else value)]
    names = getattr(value, "__slots__", None) or vars(value)
    return {name: _plain(getattr(value, name)) for name in names if not name.startswith("_")}
