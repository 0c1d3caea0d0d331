"""Where a sensor's rays end at the car: its own housing does not stop them, shadows lie where geometry puts them."""

from typing import Any

import numpy as np
import pytest

from riglens.core.kernels.runtime.jit import use_threads
from riglens.core.rig.library import default_library
from riglens.core.rig.model import BrownConrady, Camera, Lidar, LinearAngles, Sensor, Vehicle
from riglens.core.sensing.body_ends import housing_radius_m
from riglens.core.sensing.rays import sensor_rays
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.profile import reference_vehicle
from riglens.core.vehicle.solid import Solid, solid_of
from tests.core.vehicle.solids import body_ends, brute_force, plate, soup

BEAMS: dict[str, Any] = {"elevations_deg": LinearAngles(from_=-60.0, to=60.0, count=13)}
SENSORS: list[Sensor] = [
    Lidar(name="upright", position=(0.1, 0.2, 0.3), **BEAMS),
    Lidar(name="tilted", position=(0.1, 0.2, 0.3), rpy_deg=(20.0, -33.0, 5.0), **BEAMS),
    Lidar(name="listed", position=(3.0, 0.2, 0.3), azimuth_offsets_deg=tuple(np.arange(13) * 0.1), **BEAMS),
    Lidar(name="unsorted", position=(0.0, -2.5, 0.0), elevations_deg=(5.0, -70.0, 90.0), azimuths_deg=(170.0, -3.0)),
    Camera(name="ahead", position=(-3.0, 0.2, 0.3), hfov_deg=70.0, cast=(40, 30)),
    Camera(name="rolled", position=(0.0, 0.0, 0.0), rpy_deg=(40.0, 20.0, 100.0), hfov_deg=120.0, cast=(31, 22)),
    Camera(
        name="bent", position=(2.0, 2.0, 1.0), rpy_deg=(5.0, 20.0, -130.0), fx=900.0, fy=910.0, cx=800.0, cy=440.0,
        distortion=BrownConrady(k1=-0.3, k2=0.05), cast=(30, 20),
    ),
]  # fmt: skip


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda sensor: sensor.name)
@pytest.mark.parametrize("seed", range(3))
def test_rays_of_any_sensor_end_where_a_search_over_all_triangles_says(sensor: Sensor, seed: int) -> None:
    solid = soup(seed)
    ends = body_ends(sensor, solid)
    rays = sensor_rays(sensor)
    barrier = solid.barrier(sensor.kind, housing_radius_m(sensor))
    expected, _ = brute_force(
        np.array(sensor.position), rays.directions, solid.triangles_m[barrier.stops], barrier.start_m
    )
    np.testing.assert_array_equal(ends, expected)
    assert np.isfinite(ends).any() or sensor.name == "unsorted"


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda sensor: sensor.name)
def test_any_number_of_workers_finds_the_same_ends(sensor: Sensor) -> None:
    use_threads(2)
    solid = soup(7)
    for workers in (2, 3):
        np.testing.assert_array_equal(body_ends(sensor, solid, workers), body_ends(sensor, solid))


def test_without_a_solid_all_rays_are_free() -> None:
    for sensor in SENSORS:
        ends = body_ends(sensor, Solid.of(np.zeros((0, 3, 3))))
        assert ends.shape == (len(sensor_rays(sensor).directions),) and np.isinf(ends).all()


def test_a_plate_over_a_lidar_stops_the_beams_that_look_up_at_its_distance() -> None:
    sensor = SENSORS[0]
    for above_m in (0.5, 0.2):
        ends = body_ends(sensor, Solid.of(plate(sensor.position[2] + above_m, axis=2)))
        up = sensor_rays(sensor).directions[:, 2]
        np.testing.assert_allclose(ends[up > 0.1], above_m / up[up > 0.1])
        assert np.isinf(ends[up <= 1e-9]).all()


def test_the_own_housing_stops_no_ray() -> None:
    sensor = Lidar(name="a", position=(0.0, 0.0, 0.0), **BEAMS)
    for above_m, half_m, is_free in ((0.05, 0.05, True), (0.15, 0.15, False)):
        ends = body_ends(sensor, Solid.of(plate(above_m, half_m, axis=2)))
        assert np.isinf(ends).all() == is_free


def test_the_housing_has_the_size_of_the_library_or_the_usual_one() -> None:
    entry = next(entry for entry in default_library().entries("lidar") if entry.name == "velodyne-vlp-16")
    known = entry.sensor("a", SENSORS[0].pose)
    assert housing_radius_m(known) == pytest.approx(np.hypot(0.1032, 0.0717) / 2)
    for model in (None, "no-such-model"):
        for sensor in (SENSORS[0], SENSORS[4]):
            other = sensor.model_copy(update={"model": model})
            assert housing_radius_m(other) == kind_of(sensor).occlusion.housing_radius_m


@pytest.mark.parametrize(("body", "least"), [("suv", 1.0), ("van", 0.998)])
def test_no_beam_leaves_a_closed_car_and_a_camera_looks_out_of_its_windows(body: str, least: float) -> None:
    """But for the slot between wing and wheel housing, which a few beams find from the van's seat."""
    solid = solid_of(reference_vehicle(body))
    inside = (0.2, 0.0, 1.3)
    lidar = Lidar(name="in", position=inside, elevations_deg=LinearAngles(from_=-60, to=85, count=64))
    assert np.isfinite(body_ends(lidar, solid)).mean() >= least
    camera = Camera(name="in", position=inside, hfov_deg=60.0, cast=(64, 36))
    free = np.isinf(body_ends(camera, solid)).reshape(36, 64)
    assert 0.2 < free.mean() < 0.95 and not free[-1].any()


def test_the_edge_of_a_roof_throws_its_shadow_where_geometry_says() -> None:
    """A LiDAR at h_s, dx behind the edge of a flat roof at h: its shadow ends at x = h_s dx / (h_s - h)."""
    h_s, h, dx = 2.0, 1.5, 0.8
    roof = plate(h, half_m=dx, axis=2)
    sensor = Lidar(
        name="roof", position=(0.0, 0.0, h_s), azimuths_deg=(0.0,),
        elevations_deg=LinearAngles(from_=-89.0, to=0.0, count=20_001),
    )  # fmt: skip
    free = np.isinf(body_ends(sensor, Solid.of(roof)))
    down = np.radians(-sensor.elevations()[free])
    nearest_m = h_s / np.tan(down.max())
    assert nearest_m == pytest.approx(h_s * dx / (h_s - h), rel=1e-3)


def test_the_sensors_of_the_paper_stand_above_the_roof_of_the_usual_car() -> None:
    """At 2.2 m, 0.75 m above a sedan: hardly a beam is lost."""
    lidar = Lidar(
        name="l", position=(-0.4, 0.2, 2.2), elevations_deg=LinearAngles(from_=-25, to=25, count=16)
    )
    assert np.isinf(body_ends(lidar, solid_of(Vehicle()))).mean() > 0.95
