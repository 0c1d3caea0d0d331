"""Form with every field of a LiDAR."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from riglens.core.rig.model import Lidar
from riglens.widgets.panels.angles_field import AnglesField
from riglens.widgets.panels.sensor_form import SensorForm


class LidarForm(SensorForm):
    """Every field of a LiDAR."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("lidar", parent)
        self.add_heading("Beams")
        self._angles = (
            AnglesField(self, "elevations_deg", "Elevations", "beam angles, both ends included"),
            AnglesField(self, "azimuths_deg", "Azimuths", "angles of one turn; the end is left out"),
        )
        self.add_range()
        self.add_derived()
        self.close_form()

    def show_subject(self, subject: Lidar) -> None:
        """Show a LiDAR."""
        super().show_subject(subject)
        for angles in self._angles:
            angles.show_rows(subject)
