"""Docks around the view: their titles, the actions that raise them, and whether they are visible."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from PySide6.QtCore import QObject, Qt, QTimer, Signal, SignalInstance
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QWidget

from riglens.app.window.actions import Actions, Spec
from riglens.app.window.places import Places

Area = Qt.DockWidgetArea


class Docks:
    """The docks of a window by title, in the order in which they were added."""

    def __init__(self, window: QMainWindow, actions: Actions, places: Places) -> None:
        self._window = window
        self._menu = places.add_submenu("view/docks", "Panels")
        self._actions = actions
        self._titles = DockTitles(window)
        self._docks: dict[str, QDockWidget] = {}

    def __getitem__(self, title: str) -> QDockWidget:
        return self._docks[title]

    def __iter__(self) -> Iterator[QDockWidget]:
        return iter(self._docks.values())

    def add(self, title: str, content: QWidget, area: Area, beside: str | None = None) -> QDockWidget:
        """Add a dock that can be closed and reopened by the View menu; `beside` makes it a tab of another dock."""
        dock = QDockWidget(title, self._window)
        dock.setObjectName(title)
        dock.setWidget(content)
        self._window.addDockWidget(area, dock)
        self._docks[title] = dock
        self._titles.follow(dock)
        spec = dock_spec(title, len(self._docks))
        self._actions.add((spec,))
        self._menu.addAction(self._actions[spec.key])
        self._actions.bind(**{spec.key: partial(self.bring_up, title)})
        if beside is not None:
            self._window.tabifyDockWidget(self._docks[beside], dock)
            self._docks[beside].raise_()
        return dock

    def bring_up(self, title: str) -> None:
        """Show a dock in front of other tabs."""
        self._docks[title].show()
        self._docks[title].raise_()


def dock_spec(title: str, number: int) -> Spec:
    """Return the action of the dock with that number; the tenth one has the key 0, later ones have none."""
    key = f"Ctrl+{number % 10}" if number <= 10 else ""
    return Spec(f"dock_{title}", title, f"Bring the panel {title} to the front.", key, menu="view")


class DockTitles:
    """Title bars of docks, hidden among tabs and shown otherwise: a dock among tabs is named by its tab."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self._docks: list[QDockWidget] = []
        self._later = QTimer(window, singleShot=True, interval=0)  # not in the midst of a drag's events
        self._later.timeout.connect(self.update)

    def follow(self, dock: QDockWidget) -> None:
        """Add a dock to those managed."""
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


# ---------------------------------------------------------------------- in sight
def is_in_sight(dock: QDockWidget) -> bool:
    """Return whether a dock is visible. Qt does not call one behind other tabs hidden, but moves it out of view."""
    around = dock.parentWidget()
    is_within = around is None or dock.isWindow() or around.rect().intersects(dock.geometry())
    return dock.isVisible() and is_within


def focus_next_in_sight(step: Callable[[], bool]) -> bool:
    """Make Tab skip invisible docks; `step` gives the focus to the next widget, False when there is none."""
    first = QApplication.focusWidget()
    while step():
        focus = QApplication.focusWidget()
        if focus is None or focus is first or _is_seen(focus):
            return True
    return False


def _is_seen(widget: QWidget) -> bool:
    """Return whether a widget is in no dock, or in one that is in sight."""
    parent: QWidget | None = widget
    while parent is not None and not isinstance(parent, QDockWidget):
        parent = parent.parentWidget()
    return parent is None or is_in_sight(parent)


class InSight(QObject):
    """Visibility of one dock, or of one page in it. Qt's own `visibilityChanged` is False for a tab that was pulled out
    of the window."""

    changed = Signal(bool)

    def __init__(self, dock: QDockWidget, page: QWidget | None = None) -> None:
        super().__init__(dock)
        self._dock, self._page = dock, page
        self._is_seen = False
        self._later = QTimer(self, singleShot=True, interval=0)  # when docks are where they are going to be
        self._later.timeout.connect(self._look)
        for moved in (dock.visibilityChanged, dock.topLevelChanged, dock.dockLocationChanged):
            moved.connect(self._on_moved)

    def __bool__(self) -> bool:
        return self._is_seen

    def follow(self, slot: Callable[[], None], *signals: SignalInstance) -> None:
        """Connect a slot while the dock is in sight, and call it whenever the dock comes into sight."""

        def turn(is_seen: bool) -> None:
            for signal in signals:
                if is_seen:
                    signal.connect(slot)
                else:
                    signal.disconnect(slot)
            if is_seen:
                slot()

        self.changed.connect(turn)

    def turn_with(self, turned: SignalInstance) -> InSight:
        """Check again whenever another page is shown."""
        turned.connect(lambda: self._on_moved(None))
        return self

    def _on_moved(self, _: object) -> None:
        self._look()
        self._later.start()

    def _look(self) -> None:
        is_seen = is_in_sight(self._dock) and (self._page is None or self._page.isVisible())
        if is_seen != self._is_seen:
            self._is_seen = is_seen
            self.changed.emit(is_seen)
