"""Which class a source's object name belongs to: one table per source, and the user's overrides.

car = motor vehicles on four or more wheels; bicycle = bicycles and motorcycles, ridden or not;
pedestrian = people. A name that is in no table is not mapped: readers count it, so that nothing is
dropped silently.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES

IGNORE = "ignore"
NO_BOX_CALLED = "class map: no box is called"
UNMAPPED = -1
"""Code of a name that belongs to no class."""


def _table(car: str, bicycle: str, pedestrian: str) -> dict[str, str]:
    """Return the class by lower-case name, from blank-separated names per class."""
    groups = zip(CLASSES, (car, bicycle, pedestrian), strict=True)
    return {name: cls for cls, names in groups for name in names.split()}


# A tram runs on rails, so it is not a car; Misc and DontCare do not say what the object is.
KITTI = _table("car van truck", "cyclist", "pedestrian person person_sitting")

# Racks, cones, barriers, debris and animals are not mapped. People on wheels other than cycles stay people.
NUSCENES = _table(
    "vehicle.car vehicle.truck vehicle.trailer vehicle.construction vehicle.bus.bendy vehicle.bus.rigid"
    " vehicle.emergency.ambulance vehicle.emergency.police"
    " car truck trailer bus construction_vehicle emergency_vehicle",
    "vehicle.bicycle vehicle.motorcycle bicycle motorcycle",
    "human.pedestrian.adult human.pedestrian.child human.pedestrian.construction_worker"
    " human.pedestrian.police_officer human.pedestrian.personal_mobility human.pedestrian.stroller"
    " human.pedestrian.wheelchair pedestrian",
)

# Names of Argoverse 2 in lower case. Signal and message trailers stand still like signs: not mapped.
ARGOVERSE = _table(
    "regular_vehicle large_vehicle box_truck truck truck_cab vehicular_trailer bus school_bus"
    " articulated_bus",
    "bicycle bicyclist motorcycle motorcyclist",
    "pedestrian wheeled_rider wheelchair stroller official_signaler",
)

# Vehicle classes of the simulator SUMO, and of the bundled scenario.
SUMO = _table(
    "car passenger van delivery taxi truck trailer bus coach emergency",
    "bicycle motorcycle moped",
    "pedestrian person",
)

# The three folders of the published code.
CARLA = _table("vehicle", "cyclist", "pedestrian")

ANY_TABLE = {**KITTI, **NUSCENES, **ARGOVERSE, **SUMO}
"""The names that a plain table may use: all those above, which never contradict each other."""


@dataclass(frozen=True)
class ClassTable:
    """Maps object names to indices into CLASSES; case does not matter, the user's `overrides` take precedence.

    `names` and `overrides` are {source name: class name}; an override may also be "ignore".
    Raise InputError for any other override.
    """

    names: Mapping[str, str]
    overrides: Mapping[str, str] = field(default_factory=dict)
    met: set[str] = field(default_factory=set, compare=False, repr=False)
    """Names of the overrides that the data held so far, in lower case."""

    def __post_init__(self) -> None:
        for name, cls in self.overrides.items():
            if cls not in (*CLASSES, IGNORE):
                raise InputError(f"class of {name!r}: found {cls!r}, accepted is one of {_accepted()}")

    def effective(self) -> dict[str, str]:
        """Return the table after the overrides: {lower-case name: class name}, without ignored names."""
        chosen = {**self.names, **self._overridden()}
        return {name: cls for name, cls in sorted(chosen.items()) if cls != IGNORE}

    def codes(self, names: Iterable[str]) -> list[int]:
        """Return the index into CLASSES for each name, or UNMAPPED."""
        codes = {name: CLASSES.index(cls) for name, cls in self.effective().items()}
        asked = [name.strip().lower() for name in names]
        self.met.update(self._overridden().keys() & set(asked))
        return [codes.get(name, UNMAPPED) for name in asked]

    def never_met(self) -> list[str]:
        """Return a sentence for each override whose name was in none of the data so far."""
        return [f"{NO_BOX_CALLED} {name!r}" for name in self._overridden() if name not in self.met]

    def idle(self) -> list[tuple[str, str]]:
        """Return the overrides that leave the table as it is, sorted."""
        said = self._overridden().items()
        return sorted((name, cls) for name, cls in said if self.names.get(name, IGNORE) == cls)

    def _overridden(self) -> dict[str, str]:
        return {name.strip().lower(): cls for name, cls in self.overrides.items()}


def parse_class_map(pairs: Iterable[str]) -> dict[str, str]:
    """Return overrides from texts like "rider=bicycle" or "tram=ignore"; raise InputError for any other form."""
    overrides: dict[str, str] = {}
    for pair in pairs:
        name, equals, cls = (part.strip() for part in pair.rpartition("="))
        if not (name and equals) or cls not in (*CLASSES, IGNORE):
            raise InputError(f"class map: found {pair!r}, accepted is NAME=CLASS with one of {_accepted()}")
        overrides[name] = cls
    return overrides


def _accepted() -> str:
    return ", ".join((*CLASSES, IGNORE))
