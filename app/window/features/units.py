"""The units in which the inspector shows lengths and angles, kept between sessions."""

from __future__ import annotations

from riglens.app.window.feature import Feature
from riglens.app.window.settings import Settings
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, MILLIMETRES, RADIANS

SHOWN = {unit.name: unit for unit in (METRES, MILLIMETRES, DEGREES, RADIANS)}


class Units(Feature):
    """Remembers what was chosen in the inspector; files and exact values stay in metres and degrees."""

    def restore(self, settings: Settings) -> None:
        found = [
            SHOWN[name] for name in settings.read("units", []) if isinstance(name, str) and name in SHOWN
        ]
        by_quantity = {unit.quantity: unit for unit in (METRES, DEGREES, *found)}
        self.window.inspector.set_units(tuple(by_quantity.values()))

    def keep(self, settings: Settings) -> None:
        settings.write("units", [unit.name for unit in self.window.inspector.units])
