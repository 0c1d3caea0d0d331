"""Ask for the options of a picture for a report, with a preview that is the picture itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from PySide6.QtCore import QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from riglens.widgets.panels.controls.building import button, filled, plain_label
from riglens.widgets.panels.controls.messages import ProgressStrip
from riglens.widgets.panels.controls.style import MARGIN, SPACING

_PREVIEW = QSize(560, 380)
_CHECK_PX = 10


@dataclass(frozen=True)
class PictureChoice:
    """Choice in the dialog; `size_px` is width and height before `scale` enlarges everything."""

    size_px: tuple[int, int]
    scale: int = 1
    transparent: bool = False
    light: bool = False
    legend: bool = True
    title: bool = False
    scores: bool = False
    ground: bool = True


class Preview(QWidget):
    """A picture as large as fits; transparent parts show a chequered background."""

    def __init__(self) -> None:
        super().__init__()
        self.image = QImage()
        self.setMinimumSize(_PREVIEW)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    @property
    def room_px(self) -> tuple[int, int]:
        """Pixels of the screen that a picture has room in."""
        ratio = self.devicePixelRatioF()
        return round(self.width() * ratio), round(self.height() * ratio)

    def show_png(self, png: bytes) -> None:
        """Show a PNG file."""
        self.image = QImage.fromData(png)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the picture in the middle."""
        if self.image.isNull():
            return
        size = self.image.size().scaled(self.size(), Qt.AspectRatioMode.KeepAspectRatio)
        place = QRect((self.width() - size.width()) // 2, (self.height() - size.height()) // 2, 0, 0)
        place.setSize(size)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        if self.image.hasAlphaChannel():
            _chequer(painter, place)
        painter.drawImage(place, self.image)
        painter.end()


def _chequer(painter: QPainter, place: QRect) -> None:
    painter.fillRect(place, QColor("#ffffff"))
    for x in range(place.left(), place.right(), _CHECK_PX):
        for y in range(place.top(), place.bottom(), _CHECK_PX):
            if (x - place.left() + y - place.top()) // _CHECK_PX % 2:
                painter.fillRect(QRect(x, y, _CHECK_PX, _CHECK_PX).intersected(place), QColor("#d5d9de"))


class PictureDialog(QDialog):
    """Options next to a preview; neither draws nor saves anything itself."""

    changed = Signal()
    save_wanted = Signal()
    copy_wanted = Signal()

    def __init__(
        self, size_px: tuple[int, int], limits_px: tuple[int, int], light: bool, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Picture of the view")
        self.preview, self._note = Preview(), plain_label(style="hint")
        self.busy = ProgressStrip("Drawing")
        self.busy.bar.setRange(0, 0)
        self.busy.bar.setTextVisible(True)
        self._limits_px = limits_px
        self.width_px, self.height_px = (self._spin(side) for side in size_px)
        self.scale = QComboBox()
        self.scale.addItems([f"{factor} ×" for factor in range(1, 5)])
        self.scale.currentIndexChanged.connect(self._on_changed)
        self.legend = self._box("Colour bar", "Show the legend of the heatmap.", True)
        self.title = self._box(
            "Name of the rig", "Show the name, sensors and data in the upper corner.", False
        )
        self.scores = self._box("Scores", "Show the table of scores in the lower corner.", False)
        self.light = self._box("Light background", "Draw in the light theme, for white paper.", light)
        self.transparent = self._box("Transparent background", "Let the page show through.", False)
        self.ground = self._box("Ground", "Draw the ground with its road and rings.", True)
        self._options = {
            "legend": self.legend, "title": self.title, "scores": self.scores, "ground": self.ground,
            "light": self.light, "transparent": self.transparent,
        }  # fmt: skip
        self.save = button(QPushButton("Save…"), self.save_wanted)
        self.copy = button(QPushButton("Copy"), self.copy_wanted)
        self.save.setDefault(True)
        self._build()
        self._show_size()

    def _spin(self, side_px: int) -> QSpinBox:
        spin = QSpinBox()
        spin.setRange(*self._limits_px)
        spin.setValue(side_px)
        spin.setKeyboardTracking(False)
        spin.valueChanged.connect(self._on_changed)
        return spin

    def _box(self, caption: str, tip: str, is_on: bool) -> QCheckBox:
        box = QCheckBox(caption)
        box.setToolTip(tip)
        box.setChecked(is_on)
        box.toggled.connect(self._on_changed)
        return box

    def _build(self) -> None:
        fields = QGridLayout()
        fields.setSpacing(SPACING)
        rows = (("Width", self.width_px), ("Height", self.height_px), ("Enlarge", self.scale))
        for row, (caption, field) in enumerate(rows):
            fields.addWidget(QLabel(caption), row, 0)
            fields.addWidget(field, row, 1)
        for box in self._options.values():
            fields.addWidget(box, fields.rowCount(), 0, 1, 2)
        fields.addWidget(self._note, fields.rowCount(), 0, 1, 2)
        fields.setRowStretch(fields.rowCount(), 1)
        close = button(QPushButton("Close"), self.reject)
        buttons = filled(QHBoxLayout(), self.busy, None, self.copy, self.save, close)
        upper = filled(QHBoxLayout(), self.preview, 1, fields, spacing=2 * MARGIN)
        filled(QVBoxLayout(self), upper, 1, buttons, margins=(2 * MARGIN,) * 4, spacing=2 * SPACING)

    @property
    def choice(self) -> PictureChoice:
        """Return the choice."""
        return PictureChoice(
            (self.width_px.value(), self.height_px.value()), self.scale.currentIndex() + 1,
            self.transparent.isChecked(), self.light.isChecked(), self.legend.isChecked(),
            self.title.isChecked(), self.scores.isChecked(), self.ground.isChecked(),
        )  # fmt: skip

    def recall(self, options: Mapping[str, bool], scale: int) -> None:
        """Choose again what was chosen the last time; options that there are not are passed over."""
        for name, box in self._options.items():
            if name in options:
                box.setChecked(options[name])
        self.scale.setCurrentIndex(min(max(scale, 1), self.scale.count()) - 1)

    @property
    def options(self) -> dict[str, bool]:
        """Return the ticked options, by name."""
        return {name: box.isChecked() for name, box in self._options.items()}

    def set_words_possible(self, possible: bool) -> None:
        """Set whether there are scores to write into a picture."""
        for box in (self.title, self.scores):
            box.setEnabled(possible)

    def set_busy(self, what: str) -> None:
        """Show the current activity, with a bar and Cancel if it lasts; "" when there is none, and then pictures can be
        saved."""
        is_too_large = max(self._pixels()) > self._limits_px[1]
        for made in (self.save, self.copy):
            made.setEnabled(not what and not is_too_large)
        if what:
            self._note.setText(what)
            self.busy.begin()
        else:
            self._show_size()
            self.busy.end()

    def set_done(self, what: str) -> None:
        """Show the result of the last action."""
        self._note.setText(what)

    def _pixels(self) -> tuple[int, int]:
        choice = self.choice
        return choice.size_px[0] * choice.scale, choice.size_px[1] * choice.scale

    def _show_size(self) -> None:
        width, height = self._pixels()
        too_large = (
            f"\nat most {self._limits_px[1]} a side" if max(width, height) > self._limits_px[1] else ""
        )
        self._note.setText(f"{width} × {height} pixels{too_large}")

    def _on_changed(self, _: object = None) -> None:
        self._show_size()
        self.changed.emit()
