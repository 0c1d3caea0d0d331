"""Long work of all features: a strip in the status bar for each, and what went wrong in the message bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.background.tasks import Task
from riglens.app.window.feature import Feature

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Background(Feature):
    """Shows what `window.tasks` runs; closing the window gives it up."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        window.tasks.started.connect(self._show)
        window.tasks.failed.connect(window.report_error)
        window.closing.connect(window.tasks.close)

    def _show(self, task: Task) -> None:
        queued = Qt.ConnectionType.QueuedConnection
        strip = self.window.status.add_strip(task.title)
        strip.cancelled.connect(task.cancel)
        task.progressed.connect(strip.show_progress, queued)
        task.ended.connect(strip.end, queued)
        task.ended.connect(strip.deleteLater, queued)
        strip.begin()
