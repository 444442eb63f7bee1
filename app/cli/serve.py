"""``abi serve``: the visualiser in the browser."""

from __future__ import annotations

import contextlib
import functools
import signal
import threading
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode

import click

from abi.browser import missing_browser, open_in_background
from app.guard.policy import MAX_TABS, Policy, policy_for
from app.guard.side_door import SideDoor
from app.process.logs import LEVELS, configure
from app.process.scratch import remove_abandoned
from app.process.unused_memory import load_at_once
from app.server.workers import Workers, are_possible
from app.state.appearance import OPENING, Appearance

if TYPE_CHECKING:
    from app.teach.classroom import Classroom

_PERIOD = 1.0
"""Seconds after which the main thread notices a signal that another thread received."""


@click.command(short_help="Start the visualiser, as abi alone does.")
@click.argument("scene", default=OPENING)
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port",
    default=8080,
    show_default=True,
    type=click.IntRange(0, 65535),
    help="0 takes any free one.",
)
@click.option("--open/--no-open", "open_tab", default=True, help="Open a browser tab.")
@click.option(
    "--dark/--light", default=None, help="Colours of a new tab.  [default: as the system]"
)
@click.option(
    "--demo/--no-demo", default=True, help="Move a new tab's obstacle until the first touch."
)
@click.option(
    "--plain/--no-plain",
    default=None,
    envvar="ABI_PLAIN",
    help="No shadows or reflections; default: where the browser has no graphics card.",
)
@click.option(
    "--lessons",
    type=click.Path(file_okay=False, exists=True, path_type=Path),
    help="Folder with lessons of your own, besides the shipped ones.",
)
@click.option(
    "--classroom", is_flag=True, help="Tabs follow the teacher's link and answer its questions."
)
@click.option(
    "--teach",
    envvar="ABI_TEACH",
    help="Secret of the teacher's link, for --classroom.  [default: a new one]",
)
@click.option(
    "--results",
    type=click.Path(dir_okay=False, path_type=Path),
    help="File for the answers of a class as CSV, which outlast the server, for --classroom.",
)
@click.option(
    "--exercise",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Your file with the functions of exercises; it is checked whenever it is saved.",
)
@click.option(
    "--log-level",
    default="info",
    show_default=True,
    type=click.Choice(LEVELS),
    help="How much is logged.",
)
@click.option(
    "--token", envvar="ABI_TOKEN", help="Secret that visitors need.  [default: a new one]"
)
@click.option(
    "--no-token", is_flag=True, envvar="ABI_NO_TOKEN", help="Let in whoever can reach the server."
)
@click.option(
    "--origin",
    multiple=True,
    envvar="ABI_ORIGIN",
    help="URL under which a proxy shows the server, as browsers see it.",
)
@click.option(
    "--embed-in",
    multiple=True,
    envvar="ABI_EMBED_IN",
    help="URL of a site that may show it in a frame.",
)
@click.option(
    "--max-tabs",
    default=MAX_TABS,
    show_default=True,
    type=click.IntRange(1),
    help="Tabs at the same time.",
)
@click.option(
    "--workers",
    default=1,
    show_default=True,
    type=click.IntRange(1, 64),
    help="Processes that share the tabs, one a core (Linux).",
)
@click.option("--joins", type=click.IntRange(2, 64), hidden=True)
def serve(
    scene: str,
    host: str,
    port: int,
    open_tab: bool,
    dark: bool | None,
    demo: bool,
    plain: bool | None,
    lessons: Path | None,
    classroom: bool,
    teach: str | None,
    results: Path | None,
    exercise: Path | None,
    log_level: str,
    workers: int,
    joins: int | None,
    **visitors: Any,
) -> None:
    """Start the visualiser on SCENE (a shipped scene's name or a file) and print its URL.

    On any address but this machine's own, and with --origin, visitors need a token: it is part of
    the link that is printed.
    """
    load_at_once()
    from app.server.server import start

    ended = threading.Event()
    signal.signal(signal.SIGTERM, functools.partial(_end, ended))
    configure(log_level)
    remove_abandoned()
    policy = _policy(host, **visitors)
    if exercise is not None and workers > 1:
        raise click.UsageError("--exercise needs one process.")
    helpers = _workers(workers, classroom)
    room = _room(teach, policy.token, results) if classroom else None
    announce = functools.partial(_announce, open_tab, room)
    entrance = helpers.porter if joins is None else SideDoor.of_input(ended.set, joins)
    server = start(
        scene,
        host,
        port,
        Appearance(plain, dark, demo),
        policy,
        lessons,
        room,
        exercise,
        # of several processes not all listen yet
        announce if helpers.porter is None else None,
        entrance,
    )
    options = {"plain": plain, "dark": dark, "demo": demo, "lessons": lessons, **visitors}
    place = {"host": host, "port": server.viser.get_port(), "log_level": log_level}
    helpers.start(_arguments(scene, **place, **options), policy.token, server.meet)
    try:
        if helpers.porter is not None:
            helpers.wait(ended)
            announce(server.link)
        # a signal that came to another thread is heard at the next turn
        while not ended.wait(_PERIOD):
            from app.process import metrics  # by now the page has been sent

            metrics.measure_memory()  # for the process that answers for all
    except KeyboardInterrupt:
        click.echo()
    finally:
        server.stop()
        if room is not None:
            room.end()
        helpers.stop()


