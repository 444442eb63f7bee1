"""Time from the command to the first drawn plan: the first time on a machine, and after that.

    python -m benchmarks.start

Each start is a process of its own: the command, a page in a Chromium that runs already, until the
paper's curve is drawn, and until the arm stands beside it. The first start finds neither compiled
kernels nor compiled Python. Beside it stands what the viewer's library takes for a page with
nothing but one line.
"""

from __future__ import annotations

import json
import os
import socket
import statistics
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
_WITH_ARM = (
    "() => Object.keys(window.__viserSceneTree.getState())"
    ".some(name => name.startsWith('/arm/links') && name.endsWith('/mesh'))"
)


def measure(browser: Browser, warm_starts: int = 5) -> dict[str, Any]:
    """Start the visualiser several times.

    Returns:
        From the command to the drawn curve: ``cold_s`` of the first start, ``warm_s`` of those
        after it; ``arm_s`` of these to the drawn arm; ``one_line_s`` of a page with one line. All
        but the first are medians.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {
            "NUMBA_CACHE_DIR": f"{cache}/kernels",
            "PYTHONPYCACHEPREFIX": f"{cache}/python",
            "PYTHONDONTWRITEBYTECODE": "",
        }
        serve = ["-m", "app", "serve", "--no-open", "--port"]
        cold, _ = _start(browser, serve, environment)
        # until all kernels are in the cache
        _compile(environment)
        starts = [_start(browser, serve, environment) for _ in range(warm_starts)]
        warm, with_arm = map(statistics.median, zip(*starts, strict=True))
        line = ["-c", _ONE_LINE]
        lines = [_start(browser, line, environment, _DRAWN)[0] for _ in range(warm_starts)]
    one_line = statistics.median(lines)
    return {"cold_s": cold, "warm_s": warm, "arm_s": with_arm, "one_line_s": one_line}


def _compile(environment: dict[str, str]) -> None:
    code = "import abi; abi.compile()"
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)


def _start(
    browser: Browser, arguments: list[str], environment: dict[str, str], last: str = _WITH_ARM
) -> tuple[float, float]:
    """Seconds from Python with these arguments and a port to the drawn curve, and to ``last``.

    ``last`` is a condition in the page.
    """
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
        drawn = time.monotonic() - begin
        tab.wait_for_function(last, timeout=1e3 * _PATIENCE)
        return drawn, time.monotonic() - begin
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
