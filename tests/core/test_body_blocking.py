"""With `body: blocks` the voxels seen are those of rays cut off at the car, to the last one and for any sensor."""

from dataclasses import replace
from unittest import mock

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine, Evaluation, evaluate_from_scratch
from riglens.core.engine.meshes import make_mesh
from riglens.core.engine.sheets import make_sheets
from riglens.core.errors import InputError
from riglens.core.kernels.body.solid import ends_by_tree
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import METHODS, READINGS, MetricSettings
from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import BrownConrady, Camera, Lidar, LinearAngles, Rig, Sensor, Vehicle
from riglens.core.sensing.body_ends import (
    barrier_ends,
    barrier_of,
    housing_radius_m,
    rays_in_metres,
)
from riglens.core.sensing.screens import screen_of
from riglens.core.vehicle.solid import Solid, solid_of
from tests.core.builders import (
    camera,
    field_of,
    grid_of,
    random_field,
    random_sensor,
    rig_of,
    spinning,
    unpack,
)
from tests.core.edits import Editor
from tests.core.oracle import exact_mask, grid_rays
from tests.core.vehicle.solids import body_ends, brute_force, plate, soup

BLOCKS = MetricSettings(body="blocks")
FILE = Vehicle(body="soup.glb")
GRID = grid_of(12, 9, 70, 0.5)
FINE = grid_of(48, 40, 20, 0.25)
Mask = NDArray[np.bool_]


def test_one_type_of_screen_serves_lidars_and_cameras() -> None:
    """Another type of an array would compile all of the shadow again."""
    screens = [screen_of(sensor) for sensor in (spinning((0, 0, 2)), camera((0, 0, 2)))]
    assert numba.typeof(screens[0]) == numba.typeof(screens[1])


def mesh_of(triangles_m: NDArray[np.float64]) -> BodyMesh:
    """A mesh of separate triangles (t, 3, 3)."""
    points = triangles_m.reshape(-1, 3).astype(np.float32)
    corners = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    return BodyMesh(points, np.zeros_like(points), corners)


def soup_around(sensor: Sensor, seed: int, count: int = 60) -> BodyMesh:
    """Triangles here and there within two metres of a sensor."""
    return mesh_of(soup(seed, count, size_m=0.6, spread_m=1.5).triangles_m + np.array(sensor.position))


def evaluated(field: EntropyField, mesh: BodyMesh, *sensors: Sensor, method: str = "exact") -> Evaluation:
    rig = rig_of(*sensors).replace(vehicle=FILE.with_body_mesh(mesh))
    return Engine(field).evaluate(rig, replace(BLOCKS, method=method))  # type: ignore[arg-type]


def seen_cut(field: EntropyField, mesh: BodyMesh, *sensors: Sensor, method: str = "exact") -> Mask:
    found = evaluated(field, mesh, *sensors, method=method)
    return unpack(field.grid, found.seen_by_any())


def oracle_cut(field: EntropyField, mesh: BodyMesh, sensor: Sensor) -> Mask:
    """Every ray against every triangle in plain numpy, then against every voxel in rational numbers."""
    solid = solid_of(FILE.with_body_mesh(mesh))
    barrier = barrier_of(sensor, solid)
    grid = field.grid
    rays = grid_rays(grid, sensor)
    directions = np.array([ray.d for ray in rays])
    ends, _ = brute_force(
        np.array(sensor.position), directions, solid.triangles_m[barrier.stops], barrier.start_m
    )
    cover = np.zeros(grid.shape, np.bool_)
    for ray, end in zip(rays, ends, strict=True):
        far = min(ray.far, float(end) / grid.voxel_m)
        if far > ray.near:
            cover |= exact_mask(grid.shape, replace(ray, far=far))
    return cover


def ray_by_ray(field: EntropyField, mesh: BodyMesh, sensor: Sensor) -> Mask:
    """The same with the product's walk of single rays, each cut off at its own end."""
    caster, marks = Caster(field), np.zeros_like(field.index.words)
    solid = solid_of(FILE.with_body_mesh(mesh))
    ends = body_ends(sensor, solid) / field.grid.voxel_m
    caster._mark_rays(caster.rays(sensor, "exact")._replace(ends=ends), marks, lambda: False)
    return unpack(field.grid, marks & field.index.words)


seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=25)
@given(seed=seeds)
def test_the_voxels_seen_are_those_of_rays_cut_off_at_the_car(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field = field_of(GRID)
    sensor = random_sensor(GRID, rng, rays=20)
    mesh = soup_around(sensor, seed)
    np.testing.assert_array_equal(seen_cut(field, mesh, sensor), oracle_cut(field, mesh, sensor))


def dense_sensor(rng: np.random.Generator) -> Sensor:
    """A sensor with many rays, upright as often as tilted, at a round place as often as not."""
    position = rng.uniform([-3.0, -3.0, 0.5], [3.0, 3.0, 3.5])
    position = np.round(position, 1) if rng.random() < 0.5 else position
    rpy = np.zeros(3) if rng.random() < 0.3 else rng.uniform([-20.0, -20.0, -180.0], [20.0, 20.0, 180.0])
    if rng.random() < 0.6:
        rpy[:2] = 0.0
    if rng.random() < 0.5:
        sensor: Sensor = spinning(position, rpy, int(rng.integers(2, 20)), int(rng.integers(10, 120)))
        near = float(rng.choice([0.0, 0.3, 1.1]))
        return sensor.replace(range_m=(near, float(rng.choice([np.inf, 60.0, 4.0]))))
    columns, rows = int(rng.integers(2, 90)), int(rng.integers(2, 60))
    return camera(position, rpy, (columns, rows), float(rng.uniform(40.0, 120.0)))


def assert_as_ray_by_ray(seed: int, share: float = 0.5) -> None:
    rng = np.random.default_rng(seed)
    field = random_field(FINE, rng, share=share)
    sensor = dense_sensor(rng)
    mesh = soup_around(sensor, seed, int(rng.integers(1, 40)))
    np.testing.assert_array_equal(seen_cut(field, mesh, sensor), ray_by_ray(field, mesh, sensor))


@settings(max_examples=30)
@given(seed=seeds)
def test_every_way_of_casting_sees_what_single_rays_see(seed: int) -> None:
    assert_as_ray_by_ray(seed)


def dense_lidar(rng: np.random.Generator) -> Lidar:
    """A LiDAR with rays close enough for core and sheets: tilted, upside down, with offsets, a sector, a range."""
    beams = int(rng.integers(2, 40))
    turn = LinearAngles(from_=-180.0, to=180.0, count=int(rng.integers(520, 800)))
    wide = float(rng.choice([155.0, 240.0]))
    sector = LinearAngles(from_=-0.6 * wide, to=0.4 * wide, count=int(rng.integers(400, 500)))
    offsets = tuple(rng.uniform(-3.0, 3.0, beams)) if rng.random() < 0.4 else None
    low = float(rng.uniform(-40.0, 0.0))
    return Lidar(
        name="a",
        position=tuple(np.round(rng.uniform([-4.0, -4.0, 0.5], [4.0, 4.0, 4.0]), int(rng.choice([1, 12])))),
        rpy_deg=(
            float(rng.choice([0.0, 180.0]) + rng.uniform(-9, 9)),
            *map(float, rng.uniform([-9, -180], [9, 180])),
        ),
        elevations_deg=LinearAngles(from_=low, to=low + float(rng.uniform(2.0, 45.0)), count=beams),
        azimuths_deg=turn if rng.random() < 0.6 else sector,
        azimuth_offsets_deg=offsets,
        range_m=(float(rng.choice([0.0, 0.5])), float(rng.choice([np.inf, 5.0]))),
    )


def assert_sheets_as_ray_by_ray(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field, sensor = random_field(FINE, rng, share=float(rng.choice([0.1, 0.6]))), dense_lidar(rng)
    assert make_sheets(sensor, Caster(field).rays(sensor, "exact")) is not None
    mesh = soup_around(sensor, seed, int(rng.integers(1, 40)))
    with mock.patch(
        "riglens.core.engine.caster.FEWEST_RAYS", 0
    ):  # the rays are few, so that one by one takes no time
        seen = seen_cut(field, mesh, sensor)
    np.testing.assert_array_equal(seen, ray_by_ray(field, mesh, sensor))


@pytest.mark.parametrize("seed", range(24))
def test_cores_and_sheets_see_what_single_rays_see(seed: int) -> None:
    assert_sheets_as_ray_by_ray(seed)


@pytest.mark.parametrize("rays", [30_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_triangles_offered_to_rays_and_the_tree_find_the_same_ends(rays: int) -> None:
    """Two routes from a triangle to the rays that it stops, to the last bit of each distance."""
    cast = stopped = seed = 0
    while cast < rays:
        rng = np.random.default_rng(seed)
        sensor = dense_lidar(rng) if seed % 2 else dense_sensor(rng)
        barrier = solid_of(FILE.with_body_mesh(soup_around(sensor, seed, int(rng.integers(1, 120))))).barrier(
            sensor.kind, 0.1
        )
        assert screen_of(sensor) is not None
        found = barrier_ends(sensor, barrier)
        expected = np.full(found.size, np.inf)
        ends_by_tree(rays_in_metres(sensor), *barrier, 0, 1, expected)
        np.testing.assert_array_equal(found, expected)
        cast, stopped, seed = cast + found.size, stopped + int(np.isfinite(found).sum()), seed + 1
    assert stopped > rays // 100


@pytest.mark.slow
def test_thousands_of_sensors_see_what_their_single_rays_see() -> None:
    for seed in range(3000):
        assert_as_ray_by_ray(seed, (0.1, 0.5, 1.0)[seed % 3])
        assert_sheets_as_ray_by_ray(seed)


def bent_camera(rng: np.random.Generator) -> Camera:
    """A camera with a distorted lens whose rays are close enough to be joined to a mesh."""
    fx = float(rng.uniform(800.0, 2000.0))
    return Camera(
        name="C",
        position=tuple(np.round(rng.uniform([-3.0, -3.0, 0.5], [3.0, 3.0, 3.5]), int(rng.choice([1, 12])))),
        rpy_deg=tuple(map(float, rng.uniform([-20.0, -20.0, -180.0], [20.0, 20.0, 180.0]))),  # type: ignore[arg-type]
        fx=fx, fy=fx, cx=float(rng.uniform(700.0, 900.0)), cy=450.0,
        distortion=BrownConrady(k1=float(rng.uniform(-0.12, 0.1)), p1=float(rng.uniform(-0.01, 0.01))),
        cast=(int(rng.integers(60, 140)), int(rng.integers(40, 80))),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(8))
def test_bent_lenses_see_what_single_rays_see_and_stay_in_their_mesh(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field, sensor = random_field(FINE, rng, share=float(rng.choice([0.1, 0.6]))), bent_camera(rng)
    ahead = np.array(sensor.position) + sensor.pose.rotation()[:, 0]
    mesh = mesh_of(soup(seed, int(rng.integers(10, 60)), size_m=0.6, spread_m=0.9).triangles_m + ahead)
    free, *_ = Caster(field)._casts(sensor, "exact", barrier_of(sensor, solid_of(FILE.with_body_mesh(mesh))))
    assert make_mesh(sensor, free) is not None and free.is_stopped.any()
    np.testing.assert_array_equal(seen_cut(field, mesh, sensor), ray_by_ray(field, mesh, sensor))


LISTED: list[Sensor] = [
    Lidar(
        name="L", position=(0.3, 0.1, 1.7), elevations_deg=LinearAngles(from_=-40, to=25, count=9),
        azimuth_offsets_deg=tuple(0.3 * i for i in range(9)), azimuths_deg=LinearAngles(from_=-180, to=180, count=40),
    ),
    Camera(
        name="C", position=(0.4, 0.0, 1.5), rpy_deg=(0.0, 10.0, 30.0), fx=900.0, fy=910.0, cx=800.0, cy=440.0,
        distortion=BrownConrady(k1=-0.3, k2=0.05), cast=(40, 25),
    ),
]  # fmt: skip


@pytest.mark.parametrize("sensor", LISTED, ids=["lidar", "camera"])
@pytest.mark.parametrize("seed", range(4))
def test_sensors_of_listed_rays_are_cut_off_too(sensor: Sensor, seed: int) -> None:
    field = field_of(FINE)
    mesh = soup_around(sensor, seed)
    seen = seen_cut(field, mesh, sensor)
    np.testing.assert_array_equal(seen, ray_by_ray(field, mesh, sensor))
    assert 0 < seen.sum() < seen_cut(field, mesh_of(np.zeros((0, 3, 3))), sensor).sum()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("reading", READINGS)
def test_an_empty_body_blocks_nothing_to_the_last_bit(method: str, reading: str) -> None:
    rng = np.random.default_rng(5)
    field = random_field(GRID, rng, share=0.4)
    rig = rig_of(*(random_sensor(GRID, rng) for _ in range(5))).replace(vehicle=FILE)
    free = MetricSettings(method, reading)  # type: ignore[arg-type]
    expected = Engine(field).evaluate(rig, free)
    empty = rig.with_body_mesh(mesh_of(np.zeros((0, 3, 3))))
    found = Engine(field).evaluate(empty, replace(free, body="blocks"))
    assert found.scores == expected.scores
    np.testing.assert_array_equal(found.seen["camera"], expected.seen["camera"])
    np.testing.assert_array_equal(found.seen["lidar"], expected.seen["lidar"])


def test_a_body_in_the_way_takes_from_every_method_and_reading() -> None:
    field = field_of(GRID)
    wall = mesh_of(plate(1.0) + np.array([0.0, 0.1, 0.0]))
    for sensor in (spinning((0.1, 0.2, 1.3)), camera((0.1, 0.2, 1.3))):
        for method in METHODS:
            free = seen_cut(field, mesh_of(np.zeros((0, 3, 3))), sensor, method=method)
            cut = seen_cut(field, wall, sensor, method=method)
            behind = np.arange(GRID.shape[0]) * GRID.voxel_m - GRID.roi_m[0] / 2 > 1.5
            assert free[behind].any() and not cut[behind].any()
            if method == "exact":  # a line of Bresenham's with another end runs through other voxels
                np.testing.assert_array_equal(cut & free, cut)
        rig = rig_of(sensor).replace(vehicle=FILE.with_body_mesh(wall))
        hits = [
            Engine(field)
            .evaluate(rig, MetricSettings("exact", "hits", body=body))  # type: ignore[arg-type]
            .scores.classes["car"]
            .s_ms
            for body in ("ignored", "blocks")
        ]
        assert abs(hits[1]) < abs(hits[0])


def test_the_sum_over_hits_counts_each_cut_ray() -> None:
    """One ray along x, cut off in the middle of a voxel that still counts."""
    field = random_field(GRID, np.random.default_rng(2), share=1.0)
    ray = Lidar(name="L", position=(-2.9, 0.1, 1.1), elevations_deg=(0.0,), azimuths_deg=(0.0,))
    rig = rig_of(ray).replace(vehicle=FILE.with_body_mesh(mesh_of(plate(0.3))))
    both = [
        Engine(field).evaluate(rig, MetricSettings("exact", reading, body="blocks"))  # type: ignore[arg-type]
        for reading in ("covered", "hits")
    ]
    assert both[0].scores.covered_voxels["any"] == 7  # x from -2.9 to 0.3 in voxels of half a metre
    assert both[1].scores.classes["car"].lidar.s_mig == pytest.approx(
        both[0].scores.classes["car"].lidar.s_mig
    )


class BlockingEditor(Editor):
    """Also switches the body and its shape."""

    def __init__(self, rng: np.random.Generator) -> None:
        super().__init__(rng, grid_of(10, 9, 70, 0.5))
        self.rig = Rig(vehicle=Vehicle(length=3.0, width=1.5, height=1.2))

    def step(self) -> None:
        chance = self.rng.random()
        if chance < 0.1:
            self.settings = replace(self.settings, body=str(self.rng.choice(["ignored", "blocks"])))
        elif chance < 0.2:
            body, length = str(self.rng.choice(["sedan", "suv"])), float(self.rng.choice([3.0, 3.5]))
            self.rig = self.rig.replace(vehicle=Vehicle(body=body, length=length, width=1.5, height=1.2))
        else:
            body_before = self.settings.body
            super().step()
            if len(self.past) % 3:
                self.settings = replace(self.settings, body=body_before)


def edit_at_random(seed: int, steps: int) -> None:
    field = random_field(GRID, np.random.default_rng(1), share=0.3)
    editor, engine, fresh = BlockingEditor(np.random.default_rng(seed)), Engine(field, 2), Engine(field, 1)
    blocked = 0
    for step in range(steps):
        editor.step()
        found = engine.evaluate(editor.rig, editor.settings)
        if steps > 500 and step % 20:
            continue
        expected = next(evaluate_from_scratch(field, [editor.rig], editor.settings, 1, with_seen=True))
        assert found.scores == expected.scores
        np.testing.assert_array_equal(found.seen["camera"], expected.seen["camera"])
        np.testing.assert_array_equal(found.seen["lidar"], expected.seen["lidar"])
        if editor.settings.body == "blocks":
            free = fresh.evaluate(editor.rig, replace(editor.settings, body="ignored"))
            blocked += free.scores != found.scores
    assert blocked > 0


@pytest.mark.parametrize("seed", [1, 5])
def test_random_edits_end_where_an_evaluation_from_scratch_does(seed: int) -> None:
    edit_at_random(seed, 60)


@pytest.mark.slow
def test_ten_thousand_edits_end_where_an_evaluation_from_scratch_does() -> None:
    edit_at_random(11, 10_000)


def test_a_missing_mesh_is_told_and_nothing_is_scored() -> None:
    engine, rig = Engine(field_of(GRID)), rig_of(spinning((0.0, 0.0, 1.0))).replace(vehicle=FILE)
    with pytest.raises(InputError, match=r"^vehicle\.body: the mesh 'soup\.glb' has not been read$"):
        engine.evaluate(rig, BLOCKS)
    assert engine.evaluate(rig).scores.covered_voxels["any"] > 0


def test_another_model_with_a_larger_housing_is_another_sensor() -> None:
    """The housing decides what stops a ray: 8 cm from a VLP-16 is outside of it, from an unknown LiDAR inside."""
    field = field_of(GRID)
    lid = mesh_of(plate(1.08, half_m=0.05, axis=2))
    near = spinning((0.0, 0.0, 1.0), beams=1).replace(elevations_deg=(88.0,))
    known = near.replace(model="velodyne-vlp-16")
    assert housing_radius_m(known) < 0.08 < housing_radius_m(near)
    engine, car = Engine(field), FILE.with_body_mesh(lid)
    free, cut = (
        engine.evaluate(rig_of(sensor).replace(vehicle=car), BLOCKS).scores.covered_voxels["any"]
        for sensor in (near, known)
    )
    assert cut < free


def test_a_car_that_hides_nothing_from_a_sensor_costs_it_nothing() -> None:
    """Solids of which no ray meets anything leave the rays as they are."""
    caster = Caster(field_of(GRID))
    sensor = spinning((0.0, 0.0, 1.0))
    away = Solid.of(plate(40.0, half_m=0.1, axis=2))
    (free,) = caster._casts(sensor, "exact", barrier_of(sensor, away))
    assert free.is_stopped.size == 0


ROOF_EDGE: list[Sensor] = [
    camera((0.01, 0.12, 1.53), rpy, cast, 80.0)
    for rpy, cast in (
        ((0.0, 0.0, 5.0), (800, 450)),
        ((0.0, 3.0, 5.0), (1600, 900)),
        ((4.0, 8.0, 5.0), (800, 450)),
    )
] + [spinning((0.01, 0.12, 1.62), rpy, 32, 720) for rpy in ((0.0, 0.0, 5.0), (1.0, 3.0, 5.0))]
ROOF_EDGE.append(
    Camera(
        name="C", position=(1.25, 0.91, 0.95), rpy_deg=(0.0, 5.0, 140.0), fx=1000.0, fy=1000.0, cx=960.0, cy=600.0,
        distortion=BrownConrady(k1=-0.1, p1=0.004), cast=(480, 300),
    )
)  # fmt: skip


@pytest.mark.parametrize(
    "sensor", ROOF_EDGE, ids=["upright", "pitched", "rolled", "lidar", "tilted-lidar", "bent-lens"]
)
def test_dense_sensors_on_the_car_see_what_single_rays_see(sensor: Sensor) -> None:
    """Sensors on a sedan, which takes a part of their rays and leaves others free; what another sensor of their kind
    has marked in the same set stays."""
    field = random_field(grid_of(60, 60, 20, 0.4), np.random.default_rng(3), share=0.4)
    solid, window = solid_of(Vehicle()), Caster(field).window(sensor)
    barrier, found = barrier_of(sensor, solid), []
    for workers in (1, 2):
        caster, marks = Caster(field, workers), np.zeros_like(field.index.words)
        assert caster.mark(sensor, "exact", window, marks, barrier=barrier)
        found.append(marks & field.index.words)
    ends = body_ends(sensor, solid) / field.grid.voxel_m
    single = np.zeros_like(field.index.words)
    caster._mark_rays(caster.rays(sensor, "exact")._replace(ends=ends), single, lambda: False)
    assert 0.0 < np.isfinite(ends).mean() < 0.9
    np.testing.assert_array_equal(found[0], single & field.index.words)
    np.testing.assert_array_equal(found[1], found[0])
    before = field.index.words & np.random.default_rng(4).integers(0, 2**64, single.size, np.uint64)
    both = before.copy()
    assert caster.mark(sensor, "exact", window, both, barrier=barrier)
    np.testing.assert_array_equal(both & field.index.words, before | found[0])
