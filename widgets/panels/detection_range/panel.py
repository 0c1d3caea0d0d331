"""Detection range panel: the distance up to which the rig detects an object in the open, next to stopping distances."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from riglens.core.targets.detection_range import FARTHEST_M, DetectionRange, RangePlan
from riglens.widgets.panels.controls.building import button, filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel, plain_tip
from riglens.widgets.panels.detection_range.chart import RangeChart
from riglens.widgets.panels.detection_range.table import RangeTable

MOST_POINTS, MOST_PX, LEAST_TO_M = 1000, 2000, 10
_BUTTON_PX, _BOX_PX = 72, 116
HELP = (
    "One object of the mean size in the bundled town, on flat ground, at every "
    "distance in eight directions. The table shows the first distance in metres at which it "
    "falls below the thresholds; more is better.\nLiDARs: worst-median-best position "
    "between the beams. Cameras: height in pixels.\nNo traffic occludes it, "
    "and every ray returns. The car is solid."
)
ENOUGH_TIP = (
    "The thresholds are your choice. Conventions: nuScenes scores objects with 1 point or more, Waymo rates those with "
    "fewer than 5 as hard (LEVEL_2); KITTI requires 40 px (easy) or 25 px (moderate, hard)."
)
STOP_TIP = "Braking model (our choice): enter your own. Stopping distance: v t + v² / 2a."
_BOXES = {
    "min_points": ("card_points", (1, MOST_POINTS), None, "≥ ", " points", ENOUGH_TIP),
    "min_height_px": ("card_px", (1, MOST_PX), 0, "≥ ", " px", ENOUGH_TIP),
    "to_m": ("card_to", (LEAST_TO_M, int(FARTHEST_M)), None, "up to ", " m", "Maximum distance."),
    "reaction_s": ("card_reaction", (0, 60), 1, "reaction ", " s", STOP_TIP),
    "deceleration_mps2": ("card_brake", (1, 20), 1, "brakes ", " m/s²", STOP_TIP),
}
"""Boxes by the fields of a RangePlan: name, ends, decimals (None of integers), words around the number, tooltip."""


class RangePanel(QWidget):
    """Panel that shows detection ranges and the rig they belong to, and edits the thresholds and the braking model."""

    plan_wanted = Signal(object)
    """Request for another RangePlan."""
    stop_wanted = Signal()
    make_wanted = Signal()
    export_wanted = Signal()

    def __init__(self, plan: RangePlan, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._plan = plan
        self._ranges: DetectionRange | None = None
        self.table, self.chart = RangeTable(), RangeChart()
        _keep_room(self.table)  # nothing is shown in it before there are ranges
        self.table.hide()
        self._note, self._ways = (plain_label(style="hint", shrinks=True) for _ in range(2))
        self._note.setToolTip(plain_tip(HELP))
        self._bar, self._button = QProgressBar(), button(QPushButton(), self._on_button, "", "card_button")
        tip = "Save all distances of the current rig."
        self.export = button(QPushButton("CSV…"), self.export_wanted, tip, "card_export")
        self._bar.setRange(0, 100)
        self._bar.setFixedWidth(110)
        self._button.setFixedWidth(_BUTTON_PX)
        top = _row(self._note, 1, self._bar, self._button, self.export)
        body = filled(QHBoxLayout(), self.table, 1, self.chart, spacing=0)
        filled(QVBoxLayout(self), top, body, 1, self._controls(), spacing=0)
        self.table.row_chosen.connect(self._show_chart)
        self.show_plan(plan)
        self.show_progress(None)
        self.show_current(False)

    def _controls(self) -> QHBoxLayout:
        self._boxes: dict[str, QSpinBox | QDoubleSpinBox] = {}
        for field, (name, ends, decimals, prefix, suffix, tip) in _BOXES.items():
            box = self._boxes[field] = QSpinBox() if decimals is None else QDoubleSpinBox()
            if isinstance(box, QDoubleSpinBox) and decimals is not None:
                box.setDecimals(decimals)
                box.setSingleStep(0.1**decimals)
            box.setObjectName(name)
            box.setFixedWidth(_BOX_PX)
            box.setRange(*ends)
            box.setPrefix(prefix)
            box.setSuffix(suffix)
            box.setToolTip(plain_tip(tip))
            box.setKeyboardTracking(False)
            box.valueChanged.connect(lambda _: self._on_values())
        self._ways.setToolTip(plain_tip(STOP_TIP))
        return _row(QLabel("Threshold"), *self._boxes.values(), self._ways, 1)

    # ------------------------------------------------------------------ what is shown
    def show_plan(self, plan: RangePlan) -> None:
        """Show the thresholds and the braking model."""
        self._plan = plan
        for field, box in self._boxes.items():
            value = getattr(plan, field)
            with QSignalBlocker(box):
                box.setValue(round(value) if isinstance(box, QSpinBox) else value)
        ways = ", ".join(f"{plan.stopping_m(speed):.0f}" for speed in plan.speeds_kmh)
        self._ways.setText(f"stops in {ways} m from {', '.join(f'{v:g}' for v in plan.speeds_kmh)} km/h")

    def show_range(self, ranges: DetectionRange) -> None:
        """Show the ranges of a rig."""
        self._ranges = ranges
        self.table.show()
        self.table.show_range(ranges)
        self._show_chart()

    def _show_chart(self) -> None:
        line = self.table.line
        if self._ranges is not None and line is not None:
            self.chart.show_line(self._ranges, line)

    def show_current(self, is_current: bool) -> None:
        """Show whether the results belong to the current rig: otherwise they are greyed and not exported."""
        self.export.setEnabled(is_current)
        if not is_current:
            self.table.figures.grey()
            self.chart.grey()

    def say(self, text: str) -> None:
        """Show which rig the ranges are of."""
        self._note.setText(text)

    @property
    def note(self) -> str:
        """Return the note on the detection ranges."""
        return self._note.text()

    def show_progress(self, share: float | None, can_make: bool = False) -> None:
        """Show the progress of a computation, with a way to stop; or, when none runs, whether one can be requested."""
        self._bar.setVisible(share is not None)
        self._bar.setValue(round(100.0 * (share or 0.0)))
        self._button.setVisible(share is not None or can_make)
        self._button.setText("Update" if share is None else "Stop")

    def _on_button(self) -> None:
        (self.make_wanted if self._button.text() == "Update" else self.stop_wanted).emit()

    def _on_values(self) -> None:
        values = {field: type(getattr(self._plan, field))(box.value()) for field, box in self._boxes.items()}
        self.plan_wanted.emit(replace(self._plan, **values))


def _keep_room(widget: QWidget) -> None:
    """Have a widget keep its place in the layout while it is hidden."""
    policy = widget.sizePolicy()
    policy.setRetainSizeWhenHidden(True)
    widget.setSizePolicy(policy)


def _row(*parts: QWidget | int) -> QHBoxLayout:
    return filled(QHBoxLayout(), *parts, margins=(MARGIN, 5, MARGIN, 5), spacing=SPACING)
