"""Describe a sensor in a row: its type, its state, and the data sheet figures that follow from its fields."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, Qt
from PySide6.QtGui import QBrush, QColor, QIcon, QPainter
from PySide6.QtWidgets import (
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTreeWidget,
    QTreeWidgetItem,
)

from riglens.core.errors import InputError
from riglens.core.footprint.overlap import overlaps
from riglens.core.footprint.words import camera_rows
from riglens.core.rig.library import changed_fields, default_library
from riglens.core.rig.model import Camera, Sensor
from riglens.core.sensors.registry import kind_of
from riglens.core.shown_text import visible
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.item_views import BAR_COLOUR, BAR_SHARE, BarDelegate
from riglens.widgets.panels.controls.style import numbers_font, plain_tip, tones
from riglens.widgets.panels.sensors.losses import Loss
from riglens.widgets.theme import LINKED_COLOUR


def derived_rows(sensor: Sensor, cameras: Sequence[Camera] = ()) -> list[tuple[str, str]]:
    """Return the captions and values, always the same captions for a kind of sensor; `cameras` are those of the rig."""
    rows = kind_of(sensor).summary(sensor)
    return [*rows, *camera_rows(sensor, overlaps(cameras))] if isinstance(sensor, Camera) else rows


MODIFIED = "*"
SIGN_PX = 18
"""Room for the warning sign."""
NAME, TYPE, LOSS, LOCK, EYE = range(5)
TITLES = ("Sensor", "Type", "", "", "")
"""The measure of losses has its title from the list."""
SENSOR_NAME = Qt.ItemDataRole.UserRole
PROBLEM = Qt.ItemDataRole.UserRole.value + 3
WIDTHS_PX = {TYPE: 50, LOSS: 92, LOCK: 22, EYE: 24}
_FIXED_FLAGS = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
_EDIT_FLAGS = _FIXED_FLAGS | Qt.ItemFlag.ItemIsEditable | Qt.ItemFlag.ItemIsUserCheckable
FAILED = "failed"
_FAILED = Loss(None, FAILED, "Failed: all figures are those without it. The rig itself is unchanged.")
_DISABLED = Loss(None, "", "Disabled: no loss")
CHOICE_TIP = "Click to choose the measure."
TIPS = (
    "Tick: included in the scores. F2 or double-click: rename. Ctrl and Shift select several.",
    "Channels of a LiDAR, horizontal field of view of a camera; * differs from the library.",
    CHOICE_TIP,
    "Locked sensors cannot be moved, edited or deleted.",
    "Shown or hidden in the view; the scores include it either way.",
)


class NameDelegate(QStyledItemDelegate):
    """Delegate that draws a name, and behind it a warning sign where something is wrong with the sensor's place."""

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Draw name and sign."""
        if not index.data(PROBLEM):
            super().paint(painter, option, index)
            return
        told = QStyleOptionViewItem(option)
        rect = QRect(option.rect)
        told.rect = rect.adjusted(0, 0, -SIGN_PX, 0)
        super().paint(painter, told, index)
        side = SIGN_PX - 4
        place = QRect(rect.right() - SIGN_PX, rect.center().y() - side // 2, side, side)
        is_selected = bool(option.state & QStyle.StateFlag.State_Selected)
        if is_selected:
            rest = QRect(rect.right() - SIGN_PX + 1, rect.top(), SIGN_PX, rect.height())
            painter.fillRect(rest, option.palette.highlight())
        mode = QIcon.Mode.Selected if is_selected else QIcon.Mode.Normal
        icon("alert", tones().less).paint(painter, place, Qt.AlignmentFlag.AlignCenter, mode)


@dataclass(frozen=True)
class RowState:
    """State of a sensor besides its fields."""

    is_hidden: bool = False
    is_locked: bool = False
    partner: str | None = None
    """The other sensor of its mirror pair."""
    problem: str = ""
    """Problem with its place."""
    is_failed: bool = False


def set_up_columns(tree: QTreeWidget) -> None:
    """Set titles, widths and delegates; only the name column grows with the list."""
    tree.setColumnCount(len(TITLES))
    tree.setHeaderLabels(list(TITLES))
    tree.setItemDelegateForColumn(NAME, NameDelegate(tree))
    tree.setItemDelegateForColumn(LOSS, BarDelegate(tree))
    head = tree.headerItem()
    for column, tip in enumerate(TIPS):
        head.setToolTip(column, tip)
    head.setTextAlignment(LOSS, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    header = tree.header()
    header.setStretchLastSection(False)
    header.setSectionsMovable(False)
    header.setMinimumSectionSize(min(WIDTHS_PX.values()))
    header.setSectionResizeMode(NAME, QHeaderView.ResizeMode.Stretch)
    for column, width in WIDTHS_PX.items():
        header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(column, width)


def short_type(sensor: Sensor) -> str:
    """Return a type of a few characters: channels (beams) of a LiDAR, horizontal field of view of a camera."""
    return kind_of(sensor).brief(sensor)


def model_note(sensor: Sensor) -> str:
    """Return title and source of the sensor's model, or say that it has none."""
    if sensor.model is None:
        return "no library model"
    try:
        entry = default_library().entry(sensor.model)
    except InputError:
        return f"{sensor.model}: not in the library"
    changed = modified_note(sensor)
    return "\n".join([entry.title, *([changed] if changed else []), entry.origin()])


