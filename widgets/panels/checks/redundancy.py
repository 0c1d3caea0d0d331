"""Show what the rig loses when one sensor fails, sensor by sensor."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtWidgets import QVBoxLayout, QWidget

from riglens.core.figures.text import change_unit
from riglens.widgets.panels.checks.sensor_table import SensorTable
from riglens.widgets.panels.controls.building import filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN, as_panel
from riglens.widgets.panels.figures.table import Cell
from riglens.widgets.panels.sensors.losses import FOLLOWS, Loss, Losses, meaning, measures

NOTE = "Loss of the figures without the sensor, all classes together. Pairs and groups are in the report."


class RedundancyPanel(QWidget):
    """One row per sensor with its loss in each measure."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._keys = tuple(measures())
        columns = {f"{one.title}, {change_unit(one)}": meaning(one) for one in measures().values()}
        self.table = SensorTable("Loss by sensor", columns)
        self.table.explain("Computed between edits.")
        note = plain_label(NOTE, "hint")
        note.setContentsMargins(MARGIN, 4, MARGIN, 4)
        filled(QVBoxLayout(self), note, self.table, spacing=0)

    def show_losses(self, losses: Mapping[str, Losses]) -> None:
        """Show losses by sensor and measure; a measure that is not known yet has none."""
        follows = Loss(None, FOLLOWS, "computed between edits")
        self.table.show_rows(
            {
                name: [
                    Cell(loss.text, tip=loss.tip) for loss in (known.get(key, follows) for key in self._keys)
                ]
                for name, known in losses.items()
            }
        )

    def grey(self) -> None:
        """Grey what belongs to an earlier rig."""
        self.table.figures.grey()
