"""Write what the documentation lists of the code's tables: shapes, searches, laws and formats.

    python -m tools.documented_tables

``make format`` runs it, and a test says what it would change.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from abi.arm_planning.motion_law import LAWS
from abi.export.formats import FORMATS
from abi.obstacles.primitives import PRIMITIVES
from abi.scene.lattices import LATTICES
from abi.search.search import SEARCHES

PAGE = Path(__file__).parents[1] / "docs" / "scene-and-plan.md"


def written(page: str) -> str:
    """The page with its lists as the tables are now.

    Choices of a setting stand in its row up to the first full stop, and tables between comments.
    """
    laws = "; ".join(f"`{name}`: {one.meaning}" for name, one in LAWS.items())
    choices = {
        "mesh.lattice": _either(LATTICES),
        "search.algorithm": _either(SEARCHES),
        "motion.law": laws,
    }
    for field, text in choices.items():
        row = rf"^(\| `{re.escape(field)}` \| [^|]* \| ).*?(?=\. | \|$)"
        page = re.sub(row, rf"\g<1>{text}", page, flags=re.MULTILINE)
    for name, rows in (("shapes", _shapes()), ("formats", _formats())):
        first, last = f"<!-- {name}: tools/documented_tables.py -->\n", "<!-- end -->"
        table = first + "\n".join([*rows, last])
        page = re.sub(f"{first}.*?{last}", lambda _, table=table: table, page, flags=re.DOTALL)
    return page


def _either(names: Iterable[str]) -> str:
    *first, last = (f"`{name}`" for name in names)
    return f"{', '.join(first)} or {last}"


def _shapes() -> list[str]:
    """A row for each shape: its name, its sizes, and the first sentence on its class."""
    rows = ["| `shape` | Fields for its size | Meaning |", "|---|---|---|"]
    for name, kind in PRIMITIVES.items():
        sizes = [size for size in kind.model_fields if size not in ("shape", "position", "wxyz")]
        text = (kind.__doc__ or "").splitlines()[0].replace("``", "`")
        rows.append(f"| `{name}` | {', '.join(f'`{size}`' for size in sizes)} | {text} |")
    return rows


def _formats() -> list[str]:
    rows = ["| Format | Ending | Contents |", "|---|---|---|"]
    for name, one in FORMATS.items():
        endings = ", ".join(f"`{ending}`" for ending in one.endings)
        ending = endings or f"`.{one.file.partition('.')[2]}`"
        rows.append(f"| `{name}` | {ending} | {one.label} |")
    return rows


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
