"""List of test objects near the car: profile by profile whether the rig sees them; a click on an object goes there."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHeaderView, QLabel, QTreeWidget, QTreeWidgetItem, QVBoxLayout, QWidget

from riglens.core.shown_text import visible
from riglens.widgets.panels.checks.panel import COMPUTING
from riglens.widgets.panels.controls.building import filled
from riglens.widgets.panels.controls.messages import ThinBar
from riglens.widgets.panels.controls.style import MARGIN, as_panel

if TYPE_CHECKING:  # loads the compiler, which a window that opens does not need
    from riglens.core.review.verdicts import ObjectVerdict, ProfileVerdict

NOTE = (
    "Geometry only, not a type approval. Seen: enough rays reach the object without hitting "
    "the car, and a sensor views enough of the surface facing it. Sources are in the "
    "tooltips. Select an object to show it."
)
COLUMNS = ("Objects", "Seen", "Rays", "In view")


class ObjectsPanel(QWidget):
    """Panel of verdicts; profiles of which an object is not seen are open, the first time they are shown."""

    chosen = Signal(int, int)
    """The numbers of the profile and of its object that was chosen, in the order in which they are shown."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._items: list[tuple[QTreeWidgetItem, list[QTreeWidgetItem]]] = []
        self.tree = QTreeWidget()
        self.tree.setColumnCount(len(COLUMNS))
        self.tree.setHeaderLabels(list(COLUMNS))
        self.tree.header().setStretchLastSection(False)
        self.tree.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for column in range(1, len(COLUMNS)):
            self.tree.header().setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        self.tree.itemClicked.connect(self._choose)
        self.tree.itemActivated.connect(self._choose)
        QTreeWidgetItem(self.tree, [COMPUTING])
        self.note = QLabel(NOTE)
        self.note.setWordWrap(True)
        self.bar = ThinBar()
        filled(
            QVBoxLayout(self), self.note, self.bar, self.tree, margins=(MARGIN, 4, MARGIN, 4), spacing=2
        )  # fmt: skip

    def show_verdicts(self, profiles: Sequence[ProfileVerdict]) -> None:
        """Show the verdict on every object; the expanded and chosen items stay."""
        self.bar.show_share(None)
        if [len(children) for _, children in self._items] != [len(p.objects) for p in profiles]:
            self._build(profiles)
        for (item, children), verdict in zip(self._items, profiles, strict=True):
            seen = len(verdict.objects) - len(verdict.failed)
            _write(item, f"{seen} of {len(verdict.objects)}", "", "", verdict.passes)
            for child, one in zip(children, verdict.objects, strict=True):
                _show(child, one)

    def _build(self, profiles: Sequence[ProfileVerdict]) -> None:
        self.tree.clear()
        self._items = []
        for verdict in profiles:
            item = QTreeWidgetItem(self.tree, [visible(verdict.profile.title)])
            item.setToolTip(0, f"<p>{_escaped(verdict.profile.source)}</p>")
            children = [QTreeWidgetItem(item, [visible(one.target.name)]) for one in verdict.objects]
            self._items.append((item, children))
            item.setExpanded(not verdict.passes and len(verdict.objects) <= 10)

    def _choose(self, item: QTreeWidgetItem) -> None:
        profile = item.parent()
        if profile is not None:
            self.chosen.emit(self.tree.indexOfTopLevelItem(profile), profile.indexOfChild(item))


def _show(item: QTreeWidgetItem, one: ObjectVerdict) -> None:
    """Show one object: x and y are its current place, as the car may have changed."""
    where = f"x {one.target.x_m:.2f} m, y {one.target.y_m:.2f} m"
    told = ", ".join(f"{visible(name)} {count}" for name, count in one.rays_by_sensor.items() if count)
    item.setToolTip(0, f"<p>{_escaped(where)}<br>Rays: {_escaped(told or 'none')}</p>")
    _write(item, "yes" if one.is_seen else "no", f"{one.rays:,}", f"{100.0 * one.share:.0f} %", one.is_seen)


def _write(item: QTreeWidgetItem, seen: str, rays: str, share: str, is_good: bool) -> None:
    for column, text in enumerate((seen, rays, share), 1):
        if item.text(column) != text:
            item.setText(column, text)
        item.setTextAlignment(column, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    font = item.font(0)
    if font.bold() == is_good:
        font.setBold(not is_good)
        item.setFont(0, font)
        item.setFont(1, font)


def _escaped(text: str) -> str:
    """Return a text of a file inside the rich text of a tooltip."""
    return escape(visible(text))
