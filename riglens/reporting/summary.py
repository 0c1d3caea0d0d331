"""Page 1 of a report: the sentence, the figures that lead, and the worst of each kind with the place of its figure."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from riglens.core.figures.figure import ALL, Estimate, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import leading_figures
from riglens.core.figures.text import (
    change_estimate_text,
    decimals_of,
    error_text,
    in_unit,
    parts_text,
    verdict,
)
from riglens.core.figures.weakest import Weakest, weakest_text
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kinds
from riglens.core.targets.detection_range_text import HEADINGS
from riglens.reporting.charts import (
    bars,
    bearing_words,
    estimate_of,
    failure_rose,
    objects_missed,
    stopping_bars,
)
from riglens.reporting.document import ReportDocument
from riglens.reporting.svg import Drawing

Figures = dict[str, Any]
NO_BREAK = "\u00a0"
_DECIMALS = {"share": 1, "nat": 2, "points": 0, "px": 0}


class Found(NamedTuple):
    """A figure by its path among those of a rig, a title, and words about it."""

    path: str
    title: str
    words: str


class Missed(NamedTuple):
    """A test object that is not seen, by its profile, and its path among the figures of a rig."""

    profile: Figures
    object: Figures
    path: str


class Leading(NamedTuple):
    """A figure that leads: its mean over the classes, that of the baseline, the change with its verdict, and bars."""

    figure: Figure
    now: Estimate
    before: Estimate
    change: Estimate
    bars: Drawing
    weakest: str
    """Class, sector and distance where the figure is worst; empty where nothing is known."""

    @property
    def verdict(self) -> str:
        """Better, worse, or too small to distinguish rigs; empty without a baseline."""
        return verdict(self.figure, self.change)

    @property
    def parts(self) -> str:
        """Value that one kind of sensor alone would give, in words."""
        return parts_text(self.figure, self.now)


class Card(NamedTuple):
    """One of the three worst: what it is with the place of its figure, and a drawing; None if nothing is wrong."""

    found: Found | None
    drawing: Drawing | None
    otherwise: str


def estimate_words(figure: Figure, found: Estimate) -> str:
    """Return a figure with the digits that its error leaves, without its unit; in brackets outside its domain."""
    if not found.exists:
        return "—"
    sure = error_text(figure, found.se)
    places = decimals_of(figure, found.se) if sure else _DECIMALS.get(figure.unit, 1)
    text = f"{in_unit(figure, found.value):,.{places}f} {sure}".rstrip().replace("-", "−")
    return f"({text})" if found.state == "outside" else text


def change_words(figure: Figure, change: Estimate) -> str:
    """Return a change with its sign, and its error where it has one."""
    return _kept_together(change_estimate_text(figure, change))


def _kept_together(text: str) -> str:
    """Return text whose errors stay on the line of their figures."""
    return text.replace(" ±", f"{NO_BREAK}±")


def subjects(document: ReportDocument) -> list[int]:
    """Return the rigs that have pages of their own: those that are compared with the first one, or the only one."""
    return list(range(1, len(document.rigs))) or [0]


def figures_on_page_one() -> list[Figure]:
    """Return the leading figures that are shares."""
    return [figure for figure in leading_figures() if figure.per_class and figure.unit == "share"]


def leading_of(document: ReportDocument, number: int, classes: list[str]) -> Iterator[Leading]:
    """Yield the leading figures of a rig with those of the first one, where that is another."""
    rigs, scored = document.figures["rigs"], document.figures["evaluation"]["rigs"]
    against = rigs[number]["against"]
    for figure in figures_on_page_one():
        changes = {} if against is None else against["changes"].get(figure.key, {})

        def values(rig: int, cls: str, figure: Figure = figure) -> Estimate:
            return estimate_of(scored[rig]["classes"][cls]["figures"].get(figure.key))

        none, compares = Estimate.none(""), bool(number)
        rows = [
            (
                cls,
                f"evaluation/rigs/{number}/classes/{cls}/figures/{figure.key}",
                values(number, cls),
                values(0, cls) if compares else none,
                estimate_of(changes.get(cls)),
            )
            for cls in classes
        ]
        yield Leading(
            figure,
            estimate_of(scored[number]["figures"].get(figure.key)),
            estimate_of(scored[0]["figures"].get(figure.key)) if compares else none,
            estimate_of(changes.get(ALL)),
            bars(f"rig{number + 1}", figure, rows),
            _weakest(figure, scored[number]["figures"].get(figure.key)),
        )


def _weakest(figure: Figure, found: Figures | None) -> str:
    if found is None or "weakest" not in found or not isinstance(figure, ObjectFigure):
        return ""
    return weakest_text(figure, Weakest.of_dict(found["weakest"]))


def headline(document: ReportDocument, number: int) -> str:
    """Return the sentence of page 1: how a rig compares with the first one, or the leading figures in words."""
    rig = document.figures["rigs"][number]
    if rig["against"] is not None:
        return _kept_together(f"{rig['against']['sentence']}.")
    whole = document.figures["evaluation"]["rigs"][number]["figures"]
    found = [(figure, estimate_of(whole.get(figure.key))) for figure in figures_on_page_one()]
    parts = [
        f"{figure.title} {f'{estimate_words(figure, one)} %'.replace(' ', NO_BREAK)}"
        for figure, one in found
        if one.exists
    ]
    return (
        "; ".join([*parts[:1], *(part[:1].lower() + part[1:] for part in parts[1:])]) + "." if parts else ""
    )


# ---------------------------------------------------------------- the three worst
def worst_cards(document: ReportDocument, number: int) -> list[Card]:
    """Return the worst test objects, failure and detection range of a rig."""
    rig, shape, key = document.figures["rigs"][number], document.drawings[number].shape, f"rig{number + 1}"
    vehicle = document.rigs[number].vehicle
    profile, failure, reach = worst_profile(rig), worst_failure(rig), smallest_range(rig)
    cards = [Card(profile, None, "Every test object for such a vehicle is seen.")]
    if profile is not None:
        objects = rig["blind"]["profiles"][int(profile.path.split("/")[2])]
        cards = [Card(profile, objects_missed(key, objects, shape, (vehicle.length, vehicle.width)), "")]
    cards.append(Card(failure, None, "The rig has no sensor that could fail."))
    if failure is not None:
        _, of, _, place, _, cls = failure.path.split("/")
        lost = rig["redundancy"][of]["failures"][int(place)]["lost_by_sector"][cls]
        cards[1] = Card(
            failure, failure_rose(key, lost, rig["redundancy"][of]["sectors"], shape, failure.title), ""
        )
    cards.append(Card(reach, None, "The rig has no sensor that detects an object."))
    if reach is not None:
        row, found = rig["range"]["rigs"][0]["rows"][int(reach.path.split("/")[4])], rig["range"]
        cards[2] = Card(reach, stopping_bars(key, row, found["to_m"], found["stopping"], reach.title), "")
    return cards


def worst_profile(rig: Figures) -> Found | None:
    """Return the number of objects seen of the profile, of those for this vehicle, with the largest share missed; None
    where every object is seen."""
    places = [
        (sum(one["seen"] for one in profile["objects"]) / len(profile["objects"]), place)
        for place, profile in enumerate(rig["blind"]["profiles"])
        if profile["for_this_vehicle"] and not profile["passes"]
    ]
    if not places:
        return None
    place = min(places)[1]
    profile = rig["blind"]["profiles"][place]
    words = f"of {len(profile['objects'])} test objects are seen"
    return Found(f"blind/profiles/{place}/seen", profile["title"], words)


def missed_objects(rig: Figures) -> Iterator[Missed]:
    """Yield every test object that no sensor sees, in the order of the profiles."""
    for place, profile in enumerate(rig["blind"]["profiles"]):
        for number, one in enumerate(profile["objects"]):
            if not one["seen"]:
                yield Missed(profile, one, f"blind/profiles/{place}/objects/{number}")


def worst_failure(rig: Figures) -> Found | None:
    """Return the most that the failure of one sensor or one group costs of a class: of objects where they were counted,
    else of entropy; None for a rig without sensors."""
    of = "voxels" if rig["redundancy"]["objects"] is None else "objects"
    cases = [
        (failure["lost"][name], -place, -cls)
        for place, failure in enumerate(rig["redundancy"][of]["failures"])
        if failure["what"] in ("sensor", "group")
        for cls, name in enumerate(CLASSES)
    ]
    if not cases:
        return None
    _, place, cls = max(cases)
    failure, name = rig["redundancy"][of]["failures"][-place], CLASSES[-cls]
    what = f"the entropy of {name}" if of == "voxels" else f"all {name} objects"
    words = f"of {what} are then lost: nothing else detects them"
    return Found(f"redundancy/{of}/failures/{-place}/lost/{name}", f"{failure['name']} fails", words)


def smallest_range(rig: Figures) -> Found | None:
    """Return the first distance with too little for the kind that reaches farthest, where that is least: by class and
    direction, at the worst place between the beams; None without sensors."""
    cases = []
    for place, row in enumerate(rig["range"]["rigs"][0]["rows"]):
        reaches = []
        for kind in kinds():
            if kind.name in row:
                least = row[kind.name]["first_below_m"]["min"]
                reaches.append((math.inf if least is None else least, kind))
        if reaches:
            far, kind = max(reaches, key=lambda reach: reach[0])
            cases.append((far, place, kind))
    if not cases:
        return None
    _, place, kind = min(cases, key=lambda case: case[:2])
    row = rig["range"]["rigs"][0]["rows"][place]
    where = f"{row['class']} {HEADINGS[row['heading_deg']]}, {bearing_words(row['bearing_deg'])}".capitalize()
    words = f"is the detection range, by {kind.plural}; no direction or class has a shorter one"
    return Found(f"range/rigs/0/rows/{place}/{kind.name}/first_below_m", where, words)
