"""``abi serve``: the visualiser in the browser."""

from __future__ import annotations

import functools
import threading
import webbrowser

import click


@click.command()
@click.argument("scene", default="paper")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port", default=8080, show_default=True, type=click.IntRange(0, 65535), help="0: any free."
)
@click.option("--open/--no-open", "open_tab", default=True, help="Open a browser tab.")
@click.option("--dark/--light", default=False, help="How a new tab looks.")
def serve(scene: str, host: str, port: int, open_tab: bool, dark: bool) -> None:
    """Start the visualiser on SCENE (a shipped scene's name or a file) and print its URL."""
    from app.server import start

    announce = functools.partial(_announce, open_tab)
    server = start(host=host, port=port, scene=scene, dark=dark, announce=announce)
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        click.echo()
    finally:
        server.stop()


def _announce(open_tab: bool, url: str) -> None:
    click.echo(f"The ABI visualiser is at {url} (Ctrl+C ends it)")
    if open_tab:
        webbrowser.open(url)
