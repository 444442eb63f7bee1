"""Rows of a crowd that is packed again and again are those of a crowd packed anew."""

from __future__ import annotations

import threading

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.packing import pack
from abi.obstacles.primitives import Primitive
from tests.random_geometry import random_obstacle


def solid(random: np.random.Generator) -> Primitive:
    found = random_obstacle(random)
    assert not isinstance(found, MeshShape)
    return found


def packed_anew(crowd: tuple[Primitive, ...]) -> FloatArray:
    """Rows as a thread without any memory makes them."""
    found: list[FloatArray] = []
    thread = threading.Thread(target=lambda: found.append(pack(crowd)))
    thread.start()
    thread.join()
    return found[0]


def test_a_changed_crowd_has_the_rows_of_a_new_one() -> None:
    random = np.random.default_rng(4)
    crowd = [solid(random) for _ in range(100)]
    first = pack(tuple(crowd))
    before = first.copy()
    for step in range(12):
        k = int(random.integers(len(crowd)))
        if step == 5:
            del crowd[k]
        elif step == 8:
            crowd.reverse()
        else:
            crowd[k] = solid(random)
        found = pack(tuple(crowd))
        assert found.tobytes() == packed_anew(tuple(crowd)).tobytes()
        assert not found.flags.writeable
    assert first.tobytes() == before.tobytes()
