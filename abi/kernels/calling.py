"""How a kernel is called before the compiler is done: as the Python that it is."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np


def call(ready: threading.Event, kernel: Any, *arguments: Any) -> Any:
    """Call a kernel: compiled once ``ready`` is set, else uncompiled on lists.

    An array that can be written is one that the kernel fills or changes.
    """
    if ready.is_set():
        return kernel(*arguments)
    plain = [value.tolist() if isinstance(value, np.ndarray) else value for value in arguments]
    with np.errstate(all="ignore"):  # as compiled
        result = kernel.py_func(*plain)
    for array, values in zip(arguments, plain, strict=True):
        if isinstance(array, np.ndarray) and array.flags.writeable:
            array[:] = values
    return result
