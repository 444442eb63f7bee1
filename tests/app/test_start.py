"""What the command waits for before there is a page to load."""

from __future__ import annotations

import json
import subprocess
import sys

_LATE = ("numba", "scipy", "trimesh", "networkx", "yourdfpy", "pydantic")
_CODE = """
import json, sys
import app.__main__, app.server
print(json.dumps(sorted({name.partition(".")[0] for name in sys.modules})))
"""


def test_the_port_opens_before_the_method_is_loaded() -> None:
    run = subprocess.run([sys.executable, "-c", _CODE], capture_output=True, text=True, check=True)
    loaded = json.loads(run.stdout)
    assert "viser" in loaded
    assert [name for name in _LATE if name in loaded] == []


def test_the_public_names_are_there_when_they_are_asked_for() -> None:
    code = "import abi; print([getattr(abi, name).__name__ for name in abi.__all__], dir(abi))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "load_scene" in run.stdout
    for wrong in ("Scenes", "plans"):
        run = subprocess.run(
            [sys.executable, "-c", f"import abi; abi.{wrong}"], capture_output=True, text=True
        )
        assert f"module 'abi' has no attribute '{wrong}'" in run.stderr
