"""Handle unexpected errors while the window is open: logged, reported once, and the work goes on."""

from __future__ import annotations

import logging
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from logging.handlers import RotatingFileHandler
from pathlib import Path
from types import TracebackType
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal

from riglens.core.shown_text import visible_lines

LOG = "riglens.log"
LOG_BYTES = 500_000


class _Teller(QObject):
    """Bridge that brings a failure of any thread to the interface thread."""

    failed = Signal(str, str)


@contextmanager
def failures_told(told: Any, folder: Path) -> Iterator[None]:
    """Send uncaught exceptions to `told(message, details)` and into a log file while the block runs.

    Ctrl-C keeps its meaning. The log is `folder`/riglens.log, of limited size; without it the rest works.
    """
    teller = _Teller()
    teller.failed.connect(told, Qt.ConnectionType.QueuedConnection)
    logger, handler = logging.getLogger("riglens"), _log_file(folder)
    if handler is not None:
        logger.addHandler(handler)

    def tell(kind: type[BaseException], error: BaseException, where: TracebackType | None) -> None:
        details = "".join(traceback.format_exception(kind, error, where))
        logger.error("unexpected failure\n%s", details)
        print(visible_lines(details), file=sys.stderr, end="")
        log = f" The log is {folder / LOG}." if handler is not None else ""
        message = f"Unexpected failure: {kind.__name__}: {error}. The rig is unchanged; you can save it.{log}"
        teller.failed.emit(message, details)

    def on_exception(kind: type[BaseException], error: BaseException, where: TracebackType | None) -> None:
        if issubclass(kind, Exception):
            tell(kind, error, where)
        else:
            sys.__excepthook__(kind, error, where)

    def in_thread(failure: threading.ExceptHookArgs) -> None:
        if failure.exc_value is not None:
            on_exception(failure.exc_type, failure.exc_value, failure.exc_traceback)

    before, before_in_thread = sys.excepthook, threading.excepthook
    sys.excepthook, threading.excepthook = on_exception, in_thread
    try:
        yield
    finally:
        sys.excepthook, threading.excepthook = before, before_in_thread
        if handler is not None:
            logger.removeHandler(handler)
            handler.close()


def _log_file(folder: Path) -> logging.Handler | None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handler = RotatingFileHandler(folder / LOG, maxBytes=LOG_BYTES, backupCount=1, encoding="utf-8")
    except OSError:
        return None
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s"))
    return handler
