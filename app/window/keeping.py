"""Writes what features keep soon after it changed: a crash or a kill loses none of it."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QEvent, QObject

from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.widgets.timers import Timers, single_shot

DELAY_MS = 500
"""Changes within this time are written together: a resized window changes with every mouse move."""
_WINDOW_EVENTS = (QEvent.Type.Resize, QEvent.Type.Move, QEvent.Type.WindowStateChange)


class Keeping(QObject):
    """Observer of the window, its docks and actions that makes every feature write its settings.

    What is not heard of, such as a turn of the camera, is written with the next thing that is, or at the end.
    """

    def __init__(self, bench: Workbench, features: Iterable[Feature], timers: Timers = single_shot) -> None:
        super().__init__(bench)
        self._bench, self._features = bench, tuple(features)
        self._later = timers(self, DELAY_MS, self.keep)
        for action in bench.actions:
            action.triggered.connect(self._note)
        for dock in bench.docks:
            dock.dockLocationChanged.connect(self._note)
            dock.topLevelChanged.connect(self._note)
            dock.visibilityChanged.connect(self._note)
            dock.installEventFilter(self)
        bench.session.heat_changed.connect(self._note)
        bench.panels.inspector.units_changed.connect(self._note)
        bench.window.installEventFilter(self)
        bench.closing.connect(self._later.stop)

    def keep(self) -> None:
        """Write everything now; unchanged values cost no write."""
        for feature in self._features:
            feature.keep(self._bench.kept)
        self._bench.kept.sync()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() in _WINDOW_EVENTS:
            self._note()
        return super().eventFilter(watched, event)

    def _note(self, *_: object) -> None:
        self._later.start()
