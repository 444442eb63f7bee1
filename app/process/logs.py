"""The log: one event per line on standard error, with its fields as ``name=value``."""

from __future__ import annotations

import contextlib
import logging
import sys
import time
import traceback

LEVELS = ("debug", "info", "warning", "error")
_LOGGERS = ("abi", "app")
_PLAIN = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName"}


class Terminal(logging.Handler):
    """Log handler for whatever standard error is at the time."""

    def format(self, record: logging.LogRecord) -> str:
        """Time, level, logger, event and the fields given as ``extra``.

        Values that come from outside stand in quotes, with every odd letter escaped.
        """
        seconds = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created))
        moment = f"{seconds}.{int(record.msecs):03d}Z"
        event = record.getMessage().encode("unicode_escape").decode()
        fields = [
            f"{name}={_shown(value)}" for name, value in vars(record).items() if name not in _PLAIN
        ]
        line = " ".join((moment, record.levelname, record.name, event, *fields))
        if record.exc_info:
            line += "\n" + "".join(traceback.format_exception(*record.exc_info)).rstrip()
        return line

    def emit(self, record: logging.LogRecord) -> None:
        """Write one line; a closed terminal is ignored."""
        with contextlib.suppress(OSError, ValueError):
            print(self.format(record), file=sys.stderr, flush=True)


_TERMINAL = Terminal()


def configure(level: str) -> None:
    """Log events of ``level``, one of :data:`LEVELS`, and above."""
    root = logging.getLogger()
    root.addHandler(_TERMINAL)  # once, however often
    root.setLevel(logging.WARNING)
    for name in _LOGGERS:
        logging.getLogger(name).setLevel(level.upper())


def _shown(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return ascii(value) if isinstance(value, str) else str(value)
