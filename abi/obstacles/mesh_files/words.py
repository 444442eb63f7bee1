"""Words of a mesh file's text: parsed as numbers, and quoted in sentences."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray

_LONGEST = 40
_LINE_END = re.compile(r"\r\n|\r|\n")


def lines_of(text: str) -> list[str]:
    """Lines of a text, with the ends of lines that files have, and no other of Unicode's."""
    return _LINE_END.split(text)


def float_words(words: Sequence[bytes], what: str) -> FloatArray:
    """Parse words as numbers, (n,).

    Raises:
        ValueError: one is none; says that ``what`` of numbers is expected.
    """
    if max(map(len, words), default=0) <= _LONGEST:
        with suppress(ValueError):
            return float_table(np.array(words, dtype=f"S{_LONGEST}"))
    wrong = next((word for word in words if not _is_number(word)), b"")
    raise ValueError(f"{what}, one of them is {shown(wrong.decode('utf-8', 'replace'))}")


def float_table(words: NDArray[np.bytes_]) -> FloatArray:
    """Numbers of the same shape; other programs read no ``1_0`` as Python does.

    Raises:
        ValueError: a word is no number.
    """
    if b"_" in words.tobytes():
        raise ValueError
    return words.astype(np.float64)


def shown(text: str) -> str:
    """Quote a word of a file, shortened and without unprintable characters."""
    return repr("".join(c if c.isprintable() else "?" for c in text[:_LONGEST]))


def counted(number: int, noun: str, several: str = "") -> str:
    """A number with its noun and verb: ``1 line is``, ``2 lines are``."""
    return f"1 {noun} is" if number == 1 else f"{number:,} {several or f'{noun}s'} are"


def _is_number(word: bytes) -> bool:
    try:
        return len(word) <= _LONGEST and bool(float_table(np.array([word])).size)
    except ValueError:
        return False
