from __future__ import annotations

import tomllib
from pathlib import Path

from ruamel.yaml import YAML

ROOT = Path(__file__).parents[1]


def test_it_names_the_version_and_the_licence_of_the_package() -> None:
    cited = YAML(typ="safe").load(ROOT / "CITATION.cff")

    package = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (cited["version"], cited["license"]) == (package["version"], package["license"])
