"""Housings of sensors as obstacles of the others' rays, against every ray on every triangle and boxes by hand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.history import History
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Camera, KannalaBrandt, Lidar, LinearAngles, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.file import dumps, loads, rig_sha256
from riglens.core.sensing.body_ends import (
    barrier_of,
    barrier_of_some,
    housing_radius_m,
    known_obstacle,
    listed_ends,
    obstacle_of,
)
from riglens.core.sensing.kept import RAYS
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.housings import car_of, half_size_m
from riglens.core.vehicle.solid import solid_of
from tests.core.builders import field_of, grid_of, random_sensor, unpack
from tests.core.oracle import exact_mask, grid_rays
from tests.core.vehicle.solids import body_ends, brute_force

BLOCKS = MetricSettings(body="blocks")
GRID = grid_of(24, 20, 12, 0.5)
FAR_CAR = Vehicle(length=0.1, width=0.1, height=0.1)
"""So small that it hides little: the housings decide."""
MODELS = tuple(
    entry.name for entry in default_library().entries() if entry.body_m is not None and entry.kind == "lidar"
)
Doubles = NDArray[np.float64]


def housed(*sensors: Sensor, **fields: object) -> Rig:
    return Rig(housings="blocks", vehicle=FAR_CAR, sensors=sensors).replace(**fields)


def crowd(seed: int, count: int = 4, rays: int = 12) -> Rig:
    """Sensors of all kinds of rays so near to each other that their housings matter."""
    rng = np.random.default_rng(seed)
    sensors = []
    for number in range(count):
        one = random_sensor(GRID, rng, rays)
        place = tuple(map(float, rng.uniform([-0.6, -0.6, 1.5], [0.6, 0.6, 2.2])))
        model = None if rng.random() < 0.3 else str(rng.choice(MODELS))
        sensors.append(one.model_copy(update={"name": f"s{number}", "position": place, "model": model}))
    return housed(*sensors)


def triangles_without(rig: Rig, name: str) -> Doubles:
    """Triangles of the body and of all housings but one, whether or not they lie in anybody's view."""
    car = car_of(rig)
    own = next(number for number, one in enumerate(car.housings) if one.name == name)
    return car.triangles_m[car.owners != own]


def test_rays_end_at_the_first_of_the_body_and_the_other_housings() -> None:
    met = 0
    crowds = [crowd(seed, 8, 24) for seed in range(5)]
    for rig, sensor in [(one, sensor) for one in crowds for sensor in one.sensors]:
        rays = sensor_rays(sensor)
        corners = triangles_without(rig, sensor.name)
        ends, _ = brute_force(np.array(sensor.position), rays.directions, corners, housing_radius_m(sensor))
        found = body_ends(sensor, car_of(rig))
        np.testing.assert_array_equal(np.isfinite(found), np.isfinite(ends))
        np.testing.assert_allclose(found, ends, rtol=1e-12)
        met += int(np.isfinite(ends).sum() - np.isfinite(body_ends(sensor, solid_of(rig.vehicle))).sum())
    assert met > 10


@pytest.mark.parametrize("seed", range(4))
def test_the_voxels_seen_are_those_of_rays_cut_off_at_housings(seed: int) -> None:
    rig, field = crowd(seed, 3), field_of(GRID)
    cover = np.zeros(GRID.shape, np.bool_)
    for sensor in rig.sensors:
        rays = grid_rays(GRID, sensor)
        ends, _ = brute_force(
            np.array(sensor.position), np.array([ray.d for ray in rays]),
            triangles_without(rig, sensor.name), housing_radius_m(sensor),
        )  # fmt: skip
        for ray, end in zip(rays, ends, strict=True):
            far = min(ray.far, float(end) / GRID.voxel_m)
            if far > ray.near:
                cover |= exact_mask(GRID.shape, replace(ray, far=far))
    seen = Engine(field).evaluate(rig, BLOCKS).seen_by_any()
    np.testing.assert_array_equal(unpack(GRID, seen), cover)


