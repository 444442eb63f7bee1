"""Bags of ROS 2: MCAP and SQLite, written by two other libraries, and damaged ones."""

from __future__ import annotations

import contextlib
import io
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader
from mcap.writer import CompressionType
from mcap.writer import Writer as RawWriter
from mcap_ros2.writer import Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

from abi.certification import read_bag
from abi.certification.read_bag import JOINT_TRAJECTORY
from abi.certification.read_motion import load_motion, own_joints, read_motion
from abi.certification.robot_scene import robot_scene
from abi.errors import AbiError
from tests.thorough import examples

pytestmark = pytest.mark.slow
ROBOT = robot_scene("ur5e").arm.robot
JOINTS = tuple(own_joints(ROBOT))
KIND = "trajectory_msgs/msg/JointTrajectory"
POSITIONS = np.random.default_rng(0).uniform(-1, 1, (3, 6))
TIMES = (0.0, 0.5, 1.25)


def stamp(time: float) -> dict[str, int]:
    return {"sec": int(time), "nanosec": round(time % 1 * 1e9)}


def message(first: float = 0.0) -> dict[str, Any]:
    rows = zip(TIMES, (POSITIONS + first).tolist(), strict=True)
    empty: list[float] = []
    return {
        "header": {"stamp": stamp(0), "frame_id": "base"},
        "joint_names": list(JOINTS),
        "points": [
            {
                "positions": row,
                "velocities": [0.1] * 6,
                "accelerations": empty,
                "effort": empty,
                "time_from_start": stamp(time),
            }
            for time, row in rows
        ],
    }


def mcap(*topics: str) -> bytes:
    """A bag with a trajectory on each topic, the k-th of which begins k rad farther."""
    file = io.BytesIO()
    writer = Writer(file)
    schema = writer.register_msgdef(KIND, JOINT_TRAJECTORY)
    for number, topic in enumerate(topics):
        writer.write_message(topic, schema, message(number), number)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()


