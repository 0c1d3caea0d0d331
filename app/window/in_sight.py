"""Whether anybody sees a dock: not closed, and not behind other tabs; pulled out of the window it is seen."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QApplication, QDockWidget, QWidget


def is_in_sight(dock: QDockWidget) -> bool:
    """Docks behind other tabs are not hidden: Qt puts them where nothing of them is seen."""
    return not dock.widget().visibleRegion().isEmpty()


def focus_next_in_sight(step: Callable[[], bool]) -> bool:
    """Let Tab pass over docks that nobody sees; `step` gives the focus to the next widget, False when there is none."""
    first = QApplication.focusWidget()
    while step():
        focus = QApplication.focusWidget()
        if focus is None or focus is first or _is_seen(focus):
            return True
    return False


def _is_seen(widget: QWidget) -> bool:
    """Whether a widget is in no dock, or in one that is in sight."""
    parent: QWidget | None = widget
    while parent is not None and not isinstance(parent, QDockWidget):
        parent = parent.parentWidget()
    return parent is None or is_in_sight(parent)


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
        is_seen = is_in_sight(self._dock)
        if is_seen != self._is_seen:
            self._is_seen = is_seen
            self.changed.emit(is_seen)
