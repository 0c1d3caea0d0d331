"""Draw the figures of a rig: bars beside a baseline, the three worst, blind areas, ranges around the car, where objects
are missed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from riglens.core.figures.figure import SE_FACTOR, Estimate, Figure
from riglens.core.figures.text import change_digits, in_unit, verdict
from riglens.core.sensors.registry import AnyKind, kinds
from riglens.core.targets.detection_range_text import bearing_text
from riglens.reporting.plans import CarShape, above, draw_car
from riglens.reporting.svg import (
    GAIN,
    INK,
    LINE,
    LOSS,
    LOSS_TEXT,
    ON_LOSS,
    PANEL,
    PAPER,
    SOFT,
    TEXT_MM,
    Drawing,
    Point,
    sector,
)

Figures = dict[str, Any]
SPEEDS_KMH = (50.0, 80.0)
"""Of the circles of stopping distances."""
FEW_OBJECTS, NOTED = 100, 0.04
"""Objects in a cell below which it has no number, and the change from which it has one."""
_STRONG = 0.68
"""Strength from which a colour is darker, or on a dark page lighter, than half way to the paper."""


def estimate_of(document: Figures | None) -> Estimate:
    """Return an estimate from its document; an estimate without a value if there is no document."""
    if document is None or document["value"] is None:
        return Estimate.none("" if document is None else document["reason"] or "")
    return Estimate(
        document["value"],
        document["se"],
        document["state"],
        document["reason"] or "",
        parts=document.get("parts", {}),
    )


# ---------------------------------------------------------------- page 1: figures
def bars(key: str, figure: Figure, found: Sequence[tuple[str, str, Estimate, Estimate, Estimate]]) -> Drawing:
    """Return a bar per class, 0 to 100 %, with two standard errors, the baseline as a triangle, and the change.

    found: class, place of the figure, the figure, that of the baseline, and the change; none without a baseline.
    """
    compares = any(change.exists for *_, change in found)
    wide, row, left = 56.0, 6.4, 17.0
    right = 39.0 if compares else 46.0
    drawing = Drawing(
        f"{key}-{figure.key}", wide, 5.6 + row * (len(found) - 1), f"{figure.title} by class, in per cent"
    )

    def across(value: float) -> float:
        return left + (right - left) * min(max(in_unit(figure, value), 0.0), 100.0) / 100.0

    for place, (name, path, now, before, change) in enumerate(found):
        y = 3.4 + row * place
        drawing.text(0.0, y + 0.85, name)
        drawing.rect(left, y - 1.5, right - left, 3.0, PANEL)
        if not now.exists:
            drawing.text(left + 1.0, y + 0.85, "—", colour=SOFT)
            continue
        drawing.rect(left, y - 1.5, across(now.value) - left, 3.0, GAIN, 0.62)
        if now.se:
            low, high = (across(now.value + way * SE_FACTOR * now.se) for way in (-1.0, 1.0))
            drawing.line([(low, y), (high, y)], INK, 0.3)
            for end in (low, high):
                drawing.line([(end, y - 0.6), (end, y + 0.6)], INK, 0.25)
        if before.exists:
            at = across(before.value)
            drawing.area([(at, y - 1.2), (at - 0.85, y - 2.8), (at + 0.85, y - 2.8)], INK)
        level = f"{in_unit(figure, now.value):.1f}"
        words = f"({level})" if now.state == "outside" else level
        drawing.text(wide - 9.0 if compares else wide, y + 0.85, words, "end", bold=True, path=path)
        if change.exists:
            tone = _tone(figure, change)
            drawing.text(wide, y + 0.85, change_digits(figure, change), "end", tone, tone != SOFT)
    return drawing


def _tone(figure: Figure, change: Estimate) -> str:
    return {"better": GAIN, "worse": LOSS_TEXT}.get(verdict(figure, change), SOFT)


# ---------------------------------------------------------------- page 1: the three worst
def objects_missed(key: str, profile: Figures, shape: CarShape, size_m: Point) -> Drawing:
    """Return the objects of a profile beside the car; size_m: length and width of the car."""
    wide, high = 56.0, 40.0
    drawing = Drawing(f"{key}-objects", wide, high, f"{profile['title']}: which test objects are seen")
    xs, ys = ([one[axis] for one in profile["objects"]] for axis in ("x_m", "y_m"))
    low, high_m = (
        min(*xs, 0.0 if max(xs) > 0 else -size_m[0] / 2 + 0.6),
        max(*xs, 0.0 if min(xs) < 0 else size_m[0] / 2 - 0.6),
    )
    side = max(abs(min(ys)), abs(max(ys)), size_m[1] / 2) + 0.5
    scale = min((high - 6.0) / (high_m - low + 0.8), (wide - 18.0) / (2.0 * side), 9.0)
    middle = (wide / 2 + 8.0, 2.0 + (high_m + 0.4) * scale)
    draw_car(drawing, shape.above, middle, scale)
    for one in profile["objects"]:
        is_partly = not one["seen"] and one["share"] > 0.0
        tone = GAIN if one["seen"] else LOSS
        radius = max(0.75, one["diameter_m"] / 2.0 * scale)
        drawing.circle(
            above(middle, scale, one["x_m"], one["y_m"]),
            radius,
            tone,
            "#ffffff",
            0.2,
            0.5 if is_partly else None,
        )
    drawing.clip(wide, high - 1.0)
    for place, (tone, opacity, words) in enumerate(
        ((LOSS, None, "not seen"), (LOSS, 0.5, "in part"), (GAIN, None, "seen"))
    ):
        drawing.circle((1.3, 29.0 + 4.0 * place), 1.1, tone, opacity=opacity)
        drawing.text(3.6, 29.8 + 4.0 * place, words)
    return drawing


def failure_rose(
    key: str, lost: Sequence[float], sectors: Sequence[str], shape: CarShape, what: str
) -> Drawing:
    """Return what a failure costs in each sector as areas, with the worst sector in words."""
    wide, high, at, radius = 56.0, 40.0, (20.0, 20.0), 19.0
    drawing = Drawing(f"{key}-failure", wide, high, f"{what}, by sector around the car")
    worst = max(lost)
    whole = next((step for step in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0) if worst <= step * 1.1), 1.0) * 1.1

    def far(share: float) -> float:
        return radius * math.sqrt(share / whole)

    for ring in (whole / 2.2, whole / 1.1):
        drawing.circle(at, far(ring), stroke=SOFT, width=0.15)
    for place, share in enumerate(lost):
        if share > 0.0:
            drawing.area(
                sector(at, (0.0, far(share)), 45.0 * place),
                LOSS,
                1.0 if share > worst / 2 else 0.5,
                "#ffffff",
            )
    drawing.circle(at, 3.0, "#ffffff")
    draw_car(drawing, shape.above, at, 1.15, "#8a96a3")
    place = lost.index(worst)
    emptier = min((0, len(lost) // 2), key=lambda number: lost[number])
    for ring in (whole / 2.2, whole / 1.1):
        x, y = _at(at, far(ring), 45.0 * emptier)
        drawing.text(x, y + 0.85, f"{100.0 * ring:g} %", "middle", SOFT, halo=True)
    drawing.text(40.5, 6.0, f"{100.0 * worst:.0f} %", colour=LOSS_TEXT, bold=True)
    drawing.text(40.5, 9.4, sectors[place], colour=LOSS_TEXT)
    others = max((share for number, share in enumerate(lost) if number != place), default=0.0)
    drawing.text(40.5, 20.0, f"≤ {100.0 * others:.0f} % in the")
    drawing.text(40.5, 23.4, "other seven")
    return drawing


def stopping_bars(key: str, row: Figures, to_m: float, stopping: Figures, title: str) -> Drawing:
    """Return how far each kind of sensor holds an object, worst to best place, beside stopping distances."""
    wide, bottom = 56.0, 32.0
    drawing = Drawing(f"{key}-range", wide, 40.0, f"{title}: how far it is held, beside stopping distances")
    shown = [(kind, row[kind.name]["first_below_m"]) for kind in kinds() if kind.name in row][:4]
    ends = [to_m if far is None else far for _, first in shown for far in first.values()]
    speeds = [one for one in stopping["distances"] if one["speed_kmh"] in (50.0, 80.0, 100.0)]
    most = max(*ends, *(one["distance_m"] for one in speeds)) * 1.04
    held = max((first["min"] if first["min"] is not None else to_m for _, first in shown), default=0.0)
    scale = (wide - 2.0) / most
    for one in speeds:
        x, is_beyond = 1.0 + one["distance_m"] * scale, one["distance_m"] > held
        drawing.line([(x, 1.0), (x, bottom)], LOSS if is_beyond else INK, 0.35)
        drawing.text(
            x, bottom + 3.2, f"{one['speed_kmh']:g}", "middle", LOSS_TEXT if is_beyond else INK, True
        )
    step = bottom / max(len(shown), 1)
    for place, (kind, first) in enumerate(shown):
        y = step * (place + 0.5)
        least, best = (to_m if first[name] is None else first[name] for name in ("min", "max"))
        drawing.rect(1.0, y, least * scale, 3.6, GAIN)
        drawing.rect(1.0 + least * scale, y, (best - least) * scale, 3.6, GAIN, 0.4)
        drawing.text(
            1.0,
            y - 0.9,
            f"{kind.plural[:1].upper()}{kind.plural[1:]} {_span_text(least, best, to_m)}",
            halo=True,
        )
    drawing.line([(1.0, bottom), (wide - 1.0, bottom)], INK, 0.25)
    drawing.text(1.0, 39.0, "km/h from which the car still stops", colour=SOFT)
    return drawing


def _span_text(least: float, best: float, to_m: float) -> str:
    if best == 0.0:
        return "never"
    texts = [f"> {to_m:g}" if far >= to_m else f"{far:.0f}" for far in (least, best)]
    return f"{texts[0]} m" if texts[0] == texts[1] else f"{texts[0]} to {texts[1]} m"


# ---------------------------------------------------------------- page 3
def blind_areas(
    key: str, heights: Sequence[tuple[str, Figures]], before: Sequence[Figures] | None
) -> Drawing:
    """Return the ground on which an object is unseen by its height; heights: places of figures, and the figures."""
    wide, left, right = 82.0, 17.0, 58.0
    drawing = Drawing(
        f"{key}-areas", wide, 4.6 + 6.2 * len(heights), "Ground on which an object is unseen, by its height"
    )
    drawing.text(0.0, 3.0, "object's height", colour=SOFT)
    drawing.text(
        wide if before else 72.0, 3.0, "m² unseen (baseline)" if before else "m² unseen", "end", SOFT
    )
    areas = [one["unseen_m2"] for one in (*(one for _, one in heights), *(before or ()))]
    most = max(*areas, 1.0)
    for place, (path, one) in enumerate(heights):
        y, area = 8.0 + 6.2 * place, one["unseen_m2"]
        drawing.text(0.0, y + 0.85, f"{one['height_m']:.2f} m")
        drawing.rect(left, y - 1.5, (right - left) * area / most, 3.0, LOSS, 0.75)
        drawing.line([(left, y - 2.6), (left, y + 2.6)], LINE)
        drawing.text(72.0, y + 0.85, f"{area:,.1f}", "end", bold=True, path=path)
        if before:
            at = left + (right - left) * before[place]["unseen_m2"] / most
            drawing.area([(at, y - 1.5), (at - 0.85, y - 2.9), (at + 0.85, y - 2.9)], INK)
            drawing.text(wide, y + 0.85, f"{before[place]['unseen_m2']:,.1f}", "end", SOFT)
    return drawing


_DASHES = (None, "1.4 0.9", "0.4 0.7", "2.4 0.6 0.4 0.6")


def range_chart(key: str, cls: str, document: Figures, before: Figures | None, shape: CarShape) -> Drawing:
    """Return how far each kind of sensor holds a class in each direction, and stopping distances as circles."""
    wide, high, middle, radius = 56.0, 56.0, (28.0, 28.0), 26.0
    drawing = Drawing(f"{key}-range-{cls}", wide, high, f"Detection range for a {cls} by direction, ahead up")
    rows, to_m = document["rigs"][0]["rows"], document["to_m"]
    there = [kind for kind in kinds() if any(kind.name in row for row in rows)]
    stops = [one for one in document["stopping"]["distances"] if one["speed_kmh"] in SPEEDS_KMH]
    far = max(
        [
            *(m for kind in there for _, m in _around(rows, cls, kind, "max", to_m)),
            *(s["distance_m"] for s in stops),
        ]
    )
    most = next(step for step in (50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0) if far <= step)
    scale = radius / most
    for ring in (most / 4, most / 2, most * 3 / 4, most):
        drawing.circle(middle, ring * scale, stroke=LINE, width=0.18)
    for turn in range(0, 360, 45):
        drawing.line([middle, _at(middle, radius, turn)], LINE, 0.15)
    for one in stops:
        drawing.circle(middle, one["distance_m"] * scale, stroke="#8d97a2", width=0.5)
    for place, kind in enumerate(there):
        best, median, least = (_around(rows, cls, kind, name, to_m) for name in ("max", "median", "min"))
        tone = GAIN if place == 0 else INK
        if place == 0 and best != least:
            band = (*best, best[0], least[0], *reversed(least))
            drawing.area([_at(middle, m * scale, turn) for turn, m in band], GAIN, 0.25)
        drawing.area(
            [_at(middle, m * scale, turn) for turn, m in median],
            "none",
            1.0,
            tone,
            0.5,
            _DASHES[min(place, 3)],
        )
    if before is not None and there:
        old = _around(before["rigs"][0]["rows"], cls, there[0], "median", to_m)
        drawing.area([_at(middle, m * scale, turn) for turn, m in old], "none", 1.0, LOSS, 0.35, "0.5 0.5")
    draw_car(drawing, shape.above, middle, scale, "#8a96a3")
    for ring in (most / 2, most):
        x, y = _at(middle, ring * scale, -22.0)
        drawing.text(x, y + 0.9, f"{ring:g} m", "middle", SOFT, halo=True)
    return drawing


def _around(
    rows: Iterable[Figures], cls: str, kind: AnyKind, which: str, to_m: float
) -> list[tuple[float, float]]:
    """Return bearings and distances of a class by a kind, the worse of all headings."""
    least: dict[float, float] = {}
    for row in rows:
        if row["class"] == cls and kind.name in row:
            far = row[kind.name]["first_below_m"][which]
            turn = row["bearing_deg"] % 360.0
            least[turn] = min(to_m if far is None else far, least.get(turn, math.inf))
    return sorted(least.items())


def _at(middle: Point, radius: float, turn_deg: float) -> Point:
    turn = math.radians(turn_deg)
    return middle[0] - radius * math.sin(turn), middle[1] - radius * math.cos(turn)


def missed_wheel(key: str, cls: str, document: Figures, compares: bool, shape: CarShape) -> Drawing:
    """Return by sector and ring what share of a class is missed, or how many more of it are detected than before."""
    wide, high, middle, radius = 56.0, 57.0, (28.0, 28.4), 26.5
    what = "gained and lost against the baseline" if compares else "missed"
    drawing = Drawing(f"{key}-wheel-{cls}", wide, high, f"Where a {cls} is {what}, by sector and distance")
    edges, of_class = document["rings_m"], document["classes"][cls]
    notes: list[tuple[Point, str, str]] = []
    scale = radius / edges[-1]
    drawing.circle(middle, radius, PANEL)
    for ring, (objects, values) in enumerate(
        zip(of_class["objects"], of_class["change" if compares else "value"], strict=True)
    ):
        for place, (count, value) in enumerate(zip(objects, values, strict=True)):
            radii = (edges[ring] * scale, edges[ring + 1] * scale)
            gain = 0.0 if value is None else -value
            strength = min(1.0, abs(gain) / 0.3) if compares else -gain
            is_shown = value is not None and abs(gain) >= 0.005
            if is_shown:
                tone = GAIN if compares and gain > 0.0 else LOSS
                drawing.area(sector(middle, radii, 45.0 * place), tone, 0.12 + 0.88 * strength)
            is_noted = abs(gain) >= NOTED if compares else ring >= 2
            if is_shown and count >= FEW_OBJECTS and is_noted:
                words = f"{100.0 * gain:+.0f}".replace("-", "−") if compares else f"{-100.0 * gain:.0f}"
                colour = INK if strength < _STRONG else PAPER if gain > 0.0 else ON_LOSS
                notes.append((_at(middle, sum(radii) / 2.0, 45.0 * place), words, colour))
    for edge in edges[1:]:
        drawing.circle(middle, edge * scale, stroke="#ffffff", width=0.3)
    for turn in range(0, 180, 45):
        drawing.line([_at(middle, radius, turn + 22.5), _at(middle, radius, turn + 202.5)], "#ffffff", 0.3)
    for (x, y), words, colour in notes:
        size_mm = 2.2 if compares else TEXT_MM  # to the left and right a sign and two digits fill a ring
        drawing.text(x, y + 0.85, words, "middle", colour, True, size_mm=size_mm)
    draw_car(drawing, shape.above, middle, scale, "#ffffff")
    return drawing


def bearing_words(bearing_deg: float) -> str:
    """Return a direction as words: ahead, at 45° left."""
    named = bearing_text(bearing_deg)
    return f"at {named}" if "°" in named else named
