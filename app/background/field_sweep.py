"""Compute the curve of one field of the rig in a thread of its own, with serial kernels, point by point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from riglens.app.background.worker import Context
from riglens.core.rig.model import Rig
from riglens.core.targets.settings import TargetSettings

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.sweep.curve import CurvePoint
    from riglens.core.sweep.fields import RigField
    from riglens.core.targets.traffic import Traffic


@dataclass(frozen=True, eq=False)
class FieldRequest:
    """A field of a rig, and the objects to count on."""

    rig: Rig
    field: RigField
    settings: TargetSettings
    traffic: Traffic


class Curve(NamedTuple):
    """The points that are known so far, and whether their noise holds the noise floor."""

    points: tuple[CurvePoint, ...] = ()
    has_floor: bool = False


def field_curve(request: FieldRequest, context: Context[Curve]) -> Curve:
    """Return the curve of a field; publishes it point by point, first without the noise floor."""
    from riglens.core.sweep.curve import FRAMES, curve, figure_of, nearby_values, with_floor
    from riglens.core.sweep.rows import Sweeper, SweepFigures

    rig, values = request.rig, nearby_values(request.rig, request.field)
    figures = SweepFigures(None, request.settings, FRAMES)
    sweeper = Sweeper(figures, rig, None, request.traffic, threads=1)
    found: tuple[CurvePoint, ...] = ()
    for point in curve(rig, request.field, values, sweeper):
        found = (*found, point)
        context.report(0.5 * len(found) / len(values))
        context.publish(Curve(found))
    floor = sweeper.noise_floor(progress=lambda share: context.report(0.5 + 0.5 * share))
    return Curve(with_floor(found, figure_of(rig, request.field), floor), True)
