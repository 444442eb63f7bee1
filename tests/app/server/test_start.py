"""The command's work before there is a page to load."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

import abi

_LATE = ("numba", "scipy", "trimesh", "networkx", "lxml", "pydantic")
_NEVER = ("scipy.optimize", "scipy.spatial", "trimesh", "networkx")
"""What the first plan of the paper's scene needs nothing of; it takes a second to load."""
_CODE = """
import json, sys
{}
print(json.dumps(sorted(sys.modules)))
"""


def _loaded(code: str) -> list[str]:
    """Modules that are there after the code."""
    run = subprocess.run(
        [sys.executable, "-c", _CODE.format(code)], capture_output=True, text=True, check=True
    )
    return list(json.loads(run.stdout))


def test_the_port_opens_before_the_method_is_loaded() -> None:
    loaded = _loaded("import app.__main__, app.server.server")
    assert "viser" in loaded
    assert [name for name in _LATE if name in loaded] == []


def test_a_tab_and_its_first_plan_load_no_library_that_they_do_not_need() -> None:
    loaded = _loaded(
        "import app.tab.session, abi; assert abi.plan(abi.load_scene('paper')).bspline"
    )
    assert "pydantic" in loaded
    assert [name for name in _NEVER if name in loaded] == []


def test_what_the_first_picture_needs_is_there_before_a_tab_asks_and_no_more() -> None:
    loaded = _loaded(
        """
from app.server.warm_up import prepare_picture
prepare_picture()
from app.panels.teach.figures import paper_text
before = paper_text.cache_info()
paper_text()
after = paper_text.cache_info()
assert (after.misses - before.misses, after.hits - before.hits) == (0, 1)
"""
    )
    assert "app.tab.session" in loaded
    # what reads an arm's solids takes longer to import than all else, and the curve comes first
    assert not {"trimesh", "scipy.ndimage"} & set(loaded)


def test_garbage_is_looked_for_again_once_all_is_loaded() -> None:
    code = """
import gc
from app.process import unused_memory
from app.server import warm_up
warm_up.compiling.begin = lambda spare=None: None
warm_up.compiling.wait = lambda timeout: True
def loading():
    assert not gc.isenabled() and gc.get_freeze_count() == 0
    {then}
warm_up.prepare_picture = loading
unused_memory.load_at_once()
from abi.scene.scene import load_scene
from app.shared.shared_plans import SharedPlans
work = warm_up.WarmUp(load_scene("paper"), SharedPlans())
work.planned.set()
import time
while not gc.isenabled():
    time.sleep(0.01)
assert gc.get_freeze_count() > 10_000
"""
    for then in ("pass", "raise OSError"):
        _loaded(code.format(then=then))


def test_the_public_names_are_there_when_they_are_asked_for() -> None:
    code = "import abi; print([getattr(abi, name).__name__ for name in abi.__all__], dir(abi))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "load_scene" in run.stdout
    for wrong in ("Scenes", "plans"):
        with pytest.raises(AttributeError, match=f"module 'abi' has no attribute '{wrong}'"):
            getattr(abi, wrong)
