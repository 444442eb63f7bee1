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

from abi.browser import missing_browser, open_in_background
from tests.app.fake_tab import until

_WAITING = "#!/bin/sh\necho opened >> {log}\nexec /bin/sleep 600\n"


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


def test_no_text_browser_takes_the_terminal_where_the_chosen_one_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "log"
    text = tmp_path / "w3m"
    text.write_text(_WAITING.format(log=log))
    text.chmod(0o755)
    monkeypatch.setattr(webbrowser, "_tryorder", None)
    for name, value in {"BROWSER": "/nowhere/x", "TERM": "xterm", "PATH": str(tmp_path)}.items():
        monkeypatch.setenv(name, value)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    opening = open_in_background("http://127.0.0.1:1")
    opening.join(20)
    assert not opening.is_alive()
    assert not log.exists()
