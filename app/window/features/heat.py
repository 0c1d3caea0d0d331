"""What the heatmap shows, of which class of traffic, and how it is drawn."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, cast

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMainWindow, QMenu, QToolButton, QWidget, QWidgetAction

from app.actions import Choice, class_actions, heat_actions
from app.heat_modes import HEAT_TITLES, HeatMode
from app.requests import Result
from app.window.feature import Feature
from app.window.settings import Settings
from core.scene.boxes import CLASSES
from widgets.panels.heat_panel import HeatPanel
from widgets.panels.icons import icon
from widgets.viewport.heat_scale import HeatLook

if TYPE_CHECKING:
    from app.window.main_window import MainWindow


class Heat(Feature):
    """Two choices and a panel of sliders in the toolbar; `mode` and `class_name` are what evaluations ask for."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.mode: HeatMode = "probability"
        self.class_name = CLASSES[0]
        self._modes = Choice("heatmap", "What the heatmap shows", heat_actions(window, self.set_mode))
        self._classes = Choice(
            "class", "Class of traffic of heatmap and map", class_actions(window, self.set_class)
        )
        self._classes.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.panel = HeatPanel()
        for widget in (self._modes, self._classes, panel_button(self.panel, window)):
            window.places.add_to_toolbar("heat", widget)
        self.panel.look_changed.connect(self.viewport.set_heat_look)
        window.result_shown.connect(self._follow)
        self._show()

    def set_mode(self, mode: str) -> None:
        """Choose what the heatmap shows: a key of HEAT_TITLES."""
        self.mode = cast(HeatMode, mode)
        self._show()
        self.window.settings_changed.emit()

    def set_class(self, name: str) -> None:
        """Choose the class of traffic that the heatmap is about."""
        self.class_name = name
        self._show()
        self.window.settings_changed.emit()

    def restore(self, settings: Settings) -> None:
        mode, name = settings.read("heat/mode", self.mode), settings.read("heat/class", self.class_name)
        self.mode = mode if mode in HEAT_TITLES else self.mode
        self.class_name = name if name in CLASSES else self.class_name
        self._show()
        look = look_of(settings.read("heat/look", {}))
        if look is not None:
            self.panel.set_look(look)

    def keep(self, settings: Settings) -> None:
        settings.write("heat/mode", self.mode)
        settings.write("heat/class", self.class_name)
        look = replace(self.panel.look, slice_m=None)  # a slice left over would hide what is expected
        settings.write("heat/look", asdict(look))

    def _follow(self, result: Result) -> None:
        display = result.scene.heatmaps.display
        self.panel.set_layers(display.cell_m, result.scene.field.grid.roi_m[2])
        self.panel.set_data(result.heatmap)

    def _show(self) -> None:
        self._modes.show_choice(self.mode, "Heatmap off" if self.mode == "off" else HEAT_TITLES[self.mode])
        self._classes.show_choice(self.class_name, self.class_name, with_icon=True)


def panel_button(panel: QWidget, window: QMainWindow) -> QToolButton:
    """A toolbar button under which the panel opens."""
    button, menu = QToolButton(), QMenu(window)
    holder = QWidgetAction(menu)
    holder.setDefaultWidget(panel)
    menu.addAction(holder)
    button.setObjectName("heat_look")
    button.setIcon(icon("sliders"))
    button.setToolTip("Threshold, colour scale, opacity and slice of the heatmap")
    button.setMenu(menu)
    button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    return button


def look_of(kept: dict[str, Any]) -> HeatLook | None:
    """The look of an earlier session, None when it does not say one."""
    threshold, opacity, log = kept.get("threshold"), kept.get("opacity"), kept.get("log")
    shares = [share for share in (threshold, opacity) if isinstance(share, float) and 0.0 <= share <= 1.0]
    return HeatLook(shares[0], log is True, shares[1]) if len(shares) == 2 else None
