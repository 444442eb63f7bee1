"""A ROS 2 bag with a trajectory, as an MCAP file."""

from __future__ import annotations

import io

from abi.certification.read_bag import JOINT_TRAJECTORY, KINDS


def mcap(joint: str) -> bytes:
    """A bag in which a joint moves by one unit in one second."""
    from mcap_ros2.writer import Writer

    points = [
        {"positions": [float(k)], "time_from_start": {"sec": k, "nanosec": 0}} for k in (0, 1)
    ]
    file = io.BytesIO()
    writer = Writer(file)
    schema = writer.register_msgdef(KINDS[0], JOINT_TRAJECTORY)
    writer.write_message("/a", schema, {"joint_names": [joint], "points": points}, 0)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()
