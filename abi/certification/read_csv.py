"""Reader of motions as comma-separated values: a header with the joints' names, a row a waypoint.

``time, elbow [deg], rail [mm]``: units stand in brackets behind a name, without them angles are in
[rad], lengths in [m] and times in [s]. Columns of other names than the robot's joints are ignored.
Between semicolons or tabs numbers may have decimal commas, as spreadsheets write them in many
countries.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping

import numpy as np

from abi.arrays import FloatArray
from abi.certification.motion import MOST_WAYPOINTS, Motion
from abi.errors import AbiError, short
from abi.obstacles.mesh_files.words import counted

_TIMES = ("time", "t", "time_from_start", "timestamp")
_ANGLES = {"": 1.0, "rad": 1.0, "deg": math.pi / 180, "°": math.pi / 180}
_LENGTHS = {"": 1.0, "m": 1.0, "cm": 0.01, "mm": 0.001}
_DURATIONS = {"": 1.0, "s": 1.0, "ms": 0.001, "ns": 1e-9}
_HEADING = re.compile(r"^(?P<name>.*?)\s*(?:[\[(]\s*(?P<unit>[^\])]*)\s*[\])])?$")
_STATES = ("state", "tool_state")
"""Columns in which an export says what is proven of a motion, and what its tool holds."""
_FEW = 20
"""Remarks before the header that are told, at most."""
_LONGEST_STATE, _LONGEST_HEADING = 500, 300
_DELIMITERS = ",;\t"
_MOST_LINES = MOST_WAYPOINTS + 2
"""Lines that are read: with the header, one more than a motion may have."""
_DECIMAL_COMMA = re.compile(r"(\d),(\d)")


def read_csv(text: str, slides: Mapping[str, bool]) -> Motion:
    """Read a motion from comma-, semicolon- or tab-separated values.

    Args:
        text: the whole file.
        slides: the robot's joints by their names, which are columns, and which of them slide.

    Raises:
        AbiError: no header, no column of a joint, a double one, or what is no number.
    """
    filled = [line for line in text.splitlines() if line.strip()]
    lines = [line for line in filled if not line.startswith("#")]
    if not lines:
        raise AbiError("The file is empty.", "Give a header with the joints' names, then rows.")
    delimiter = max(_DELIMITERS, key=lambda one: _fits(lines[0], one, slides))
    if delimiter != ",":
        lines[1:] = [_DECIMAL_COMMA.sub(r"\1.\2", line) for line in lines[1:]]
    rows = [_cells(number, line, delimiter) for number, line in enumerate(lines[:_MOST_LINES])]
    _check_widths(rows)
    names, units = zip(*(_name_and_unit(cell, slides) for cell in rows[0]), strict=True)
    places = range(len(names))
    joints = [k for k in places if names[k] in slides and not _must_be_time(names[k], units[k])]
    time = [k for k in places if names[k].lower() in _TIMES and k not in joints][:1]
    if not joints:
        raise AbiError(
            "No column of the file is named after a joint: its first row has "
            f"{', '.join(map(short, names[:6]))}.",
            f"Give a header with the robot's joints: {', '.join(list(slides)[:8])}.",
        )
    tables = [
        _numbers(
            rows,
            k,
            names[k],
            _factor(names[k], units[k], _LENGTHS if slides[names[k]] else _ANGLES),
        )
        for k in joints
    ]
    positions, times = np.stack(tables, axis=1), np.arange(len(rows) - 1, dtype=float)
    for k in time:
        times = _numbers(rows, k, names[k], _factor(names[k], units[k], _DURATIONS))
    stated = [k for k in places if names[k] in _STATES and k not in joints]
    left_out = [
        names[k] or "one without a name" for k in places if k not in (*joints, *time, *stated)
    ]
    notes = []
    begin = filled.index(lines[0])
    remarks = sum(line.startswith("#") for line in filled[begin:])
    notes += [f"The file says: {one.strip('# ')[:_LONGEST_STATE]}" for one in filled[:begin]][:_FEW]
    if remarks:
        notes.append(f"{counted(remarks, 'row')} left out: # begins a remark.")
    said = [cell.strip() for row in rows[1:] for k, cell in enumerate(row) if k in stated]
    notes += [f"The file says: {text[:_LONGEST_STATE]}" for text in dict.fromkeys(said) if text]
    if left_out:
        notes.append(f"Columns that are no joint were ignored: {', '.join(left_out[:8])}.")
    return Motion(
        joints=tuple(names[k] for k in joints),
        times=times,
        positions=positions,
        timed=bool(time),
        notes=tuple(notes),
    )


def _check_widths(rows: list[list[str]]) -> None:
    """Raise where a row has more cells than the header: whose each is cannot be known."""
    for row, cells in enumerate(rows[1:], start=1):
        if any(cell.strip() for cell in cells[len(rows[0]) :]):
            raise AbiError(
                f"Row {row} has {len(cells)} cells, and the header {len(rows[0])}.",
                "Name each column, one of row numbers, too, and write decimal points, or ; between "
                "numbers with decimal commas.",
            )


def _cells(row: int, line: str, delimiter: str) -> list[str]:
    """Cells of a line; a quote that none closes would take the lines after it along."""
    try:
        (cells,) = csv.reader([line], delimiter=delimiter, strict=True)
    except (csv.Error, ValueError):
        raise AbiError(
            f"Row {row} is no row of cells.", "Close each quote in its own row."
        ) from None
    return cells


def _fits(header: str, delimiter: str, slides: Mapping[str, bool]) -> tuple[int, int]:
    """Joints that a header names between such delimiters, which names may contain, and these."""
    try:
        cells = next(csv.reader([header], delimiter=delimiter))
    except csv.Error:
        cells = []
    named = sum(_name_and_unit(cell, slides)[0] in slides for cell in cells)
    return named, header.count(delimiter)


def _name_and_unit(cell: str, slides: Mapping[str, bool]) -> tuple[str, str]:
    """Name and unit of a column; what looks like a unit may be part of a joint's name."""
    if cell.strip() in slides or len(cell) > _LONGEST_HEADING:
        return cell.strip(), ""
    match = _HEADING.match(cell.strip().strip('"'))
    assert match is not None  # every text is a name
    unit = (match["unit"] or "").strip().lower()
    return match["name"].strip(), unit


def _must_be_time(name: str, unit: str) -> bool:
    """Check whether a column is the time though a joint is called so: by its unit."""
    return name.lower() in _TIMES and unit in _DURATIONS and unit != ""


def _factor(name: str, unit: str, factors: Mapping[str, float]) -> float:
    """Factor of a column's unit."""
    if unit not in factors:
        units = ", ".join(f"[{one}]" for one in factors if one)
        raise AbiError(f"The unit of {name} is {short(unit)}.", f"Use one of {units}.")
    return factors[unit]


def _numbers(rows: list[list[str]], place: int, name: str, factor: float) -> FloatArray:
    """Numbers of a column below the header, times a factor."""
    values = []
    for row, cells in enumerate(rows[1:], start=1):
        cell = cells[place] if place < len(cells) else ""
        try:
            # float() would take 1_0 for 10, and digits of other scripts
            values.append(float(cell.replace("_", "?") if cell.isascii() else "?"))
        except ValueError:
            raise AbiError(
                f"In row {row} {name} is {short(cell)}, which is no number.",
            ) from None
    return factor * np.array(values)
