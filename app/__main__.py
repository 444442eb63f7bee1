"""The ``abi`` command; loads nothing before it can be interrupted."""

from __future__ import annotations

import _thread
import signal
import sys
import threading


def main() -> None:
    """Run the command; Ctrl+C ends it without a traceback, also while it loads."""
    before, sys.unraisablehook = sys.unraisablehook, _interrupt_again
    try:
        from app.cli.command_line import run

        run()
    except KeyboardInterrupt:
        sys.exit(130)
    finally:
        sys.unraisablehook = before


def _interrupt_again(dropped: sys.UnraisableHookArgs) -> None:
    """Interrupt once more where Ctrl+C came during a callback, whose exceptions Python drops.

    Importing a module makes such callbacks. The main thread must have left it by then.
    """
    if issubclass(dropped.exc_type, KeyboardInterrupt):
        again = threading.Timer(0.05, _interrupt)
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(dropped)


def _interrupt() -> None:
    if hasattr(signal, "pthread_kill") and (main_thread := threading.main_thread().ident):
        signal.pthread_kill(main_thread, signal.SIGINT)  # wakes it if it waits
    else:
        _thread.interrupt_main()


if __name__ == "__main__":
    main()
