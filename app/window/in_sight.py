"""Whether anybody sees a dock: not closed, and not behind other tabs; pulled out of the window it is seen."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QDockWidget


class InSight(QObject):
    """Follows one dock. Qt's own `visibilityChanged` says False of a tab that was pulled out of the window."""

    changed = Signal(bool)

    def __init__(self, dock: QDockWidget) -> None:
        super().__init__(dock)
        self._dock = dock
        self._is_seen = False
        self._later = QTimer(self, singleShot=True, interval=0)  # when docks are where they are going to be
        self._later.timeout.connect(self._look)
        for moved in (dock.visibilityChanged, dock.topLevelChanged, dock.dockLocationChanged):
            moved.connect(self._on_moved)

    def __bool__(self) -> bool:
        return self._is_seen

    def _on_moved(self, _: object) -> None:
        self._look()
        self._later.start()

    def _look(self) -> None:
        """Docks behind other tabs are not hidden: Qt puts them where nothing of them is seen."""
        is_seen = not self._dock.widget().visibleRegion().isEmpty()
        if is_seen != self._is_seen:
            self._is_seen = is_seen
            self.changed.emit(is_seen)
