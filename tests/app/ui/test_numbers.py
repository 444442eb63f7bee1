"""Lengths look the same wherever they stand, and bounds stay bounds."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi import load_scene, plan
from abi.errors import UNIT, SceneError, format_point
from abi.explain.arm_faults import limit_sentence
from abi.length_text import format_proven
from abi.scene.scene import scene_names
from app.layers.result.tables import _searches, _stages
from app.panels.stages.stage_headings import _results
from app.shared.puzzles import is_puzzle
from app.stages.catalogue import TITLES
from app.ui import style
from app.ui.numbers import (
    format_count,
    format_excess,
    format_length,
    format_lower_bound,
    format_setting,
    format_time,
    unbroken,
)
from app.ui.plan_notes import _clearance, _control_points, notes


def _number(text: str) -> float:
    return float(text.replace("−", "-").replace(",", ""))


@given(st.floats(1e-9, 1e9))
def test_a_proven_distance_is_told_rounded_down(distance: float) -> None:
    assert 0.999 * distance <= float(format_proven(distance)) <= distance


@pytest.mark.parametrize("size", [1e-3, 1.0, 99.9995, 1e2, 1e3, 1e6])
def test_a_lower_bound_stays_one(size: float) -> None:
    for number in np.random.default_rng(1).uniform(-size, size, 200):
        shown = _number(format_lower_bound(number))
        assert shown <= number + 1e-6 * max(abs(number), 1)
        assert number - shown <= 10.0 ** -(
            3 if abs(number) < 100 else 1 if abs(number) < 1000 else 0
        )
        assert format_lower_bound(shown) == format_length(shown)


@given(st.floats(1.0, 3.0), st.floats(0.1, 1e3))
def test_an_upper_bound_of_what_is_too_long_stays_one(times: float, shortest: float) -> None:
    percent = 100 * (times * shortest / shortest - 1)
    shown = _number(format_excess(times * shortest, shortest, exact=False).removesuffix(" %"))
    assert percent - 1e-6 <= shown < percent + 0.1 + 1e-6
    nearest = _number(format_excess(times * shortest, shortest, exact=True).removesuffix(" %"))
    assert abs(nearest - percent) <= 0.05 + 1e-9


@pytest.mark.parametrize("number", [0.0, 0.2, 1e-5, 1520.0, 1.52e7, 1.0 / 3, -0.084, 12.5])
def test_no_number_is_in_powers_of_ten(number: float) -> None:
    for shown in (format_setting(number), format_length(number), format_lower_bound(number)):
        assert "e" not in shown
    assert _number(format_setting(number)) == pytest.approx(number, rel=1e-3)


def test_counts_are_short() -> None:
    assert format_count(999_999) == "999,999"
    assert format_count(13_546_274) == "13.5 M"


@pytest.mark.slow
@pytest.mark.parametrize("name", scene_names())
def test_a_shipped_scene_opens_calmly_and_with_the_same_numbers_everywhere(name: str) -> None:
    found = plan(load_scene(name))
    is_whole = found.error is None and found.is_arm_clear and not found.limits_passed
    assert is_whole != is_puzzle(found.scene)
    assert style.readable(style.BAD) not in _stages(found)
    for stage, result in _results(found).items():
        if stage != "arm":
            assert len(f"{TITLES[stage]} — {result}") < 30
    table = _stages(found)
    for fit in (found.bspline, found.quadratic):
        note = _clearance(found, fit)
        if fit is None or not note:
            continue
        (distance,) = re.findall(r"(?:cuts|: )\s*(\d\.\d+)", note)
        assert f"{distance} ✗" in table


def test_the_table_tells_no_time_that_says_nothing() -> None:
    found = plan(load_scene("paper"))
    names = [result.algorithm for result in found.searches]
    fast = replace(found, ms={**found.ms, **dict.fromkeys(names, 0.08)})
    slow = replace(found, ms={**found.ms, **dict.fromkeys(names, 61.4)})
    assert _searches(fast, {}).count("<td>80 µs</td>") == len(names)
    assert _searches(slow, {}).count("<td>61 ms</td>") == len(names)
    for result in found.searches:
        assert f"<td>{result.relaxed:,}</td>" in _searches(fast, {})
    assert math.isfinite(found.searches[0].length)


@given(st.floats(0, 1e7))
def test_a_time_is_never_four_digits_of_milliseconds(ms: float) -> None:
    number, unit = format_time(ms).split()
    factor, half = {"µs": (0.001, 0.005), "ms": (1.0, 0.5), "s": (1000.0, 50.0)}[unit]
    assert abs(factor * float(number) - ms) <= half * (1 + 1e-6)
    assert (unit == "s") == (ms >= 999.5)
    assert (unit == "µs") == (ms < 0.995)
    assert unit == "s" or float(number) < 1000


def test_nothing_is_told_of_points_that_there_are_not() -> None:
    paper = load_scene("paper")
    boxes = [{"shape": "box", "size": [2, 2, 2], "position": [3.788, 3, 3]}]
    moved = plan(paper.replace(obstacles=boxes))
    assert moved.bspline is not None
    assert moved.bspline.curve.inserted == 0 < moved.bspline.curve.moved
    assert ">6 control points moved to stay clear." in _control_points(moved)
    added = plan(load_scene("arm-in-the-way"))
    assert ">8 control points added to stay near the path." in _control_points(added)
    assert _control_points(plan(paper)) == ""


@pytest.mark.parametrize("unit", ["m", "cm", "mm", "s", "ms", "%", "cm/s", "cm/s²"])
def test_no_line_ends_between_a_number_and_its_unit(unit: str) -> None:
    text = f'<b style="top:2 {unit}">The rod, 2 of 3, comes to 0.5 {unit}</b> in 3 steps, 4 more.'
    kept = unbroken(text)
    assert kept.replace("\N{NO-BREAK SPACE}", " ") == text
    places = [place for place, letter in enumerate(kept) if letter == "\N{NO-BREAK SPACE}"]
    assert places == [text.index(f"5 {unit}</b>") + 1]


def test_every_sentence_has_the_same_minus_sign() -> None:
    scene = load_scene("kitchen-ur5e")
    with pytest.raises(SceneError) as outside:
        scene.replace(goal=[-3.0, 0.0, 0.5])
    assert "x between −0.5 and 0.5 m" in outside.value.expected
    assert format_point((-1.5, 2.0, -0.25)) == f"(−1.5, 2, −0.25){UNIT}"
    fast = {"speed": 1.5, "acceleration": 5.0, "deceleration": 5.0, "law": "three_phase"}
    made = plan(scene.replace(motion=fast))
    assert made.motion is not None
    negative = [one for one in made.limits_passed if one.limit < 0]
    assert negative
    for violation in negative:
        assert "-" not in limit_sentence(violation, made.motion, "m").replace("three-", "")
    assert format_setting(-12_345.0) == "−12,345"
    assert format_setting(-0.0) == "0"
    assert format_point((0.0, -0.0, 1.0)) == f"(0, 0, 1){UNIT}"


def test_a_motion_has_the_name_of_its_law_unless_it_was_planned_elsewhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = plan(load_scene("paper").replace(motion={"law": "jerk_limited"}))
    assert made.profile is not None
    assert "Smooth (limited jerk), up to " in notes(made)["motion"]
    elsewhere = notes(replace(made, followed=None))["motion"]
    # what no proof compares is told beside it
    monkeypatch.setattr(type(made), "not_compared", ("left & right touch.",))
    assert "left &amp; right touch." in notes(replace(made))["arm"]
    assert f">{made.profile.duration:.2f} s in all." in elsewhere
