"""The map, with the choice of which sensors' coverage it shows."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from riglens.core.view.top_view import SeenBy
from riglens.widgets.maps.map_view import MapView
from riglens.widgets.panels.style import MARGIN, SPACING, as_panel

SEEN_BY: dict[SeenBy, str] = {"any": "any sensor", "lidar": "LiDARs", "camera": "cameras"}


class MapPanel(QWidget):
    """A row of choices over the map."""

    seen_by_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.map = MapView()
        self.title = QLabel()
        self.title.setToolTip("The class of traffic is chosen in the toolbar")
        self.choice = QComboBox()
        for key, text in SEEN_BY.items():
            self.choice.addItem(text, key)
        self.choice.setToolTip("Which sensors' coverage the map shows")
        self.choice.activated.connect(lambda _: self.seen_by_chosen.emit(self.seen_by))
        fit = QToolButton()
        fit.setText("Fit")
        fit.setToolTip("Show the whole region of interest")
        fit.clicked.connect(self.map.fit)
        row = QHBoxLayout()
        row.setContentsMargins(MARGIN, 4, MARGIN, 4)
        row.setSpacing(SPACING)
        row.addWidget(self.title)
        row.addWidget(self.choice)
        row.addStretch(1)
        row.addWidget(fit)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(row)
        column.addWidget(self.map, 1)
        self.set_class("")

    @property
    def seen_by(self) -> SeenBy:
        """Which sensors' coverage the map shows."""
        found: SeenBy = self.choice.currentData()
        return found

    def set_class(self, name: str) -> None:
        """Say which class of traffic the map is about."""
        self.title.setText(f"{name.capitalize()}, seen by" if name else "Seen by")
