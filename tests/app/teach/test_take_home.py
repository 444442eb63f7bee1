from __future__ import annotations

import io
import json
import re
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree

from app.cli.command_line import cli
from app.teach.lesson_file import lesson_named
from app.teach.take_home.lesson_page import lesson_page
from app.teach.take_home.scorm import manifest, scorm_package

_CP = "{http://www.imsproject.org/xsd/imscp_rootv1p1p2}"
_ADL = "{http://www.adlnet.org/xsd/adlcp_rootv1p2}"
_XSI = "{http://www.w3.org/2001/XMLSchema-instance}"
_STRUCTURE = {
    "manifest": ("metadata organizations resources", "identifier", "version"),
    "metadata": ("schema schemaversion", "", ""),
    "schema": ("", "", ""),
    "schemaversion": ("", "", ""),
    "organizations": ("organization", "default", ""),
    "organization": ("title item", "identifier", "structure"),
    "title": ("", "", ""),
    "item": ("title", "identifier", "identifierref isvisible parameters"),
    "resources": ("resource", "", ""),
    "resource": ("file", f"identifier type {_ADL}scormtype", "href"),
    "file": ("", "href", ""),
}
"""Of each element: children in their order, attributes that SCORM 1.2 requires, and others.

From ``imscp_rootv1p1p2.xsd`` and ``adlcp_rootv1p2.xsd``, as far as a package of one page goes.
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    file = tmp_path_factory.mktemp("scorm") / "lesson.zip"
    run = CliRunner().invoke(cli, ["lessons", "export", "10-optimal", "--to", str(file)])
    assert run.exit_code == 0, run.output
    return zipfile.ZipFile(io.BytesIO(file.read_bytes()))


def test_a_manifest_has_the_structure_that_the_schemas_ask_for(
    package: zipfile.ZipFile,
) -> None:
    root = etree.fromstring(package.read("imsmanifest.xml"))
    for element in root.iter():
        name = element.tag.removeprefix(_CP)
        children, required, optional = _STRUCTURE[name]
        found = [one.tag.removeprefix(_CP) for one in element]
        assert found == [one for one in children.split() if one in found]
        attributes = {key for key in element.attrib if not key.startswith(_XSI)}
        assert set(required.split()) <= attributes <= {*required.split(), *optional.split()}


def test_a_package_has_what_its_manifest_lists(package: zipfile.ZipFile) -> None:
    root = etree.fromstring(package.read("imsmanifest.xml"))
    assert [one.text for one in root[0]] == ["ADL SCORM", "1.2"]
    identifiers = [one.get("identifier") for one in root.iter() if one.get("identifier")]
    assert len(set(identifiers)) == len(identifiers)
    organizations = root.find(f"{_CP}organizations")
    assert organizations is not None
    assert organizations.get("default") == organizations[0].get("identifier")
    item = organizations[0].find(f"{_CP}item")
    assert item is not None
    resource = root.find(f"{_CP}resources/{_CP}resource[@identifier='{item.get('identifierref')}']")
    assert resource is not None
    assert (resource.get("type"), resource.get(f"{_ADL}scormtype")) == ("webcontent", "sco")
    files = [one.get("href") for one in resource.iter(f"{_CP}file")]
    assert resource.get("href") in files
    assert {*files, "imsmanifest.xml"} == set(package.namelist())


def test_a_page_asks_for_nothing_from_elsewhere_and_has_all_of_the_lesson(
    package: zipfile.ZipFile,
) -> None:
    page = package.read("index.html").decode()
    names = ("http://www.w3.org/1998/Math/MathML",)
    assert set(re.findall(r"https?://[^\s\"'<>\\]+", page)) <= set(names)
    assert not re.search(r"\b(src|href)=", page)
    found = re.search(r'<script id="plan" type="application/json">(.*?)</script>', page, re.S)
    assert found is not None
    data = json.loads(found[1])
    lesson, _ = lesson_named("10-optimal")
    assert len(data["pages"]) == len(lesson.steps)
    for page_data, step in zip(data["pages"], lesson.steps, strict=True):
        assert len(page_data["choices"]) == len(step.question.choices if step.question else ())
        assert "{{" not in json.dumps(page_data)
        for view in (page_data["before"], page_data["revealed"]):
            assert 0 <= view["plan"] < len(data["plans"])


@settings(max_examples=25)
@given(name=st.text(min_size=1), title=st.text(min_size=1))
def test_names_and_titles_of_any_letters_make_a_manifest(name: str, title: str) -> None:
    root = etree.fromstring(manifest(name, title))
    written = "".join(one if one.isprintable() else " " for one in title)
    assert [one.text for one in root.iter(f"{_CP}title")] == [written, written]
    assert re.fullmatch(r"[A-Za-z_][A-Za-z0-9_.-]*", str(root.get("identifier")))


def test_the_same_lesson_gives_the_same_package() -> None:
    assert scorm_package("a", "b", b"c") == scorm_package("a", "b", b"c")


def test_a_lesson_of_ones_own_is_taken_home_with_its_scene(tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("version: 1\nmesh: {pitch: 3}\n", encoding="utf-8")
    text = "title: Mine\nsteps: [{text: 'Nodes {{mesh.nodes}}', set: {scene: own.yaml}}]\n"
    (tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    lesson, file = lesson_named(str(tmp_path / "mine.yaml"))
    assert b"Nodes " in lesson_page(file.stem, lesson, file.parent)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nothing", "--to", "a.html"], "There is no lesson 'nothing'; expected a file, or one of"),
        (["01-mesh", "--to", "a.pdf"], "expected a file ending in .html or .zip"),
    ],
)
def test_what_cannot_be_written_is_told(arguments: list[str], told: str) -> None:
    run = CliRunner().invoke(cli, ["lessons", "export", *arguments])
    assert told in f"{run.output}{run.exception}"
