"""The motion that the page plays by its own clock, without a message for each frame.

The page interpolates joint positions between samples and moves the node of each joint accordingly,
as :class:`app.layers.arm.arm_nodes.JointNode` does for one moment. The page's part is in
``assets/page/page.js``.
"""

from __future__ import annotations

import base64
import functools

import numpy as np

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray, read_only

SAMPLES = 101


def table_of(motion: ArmMotion, positions: FloatArray) -> dict[str, object]:
    """Table of times and joint positions that the page interpolates, as its ``play`` takes it.

    Args:
        motion: the motion.
        positions: of the joints that the page moves, at :func:`samples_of` the motion, (k, m).
    """
    table = np.column_stack((motion.time[samples_of(motion)], positions)).astype("<f4")
    return {
        "samples": base64.b64encode(table.tobytes()).decode(),
        "columns": table.shape[1],
    }


def samples_of(motion: ArmMotion) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Numbers of the samples that the page gets, the first and the last among them."""
    return _numbers(len(motion.time))


@functools.cache
def _numbers(count: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Numbers of those samples among so many."""
    return read_only(np.unique(np.linspace(0, count - 1, SAMPLES).astype(np.int64)))
