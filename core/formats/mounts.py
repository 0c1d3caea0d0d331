"""From the axes and origin of a foreign file to the vehicle frame, and from its content to valid sensors."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from riglens.core.errors import InputError
from riglens.core.formats.frames import Matrix, inverse, pose_from_se3, se3
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_PIXELS
from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.library import Entry, default_library
from riglens.core.rig.model import MAX_SENSORS, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.file import RigFile
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.rig.yaml.problems import problem_text, problems
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import AnyKind, kind_of, shown_kinds

_FAR_FROM_MIDDLE = 0.12
"""Share of an image's side that a principal point may be off its middle: real lenses stay within 0.06 (our choice)."""
DEFAULT_LIDAR = "generic-16"
_ASSUMED = {"lidar": DEFAULT_LIDAR, "radar": "generic-radar", "ultrasonic": "generic-ultrasonic"}
"""The library model of each kind that stands for an unknown one."""


@dataclass(frozen=True)
class ReadOptions:
    """Details of a foreign file that the user may state because the file does not contain them.

    vehicle: the car that the sensors are on; rear_axle_x: where its rear axle is, metres from the body centre;
    origin_m: where the origin of the file lies in the vehicle frame, metres; token: which rig to take of several;
    kit: the folder of an Autoware kit's description, which lies elsewhere than its individual_params.
    """

    vehicle: Vehicle | None = None
    rear_axle_x: float | None = None
    origin_m: Vec3 | None = None
    token: str | None = None
    kit: Path | None = None

    def __post_init__(self) -> None:
        numbers = [*(self.origin_m or ()), self.rear_axle_x or 0.0]
        if not all(math.isfinite(number) and abs(number) <= 1e6 for number in numbers):
            raise InputError("must be finite, in metres", "origin_m" if self.origin_m else "rear_axle_x")

    def vehicle_or(self, known: Vehicle) -> Vehicle:
        """Return the vehicle that the user named, or else the one known from the file or its data set."""
        found = self.vehicle or known
        if self.rear_axle_x is None:
            return found
        return found.replace(rear_axle_x=self.rear_axle_x)


def rear_axle_on_ground(vehicle: Vehicle) -> Vec3:
    """Return where the middle of the rear axle, dropped to the ground, lies in the vehicle frame."""
    return vehicle.rear_axle_x, 0.0, 0.0


class Origin(NamedTuple):
    """The origin of a file: what is there, where that is in the vehicle frame, and whether the format says so."""

    what: str
    place_m: Callable[[Vehicle], Vec3]
    is_known: bool = False


SEDAN = Vehicle()
ON_ROOF = Origin("the origin", lambda vehicle: (0.0, 0.0, vehicle.height))
REAR_AXLE = Origin("the rear axle on the ground", rear_axle_on_ground, is_known=True)
ACTOR = Origin("the vehicle's actor in CARLA", lambda _: (0.0, 0.0, 0.0), is_known=True)


