"""Long messages in YAML are what a reader of YAML takes them for."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.certification.read_motion import read_motion
from abi.certification.yaml_points import parse_yaml_points
from abi.errors import AbiError, SceneError
from abi.scene.scene_file import MAX_BYTES, parse_bytes, yaml_text
from tests.thorough import examples

NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(10**9), 10**9)
POINTS = st.lists(
    st.fixed_dictionaries(
        {
            "positions": st.lists(NUMBERS, max_size=3),
            "effort": st.builds(list),
            "time_from_start": st.fixed_dictionaries({"sec": NUMBERS, "nanosec": NUMBERS}),
        },
        optional={"at": NUMBERS},
    ),
    max_size=4,
)


@settings(max_examples=examples(20))
@given(points=POINTS, more=POINTS)
def test_points_mean_what_they_mean_in_yaml(points: object, more: object) -> None:
    data = {"header": {"frame": "a"}, "points": points, "solution": {"deep": {"points": more}}}
    text = yaml_text(data, width=4096).encode()
    assert parse_yaml_points(text, "a.yaml", least=0) == parse_bytes(text, "a.yaml") == data


@pytest.mark.parametrize(
    "text",
    [
        "a: |\n  - x: 1\n  - x: 2\n",  # text
        'a: "\n  - x: 1\n  - x: 2"\n',
        "a: b\n  - x: [1]\n",
        "a:\n- x: 1\n  y: 2\n  z: word\n",
        "a:\n- x: 1\n\n  y: 2\n",
        "a:\n- x: 1\n  x: 2\n",
        "a:\n- x: {b: 1, b: 2}\n",
        "a:\n- x: 1\n  # remark\n  y: 2\n- x: [01, 0x1, 1_0]\n",
        "a:\n- x: 1\n  - y: 2\n",
        "a: [\n- x: 1\n]\n",
        "a:\n- x: 1\n    y: 2\n",
        "- x: 1\r\n- x: 2\r\n",
        "x: 1\n- x: 2\n",
        "a:\n- x: 1\n- points-0-read-apart\n",
        "a:\n- x: 1\n- &b\n  y: 2\n- *b\n",
        "- - x: 1\n  - x: 2\n- 3\n",
        "a:\n  - x: 1\n    y: 2\n  - x: 3\nb: 4\n",
    ],
)
def test_lines_that_look_like_points_mean_what_they_mean_in_yaml(text: str) -> None:
    wanted, found = (
        outcome(partial(read, text.encode(), "a.yaml"))
        for read in (parse_bytes, partial(parse_yaml_points, least=0))
    )
    assert found == wanted


def outcome(read: Callable[[], object]) -> object:
    """What is read, or why it is not."""
    try:
        return read()
    except SceneError as error:
        return str(error)


def test_messages_larger_than_scenes_are_read() -> None:
    count, row = 4_000, [k / 7 for k in range(7)]
    points = [
        {"positions": row, "velocities": row, "time_from_start": {"sec": k, "nanosec": 0}}
        for k in range(count)
    ]
    lines = [
        f"- positions: {row}\n  velocities: {row}\n  time_from_start: {{sec: {k}, nanosec: 0}}\n"
        for k in range(count)
    ]
    names = [f"j{k}" for k in range(7)]
    text = f"# Proven clear.\njoint_names: {names}\npoints:\n{''.join(lines)}".encode()
    assert len(text) > 2 * MAX_BYTES
    slides = dict.fromkeys(names, False)
    motion = read_motion("a.yaml", text, slides)
    other = read_motion(
        "a.json", json.dumps({"joint_names": names, "points": points}).encode(), slides
    )
    assert motion.to_dict() == other.to_dict()
    assert motion.notes == ("The file says: Proven clear.",)
    large = b"header: [" + b"1, " * MAX_BYTES + b"1]\n" + text
    with pytest.raises(AbiError, match="at most 400 kB, or JSON"):
        read_motion("a.yaml", large, slides)
