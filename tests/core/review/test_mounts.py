"""Mounts: distances that a pencil gives, zones of the built-in bodies, one line per violation."""

import gc
import weakref

import numpy as np
import pytest
from pydantic import ValidationError

from riglens.core.blind.outline import Outline
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.review import mounts as mounts_module
from riglens.core.review.mounts import (
    OWN_ZONE,
    SIDES,
    USUAL_KEEP_OUT,
    Box,
    Footing,
    KeepOut,
    MountLimits,
    Overhang,
    is_in_zone,
    is_kept_out,
    mounts_of,
    violations,
)
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Camera, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.file import dumps, loads, rig_sha256
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.solid import Solid, solid_of
from riglens.core.vehicle.standing import MountStatus, status_of
from tests.core.review.scenes import BOX, camera, dense_lidar

SEDAN = Vehicle()


def on_material(material: str) -> tuple[float, float, float]:
    """A place just outside of the middle of the largest triangle of a material."""
    surface = dict(body_parts(SEDAN))[material]
    corners = surface.points[surface.triangles].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1)
    bare = (material != "glass") | (
        corners[:, :, 2].mean(axis=1) > 1.15
    )  # below, the body stands before the glass
    largest = int(np.argmax(size * bare))
    middle, out = corners[largest].mean(axis=0), normal[largest] / size[largest]
    out *= np.sign(out @ (middle - [0.0, 0.0, 0.7]))
    x, y, z = (middle + 0.003 * out).tolist()
    return x, y, z


def test_distances_over_a_box_are_those_of_a_pencil() -> None:
    roof = dense_lidar(1.8)
    side = camera((0.0, 1.3, 1.0), 90.0)
    rig = Rig(vehicle=BOX, sensors=(roof, side, camera((9.0, 0.0, 1.0), 5.0).replace(enabled=False)))
    top, left = mounts_of(rig)
    assert (top.height_m, top.status.gap_m) == pytest.approx((1.8, 0.3))
    assert left.status.gap_m == pytest.approx(0.3) and left.neighbour == roof.name
    assert left.neighbour_m == pytest.approx(np.hypot(1.3, 0.8))
    half = 0.05 / np.sqrt(3.0)
    assert left.beyond_m["left"] == pytest.approx(0.3 + half) and left.beyond_m["top"] == pytest.approx(
        half - 0.5
    )
    assert tuple(left.beyond_m) == SIDES and left.materials == frozenset()
    alone = mounts_of(Rig(vehicle=BOX, sensors=(roof,)))[0]
    assert alone.neighbour is None and alone.neighbour_m == np.inf


def test_a_housing_sticks_out_as_its_own_size_turned_says() -> None:
    lying = sensor_from_model("velodyne-vlp-16", "v", Pose((-2.3, -1.2, 0.9), (0.0, 90.0, 0.0)))
    (mount,) = mounts_of(Rig(vehicle=BOX, sensors=(lying,)))
    across, along = 0.1032 / 2, 0.0717 / 2
    out = (-4.3 + along, 0.3 + along, -2.2 + across, 0.2 + across, 0.9 + across - 1.5)
    assert [mount.beyond_m[side] for side in SIDES] == pytest.approx(out)


def test_a_car_measures_what_sticks_out_on_both_of_its_sides() -> None:
    half = 0.05 / np.sqrt(3.0)
    around = [(2.1, 0.0, 1.0), (-2.2, 0.0, 1.0), (0.0, 1.3, 1.0), (0.0, -1.4, 1.0)]
    rig = Rig(vehicle=BOX, sensors=tuple(camera(place, 90.0 * i) for i, place in enumerate(around)))
    limits = MountLimits(length_m=4.0, width_m=2.0, total_height_m=1.5, spacing_m=1.2, keep_out=())
    assert [violation.text for violation in violations(rig, limits)] == [
        f"length with sensors must be at most 4 m (is {4.3 + 2 * half:.3f} m)",
        f"width with sensors must be at most 2 m (is {2.7 + 2 * half:.3f} m)",
    ]


