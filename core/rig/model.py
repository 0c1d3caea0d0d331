"""Frozen, validated description of a rig: vehicle, LiDARs and cameras, as in the rig YAML version 1."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, ClassVar, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from riglens.core.geometry import Pose


class Frozen(BaseModel):
    """Immutable, strict, no unknown keys; fields are addressed by the names of the YAML file."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, populate_by_name=True)

    def replace(self, **changes: object) -> Self:
        """Return a validated copy with some fields changed; raise pydantic's ValidationError where one does not fit."""
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return type(self)(**(fields | changes))


Coefficient = Annotated[float, Field(allow_inf_nan=False, ge=-1e9, le=1e9)]


class BrownConrady(Frozen):
    """Radial and tangential distortion; with k4, k5 or k6 the rational model (OpenCV, calib3d).

    r' / r = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6), r on the plane at distance 1.
    """

    model: Literal["brown_conrady"] = "brown_conrady"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    p1: Coefficient = 0.0
    p2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0
    k5: Coefficient = 0.0
    k6: Coefficient = 0.0


class KannalaBrandt(Frozen):
    """Fisheye: theta' = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8) (OpenCV, fisheye)."""

    model: Literal["kannala_brandt"] = "kannala_brandt"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0


Distortion = Annotated[BrownConrady | KannalaBrandt, Field(discriminator="model")]
COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
"""Every coefficient of any model; each is 0 when it is not given."""


FORMAT_VERSION = 1
PARAMETRIC_BODIES = ("sedan", "suv", "van", "truck")
MAX_SENSORS = 255
MAX_GROUPS = 16
"""Of a sensor: brackets, control units, cables, windows with which it fails."""
MAX_SPOTS = 1000
"""Of painted keep-out zones."""
MAX_RAYS_PER_SENSOR = 1 << 26
MAX_LISTED_RAYS = 1 << 23
"""Rays that do not form a table of rows and columns (lens distortion, azimuth offsets) are stored one by one."""

Metres = Annotated[float, Field(allow_inf_nan=False, ge=-1e7, le=1e7)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
Length = Annotated[float, Field(allow_inf_nan=False, ge=1e-3, le=100.0)]
VehicleLength = Annotated[float, Field(allow_inf_nan=False, ge=0.1, le=100.0)]
Degrees = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
"""Thousands of turns, and still exact to 1e-10 degrees."""
FieldOfView = Annotated[float, Field(allow_inf_nan=False, ge=0.001, le=179.9)]
FocalLength = Annotated[float, Field(allow_inf_nan=False, ge=1e-4, le=1e10)]
"""In pixels; any field of view that is accepted has such a one, whatever the image."""
PrincipalPoint = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Elevation = Annotated[float, Field(allow_inf_nan=False, ge=-90.0, le=90.0)]
Azimuth = Annotated[float, Field(allow_inf_nan=False, ge=-360.0, le=360.0)]
Name = Annotated[str, Field(min_length=1, max_length=200)]
Pixels = Annotated[int, Field(ge=1, le=20_000)]
Position = tuple[Metres, Metres, Metres]
Angles3 = tuple[Degrees, Degrees, Degrees]
SpotRadius = Annotated[float, Field(allow_inf_nan=False, ge=0.005, le=2.0)]
Spot = tuple[Metres, Metres, Metres, SpotRadius]
"""A ball around a place on the car's skin: x, y, z and radius in metres."""


class EvenAngles(Frozen):
    """`count` evenly spaced angles in degrees; whether `to` is included depends on where they are used."""

    from_: Azimuth = Field(alias="from")
    to: Azimuth
    count: Annotated[int, Field(ge=1, le=100_000)]

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if self.to < self.from_:
            raise ValueError(f"'to' ({self.to}) must not be below 'from' ({self.from_})")
        return self

    def both_ends_deg(self) -> NDArray[np.float64]:
        """Return the angles with both ends included, (count,); one angle is `from`."""
        if self.count == 1:
            return np.array([self.from_])
        return self.from_ + np.arange(self.count) * (self.to - self.from_) / (self.count - 1)

    def open_end_deg(self) -> NDArray[np.float64]:
        """Return the angles from + i (to - from) / count, (count,): a full turn has no duplicate end."""
        return self.from_ + np.arange(self.count) * (self.to - self.from_) / self.count


class _Mounted(Frozen):
    """What LiDARs and cameras have in common: a name, a pose, a range."""

    name: Name
    model: str | None = None
    position: Position
    rpy_deg: Angles3 = (0.0, 0.0, 0.0)
    range_m: tuple[Annotated[float, Field(ge=0.0)], Annotated[float, Field(gt=0.0)]] = (0.0, math.inf)
    enabled: bool = True
    mirror_of: Name | None = None
    fails_with: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MAX_GROUPS)] | None = None

    @model_validator(mode="after")
    def _range_rises(self) -> Self:
        low, high = self.range_m
        if math.isnan(low) or math.isnan(high) or math.isinf(low) or not low < high:
            raise ValueError(f"range_m must be [min, max] with 0 <= min < max, found [{low}, {high}]")
        return self

    @property
    def pose(self) -> Pose:
        """Pose of the sensor in the vehicle frame."""
        return Pose(self.position, self.rpy_deg)

    def with_pose(self, pose: Pose) -> Self:
        """Return the same sensor elsewhere; not validated again, because this happens on every mouse move."""
        return self.model_copy(update={"position": pose.position_m, "rpy_deg": pose.rpy_deg})


