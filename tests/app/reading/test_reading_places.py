"""Places are shared out fairly: in the order of arrival, and one an owner."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.reading.reading_places import ReadingPlaces, Ticket


def served(places: ReadingPlaces, waiting: list[Ticket]) -> list[Ticket]:
    """Those that get a place now, and leave the list."""
    found = []
    while ticket := next((one for one in waiting if places.wait(one, 0)), None):
        waiting.remove(ticket)
        found.append(ticket)
    return found


def test_one_owner_has_one_place_however_many_files_there_are() -> None:
    places = ReadingPlaces(2)
    many = [places.queue("a") for _ in range(3)]
    assert places.wait(many[0], 0)
    assert not places.wait(many[1], 0)
    other = places.queue("b")
    assert places.wait(other, 0)


def test_who_comes_later_waits_for_one_more_file_of_each_at_most() -> None:
    places = ReadingPlaces(2)
    waiting = [places.queue(owner) for owner in "aaaabbbb"]
    first = served(places, waiting)
    assert [ticket.owner for ticket in first] == ["a", "b"]
    waiting.append(places.queue("c"))
    order, reading = [], first
    while reading[-1].owner != "c":
        places.give_back(reading.pop(0))
        reading += served(places, waiting)
        order.append(reading[-1].owner)
    assert order == ["a", "b", "c"]


@given(st.lists(st.sampled_from("abcd"), max_size=30), st.integers(1, 3))
def test_all_are_served_and_nobody_twice_while_others_wait(owners: list[str], count: int) -> None:
    places = ReadingPlaces(count)
    waiting = [places.queue(owner) for owner in owners]
    total, reading, order = len(owners), served(places, waiting), []
    while reading:
        assert len(reading) <= count
        assert len({ticket.owner for ticket in reading}) == len(reading)
        order.append(reading.pop(0))
        places.give_back(order[-1])
        reading += served(places, waiting)
    assert len(order) == total

    # with one place it is a round: an owner's second file comes after every other's first
    if count == 1:
        rounds = {ticket: owners_before(order, ticket) for ticket in order}
        assert list(rounds.values()) == sorted(rounds.values())


def owners_before(order: list[Ticket], ticket: Ticket) -> int:
    """Number of its owner's files that were read before it."""
    return sum(other.owner == ticket.owner for other in order[: order.index(ticket)])


def test_who_leaves_the_line_keeps_nobody_waiting() -> None:
    places = ReadingPlaces(1)
    first, second, third = (places.queue(owner) for owner in "abc")
    assert places.wait(first, 0)
    places.give_back(second)
    places.give_back(first)
    assert places.wait(third, 0)
