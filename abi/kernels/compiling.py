"""Compiling, kept from one start to the next until any source of the kernels changes.

numba stamps what it keeps with the file that a kernel is in: its contents, or in older versions its
time and size. But the functions that a kernel calls are compiled into it, and most of them are in
other files; after a change there, the old code would go on running. So the stamp is one of the
contents of all those files. It is the same wherever these are copied.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """A decorator: numba's ``njit`` without the interpreter's lock, whose outcome is kept.

    Where numba keeps it, and ``NUMBA_CACHE_DIR``, are as ever. A numba that no longer has the
    private names used here stamps as it likes.

    Args:
        options: what else ``numba.njit`` is given.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        kernel = numba.njit(cache=True, nogil=True, **options)(function)
        index: Any = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
        if stamp() and hasattr(index, "_source_stamp"):
            index._source_stamp = stamp()
        return kernel

    return decorate


@functools.cache
def stamp() -> str:
    """A hash of all sources that kernels are compiled from; empty where they cannot be read."""
    here = Path(__file__).parent
    sources = sorted(here.parent.rglob("*_kernels.py"))
    if not sources:  # in an archive, or left out of an application that is one file
        return ""
    whole = hashlib.sha256()
    for source in (*sources, here.parent / "arrays.py"):
        whole.update(source.read_bytes())
    return whole.hexdigest()
