"""The map, with the choice of which sensors' coverage it shows."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from riglens.core.figures.heatmaps import ObjectHeatMap
from riglens.core.figures.lowest_heights import LowestHeight
from riglens.core.figures.registry import maps
from riglens.core.figures.voxel_sets import VoxelSet
from riglens.core.view.top_view import SeenBy
from riglens.widgets.maps.map_view import MapView
from riglens.widgets.panels.controls.building import button, filled
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.blind.zones import By


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
        self._maps = {one.key: one for one in maps()}
        for _, group in groupby(self._maps.values(), lambda one: one.needs):
            if self.choice.count():
                self.choice.insertSeparator(self.choice.count())
            for one in group:
                self.choice.addItem(one.on_map, one.key)
        self.choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.choice.setMinimumContentsLength(8)
        self.choice.setToolTip(
            "Content of the map: coverage by sensors, lowest visible height next to the car, or "
            "figures of objects."
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
        """Return the key of what the map shows, one of `maps`."""
        return str(self.choice.currentData())

    def choose(self, shown: str) -> None:
        """Show another map and emit the choice; ignore one that does not exist or is shown already."""
        place = self.choice.findData(shown)
        if shown and place >= 0 and place != self.choice.currentIndex():
            self.choice.setCurrentIndex(place)
            self.shown_chosen.emit()

    @property
    def seen_by(self) -> SeenBy | None:
        """Return the key of the set of voxels that the map shows, None while it shows something else."""
        return self.shown if isinstance(self._maps[self.shown], VoxelSet) else None

    @property
    def lowest(self) -> tuple[By, int] | None:
        """Return the sensors, and their number, whose lowest visible height it shows; None while it shows something
        else."""
        found = self._maps[self.shown]
        return (found.by, found.k) if isinstance(found, LowestHeight) else None

    @property
    def of_objects(self) -> ObjectHeatMap | None:
        """Return the heatmap of objects that the map shows; None while it shows something else."""
        found = self._maps[self.shown]
        return found if isinstance(found, ObjectHeatMap) else None

    def set_class(self, name: str) -> None:
        """Say which class of traffic the map is about."""
        self.title.setText(f"{name.capitalize()}," if name else "")
