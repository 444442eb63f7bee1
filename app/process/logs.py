"""The log: one event per line on standard error, with its fields as ``name=value``."""

from __future__ import annotations

import contextlib
import logging
import sys
import time

LEVELS = ("debug", "info", "warning", "error")
_LOGGERS = ("abi", "app")
_PLAIN = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName"}


class _Fields(logging.Formatter):
    """Log format: time, level, logger, event and the fields given as ``extra``.

    Values that come from outside stand in quotes, with every odd letter escaped.
    """

    def format(self, record: logging.LogRecord) -> str:
        seconds = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created))
        moment = f"{seconds}.{int(record.msecs):03d}Z"
        event = record.getMessage().encode("unicode_escape").decode()
        fields = [
            f"{name}={_shown(value)}" for name, value in vars(record).items() if name not in _PLAIN
        ]
        line = " ".join((moment, record.levelname, record.name, event, *fields))
        return f"{line}\n{self.formatException(record.exc_info)}" if record.exc_info else line


class _Terminal(logging.Handler):
    """Log handler for whatever standard error is at the time."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write one line; a closed terminal is ignored."""
        with contextlib.suppress(OSError, ValueError):
            print(self.format(record), file=sys.stderr, flush=True)


_TERMINAL = _Terminal()
_TERMINAL.setFormatter(_Fields())


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