@dataclass
class Mounting:
    """Collector of the sensors of a file, with what the options, else the file, else its format say of the vehicle.

    `car` describes the vehicle that is assumed, empty where the file has one; `file` is RigLens' own rig file, if the
    source is one.
    """

    where: str
    notes: Notes
    options: ReadOptions
    known: Vehicle
    car: str
    origin: Origin
    sensors: list[Sensor] = field(default_factory=list)
    file: RigFile | None = None

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle that the sensors are on."""
        return self.options.vehicle_or(self.known)

    @property
    def origin_m(self) -> Vec3:
        """Place of the file's root frame in the vehicle frame, metres."""
        return self.options.origin_m or self.origin.place_m(self.vehicle)

    def found(self, vehicle: Vehicle | None) -> None:
        """Take the vehicle that the file has, if any."""
        if vehicle is not None:
            self.known, self.car = vehicle, ""

    def pose(self, root_SE3_sensor: Matrix) -> Pose:
        """Return the pose in the vehicle frame from that in the file's root frame."""
        return pose_from_se3(se3(np.eye(3), self.origin_m) @ root_SE3_sensor)

    def add(
        self, kind: str, name: str, root_SE3_sensor: Matrix, said: str | None = None, **fields: Any
    ) -> None:
        """Add a sensor at the pose of its body (x forward, y left, z up), with `fields`.

        Rays that these do not give are those of the library model that `said` or the name tells, or assumed ones.
        """
        if len(self.sensors) >= MAX_SENSORS:
            raise InputError(f"{self.where}: too many sensors (at most {MAX_SENSORS})")
        found = kind_of(kind)
        if kind in _ASSUMED and not ("elevations_deg" in fields if kind == "lidar" else fields):
            entry = self._entry(found, name, said)
            fields = entry.fields | {"model": entry.name} | fields
        pose = self.pose(root_SE3_sensor)
        unique = self._unique(name)
        data = {"name": unique, "position": pose.position_m, "rpy_deg": pose.rpy_deg, **fields}
        try:
            self.sensors.append(found.model(**data))
        except ValidationError as error:
            complaint = problem_text(problems(error, data)[0], data)
            raise InputError(f"{self.where}: sensor '{shortened(unique)}': {complaint}") from error

    def unknown_image(self, name: str, usual: tuple[int, int], lens: Mapping[str, Any]) -> tuple[int, int]:
        """Return the image of a camera whose file has the lens alone: the usual one of the format.

        Where that cannot be, the principal point being far from its middle, it is twice the principal point.
        """
        centre = lens.get("cx", usual[0] / 2.0), lens.get("cy", usual[1] / 2.0)
        off = max(abs(at - side / 2.0) / side for at, side in zip(centre, usual, strict=True))
        width, height = (max(1, min(MAX_PIXELS, round(2.0 * at))) for at in centre)
        if off <= _FAR_FROM_MIDDLE or min(centre) <= 0.0:
            width, height = usual
            self.notes.approximated(f"image size not in the file: {width} x {height} pixels", name)
        else:
            self.notes.approximated(
                f"image size not in the file: {width} x {height} pixels, twice the principal point, which does not fit "
                f"the usual {usual[0]} x {usual[1]}",
                name,
            )
        return width, height

    def unknown_lens(
        self, name: str, why: str = "lens and image not in the file", image: tuple[int, int] = (1600, 900)
    ) -> dict[str, Any]:
        """Return an assumed lens for a camera of which the file has the pose alone."""
        self.notes.approximated(f"{why}: {image[0]} x {image[1]} pixels, 70 degrees wide", name)
        return {"image": image, "hfov_deg": 70.0}

    def rig(self, name: str, may_be_empty: bool = False) -> Rig:
        """Return the rig of all sensors so far, and report what is assumed of vehicle and origin.

        Raise InputError when there is no sensor and that is not allowed.
        """
        x, y, z = self.origin_m
        if self.origin.is_known and any(self.origin_m):
            self.notes.converted(
                f"origin from {self.origin.what} to the body centre: added {x:g} {y:g} {z:g} m"
            )
        elif not self.origin.is_known and self.options.origin_m is None:
            where = f"position of {self.origin.what} on the vehicle not in the file: {x:g} {y:g} {z:g} m"
            self.notes.approximated(where, field="origin_m")
        if self.car and self.options.vehicle is None:
            self.notes.approximated(f"vehicle not in the file: {self.car}", field="vehicle")
        if not self.sensors and not may_be_empty:
            ignored = "; ".join(one.sentence() for one in self.notes.report("").of_kind("ignored"))
            why = f"; ignored: {shortened(ignored, 200)}" if ignored else ""
            raise InputError(f"{self.where}: a rig needs at least one sensor{why}")
        shown = sorted(shown_kinds(s.kind for s in self.sensors), key=lambda kind: kind.name)
        counts = [(sum(s.kind == kind.name for s in self.sensors), kind) for kind in shown]
        self.notes.read(", ".join(f"{n} {kind.title if n == 1 else kind.plural}" for n, kind in counts))
        return Rig(name=shortened(name, 190) or "imported", vehicle=self.vehicle, sensors=tuple(self.sensors))

    def _entry(self, kind: AnyKind, name: str, said: str | None) -> Entry:
        told, assumed = find_model(said, kind.name) if said else None, _ASSUMED[kind.name]
        part = "beams" if kind is LIDAR else "angles"
        found = told or find_model(name, kind.name)
        if found is not None:
            how = f"its {part} are those of the library model" if told else "taken by its name for a"
            add = self.notes.read if told else self.notes.approximated
            add(f"{how} {found.name}", name)
            if found.unverified:
                self.notes.approximated(f"{found.name} in the library is {found.caveat()}", name)
            return found
        what = f"unknown to the library ({shortened(said, 40)})" if said else "not in the file"
        self.notes.approximated(
            f"unknown {part}, {kind.title} model {what}: assumed those of {assumed}", name
        )
        return default_library().entry(assumed)

    def _unique(self, name: str) -> str:
        """Return the name as a rig accepts it: not empty, not too long, not taken."""
        base = name.strip()[:190] or "sensor"
        used = {sensor.name for sensor in self.sensors}
        found = next(new for number in range(1, 999) if (new := _numbered(base, number)) not in used)
        if found != name:
            self.notes.converted(f"renamed from '{shortened(name, 40)}'", found)
        return found


