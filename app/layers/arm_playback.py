"""The motion that the page plays by its own clock, without a message for each frame.

The page interpolates joint positions between samples and turns the node of each joint accordingly,
as :class:`app.layers.arm.ArmLayer` does for one moment. The page's part is in
``assets/page/page.js``.
"""

from __future__ import annotations

import base64
import functools
from dataclasses import dataclass

import numpy as np
import viser

from abi.arm.trajectory import ArmMotion
from abi.arrays import FloatArray, read_only
from app import page

SAMPLES = 101


@dataclass(frozen=True)
class JointPose:
    """Motion of a joint's node with its position.

    Attributes:
        name: of the node.
        column: of the joint's position among all.
        wxyz: orientation at position 0, (4,), in the parent node.
        position: place at position 0, (3,), [unit].
        axis: (3,), to turn about, in the node; or to slide along, in the parent node.
        prismatic: whether it slides.
    """

    name: str
    column: int
    wxyz: FloatArray
    position: FloatArray
    axis: FloatArray
    prismatic: bool

    def to_dict(self) -> dict[str, object]:
        """The fields as the page has them, to whose samples the time comes first."""
        return {
            "name": self.name,
            "column": self.column + 1,
            "wxyz": self.wxyz.tolist(),
            "position": self.position.tolist(),
            "axis": self.axis.tolist(),
            "prismatic": self.prismatic,
        }


class ArmPlayback:
    """Playback in the page of the arm's motion, sent anew when that changes."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._joints: tuple[list[JointPose], list[dict[str, object]]] = ([], [])
        self._playing: tuple[object, ...] | None = None

    def play(
        self, motion: ArmMotion, joints: list[JointPose], trace: str, time: float, rate: float
    ) -> bool:
        """Have the page play ``motion`` from ``time`` [s] on, at ``rate`` times real time.

        Returns:
            Whether this is new: the line named ``trace`` is then to have a segment between each
            two of :func:`samples_of`.
        """
        key = (motion, rate, id(joints))
        if key == self._playing:
            return False
        self._playing = key
        if self._joints[0] is not joints:
            self._joints = joints, [joint.to_dict() for joint in joints]
        rows = samples_of(motion)
        table = np.column_stack((motion.time[rows], motion.positions[rows])).astype("<f4")
        page.play(
            self._client,
            {
                "samples": base64.b64encode(table.tobytes()).decode(),
                "columns": table.shape[1],
                "joints": self._joints[1],
                "trace": trace,
                "time": time,
                "rate": rate,
            },
        )
        return True

    def stop(self, time: float) -> bool:
        """Have the page stand still at ``time`` [s]; whether it played."""
        if self._playing is None:
            return False
        self._playing = None
        page.stand(self._client, time)
        return True


def samples_of(motion: ArmMotion) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Numbers of the samples that the page gets, the first and the last among them."""
    return _numbers(len(motion.time))


@functools.cache
def _numbers(count: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Numbers of those samples among so many."""
    return read_only(np.unique(np.linspace(0, count - 1, SAMPLES).astype(np.int64)))
