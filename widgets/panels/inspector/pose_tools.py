"""Heading of the pose with what can be done to it: other units, copy, paste, reset."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QActionGroup, QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QToolButton, QWidget

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.pose_text import POSE_FORMATS, PoseFormat, parse_pose, pose_text
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, MILLIMETRES, RADIANS, Unit
from riglens.widgets.panels.icons import icon
from riglens.widgets.panels.menus import add_entry

_SHOWN_UNITS = ((METRES, MILLIMETRES), (DEGREES, RADIANS))
PASTE_TIP = (
    "Take the pose from the clipboard: YAML, x y z roll pitch yaw (m, deg), x y z qx qy qz qw, 4 × 4 matrix"
)


class PoseTools(QWidget):
    """A line with the title and small buttons; it knows the pose shown and signals requests for another one."""

    pasted = Signal(object)
    """A Pose, in metres and degrees."""
    refused = Signal(str)
    """Why the clipboard holds no pose."""
    units_chosen = Signal(object)
    """The Unit in which lengths or angles are to be shown."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._pose = Pose()
        self._saved: Pose | None = None
        self._form: PoseFormat = "yaml"
        line = QHBoxLayout(self)
        line.setContentsMargins(0, 4, 0, 0)
        line.setSpacing(2)
        title = QLabel("Pose")
        title.setObjectName("heading")
        title.setIndent(0)
        line.addWidget(title)
        line.addStretch(1)
        self._units = [self._unit_button(first, second) for first, second in _SHOWN_UNITS]
        self._copy = self._button("copy_pose", "copy", "", self.copy)
        self._copy.setMenu(self._format_menu())
        self._copy.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        self._paste = self._button("paste_pose", "paste", PASTE_TIP, self.paste)
        self._reset = self._button("reset_pose", "reset", "Reset the pose", None)
        self._reset.setMenu(self._reset_menu())
        self._reset.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        for button in (*self._units, self._copy, self._paste, self._reset):
            line.addWidget(button)
        self._choose_format("yaml")

    # ------------------------------------------------------------------ what is shown
    def set_pose(self, pose: Pose) -> None:
        """Set the pose that is copied."""
        self._pose = pose

    def set_saved(self, pose: Pose | None) -> None:
        """Set the pose of this sensor in the file, None when it is not in the file."""
        self._saved = pose
        self._as_saved.setEnabled(pose is not None)

    def show_units(self, *units: Unit) -> None:
        """Name the units in use on the buttons."""
        for button, pair in zip(self._units, _SHOWN_UNITS, strict=True):
            shown = next((unit for unit in pair if unit in units), pair[0])
            button.setText(shown.name)

    def set_editable(self, editable: bool) -> None:
        """Allow pasting and resetting, or only copying."""
        self._paste.setEnabled(editable)
        self._reset.setEnabled(editable)

    # ------------------------------------------------------------------ what the user does
    def copy(self) -> None:
        """Copy the pose to the clipboard, in the chosen format."""
        QGuiApplication.clipboard().setText(pose_text(self._pose, self._form))

    def paste(self) -> None:
        """Take the pose from the clipboard."""
        try:
            pose = parse_pose(QGuiApplication.clipboard().text())
        except InputError as error:
            self.refused.emit(str(error))
        else:
            self.pasted.emit(pose)

    def _choose_format(self, form: PoseFormat) -> None:
        self._form = form
        self._copy.setToolTip(f"Copy the pose as {POSE_FORMATS[form]}")

    def _copy_as(self, form: PoseFormat) -> None:
        self._choose_format(form)
        self.copy()

    def _level(self) -> None:
        self.pasted.emit(Pose(self._pose.position_m, (0.0, 0.0, self._pose.rpy_deg[2])))

    def _unturned(self) -> None:
        self.pasted.emit(Pose(self._pose.position_m))

    def _put_back(self) -> None:
        if self._saved is not None:
            self.pasted.emit(self._saved)

    # ------------------------------------------------------------------ building
    def _button(self, name: str, picture: str, tip: str, slot: object) -> QToolButton:
        button = QToolButton()
        button.setObjectName(name)
        button.setIcon(icon(picture))
        button.setToolTip(tip)
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        if slot is not None:
            button.clicked.connect(slot)
        return button

    def _unit_button(self, first: Unit, second: Unit) -> QToolButton:
        button = QToolButton()
        button.setObjectName(f"unit_{first.quantity}")
        button.setText(first.name)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setFixedWidth(34)
        button.setToolTip(f"Show in {first.name} or {second.name}; files and copies always use {first.name}")
        button.clicked.connect(
            lambda: self.units_chosen.emit(second if button.text() == first.name else first)
        )
        return button

    def _format_menu(self) -> QMenu:
        menu = QMenu(self)
        group = QActionGroup(menu)
        for form, title in POSE_FORMATS.items():
            action = add_entry(menu, title, partial(self._copy_as, form))
            action.setObjectName(form)
            action.setCheckable(True)
            action.setChecked(form == self._form)
            group.addAction(action)
        return menu

    def _reset_menu(self) -> QMenu:
        menu = QMenu(self)
        add_entry(menu, "Level: roll and pitch 0", self._level)
        add_entry(menu, "No rotation: roll, pitch, yaw 0", self._unturned)
        self._as_saved: QAction = add_entry(menu, "Pose as last saved", self._put_back)
        self._as_saved.setEnabled(False)
        return menu