_MOST_WORDS = 6
_MAKERS = "velodyne|hesai|robosense|rslidar|rs|livox|ouster|continental|conti|smartmicro|aptiv"


def find_model(words: str, kind: str = "lidar") -> Entry | None:
    """Return the sensor of the library that the words name ("VELO_VLP32C", "Hesai Pandar64"); the longest name wins.

    A name that goes on, as `helios_16p`, `mid_360s` and `os1_64_rev7` do, is that of another model; a number such as
    `_1` counts sensors.
    """
    runs = _runs_of_words(words)
    entries = default_library().entries(kind)
    exact = [entry for entry in entries if entry.name == words]
    found = exact or [entry for entry in entries if any(run.endswith(_products(entry)) for run in runs)]
    if found:
        return max(found, key=lambda entry: len(_product(entry)))
    said = {
        max((len(run) for run in runs if _is_other_name(entry, run)), default=0): entry
        for entry in reversed(entries)
    }
    length = max(said, default=0)  # as in "puck hires", which begins with another model
    return said[length] if length else None


def _is_other_name(entry: Entry, run: str) -> bool:
    names = "|".join(entry.other_names)
    return bool(names and re.fullmatch(f"(?:{_MAKERS})*(?:{names})", run))


def _runs_of_words(text: str) -> list[str]:
    """Return the letters and digits of words that follow each other, up to each that may end the name of a model."""
    words = re.findall(r"[a-z0-9]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z][a-z])", " ", text).lower())
    goes_on = [bool(re.match(r"[0-9]{2}|[0-9]+[a-z]|rev[0-9]", word)) for word in [*words[1:], ""]]
    ends = [place for place, more in enumerate(goes_on, 1) if not more]
    return ["".join(words[start:end]) for end in ends for start in range(max(0, end - _MOST_WORDS), end)]


def _product(entry: Entry) -> str:
    """Return the library name without the maker and without punctuation; a name without a number matches nothing."""
    product = re.sub(r"[^a-z0-9]", "", entry.name.partition("-")[2].lower())
    is_telling = len(product) >= 4 and any(letter.isdigit() for letter in product)
    return product if is_telling else "\n"


def _products(entry: Entry) -> tuple[str, ...]:
    """Return the product, alone and with the revision that its title states."""
    product = _product(entry)
    revision = re.search(r"\brev[0-9]+", entry.title.lower())
    return (product,) if revision is None else (product, product + revision[0])


def _numbered(base: str, number: int) -> str:
    return base if number == 1 else f"{base}_{number}"


def sensors_to_write(rig: Rig, notes: Notes, kinds: Collection[str]) -> list[Sensor]:
    """Return the enabled sensors of these kinds; others are reported. Raise InputError when none is left."""
    for sensor in rig.sensors:
        if not sensor.enabled:
            notes.ignored("disabled in the rig, not written", sensor.name)
        elif sensor.kind not in kinds:
            notes.ignored(f"{kind_of(sensor).title}: the format cannot express it", sensor.name)
        elif sensor.mirror_of is not None:
            notes.ignored("mirror pair: the format cannot express it", sensor.name)
        if sensor.enabled and sensor.kind in kinds and sensor.fails_with is not None:
            notes.ignored("failure groups: the format cannot express them", sensor.name)
        if sensor.enabled and sensor.kind in kinds and sensor.blocked:
            notes.ignored("blocked sectors: the format cannot express them", sensor.name)
    if not rig.self_occlusion:
        notes.ignored("rays through the car's own body: the format cannot express it", rig.name)
    if rig.obstacles:
        notes.ignored("housings that stop rays: the format cannot express them", rig.name)
    if rig.keep_out:
        notes.ignored("keep-out zones: the format cannot express them", rig.name)
    chosen = [sensor for sensor in rig.sensors if sensor.enabled and sensor.kind in kinds]
    if not chosen:
        raise InputError(f"rig '{shortened(rig.name)}': it has no enabled sensor to write")
    return chosen


def root_SE3_body(sensor: Sensor, origin_m: Vec3) -> Matrix:
    """Return the transform of a sensor in a frame whose origin is at `origin_m` in the vehicle frame."""
    return inverse(se3(np.eye(3), origin_m)) @ sensor.pose.vehicle_SE3_sensor()
