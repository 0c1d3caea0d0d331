"""The map, with the choice of which sensors' coverage it shows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from riglens.core.view.top_view import SeenBy
from riglens.widgets.maps.map_view import MapView
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.review.blind import By

SEEN_BY: dict[SeenBy, str] = {
    "any": "any sensor",
    "lidar": "LiDARs",
    "camera": "cameras",
    "twice": "2 or more",
    "thrice": "3 or more",
    "kinds": "both kinds",
}
LOWEST: dict[str, tuple[By, int, str]] = {
    "lowest_1_any": ("any", 1, "1 sensor"),
    "lowest_1_lidar": ("lidar", 1, "1 LiDAR"),
    "lowest_1_camera": ("camera", 1, "1 camera"),
    "lowest_2_any": ("any", 2, "2 sensors"),
    "lowest_2_lidar": ("lidar", 2, "2 LiDARs"),
    "lowest_2_camera": ("camera", 2, "2 cameras"),
}
"""Lowest visible heights: by whom, by how many, and in words."""
ON_ROAD_USERS = {"on_target": "on target", "missed": "missed road users"}


class MapPanel(QWidget):
    """A row of choices over the map."""

    shown_chosen = Signal()
    """The map is to show something else."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.map = MapView()
        self.title = QLabel()
        self.title.setToolTip("The class of traffic is chosen in the toolbar")
        self.choice = QComboBox()
        for key, text in SEEN_BY.items():
            self.choice.addItem(f"seen by {text}", key)
        self.choice.insertSeparator(self.choice.count())
        for name, (_, number, text) in LOWEST.items():
            self.choice.addItem(f"L{'₁₂'[number - 1]}, lowest height seen by {text}", name)
        self.choice.insertSeparator(self.choice.count())
        for mode, text in ON_ROAD_USERS.items():
            self.choice.addItem(text, mode)
        self.choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.choice.setMinimumContentsLength(8)
        self.choice.setToolTip(
            "Which sensors' coverage the map shows, from what height on something beside the car is seen, or what "
            "LiDARs get onto road users"
        )
        self.choice.activated.connect(lambda _: self.shown_chosen.emit())
        fit = QToolButton()
        fit.setText("Fit")
        fit.setToolTip("Show the whole region of interest")
        fit.clicked.connect(self.map.fit)
        row = QHBoxLayout()
        row.setContentsMargins(MARGIN, 4, MARGIN, 4)
        row.setSpacing(SPACING)
        row.addWidget(self.title)
        row.addWidget(self.choice, 1)
        row.addWidget(fit)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(row)
        column.addWidget(self.map, 1)
        self.set_class("")

    @property
    def shown(self) -> str:
        """What the map shows: a key of SEEN_BY, LOWEST or ON_ROAD_USERS."""
        return str(self.choice.currentData())

    def choose(self, shown: str) -> None:
        """Show something else, and say so; nothing happens for what there is not, or is shown."""
        place = self.choice.findData(shown)
        if shown and place >= 0 and place != self.choice.currentIndex():
            self.choice.setCurrentIndex(place)
            self.shown_chosen.emit()

    @property
    def seen_by(self) -> SeenBy | None:
        """Which sensors' coverage the map shows, None while it shows something else."""
        return next((key for key in SEEN_BY if key == self.choice.currentData()), None)

    @property
    def lowest(self) -> tuple[By, int] | None:
        """Of whom, and of how many, it shows the lowest visible height; None while it shows something else."""
        found = LOWEST.get(str(self.choice.currentData()))
        return None if found is None else found[:2]

    @property
    def target_mode(self) -> str:
        """What the map shows of road users, a key of ON_ROAD_USERS; empty while it shows coverage."""
        found = str(self.choice.currentData())
        return found if found in ON_ROAD_USERS else ""

    def set_class(self, name: str) -> None:
        """Say which class of traffic the map is about."""
        self.title.setText(f"{name.capitalize()}," if name else "")
