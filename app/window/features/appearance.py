"""Appearance of the window, kept between sessions: light or dark, docks, units of lengths and angles."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QApplication

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.follow import Follow
from riglens.app.window.settings import Settings
from riglens.app.window.workbench import Workbench
from riglens.widgets.panels.controls.building import room_around
from riglens.widgets.panels.controls.style import apply_theme, is_dark, shows_dark
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, MILLIMETRES, RADIANS
from riglens.widgets.theme import palette

LEFT_PX, RIGHT_PX, BOTTOM_PX = 312, 336, 232
LEFT_SHARE, RIGHT_SHARE, BELOW_SHARE = 0.27, 1 / 3, 0.27
"""Largest shares of a small window for the panels on the left, on the right and below the view at first. The names of
tabs and the form of a sensor need as much on the right."""
COMPACT_PX = 800
"""In a lower window the scores get no more room than their rows need."""
FRAME = QSize(16, 44)
"""Room for the frame and the title bar that a desktop puts around a window; how large they are is known too late."""
VERSION = 2
"""Incremented when docks are rearranged, so that an old layout is not applied to them."""
SHOWN = {unit.name: unit for unit in (METRES, MILLIMETRES, DEGREES, RADIANS)}
CHOICES = {"theme_system": None, "theme_light": False, "theme_dark": True}


class Theme(Feature):
    """Theme of the application, of the viewport and of listeners to `theme_changed`."""

    specs = (
        Spec(
            "theme_system", "System", "Follow the system's light or dark theme.", menu="view", group="theme"
        ),
        Spec("theme_light", "Light", "Always use the light theme.", menu="view", group="theme"),
        Spec("theme_dark", "Dark", "Always use the dark theme.", menu="view", group="theme"),
    )

    def __init__(self, bench: Workbench, follow: Follow) -> None:
        super().__init__(bench)
        self._follow = follow
        self._shown = shows_dark()
        bench.places.add_submenu("view/window", "Theme", [self.actions[key] for key in CHOICES])
        self.actions["theme_system"].setChecked(True)
        self.bind(**dict.fromkeys(CHOICES, self.apply))
        QGuiApplication.styleHints().colorSchemeChanged.connect(self.apply)
        self.remember("theme", lambda: self.choice, self._take)

    @property
    def choice(self) -> str:
        """Return the ticked one of CHOICES."""
        return next(key for key in CHOICES if self.actions[key].isChecked())

    def apply(self) -> None:
        """Apply the chosen theme everywhere at once."""
        wanted = CHOICES[self.choice]
        dark = is_dark() if wanted is None else wanted
        if dark == self._shown:
            return
        self._shown = dark
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        apply_theme(app, dark)
        self.viewport.show_state(replace(self.viewport.state, palette=palette(dark)))
        self._follow.show_all()
        self.bench.theme_changed.emit(dark)

    def _take(self, key: str) -> None:
        if key in CHOICES:
            self.actions[key].setChecked(True)
            self.apply()


def fitting_size(wanted: QSize, screen: QSize) -> QSize:
    """Return the size of a window that fits, with its frame, into this part of a screen."""
    return wanted.boundedTo(screen - FRAME)


class Layout(Feature):
    """Geometry and docks of the window. Its place is behind all features that add docks."""

    specs = (
        Spec(
            "reset_layout", "Reset layout",
            "Restore the initial panels, toolbar and window size; a maximised window stays maximised.",
            "Ctrl+Alt+0", menu="view/window",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self._share_room()
        self._first_state = bench.window.saveState(VERSION)
        self._first_size = bench.window.size()
        self.bind(reset_layout=self.reset)

    def _share_room(self) -> None:
        """Give the panels their first sizes; the view gets most of a small window."""
        docks, size = self.bench.docks, self.bench.window.size()
        sides_px = ((LEFT_PX, LEFT_SHARE), (RIGHT_PX, RIGHT_SHARE))
        wide_px = [min(wanted_px, round(share * size.width())) for wanted_px, share in sides_px]
        high_px = min(BOTTOM_PX, round(size.height() * BELOW_SHARE))
        if size.height() < COMPACT_PX:
            high_px = self.bench.panels.scores.minimumSizeHint().height()
        sides = [docks["Sensors"], docks["Inspector"]]
        self.bench.window.resizeDocks(sides, wide_px, Qt.Orientation.Horizontal)
        self.bench.window.resizeDocks([docks["Scores"]], [high_px], Qt.Orientation.Vertical)

    def reset(self) -> None:
        """Arrange the window as at the very first start; a maximised one stays maximised."""
        window = self.bench.window
        window.restoreState(self._first_state, VERSION)
        if not (window.isMaximized() or window.isFullScreen()):
            window.resize(fitting_size(self._first_size, room_around(window).size()))

    def restore(self, settings: Settings) -> None:
        window = self.bench.window
        window.restoreGeometry(settings.read_bytes("window/geometry"))
        if not (window.isMaximized() or window.isFullScreen()):
            window.resize(fitting_size(window.size(), room_around(window).size()))
        window.restoreState(settings.read_bytes("window/state"), VERSION)

    def keep(self, settings: Settings) -> None:
        settings.write_bytes("window/geometry", self.bench.window.saveGeometry())
        settings.write_bytes("window/state", self.bench.window.saveState(VERSION))


class Units(Feature):
    """Units chosen in the inspector, remembered; files and exact values stay in metres and degrees."""

    def restore(self, settings: Settings) -> None:
        found = [
            SHOWN[name] for name in settings.read("units", []) if isinstance(name, str) and name in SHOWN
        ]
        by_quantity = {unit.quantity: unit for unit in (METRES, DEGREES, *found)}
        self.bench.panels.inspector.set_units(tuple(by_quantity.values()))

    def keep(self, settings: Settings) -> None:
        settings.write("units", [unit.name for unit in self.bench.panels.inspector.units])
