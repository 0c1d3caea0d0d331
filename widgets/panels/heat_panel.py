"""How the heatmap is drawn: threshold, linear or logarithmic colours, opacity, and a horizontal slice."""

from __future__ import annotations

import math

from PySide6.QtWidgets import QWidget

from riglens.widgets.heatmap.scale import DEFAULT_LOOK, HeatLook, HeatmapData, value_text
from riglens.widgets.panels.look_panel import LookPanel

_STEPS = 200
_LEAST_OPACITY = 0.05


class HeatPanel(LookPanel):
    """Sliders for a HeatLook. Slices are whole layers of the cells that are shown."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Heatmap", parent)
        self._data: HeatmapData | None = None
        self._cell_m, self._layers = 0.4, 10
        self.threshold = self.add_slider("Show from", "Cells below this are not drawn", 0, _STEPS)
        self.opacity = self.add_slider(
            "Opacity", "Opacity of the highest values", round(_LEAST_OPACITY * _STEPS), _STEPS
        )
        self.log = self.add_box("Logarithmic colours", "Three powers of ten; shows small values, too")
        self.sliced = self.add_box("Horizontal slice only", "Only some layers of cells")
        self.bottom = self.add_slider("Height", "Where the slice begins", 0, self._layers - 1)
        self.thickness = self.add_slider("Layers", "How many layers of cells the slice has", 1, self._layers)
        self.add_reset()
        self.set_look(DEFAULT_LOOK)

    def reset(self) -> None:
        """Draw as at first."""
        self.set_look(DEFAULT_LOOK)

    # ------------------------------------------------------------------ what is shown
    def set_layers(self, cell_m: float, height_m: float) -> None:
        """Other cells: their edge and the height of the region, metres."""
        layers = max(1, math.ceil(height_m / cell_m - 1e-6))
        if (cell_m, layers) != (self._cell_m, self._layers):
            look = self.look
            self._cell_m, self._layers = cell_m, layers
            self.set_look(look)

    def set_data(self, data: HeatmapData | None) -> None:
        """Say thresholds in the values of this heatmap."""
        self._data = data
        self._show_values()

    def set_look(self, look: HeatLook) -> None:
        """Bring the sliders in line with a look, and tell it."""
        widgets = (self.threshold, self.opacity, self.log, self.sliced, self.bottom, self.thickness)
        for widget in widgets:
            widget.blockSignals(True)
        self.threshold.setValue(round(look.threshold * _STEPS))
        self.opacity.setValue(round(look.opacity * _STEPS))
        self.log.setChecked(look.log)
        self.sliced.setChecked(look.slice_m is not None)
        low_m, high_m = look.slice_m or (0.0, self._cell_m)
        self.bottom.setRange(0, self._layers - 1)
        self.thickness.setRange(1, self._layers)
        self.bottom.setValue(round(low_m / self._cell_m))
        self.thickness.setValue(round((high_m - low_m) / self._cell_m))
        for widget in widgets:
            widget.blockSignals(False)
        self._on_changed()

    @property
    def look(self) -> HeatLook:
        """What the sliders say."""
        first = self.bottom.value()
        low_m, high_m = first * self._cell_m, (first + self.thickness.value()) * self._cell_m
        return HeatLook(
            self.threshold.value() / _STEPS,
            self.log.isChecked(),
            self.opacity.value() / _STEPS,
            (low_m, high_m) if self.sliced.isChecked() else None,
        )

    # ------------------------------------------------------------------ changes
    def _on_changed(self, _: object = None) -> None:
        self._show_values()
        self.look_changed.emit(self.look)

    def _show_values(self) -> None:
        look = self.look
        for slider in (self.bottom, self.thickness):
            slider.setEnabled(look.slice_m is not None)
        threshold = f"{100 * look.threshold:.3g} %"
        if self._data is not None:
            threshold = value_text(self._data, look.threshold, look.log)
        low_m, high_m = look.slice_m or (0.0, self._layers * self._cell_m)
        count = self.thickness.value() if look.slice_m is not None else self._layers
        self.say(
            {
                "Show from": threshold if look.threshold > 0.0 else "everything",
                "Opacity": f"{100 * look.opacity:.0f} %",
                "Height": f"{low_m:.4g} to {high_m:.4g} m",
                "Layers": f"{count} of {self._cell_m:.3g} m",
            }
        )
