"""Parts of a car by name, and those that a housing covers."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.geometry import Pose
from riglens.core.optimise.additions import Additions
from riglens.core.optimise.candidates import choices_of
from riglens.core.review.mounts import MountLimits, mounts_of, violations
from riglens.core.rig.library import default_library
from riglens.core.rig.model import PARAMETRIC_BODIES, Rig, Vehicle
from riglens.core.vehicle.mesh_file import read_mesh
from riglens.core.vehicle.parts import PARTS, overlaps, part_called
from riglens.core.vehicle.profile import reference_vehicle
from riglens.core.vehicle.solid import solid_of
from riglens.core.vehicle.standing import skin_of


def meets_box(half: np.ndarray, triangle: np.ndarray) -> bool:
    """Cut a triangle at the six planes of a box: is anything left?"""
    left = list(triangle)
    for axis, side in itertools.product(range(3), (-1.0, 1.0)):
        depths = [float(half[axis] - side * corner[axis]) for corner in left]
        edges, left = zip(left, left[1:] + left[:1], depths, depths[1:] + depths[:1], strict=True), []
        for start, end, here, there in edges:
            left += [start] if here >= 0.0 else []
            left += [start + here / (here - there) * (end - start)] if here * there < 0.0 else []
    return bool(left)


@given(seed=st.integers(0, 10**6))
def test_a_box_meets_the_triangles_of_which_a_part_is_in_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    half = rng.uniform(0.2, 1.0, 3)
    triangle = rng.uniform(-1.8, 1.8, (3, 3)) * rng.choice([1.0, 0.3])
    triangle += rng.uniform(-1.0, 1.0, 3)
    met = meets_box(half, triangle)
    if met == meets_box(half + 1e-6, triangle):  # else it is too near to call
        assert overlaps(half, triangle[None])[0] == met


@pytest.mark.parametrize("body", PARAMETRIC_BODIES)
def test_every_body_names_its_parts_on_both_sides(body: str) -> None:
    car = Vehicle(body=body, length=5.1, width=2.0, height=2.0)
    solid = solid_of(car)
    middles = solid.triangles_m.mean(axis=1)
    for number, name in enumerate(PARTS):
        left, right = (int((solid.parts[side * middles[:, 1] > 0.0] == number).sum()) for side in (1.0, -1.0))
        assert left > 10 and 0.8 < left / right < 1.25, name


def sensor_at(car: Vehicle, x: float, y: float, z: float, model: str = "nuscenes-front") -> Rig:
    """A car with a sensor at the place on its skin that is nearest to a place, by shares of its sizes."""
    place = skin_of(solid_of(car)).nearest(np.array([x * car.length, y * car.width / 2.0, z * car.height]))
    return Rig(vehicle=car, sensors=(default_library().entry(model).sensor("one", Pose(place)),))


@pytest.mark.parametrize(
    ("body", "place", "zone"),
    [
        ("sedan", (-0.067, 0.80, 0.80), "door"),  # between its windows: above 0.62 of the height
        ("suv", (-0.074, 0.82, 0.80), "door"),
        ("van", (0.0, 1.0, 0.87), "door"),
        ("truck", (0.42, 1.0, 0.30), "door"),
        ("sedan", (0.35, 0.0, 0.65), "lid"),
        ("sedan", (-0.46, 0.0, 0.75), "lid"),
        ("suv", (-0.49, 0.5, 0.5), "lid"),
        ("van", (-0.5, 0.4, 0.5), "lid"),
        ("truck", (-0.5, 0.3, 0.6), "lid"),
        ("truck", (0.5, 0.0, 0.35), "lid"),
        ("sedan", (0.152, 1.1, 0.665), "door mirror"),
        ("sedan", (-0.2935, 1.0, 0.52), "wheel arch"),
        ("suv", (0.298, 1.0, 0.49), "wheel arch"),
    ],
)
def test_a_part_of_the_body_is_where_it_is_seen(body: str, place: tuple[float, ...], zone: str) -> None:
    car = reference_vehicle(body)
    for side in (1.0, -1.0):
        (mount,) = mounts_of(sensor_at(car, place[0], side * place[1], place[2], "generic-corner-radar"))
        assert zone in mount.zones


@pytest.mark.parametrize(
    ("body", "place"),
    [
        ("sedan", (-0.1, 0.0, 1.0)), ("suv", (-0.1, 0.0, 1.0)), ("van", (-0.1, 0.0, 1.0)), ("truck", (-0.1, 0.0, 1.0)),
        ("sedan", (0.45, 1.0, 0.30)), ("suv", (-0.48, 1.0, 0.4)), ("truck", (-0.2, 1.0, 0.7)),
    ],
)  # fmt: skip
def test_roofs_bumpers_and_side_panels_are_free(body: str, place: tuple[float, ...]) -> None:
    (mount,) = mounts_of(sensor_at(reference_vehicle(body), *place))
    assert mount.zones == ()


def test_a_housing_counts_where_its_middle_is_beside_a_part() -> None:
    """A camera over the line between fender and door: of a small housing only the middle counts."""
    car = reference_vehicle("sedan")
    skin = skin_of(solid_of(car))
    x, y, z = skin.nearest(np.array([0.90, 1.0, 0.60])).tolist()
    wide = default_library().entry("hesai-ot128").sensor("wide", Pose((x, y, z)))
    small = default_library().entry("generic-ultrasonic").sensor("small", Pose((x + 0.06, y, z)))
    wide_mount, small_mount = mounts_of(Rig(vehicle=car, sensors=(wide, small)))
    assert {"shut line", "door"} <= set(wide_mount.zones) and small_mount.zones == ()
    assert wide_mount.materials == {"paint"}, "by its middle alone it would be free"


@pytest.mark.parametrize("body", PARAMETRIC_BODIES)
def test_no_proposed_mount_covers_a_part_that_is_kept_out(body: str) -> None:
    rules = MountLimits(height_m=(0.3, 100.0), spacing_m=0.25)
    models = ("nuscenes-front", "generic-ultrasonic", "velodyne-vlp-16")
    car = Vehicle(body=body, length=4.9, width=2.0, height=1.9)
    found = choices_of(
        Rig(vehicle=car), Additions(models, rules=rules, spots_m=0.6, tilts_deg=(0.0,))
    ).candidates
    assert found
    for one in found[::5]:
        assert violations(Rig(vehicle=car, sensors=one.sensors), MountLimits()) == ()


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("Door_FL", "door"), ("front door glass", "glass"), ("Windscreen", "glass"), ("taillight.L", "tail lamp"),
        ("Headlights", "head lamp"), ("light_blue", "body"), ("wing mirror", "door mirror"), ("TRIM", "body"),
        ("solid", "body"), ("Bonnet", "lid"), ("license_plate", "number plate"), ("skid plate", "body"),
        ("wheel_arch", "wheel arch"), ("tyres", "wheel"), ("paint", "body"),
    ],
)  # fmt: skip
def test_meshes_and_materials_name_parts_by_usual_words(name: str, part: str) -> None:
    assert PARTS[part_called(name)] == part


OBJ = """mtllib car.mtl
v -2 -1 0
v 2 -1 0
v 2 1 0
v -2 1 0
v -2 -1 1.5
v 2 -1 1.5
v 2 1 1.5
v -2 1 1.5
usemtl paint
f 5 6 7 8
f 1 4 3 2
f 1 5 8 4
f 2 3 7 6
usemtl Door_left
f 4 8 7 3
usemtl Door_right
f 1 2 6 5
"""
MTL = "newmtl paint\nKd 1 0 0\nnewmtl Door_left\nKd 1 0 0\nnewmtl Door_right\nKd 1 0 0\n"


def test_materials_of_a_mesh_file_keep_sensors_out(tmp_path: Path) -> None:
    (tmp_path / "car.mtl").write_text(MTL, encoding="utf-8")
    (tmp_path / "car.obj").write_text(OBJ, encoding="utf-8")
    car = Vehicle(body="car.obj", length=4.0, width=2.0, height=1.5)
    car = car.with_body_mesh(read_mesh(tmp_path / "car.obj"))
    camera = default_library().entry("nuscenes-front")
    sensors = [
        camera.sensor(name, Pose(place))
        for name, place in (
            ("side", (1.5, 1.0, 0.7)),
            ("roof", (0.0, 0.0, 1.5)),
            ("corner", (1.5, 0.93, 1.5)),
        )
    ]
    side, roof, corner = mounts_of(Rig(vehicle=car, sensors=tuple(sensors)))
    assert (side.zones, roof.zones, corner.zones) == (("door",), (), ())
    wide = default_library().entry("hesai-ot128").sensor("corner", Pose((1.5, 0.93, 1.5)))
    assert mounts_of(Rig(vehicle=car, sensors=(wide,)))[0].zones == ("door",)
    plain = car.with_body_mesh(read_mesh_without_names(tmp_path))
    assert not solid_of(plain).names_parts and solid_of(plain).fingerprint == solid_of(car).fingerprint


def read_mesh_without_names(folder: Path) -> object:
    """The same mesh, whose materials say nothing."""
    (folder / "car.mtl").write_text(MTL.replace("Door", "Part"), encoding="utf-8")
    (folder / "plain.obj").write_text(OBJ.replace("Door", "Part"), encoding="utf-8")
    return read_mesh(folder / "plain.obj")
