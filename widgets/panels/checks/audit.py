"""Show the ray outcomes of each sensor, six shares that add up to 100 %, and the cost of the car's body by class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QVBoxLayout, QWidget

from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.checks.sensor_table import SensorTable
from riglens.widgets.panels.controls.building import button, filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN, as_panel
from riglens.widgets.panels.figures.table import Cell

if TYPE_CHECKING:  # made by the engine's thread, which loads the compiler
    from riglens.core.engine.audit import SensorAudit

OUTCOMES = {
    "brings_new": (
        "unique",
        "Rays into uncertain space that no other sensor sees.",
    ),
    "seen_by_others": (
        "seen by others",
        "Rays into uncertain space, all of which other sensors see as well.",
    ),
    "meets_nothing": ("hits nothing", "Rays that leave the region without meeting uncertain space."),
    "ground": ("ends at ground", "Rays that end at the ground without meeting uncertain space."),
    "never_enters": ("misses the region", "Rays that never enter the region."),
    "hits_car": ("hits the car", "Rays that end at the car's own body."),
}
"""Titles and tooltips of what becomes of rays, from the best to the worst, by the keys of the audit."""
FOLLOW, FOLLOW_TIP = "Trace rays", "Trace every ray of every sensor through the region once."
EXPLAINED = "Trace rays to see where every ray of each sensor ends."
ASKED, OUTDATED = "Tracing rays…", "from before the last change"


def percents(shares: dict[str, float]) -> dict[str, float]:
    """Return shares in percent with one decimal that add up to 100.0: the largest remainders are rounded up."""
    tenths = {name: int(1000.0 * share) for name, share in shares.items()}
    rest = sorted(shares, key=lambda name: tenths[name] - 1000.0 * shares[name])
    for name in rest[: round(1000.0 * sum(shares.values())) - sum(tenths.values())]:
        tenths[name] += 1
    return {name: tenth / 10.0 for name, tenth in tenths.items()}


class AuditPanel(QWidget):
    """Button that requests the audit, and its results."""

    wanted = Signal()
    """The rays are to be followed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        titles = dict(OUTCOMES.values())
        self.table = SensorTable("Rays of each sensor", {"Rays": "Rays of the sensor."} | titles)
        self._note = plain_label(style="hint")
        follow = button(QPushButton(FOLLOW), self.wanted, FOLLOW_TIP, "follow_rays")
        line = filled(QHBoxLayout(), follow, self._note, 1, margins=(MARGIN, 4, MARGIN, 4))
        filled(QVBoxLayout(self), line, self.table)

    def show_audits(self, found: Mapping[str, SensorAudit], note: str, is_current: bool) -> None:
        """Show where the rays of each sensor go, with a remark."""
        self.table.show_rows({name: _cells(audit) for name, audit in found.items()}, is_current)
        self._note.setText(note)
        self.table.explain(note or EXPLAINED)

    @property
    def note(self) -> str:
        """Return the note next to the button."""
        return self._note.text()


def _cells(found: SensorAudit) -> list[Cell]:
    lost = ", ".join(f"{name} {100.0 * found.lost_share[name]:.2f}" for name in CLASSES)
    tip = f"Loss by self-occlusion, in pp of H(Ω): {lost}"
    shown = percents(found.shares)
    return [
        Cell(text, tip=tip) for text in (f"{found.rays:,}", *(f"{shown[name]:.1f} %" for name in OUTCOMES))
    ]