def sqlite(folder: Path) -> Path:
    """A bag as ROS 2 Humble records it: a folder with an SQLite file without definitions."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    header, time = kinds["std_msgs/msg/Header"], kinds["builtin_interfaces/msg/Time"]
    duration = kinds["builtin_interfaces/msg/Duration"]
    point = kinds["trajectory_msgs/msg/JointTrajectoryPoint"]
    none = np.zeros(0)
    points = [
        point(row, np.full(6, 0.1), none, none, duration(**stamp(time)))
        for time, row in zip(TIMES, POSITIONS, strict=True)
    ]
    sent = kinds[KIND](header(time(0, 0), "base"), list(JOINTS), points)
    with BagWriter(folder, version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/plan", KIND, typestore=store)
        writer.write(connection, 0, store.serialize_cdr(sent, KIND))
    return folder


def test_bags_of_both_kinds_hold_the_motion(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    file.write_bytes(mcap("/plan"))
    for path in (file, sqlite(tmp_path / "bag")):
        motion = load_motion(path, ROBOT)
        assert motion.joints == JOINTS
        assert motion.interpolation == "cubic"
        np.testing.assert_allclose(motion.times, TIMES, atol=1e-9)
        np.testing.assert_array_equal(motion.positions, POSITIONS)


def test_one_of_several_is_chosen_by_topic_and_number() -> None:
    content, joints = mcap("/plan", "/plan", "/other"), own_joints(ROBOT)
    with pytest.raises(AbiError, match="3 trajectories") as caught:
        read_motion("a.mcap", content, joints)
    assert "/plan:1 to /plan:2, /other" in caught.value.hint
    for topic, shift in (("/plan:1", 0), ("/plan:2", 1), ("/other", 2)):
        motion = read_motion("a.mcap", content, joints, topic)
        np.testing.assert_array_equal(motion.positions, POSITIONS + shift)
    with pytest.raises(AbiError, match="no trajectory '/none'"):
        read_motion("a.mcap", content, joints, "/none")
    with pytest.raises(AbiError, match="no bag"):
        read_motion("a.csv", b"", joints, "/plan")


@settings(max_examples=examples(20), deadline=None)
@given(st.data())
def test_a_damaged_bag_is_refused_or_read_as_it_was(data: st.DataObject) -> None:
    whole = bytearray(mcap("/plan"))
    place = data.draw(st.integers(0, len(whole) - 1))
    whole[place] ^= data.draw(st.integers(1, 255))
    cut = data.draw(st.sampled_from([len(whole), place]))
    for name in ("a.mcap", "a.db3"):
        with contextlib.suppress(AbiError):
            motion = read_motion(name, bytes(whole[:cut]), own_joints(ROBOT))
            np.testing.assert_array_equal(motion.positions, POSITIONS)
            np.testing.assert_allclose(motion.times, TIMES, atol=1e-9)


def copied(
    encoding: str = "cdr", first: bytes = b"", omitted: str = "use_statistics", more: bytes = b""
) -> bytes:
    """A bag with the same message, encoded otherwise, or without a part of the file."""
    reader = NonSeekingReader(io.BytesIO(mcap("/plan")))
    ((schema, channel, sent),) = reader.iter_messages()
    assert schema is not None
    file = io.BytesIO()
    options: dict[str, Any] = {omitted: False}
    writer = RawWriter(file, **options)
    writer.start()
    kind = writer.register_schema(schema.name, schema.encoding, schema.data)
    topic = writer.register_channel(channel.topic, encoding, kind)
    writer.add_message(topic, 0, first + sent.data[len(first) :] + more, 0)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()


def test_messages_that_are_encoded_otherwise_are_refused() -> None:
    with pytest.raises(AbiError, match="messages in 'ros1'"):
        read_motion("a.mcap", copied("ros1"), own_joints(ROBOT))
    for compressed_or_newer in (b"\x28\xb5\x2f\xfd", b"\0\3", b"\0\7", b"\0\x0b"):
        with pytest.raises(AbiError, match="does not begin as one in CDR"):
            read_motion("a.mcap", copied(first=compressed_or_newer), own_joints(ROBOT))


def test_a_large_message_is_refused_before_it_is_decoded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read_bag, "_LARGEST", 1_000_000)
    with pytest.raises(AbiError, match="larger than 1 MB"):
        read_motion("a.mcap", copied(more=bytes(1_000_000)), own_joints(ROBOT))


@pytest.mark.parametrize("count", range(12))
def test_a_message_that_goes_on_after_its_end_is_refused(count: int) -> None:
    content = copied(more=bytes(range(count)))
    if count < 4:  # which fills it up to a multiple of four
        motion = read_motion("a.mcap", content, own_joints(ROBOT))
        np.testing.assert_array_equal(motion.positions, POSITIONS)
    else:
        with pytest.raises(AbiError, match="longer than its definition"):
            read_motion("a.mcap", content, own_joints(ROBOT))


@pytest.mark.parametrize("missing", ["repeat_schemas", "repeat_channels", "use_chunking"])
def test_a_bag_is_read_whatever_its_end_lists(missing: str) -> None:
    motion = read_motion("a.mcap", copied(omitted=missing), own_joints(ROBOT))
    np.testing.assert_array_equal(motion.positions, POSITIONS)


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_a_bag_that_is_far_larger_once_unpacked_is_refused(
    compression: CompressionType, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = io.BytesIO()
    writer = RawWriter(file, chunk_size=1, compression=compression)
    writer.start()
    schema = writer.register_schema(KIND, "ros2msg", JOINT_TRAJECTORY.encode())
    channel = writer.register_channel("/plan", "cdr", schema)
    for _ in range(4):
        writer.add_message(channel, 0, bytes(1_000_000), 0)
    writer.finish()  # type: ignore[no-untyped-call]
    content = file.getvalue()
    assert len(content) < 100_000
    monkeypatch.setattr(read_bag, "_UNPACKED", 3_500_000)
    with pytest.raises(AbiError, match="more than 3 MB once it is unpacked"):
        read_motion("a.mcap", content, own_joints(ROBOT))


@pytest.mark.parametrize(
    ("messages", "words"),
    [
        ("CREATE VIEW messages AS {endless}", "no table messages"),
        ("CREATE TABLE messages (topic_id, timestamp, data)", "interrupted"),
    ],
)
def test_a_bag_whose_query_would_not_end_is_refused(
    messages: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    endless = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x FROM c"
    rows = 300
    monkeypatch.setattr(read_bag, "_STEPS", rows**2)
    bag = sqlite3.connect(":memory:")
    bag.execute("CREATE TABLE topics (id, name, type, serialization_format)")
    bag.execute(messages.format(endless=endless))
    bag.executemany("INSERT INTO topics VALUES (1, 'a', ?, 'cdr')", [(KIND,)] * rows)
    if "TABLE" in messages:
        bag.executemany("INSERT INTO messages VALUES (1, ?, x'00')", [(k,) for k in range(rows)])
    with pytest.raises(AbiError, match=words):
        read_motion("a.db3", bag.serialize(), own_joints(ROBOT))
    bag.close()