def test_every_limit_that_is_broken_gives_one_line_that_says_by_how_much() -> None:
    rig = Rig(vehicle=BOX, sensors=(dense_lidar(1.8), camera((0.0, 1.3, 1.0), 90.0), camera((0.0, 0.0, 0.7))))
    limits = MountLimits(
        height_m=(0.8, 1.5),
        gap_m=0.2,
        spacing_m=1.2,
        beyond_m=Overhang(left=0.1, front=0.0),
        width_m=2.1,
        length_m=4.0,
        total_height_m=1.6,
    )
    lines = [(v.sensor, v.text) for v in violations(rig, limits)]
    texts = [text for _, text in lines]
    assert ("lidar 0", "height over the ground must be 0.8 to 1.5 m (is 1.800 m)") in lines
    assert ("lidar 0", "height over the skin must be at most 0.2 m (is 0.300 m)") in lines
    assert ("camera 90", "overhang (left) must be at most 0.1 m (is 0.329 m)") in lines
    assert (
        any(name == "camera 0" and text.endswith("m inside the body") for name, text in lines)
        and (
            "camera 0",
            "height over the ground must be 0.8 to 1.5 m (is 0.700 m)",
        )
        in lines
    )
    assert any("from camera 0 must be at least 1.2 m" in text for text in texts)
    assert [text for name, text in lines if name == "car"] == [
        "width with sensors must be at most 2.1 m (is 2.329 m)",
        "height with sensors must be at most 1.6 m (is 1.861 m)",
    ]
    assert violations(rig, MountLimits(keep_out=())) == violations(rig, MountLimits())


@pytest.mark.parametrize(
    ("material", "zone"),
    [("glass", "glass"), ("lamp", "head lamp"), ("tail", "tail lamp"), ("plate", "number plate")],
)
def test_a_sensor_on_glass_lamps_and_plates_stands_where_nothing_may(material: str, zone: str) -> None:
    rig = Rig(vehicle=SEDAN, sensors=(camera(on_material(material)),))
    (mount,) = mounts_of(rig)
    assert material in mount.materials and zone in mount.zones
    assert any(zone in v.text for v in violations(rig, MountLimits()))
    assert mounts_of(rig, keep_out=())[0].zones == ()


def test_a_door_is_kept_clear_and_a_roof_is_not() -> None:
    def at(x: float, y: float, z: float) -> Camera:
        return camera((x, y, z))

    door = mounts_of(Rig(vehicle=SEDAN, sensors=(at(0.1, 0.96, 0.6),)))[0]
    mirrored = mounts_of(Rig(vehicle=SEDAN, sensors=(at(0.1, -0.96, 0.6),)))[0]
    assert "door" in door.zones and door.zones == mirrored.zones
    roof = mounts_of(Rig(vehicle=SEDAN, sensors=(at(-0.3, 0.0, 1.46),)))[0]
    assert roof.zones == () and roof.materials <= {"paint", "panel"}
    own = KeepOut(name="hood", boxes=(Box(x=(0.75, 1.0)),))
    assert mounts_of(Rig(vehicle=SEDAN, sensors=(at(1.9, 0.0, 0.95),)), keep_out=(own,))[0].zones == ("hood",)
    top = KeepOut(name="top", boxes=(Box(z=(0.98, 1.02)),))  # 1.42 to 1.48 m
    zones = [
        mounts_of(Rig(vehicle=SEDAN, sensors=(at(-0.3, 0.0, z),)), keep_out=(top,))[0].zones
        for z in (1.46, 1.0)
    ]
    assert zones == [("top",), ()]
    with pytest.raises(ValueError, match="one of paint"):
        KeepOut(name="a", material="wood")
    with pytest.raises(ValueError, match="specify part, material or boxes"):
        KeepOut(name="a")
    assert {zone.name for zone in USUAL_KEEP_OUT} >= {
        "glass",
        "door",
        "head lamp",
        "tail lamp",
        "number plate",
    }


def test_the_edge_of_a_zone_belongs_to_it() -> None:
    rig, outline = Rig(vehicle=SEDAN), Outline.of(SEDAN)
    zone = KeepOut(name="rear half", boxes=(Box(x=(0.0, 0.5)),))
    middle_m = (outline.front_m + outline.rear_m) / 2
    places = (outline.rear_m, middle_m, outline.rear_m - 1e-9, middle_m + 1e-9)
    nothing = frozenset[str]()
    stands = [Footing((x, 0.0, 1.0), nothing, nothing, nothing) for x in places]
    assert [is_in_zone(zone, footing, rig, outline) for footing in stands] == [
        True, True, False, False,
    ]  # fmt: skip
    painted = rig.replace(keep_out=((0.0, 0.0, 1.0, 0.5),))
    assert [is_kept_out(painted, (x, 0.0, 1.0)) for x in (0.5, 0.5 + 1e-9)] == [True, False]


