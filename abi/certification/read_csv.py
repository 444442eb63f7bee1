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
from typing import NamedTuple

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


class _Column(NamedTuple):
    """A column of the table: its place, its name without the unit, and the unit."""

    place: int
    name: str
    unit: str


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
    columns = [_column(k, cell, slides) for k, cell in enumerate(rows[0])]
    found = [one for one in columns if one.name in slides and not _must_be_time(one)]
    time = [one for one in columns if one.name.lower() in _TIMES and one not in found]
    if not found:
        names = ", ".join(short(one.name) for one in columns[:6])
        raise AbiError(
            f"No column of the file is named after a joint: its first row has {names}.",
            f"Give a header with the robot's joints: {', '.join(list(slides)[:8])}.",
        )
    tables = [_numbers(rows, one, _LENGTHS if slides[one.name] else _ANGLES) for one in found]
    positions = np.stack(tables, axis=1)
    times = _numbers(rows, time[0], _DURATIONS) if time else np.arange(len(rows) - 1, dtype=float)
    stated = {one.place for one in columns if one.name in _STATES and one not in found}
    left_out = [
        one.name or "one without a name"
        for one in columns
        if one not in found and one not in time[:1] and one.place not in stated
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
        joints=tuple(one.name for one in found),
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
    named = sum(_column(k, cell, slides).name in slides for k, cell in enumerate(cells))
    return named, header.count(delimiter)


def _column(place: int, cell: str, slides: Mapping[str, bool]) -> _Column:
    """A column by its cell in the header; what looks like a unit may be part of a joint's name."""
    if cell.strip() in slides or len(cell) > _LONGEST_HEADING:
        return _Column(place, cell.strip(), "")
    match = _HEADING.match(cell.strip().strip('"'))
    assert match is not None  # every text is a name
    unit = (match["unit"] or "").strip().lower()
    return _Column(place, match["name"].strip(), unit)


def _must_be_time(column: _Column) -> bool:
    """Check whether a column is the time though a joint is called so: by its unit."""
    return column.name.lower() in _TIMES and column.unit in _DURATIONS and column.unit != ""


def _numbers(rows: list[list[str]], column: _Column, factors: Mapping[str, float]) -> FloatArray:
    """Numbers of a column below the header, times the factor of its unit."""
    if column.unit not in factors:
        units = ", ".join(f"[{unit}]" for unit in factors if unit)
        raise AbiError(
            f"The unit of {column.name} is {short(column.unit)}.",
            f"Use one of {units}.",
        )
    values = []
    for row, cells in enumerate(rows[1:], start=1):
        cell = cells[column.place] if column.place < len(cells) else ""
        try:
            # float() would take 1_0 for 10, and digits of other scripts
            values.append(float(cell.replace("_", "?") if cell.isascii() else "?"))
        except ValueError:
            raise AbiError(
                f"In row {row} {column.name} is {short(cell)}, which is no number.",
            ) from None
    return factors[column.unit] * np.array(values)
