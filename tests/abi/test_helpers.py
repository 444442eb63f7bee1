"""Helpers of kernels: compiled once for their types, in versions of numba known to allow it."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest

from abi.arrays import FloatArray, read_only
from abi.compilation import helpers
from abi.compilation.dispatcher import compile_once, make_dispatcher
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, NEW_FLOATS
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.obstacle_set_kernels import signed_distances
from abi.scene.scene import load_scene
from tests.abi.test_compiled import run


@jitable
def power(base: float, exponent: int) -> float:
    result = 1.0
    for _ in range(exponent):
        result *= base
    return result


@jitable(forceinline=True)
def cube(base: float) -> float:
    return power(base, 3)


def cubes(numbers: Any, found: Any) -> float:
    for i in range(len(numbers)):
        found[i] = cube(numbers[i])
    return power(2.0, exponent=len(numbers))


def powers(exponents: Any, found: Any) -> None:
    for i in range(len(exponents)):
        found[i] = power(0.1, exponents[i]) / (1 - cube(1.0))


@pytest.fixture
def compiled_pair() -> tuple[Any, Any]:
    pair = []
    for function, example in (cubes, (FLOATS, NEW_FLOATS)), (powers, (IDS, NEW_FLOATS)):
        pair.append(make_dispatcher(function, example, {}))
        compile_once(pair[-1], example)
    return pair[0], pair[1]


def test_helpers_are_compiled_in_this_version_of_numba() -> None:
    # with another version: let all tests run, compare plans with the last version's, then add it
    assert helpers.is_known(numba.__version__)
    assert helpers.is_known("0.68.7")
    assert not helpers.is_known("0.61.0")
    assert not helpers.is_known("1.68.0")


def test_a_helper_does_the_same_compiled(compiled_pair: tuple[Any, Any]) -> None:
    first, second = compiled_pair
    numbers, found = np.array([0.1, -3.0, 1e200]), np.zeros(3)
    numbers.setflags(write=False)
    assert first(numbers, found) == power(2.0, 3)
    np.testing.assert_array_equal(found, [cube(float(number)) for number in numbers])
    exponents = np.array([0, 5], np.int32)
    exponents.setflags(write=False)
    second(exponents, found)
    np.testing.assert_array_equal(found[:2], [np.inf, np.inf])


PLAIN = """
from abi.compilation import helpers
helpers.VERSIONS = ()
from tests.abi.test_helpers import distances
print(distances().tobytes().hex())
"""


def distances() -> FloatArray:
    """Distances of points to the obstacles of a scene, compiled."""
    obstacles = ObstacleSet(load_scene("forest").obstacles)
    signed_distances.compile()
    points = read_only(np.random.default_rng(0).uniform(0, 6, (500, 3)))
    return obstacles.signed_distance(points)


@pytest.mark.slow
def test_in_other_versions_of_numba_helpers_are_compiled_by_numba_itself(tmp_path: Any) -> None:
    plain = bytes.fromhex(run(PLAIN, NUMBA_CACHE_DIR=str(tmp_path)))
    assert len(plain) == 500 * 8
    assert distances().tobytes() == plain