def test_what_is_painted_keeps_out_by_the_place_on_the_skin_and_costs_no_hash_where_nothing_is() -> None:
    """A sensor 5 cm over the roof stands on the point of the skin below it, within the spot or beyond its edge."""
    x, y, z = on_material("paint")
    spot = (x, y, z, 0.1)
    for off_m, painted in ((0.0, True), (0.094, True), (0.106, False)):
        rig = Rig(sensors=(camera(position=(x, y, z)),), vehicle=SEDAN, keep_out=((x, y + off_m, z, 0.1),))
        (mount,) = mounts_of(rig, keep_out=())
        assert mount.zones == (OWN_ZONE,) * painted
    rig = Rig(sensors=(camera(position=(x, y, z)),), vehicle=SEDAN, keep_out=(spot,))
    found = [one.text for one in violations(rig, MountLimits(keep_out=()))]
    assert "is in the keep-out zone of the rig" in found
    assert loads(dumps(rig)).rig == rig and f"keep_out: [[{x!r}, {y!r}, {z!r}, 0.1]]" in dumps(rig)
    bare = rig.replace(keep_out=())
    assert "keep_out" not in dumps(bare) and rig_sha256(bare) != rig_sha256(rig)
    text = "# ours\nriglens: 1\nname: a   # a name\nsensors: []\n"
    file = loads(text).updated(Rig(name="a", keep_out=(spot,)))
    assert file.text.startswith("# ours\nriglens: 1\nname: a   # a name\nkeep_out: [[")
    assert "keep_out: []" in file.updated(Rig(name="a")).text


@pytest.mark.parametrize("wrong", ["3", "[[1, 2, 3]]", "[[1, 2, 3, 9]]", "[[1, 2, .nan, 0.1]]", "[a]"])
def test_spots_that_are_none_are_refused_by_name(wrong: str) -> None:
    with pytest.raises(InputError, match=r"rig.yaml:2: keep_out.* (must|is missing)"):
        loads(f"riglens: 1\nkeep_out: {wrong}\nsensors: []\n")


def test_what_stood_before_is_not_looked_for_again_and_says_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """One of two sensors moves, is switched off, and the car grows: the lines are those of a check from scratch."""
    roof, nose = camera(position=(0.0, 0.0, 1.6)), camera(position=(2.3, 0.0, 0.6), yaw_deg=1.0)
    rig = Rig(sensors=(roof, nose), vehicle=SEDAN)
    moved = rig.with_sensor(nose.name, nose.replace(position=(2.4, 0.0, 0.6)))
    longer = moved.replace(vehicle=SEDAN.replace(length=5.0))
    off = longer.with_sensor(roof.name, roof.replace(enabled=False))
    looked: list[tuple[float, float, float]] = []

    def counted(sensor: Sensor, solid: Solid) -> MountStatus:
        looked.append(sensor.position)
        return status_of(sensor, solid)

    wanted = [violations(one, MountLimits(gap_m=0.05)) for one in (rig, moved, longer, off)]
    monkeypatch.setattr(mounts_module, "status_of", counted)
    mounts_module._footings.cache_clear()
    counts = []
    for one, lines in zip((rig, moved, longer, off), wanted, strict=True):
        assert violations(one, MountLimits(gap_m=0.05)) == lines
        counts.append(len(looked))
    assert counts == [2, 3, 5, 5]


def test_cars_of_before_are_not_held() -> None:
    """But for the last three: of a car that is edited, the one that the view still shows, and the saved one."""
    cars = []
    for length_m in (4.1, 4.2, 4.3, 4.4, 4.5):
        vehicle = SEDAN.replace(length=length_m)
        cars.append(weakref.ref(solid_of(vehicle)))
        violations(Rig(sensors=(camera(position=(0.0, 0.0, 1.6)),), vehicle=vehicle), MountLimits())
    gc.collect()
    assert sum(car() is not None for car in cars) <= 3


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Box(z=(1.0, 0.4)), "from <= to"),
        (lambda: Box(x=(0.9, 0.1)), "from <= to"),
        (lambda: MountLimits(gap_m=-0.1), "gap_m"),
        (lambda: MountLimits(spacing_m=-0.1), "spacing_m"),
        (lambda: MountLimits(width_m=-2.0), "width_m"),
        (lambda: MountLimits(height_m=(2.0, 0.3)), "lowest <= highest"),
    ],
)
def test_limits_that_nothing_or_everything_meets_are_refused(make, said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        make()
