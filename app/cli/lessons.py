"""``abi lessons``: checks lessons before a class sees them, and exports them."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import click

from app.cli.exit_code import INCOMPLETE
from app.cli.output import cause, print_text

_LONGEST_WORD = 24
"""Most letters of a heading of one word; the code of any change to a scene has more."""


@click.group(short_help="Check lessons of your own, and take lessons home.")
def lessons() -> None:
    """Check lessons of your own, and take lessons home."""


@lessons.command(short_help="Find everything wrong in a folder of lessons.")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def check(folder: Path) -> None:
    """Go through every page of the lessons in FOLDER, and list all that is wrong with its line.

    Every scene is planned, and each task is done as its "Show me" does it. A line that says "note"
    tells of what may be meant so.

    Exit code 0: nothing is wrong; 3: something is; 2: FOLDER has no lesson.
    """
    from app.state.legend import SWITCHES
    from app.teach.lesson_check import check_folder

    faults = check_folder(folder, {switch.name for switch in SWITCHES})
    wrong = sum(not one.doubtful for one in faults)
    print_text("\n".join([*map(str, faults), f"{wrong} {'fault' if wrong == 1 else 'faults'}."]))
    if wrong:
        raise SystemExit(INCOMPLETE)


@lessons.command(short_help="Write a lesson as a page or for a learning platform.")
@click.argument("name")
@click.option(
    "--to",
    "path",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    help="File to write: .html for one page, .zip for SCORM 1.2.",
)
def export(name: str, path: Path) -> None:
    """Write the lesson NAME so that it works without this server, its quiz included.

    NAME is that of a shipped lesson, such as 03-search, or a lesson file of your own. A page opens
    from a file; a SCORM 1.2 package is what learning platforms import, with the score in percent.
    """
    from abi.atomic_file import replace_file
    from app.teach.lesson_file import lesson_named
    from app.teach.take_home.lesson_page import lesson_page
    from app.teach.take_home.scorm import scorm_package

    ending = path.suffix.lower()
    if ending not in (".html", ".zip"):
        raise click.UsageError(f"--to is {str(path)!r}; expected a file ending in .html or .zip.")
    lesson, file = lesson_named(name)
    content = lesson_page(file.stem, lesson, file.parent)
    if ending == ".zip":
        content = scorm_package(file.stem, lesson.title, content)
    try:
        replace_file(path, content)
    except OSError as error:
        why = cause(error, "not writable")
        raise click.ClickException(f"{str(path)!r} cannot be written ({why}).") from None
    click.echo(f"{path}: {lesson.title}, {len(content):,} bytes")


@lessons.command(short_help="Make the link of a homework.")
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--url", required=True, help="Address of the server, with its token if it has one.")
@click.option(
    "--qr",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the link as a QR code to this file, .svg or .png.",
)
def homework(file: Path, url: str, qr: Path | None) -> None:
    """Print the link that opens the homework in FILE.

    FILE says what to reach, in which scene, and what must stay. Whoever reaches it is shown a code
    to hand in, which abi lessons grade checks.
    """
    from app.teach.homework import homework_link

    link = homework_link(file, url)
    print_text(link)
    if qr is not None:
        _write_qr(link, qr)


def _write_qr(link: str, path: Path) -> None:
    import segno

    if path.suffix.lower() not in (".svg", ".png"):
        raise click.UsageError(f"--qr is {str(path)!r}; expected a file ending in .svg or .png.")
    try:
        segno.make(link, error="l", micro=False).save(str(path), scale=4)
    except segno.DataOverflowError:
        raise click.ClickException(
            f"The link has {len(link):,} characters, too many for a QR code; use a shipped scene, "
            "or fewer changes."
        ) from None
    except OSError as error:
        why = cause(error, "not writable")
        raise click.ClickException(f"{str(path)!r} cannot be written ({why}).") from None


@lessons.command(short_help="Check the codes that students have handed in.")
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("codes", type=click.File(encoding="utf-8-sig"))
def grade(file: Path, codes: TextIO) -> None:
    """Check the codes in CODES of the homework in FILE, each by planning its scene again.

    CODES is CSV, a code in the last column of each line and whose it is in the first, or - for
    standard input. A first line without a code is taken for headings. What is printed is CSV, too.

    Exit code 0: all reach the goal; 3: one does not.
    """
    from app.teach.homework import faults_of

    rows = [row for row in csv.reader(codes) if any(one.strip() for one in row)]
    results = [
        (row[0].strip() if row[1:] else f"line {k}", row[-1]) for k, row in enumerate(rows, 1)
    ]
    if _has_headings(results):
        click.echo(f"Not graded, as its first line has no code: {', '.join(rows[0])}", err=True)
        results = results[1:]
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(("name", "reached", "why not"))
    found = faults_of(file, results)
    for (name, _), faults in zip(results, found, strict=True):
        writer.writerow((name, "no" if faults else "yes", " ".join(faults)))
    print_text(target.getvalue().rstrip())
    if any(found):
        raise SystemExit(INCOMPLETE)


def _has_headings(results: Sequence[tuple[str, str]]) -> bool:
    """Check whether the first of several results is words over a table.

    A code that was copied in part is neither short nor has it blanks.
    """
    from app.teach.result_code import is_whole

    if len(results) < 2 or is_whole(code := results[0][1].strip()):
        return False
    return len(code) <= _LONGEST_WORD or len(code.split()) > 1
