"""Frozen, validated description of a rig: vehicle and sensors, as in the rig YAML version 1."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Literal, Self, TypeVar

from pydantic import Field, PlainValidator, PrivateAttr, SerializeAsAny, model_validator

from riglens.core.plain import Frozen
from riglens.core.rig.body_mesh import METRES, BodyMesh, MeshPlacement
from riglens.core.sensors.base import Length, Metres, Name, Positive, Sensor, rays_of
from riglens.core.sensors.camera import Camera
from riglens.core.sensors.lens import BrownConrady, KannalaBrandt
from riglens.core.sensors.lidar import Lidar, LinearAngles
from riglens.core.sensors.registry import validated_sensor

__all__ = [
    "FORMAT_VERSION",
    "MAX_SENSORS",
    "MAX_SPOTS",
    "PARAMETRIC_BODIES",
    "BrownConrady",
    "Camera",
    "KannalaBrandt",
    "Length",
    "Lidar",
    "LinearAngles",
    "MeshPlacement",
    "Positive",
    "Rig",
    "Sensor",
    "Spot",
    "Vehicle",
    "mirror_problem",
    "rays_of",
]  # fmt: skip

FORMAT_VERSION = 1
PARAMETRIC_BODIES = ("sedan", "suv", "van", "truck")
MAX_SENSORS = 255
MAX_SPOTS = 1000
"""Of the keep-out zones of a rig."""
VehicleLength = Annotated[float, Field(allow_inf_nan=False, ge=0.1, le=100.0)]
SpotRadius = Annotated[float, Field(allow_inf_nan=False, ge=0.005, le=2.0)]
Spot = tuple[Metres, Metres, Metres, SpotRadius]
"""A ball around a place on the car's skin: x, y, z and radius in metres."""
S = TypeVar("S", bound=Sensor)
AnySensor = Annotated[SerializeAsAny[Sensor], PlainValidator(validated_sensor)]


class Vehicle(Frozen):
    """The ego car's body in metres; `body` is a parametric body or the path of a mesh file.

    `mesh` places the mesh of a file; a parametric body does not use it. The mesh itself is carried along once it has
    been read: a vehicle equals only one that has the same, and `replace` gives one without it.
    """

    body: Name = "sedan"
    length: Annotated[VehicleLength, Field(description="Bumper to bumper.", json_schema_extra=METRES)] = 4.6
    width: Annotated[VehicleLength, Field(description="Without mirrors.", json_schema_extra=METRES)] = 1.9
    height: Annotated[VehicleLength, Field(description="Ground to roof.", json_schema_extra=METRES)] = 1.45
    rear_axle_x: Annotated[
        Metres,
        Field(description="From the centre of the body; negative is behind it.", json_schema_extra=METRES),
    ] = -1.35
    mesh: MeshPlacement = MeshPlacement()
    _body_mesh: BodyMesh | None = PrivateAttr(default=None)

    @property
    def has_mesh_file(self) -> bool:
        """Return whether `body` is the path of a mesh file."""
        return self.body not in PARAMETRIC_BODIES

    @property
    def body_mesh(self) -> BodyMesh | None:
        """The mesh of the file; None for a parametric body, and until the file has been read."""
        return self._body_mesh

    @property
    def lacks_mesh(self) -> bool:
        """Return whether the body is a mesh file that has not been read."""
        return self.has_mesh_file and self._body_mesh is None

    def with_body_mesh(self, mesh: BodyMesh | None) -> Self:
        """Return the same vehicle with the mesh of its file, or without it."""
        found = self.model_copy()
        found._body_mesh = mesh
        return found


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
            reason = "must be the name of another sensor"
        elif kinds[other] != kind:
            reason = f"must be a {kind}, not a {kinds[other]}"
        elif other in taken:
            reason = "must not belong to another mirror pair"
        if reason:
            return index, f"mirror_of: {reason} (got '{other}')"
        taken.add(other)
    return None


class Rig(Frozen):
    """A named set of sensors on a vehicle; immutable, every edit gives a new rig.

    `self_occlusion`: the car's own body stops rays where the rig is scored; the paper's rigs let them through.
    `housings`: whether the housings of its sensors stop the rays of the others wherever the car's body does.
    No sensor is to be mounted on the car's skin within the spots of `keep_out`; no score depends on them.
    """

    riglens: Literal[1] = 1
    name: Name = "untitled"
    self_occlusion: bool = True
    housings: Annotated[
        Literal["ignored", "blocks"],
        Field(description="Whether housings stop the rays of other sensors, wherever the car's body does."),
    ] = "ignored"
    vehicle: Vehicle = Vehicle()
    keep_out: Annotated[tuple[Spot, ...], Field(max_length=MAX_SPOTS)] = ()
    sensors: Annotated[tuple[AnySensor, ...], Field(max_length=MAX_SENSORS)] = ()

    @model_validator(mode="before")
    @classmethod
    def _body_is_self_occlusion(cls, fields: object) -> object:
        if not isinstance(fields, dict) or "body" not in fields:
            return fields
        body = fields["body"]
        if body not in ("ignored", "blocks"):
            raise ValueError(f"body must be ignored or blocks (got {body!r:.40})")
        if "self_occlusion" in fields:
            raise ValueError("body means the same as self_occlusion: specify only one of them")
        others = {key: value for key, value in fields.items() if key != "body"}
        return others | {"self_occlusion": body == "blocks"}

    @model_validator(mode="after")
    def _names_unique(self) -> Self:
        seen: set[str] = set()
        for index, sensor in enumerate(self.sensors):
            if sensor.name in seen:
                raise ValueError(f"sensors[{index}].name '{sensor.name}' is used twice; names must be unique")
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
        """Return the effect of the car's own body on rays where the rig is scored."""
        return "blocks" if self.self_occlusion else "ignored"

    @property
    def obstacles(self) -> tuple[Sensor, ...]:
        """Return the sensors whose housings stop the rays of others, enabled or not: all or none."""
        return self.sensors if self.housings == "blocks" else ()

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

    def with_body_mesh(self, mesh: BodyMesh | None) -> Self:
        """Return the rig on the same car with the mesh of its body's file, or without it."""
        return self.model_copy(update={"vehicle": self.vehicle.with_body_mesh(mesh)})

    def enabled_of(self, model: type[S]) -> tuple[S, ...]:
        """Return the enabled sensors of a class, in order."""
        return tuple(s for s in self.sensors if isinstance(s, model) and s.enabled)

    def enabled_cameras(self) -> tuple[Camera, ...]:
        """Return the enabled cameras, in order."""
        return self.enabled_of(Camera)

    def enabled_lidars(self) -> tuple[Lidar, ...]:
        """Return the enabled LiDARs, in order."""
        return self.enabled_of(Lidar)

    def with_lidars_alone(self) -> Self:
        """Return the rig with its enabled LiDARs and no other sensor."""
        return self.only(self.enabled_lidars())

    def only(self, sensors: Iterable[Sensor]) -> Self:
        """Return the rig with these sensors alone; where housings block, those of the others stay on the car,
        disabled."""
        kept = tuple(sensors)
        if self.obstacles:
            names = {sensor.name for sensor in kept}
            gone = (sensor for sensor in self.obstacles if sensor.name not in names)
            kept += tuple(sensor.model_copy(update={"enabled": False}) for sensor in gone)
        return self.model_copy(update={"sensors": kept})