def spinner(name: str, x: float, model: str | None = None) -> Lidar:
    return Lidar(
        name=name, position=(x, 0.0, 2.0), model=model,
        elevations_deg=LinearAngles(from_=-20.0, to=20.0, count=41),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=720),
    )  # fmt: skip


def test_a_lidar_behind_another_loses_exactly_the_rays_through_its_housing() -> None:
    behind, ahead = spinner("behind", -0.4), spinner("ahead", 0.0)  # of no model: a cube
    half = half_size_m(ahead)
    directions = sensor_rays(behind).directions
    with np.errstate(divide="ignore"):
        first, second = ((np.array([0.4, 0.0, 0.0]) + side * half) / directions for side in (-1.0, 1.0))
    enter, leave = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
    through = (enter <= leave) & (enter > 0.0)
    assert 0 < through.sum() < len(through)
    rig = housed(behind, ahead)
    np.testing.assert_array_equal(np.isfinite(body_ends(behind, car_of(rig))), through)
    without = body_ends(behind, car_of(rig.replace(housings="ignored")))
    assert not np.isfinite(without).any()
    alone = rig.only([behind])  # the other one would see what it hides
    seen = Engine(field_of(GRID)).evaluate(alone, BLOCKS).seen["lidar"]
    free = Engine(field_of(GRID)).evaluate(alone.replace(housings="ignored"), BLOCKS).seen["lidar"]
    assert np.array_equal(seen & free, seen)
    assert not np.array_equal(seen, free)


def test_a_round_housing_hides_the_angle_of_its_diameter() -> None:
    behind, ahead = spinner("behind", -1.0), spinner("ahead", 0.0, "velodyne-vlp-16")
    directions = sensor_rays(behind).directions
    radius = half_size_m(ahead)[0]
    level = np.abs(directions[:, 2]) < 1e-12
    aside_deg = np.degrees(np.arctan2(np.abs(directions[level, 1]), directions[level, 0]))
    stopped = np.isfinite(body_ends(behind, car_of(housed(behind, ahead))))[level]
    assert stopped[aside_deg < np.degrees(np.arcsin(radius * 0.995))].all()  # a prism of 32 sides lies within
    assert not stopped[aside_deg > np.degrees(np.arcsin(radius))].any()


def test_only_housings_in_view_are_part_of_the_obstacle() -> None:
    low = spinner("low", 0.0).model_copy(update={"position": (0.0, 0.0, 0.5)})
    high = spinner("high", 0.0).model_copy(update={"position": (0.0, 0.0, 3.0)})
    aside = spinner("aside", 2.0).model_copy(update={"position": (2.0, 0.0, 3.0)})
    rig = housed(low, high, aside)
    body = solid_of(rig.vehicle).fingerprint
    assert obstacle_of(low, car_of(rig)).fingerprint == body  # both others are steeper than 20 degrees above
    assert obstacle_of(high, car_of(rig)).fingerprint != body
    moved = rig.replace(sensors=(low.with_pose(replace(low.pose, position_m=(0.0, 0.1, 0.5))), high, aside))
    assert obstacle_of(high, car_of(moved)) == obstacle_of(high, car_of(rig))
    narrow = low.replace(azimuths_deg=LinearAngles(from_=-60.0, to=60.0, count=121))
    for side_deg, is_met in ((45.0, True), (100.0, False)):
        x, y = np.cos(np.radians(side_deg)), np.sin(np.radians(side_deg))
        other = aside.model_copy(update={"position": (float(x), float(y), 0.5)})
        found = obstacle_of(narrow, car_of(housed(narrow, other)))
        assert (found.fingerprint != body) == is_met


def test_some_rays_end_where_they_do_without_asking_what_is_in_view() -> None:
    less = 0
    for seed in range(6):
        rig = crowd(seed, 8, 24)
        car = car_of(rig)
        for sensor in rig.sensors:
            directions = sensor_rays(sensor).directions
            barrier, some = barrier_of(sensor, car), barrier_of_some(sensor, car)
            ends_m = listed_ends(sensor, directions, barrier)
            np.testing.assert_array_equal(listed_ends(sensor, directions, some), ends_m)
            less += barrier.stops.sum() < some.stops.sum()
    assert less > 5


