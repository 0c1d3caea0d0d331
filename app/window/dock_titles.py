"""Titles of docks: a dock among tabs is named by its tab, so it has a title bar only when it stands alone."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget


class DockTitles:
    """Shows and hides the title bars of a window's docks as they come together and part."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self._docks: list[QDockWidget] = []
        self._later = QTimer(window, singleShot=True, interval=0)  # not in the midst of a drag's events
        self._later.timeout.connect(self.update)

    def follow(self, dock: QDockWidget) -> None:
        """Look after one more dock."""
        self._docks.append(dock)
        for moved in (dock.visibilityChanged, dock.topLevelChanged, dock.dockLocationChanged):
            moved.connect(lambda _: self._later.start())
        dock.toggleViewAction().toggled.connect(lambda _: self._later.start())

    def update(self) -> None:
        """Bring all title bars in line with where the docks are now."""
        for dock in self._docks:
            has_bar = dock.titleBarWidget() is None
            if has_bar == self._is_among_tabs(dock):
                self._show_bar(dock, not has_bar)

    def _is_among_tabs(self, dock: QDockWidget) -> bool:
        beside = self._window.tabifiedDockWidgets(dock)
        return not dock.isFloating() and any(not other.isHidden() for other in beside)

    def _show_bar(self, dock: QDockWidget, shown: bool) -> None:
        empty = dock.titleBarWidget()
        dock.setTitleBarWidget(None if shown else QWidget(dock))  # type: ignore[arg-type]
        if empty is not None:
            empty.deleteLater()
