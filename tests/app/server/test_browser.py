"""A server beside a browser that keeps whoever opens it waiting, as those of a terminal do."""

from __future__ import annotations

import contextlib
import os
import signal
import stat
import subprocess
import sys
import urllib.error
import urllib.request
import webbrowser
from pathlib import Path

import pytest

from abi.browser import missing_browser
from tests.app.fake_tab import until

_WAITING = "#!/bin/sh\necho opened >> {log}\nexec sleep 600\n"


def _is_ready(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/healthz", timeout=10) as answer:
            return bool(answer.status == 200)
    except urllib.error.HTTPError as error:  # it starts
        error.close()
        return False


@pytest.mark.slow
@pytest.mark.parametrize(("name", "is_opened"), [("w3m", False), ("kiosk", True)])
def test_a_server_works_and_ends_whatever_its_browser_does(
    name: str, is_opened: bool, tmp_path: Path
) -> None:
    browser, log = tmp_path / name, tmp_path / "log"
    browser.write_text(_WAITING.format(log=log))
    browser.chmod(browser.stat().st_mode | stat.S_IXUSR)
    hidden = ("DISPLAY", "WAYLAND_DISPLAY")
    environment = {key: value for key, value in os.environ.items() if key not in hidden}
    with subprocess.Popen(
        [sys.executable, "-m", "app", "serve", "--port", "0"],
        env={**environment, "BROWSER": str(browser), "TERM": "xterm"},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            url = line.partition(" is at ")[2].partition(" ")[0]
            until(lambda: _is_ready(url), 60)
            if is_opened:
                until(log.exists)
            else:
                assert "The browser here, w3m, shows only text." in process.stdout.readline()
                assert not log.exists()
            process.send_signal(signal.SIGTERM)
            assert process.wait(20) == 0
        finally:
            # its browser, too
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def test_no_browser_is_told_of_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> webbrowser.BaseBrowser:
        raise webbrowser.Error("could not locate runnable browser")

    monkeypatch.setattr(webbrowser, "get", none)
    assert missing_browser() == "There is no browser here."
    monkeypatch.setattr(webbrowser, "get", lambda: webbrowser.GenericBrowser("firefox"))
    assert missing_browser() == ""
