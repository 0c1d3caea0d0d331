"""Charts, rows and words of a search for rigs, from its result."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from riglens.core.figures.figure import Figure
from riglens.core.figures.text import change_text, in_unit, value_text
from riglens.core.rig.model import Rig
from riglens.core.shown_text import visible
from riglens.widgets.panels.figures.table import NOTHING, Cell, Heading, Tone
from riglens.widgets.panels.propose.chart import Dot, Line, Plot, PlotTone

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.optimise.results import OptimiseResult

SEARCHING, NO_SEARCH = "Appears once the search runs.", "Choose what to add and press Start."
RUNNING = "Searching…"
_BEST: PlotTone = "accent"
_BOUND: PlotTone = "less"
Bracket = tuple[float, float | None, float | None]
"""Seconds since the start, best value so far, and its bound so far."""


@dataclass(frozen=True)
class Offer:
    """A rig that can be looked at, compared and applied; its value and unseen ground in the frames of choice, and the
    cost of what it adds."""

    key: str
    title: str
    rig: Rig
    value: float | None = None
    blind_m2: float | None = None
    cost: float | None = None


def offers_of(found: OptimiseResult) -> list[Offer]:
    """Return the rows of the table: the rig itself, the reference, and the proposals."""
    now = Offer("", "Now", found.problem.rig, found.before, found.before_blind_m2)
    reference = Offer("reference", reference_title(found), found.reference, found.reference_value)
    has_costs = bool(found.problem.additions.costs) or found.problem.additions.budget < math.inf
    rows = [
        Offer(
            f"proposal {number}",
            f"Proposal {number}",
            one.rig,
            one.value,
            one.blind_m2,
            one.cost if has_costs else None,
        )
        for number, one in enumerate(found.proposals, 1)
    ]
    return [now, reference, *rows]


def reference_title(found: OptimiseResult) -> str:
    """Return what gains refer to: another rig, or the same with typical mounts."""
    name = found.reference.name.removeprefix(f"{found.problem.rig.name}, ")
    return visible(name[0].upper() + name[1:])


# ---------------------------------------------------------------------- charts
def bracket_plot(history: Sequence[Bracket]) -> Plot:
    """Plot best value and bound over time, which converge."""
    best = tuple((s, value) for s, value, _ in history if value is not None)
    bound = tuple((s, high) for s, _, high in history if high is not None)
    lines = [Line(points, tone) for points, tone in ((best, _BEST), (bound, _BOUND)) if points]
    return Plot("Best found, upper limit", "s", tuple(lines), empty=SEARCHING)


def front_plot(found: OptimiseResult | None) -> Plot:
    """Plot value against unseen ground: none of the proposals is better than another in both."""
    title = "Value against unseen ground"
    if found is None or found.before_blind_m2 is None:
        return Plot(title, "m²", empty=SEARCHING)
    dots = [
        Dot(
            one.blind_m2,
            one.value,
            f"{one.title}: {value_text(found.figure, one.value)}, {one.blind_m2:.1f} m² unseen",
            one.key,
        )
        for one in offers_of(found)
        if one.blind_m2 is not None and one.value is not None
    ]
    front = sorted((dot.x, dot.y) for dot in dots if dot.key)
    return Plot(title, "m²", (Line(tuple(front)),) if front else (), tuple(dots))


# ---------------------------------------------------------------------- tables
COLUMNS = (
    Heading("Value", "Objective in the frames of choice."),
    Heading("Change", "Difference from the rig as it is, in the frames of choice."),
    Heading("Unseen", "Ground near the car where the object is in no sensor's view."),
    Heading("Cost", "Cost of the added sensors."),
)
CHECKS = (
    Heading("Gain", "Gain over the reference, in the frames of the case."),
    Heading("SE", "Standard error of the gain, paired by frame or by draw."),
    Heading("Kept", "Share of the gain for which the proposal was chosen."),
)


def offer_cells(offers: Sequence[Offer], figure: Figure) -> list[tuple[Cell, ...]]:
    """Return the cells of the proposals, with values of a figure."""
    base = offers[0].value if offers else None
    rows = list[tuple[Cell, ...]]()
    for one in offers:
        change = None if one.value is None or base is None or not one.key else one.value - base
        rows.append(
            (
                NOTHING if one.value is None else Cell(value_text(figure, one.value), (one.value,)),
                NOTHING
                if change is None
                else Cell(
                    change_text(figure, change), (change,), tone="more" if figure.is_gain(change) else "text"
                ),
                NOTHING if one.blind_m2 is None else Cell(f"{one.blind_m2:.1f} m²", (one.blind_m2,)),
                NOTHING if one.cost is None else Cell(f"{one.cost:g}", (one.cost,)),
            )
        )
    return rows


def check_cells(found: OptimiseResult | None) -> tuple[list[Heading], list[tuple[Cell, ...]]]:
    """Return titles and cells of the checks, the frames of choice first; none without a result."""
    if found is None:
        return [], []
    titles, cells = list[Heading](), list[tuple[Cell, ...]]()
    figure = found.figure
    if found.problem.goal.of_objects:
        titles.append(Heading("Frames of choice"))
        cells.append((Cell(change_text(figure, found.gain)), NOTHING, NOTHING))
    for one in found.best.guard:
        titles.append(Heading(one.case[0].upper() + one.case[1:]))
        tone: Tone = "less" if one in found.best.weak else "text"
        share = Cell(f"{one.share:.0%}", (one.share,), tone=tone, bar=one.share)
        error = Cell(f"{in_unit(figure, one.se):.2f}", (one.se,)) if one.se else NOTHING
        cells.append((Cell(change_text(figure, one.gain), (one.gain,)), error, share))
    return titles, cells


# ---------------------------------------------------------------------- words
def sentence_of(found: OptimiseResult) -> str:
    """Return the values and the bound as a sentence."""
    now, proposed = (value_text(found.figure, value) for value in (found.before, found.best.value))
    values = f"{found.problem.goal.title} {now} now, {proposed} proposed"
    where = f" (in the {found.problem.frames} frames of choice)" if found.problem.goal.of_objects else ""
    return f"{values}{where}: {found.sentence()}."


def verdict_of(found: OptimiseResult) -> str:
    """Return what the checks say about the gain over the reference."""
    weak = ", ".join(f"{one.case} ({one.share:.0%})" for one in found.best.weak)
    word = found.best.verdict
    against = f"{word[0].upper()}{word[1:]}: gain over {visible(found.reference.name)}."
    return f"{against} Less than half is left with: {weak}." if weak else against