class Lidar(_Mounted):
    """Spinning LiDAR; `elevations_deg` with both ends, `azimuths_deg` with an open end (paper, eq. 2).

    `azimuth_offsets_deg`, one per beam, are added to the azimuths of that beam (positive turns left).
    """

    kind: Literal["lidar"] = "lidar"
    elevations_deg: EvenAngles | Annotated[tuple[Elevation, ...], Field(min_length=1)]
    azimuths_deg: EvenAngles | Annotated[tuple[Azimuth, ...], Field(min_length=1)] = EvenAngles(
        from_=-180.0, to=180.0, count=360
    )
    azimuth_offsets_deg: tuple[Azimuth, ...] | None = None

    @model_validator(mode="after")
    def _angles_sensible(self) -> Self:
        if not 0 < self.ray_count <= MAX_RAYS_PER_SENSOR:
            raise ValueError(f"a LiDAR casts 1 to {MAX_RAYS_PER_SENSOR} rays, found {self.ray_count}")
        beams, turn = self.elevations_deg, self.azimuths_deg
        if isinstance(beams, EvenAngles) and (beams.from_ < -90.0 or beams.to > 90.0):
            raise ValueError(f"elevations_deg must lie in [-90, 90], found {beams.from_} to {beams.to}")
        span_deg = turn.to - turn.from_ if isinstance(turn, EvenAngles) else max(turn) - min(turn)
        if span_deg > 360.0:
            raise ValueError(f"azimuths_deg must not span more than 360 degrees, found {span_deg}")
        return self

    @model_validator(mode="after")
    def _offsets_fit(self) -> Self:
        offsets, beams = self.azimuth_offsets_deg, self.beam_count
        if offsets is not None and len(offsets) != beams:
            raise ValueError(
                f"azimuth_offsets_deg must hold one offset per beam, {beams}, found {len(offsets)}"
            )
        if offsets is not None and self.ray_count > MAX_LISTED_RAYS:
            raise ValueError(
                f"azimuth_offsets_deg go with at most {MAX_LISTED_RAYS} rays, found {self.ray_count}"
            )
        return self

    def elevations(self) -> NDArray[np.float64]:
        """Return the beam elevations in degrees, (beams,)."""
        angles = self.elevations_deg
        return (
            angles.both_ends_deg() if isinstance(angles, EvenAngles) else np.array(angles, dtype=np.float64)
        )

    def azimuths(self) -> NDArray[np.float64]:
        """Return the azimuths in degrees, (azimuths,)."""
        angles = self.azimuths_deg
        return angles.open_end_deg() if isinstance(angles, EvenAngles) else np.array(angles, dtype=np.float64)

    @property
    def beam_count(self) -> int:
        """Number of beams."""
        beams = self.elevations_deg
        return beams.count if isinstance(beams, EvenAngles) else len(beams)

    @property
    def ray_count(self) -> int:
        """Number of rays cast: beams times azimuths."""
        turn = self.azimuths_deg
        return self.beam_count * (turn.count if isinstance(turn, EvenAngles) else len(turn))


