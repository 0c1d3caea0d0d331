"""What the heatmap shows, of which class of traffic, and how it is drawn."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QToolButton, QWidget, QWidgetAction

from riglens.app.evaluation.heat_modes import HEAT_TITLES, HeatMode
from riglens.app.evaluation.requests import Result
from riglens.app.window.actions import Choice, Spec, menu_button
from riglens.app.window.feature import Feature
from riglens.app.window.settings import Settings
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.panels.icons import swatch
from riglens.widgets.panels.look_panels import HeatPanel
from riglens.widgets.theme import CLASS_COLOURS

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Heat(Feature):
    """Two choices and a panel of sliders in the toolbar; `mode` and `class_name` are what evaluations ask for."""

    specs = (
        *(
            Spec(f"heat_{mode}", title, f"Heatmap: {title}", f"Alt+{place}", menu="view", group="heat")
            for place, (mode, title) in enumerate(HEAT_TITLES.items())
        ),
        *(
            Spec(f"class_{name}", name, f"Heatmap and map: {name}", menu="view", group="class")
            for name in CLASSES
        ),
        Spec(
            "next_class", "Next class of traffic", "Heatmap and map of the next class of traffic", "T",
            menu="view/shown",
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.mode: HeatMode = "probability"
        self.class_name = CLASSES[0]
        modes = {str(mode): window.actions_[f"heat_{mode}"] for mode in HEAT_TITLES}
        classes = {name: window.actions_[f"class_{name}"] for name in CLASSES}
        for name, action in classes.items():
            action.setIcon(swatch(CLASS_COLOURS[name]))
        self._modes = Choice("heatmap", "What the heatmap shows", modes)
        self._classes = Choice("class", "Class of traffic of heatmap and map", classes)
        self._classes.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.panel = HeatPanel()
        self._looks = QMenu(window)
        self.add_look(self.panel)
        for widget in (self._modes, self._classes, looks_button(self._looks)):
            window.places.add_to_toolbar("heat", widget)
        self._add_menus([*modes.values()], [*classes.values()])
        self.bind(
            next_class=self.next_class,
            **{f"heat_{mode}": partial(self.set_mode, mode) for mode in modes},
            **{f"class_{name}": partial(self.set_class, name) for name in classes},
        )
        self.panel.look_changed.connect(self.viewport.set_heat_look)
        window.result_shown.connect(self._follow)
        self._show()
        self._modes.keep_room(HEAT_TITLES.values())
        self._classes.keep_room(CLASSES)

    def add_look(self, panel: QWidget) -> None:
        """Put a panel under those that open under the button with the sliders."""
        holder = QWidgetAction(self._looks)
        holder.setDefaultWidget(panel)
        self._looks.addAction(holder)

    def _add_menus(self, modes: list[QAction], classes: list[QAction]) -> None:
        for title, actions in (("Heatmap", modes), ("Class of traffic", classes)):
            menu = QMenu(title, self.window)
            menu.addActions(actions)
            self.window.places.add_to_menu("view/shown", menu)

    def next_class(self) -> None:
        """Choose the class after the one that is shown, after the last the first."""
        self.set_class(CLASSES[(CLASSES.index(self.class_name) + 1) % len(CLASSES)])

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


def looks_button(menu: QMenu) -> QToolButton:
    """The toolbar button under which the sliders open."""
    return menu_button(
        "heat_look",
        "sliders",
        "Threshold, colours, opacity and slice of the heatmap; rays of the sensors",
        menu,
    )


def look_of(kept: dict[str, Any]) -> HeatLook | None:
    """The look of an earlier session, None when it does not say one."""
    threshold, opacity, log = kept.get("threshold"), kept.get("opacity"), kept.get("log")
    shares = [share for share in (threshold, opacity) if isinstance(share, float) and 0.0 <= share <= 1.0]
    return HeatLook(shares[0], log is True, shares[1]) if len(shares) == 2 else None
