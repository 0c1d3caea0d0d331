"""Panels about how the heatmap and the rays are drawn."""

from __future__ import annotations

import math

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QPushButton, QSlider, QWidget

from riglens.core.errors import InputError
from riglens.core.footprint.ground import checked_limits
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.heatmap.scale import USUAL_LOOK, HeatLook, value_text
from riglens.widgets.panels.controls.building import button
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel
from riglens.widgets.panels.fields.edits import ListEdit
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, LEAST_DENSITY, MOST_DENSITY, RayLook

_CAPTION_PX, _SLIDER_PX, _VALUE_PX = 68, 150, 104


class LookPanel(QWidget):
    """Rows of caption, slider and value; a subclass adds them and defines what they mean.

    Columns of panels above each other line up.
    """

    look_changed = Signal(object)

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(MARGIN + 4, MARGIN, MARGIN + 4, MARGIN)
        self._grid.setHorizontalSpacing(SPACING + 4)
        self._grid.setVerticalSpacing(SPACING)
        self._grid.setColumnMinimumWidth(0, _CAPTION_PX)
        heading = QLabel(title)
        heading.setObjectName("heading")
        heading.setIndent(0)
        self._grid.addWidget(heading, 0, 0, 1, 3)

    def reset(self) -> None:
        """Go back to the default look."""
        raise NotImplementedError

    def add_slider(self, caption: str, tip: str, low: int, high: int) -> QSlider:
        """Add a slider of whole steps; `say` formats the value next to it."""
        slider, label, value = QSlider(Qt.Orientation.Horizontal), QLabel(caption), QLabel()
        slider.setRange(low, high)
        slider.setFixedWidth(_SLIDER_PX)
        slider.setObjectName(caption)
        slider.setAccessibleName(caption)
        slider.valueChanged.connect(self._on_changed)
        value.setMinimumWidth(_VALUE_PX)
        value.setObjectName(f"{caption} value")
        row = self._grid.rowCount()
        for column, widget in enumerate((label, slider, value)):
            widget.setToolTip(tip)
            self._grid.addWidget(widget, row, column)
        return slider

    def add_box(self, caption: str, tip: str) -> QCheckBox:
        """Add a check box."""
        box = QCheckBox(caption)
        box.setToolTip(tip)
        box.toggled.connect(self._on_changed)
        self._grid.addWidget(box, self._grid.rowCount(), 0, 1, 3)
        return box

    def add_list(self, caption: str, tip: str) -> ListEdit:
        """Add a list of numbers."""
        edit, label = ListEdit(), QLabel(caption)
        edit.setObjectName(caption)
        edit.setAccessibleName(caption)
        row = self._grid.rowCount()
        label.setToolTip(tip)
        self._grid.addWidget(label, row, 0)
        self._grid.addWidget(edit, row, 1, 1, 2)
        return edit

    def add_reset(self) -> None:
        """Add a button that goes back to the default look."""
        made = button(QPushButton("Reset"), self.reset, name="reset_look")
        self._grid.addWidget(made, self._grid.rowCount(), 2)

    def say(self, texts: dict[str, str]) -> None:
        """Show the values next to the sliders, by caption."""
        for caption, text in texts.items():
            label = self.findChild(QLabel, f"{caption} value")
            assert label is not None
            label.setText(text)

    def _on_changed(self, _: object = None) -> None:
        raise NotImplementedError


_STEPS = 200
_LEAST_OPACITY = 0.05