def test_an_obstacle_is_known_once_the_view_is() -> None:
    bent = Camera(
        name="bent", position=(0.0, 0.0, 2.0), image=(64, 48), fx=41.0, fy=40.0, cx=32.0, cy=24.0,
        distortion=KannalaBrandt(k1=-0.021),
    )  # fmt: skip
    alone, both = (car_of(housed(bent, *others)) for others in ((), (spinner("other", 0.5),)))
    assert known_obstacle(bent, alone) == obstacle_of(bent, alone), "there is nothing to see"
    assert known_obstacle(bent, both) is None
    found = obstacle_of(bent, both)
    assert found.met and known_obstacle(bent, both) == found
    moved = bent.replace(position=(0.0, 0.1, 2.0))
    assert known_obstacle(moved, both) == obstacle_of(moved, both)


def test_what_is_in_view_of_a_bent_lens_needs_no_list_of_its_rays_again() -> None:
    """The list takes half a second, and edits of other sensors drive it out."""
    bent = Camera(
        name="bent", position=(0.0, 0.0, 2.0), image=(64, 48), fx=40.0, fy=40.0, cx=32.0, cy=24.0,
        distortion=KannalaBrandt(k1=-0.02),
    )  # fmt: skip
    first = obstacle_of(bent, car_of(housed(bent, spinner("other", 0.5))))
    RAYS.forget()
    again = obstacle_of(bent, car_of(housed(bent, spinner("other", 0.5))))
    assert again == first and first.met and RAYS.size_bytes == 0


def test_every_edit_gives_the_bits_of_an_evaluation_from_scratch() -> None:
    rng, field = np.random.default_rng(5), field_of(GRID)
    engine, rig = Engine(field), crowd(5)
    for _ in range(12):
        number = int(rng.integers(len(rig.sensors)))
        one = rig.sensors[number]
        shift = rng.uniform(-0.3, 0.3, 3)
        place = tuple(float(a + b) for a, b in zip(one.position, shift, strict=True))
        other = one.model_copy(update={"position": place, "enabled": bool(rng.random() < 0.8)})
        rig = rig.with_sensor(one.name, other)
        found, again = engine.evaluate(rig, BLOCKS), Engine(field).evaluate(rig, BLOCKS)
        assert found.scores == again.scores
        for kind in again.seen:
            np.testing.assert_array_equal(found.seen[kind], again.seen[kind])


def test_a_disabled_sensor_stays_on_the_car() -> None:
    behind, ahead = spinner("behind", -1.0), spinner("ahead", 0.0)
    off = ahead.model_copy(update={"enabled": False})
    stopped = body_ends(behind, car_of(housed(behind, off)))
    np.testing.assert_array_equal(stopped, body_ends(behind, car_of(housed(behind, ahead))))
    assert housed(behind, ahead).only([behind]).sensors == (behind, off)
    assert Rig(sensors=(behind, ahead)).only([behind]).sensors == (behind,)


def test_blind_zones_follow_the_rig() -> None:
    behind, ahead = spinner("behind", -1.0), spinner("ahead", -0.7)
    rig = housed(behind, ahead.model_copy(update={"enabled": False}), vehicle=Vehicle())
    engine = BlindEngine(rig.vehicle, BlindSettings())
    blocked, free = (engine.evaluate(one).levels for one in (rig, rig.replace(housings="ignored")))
    assert (blocked >= free).all()
    assert (blocked > free).any()


def test_the_choice_is_part_of_the_file_and_of_the_history() -> None:
    rig = Rig(sensors=(spinner("a", 0.0),))
    solid = rig.replace(housings="blocks")
    assert "housings" not in dumps(rig)
    assert loads(dumps(solid)).rig == solid
    assert loads(dumps(rig)).rig == rig
    assert rig_sha256(rig) != rig_sha256(solid)
    history = History(rig)
    history.apply("solid", solid)
    history.undo()
    assert history.rig == rig
