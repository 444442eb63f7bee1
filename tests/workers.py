"""How the tests are shared out among the workers."""

from __future__ import annotations

from bisect import bisect
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadFileScheduling

_BROWSER = Path(__file__).parent / "browser"
_FIRST_FILES = ("test_le",)
"""First name of the files of the second browser: both take about as long."""
BROWSERS = len(_FIRST_FILES) + 1


class ByFile(LoadFileScheduling):  # type: ignore[misc]
    """A file's tests go to one worker, so that what they share is made once.

    Those of the browser go to two, whichever file they are in: more browsers than that at a time
    would be slower than any patience.
    """

    def __init__(self, config: pytest.Config, log: Any) -> None:
        config.option.loadscopereorder = False  # in_order has done it, and better
        super().__init__(config, log)

    def _split_scope(self, nodeid: str) -> str:
        path = Path(nodeid.partition("::")[0])
        if path.parent.name == _BROWSER.name:
            return f"browser {bisect(_FIRST_FILES, path.name) + 1}"
        return str(path)


def in_order(items: list[pytest.Item]) -> None:
    """Sort tests by how long their files take, the longest first: nobody is to wait for the last.

    After the browser's, which take longest, a file goes by its number of slow tests.
    """
    slow = Counter(item.path for item in items if item.get_closest_marker("slow") is not None)
    first = -len(items)  # not in the key: a list that is being sorted has no length
    ranks = {
        path: first if path.parent == _BROWSER else -slow[path]
        for path in {item.path for item in items}
    }
    items.sort(key=lambda item: ranks[item.path])
