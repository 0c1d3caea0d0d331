"""Describe what the rig loses without one sensor, in each of the three figures; numbers, words and directions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from riglens.core.metric.scores import Scores
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.quantities import Figures
from riglens.widgets.panels.scores.text import NONE, ON_TARGET, change_text, column_of, share_text

Measure = Literal["on_target", "seen", "s_ms"]
MEASURES: dict[Measure, tuple[str, str]] = {
    "on_target": (
        "On target",
        "Loss of the mean on target of all objects without this sensor, in percentage points.",
    ),
    "seen": (
        "Seen",
        "Loss of coverage without this sensor, in percentage points of H(Ω) of all classes together.",
    ),
    "s_ms": (
        "S-MS",
        "Change of S-MS of all classes together without this sensor, in 10³ nat; the arrow shows the direction.",
    ),
}
"""Titles of the measures, and their meaning."""
HEADINGS: dict[Measure, str] = {"on_target": "Loss, pp ▾", "seen": "Loss, pp ▾", "s_ms": "10³ nat ▾"}
"""Headings of the losses in the list: their unit."""
FOLLOWS = "…"


@dataclass(frozen=True)
class Known:
    """Figures of a rig known so far: its scores and its figures of objects."""

    scores: Scores | None = None
    figures: Figures | None = None


@dataclass(frozen=True)
class Loss:
    """Loss of one sensor in the list: the length of its bar, None for no bar, and words."""

    size: float | None
    text: str
    tip: str


def loss_of(measure: Measure, now: Known, without: Known) -> Loss | None:
    """Return the loss without a sensor in a measure; None while it is not known."""
    change = changed(measure, now, without)
    if change is None:
        return None
    tip = "\n".join(["Without it, exactly:", *(_class_line(name, now, without) for name in CLASSES)])
    if math.isnan(change):
        return Loss(None, NONE, tip)
    if measure == "s_ms":
        return Loss(
            abs(change), f"{abs(change) / 1000:.2f}{'↑' if change > 0 else '↓' if change else ''}", tip
        )
    return Loss(max(-change, 0.0), f"{-100 * change:.2f}".replace("-0.00", "0.00"), tip)


def changed(measure: Measure, now: Known, without: Known) -> float | None:
    """Return the change without a sensor, of all classes together: a fraction, or nat; None while it is not known."""
    if measure == "on_target":
        if now.figures is None or without.figures is None:
            return None
        objects = sum(found.objects for found in now.figures.values())
        total = sum(
            found.objects * (without.figures[name].on_target - found.on_target)
            for name, found in now.figures.items()
            if found.objects
        )
        return total / objects if objects else math.nan
    if now.scores is None or without.scores is None:
        return None
    if measure == "seen":
        return -lost_share(now.scores, without.scores)
    classes = without.scores.classes
    return sum(classes[name].s_ms - found.s_ms for name, found in now.scores.classes.items())


def seen_entropy_nat(scores: Scores, class_name: str) -> float:
    """Return the entropy of a class, in nat, that any sensor sees."""
    found = scores.classes[class_name]
    return found.any_seen * found.h_total


def lost_share(now: Scores, without: Scores) -> float:
    """Return the share of the entropy of all classes, 0 to 1, that is seen now but not without the sensor."""
    total = sum(scores.h_total for scores in now.classes.values())
    lost = sum(seen_entropy_nat(now, name) - seen_entropy_nat(without, name) for name in now.classes)
    return lost / total if total else 0.0


def class_change(key: Measure, class_name: str, now: Known, without: Known) -> tuple[str, str]:
    """Return the change of a measure in a class without the sensor, in short and exactly."""
    if key == "on_target":
        if now.figures is None or without.figures is None:
            return FOLLOWS, ""
        one, other = now.figures[class_name], without.figures[class_name]
        change = other.on_target - one.on_target
        if math.isnan(change):
            return NONE, "no objects of this class"
        exact = f"{change!r} of {one.objects:,} objects, now {share_text(one.on_target)}"
        return change_text(change, ON_TARGET), exact
    if now.scores is None or without.scores is None:
        return FOLLOWS, ""
    column, mine, theirs = column_of(key), now.scores.classes[class_name], without.scores.classes[class_name]
    change = column.value(theirs) - column.value(mine)
    if math.isnan(change):
        return NONE, "no boxes of this class"
    if key == "s_ms":
        return change_text(change, column), f"{change!r} nat"
    nat = seen_entropy_nat(without.scores, class_name) - seen_entropy_nat(now.scores, class_name)
    return change_text(change, column), f"{change!r} of H(Ω), {nat!r} nat"


def _class_line(name: str, now: Known, without: Known) -> str:
    return f"{name}: " + ", ".join(
        f"{title} {class_change(key, name, now, without)[0]}" for key, (title, _) in MEASURES.items()
    )
