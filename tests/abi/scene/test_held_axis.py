"""The direction of a tool that a scene holds within a tolerance: read, kept, or refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from abi.errors import SceneError
from abi.scene.held_axis import HeldAxis
from abi.scene.scene import Scene, load_scene

DOWN = [0.0, 0.0, -1.0]
HELD = {"direction": DOWN, "tolerance": 0.2, "from": 0.25, "to": 0.5}
shares = st.floats(0, 1)
bad = st.one_of(
    st.floats().filter(lambda number: not 0 <= number <= 1), st.text(), st.booleans(), st.none()
)


def scene(axis: Any = None, **arm: Any) -> Scene:
    data = {
        "version": 1,
        "unit": "m",
        "workspace": {"min": [-1, -1, 0], "max": [1, 1, 1]},
        "start": [0.4, 0.2, 0.4],
        "goal": [0.4, -0.2, 0.4],
        "mesh": {"pitch": 0.5},
        "arm": {"model": "urdf", "axis": axis, **arm},
    }
    return Scene.from_dict(data)


def refusal(axis: Any, **arm: Any) -> SceneError:
    with pytest.raises(SceneError) as refused:
        scene(axis, **arm)
    return refused.value


@given(
    st.tuples(*[st.floats(-10, 10)] * 3), st.floats(0.001, math.pi / 2), st.tuples(shares, shares)
)
def test_what_is_read_is_written_and_read_again(
    direction: tuple[float, float, float], tolerance: float, part: tuple[float, float]
) -> None:
    begin, end = sorted(part)
    assume(begin < end and max(map(abs, direction)) > 1e-6)
    one = scene({"direction": direction, "tolerance": tolerance, "from": begin, "to": end})
    held = one.arm.held_axis
    assert held is not None
    assert (held.direction, held.tolerance, held.begin, held.end) == (
        *(direction, tolerance),
        *(begin, end),
    )
    again = Scene.from_dict(one.to_dict())
    assert again == one
    assert hash(again) == hash(one)
    assert one.replace(arm={"axis": one.to_dict()["arm"]["axis"]}) == one


@given(st.sampled_from(["from", "to", "tolerance"]), bad)
def test_a_number_that_is_none_is_refused_by_its_field(name: str, value: Any) -> None:
    assume(name != "tolerance" or not (isinstance(value, float) and 0 < value <= math.pi / 2))
    assert refusal({**HELD, name: value}).field == f"arm.axis.{name}"


@given(shares, shares)
def test_a_part_has_a_length(begin: float, end: float) -> None:
    assume(begin >= end)
    refused = refusal({**HELD, "from": begin, "to": end})
    assert refused.field == "arm.axis"
    assert "from below to" in refused.expected


@pytest.mark.parametrize(
    ("axis", "arm", "field", "expected"),
    [
        ({**HELD, "direction": [0, 0, 0]}, {}, "arm.axis", "not zero"),
        ({**HELD, "direction": [1e-200, 0, 0]}, {}, "arm.axis", "not zero"),
        ([0, 0, -1e-200], {}, "arm.axis", "a direction, or none"),
        ({"tolerance": 0.1}, {}, "arm.axis.direction", "three numbers"),
        ({**HELD, "form": 0.1}, {}, "arm.axis.form", "did you mean from?"),
        ({**HELD, "begin": 0.1}, {}, "arm.axis.begin", "direction, tolerance, from, to"),
        ("down", {}, "arm.axis", "a list"),
        (HELD, {"model": "abi"}, "arm.axis", "none for the paper's arm"),
        (DOWN, {"model": "abi"}, "arm.axis", "none for the paper's arm"),
        (HELD, {"search": "mesh"}, "arm.search", "auto or joints"),
        (None, {"search": "mesh", "start": {"joints": [0.0] * 6}}, "arm.search", "auto or joints"),
        (DOWN, {"search": "joints"}, "arm.axis", "tolerance"),
        (DOWN, {"start": {"joints": [0.0] * 6}}, "arm.axis", "tolerance"),
    ],
)
def test_what_cannot_be_held_is_refused_in_a_sentence(
    axis: Any, arm: dict[str, Any], field: str, expected: str
) -> None:
    refused = refusal(axis, **arm)
    assert refused.field == field
    assert expected in refused.expected


def test_each_leg_has_its_own_and_the_first_one_that_of_the_scene(tmp_path: Path) -> None:
    waypoints: list[dict[str, Any]] = [
        {"goal": [0.4, 0, 0.4], "axis": HELD},
        {"goal": [0.4, 0.2, 0.5]},
        {"goal": [0.0, 0.0, 1.0], "axis": {**HELD, "to": 1.0}},
    ]
    one = scene().replace(tasks=waypoints)
    assert one.arm.held_axis == HeldAxis.model_validate(HELD)
    assert [leg.axis and leg.axis.end for leg in one.tasks] == [None, None, 1.0]
    one.save(tmp_path / "one.yaml")
    assert load_scene(tmp_path / "one.yaml") == one
    for change, field in (({"to": 2}, "tasks[2].axis.to"), ({"x": 2}, "tasks[2].axis.x")):
        wrong = {**waypoints[2], "axis": {**HELD, **change}}
        with pytest.raises(SceneError) as refused:
            scene().replace(tasks=[*waypoints[:2], wrong])
        assert refused.value.field == field
