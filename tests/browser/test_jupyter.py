"""The page through Jupyter's server, by jupyter-server-proxy, as in JupyterLab and JupyterHub."""

from __future__ import annotations

import http.client
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from tests.app.fake_tab import until
from tests.browser.page import Page
from tests.ports import free_port
from tests.thorough import THOROUGH

SECRET = "of Jupyter"


@pytest.fixture
def jupyter(tmp_path: Path) -> Iterator[int]:
    """Port of a Jupyter server that knows nothing but what is installed."""
    port = free_port()
    folders = {
        f"JUPYTER_{name}_DIR": str(tmp_path / name) for name in ("CONFIG", "DATA", "RUNTIME")
    }
    options = {
        "ServerApp.port": port,
        "ServerApp.port_retries": 0,
        "ServerApp.open_browser": False,
        "ServerApp.allow_root": True,
        "ServerApp.root_dir": tmp_path,
        "IdentityProvider.token": SECRET,
    }
    # a grammar of addresses, which takes seconds to build and this server does not need
    (tmp_path / "rfc3987_syntax.py").write_text("raise ImportError")
    process = subprocess.Popen(
        [sys.executable, "-m", "jupyter_server", *(f"--{k}={v}" for k, v in options.items())],
        env={**os.environ, **folders, "ABI_PLAIN": "1", "PYTHONPATH": str(tmp_path)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    until(lambda: _answer(port, "/api") is not None)
    yield port
    process.terminate()
    process.wait(timeout=60)


def _answer(port: int, path: str, token: str = SECRET) -> tuple[int, str] | None:
    """Status and text of a page; None where nobody answers."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    with closing(connection), suppress(OSError):
        connection.request("GET", path, headers={"Authorization": f"token {token}"})
        response = connection.getresponse()
        return response.status, response.read().decode()
    return None


@pytest.mark.skipif(not THOROUGH, reason="test_hosting shows the page behind another proxy")
def test_jupyter_has_a_tile_and_shows_the_page(chromium: Browser, jupyter: int) -> None:
    answer = _answer(jupyter, "/server-proxy/servers-info")
    assert answer is not None
    (tile,) = (one for one in json.loads(answer[1])["server_processes"] if one["name"] == "abi")
    assert tile["launcher_entry"]["enabled"]
    assert tile["launcher_entry"]["title"] == "ABI visualiser"
    refused = _answer(jupyter, "/abi/", "wrong")
    assert refused is not None
    assert refused[0] != 200

    path = tile["launcher_entry"]["path_info"]
    page = Page(chromium, f"http://127.0.0.1:{jupyter}/{path}?token={SECRET}")
    for name in ("/obstacle_1", "/curve/bspline"):
        page.node(name)
    before = page.points("/curve/bspline")
    page.set_number("degree", 2)
    page.until(lambda: not np.array_equal(page.points("/curve/bspline"), before), "another curve")
    assert page.errors == []
    page.close()
