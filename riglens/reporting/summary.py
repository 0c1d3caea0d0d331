"""The figures of page 1 of a report: the worst of each kind, and where among all figures each is found."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kinds
from riglens.core.targets.detection_range_text import HEADINGS, bearing_text

Figures = dict[str, Any]


class Found(NamedTuple):
    """A figure by its path among those of a rig, and words about it."""

    path: str
    words: str


class Missed(NamedTuple):
    """A test object that is not seen, by its profile, and its path among the figures of a rig."""

    profile: Figures
    object: Figures
    path: str


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
    unseen = [one["name"] for one in profile["objects"] if not one["seen"]]
    more = f" and {len(unseen) - 4} more" if len(unseen) > 4 else ""
    words = f"of {len(profile['objects'])} seen: {profile['title']}; unseen {', '.join(unseen[:4])}{more}"
    return Found(f"blind/profiles/{place}/seen", words)


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
    what = f"entropy of {name}" if of == "voxels" else f"all {name} objects"
    return Found(
        f"redundancy/{of}/failures/{-place}/lost/{name}", f"of {what} lost when {failure['name']} fails"
    )


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
    where = f"{row['class']} {HEADINGS[row['heading_deg']]}, {bearing_text(row['bearing_deg'])}"
    return Found(
        f"range/rigs/0/rows/{place}/{kind.name}/first_below_m",
        f"{where}; by {kind.plural}",
    )
