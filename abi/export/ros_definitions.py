"""Definitions of the ROS 2 messages in a bag, each with those of its nested messages.

Fields: https://docs.ros2.org/latest/api, packages std_msgs, geometry_msgs, sensor_msgs,
trajectory_msgs and tf2_msgs; the format: https://mcap.dev/spec/registry#ros2msg.
"""

from __future__ import annotations

_TIME = {"builtin_interfaces/Time": "int32 sec\nuint32 nanosec"}
_DURATION = {"builtin_interfaces/Duration": "int32 sec\nuint32 nanosec"}
_HEADER = {"std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id"} | _TIME
_QUATERNION = {"geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"}
_POSE = {
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
} | _QUATERNION
_TRANSFORM = {
    "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\n"
    "geometry_msgs/Quaternion rotation",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
} | _QUATERNION
_POINT = {
    "trajectory_msgs/JointTrajectoryPoint": "float64[] positions\nfloat64[] velocities\n"
    "float64[] accelerations\nfloat64[] effort\nbuiltin_interfaces/Duration time_from_start"
} | _DURATION


def _definition(fields: str, inside: dict[str, str]) -> str:
    """A definition followed by those of its nested messages, as in a bag."""
    parts = [fields, *(f"MSG: {name}\n{of_one}" for name, of_one in inside.items())]
    return f"\n{'=' * 80}\n".join(parts)


DEFINITIONS: dict[str, str] = {
    "std_msgs/msg/String": "string data",
    "sensor_msgs/msg/JointState": _definition(
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
        "float64[] effort",
        _HEADER,
    ),
    "trajectory_msgs/msg/JointTrajectory": _definition(
        "std_msgs/Header header\nstring[] joint_names\n"
        "trajectory_msgs/JointTrajectoryPoint[] points",
        _HEADER | _POINT,
    ),
    "geometry_msgs/msg/PoseStamped": _definition(
        "std_msgs/Header header\ngeometry_msgs/Pose pose", _HEADER | _POSE
    ),
    "tf2_msgs/msg/TFMessage": _definition(
        "geometry_msgs/TransformStamped[] transforms", _HEADER | _TRANSFORM
    ),
}
"""Definitions by the names of the messages."""
