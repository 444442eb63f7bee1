"""The motion that the page plays by its own clock, without a message for each frame.

The page interpolates joint positions between samples and moves the node of each joint accordingly,
as :class:`app.layers.arm.arm_nodes.JointNode` does for one moment. The page's part is in
``assets/page/page.js``.
"""

from __future__ import annotations

import base64
import functools
from collections.abc import Callable

import numpy as np
import viser

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray, read_only
from app.layers.arm.arm_nodes import JointNode
from app.ui import page

SAMPLES = 101


class ArmPlayback:
    """Playback in the page of the arm's motion, sent anew when that changes."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._joints: list[JointNode] | None = None
        self._playing: tuple[ArmMotion, float, bool] | None = None

    def play(
        self,
        motion: ArmMotion,
        values: Callable[[FloatArray], FloatArray],
        joints: list[JointNode],
        trace: str,
        time: float,
        rate: float,
        again: bool = True,
    ) -> bool:
        """Have the page play ``motion`` from ``time`` [s] on, at ``rate`` times real time.

        Args:
            motion: the motion.
            values: positions (k, m) of the joints that have nodes, of those (k, n) of the motion.
            joints: their nodes.
            trace: name of the line behind the tool.
            time: to begin at, [s].
            rate: seconds of the motion for one of the clock.
            again: whether it begins anew after its end.

        Returns:
            Whether this is new: the line named ``trace`` is then to have a segment between each
            two of :func:`samples_of`.
        """
        if (motion, rate, again) == self._playing and joints is self._joints:
            return False
        self._playing, self._joints = (motion, rate, again), joints
        rows = samples_of(motion)
        positions = values(motion.positions[rows]) if joints else motion.positions[rows]
        table = np.column_stack((motion.time[rows], positions)).astype("<f4")
        page.call(
            self._client,
            "play",
            {
                "samples": base64.b64encode(table.tobytes()).decode(),
                "columns": table.shape[1],
                "joints": [joint.played for joint in joints],
                "trace": trace,
                "time": time,
                "rate": rate,
                "again": again,
            },
        )
        return True

    def seek(self, time: float) -> None:
        """Have the page go on at ``time`` [s] of the motion that it plays."""
        page.call(self._client, "seek", time)

    def stop(self, time: float) -> bool:
        """Have the page stand still at ``time`` [s]; whether it played."""
        if self._playing is None:
            return False
        self._playing = None
        page.call(self._client, "stand", time)
        for joint in self._joints or ():
            joint.forget_pose()
        return True


def samples_of(motion: ArmMotion) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Numbers of the samples that the page gets, the first and the last among them."""
    return _numbers(len(motion.time))


@functools.cache
def _numbers(count: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Numbers of those samples among so many."""
    return read_only(np.unique(np.linspace(0, count - 1, SAMPLES).astype(np.int64)))
