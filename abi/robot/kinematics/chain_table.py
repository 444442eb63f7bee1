"""What a chain's table must be before kernels read it: they trust its lengths and its ids."""

from __future__ import annotations

import numpy as np

from abi import arguments
from abi.errors import ArgumentError
from abi.robot.kinematics.chain_kernels import POSE, ChainTable

_LEAST_REACH = 1e-9
"""Shortest chain, [m]."""


def checked_table(table: ChainTable, joints: int, coordinates: int) -> ChainTable:
    """Return a table as kernels take it.

    Args:
        table: the table.
        joints: number m of joints that move.
        coordinates: number n of what moves them.

    Raises:
        ArgumentError: one of its fields has another shape or type, or makes no sense.
    """
    if not isinstance(table, ChainTable):
        raise ArgumentError("table", table, "a ChainTable")
    before = arguments.bits("table.before", table.before, (joints,), -1, joints - 1)
    late = np.flatnonzero(before >= np.arange(joints))
    if len(late):
        k = int(late[0])
        raise ArgumentError(f"table.before[{k}]", int(before[k]), f"a number below {k}")
    origins = arguments.numbers("table.origins", table.origins, (POSE * (joints + 1),))
    for pose in origins.reshape(-1, POSE):
        arguments.rotation("table.origins", pose[:9].reshape(3, 3))
    axes = arguments.numbers("table.axes", table.axes, (3 * joints,))
    for axis in axes.reshape(-1, 3):
        arguments.direction("table.axes", axis)
    limits = arguments.numbers("table.limits", table.limits, (2 * coordinates,))
    arguments.ranges("table.limits", limits.reshape(-1, 2), coordinates)
    checked = ChainTable(
        length=arguments.integer("table.length", table.length, 1, joints),
        before=before,
        origins=origins,
        axes=axes,
        slides=arguments.flags("table.slides", table.slides, (joints,)),
        source=arguments.ids("table.source", table.source, (joints,), coordinates),
        factor=arguments.numbers("table.factor", table.factor, (joints,)),
        offset=arguments.numbers("table.offset", table.offset, (joints,)),
        limits=limits,
        direction=arguments.direction("table.direction", table.direction),
        aims=bool(table.aims),
        reach=arguments.number("table.reach", table.reach, _LEAST_REACH),
    )
    return ChainTable(*map(arguments.owned, checked))
