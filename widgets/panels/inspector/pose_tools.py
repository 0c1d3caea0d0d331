"""Lines of a sensor's form with buttons: the mirror pair, and the pose with other units, copy, paste, reset."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QActionGroup, QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QPushButton, QToolButton, QWidget

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.pose_text import POSE_FORMATS, PoseFormat, parse_pose, pose_text
from riglens.widgets.panels.controls.building import button, filled, plain_label, tool
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.controls.scrolled import breakable
from riglens.widgets.panels.controls.style import plain_tip
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, MILLIMETRES, RADIANS, Unit
from riglens.widgets.panels.sensors.rows import pair_note
from riglens.widgets.theme import LINKED_COLOUR

_SHOWN_UNITS = ((METRES, MILLIMETRES), (DEGREES, RADIANS))
PASTE_TIP = (
    "Paste the pose from the clipboard: YAML, x y z roll pitch yaw (m, deg), x y z qx qy qz qw, 4 × 4 matrix"
)


class PoseTools(QWidget):
    """A line with the title and small buttons; it knows the pose shown and signals requests for another one."""

    posed = Signal(object)
    """New pose of a sensor (metres and degrees): a function of its name and its current pose."""
    refused = Signal(str)
    """Reason why the clipboard holds no pose."""
    units_chosen = Signal(object)
    """The Unit in which lengths or angles are to be shown."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._pose = Pose()
        self._saved: dict[str, Pose] = {}
        self._is_alone = self._is_editable = True
        self._form: PoseFormat = "yaml"
        title = QLabel("Pose")
        title.setObjectName("heading")
        title.setIndent(0)
        self._units = [self._unit_button(first, second) for first, second in _SHOWN_UNITS]
        self._copy = self._button("copy_pose", "copy", "", self.copy)
        self._copy.setMenu(self._format_menu())
        self._copy.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        self._paste = self._button("paste_pose", "paste", PASTE_TIP, self.paste)
        self._reset = self._button("reset_pose", "reset", "Reset the pose", None)
        self._reset.setMenu(self._reset_menu())
        self._reset.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        filled(
            QHBoxLayout(self), title, None, *self._units, self._copy, self._paste, self._reset,
            margins=(0, 4, 0, 0), spacing=2,
        )  # fmt: skip
        self._choose_format("yaml")

    # ------------------------------------------------------------------ what is shown
    def set_pose(self, pose: Pose) -> None:
        """Set the pose that is copied."""
        self._pose = pose

    def set_saved(self, poses: dict[str, Pose]) -> None:
        """Set the saved poses of the selected sensors, as far as they are in the file."""
        self._saved = poses
        self._as_saved.setEnabled(bool(poses))

    def set_alone(self, is_alone: bool) -> None:
        """Set whether one sensor is selected: a pose pasted to several would stack them."""
        self._is_alone = is_alone
        self.set_editable(self._is_editable)

    def show_units(self, *units: Unit) -> None:
        """Name the units in use on the buttons."""
        for made, pair in zip(self._units, _SHOWN_UNITS, strict=True):
            shown = next((unit for unit in pair if unit in units), pair[0])
            made.setText(shown.name)

    def set_editable(self, editable: bool) -> None:
        """Allow pasting and resetting, or only copying."""
        self._is_editable = editable
        self._paste.setEnabled(editable and self._is_alone)
        self._reset.setEnabled(editable)

    # ------------------------------------------------------------------ what the user does
    def copy(self) -> None:
        """Copy the pose to the clipboard, in the chosen format."""
        QGuiApplication.clipboard().setText(pose_text(self._pose, self._form))

    def paste(self) -> None:
        """Paste the pose from the clipboard."""
        try:
            pose = parse_pose(QGuiApplication.clipboard().text())
        except InputError as error:
            self.refused.emit(str(error))
        else:
            self.posed.emit(lambda name, now: pose)

    def _choose_format(self, form: PoseFormat) -> None:
        self._form = form
        self._copy.setToolTip(f"Copy the pose as {POSE_FORMATS[form]}")

    def _copy_as(self, form: PoseFormat) -> None:
        self._choose_format(form)
        self.copy()

    def _level(self) -> None:
        self.posed.emit(lambda name, now: Pose(now.position_m, (0.0, 0.0, now.rpy_deg[2])))

    def _unturned(self) -> None:
        self.posed.emit(lambda name, now: Pose(now.position_m))

    def _put_back(self) -> None:
        saved = dict(self._saved)
        self.posed.emit(lambda name, now: saved.get(name, now))

    # ------------------------------------------------------------------ building
    def _button(self, name: str, picture: str, tip: str, slot: Callable[[], None] | None) -> QToolButton:
        made = tool(icon(picture), slot, tip, name)
        made.setAutoRaise(True)
        made.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        return made

    def _unit_button(self, first: Unit, second: Unit) -> QToolButton:
        def choose() -> None:
            self.units_chosen.emit(second if made.text() == first.name else first)

        tip = f"Show in {first.name} or {second.name}; files and copies always use {first.name}"
        made = button(QToolButton(), choose, tip, f"unit_{first.quantity}", first.name)
        made.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        made.setFixedWidth(34)
        return made

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
        self._as_saved: QAction = add_entry(menu, "Last saved pose", self._put_back)
        self._as_saved.setEnabled(False)
        return menu


class PairLine(QWidget):
    """Line of a mirror pair, with a link mark and a button that dissolves the pair."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._name = plain_label(wraps=True)
        self._mark = mark = QLabel()
        mark.setPixmap(icon("link", LINKED_COLOUR).pixmap(16, 16))
        tip = "Unlink the two sensors (Ctrl+Shift+M)."
        self.unlink = button(QPushButton("Unlink"), tip=tip, name="unlink_pair")
        filled(QHBoxLayout(self), mark, self._name, 1, self.unlink)

    def show_partner(self, name: str | None) -> None:
        """Show the name of the other sensor; without one the line keeps its place, or what is below would move."""
        self._name.setText(breakable(name or "none"))
        self._name.setEnabled(name is not None)
        for part in (self._mark, self.unlink):
            keeps = part.sizePolicy()
            keeps.setRetainSizeWhenHidden(True)
            part.setSizePolicy(keeps)
            part.setVisible(name is not None)
        self.setToolTip("" if name is None else plain_tip(pair_note(name)))
