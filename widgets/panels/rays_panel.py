"""How the rays of sensors are drawn: whether at all, how opaque, and how many."""

from __future__ import annotations

import math

from PySide6.QtWidgets import QWidget

from riglens.widgets.panels.look_panel import LookPanel
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, LEAST_DENSITY, MOST_DENSITY, RayLook

_PERCENT, _LEAST_PERCENT = 100, 2
_PER_OCTAVE = 2
"""Steps of the density's slider until there are twice as many rays."""


class RaysPanel(LookPanel):
    """A box and two sliders for a RayLook."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Rays", parent)
        self.shown = self.add_box("Show rays", "Rays of all sensors that are switched on")
        self.opacity = self.add_slider(
            "Opacity",
            "Opacity of the selected sensor's rays; the others' are fainter",
            _LEAST_PERCENT,
            _PERCENT,
        )
        self.density = self.add_slider(
            "Density",
            "How many of its rays a sensor shows at rest",
            _step(LEAST_DENSITY),
            _step(MOST_DENSITY),
        )
        self.add_reset()
        self.set_look(DEFAULT_RAYS)

    def reset(self) -> None:
        """Draw as at first."""
        self.set_look(DEFAULT_RAYS)

    def set_look(self, look: RayLook) -> None:
        """Bring box and sliders in line with a look, and tell it."""
        widgets = (self.shown, self.opacity, self.density)
        for widget in widgets:
            widget.blockSignals(True)
        self.shown.setChecked(look.shown)
        self.opacity.setValue(round(look.opacity * _PERCENT))
        self.density.setValue(_step(look.density))
        for widget in widgets:
            widget.blockSignals(False)
        self._on_changed()

    @property
    def look(self) -> RayLook:
        """What box and sliders say."""
        density = 2.0 ** (self.density.value() / _PER_OCTAVE)
        return RayLook(self.shown.isChecked(), self.opacity.value() / _PERCENT, density)

    def _on_changed(self, _: object = None) -> None:
        look = self.look
        for slider in (self.opacity, self.density):
            slider.setEnabled(look.shown)
        self.say({"Opacity": f"{100 * look.opacity:.0f} %", "Density": f"× {look.density:.2g}"})
        self.look_changed.emit(look)


def _step(density: float) -> int:
    return round(_PER_OCTAVE * math.log2(density))
