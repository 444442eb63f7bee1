"""Whether everything that names the version agrees with a tag, and the notes of the release.

    python -m tools.release v1.2.3

Prints the version's section of the changelog.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

from ruamel.yaml import YAML

ROOT = Path(__file__).parents[1]
_HEADING = re.compile(r"^## \[([^]]+)\](?: - (\d{4}-\d\d-\d\d))?$", re.MULTILINE)


def sections(changelog: str) -> dict[str, tuple[str, str]]:
    """Date and text of a changelog's sections by version; empty is the date of what is to come."""
    found = list(_HEADING.finditer(changelog))
    ends = [*(match.start() for match in found[1:]), len(changelog)]
    return {
        match[1]: (match[2] or "", changelog[match.end() : end].strip())
        for match, end in zip(found, ends, strict=True)
    }


def faults(tag: str, root: Path) -> list[str]:
    """What does not agree with a tag, a sentence each.

    Args:
        tag: such as ``v1.2.3``.
        root: folder of the project.
    """
    version = tag.removeprefix("v")
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    date, notes = sections((root / "CHANGELOG.md").read_text(encoding="utf-8")).get(
        version, ("", "")
    )
    cited = YAML(typ="safe").load(root / "CITATION.cff")
    recipe = YAML(typ="safe", pure=True).load(root / "conda" / "recipe.yaml")
    named = {
        "pyproject.toml": project["version"],
        "CITATION.cff": cited["version"],
        "conda/recipe.yaml": recipe["package"]["version"],
    }
    found = [f"{file} has version {one}." for file, one in named.items() if one != version]
    if not tag.startswith("v"):
        found.append(f"The tag {tag} does not begin with v.")
    if not date or not notes:
        found.append(f"CHANGELOG.md has no section [{version}] with a date.")
    elif str(cited.get("date-released")) != date:
        found.append(f"CITATION.cff has no date-released: {date}.")
    return found


def main() -> None:
    """Print the notes, or what is wrong."""
    (tag,) = sys.argv[1:]
    if found := faults(tag, ROOT):
        sys.exit("\n".join(found))
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    print(sections(changelog)[tag.removeprefix("v")][1])


if __name__ == "__main__":
    main()
