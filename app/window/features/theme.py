"""Light or dark: as the system says, also while the window is open, or as chosen in the View menu."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QApplication, QMenu

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.follow import Follow
from riglens.app.window.settings import Settings
from riglens.widgets.panels.style import apply_style, is_dark, shows_dark
from riglens.widgets.theme import palette

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

CHOICES = {"theme_system": None, "theme_light": False, "theme_dark": True}


class Theme(Feature):
    """Tells the application, the viewport and whoever listens to `theme_changed`."""

    specs = (
        Spec("theme_system", "As the system", "Light or dark as the system says", menu="view", group="theme"),
        Spec("theme_light", "Light", "Always light", menu="view", group="theme"),
        Spec("theme_dark", "Dark", "Always dark", menu="view", group="theme"),
    )

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._shown = shows_dark()
        menu = QMenu("Theme", window)
        for key in CHOICES:
            menu.addAction(window.actions_[key])
        window.places.add_to_menu("view/window", menu)
        window.actions_["theme_system"].setChecked(True)
        self.bind(**dict.fromkeys(CHOICES, self.apply))
        QGuiApplication.styleHints().colorSchemeChanged.connect(self.apply)

    @property
    def choice(self) -> str:
        """Which of CHOICES is ticked."""
        return next(key for key in CHOICES if self.window.actions_[key].isChecked())

    def apply(self) -> None:
        """Show what is chosen, everywhere and at once."""
        wanted = CHOICES[self.choice]
        dark = is_dark() if wanted is None else wanted
        if dark == self._shown:
            return
        self._shown = dark
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        apply_style(app, dark)
        self.viewport.set_palette(palette(dark))
        self.window.feature(Follow).show_all()
        self.window.theme_changed.emit(dark)

    def restore(self, settings: Settings) -> None:
        key = settings.read("theme", "theme_system")
        if key in CHOICES:
            self.window.actions_[key].setChecked(True)
            self.apply()

    def keep(self, settings: Settings) -> None:
        settings.write("theme", self.choice)
