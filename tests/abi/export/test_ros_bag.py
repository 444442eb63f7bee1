"""Bags for ROS 2, as two readers of them understand them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from abi.export.formats import FORMATS, export
from abi.export.joint_trajectory import joint_trajectory
from abi.export.mcap_arm import joint_states, link_frames, scene_frame
from abi.obstacles.pose import METRES, rotation
from abi.planner.planner import plan
from abi.robot.urdf.tip_pose import tip_pose
from abi.robot.urdf_arm import urdf_arm
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
        assert tuple(whole.joint_names) == trajectory.joints
        rates = [one.velocities for one in whole.points]
        np.testing.assert_array_equal(rates, trajectory.joint_velocities)
        places = [one.pose.position for one in messages["/tool"]]
        tool = np.array([[one.x, one.y, one.z] for one in places]) / metre
        np.testing.assert_allclose(tool, planned.motion.tool, atol=1e-12)
        assert len(messages["/tf"]) == len(trajectory.time)
    assert {topic: len(one) for topic, one in found.items()} == {
        topic: len(one) for topic, one in others.items()
    }


def test_the_frames_and_joints_of_a_sequence_have_the_gripper_of_each_leg() -> None:
    robot = load_scene("pick-and-place").robot
    open_, closed = (
        urdf_arm(robot, "panda_hand_tcp", (0.1, 0.2, 0.3), held={"panda_finger_joint1": at})
        for at in (0.04, 0.01)
    )
    positions = np.random.default_rng(3).uniform(-0.5, 0.5, (7, 7))
    legs = [(open_.chain, 2), (closed.chain, 4), (open_.chain, 6)]
    still, moving = link_frames(open_.chain, positions, legs)
    fingers = {"panda_leftfinger", "panda_rightfinger"}
    assert fingers <= {child for _, child in moving}
    assert not fingers & {child for _, child in link_frames(open_.chain, positions, legs[2:])[1]}
    names = open_.chain.names
    motion = plan(load_scene("paper")).motion
    assert motion is not None
    still_rates = 0 * positions, 0 * positions
    trajectory = replace(
        motion, joints=names, time=np.arange(7.0), positions=positions, rates=still_rates
    )
    states = joint_states(trajectory, legs)
    for sample in range(7):
        world = {scene_frame(open_.chain): np.eye(4)}
        waiting = {**still, **moving}
        while waiting:
            parent, child = next(pair for pair in waiting if pair[0] in world)
            poses = waiting.pop((parent, child))
            place = poses[sample if len(poses) > 1 else 0].tolist()
            pose = np.eye(4)
            pose[:3, :3] = rotation(tuple(place[3:]))
            pose[:3, 3] = place[:3]
            world[child] = world[parent] @ pose
        state = dict(zip(states[sample]["name"], states[sample]["position"], strict=True))
        assert len(state) == len(states[sample]["velocity"]) == len(names) + 1  # a finger follows
        hand = np.linalg.inv(world["panda_link0"])
        for finger in fingers:
            np.testing.assert_allclose(
                hand @ world[finger], tip_pose(robot, finger, state), atol=1e-9
            )
        chain = next(chain for chain, last in legs if sample <= last)
        frames = chain.poses(positions[sample : sample + 1])[0]
        for link, frame in chain.frames.items():
            expected = np.eye(4)
            if frame >= 0:
                expected[:3] = frames[frame]
            np.testing.assert_allclose(world[link], expected @ chain.places[link], atol=1e-9)
