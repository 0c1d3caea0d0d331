"""A report as one frozen document: its figures and the drawings made from them, which page and PDF render alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from riglens.core.rig.model import Rig
from riglens.core.shown_text import numbered
from riglens.reporting.drawings import Plans, plans, view_data
from riglens.reporting.figures import Report, ReportPlan
from riglens.studies.blind_chart import blind_figure
from riglens.studies.detection_range_chart import range_figure
from riglens.studies.pictures import picture


@dataclass(frozen=True)
class Drawings:
    """Drawings of one rig: charts as PNG, plans, and the data of the view that turns."""

    range_png: bytes
    blind_png: bytes
    plans: Plans
    view: dict[str, Any]


@dataclass(frozen=True)
class ReportDocument:
    """The figures as plain data, and rigs and drawings in their order."""

    figures: dict[str, Any]
    rigs: tuple[Rig, ...]
    drawings: Sequence[Drawings]
    labels: tuple[str, ...] = ()
    """Project, revision and author, in words."""

    @property
    def title(self) -> str:
        """The names of the rigs."""
        return ", ".join(self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """The name of each rig, with a number where several have it."""
        return numbered([rig.name for rig in self.rigs])


def document_of(plan: ReportPlan, report: Report) -> ReportDocument:
    """Return the figures of a report with its drawings."""
    drawings = tuple(
        Drawings(
            range_png=picture(range_figure(ranges)),
            blind_png=picture(blind_figure(found, "any", 1)),
            plans=plans(rig),
            view=view_data(rig),
        )
        for rig, found, ranges in zip(plan.rigs, report.maps, report.ranges, strict=True)
    )
    return ReportDocument(report.figures, plan.rigs, drawings, plan.labels.words)