_FIELD_WORDS = {
    "elevations_deg": "elevations",
    "azimuths_deg": "azimuths",
    "azimuth_offsets_deg": "azimuth offsets",
    "rays": "scan pattern",
    "range_m": "range",
    "hfov_deg": "field of view",
    "cast": "rays cast",
}


def modified_note(sensor: Sensor) -> str:
    """Return in which fields a sensor differs from its library model; empty when it is as the library has it."""
    names = [_FIELD_WORDS.get(name, name) for name in changed_fields(sensor)]
    return f"modified: {', '.join(names)} differ from the library" if names else ""


def pair_note(partner: str) -> str:
    """Return the meaning of a link mark."""
    return f"Mirror pair with {partner}: both change together"


def show_sensor(row: QTreeWidgetItem, sensor: Sensor, state: RowState) -> None:
    """Make a row show a sensor."""
    brief, about = short_type(sensor), model_note(sensor)
    row.setFlags(_FIXED_FLAGS if state.is_locked else _EDIT_FLAGS)
    row.setText(NAME, visible(sensor.name))
    row.setData(NAME, SENSOR_NAME, sensor.name)
    row.setCheckState(NAME, Qt.CheckState.Checked if sensor.enabled else Qt.CheckState.Unchecked)
    row.setText(TYPE, brief + (MODIFIED if modified_note(sensor) else ""))
    row.setFont(TYPE, numbers_font(row.font(TYPE)))
    row.setIcon(LOCK, icon("lock") if state.is_locked else icon("unlock", tones().border))
    row.setIcon(EYE, icon("eye-off", tones().muted) if state.is_hidden else icon("eye"))
    row.setIcon(NAME, icon("link", LINKED_COLOUR) if state.partner is not None else QIcon())
    pair = f"\n{pair_note(state.partner)}" if state.partner is not None else ""
    row.setData(NAME, PROBLEM, state.problem)
    place = f"\n{state.problem[:1].upper()}{state.problem[1:]}" if state.problem else ""
    row.setToolTip(
        NAME,
        plain_tip(f"{sensor.name}, {brief}{place}{pair}\n{about}\n\n{TIPS[NAME]}"),
    )
    row.setToolTip(TYPE, plain_tip(about))
    row.setToolTip(LOCK, "Locked: cannot be moved, edited or deleted." if state.is_locked else TIPS[LOCK])
    row.setToolTip(
        EYE, "Hidden in the view; still included in the scores." if state.is_hidden else "Shown in the view"
    )
    is_bright = sensor.enabled and not state.is_hidden and not state.is_failed
    bright = tones().text if is_bright else tones().muted
    row.setForeground(NAME, QBrush(QColor(bright)))
    row.setForeground(TYPE, QBrush(QColor(tones().muted)))
    font = row.font(NAME)
    font.setStrikeOut(state.is_failed)
    row.setFont(NAME, font)
    _show_no_loss(row, _DISABLED if not sensor.enabled else _FAILED if state.is_failed else None)


def _show_no_loss(row: QTreeWidgetItem, reason: Loss | None) -> None:
    """Show why a sensor has no loss; None removes an earlier reason."""
    if reason is not None:
        show_loss(row, reason, 0.0)
        if reason.text:
            row.setForeground(LOSS, QBrush(QColor(tones().less)))
    elif _has_reason(row):
        show_loss(row, Loss(None, "", ""), 0.0)


def _has_reason(row: QTreeWidgetItem) -> bool:
    return row.toolTip(LOSS) in (plain_tip(_DISABLED.tip), plain_tip(_FAILED.tip))


def forget_loss(row: QTreeWidgetItem) -> None:
    """Show no loss, because another measure is chosen; why a sensor has none holds in every measure."""
    if not _has_reason(row):
        show_loss(row, Loss(None, "", ""), 0.0)


def show_loss(row: QTreeWidgetItem, loss: Loss, largest: float) -> None:
    """Show the loss without the sensor, with a bar relative to the largest loss."""
    row.setText(LOSS, loss.text)
    row.setTextAlignment(LOSS, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    row.setFont(LOSS, numbers_font(row.font(LOSS)))
    row.setData(LOSS, BAR_SHARE, None if loss.size is None or largest <= 0.0 else loss.size / largest)
    row.setData(LOSS, BAR_COLOUR, None)
    row.setToolTip(LOSS, plain_tip(loss.tip))
    row.setForeground(LOSS, QBrush(QColor(tones().text)))


def set_loss_stale(row: QTreeWidgetItem) -> None:
    """Grey the loss: it belongs to an earlier rig."""
    if row.text(LOSS) == FAILED:
        return
    row.setData(LOSS, BAR_COLOUR, tones().border)
    row.setForeground(LOSS, QBrush(QColor(tones().muted)))
