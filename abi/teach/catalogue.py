"""The exercises by name, in the order of the stages."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from abi.errors import ArgumentError
from abi.teach.exercise import Exercise
from abi.teach.topics.edge_test import EDGE_TEST
from abi.teach.topics.elbow import ELBOW
from abi.teach.topics.heuristic import HEURISTIC
from abi.teach.topics.knot_insertion import KNOT_INSERTION
from abi.teach.topics.priority import PRIORITY
from abi.teach.topics.shortcut import SHORTCUT
from abi.teach.topics.time_law import TIME_LAW

_ALL = (EDGE_TEST, PRIORITY, HEURISTIC, SHORTCUT, KNOT_INSERTION, TIME_LAW, ELBOW)
_BY_NAME: Mapping[str, Exercise] = MappingProxyType({one.name: one for one in _ALL})


def exercises() -> Mapping[str, Exercise]:
    """The exercises by name; printing one shows its task and the beginning of a solution."""
    return _BY_NAME


def exercise(name: str) -> Exercise:
    """The exercise of that name.

    Raises:
        ArgumentError: there is none.
    """
    if name not in _BY_NAME:
        raise ArgumentError("exercise", name, f"one of {', '.join(_BY_NAME)}")
    return _BY_NAME[name]
