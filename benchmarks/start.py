"""From the command to the first drawn plan: the first time on a machine, and after that.

    python -m benchmarks.start

Each start is a process of its own: the command, a page in a Chromium that runs already, until the
paper's curve is drawn. The first start finds neither compiled kernels nor compiled Python. Beside
it stands what the viewer's library takes for a page with nothing but one line.
"""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from typing import Any

from playwright.sync_api import Browser
from playwright.sync_api import Error as PageError

from benchmarks.browser import chromium

_PATIENCE = 120.0
_ONE_LINE = """
import sys, threading, numpy, viser
server = viser.ViserServer(port=int(sys.argv[1]), verbose=False)
server.on_client_connect(lambda client: client.scene.add_line_segments(
    "/curve/bspline", numpy.ones((1, 2, 3)), (255, 0, 0)))
threading.Event().wait()
"""
_DRAWN = (
    "() => !!window.__viserSceneTree?.getState()['/curve/bspline']?.message.props.points?.length"
)


def measure(browser: Browser, warm_starts: int = 3) -> dict[str, Any]:
    """Start the visualiser again and again.

    Returns:
        ``cold_s`` of the first start and the best ``warm_s`` of those after it, from the command to
        the drawn plan; ``one_line_s``, the best of a page with one line.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {
            "NUMBA_CACHE_DIR": f"{cache}/kernels",
            "PYTHONPYCACHEPREFIX": f"{cache}/python",
        }
        serve = ["-m", "app", "serve", "--no-open", "--port"]
        cold = _start(browser, serve, environment)
        # Once more, until the kernels that compiled in the background are all kept.
        _compile(environment)
        warm = min(_start(browser, serve, environment) for _ in range(warm_starts))
        line = ["-c", _ONE_LINE]
        one_line = min(_start(browser, line, environment) for _ in range(warm_starts))
    return {"cold_s": cold, "warm_s": warm, "one_line_s": one_line}


def _compile(environment: dict[str, str]) -> None:
    code = "from abi.kernels import warm; warm()"
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)


def _start(browser: Browser, arguments: list[str], environment: dict[str, str]) -> float:
    """Seconds from the command, Python with these arguments and a port, to the drawn curve."""
    with closing(socket.socket()) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, *arguments, str(port)]
    tab = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
    begin = time.monotonic()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    try:
        _open(tab, f"http://127.0.0.1:{port}", begin)
        tab.wait_for_function(_DRAWN, timeout=1e3 * _PATIENCE)
        return time.monotonic() - begin
    finally:
        tab.context.close()
        process.terminate()
        process.wait()


def _open(tab: Any, address: str, begin: float) -> None:
    """Open the page as soon as there is one."""
    while True:
        try:
            tab.goto(address)
            return
        except PageError:
            if time.monotonic() - begin > _PATIENCE:
                raise
            tab.wait_for_timeout(20)


def main() -> None:
    """Measure and print."""
    with chromium() as browser:
        print(json.dumps(measure(browser)), flush=True)


if __name__ == "__main__":
    main()
