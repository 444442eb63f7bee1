"""What a release checks, and what a change has to say."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tools.release import faults, sections

ROOT = Path(__file__).parents[1]
CHANGES = (
    "# Changelog\n\n## [Unreleased]\n\n- One.\n\n## [0.1.0] - 2026-01-31\n\n- Two.\n- Three.\n"
)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """The files that name the version, agreeing on 0.1.0."""
    texts = {
        "pyproject.toml": '[project]\nversion = "0.1.0"\n',
        "CITATION.cff": "version: 0.1.0\ndate-released: 2026-01-31\n",
        "CHANGELOG.md": CHANGES,
        "conda/recipe.yaml": "package:\n  version: 0.1.0\n",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_sections_have_their_dates_and_texts() -> None:
    assert sections(CHANGES) == {
        "Unreleased": ("", "- One."),
        "0.1.0": ("2026-01-31", "- Two.\n- Three."),
    }


def test_the_changelog_begins_with_what_is_not_released() -> None:
    found = sections((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    assert next(iter(found)) == "Unreleased"
    assert all(date for version, (date, _) in found.items() if version != "Unreleased")


def test_a_tag_fits_where_all_files_name_it(project: Path) -> None:
    assert faults("v0.1.0", project) == []
    assert faults("0.1.0", project) == ["The tag 0.1.0 does not begin with v."]
    assert len(faults("v0.2.0", project)) == 4


@pytest.mark.parametrize(
    ("name", "old", "new", "fault"),
    [
        ("pyproject.toml", 'version = "0.1.0"', 'version = "0.1.1"', "has version 0.1.1"),
        ("conda/recipe.yaml", "version: 0.1.0", "version: 0.0.9", "has version 0.0.9"),
        ("CITATION.cff", "version: 0.1.0", "version: 0.2.0", "has version 0.2.0"),
        ("CITATION.cff", "2026-01-31", "2026-01-30", "no date-released: 2026-01-31"),
        ("CHANGELOG.md", " - 2026-01-31", "", "no section [0.1.0] with a date"),
    ],
)
def test_whatever_does_not_fit_is_named(
    project: Path, name: str, old: str, new: str, fault: str
) -> None:
    text = (project / name).read_text(encoding="utf-8")
    assert old in text
    (project / name).write_text(text.replace(old, new), encoding="utf-8")
    (found,) = faults("v0.1.0", project)
    assert found.startswith(name)
    assert fault in found


class History:
    """A repository whose branch differs from its base."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.git("init", "--quiet", "--initial-branch", "base")
        self.commit("First", "CHANGELOG.md", CHANGES)
        self.git("switch", "--quiet", "--create", "branch")

    def git(self, *arguments: str) -> None:
        who = ("-c", "user.name=A", "-c", "user.email=a@example.org")
        subprocess.run(["git", *who, *arguments], cwd=self._folder, check=True)

    def commit(self, message: str, name: str, text: str) -> None:
        (self._folder / name).parent.mkdir(exist_ok=True)
        (self._folder / name).write_text(text, encoding="utf-8")
        self.git("add", name)
        self.git("commit", "--quiet", "--message", message)

    def said(self) -> tuple[bool, str]:
        """Whether the check passes, and what it says."""
        run = subprocess.run(
            [ROOT / "tools" / "changelog", "base"],
            cwd=self._folder,
            capture_output=True,
            text=True,
            check=False,
        )
        return run.returncode == 0, run.stderr


class TestChangelog:
    def test_a_change_without_a_line_is_refused_until_it_has_one(self, tmp_path: Path) -> None:
        history = History(tmp_path)
        history.commit("Plan backwards", "abi/plan.py", "1\n")
        passed, sentence = history.said()
        assert not passed
        assert "Plan backwards" in sentence
        history.commit("Say so", "CHANGELOG.md", CHANGES.replace("One.", "One.\n- Four."))
        assert history.said() == (True, "")

    def test_a_removed_line_does_not_count(self, tmp_path: Path) -> None:
        history = History(tmp_path)
        history.commit("Plan backwards", "abi/plan.py", "1\n")
        history.commit("Say less", "CHANGELOG.md", CHANGES.replace("- Three.\n", ""))
        assert not history.said()[0]

    def test_what_no_user_sees_needs_no_line(self, tmp_path: Path) -> None:
        history = History(tmp_path)
        history.commit("Test more", "tests/test_plan.py", "1\n")
        history.commit("Move a function\n\nChangelog: none", "abi/plan.py", "1\n")
        assert history.said() == (True, "")