class Camera(_Mounted):
    """Camera; casts a lattice `cast` of rays through pixel centres of the resized image (paper, eq. 3-5).

    A pinhole, or with `distortion` a lens that bends its rays as in `riglens.core.sensing.lens`.
    """

    kind: Literal["camera"] = "camera"
    image: tuple[Pixels, Pixels] = (1600, 900)
    hfov_deg: FieldOfView | None = None
    fx: FocalLength | None = None
    fy: FocalLength | None = None
    cx: PrincipalPoint | None = None
    cy: PrincipalPoint | None = None
    distortion: Distortion | None = None
    cast: tuple[Pixels, Pixels] = (352, 128)

    @model_validator(mode="after")
    def _one_way_to_say_the_lens(self) -> Self:
        given = [value is not None for value in (self.fx, self.fy, self.cx, self.cy)]
        if (self.hfov_deg is None and not all(given)) or (self.hfov_deg is not None and any(given)):
            raise ValueError("give either hfov_deg or all of fx, fy, cx, cy")
        if self.cast[0] > self.image[0] or self.cast[1] > self.image[1]:
            raise ValueError(f"cast {list(self.cast)} must not exceed the image {list(self.image)}")
        return self

    @model_validator(mode="after")
    def _distortion_has_a_matrix(self) -> Self:
        if self.distortion is not None and self.hfov_deg is not None:
            raise ValueError("distortion needs the lens as fx, fy, cx, cy in pixels, not as hfov_deg")
        if self.distortion is not None and self.ray_count > MAX_LISTED_RAYS:
            raise ValueError(f"distortion goes with at most {MAX_LISTED_RAYS} rays, found {self.ray_count}")
        return self

    def intrinsics_px(self) -> tuple[float, float, float, float]:
        """Return focal lengths and principal point (fx, fy, cx, cy) in pixels of the native image (paper, eq. 3)."""
        if self.hfov_deg is not None:
            width_px, height_px = self.image
            focal_px = (width_px / 2) / math.tan(math.radians(self.hfov_deg) / 2)
            return focal_px, focal_px, width_px / 2, height_px / 2
        assert self.fx is not None and self.fy is not None and self.cx is not None and self.cy is not None
        return self.fx, self.fy, self.cx, self.cy

    @property
    def ray_count(self) -> int:
        """Number of rays of the lattice, columns times rows; a distorted lens may have none for some of them."""
        return self.cast[0] * self.cast[1]


Sensor = Lidar | Camera
"""A sensor of any kind, told apart by `kind`; add a new kind here."""


_S = TypeVar("_S", bound=_Mounted)


def rays_of(sensor: _S) -> _S:
    """Return the sensor without what decides none of its rays: name, model, pair, groups, and whether it is on."""
    none = {"name": "", "model": None, "enabled": True, "mirror_of": None, "fails_with": None}
    return sensor.model_copy(update=none)


class MeshPlacement(Frozen):
    """How a mesh file is placed in the vehicle frame: scaled about its origin, rotated, then moved (metres)."""

    scale: Annotated[float, Field(allow_inf_nan=False, ge=1e-6, le=1e6)] = 1.0
    rpy_deg: Angles3 = (0.0, 0.0, 0.0)
    offset: Position = (0.0, 0.0, 0.0)


class Vehicle(Frozen):
    """The ego car's body in metres; `body` is a parametric body or the path of a mesh file.

    `mesh` places the mesh of a file; a parametric body does not use it.
    """

    body: Name = "sedan"
    length: VehicleLength = 4.6
    width: VehicleLength = 1.9
    height: VehicleLength = 1.45
    rear_axle_x: Metres = -1.35
    mesh: MeshPlacement = MeshPlacement()

    @property
    def has_mesh_file(self) -> bool:
        """Whether `body` is the path of a mesh file."""
        return self.body not in PARAMETRIC_BODIES


