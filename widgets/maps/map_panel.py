"""The map, with the choice of which sensors' coverage it shows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from riglens.core.sensors.registry import kinds
from riglens.core.view.top_view import SeenBy
from riglens.widgets.maps.map_view import MapView
from riglens.widgets.panels.controls.building import button, filled
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.blind.zones import By


def seen_by_choices() -> dict[SeenBy, str]:
    """Return the sensors whose coverage the map can show, in words."""
    several = {"twice": "at least 2", "thrice": "at least 3", "kinds": "two kinds"}
    return {"any": "any sensor", **{kind.name: kind.plural for kind in kinds()}, **several}


def lowest_choices() -> dict[str, tuple[By, int, str]]:
    """Return the lowest visible heights that the map can show: by which sensors, by how many, and in words.

    How many sensors see an object is none of them (0).
    """
    who = {"any": ("sensor", "sensors"), **{kind.name: (kind.title, kind.plural) for kind in kinds()}}
    lowest: dict[str, tuple[By, int, str]] = {
        f"lowest_{number}_{by}": (by, number, f"{number} {words[number - 1]}")
        for number in (1, 2)
        for by, words in who.items()
    }
    return lowest | {"overlap": ("any", 0, "")}


OVERLAP = "overlap of fields of view"
ON_ROAD_USERS = {"on_target": "on target", "missed": "missed objects"}


class MapPanel(QWidget):
    """A row of choices over the map."""

    shown_chosen = Signal()
    """The map is to show something else."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.map = MapView()
        self.title = QLabel()
        self.title.setToolTip("Choose the traffic class in the toolbar.")
        self.choice = QComboBox()
        self._seen_by, self._lowest = seen_by_choices(), lowest_choices()
        for key, text in self._seen_by.items():
            self.choice.addItem(f"seen by {text}", key)
        self.choice.insertSeparator(self.choice.count())
        for name, (_, number, text) in self._lowest.items():
            lowest = f"L{'₁₂'[number - 1]}, lowest height seen by {text}"
            self.choice.addItem(lowest if number else OVERLAP, name)
        self.choice.insertSeparator(self.choice.count())
        for mode, text in ON_ROAD_USERS.items():
            self.choice.addItem(text, mode)
        self.choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.choice.setMinimumContentsLength(8)
        self.choice.setToolTip(
            "Content of the map: coverage by sensors, lowest visible height next to the car, or "
            "LiDAR hits on objects."
        )
        self.choice.activated.connect(lambda _: self.shown_chosen.emit())
        self.choice.currentIndexChanged.connect(lambda _: self._offer_ground())
        self.on_ground = QCheckBox("On the ground")
        self.on_ground.setToolTip("Also show lowest heights or overlap on the ground of the 3D view.")
        self.on_ground.toggled.connect(lambda _: self.shown_chosen.emit())
        fit = button(QToolButton(), self.map.fit, "Show the whole region of interest.", text="Fit")
        parts = (self.title, self.choice, 1, self.on_ground, fit)
        row = filled(QHBoxLayout(), *parts, margins=(MARGIN, 4, MARGIN, 4), spacing=SPACING)
        filled(QVBoxLayout(self), row, self.map, 1, spacing=0)
        self.set_class("")
        self._offer_ground()

    def _offer_ground(self) -> None:
        self.on_ground.setVisible(self.lowest is not None)  # the choice needs the room

    @property
    def ground(self) -> tuple[By, int] | None:
        """Return the map on the ground of the 3D view, as `lowest`; None for none."""
        return self.lowest if self.on_ground.isChecked() else None

    @property
    def shown(self) -> str:
        """Return the content of the map: a key of `seen_by_choices`, `lowest_choices` or ON_ROAD_USERS."""
        return str(self.choice.currentData())

    def choose(self, shown: str) -> None:
        """Show another map and emit the choice; ignore one that does not exist or is shown already."""
        place = self.choice.findData(shown)
        if shown and place >= 0 and place != self.choice.currentIndex():
            self.choice.setCurrentIndex(place)
            self.shown_chosen.emit()

    @property
    def seen_by(self) -> SeenBy | None:
        """Return the sensors whose coverage the map shows, None while it shows something else."""
        return self.shown if self.shown in self._seen_by else None

    @property
    def lowest(self) -> tuple[By, int] | None:
        """Return the sensors, and their number, whose lowest visible height it shows; None while it shows something
        else."""
        found = self._lowest.get(self.shown)
        return None if found is None else found[:2]

    @property
    def target_mode(self) -> str:
        """Return the figure of objects that the map shows, a key of ON_ROAD_USERS; empty while it shows coverage."""
        return self.shown if self.shown in ON_ROAD_USERS else ""

    def set_class(self, name: str) -> None:
        """Say which class of traffic the map is about."""
        self.title.setText(f"{name.capitalize()}," if name else "")
