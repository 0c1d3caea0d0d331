"""Progress of the process that compiles kernels, after a first start or an update."""

from __future__ import annotations

from PySide6.QtCore import Qt

from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.widgets.timers import Timers, single_shot

LOOK_MS = 500
NOTE = "Compiling code for other sensors, maps and checks; you can keep working."


class Preparing(Feature):
    """Display of the progress of the compiling process in the status bar until it ends."""

    def __init__(self, bench: Workbench, timers: Timers = single_shot) -> None:
        super().__init__(bench)
        self._strip = bench.status.add_busy("")
        self._strip.setToolTip(NOTE)
        self._timer = timers(self, LOOK_MS, self.show_progress)
        bench.answers.answered.connect(lambda _: self._timer.start(), Qt.ConnectionType.SingleShotConnection)

    def show_progress(self) -> None:
        """Show the steps that are ready, and look again later."""
        progress = self.bench.recompute.compiling()
        if progress is None:
            self._strip.end()
            return
        if not self._strip.is_running:
            self._strip.begin()
        done, total = progress
        self._strip.bar.setRange(0, total)
        self._strip.bar.setValue(done)
        self._strip.bar.setFormat("preparing %v of %m")
        self._strip.left.setText("")
        self._timer.start()
