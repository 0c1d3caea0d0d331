"""Map a source's object names to classes: one table per source, and the user's overrides.

car = motor vehicles on four or more wheels; bicycle = bicycles and motorcycles, ridden or not;
pedestrian = people. A name that is in no table is not mapped: readers count it, so that nothing is
dropped silently.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES

IGNORE = "ignore"
NO_BOX_CALLED = "class map: no box is called"
UNMAPPED = -1
"""Code of a name that belongs to no class."""


def _table(car: str, bicycle: str, pedestrian: str, between: str | None = None) -> dict[str, str]:
    """Return the class by lower-case name, from names per class separated by `between`."""
    groups = zip(CLASSES, (car, bicycle, pedestrian), strict=True)
    return {name.strip(): cls for cls, names in groups for name in names.split(between)}


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

# Waymo Open Dataset: label.proto and segmentation.proto. Signs are not mapped.
WAYMO = _table(
    "type_vehicle type_car type_truck type_bus type_other_vehicle",
    "type_cyclist type_bicyclist type_motorcyclist type_bicycle type_motorcycle",
    "type_pedestrian",
)

# nuPlan: tracked object types. Cones, barriers, signs and generic objects are not mapped.
NUPLAN = _table("vehicle", "bicycle", "pedestrian")

# PandaSet's cuboids. Trains, trams and trolleys run on rails; animals, cones, signs and the like are not mapped.
PANDASET = _table(
    "car, pickup truck, medium-sized truck, semi-truck, towed object, bus, emergency vehicle,"
    " other vehicle - construction vehicle, other vehicle - uncommon",
    "bicycle, motorcycle, motorized scooter, other vehicle - pedicab",
    "pedestrian, pedestrian with object, personal mobility device",
    between=",",
)

# ONCE, ZOD, DAIR-V2X and OPV2V. Tricycles, barrows and wheelchairs are neither cycles nor people on foot: not mapped.
FRAME_FILES = _table(
    "car bus truck van trailer heavyequip vehicle", "cyclist bicycle motorcycle motorcyclist", "pedestrian"
)

# Blueprints of CARLA 0.9: "vehicle.", maker, model; the makers of two-wheelers make nothing else there.
CARLA_BLUEPRINTS = _table(
    "vehicle.audi.* vehicle.bmw.* vehicle.carlamotors.* vehicle.chevrolet.* vehicle.citroen.* vehicle.dodge.*"
    " vehicle.ford.* vehicle.jeep.* vehicle.lincoln.* vehicle.mercedes.* vehicle.mercedes-benz.* vehicle.micro.*"
    " vehicle.mini.* vehicle.mitsubishi.* vehicle.nissan.* vehicle.seat.* vehicle.tesla.* vehicle.toyota.*"
    " vehicle.volkswagen.*",
    "vehicle.bh.crossbike vehicle.diamondback.century vehicle.gazelle.omafiets vehicle.harley-davidson.*"
    " vehicle.kawasaki.* vehicle.vespa.* vehicle.yamaha.*",
    "walker.pedestrian.*",
)

ANY_TABLE = {**KITTI, **NUSCENES, **ARGOVERSE, **SUMO, **WAYMO, **NUPLAN, **PANDASET, **CARLA_BLUEPRINTS}
"""The names that a plain table may use: all those above, which never contradict each other."""


@dataclass(frozen=True)
class ClassTable:
    """Map of object names to indices into CLASSES; case does not matter, the user's `overrides` take precedence.

    `names` and `overrides` are {source name: class name}; an override may also be "ignore". In both, * stands for
    any letters and ? for one; a name without them goes before one with, and of several such overrides the last one
    that fits counts. Raise InputError for any other override.
    """

    names: Mapping[str, str]
    overrides: Mapping[str, str] = field(default_factory=dict)
    met: set[str] = field(default_factory=set, compare=False, repr=False)
    """Names of the overrides that the data held so far, in lower case."""

    def __post_init__(self) -> None:
        for name, cls in self.overrides.items():
            if cls not in (*CLASSES, IGNORE):
                raise InputError(f"must map {name!r} to one of {_accepted()} (got {cls!r})", "classes")

    def effective(self) -> dict[str, str]:
        """Return the table after the overrides, {lower-case name: class name}: all that decides a box's class.

        Ignored names are left out; overrides with * or ? come last, in their order, those that ignore included.
        """
        said = self._overridden()
        names = sorted(name for name in {*self.names, *said} if name in self.names or not _is_pattern(name))
        plain = {name: cls for name in names if (cls := self._class_of(name, said)) != IGNORE}
        patterns = {name: cls for name, cls in said.items() if _is_pattern(name)}
        return {name: cls for name, cls in plain.items() if name not in patterns} | patterns

    def codes(self, names: Iterable[str]) -> list[int]:
        """Return the index into CLASSES for each name, or UNMAPPED."""
        said = self._overridden()
        codes: dict[str, int] = {}
        found = []
        for name in (asked.strip().lower() for asked in names):
            if name not in codes:
                cls = self._class_of(name, said)
                codes[name] = UNMAPPED if cls == IGNORE else CLASSES.index(cls)
            found.append(codes[name])
        self.met.update(name for name in said if name in codes or any(fits(each, name) for each in codes))
        return found

    def never_met(self) -> list[str]:
        """Return a sentence for each override whose name occurred in none of the data so far."""
        return [f"{NO_BOX_CALLED} {name!r}" for name in self._overridden() if name not in self.met]

    def idle(self) -> list[tuple[str, str]]:
        """Return the overrides that do not change the table, sorted."""
        said = self._overridden().items()
        return sorted((name, cls) for name, cls in said if self._class_of(name, {}) == cls)

    def _class_of(self, name: str, overrides: Mapping[str, str]) -> str:
        """Return the class of a lower-case name, IGNORE when nothing names it."""
        for table in (overrides, self.names):
            if name in table:
                return table[name]
            patterns = [cls for pattern, cls in table.items() if fits(name, pattern)]
            if patterns:
                return patterns[-1]
        return IGNORE

    def _overridden(self) -> dict[str, str]:
        return {name.strip().lower(): cls for name, cls in self.overrides.items()}


def fits(name: str, pattern: str) -> bool:
    """Return whether a name fits one with * for any letters and ? for one; without them only itself fits."""
    return name == pattern or (_is_pattern(pattern) and fnmatchcase(name, pattern.replace("[", "[[]")))


def _is_pattern(name: str) -> bool:
    return "*" in name or "?" in name


def parse_class_map(pairs: Iterable[str]) -> dict[str, str]:
    """Return overrides from texts like "rider=bicycle" or "tram=ignore"; raise InputError for any other form."""
    overrides: dict[str, str] = {}
    for pair in pairs:
        name, equals, cls = (part.strip() for part in pair.rpartition("="))
        if not (name and equals) or cls not in (*CLASSES, IGNORE):
            raise InputError(f"must be NAME=CLASS with one of {_accepted()} (got {pair!r})", "classes")
        overrides[name] = cls
    return overrides


def _accepted() -> str:
    return ", ".join((*CLASSES, IGNORE))
