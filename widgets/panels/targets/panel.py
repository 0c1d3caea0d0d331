"""Targets panel: the rig's figures for objects, by class, distance and direction."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QSpinBox,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import object_figures
from riglens.core.figures.values import FigureCells
from riglens.core.targets.settings import TargetSettings
from riglens.widgets.panels.controls.building import button, filled, tool
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.scrolled import ElidedLabel
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel, plain_tip
from riglens.widgets.panels.fields.form import ChoiceBox
from riglens.widgets.panels.targets.rose import RoseView
from riglens.widgets.panels.targets.table import TargetTable

if TYPE_CHECKING:  # made by the thread that counts, which loads the compiler
    from riglens.core.targets.counts import Counted

FRAME_TIP = (
    "Show one frame in the 3D view: objects coloured by their LiDAR points (red none, "
    "orange too few, light and dark green enough and many), occluders in grey, and the ends "
    "of LiDAR rays. Points are those of the table: class shapes, range law, random spin "
    "phase. The dots are nominal rays on plain boxes."
)
MOST_POINTS = 1000
WAITING = "Counting objects…"
POINTS_TIP = (
    "An object with at least this many LiDAR points counts as detected. Our choice is 5: Waymo rates objects "
    "with fewer as hard (LEVEL_2), nuScenes scores objects with 1 point or more."
)


class TargetsPanel(QWidget):
    """Panel with the counts of one rig next to those of the baseline. Outdated numbers are greyed."""

    settings_wanted = Signal(object)
    """Request for other TargetSettings."""
    frame_wanted = Signal(object)
    """The number of the frame to show in the 3D view, None for none."""
    play_wanted = Signal(bool)
    """Frames are to be shown one after the other, or not any more."""
    next_missed_wanted = Signal()
    """Request to show the next missed object."""

    def __init__(self, settings: TargetSettings, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._settings = settings
        self._shown: tuple[Counted, Counted, str] | None = None
        self._is_stale = self._is_behind = False
        self.table, self.rose = TargetTable(), RoseView()
        self.table.explain(WAITING)
        self._choice, self._points = ChoiceBox(), QSpinBox()
        self._note = ElidedLabel(WAITING)
        self._note.setObjectName("hint")
        self._note.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._figures: tuple[ObjectFigure, ...] = ()
        self._said = ""
        body = filled(QHBoxLayout(), self.table, 1, self.rose, spacing=0)
        filled(QVBoxLayout(self), body, 1, self._controls(), spacing=0)
        self.table.row_chosen.connect(self._show_rose)

    def _controls(self) -> QHBoxLayout:
        self._choice.setObjectName("target_quantity")
        self._offer(())
        self._choice.currentIndexChanged.connect(lambda _: self._show())
        self._points.setObjectName("min_points")
        self._points.setRange(1, MOST_POINTS)
        self._points.setValue(self._settings.min_points)
        self._points.setSuffix(" points")
        self._points.setPrefix("≥ ")
        self._points.setKeyboardTracking(False)
        self._points.setToolTip(POINTS_TIP)
        self._points.valueChanged.connect(self._on_points)
        row = filled(
            QHBoxLayout(), QLabel("Show"), self._choice, QLabel("Detected from"), self._points,
            margins=(MARGIN, 5, MARGIN, 6), spacing=SPACING,
        )  # fmt: skip
        row.addSpacing(SPACING)
        for control in self._frame_controls():
            row.addWidget(control)
        row.addSpacing(SPACING)
        row.addWidget(self._note, 1)
        return row

    def _frame_controls(self) -> tuple[QWidget, ...]:
        """Return the controls that choose the frame in the 3D view; disabled until there is one."""
        self._frame_on = button(QToolButton(), tip=FRAME_TIP, name="frame_on", text="Frame")
        self._frame_on.setCheckable(True)
        self._frame_on.toggled.connect(lambda _: self._emit_frame())
        self._frame = QSpinBox()
        self._frame.setObjectName("frame_number")
        self._frame.setKeyboardTracking(False)
        self._frame.setToolTip("Number of the frame in the data, from 0.")
        self._frame.valueChanged.connect(lambda _: self._emit_frame())
        self._play = tool(icon("play"), tip="Play all frames.", name="play_frames")
        self._play.setCheckable(True)
        self._play.toggled.connect(self.play_wanted)
        tip = "Show the next object that no sensor detects, the nearest first."
        self._next = button(QToolButton(), self.next_missed_wanted, tip, "next_missed", "Next missed")
        self.set_frames(0)
        return self._frame_on, self._frame, self._play, self._next

    def set_frames(self, count: int) -> None:
        """Set the number of frames to choose from."""
        for widget in (self._frame_on, self._frame, self._play, self._next):
            widget.setEnabled(count > 0)
        with QSignalBlocker(self._frame):
            self._frame.setRange(0, max(count - 1, 0))

    def show_frame(self, number: int | None) -> None:
        """Show which frame the 3D view shows, without asking for it."""
        with QSignalBlocker(self._frame), QSignalBlocker(self._frame_on):
            self._frame_on.setChecked(number is not None)
            if number is not None:
                self._frame.setValue(number)

    def show_playing(self, is_playing: bool) -> None:
        """Show whether frames are being played, without asking for it."""
        with QSignalBlocker(self._play):
            self._play.setChecked(is_playing)
        self._play.setIcon(icon("pause" if is_playing else "play"))

    def _emit_frame(self) -> None:
        self.frame_wanted.emit(self._frame.value() if self._frame_on.isChecked() else None)

    def say(self, text: str, stays: bool = False) -> None:
        """Show a text in place of the note, until new counts arrive or, where it stays, until `unsay`."""
        self._said = text if stays else ""
        self._note.setText(text)
        self._note.setToolTip(plain_tip(text))

    def unsay(self) -> None:
        """Show the note again."""
        if self._said:
            self._said = ""
            self._show_note()

    @property
    def figure(self) -> ObjectFigure:
        """Return the figure shown."""
        return self._figures[self._choice.currentIndex()]

    def choose(self, key: str) -> None:
        """Show another figure by its key; ignore unknown keys."""
        self._offer((key,))
        self._choice.setCurrentIndex(max(self._choice.findData(key), 0))

    def _offer(self, kinds: Iterable[str]) -> None:
        """List the figures of rigs with sensors of some kinds; the one shown stays."""
        chosen = self._choice.currentData()
        figures = object_figures({*kinds, chosen})
        if [one.key for one in figures] == [one.key for one in self._figures]:
            return
        self._figures = figures
        with QSignalBlocker(self._choice):
            self._choice.clear()
            for number, figure in enumerate(figures):
                self._choice.addItem(figure.title, figure.key)
                self._choice.setItemData(number, figure.tip, Qt.ItemDataRole.ToolTipRole)
            self._choice.setCurrentIndex(max(self._choice.findData(chosen), 0))

    def show_settings(self, settings: TargetSettings) -> None:
        """Show settings that were chosen elsewhere."""
        self._settings = settings
        with QSignalBlocker(self._points):
            self._points.setValue(settings.min_points)

    def show_counts(self, now: Counted, before: Counted, baseline: str) -> None:
        """Show counts next to those of the baseline, which is called `baseline`; both from the same frames."""
        self._shown, self._is_stale = (now, before, baseline), False
        self._offer((*now.objects.returns, *before.objects.returns))
        self._show()

    def showEvent(self, event: QShowEvent) -> None:
        """Show the latest counts when the panel becomes visible: no table is made while it is hidden."""
        super().showEvent(event)
        if self._is_behind:
            self._show()

    def show_problem(self, reason: str) -> None:
        """Show why there are no counts."""
        self._shown = None
        self.table.figures.forget()
        self.table.explain(reason)
        self.rose.forget()
        self._note.setText(reason)
        self._note.setToolTip(reason)

    def set_stale(self) -> None:
        """Grey the numbers: newer ones are on their way."""
        self._is_stale = True
        self.table.figures.grey()
        self.rose.grey()

    def _show(self) -> None:
        self._is_behind = self._shown is not None and not self.isVisible()
        if self._shown is None or self._is_behind:
            return
        now, before, baseline = self._shown
        whole = FigureCells.of(self.figure, now, before)
        rings = FigureCells.of(self.figure, now, before, "ring")
        self.table.show_figure(whole, rings, now.groups.edges_m.tolist(), baseline)
        self._show_rose()
        self._show_note()
        if self._is_stale:
            self.set_stale()

    def _show_note(self) -> None:
        if self._shown is not None and not self._said:
            now, _, _ = self._shown
            self._note.setText(_note(now))
            self._note.setToolTip(self.figure.tip)

    def _show_rose(self) -> None:
        if self._shown is not None and not self._is_behind:
            now, before, baseline = self._shown
            cells = FigureCells.of(self.figure, now, before, "ring and sector")
            self.rose.show_figure(cells, self.table.who, now.groups.edges_m.tolist(), baseline)

    def _on_points(self, number: int) -> None:
        self._settings = replace(self._settings, min_points=number)
        self.settings_wanted.emit(self._settings)


def _note(counted: Counted) -> str:
    """Describe the number of objects and of frames, and the accuracy."""
    users = f"{len(counted.objects.box):,} objects within {counted.within_m:g} m"
    if counted.is_whole:
        return f"{users}, all {counted.frames:,} frames"
    return f"{users}, sample of {counted.frames_used:,} of {counted.frames:,} frames, ± two standard errors"
