"""Triangles offered to rays find the very ends that every ray finds in the tree, for any sensor, pose and body."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.geometry import Pose
from riglens.core.kernels.body.solid import EDGE, ends_by_tree
from riglens.core.kernels.runtime.jit import use_threads
from riglens.core.rig.library import default_library
from riglens.core.rig.model import BrownConrady, Camera, Lidar, LinearAngles, Sensor
from riglens.core.sensing.body_ends import (
    NO_EMPTY_BOX,
    barrier_ends,
    barrier_of,
    barrier_shadow,
    rays_in_metres,
)
from riglens.core.sensing.kept import SHADOWS
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.profile import reference_vehicle
from riglens.core.vehicle.solid import Barrier, Solid, solid_of
from tests.core.vehicle.solids import box, soup

LIBRARY = default_library()
MODELS = [entry.name for kind in ("lidar", "camera") for entry in LIBRARY.entries(kind)]


def by_tree(sensor: Sensor, barrier: Barrier) -> np.ndarray:
    rays = rays_in_metres(sensor)
    ends = np.full(len(rays.rows) * len(rays.planes), np.inf)
    ends_by_tree(rays, *barrier, 0, 1, ends)
    return ends


def random_sensor(rng: np.random.Generator, spread_m: float) -> Sensor:
    """A LiDAR with or without offsets, or a camera, anywhere, turned anyhow."""
    tilt = rng.choice([0.0, 10.0, 90.0])
    rpy = (rng.uniform(-tilt, tilt), rng.uniform(-tilt, tilt), rng.uniform(-180, 180))
    position = tuple(np.round(rng.uniform(-spread_m, spread_m, 3), int(rng.choice([1, 12]))))
    if rng.random() < 0.3:
        width = rng.choice([20.0, 70.0, 150.0])
        cast = (int(rng.integers(1, 150)), int(rng.integers(1, 90)))
        return Camera(name="a", position=position, rpy_deg=rpy, hfov_deg=width, cast=cast)  # type: ignore[arg-type]
    beams = int(rng.integers(1, 40))
    elevations = tuple(np.round(rng.uniform(-90, 90, beams), int(rng.choice([0, 9]))))
    first, width = float(rng.uniform(-180, 0)), float(rng.choice([40.0, 360.0]))
    turn = LinearAngles(from_=first, to=first + width, count=int(rng.integers(1, 300)))
    offsets = tuple(rng.uniform(-20, 20, beams)) if rng.random() < 0.4 else None
    return Lidar(
        name="a", position=position, rpy_deg=rpy, elevations_deg=elevations, azimuths_deg=turn,  # type: ignore[arg-type]
        azimuth_offsets_deg=offsets,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_any_lattice_ends_at_random_triangles_where_single_rays_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    solid = soup(seed, int(rng.integers(1, 60)), size_m=float(rng.choice([0.01, 0.3, 3.0])))
    for _ in range(6):
        sensor = random_sensor(rng, spread_m=float(rng.choice([0.5, 3.0])))
        barrier = barrier_of(sensor, solid)
        np.testing.assert_array_equal(barrier_ends(sensor, barrier), by_tree(sensor, barrier))


@pytest.mark.parametrize("seed", range(10))
def test_bent_lenses_end_at_random_triangles_where_single_rays_do(seed: int) -> None:
    """With triangles around the camera too, and with one so wide that no image plane has its rays."""
    rng = np.random.default_rng(seed)
    solid = soup(seed, int(rng.integers(1, 200)), size_m=float(rng.choice([0.01, 0.3, 3.0])))
    threads = use_threads(2)
    for k1, fx in ((-0.1, 900.0), (0.05, 500.0), (0.0, 20.0)):
        sensor = Camera(
            name="a", position=tuple(rng.uniform(-0.5, 0.5, 3)), rpy_deg=tuple(rng.uniform(-180, 180, 3)),
            fx=fx, fy=fx, cx=820.0, cy=400.0, distortion=BrownConrady(k1=k1, p1=0.001), cast=(67, 41),
        )  # fmt: skip
        barrier = barrier_of(sensor, solid)
        for workers in (1, threads):
            np.testing.assert_array_equal(barrier_ends(sensor, barrier, workers), by_tree(sensor, barrier))


def test_rays_along_the_faces_and_edges_of_a_box_end_where_single_rays_do() -> None:
    """Sensors in the plane of faces and on edges and corners, with beams along them."""
    solid = Solid.of(box((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0)))
    turn = LinearAngles(from_=-180.0, to=180.0, count=72)
    beams = LinearAngles(from_=-90.0, to=90.0, count=25)
    for x in (-2.0, -1.0, 0.0, 1.0):
        for z in (0.0, 0.5, 1.0, 1.5):
            sensor = Lidar(name="a", position=(x, -1.0, z), elevations_deg=beams, azimuths_deg=turn)
            barrier = barrier_of(sensor, solid)
            np.testing.assert_array_equal(barrier_ends(sensor, barrier), by_tree(sensor, barrier))


@pytest.mark.parametrize(
    "model",
    [model if n % 4 == 0 else pytest.param(model, marks=pytest.mark.slow) for n, model in enumerate(MODELS)],
)
def test_every_model_of_the_library_ends_at_a_car_where_single_rays_do(model: str) -> None:
    """Above the roof, at a corner, or inside, tilted."""
    number, turn = MODELS.index(model), (2.0, 6.0, 40.0)
    vehicle = reference_vehicle(("sedan", "suv", "van")[number % 3])
    places = (
        (0.1, 0.0, vehicle.height + 0.12),
        (vehicle.length / 2 - 0.3, vehicle.width / 2 + 0.05, 0.9),
        (0.2, 0.1, 1.3),
    )
    sensor = LIBRARY.entry(model).sensor("a", Pose(position_m=places[number // 3 % 3], rpy_deg=turn))
    if isinstance(sensor, Camera):
        sensor = sensor.replace(cast=(240, 150))
    barrier = barrier_of(sensor, solid_of(vehicle))
    ends = barrier_ends(sensor, barrier)
    np.testing.assert_array_equal(ends, by_tree(sensor, barrier))
    assert np.isfinite(ends).any() or places[number // 3 % 3] != places[-1]


@pytest.mark.parametrize("is_bent", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_rays_that_end_in_the_void_are_over_and_all_others_keep_their_ends(seed: int, is_bent: bool) -> None:
    rng = np.random.default_rng(seed)
    solid = soup(seed, 200, size_m=0.4)
    sensor = random_sensor(rng, spread_m=1.0)
    if is_bent:
        lens = {"fx": 900.0, "fy": 900.0, "cx": 780.0, "cy": 470.0, "distortion": BrownConrady(k1=-0.2)}
        place = {"position": sensor.position, "rpy_deg": sensor.rpy_deg}
        sensor = Camera.model_validate({"name": "a", **place, **lens, "cast": (130, 70)})
    low, high = (
        np.array(sensor.position) - rng.uniform(0.2, 2, 3),
        np.array(sensor.position) + rng.uniform(0.2, 2, 3),
    )
    barrier = barrier_of(sensor, solid)
    ends = by_tree(sensor, barrier)
    shadow = barrier_shadow(sensor, barrier, np.concatenate([low, high]))
    np.testing.assert_array_equal(shadow.is_stopped, np.isfinite(ends))
    np.testing.assert_array_equal(shadow.cut_m, ends[shadow.cut])
    stopped, directions = np.flatnonzero(np.isfinite(ends)), sensor_rays(sensor).directions
    places = np.array(sensor.position) + ends[stopped, None] * directions[stopped]
    outside = ((places < low - 1e-9) | (places > high + 1e-9)).any(axis=1)
    inside = ((places > low + 1e-9) & (places < high - 1e-9)).all(axis=1)
    assert np.isin(stopped[outside], shadow.cut).all() and not np.isin(stopped[inside], shadow.cut).any()


def test_all_empty_boxes_share_the_shadow_of_a_bent_lens() -> None:
    """Scores leave out what ends in one box near the car and the camera, objects what ends in another."""
    place = {"position": (1.0, 0.4, 1.5), "rpy_deg": (1.0, 20.0, 30.0)}
    lens = {"fx": 500.0, "fy": 500.0, "cx": 780.0, "cy": 470.0, "distortion": BrownConrady(k1=-0.1)}
    camera = Camera.model_validate({"name": "a", **place, **lens, "cast": (130, 70)})
    barrier = barrier_of(camera, solid_of(reference_vehicle("sedan")))
    ends, sides = by_tree(camera, barrier), np.array([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
    car = barrier.tree.bounds[0]
    least = np.concatenate([np.minimum(car[:3], place["position"]), np.maximum(car[3:], place["position"])])
    SHADOWS.forget()
    held, cuts = set(), []
    for empty_box in (least, least + 0.2 * sides, least - 0.2 * sides, NO_EMPTY_BOX):
        shadow = barrier_shadow(camera, barrier, empty_box)
        np.testing.assert_array_equal(shadow.is_stopped, np.isfinite(ends))
        np.testing.assert_array_equal(shadow.cut_m, ends[shadow.cut])
        held.add(SHADOWS.size_bytes)
        cuts.append(len(shadow.cut))
    assert len(held) == 1 and cuts[1] == 0 < cuts[2] < cuts[3] == np.isfinite(ends).sum()


def test_any_number_of_workers_finds_the_same_shadow() -> None:
    use_threads(3)
    solid = solid_of(reference_vehicle("sedan"))
    for model in ("velodyne-vls-128", "hesai-xt32"):
        sensor = LIBRARY.entry(model).sensor("a", Pose(position_m=(1.9, 0.9, 0.9), rpy_deg=(1.0, 2.0, 3.0)))
        barrier = barrier_of(sensor, solid)
        for empty_box in (NO_EMPTY_BOX, np.array([-2.0, -1.0, 0.0, 2.0, 1.0, 2.0])):
            alone = barrier_shadow(sensor, barrier, empty_box)
            for workers in (2, 3):
                for mine, its in zip(barrier_shadow(sensor, barrier, empty_box, workers), alone, strict=True):
                    np.testing.assert_array_equal(mine, its)


SMALL: dict[str, dict[str, object]] = {
    "lidar": {"elevations_deg": (-20.0, -3.0, 4.0), "azimuths_deg": {"from": -180.0, "to": 180.0, "count": 90}},
    "camera": {"hfov_deg": 80.0, "cast": (40, 30)},
    "bent": {
        "image": (800, 600), "cast": (40, 30), "fx": 500.0, "fy": 500.0, "cx": 400.0, "cy": 300.0,
        "distortion": BrownConrady(k1=-0.1),
    },
}  # fmt: skip
SMALL["narrow"] = SMALL["bent"] | {"fx": 1e7, "fy": 1e7}  # between its rays there is next to no bend


@pytest.mark.parametrize("beyond", [0.9, 1.1, 1e5])
@pytest.mark.parametrize("which", SMALL)
def test_a_triangle_ends_as_far_beyond_its_edges_as_for_single_rays(which: str, beyond: float) -> None:
    """Rays pass just outside an edge or a corner, at multiples of the margin within which they still hit."""
    rng, away, model = np.random.default_rng(11), beyond * EDGE, Lidar if which == "lidar" else Camera
    for _ in range(12):
        where = {"name": "a", "position": (0.1, -0.2, 1.3), "rpy_deg": tuple(rng.uniform(-180.0, 180.0, 3))}
        sensor: Sensor = model.model_validate(where | SMALL[which])
        directions = sensor_rays(sensor).directions
        beside = [(-away, 0.3), (0.3, -away), (0.4, 0.6 + away), (-away, -away), (1.0 + 2.0 * away, -away)]
        for u, v in beside:
            ray, (one, two) = rng.integers(len(directions)), rng.uniform(-0.5, 0.5, (2, 3))
            corner = np.array(sensor.position) + rng.uniform(1.0, 3.0) * directions[ray] - u * one - v * two
            barrier = barrier_of(sensor, Solid.of(np.array([[corner, corner + one, corner + two]])))
            ends = by_tree(sensor, barrier)
            assert np.isfinite(ends[ray]) == (beyond < 1.0)
            np.testing.assert_array_equal(barrier_ends(sensor, barrier), ends)
            shadow = barrier_shadow(sensor, barrier, np.array([-9.0, -9.0, -9.0, 9.0, 9.0, 9.0]))
            np.testing.assert_array_equal(shadow.is_stopped, np.isfinite(ends))


def test_a_bent_lens_in_the_planes_of_faces_ends_at_a_box_where_single_rays_do() -> None:
    """Triangles that are seen edge on have no sides, also in an empty box."""
    solid, bent = Solid.of(box((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0))), SMALL["bent"] | {"cast": (41, 31)}
    for x in (-2.0, -1.0, 0.0):
        for z in (0.0, 0.5, 1.0, 1.5):
            for yaw_deg in (0.0, 45.0):
                where = {"name": "a", "position": (x, -1.0, z), "rpy_deg": (0.0, 0.0, yaw_deg)}
                sensor = Camera.model_validate(where | bent)
                barrier = barrier_of(sensor, solid)
                ends = by_tree(sensor, barrier)
                np.testing.assert_array_equal(barrier_ends(sensor, barrier), ends)
                shadow = barrier_shadow(sensor, barrier, np.array([-9.0, -9.0, -9.0, 9.0, 9.0, 9.0]))
                np.testing.assert_array_equal(shadow.is_stopped, np.isfinite(ends))