def mirror_problem(sensors: Iterable[tuple[str, str, str | None]]) -> tuple[int, str] | None:
    """Return index and problem of the first sensor (name, kind, mirror_of) with a wrong `mirror_of`, None if all fit.

    A pair is two sensors of one kind; one of them names the other, and neither belongs to another pair.
    """
    listed = list(sensors)
    kinds = {name: kind for name, kind, _ in listed}
    taken = {name for name, _, other in listed if other is not None}
    for index, (name, kind, other) in enumerate(listed):
        if other is None:
            continue
        reason = ""
        if other not in kinds or other == name:
            reason = "accepted is the name of another sensor"
        elif kinds[other] != kind:
            reason = f"that is a {kinds[other]}, accepted is a {kind}"
        elif other in taken:
            reason = "that sensor belongs to another mirror pair"
        if reason:
            return index, f"mirror_of: found '{other}'; {reason}"
        taken.add(other)
    return None


class Rig(Frozen):
    """A named set of sensors on a vehicle; immutable, every edit gives a new rig.

    `self_occlusion`: the car's own body stops rays where the rig is scored; the paper's rigs let them through.
    No sensor is to be mounted on the car's skin within the spots of `keep_out`; no score depends on them.
    """

    OTHER_SPELLINGS: ClassVar = ("body",)
    """Keys that are read besides the fields: `body: ignored|blocks` is another spelling of `self_occlusion`."""

    riglens: Literal[1] = 1
    name: Name = "untitled"
    self_occlusion: bool = True
    vehicle: Vehicle = Vehicle()
    keep_out: Annotated[tuple[Spot, ...], Field(max_length=MAX_SPOTS)] = ()
    sensors: Annotated[
        tuple[Annotated[Sensor, Field(discriminator="kind")], ...], Field(max_length=MAX_SENSORS)
    ] = ()

    @model_validator(mode="before")
    @classmethod
    def _body_is_self_occlusion(cls, fields: object) -> object:
        if not isinstance(fields, dict) or "body" not in fields:
            return fields
        body = fields["body"]
        if body not in ("ignored", "blocks"):
            raise ValueError(f"body must be ignored or blocks (got {body!r:.40})")
        if "self_occlusion" in fields:
            raise ValueError("body says the same as self_occlusion: give only one of the two")
        others = {key: value for key, value in fields.items() if key != "body"}
        return others | {"self_occlusion": body == "blocks"}

    @model_validator(mode="after")
    def _names_unique(self) -> Self:
        seen: set[str] = set()
        for sensor in self.sensors:
            if sensor.name in seen:
                raise ValueError(f"sensor name '{sensor.name}' is used twice; names must be unique")
            seen.add(sensor.name)
        return self

    @model_validator(mode="after")
    def _mirrors_pair_up(self) -> Self:
        problem = mirror_problem((s.name, s.kind, s.mirror_of) for s in self.sensors)
        if problem is not None:
            raise ValueError(f"sensors[{problem[0]}].{problem[1]}")
        return self

    @property
    def body(self) -> Literal["ignored", "blocks"]:
        """What the car's own body does to rays where the rig is scored."""
        return "blocks" if self.self_occlusion else "ignored"

    def sensor(self, name: str) -> Sensor:
        """Return the sensor of that name; raise KeyError when there is none."""
        for sensor in self.sensors:
            if sensor.name == name:
                return sensor
        raise KeyError(name)

    def with_sensor(self, name: str, sensor: Sensor) -> Rig:
        """Return the rig with the sensor called `name` replaced by another, without validation."""
        sensors = tuple(sensor if old.name == name else old for old in self.sensors)
        return self.model_copy(update={"sensors": sensors})

    def cameras(self) -> tuple[Camera, ...]:
        """Return the enabled cameras, in order."""
        return tuple(s for s in self.sensors if isinstance(s, Camera) and s.enabled)

    def lidars(self) -> tuple[Lidar, ...]:
        """Return the enabled LiDARs, in order."""
        return tuple(s for s in self.sensors if isinstance(s, Lidar) and s.enabled)
