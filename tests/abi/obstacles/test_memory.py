from __future__ import annotations

from abi.obstacles.memory import ByIdentity
from abi.obstacles.obstacle_set import meshes, rows
from abi.obstacles.primitives import Box, Obstacles


def test_the_same_thing_is_looked_up_and_an_equal_one_is_not() -> None:
    asked: list[tuple[int, ...]] = []

    def count(thing: tuple[int, ...]) -> int:
        asked.append(thing)
        return len(thing)

    known = ByIdentity(count)
    first = tuple(range(3))
    second = tuple(range(3))
    assert [known(first), known(first), known(second), known(first)] == [3, 3, 3, 3]
    assert len(asked) == 2


def test_only_the_last_things_are_kept() -> None:
    asked: list[int] = []

    def note(thing: tuple[int, ...]) -> int:
        asked.append(thing[0])
        return thing[0]

    known = ByIdentity(note)
    things = [(k,) for k in range(40)]
    assert [known(thing) for thing in things] == list(range(40))
    assert [known(thing) for thing in things[-16:]] == list(range(24, 40))
    assert len(asked) == 40
    assert known(things[0]) == 0
    assert len(asked) == 41


def test_another_tuple_of_obstacles_has_its_own_rows() -> None:
    for k in range(50):
        obstacles: Obstacles = (Box(size=(1, 1, 1), position=(k, 0, 0)),)
        assert rows(obstacles)[0] == k
        assert meshes(obstacles) == ()
