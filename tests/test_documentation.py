"""What the documentation names is there, and what a user can set is documented."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from abi.arm_planning.motion_law import LAWS
from abi.export.formats import FORMATS
from abi.obstacles.primitives import PRIMITIVES
from abi.search.search import SEARCHES
from app.cli.export import export
from app.cli.serve import serve
from tools.documented_tables import PAGE, written

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    page.relative_to(ROOT)
    for page in (*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("docs/[mt]*/*.md"))
)
ENDINGS = ("conf", "md", "npz", "py", "toml", "txt", "yaml")
PLACES = [
    ROOT,
    ROOT / "abi",
    ROOT / "abi_sweep",
    ROOT / "app",
    *sorted(path for path in (ROOT / "app").iterdir() if path.is_dir()),
]


def _text(page: Path | str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def _anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", one.lower()).strip().replace(" ", "-") for one in headings}


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_every_relative_link_leads_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", _text(page)):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = (ROOT / page).parent / path if path else ROOT / page
        assert target.exists(), link
        assert not anchor or anchor in _anchors(target), link


def test_every_file_that_the_contributors_page_names_is_there() -> None:
    names = re.findall(r"`([\w./-]*/[\w./-]*\.\w+|\w+\.(?:py|md|yaml))`", _text("CONTRIBUTING.md"))
    assert len(names) > 50
    known = {
        path.name
        for folder in ("abi", "abi_sweep", "app")
        for path in (ROOT / folder).rglob("*.py")
    }
    for name in names:
        if name.startswith(".venv/"):
            continue
        path, _, ending = name.rpartition(".")
        is_file = ending in ENDINGS
        path = name if is_file else f"{path}.py"  # a function of a file, as planner/x.y
        found = [place / path for place in PLACES if (place / path).exists()]
        assert found or path in known, name
        assert is_file or re.search(rf"\b{ending}\b", found[0].read_text(encoding="utf-8")), name


def test_every_way_to_start_the_server_is_documented() -> None:
    readme, hosting = _text("README.md"), _text("docs/hosting.md")
    options = [one for one in serve.params if isinstance(one, click.Option) and not one.hidden]
    for option in options:
        assert all(name in readme for name in (*option.opts, *option.secondary_opts)), option
        assert option.envvar is None or f"`{option.envvar}`" in hosting, option


def test_the_documentation_lists_what_the_tables_have() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert page == written(page), "run make format, which writes docs/scene-and-plan.md anew"
    for name in (*FORMATS, *SEARCHES, *LAWS, *PRIMITIVES):
        assert f"`{name}`" in page


def test_the_command_line_lists_every_format() -> None:
    listed = CliRunner().invoke(export, ["--formats"]).output
    assert [line.split()[0] for line in listed.splitlines()] == list(FORMATS)
