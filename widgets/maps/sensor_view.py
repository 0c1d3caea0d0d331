"""Sensor view: the selected sensor's view of one frame of the data set."""

from __future__ import annotations

from html import escape

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QSlider,
    QSpinBox,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from riglens.core.view.camera_picture import CameraPicture
from riglens.core.view.range_image import RangeImage
from riglens.widgets.maps.camera_view import CameraView
from riglens.widgets.maps.range_view import RangeView
from riglens.widgets.panels.controls.building import filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel

COLOURINGS = {"range": "Colour: range", "hit": "Colour: surface"}


class SensorViewPanel(QWidget):
    """A header with the sensor's name and the choice of the frame over an image, or over a text."""

    frame_chosen = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.camera, self.ranges, self.text = CameraView(), RangeView(), plain_label(style="hint", wraps=True)
        self.text.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.text.setMargin(MARGIN)
        self._build_header()
        self._stack = QStackedWidget()
        self._pages: tuple[QWidget, ...] = (self.text, self.camera, self.ranges)
        for page in self._pages:
            self._stack.addWidget(page)
        self.note = plain_label(style="hint", wraps=True)
        self.note.setContentsMargins(MARGIN, 0, MARGIN, 2)
        filled(QVBoxLayout(self), self._header, self._stack, 1, self.note, spacing=0)
        self.set_note("")
        self.set_frames(0)
        self.show_text("")

    def _build_header(self) -> None:
        self._header = QWidget()
        self.title = QLabel()
        self.title.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.frame, self.slider = QSpinBox(), QSlider(Qt.Orientation.Horizontal)
        self.frame.setObjectName("frame")
        self.frame.setToolTip("Frame of the data set, counted from 0.")
        self.frame.setKeyboardTracking(False)
        self.slider.setMinimumWidth(60)
        self._of = QLabel()
        self.rays = QCheckBox("Rays")
        self.rays.setToolTip("Show where rays cast for the score pass through the image (only a selection).")
        self.rays.toggled.connect(self.camera.set_rays)
        self.colouring = QComboBox()
        for key, title in COLOURINGS.items():
            self.colouring.addItem(title, key)
        self.colouring.currentIndexChanged.connect(
            lambda _: self.ranges.set_colouring(self.colouring.currentData())
        )
        self.title.setMinimumHeight(self.colouring.sizeHint().height())  # keeps the header from moving
        first = filled(QHBoxLayout(), self.title, 1, self.rays, self.colouring, spacing=SPACING)
        second = filled(QHBoxLayout(), QLabel("Frame"), self.frame, self._of, self.slider, 1, spacing=SPACING)
        filled(QVBoxLayout(self._header), first, second, margins=(MARGIN, 4, MARGIN, 4), spacing=2)
        self.frame.valueChanged.connect(self._choose)
        self.slider.valueChanged.connect(self._choose)

    # ------------------------------------------------------------------ what is shown
    def set_title(self, name: str) -> None:
        """Set the name of the sensor."""
        self.title.setText(f"<b>{escape(name)}</b>")

    def set_frames(self, count: int) -> None:
        """Set the number of frames; the chosen one stays if it is still valid."""
        with QSignalBlocker(self.frame), QSignalBlocker(self.slider):
            self.frame.setRange(0, max(0, count - 1))
            self.slider.setRange(0, max(0, count - 1))
            self.slider.setValue(self.frame.value())
        self._of.setText(f"of {count:,}")
        for widget in (self.frame, self.slider):
            widget.setEnabled(count > 1)

    def choose_frame(self, number: int) -> None:
        """Choose another frame without asking for its picture."""
        with QSignalBlocker(self.frame), QSignalBlocker(self.slider):
            self.frame.setValue(number)
            self.slider.setValue(self.frame.value())

    @property
    def chosen_frame(self) -> int:
        """The frame that is shown."""
        return self.frame.value()

    def show_text(self, text: str) -> None:
        """Show why there is no picture."""
        self.text.setText(text)
        self._show_page(self.text)

    def show_camera(self, picture: CameraPicture) -> None:
        """Show a camera's picture."""
        self.camera.set_picture(picture)
        self._show_page(self.camera)

    def show_ranges(self, image: RangeImage, reach_m: float) -> None:
        """Show a LiDAR's ranges, coloured up to `reach_m`."""
        self.ranges.set_image(image, reach_m)
        self._show_page(self.ranges)

    def set_note(self, text: str) -> None:
        """Show a remark below the picture, none when it is empty."""
        self.note.setText(text)
        self.note.setVisible(bool(text))

    @property
    def page(self) -> QWidget:
        """The widget that is shown: `text`, `camera` or `ranges`."""
        return self._pages[self._stack.currentIndex()]

    def _show_page(self, page: QWidget) -> None:
        self._stack.setCurrentWidget(page)
        self._header.setVisible(page is not self.text)
        self.rays.setVisible(page is self.camera)
        self.colouring.setVisible(page is self.ranges)

    def _choose(self, frame: int) -> None:
        with QSignalBlocker(self.frame), QSignalBlocker(self.slider):
            self.frame.setValue(frame)
            self.slider.setValue(frame)
        self.frame_chosen.emit(frame)
