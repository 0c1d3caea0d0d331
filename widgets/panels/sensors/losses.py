"""Describe what the rig loses without one sensor, figure by figure; numbers, words and directions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from riglens.core.figures.figure import ALL, Estimate, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.text import (
    UNITS,
    change_digits,
    change_estimate_text,
    change_unit,
    exact_text,
    in_unit,
    value_text,
)
from riglens.core.figures.values import Values, class_figures
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kind_of
from riglens.core.shown_values import NONE

FOLLOWS = "…"
Losses = Mapping[str, "Loss"]
"""By key of the measure, as far as they are known."""


def measures() -> dict[str, Figure]:
    """Return the figures in which a loss is measured, by key: those that lead."""
    return {figure.key: figure for figure in class_figures() if figure.leads}


def usual_measure() -> Figure:
    """Return the figure in which losses are shown where none is chosen: the first that leads."""
    return next(iter(measures().values()))


def measure_for(kind: str, chosen: Figure) -> Figure:
    """Return the chosen measure, or one of sensors of all kinds where it does not count those of a kind."""
    if counts_kind(chosen, kind) or not isinstance(chosen, ObjectFigure):
        return chosen
    every = (one for one in measures().values() if isinstance(one, ObjectFigure) and not one.kinds)
    return next(every, chosen)


def counts_kind(measure: Figure, kind: str) -> bool:
    """Return whether sensors of a kind count in a measure."""
    if isinstance(measure, ObjectFigure):
        return not measure.kinds or kind in measure.kinds
    return not measure.of_paper or kind_of(kind).score_weight != 0.0


def heading(measure: Figure) -> str:
    """Return the heading of losses in the list: their unit."""
    unit = change_unit(measure)
    return f"{unit} ▾" if measure.better == "neither" else f"Loss, {unit} ▾"


def meaning(measure: Figure) -> str:
    """Return what a loss in a measure is."""
    if measure.better == "neither":
        unit = UNITS[measure.unit]
        return f"Change of {measure.title} without this sensor, in {unit}; the arrow shows the direction."
    return f"{measure.title}: loss without this sensor, in {change_unit(measure)}. {measure.question}"


@dataclass(frozen=True)
class Loss:
    """Loss of one sensor in the list: the length of its bar, None for no bar, and words."""

    size: float | None
    text: str
    tip: str


def losses_of(now: Values, without: Values, kind: str) -> Losses:
    """Return the losses without a sensor of a kind, of all classes together, in every measure in which they are
    known."""
    known, found = measures(), dict[str, Loss]()
    lines = [
        f"{name}: "
        + ", ".join(f"{one.title} {class_change(one, name, now, without)[1]}" for one in known.values())
        for name in CLASSES
    ]
    tip = "\n".join(["Without it, exactly:", *lines])
    for key, measure in known.items():
        change = changed(measure, ALL, now, without)
        if not counts_kind(measure, kind):
            found[key] = Loss(None, NONE, f"{measure.title} does not count {kind_of(kind).plural}")
        elif change is not None:
            found[key] = _loss(measure, change, f"Loss in {measure.title}\n{tip}")
    return found


def _loss(measure: Figure, change: Estimate, tip: str) -> Loss:
    if not change.exists:
        return Loss(None, NONE, f"{change.reason}\n{tip}")
    size = in_unit(measure, change.value)
    if measure.better == "neither":
        arrow = "↑" if size > 0.0 else "↓" if size else ""
        return Loss(abs(size), f"{abs(size):.2f}{arrow}", tip)
    lost = -size if measure.better == "more" else size
    digits = f"{abs(lost):.1f}"  # as many for every sensor, whose errors differ
    return Loss(max(lost, 0.0), f"{'-' if lost < 0.0 and float(digits) else ''}{digits}", tip)


def changed(measure: Figure, who: str, now: Values, without: Values) -> Estimate | None:
    """Return the change of a measure of a class or of `ALL` without a sensor; None while it is not known.

    A rig that loses its last sensor of a kind loses all of the figures that only this kind makes.
    """
    mine, theirs = (known[measure.key][who] if measure.key in known else None for known in (now, without))
    if mine is None or theirs is None:
        return None
    return (theirs if theirs.exists else Estimate()).minus(mine)


def class_change(measure: Figure, class_name: str, now: Values, without: Values) -> tuple[str, str, str]:
    """Return the change of a measure in a class without the sensor: for a column, with unit and error, and exactly."""
    change = changed(measure, class_name, now, without)
    if change is None:
        return FOLLOWS, FOLLOWS, ""
    if not change.exists:
        return NONE, NONE, change.reason
    objects = f" of {change.objects:,} objects" if change.objects else ""
    before = value_text(measure, now[measure.key][class_name].value)
    exact = f"{exact_text(measure, change.value)}{objects}, now {before}"
    return change_digits(measure, change), change_estimate_text(measure, change), exact
