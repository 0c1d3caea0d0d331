"""A report as one frozen document: its figures and the drawings made from them, which page and PDF render alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from riglens.core.rig.model import Rig
from riglens.core.shown_text import numbered
from riglens.reporting.drawings import car_shape, view_data
from riglens.reporting.figures import Report, ReportPlan
from riglens.reporting.plans import (
    CarPicture,
    CarShape,
    bearing_strip,
    blind_plan,
    footprint_plan,
    numbered_picture,
    seats,
)
from riglens.reporting.svg import Drawing


@dataclass(frozen=True)
class Drawings:
    """Drawings of one rig that need more than its figures, the outlines of its car, and the data of the turning view;
    None without what draws pictures, or without cameras."""

    picture: Drawing | None
    plan: Drawing
    seats: Drawing
    bearings: Drawing | None
    blind: Drawing
    shape: CarShape
    view: dict[str, Any]


@dataclass(frozen=True)
class ReportDocument:
    """The figures as plain data, and rigs and drawings in their order; given: names of the rigs that differ."""

    figures: dict[str, Any]
    rigs: tuple[Rig, ...]
    drawings: Sequence[Drawings]
    labels: tuple[str, ...] = ()
    """Project, revision, author and reviewer, in words."""
    given: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The name of each rig, with its file or a number where several have it."""
        return self.given or numbered([rig.name for rig in self.rigs])

    @property
    def title(self) -> str:
        """The names of the rigs."""
        return ", ".join(self.names)


def document_of(plan: ReportPlan, report: Report) -> ReportDocument:
    """Return the figures of a report with its drawings."""
    drawings = []
    for number, rig in enumerate(plan.rigs):
        key, figures, shape = f"rig{number + 1}", report.figures["rigs"][number], car_shape(rig)
        taken = _picture_of(rig)
        drawings.append(
            Drawings(
                picture=None if taken is None else numbered_picture(key, taken, plan.names[number]),
                plan=footprint_plan(key, rig, report.footprints[number], figures, shape),
                seats=seats(key, rig, shape),
                bearings=bearing_strip(key, rig, figures["footprint"]),
                blind=blind_plan(key, report.maps[number], figures["blind"], shape),
                shape=shape,
                view=view_data(rig),
            )
        )
    return ReportDocument(report.figures, plan.rigs, drawings, plan.labels.words, plan.names)


def _picture_of(rig: Rig) -> CarPicture | None:
    """Return a picture of a rig's car; None without graphics libraries."""
    from riglens.rendering.display import prepare_drawing
    from riglens.rendering.system_libraries import MissingLibraries

    try:
        prepare_drawing()
    except MissingLibraries:
        return None
    from riglens.rendering.picture_set import car_with_sensors  # VTK

    return CarPicture(*car_with_sensors(rig))