class HeatPanel(LookPanel):
    """Sliders for a HeatLook. Slices are whole layers of the cells that are shown."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Heatmap", parent)
        self._data: HeatmapData | None = None
        self._cell_m, self._layers = 0.4, 10
        self.threshold = self.add_slider("Show from", "Cells below this value are not drawn.", 0, _STEPS)
        self.opacity = self.add_slider(
            "Opacity", "Opacity of the highest values.", round(_LEAST_OPACITY * _STEPS), _STEPS
        )
        self.draped = self.add_box(
            "On the ground", "All heights together on the ground; off: cells in space."
        )
        self.log = self.add_box("Logarithmic colours", "Three decades: also shows small values.")
        self.sliced = self.add_box("Horizontal slice only", "Show only some layers of cells.")
        self.bottom = self.add_slider("Height", "Lower edge of the slice.", 0, self._layers - 1)
        self.thickness = self.add_slider("Layers", "Number of layers in the slice.", 1, self._layers)
        self.add_reset()
        self.set_look(USUAL_LOOK)

    def reset(self) -> None:
        """Go back to the default look."""
        self.set_look(USUAL_LOOK)

    # ------------------------------------------------------------------ what is shown
    def set_layers(self, cell_m: float, height_m: float) -> None:
        """Set the edge of the cells and the height of the region, metres."""
        layers = max(1, math.ceil(height_m / cell_m - 1e-6))
        if (cell_m, layers) != (self._cell_m, self._layers):
            look = self.look
            self._cell_m, self._layers = cell_m, layers
            self.set_look(look)

    def set_data(self, data: HeatmapData | None) -> None:
        """Show thresholds in the values of this heatmap."""
        self._data = data
        self._show_values()

    def set_look(self, look: HeatLook) -> None:
        """Set the sliders to a look, and signal it."""
        boxes = (self.draped, self.log, self.sliced)
        widgets = (self.threshold, self.opacity, *boxes, self.bottom, self.thickness)
        blockers = [QSignalBlocker(widget) for widget in widgets]
        self.threshold.setValue(round(look.threshold * _STEPS))
        self.opacity.setValue(round(look.opacity * _STEPS))
        self.draped.setChecked(look.draped)
        self.log.setChecked(look.log)
        self.sliced.setChecked(look.slice_m is not None)
        low_m, high_m = look.slice_m or (0.0, self._cell_m)
        self.bottom.setRange(0, self._layers - 1)
        self.thickness.setRange(1, self._layers)
        self.bottom.setValue(round(low_m / self._cell_m))
        self.thickness.setValue(round((high_m - low_m) / self._cell_m))
        del blockers
        self._on_changed()

    @property
    def look(self) -> HeatLook:
        """The look that the sliders give."""
        first = self.bottom.value()
        low_m, high_m = first * self._cell_m, (first + self.thickness.value()) * self._cell_m
        return HeatLook(
            self.threshold.value() / _STEPS,
            self.log.isChecked(),
            self.opacity.value() / _STEPS,
            (low_m, high_m) if self.sliced.isChecked() else None,
            self.draped.isChecked(),
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


_PERCENT, _LEAST_PERCENT = 100, 2
_PER_OCTAVE = 2
"""Steps of the density slider per doubling of the rays."""


class RaysPanel(LookPanel):
    """Check boxes and two sliders for a RayLook; the fill stays as it was set."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Rays", parent)
        self._fill = DEFAULT_RAYS.fill
        self.shown = self.add_box("Show rays", "Show the rays of the selected sensor.")
        self.of_all = self.add_box("Of all sensors", "Show the rays of every enabled sensor.")
        self.lattice = self.add_box(
            "Lattice of cameras", "Show a camera's rays up to the region; off: a pyramid."
        )
        self.opacity = self.add_slider(
            "Opacity",
            "Opacity of the selected sensor's rays; others are fainter.",
            _LEAST_PERCENT,
            _PERCENT,
        )
        self.density = self.add_slider(
            "Density",
            "Share of a sensor's rays that is drawn at rest.",
            _step(LEAST_DENSITY),
            _step(MOST_DENSITY),
        )
        self.limits = self.add_list(
            "Bands, px/m",
            "Least pixels per metre of each band of a camera on the ground, falling; by default those of EN 62676-4.",
        )
        self.limits.edited.connect(self._on_limits)
        self.add_reset()
        self.set_look(DEFAULT_RAYS)

    def reset(self) -> None:
        """Go back to the default look."""
        self.set_look(DEFAULT_RAYS)

    def set_look(self, look: RayLook) -> None:
        """Set check box and sliders to a look, and signal it."""
        self._fill = look.fill
        self.limits.set_value(look.px_per_m)
        widgets = (self.shown, self.of_all, self.lattice, self.opacity, self.density)
        blockers = [QSignalBlocker(widget) for widget in widgets]
        self.shown.setChecked(look.shown)
        self.of_all.setChecked(look.of_all)
        self.lattice.setChecked(look.lattice)
        self.opacity.setValue(round(look.opacity * _PERCENT))
        self.density.setValue(_step(look.density))
        del blockers
        self._on_changed()

    @property
    def look(self) -> RayLook:
        """The look that check box and sliders give."""
        density = 2.0 ** (self.density.value() / _PER_OCTAVE)
        return RayLook(
            self.shown.isChecked(), self.opacity.value() / _PERCENT, density, self._fill,
            self.of_all.isChecked(), self.lattice.isChecked(), self.limits.value or DEFAULT_RAYS.px_per_m,
        )  # fmt: skip

    def _on_limits(self, limits: tuple[float, ...]) -> None:
        """Take limits of bands, unless they do not fall."""
        try:
            self.limits.set_value(checked_limits(limits))
        except InputError as error:
            self.limits.mark(str(error))
            return
        self._on_changed()

    def _on_changed(self, _: object = None) -> None:
        look = self.look
        for widget in (self.of_all, self.lattice, self.opacity, self.density):
            widget.setEnabled(look.shown)
        self.say({"Opacity": f"{100 * look.opacity:.0f} %", "Density": f"× {look.density:.2g}"})
        self.look_changed.emit(look)


def _step(density: float) -> int:
    return round(_PER_OCTAVE * math.log2(density))
