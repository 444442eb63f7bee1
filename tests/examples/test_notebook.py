from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).parents[2] / "examples" / "notebook" / "tour.ipynb"


@pytest.mark.slow
def test_runs_from_top_to_bottom_and_shows_numbers_and_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # a grammar of addresses, which takes a second to build and no notebook needs
    monkeypatch.setitem(sys.modules, "rfc3987_syntax", None)
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()

    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert [one for one in outputs if one.get("name") == "stderr"] == []
    assert sum("image/png" in one.get("data", {}) for one in outputs) == 2
    lengths = [one["text"] for one in outputs if "nodes expanded" in one.get("text", "")]
    assert lengths[0].count("cm") == 3


def test_is_stored_without_results() -> None:
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]

    assert all(not cell["outputs"] for cell in cells if cell["cell_type"] == "code")