def _end(ended: threading.Event, number: int, frame: FrameType | None) -> None:
    """Stop as Ctrl+C does: notify the tabs and exit with 0."""
    ended.set()


def _workers(count: int, classroom: bool) -> Workers:
    """The worker processes, not yet started."""
    if count > 1 and classroom:
        raise click.UsageError("--classroom needs one process: its tabs follow each other.")
    if count > 1 and not are_possible():
        raise click.UsageError("--workers needs Linux; elsewhere, put servers behind a proxy.")
    return Workers(count - 1)


def _room(secret: str | None, token: str | None, results: Path | None) -> Classroom:
    """The class that all tabs join; its teacher is whoever has the secret.

    With the same secret, or the same results, it goes on where a server that was killed left it.
    """
    from app.teach.class_file import record_of_secret
    from app.teach.classroom import Classroom

    _check_secret("--teach", secret)
    if secret is not None and secret == token:
        raise click.UsageError("--teach must differ from --token, which all visitors know.")
    file = None
    if results is None and secret is not None:
        with contextlib.suppress(OSError):  # then it ends with this server
            file = record_of_secret(secret)
    return Classroom(secret, file, results)


def _arguments(scene: str, **options: Any) -> list[str]:
    """Arguments of ``abi serve`` for a worker process of this server."""
    dark = {True: ["--dark"], False: ["--light"], None: []}
    plain = {True: ["--plain"], False: ["--no-plain"], None: []}
    words = ["--no-open", *dark[options.pop("dark")], *plain[options.pop("plain")]]
    words.append("--demo" if options.pop("demo") else "--no-demo")
    words += ["--no-token"] if options.pop("no_token") else []
    options.pop("token")  # in its environment, where other users do not see it
    for name, value in options.items():
        values = value if isinstance(value, tuple) else (value,)
        words += [f"--{name.replace('_', '-')}={one}" for one in values if one is not None]
    return [*words, "--", scene]


def _policy(
    host: str,
    token: str | None,
    no_token: bool,
    origin: tuple[str, ...],
    embed_in: tuple[str, ...],
    max_tabs: int,
) -> Policy:
    if token is not None and no_token:
        raise click.UsageError("--token and --no-token exclude each other.")
    _check_secret("--token", token)
    return policy_for(host, token, not no_token, origin, embed_in, max_tabs)


def _check_secret(option: str, text: str | None) -> None:
    if text is not None and not (0 < len(text) <= 200 and text.isprintable()):
        raise click.UsageError(f"{option} must have 1 to 200 characters that can be printed.")


def _announce(open_tab: bool, room: Classroom | None, link: str) -> None:
    click.echo(f"The ABI visualiser is at {link} (Ctrl+C ends it)")
    if room is not None:
        link += f"{'&' if '?' in link else '/?'}{urlencode({'teach': room.secret})}"
        click.echo(f"The teacher's link, for you alone: {link}")
    if open_tab and (reason := missing_browser()):
        click.echo(f"{reason} Open the link in one that runs WebGL, or start with --no-open.")
    elif open_tab:
        open_in_background(link)
