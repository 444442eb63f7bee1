"""Bags for ROS 2, as two readers of them understand them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from abi.export.formats import FORMATS, export
from abi.export.joint_trajectory import joint_trajectory
from abi.obstacles.pose import METRES
from abi.planner.planner import plan
from abi.scene.scene import load_scene


def test_both_readers_of_ros_bags_read_the_motion(tmp_path: Path) -> None:
    planned = plan(load_scene("paper").replace(motion={"curve": "bspline"}))
    file = tmp_path / FORMATS["rosbag"].file
    export(planned, file)
    trajectory = joint_trajectory(planned)
    metre = METRES[planned.scene.unit]
    found: dict[str, list[Any]] = {}
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    others: dict[str, list[Any]] = {}
    with AnyReader([file]) as bag:
        for connection, time, raw in bag.messages():
            message = bag.deserialize(raw, connection.msgtype)
            others.setdefault(connection.topic, []).append(message)
            stamp = getattr(message, "header", None)
            assert stamp is None or stamp.stamp.sec * 10**9 + stamp.stamp.nanosec == time

    assert planned.motion is not None
    for messages in (found, others):
        np.testing.assert_array_equal(
            [one.position for one in messages["/joint_states"]], trajectory.positions
        )
        (whole,) = messages["/joint_trajectory"]
        assert tuple(whole.joint_names) == trajectory.names
        rates = [one.velocities for one in whole.points]
        np.testing.assert_array_equal(rates, trajectory.velocities)
        places = [one.pose.position for one in messages["/tool"]]
        tool = np.array([[one.x, one.y, one.z] for one in places]) / metre
        np.testing.assert_allclose(tool, planned.motion.tool, atol=1e-12)
        assert len(messages["/tf"]) == len(trajectory.time)
    assert {topic: len(one) for topic, one in found.items()} == {
        topic: len(one) for topic, one in others.items()
    }
