"""``abi lessons``: lessons are checked before a class sees them."""

from __future__ import annotations

from pathlib import Path

import click

from app.cli.exit_code import INCOMPLETE
from app.cli.output import print_text


@click.group(short_help="Check lessons of your own.")
def lessons() -> None:
    """Work with lessons of your own."""


@lessons.command(short_help="Find everything wrong in a folder of lessons.")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def check(folder: Path) -> None:
    """Go through every page of the lessons in FOLDER, and list all that is wrong with its line.

    Every scene is planned, and each task is done as its "Show me" does it. A line that says "note"
    tells of what may be meant so.

    Exit code 0: nothing is wrong; 3: something is; 2: FOLDER has no lesson.
    """
    from app.tab.view import SWITCHES
    from app.teach.lesson_check import check_folder

    faults = check_folder(folder, {switch.name for switch in SWITCHES})
    wrong = sum(not one.doubtful for one in faults)
    print_text("\n".join([*map(str, faults), f"{wrong} {'fault' if wrong == 1 else 'faults'}."]))
    if wrong:
        raise SystemExit(INCOMPLETE)
