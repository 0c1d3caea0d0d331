"""The exact method covers exactly the voxels that an independent oracle finds, on random and nasty rays."""

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from riglens.core.kernels.rays.walk import IRREGULAR, Ray, walk_exact
from riglens.core.rig.model import Lidar, Sensor
from riglens.core.rig.presets import preset
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rational_walk import walk_rational
from tests.core.builders import (
    camera,
    field_of,
    grid_of,
    lidar,
    random_sensor,
    seen_by,
    seen_ray_by_ray,
    spinning,
)
from tests.core.oracle import (
    GridRay,
    exact_cover,
    exact_mask,
    exact_walk,
    grid_rays,
    slab_cover,
)

GRIDS = {
    "unit": grid_of(12, 9, 7),
    "tenths": grid_of(12, 9, 7, 0.1),
    "odd": grid_of(11, 10, 5, 0.3),
    "tall": grid_of(6, 5, 70, 0.25),
    "very tall": grid_of(3, 4, 130, 0.1),
    "one voxel thick": grid_of(12, 1, 6, 0.5),
    "flat": grid_of(12, 9, 1, 0.7),
    "one voxel": grid_of(1, 1, 1, 2.0),
}
FIELDS = {name: field_of(grid) for name, grid in GRIDS.items()}
seeds = st.integers(0, 2**32 - 1)


def assert_agrees(name: str, *sensors: Sensor) -> None:
    """The product's covered set is the oracle's."""
    grid = GRIDS[name]
    assert np.array_equal(seen_by(FIELDS[name], *sensors), exact_cover(grid, sensors))


def kernel_cells(shape: tuple[int, int, int], ray: GridRay) -> set[tuple[int, int, int]]:
    """Voxels of one ray given by its numbers, from the kernel, or the rational walk when it declines."""
    runs = np.empty((sum(shape) + 3, 3), np.int32)
    box = np.array([0, shape[0], 0, shape[1], 0, shape[2]], np.int64)
    far = min(ray.far, 1e30)
    count = walk_exact(Ray(ray.g, ray.d, ray.near, far), box, shape[1], runs)
    if count == IRREGULAR:
        return set(walk_rational(ray.g, ray.d, ray.near, far, [int(b) for b in box]))
    cells = [
        (int(column) // shape[1], int(column) % shape[1], level)
        for column, low, high in runs[:count]
        for level in range(low, high + 1)
    ]
    assert len(cells) == len(set(cells)), "a voxel was visited twice"
    return set(cells)


def assert_walks(shape: tuple[int, int, int], ray: GridRay) -> None:
    assert kernel_cells(shape, ray) == set(exact_walk(shape, ray)), ray


# ---------------------------------------------------------------- the oracle itself


def test_oracle_knows_the_voxels_of_a_ray_that_can_be_followed_by_hand() -> None:
    ray = GridRay((0.5, 0.5, 0.5), (1.0, 0.5, 0.0))
    assert exact_walk((3, 3, 1), ray) == [(0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 1, 0)]


def test_oracle_gives_a_ray_in_a_face_to_the_positive_side_and_a_diagonal_no_touched_voxels() -> None:
    assert exact_walk((2, 3, 1), GridRay((0.0, 1.0, 0.0), (1.0, 0.0, 0.0))) == [(0, 1, 0), (1, 1, 0)]
    assert exact_walk((3, 3, 3), GridRay((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))) == [
        (0, 0, 0),
        (1, 1, 1),
        (2, 2, 2),
    ]
    assert not exact_mask((2, 2, 2), GridRay((0.0, 2.0, 0.0), (1.0, 0.0, 0.0))).any()


# ---------------------------------------------------------------- random sensors


@settings(max_examples=50)
@given(name=st.sampled_from(sorted(GRIDS)), seed=seeds)
def test_random_sensor_covers_what_the_oracle_says(name: str, seed: int) -> None:
    assert_agrees(name, random_sensor(GRIDS[name], np.random.default_rng(seed), rays=20))


@settings(max_examples=20)
@given(
    name=st.sampled_from(["unit", "tenths", "tall", "very tall"]),
    seed=seeds,
    share=st.sampled_from([0.02, 0.2, 0.7]),
)
def test_only_informative_voxels_are_covered(name: str, seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    grid = GRIDS[name]
    informative = rng.random(grid.shape) < share
    sensors = [random_sensor(grid, rng, rays=15) for _ in range(2)]
    assert np.array_equal(
        seen_by(field_of(grid, informative), *sensors), exact_cover(grid, sensors) & informative
    )


def _values(length_m: float, voxel_m: float) -> st.SearchStrategy[float]:
    """Coordinates that like faces: multiples of half the voxel, of a tenth, special values, and anything."""
    halves = st.integers(-6, 2 * round(length_m / voxel_m) + 6).map(lambda i: i * voxel_m / 2 - length_m / 2)
    special = st.sampled_from([0.0, -0.0, 1e-310, -1e-310, 5e-324, 1e-200, 1e-100, -1e-17, 1e-9, 1e6, -1e6])
    return st.one_of(halves, special, st.floats(-length_m, length_m))


_ANGLES = st.one_of(
    st.sampled_from(
        [
            0.0,
            -0.0,
            45.0,
            -45.0,
            90.0,
            -90.0,
            135.0,
            180.0,
            -180.0,
            270.0,
            30.0,
            1e-310,
            5e-324,
            1e-200,
            1e-13,
        ]
    ),
    st.floats(-180.0, 180.0),
)


@st.composite
def _awkward_sensors(draw: st.DrawFn, grid: VoxelGrid) -> Sensor:
    position = [draw(_values(length, grid.voxel_m)) for length in grid.roi_m]
    rpy_deg = [draw(_ANGLES) for _ in range(3)]
    near = draw(st.sampled_from([0.0, grid.voxel_m, 2.5 * grid.voxel_m, 1e-310, 3.0]))
    far = draw(st.sampled_from([math.inf, 2.0 * grid.voxel_m, 4.0 * grid.voxel_m, 1.0, 1e6]))
    range_m = (near, far if far > near else math.inf)
    if draw(st.booleans()):
        cast = draw(st.sampled_from([(1, 1), (3, 3), (4, 2), (5, 4)]))
        return camera(
            position, rpy_deg, cast, draw(st.sampled_from([90.0, 53.13010235415598, 10.0, 170.0])), range_m
        )
    elevations = draw(
        st.lists(
            st.one_of(st.sampled_from([0.0, -0.0, 45.0, 90.0, -90.0, 1e-310]), st.floats(-90, 90)),
            min_size=1,
            max_size=3,
        )
    )
    azimuths = draw(st.lists(_ANGLES.filter(lambda a: abs(a) <= 180.0), min_size=1, max_size=5))
    return lidar(position, rpy_deg, elevations, azimuths, range_m)


@settings(max_examples=30)
@given(
    name=st.sampled_from(["unit", "tenths", "tall"]),
    place=st.tuples(*[st.integers(-8, 8)] * 3),
    yaw_deg=st.sampled_from([0.0, 90.0, 180.0, 45.0, 30.0, -126.86989764584402]),
    focal=st.sampled_from([1.0, 2.0, 4.0, 5.0]),
    is_camera=st.booleans(),
    near=st.sampled_from([0, 2, 3]),
)
def test_upright_sensors_on_grid_faces_whose_rays_change_level_right_at_faces(
    name: str, place: tuple[int, int, int], yaw_deg: float, focal: float, is_camera: bool, near: int
) -> None:
    grid = GRIDS[name]
    x, y, z = (step * grid.voxel_m for step in place)
    position, rpy_deg = [x, y, grid.roi_m[2] / 2 + z], [0.0, 0.0, yaw_deg]
    if is_camera:
        fov_deg = math.degrees(2.0 * math.atan(2.0 / focal))  # slopes like 1/8, 3/8, 5/8
        sensor: Sensor = camera(position, rpy_deg, (4, 4), fov_deg, (0.0, math.inf))
    else:
        beams = [math.degrees(math.atan(rise / 4.0)) for rise in (-4, -2, -1, 0, 1, 3)]
        azimuths = [math.degrees(math.atan2(b, a)) for a, b in ((3, 4), (-8, 15), (7, -24))]
        sensor = lidar(position, rpy_deg, beams, azimuths, (near * grid.voxel_m, 9.0 * grid.voxel_m))
    assert_agrees(name, sensor)


@settings(max_examples=60)
@given(data=st.data(), name=st.sampled_from(sorted(GRIDS)))
def test_awkward_sensor_covers_what_the_oracle_says(data: st.DataObject, name: str) -> None:
    assert_agrees(name, data.draw(_awkward_sensors(GRIDS[name])))


@settings(max_examples=50)
@given(name=st.sampled_from(sorted(GRIDS)), seed=seeds, share=st.sampled_from([0.05, 1.0]))
def test_upright_sensors_with_close_rays(name: str, seed: int, share: float) -> None:
    """Sensors that only yaw may be cast plane by plane; their heights and places like faces."""
    rng = np.random.default_rng(seed)
    grid = GRIDS[name]
    position = rng.integers(-1, 2 * np.array(grid.shape) + 2) / 2.0 * grid.voxel_m
    position = position - [grid.roi_m[0] / 2, grid.roi_m[1] / 2, 0.0] + rng.choice([0.0, 0.013], 3)
    rpy_deg = (0.0, 0.0, float(rng.choice([0.0, 30.0, 45.0, 90.0, 1e-310, rng.uniform(-180.0, 180.0)])))
    spread = float(rng.choice([1.0, 10.0, 45.0, 89.0, 90.0]))
    elevations = np.linspace(-spread, spread, int(rng.choice([1, 2, 5, 31])))
    dense = camera(position, rpy_deg, (2, int(rng.choice([1, 2, 21]))), float(rng.choice([2.0, 60.0, 150.0])))
    informative = rng.random(grid.shape) < share
    near_m, far_m = rng.choice([0.0, 0.013, 0.5, 1.0, 1.7]), rng.choice([0.2, 1.0, 2.2, math.inf])
    azimuths, range_m = rng.choice([0.0, 45.0, -60.0, 100.3], 2), (float(near_m), float(near_m + far_m))
    for sensor in (dense, lidar(position, rpy_deg, elevations, azimuths, range_m)):
        assert np.array_equal(
            seen_by(field_of(grid, informative), sensor), exact_cover(grid, [sensor]) & informative
        )


def test_a_level_ray_in_a_face_is_seen_where_only_its_first_voxel_counts() -> None:
    informative = np.zeros(GRIDS["unit"].shape, np.bool_)
    informative[6, 4, 2] = True
    assert seen_by(field_of(GRIDS["unit"], informative), lidar((0.5, 0.0, 2.0), azimuths=[30.0]))[6, 4, 2]


@settings(max_examples=4)
@given(seed=seeds)
def test_many_generic_rays_agree_with_slabs_in_doubles(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = grid_of(40, 30, 20, 0.2)
    field = field_of(grid)
    for sensor in (
        spinning(rng.uniform(-3.0, 3.0, 3), rng.uniform(-20.0, 20.0, 3), beams=9, count=50),
        spinning([*rng.uniform(-3.0, 3.0, 2), 2.1], (0.0, 0.0, rng.uniform(-20.0, 20.0)), beams=24, count=30),
        camera([*rng.uniform(-3.0, 3.0, 2), 1.7], (0.0, 0.0, rng.uniform(-20.0, 20.0)), (16, 60), 70.0),
        camera(rng.uniform(-3.0, 3.0, 3), rng.uniform(-170.0, 170.0, 3), (25, 14), 100.0),
    ):
        sure, possible = slab_cover(grid, sensor)
        assert np.array_equal(sure, possible), "not generic: choose other numbers"
        assert np.array_equal(seen_by(field, sensor), sure)


def test_at_full_size_a_sensor_covers_the_same_voxels_however_it_is_cast() -> None:
    field = field_of(VoxelGrid(0.2))
    front, left = preset("Wide").sensors[:2]
    native = left.replace(cast=(1600, 900), rpy_deg=(0.0, 0.0, 17.3))
    lidars = preset("Trapezoid").sensors[:2]
    blind_near_by = [sensor.replace(range_m=(0.5, 12.0)) for sensor in lidars]
    for sensor in (*lidars, *blind_near_by, front, left, native):
        seen = seen_by(field, sensor)
        assert seen.sum() > 10_000
        assert np.array_equal(seen, seen_ray_by_ray(field, sensor))


def test_a_heading_almost_along_an_axis_crosses_levels_where_it_should() -> None:
    """Yaw and azimuth nearly make a right angle; the ray meets a column's face and a level at once."""
    grid = grid_of(6, 300, 8)
    field = field_of(grid)
    rng = np.random.default_rng(0)
    for _ in range(25):
        yaw, beside = rng.uniform(20.0, 70.0), 10 ** rng.uniform(-7.0, -5.0)
        x_m = math.radians(beside) * rng.uniform(50.0, 250.0)
        sensor = lidar((x_m, -149.7, 0.0), (0.0, 0.0, yaw), [rng.uniform(0.2, 1.0)], [90.0 - yaw + beside])
        (ray,) = grid_rays(grid, sensor)
        rise = float((3 - Fraction(ray.g[0])) / Fraction(ray.d[0]) * Fraction(ray.d[2]))
        for above in (3e-9, -3e-9, 1e-8, -1e-8, 1e-7):
            placed = sensor.replace(position=(x_m, -149.7, 4.0 - rise + above))
            assert np.array_equal(seen_by(field, placed), exact_cover(grid, [placed]))


# ---------------------------------------------------------------- nasty cases by name


def _axis_parallel() -> Iterator[tuple[str, Lidar]]:
    straight = {
        "forward": (0, 0),
        "left": (0, 90),
        "back": (0, 180),
        "right": (0, -90),
        "up": (90, 0),
        "down": (-90, 0),
    }
    places = {
        "in a face": (0.0, 0.5, 0.5),
        "on an edge": (0.0, 0.5, 1.0),
        "on a corner": (0.0, -0.5, 1.0),
        "in the middle": (0.5, 0.0, 0.5),
    }
    for place, position in places.items():
        for way, (elevation, azimuth) in straight.items():
            yield f"{way} {place}", lidar(position, elevations=[elevation], azimuths=[azimuth])


@pytest.mark.parametrize("sensor", [pytest.param(s, id=name) for name, s in _axis_parallel()])
def test_axis_parallel_rays(sensor: Lidar) -> None:
    assert_agrees("unit", sensor)
    assert_agrees("tenths", sensor.replace(position=tuple(x / 10 for x in sensor.position)))


def test_a_ray_in_a_face_belongs_to_the_positive_side() -> None:
    seen = seen_by(FIELDS["unit"], lidar((-6.0, 0.5, 2.0)))
    assert np.array_equal(np.argwhere(seen), [(i, 5, 2) for i in range(12)])


def test_a_ray_in_the_upper_end_of_the_roi_is_outside() -> None:
    assert not seen_by(FIELDS["unit"], lidar((-6.0, 0.5, 7.0))).any()
    assert not seen_by(FIELDS["unit"], lidar((-6.0, 4.5, 2.5))).any()
    assert seen_by(FIELDS["unit"], lidar((-6.0, -4.5, 0.0))).sum() == 12


@pytest.mark.parametrize(
    "position",
    [
        (0.0, 0.5, 3.0),
        (0.5, 0.0, 3.5),
        (0.0, 0.5, 3.5),
        (-6.0, -4.5, 0.0),
        (6.0, 4.5, 7.0),
        (-9.0, -7.5, 1.0),
    ],
)
def test_diagonals_through_corners_and_along_edges(position: tuple[float, float, float]) -> None:
    corner = math.degrees(math.atan(math.sqrt(0.5)))
    assert_agrees(
        "unit", lidar(position, elevations=[0.0, 45.0, -45.0, corner, -corner], azimuths=range(-180, 180, 45))
    )


@pytest.mark.parametrize("name", ["unit", "tenths", "odd", "tall"])
@pytest.mark.parametrize("pitch", [90.0, -90.0])
def test_looking_straight_down_and_up(name: str, pitch: float) -> None:
    for position in ((0.0, 0.0, 1.0), (0.05, 0.12, 0.3), (0.3, 0.3, 0.3)):
        assert_agrees(
            name,
            camera(position, (0.0, pitch, 0.0), (5, 5), 60.0),
            lidar(position, (0.0, pitch, 30.0), [0, 10]),
        )


@pytest.mark.parametrize("tiny", [1e-310, -1e-310, 5e-324, 1e-200, -0.0, 1e-320])
@pytest.mark.parametrize("name", ["unit", "tenths"])
def test_denormal_and_signed_zero_components(name: str, tiny: float) -> None:
    for position in ((tiny, 0.0, tiny), (0.05, 0.5, tiny), (-0.6, tiny, 0.2)):
        for rpy_deg in ((0.0, 0.0, tiny), (0.0, tiny, 0.0), (tiny, tiny, tiny), (0.0, tiny, 90.0)):
            assert_agrees(name, lidar(position, rpy_deg, elevations=[0.0, tiny], azimuths=[0.0, 180.0, tiny]))


@pytest.mark.parametrize("far_m", [1e6, 9.9e6])
@pytest.mark.parametrize("name", ["unit", "tenths", "tall"])
def test_a_sensor_a_million_metres_away(name: str, far_m: float) -> None:
    aims = np.degrees(np.linspace(-6.0, 6.0, 25) / far_m)
    sensor = lidar((-far_m, 0.25, 0.5), elevations=[0.0, 1e-6, -1e-6], azimuths=aims)
    assert_agrees(name, sensor)
    assert seen_by(FIELDS[name], sensor).any()
    assert_agrees(name, lidar((far_m, far_m, 0.5), (0.0, 0.0, -135.0), azimuths=[*aims, 0.0, 1e-14]))


@pytest.mark.parametrize(
    "range_m",
    [
        (0.0, 2.0),
        (1.0, 2.0),
        (2.0, 3.0),
        (0.0, 0.5),
        (0.5, 1.5),
        (1.0, math.nextafter(1.0, 2.0)),
        (100.0, math.inf),
        (5.0, 5.5),
        (6.0, 7.0),
    ],
)
def test_range_limits_on_faces_and_beyond_the_roi(range_m: tuple[float, float]) -> None:
    for position in ((0.0, 0.5, 3.5), (0.5, 0.0, 3.0), (-6.0, 0.0, 3.5)):
        assert_agrees(
            "unit",
            lidar(position, azimuths=range(-180, 180, 45), range_m=range_m, elevations=[0.0, 45.0, 90.0]),
        )
    assert_agrees(
        "tenths",
        lidar((0.0, 0.05, 0.35), azimuths=range(-180, 180, 45), range_m=tuple(r / 10 for r in range_m)),
    )


def test_a_range_that_ends_on_a_face_does_not_touch_the_next_voxel() -> None:
    seen = seen_by(FIELDS["unit"], lidar((0.5, 0.0, 3.5), range_m=(0.5, 2.5)))
    assert np.array_equal(np.argwhere(seen), [(7, 4, 3), (8, 4, 3)])


@pytest.mark.parametrize(
    "range_m",
    [(0.0, 1e308), (1e308, math.inf), (0.0, 1e200), (1e200, 1e308), (1e29, math.inf), (1e-320, 1e300)],
)
def test_absurd_range_limits(range_m: tuple[float, float]) -> None:
    sensor = lidar((0.05, 0.1, 0.2), (1.0, 2.0, 3.0), [0.0, 10.0], [0.0, 77.0, 180.0, -90.0], range_m)
    limit = 1e6 if range_m[1] > 1e6 else range_m[1]
    near = min(range_m[0], 1e5)
    expected = exact_cover(GRIDS["tenths"], [sensor.replace(range_m=(near, limit))])
    assert np.array_equal(seen_by(FIELDS["tenths"], sensor), expected)


# ---------------------------------------------------------------- rays given by their numbers


def _lattice_points(rng: np.random.Generator, shape: tuple[int, int, int], count: int) -> np.ndarray:
    """Corners, points on edges and points in faces of the voxel lattice."""
    points = rng.integers(0, np.array(shape) + 1, (count, 3)).astype(float)
    free = rng.random((count, 3)) < 0.25
    return points + free * rng.random((count, 3))


@settings(max_examples=60)
@given(seed=seeds, scale=st.sampled_from([1.0, 0.0625, 1e3, 1e7]))
def test_rays_aimed_at_corners_and_edges_and_one_ulp_beside(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    shape = (8, 7, 6)
    for target in _lattice_points(rng, shape, 6):
        origin = rng.uniform(-1.0, 2.0, 3) * np.array(shape)
        aim = (target - origin) * scale
        nudge = rng.integers(-1, 2, 3)
        aim = np.where(
            nudge < 0, np.nextafter(aim, -np.inf), np.where(nudge > 0, np.nextafter(aim, np.inf), aim)
        )
        if aim.any():
            assert_walks(shape, GridRay(tuple(map(float, origin)), tuple(map(float, aim))))


@settings(max_examples=60)
@given(seed=seeds)
def test_rays_from_lattice_point_to_lattice_point(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = (8, 7, 6)
    for start, end in _lattice_points(rng, shape, 12).reshape(-1, 2, 3):
        far = float(rng.choice([math.inf, 1.0, 0.5]))
        if (end - start).any():
            assert_walks(shape, GridRay(tuple(map(float, start)), tuple(map(float, end - start)), 0.0, far))


@settings(max_examples=60)
@given(seed=seeds)
def test_rays_from_far_away_that_graze_corners(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = (8, 7, 6)
    for _ in range(4):
        target = rng.integers(0, np.array(shape) + 1)
        aim = rng.integers(-3, 4, 3).astype(float)
        if aim.any():
            origin = target - aim * float(2.0 ** rng.integers(0, 30))
            ulps = rng.integers(-1, 2, 3)
            origin = np.where(ulps == 0, origin, np.nextafter(origin, np.inf * np.where(ulps == 0, 1, ulps)))
            assert_walks(shape, GridRay(tuple(map(float, origin)), tuple(map(float, aim))))


_COMPONENTS = st.one_of(
    st.sampled_from(
        [0.0, -0.0, 1.0, -1.0, 0.5, 5e-324, -5e-324, 1e-310, 1e-300, 2.0**-300, 2.0**-301, 1e-30, 2.0**-53]
    ),
    st.floats(-1.0, 1.0),
)
_PLACES = st.one_of(
    st.integers(-2, 9).map(float),
    st.sampled_from(
        [-0.0, 5e-324, -5e-324, 1e-310, 1e-100, 2.5, math.nextafter(3.0, 0.0), math.nextafter(3.0, 4.0), 1e17]
    ),
    st.floats(-10.0, 20.0),
)
_LIMITS = st.one_of(st.sampled_from([0.0, 1.0, 2.0, 1e-310, 5e-324, 1e-30, 0.5]), st.floats(0.0, 10.0))


@settings(max_examples=150)
@given(
    g=st.tuples(_PLACES, _PLACES, _PLACES),
    d=st.tuples(_COMPONENTS, _COMPONENTS, _COMPONENTS),
    near=_LIMITS,
    far=st.one_of(st.just(math.inf), _LIMITS),
)
@example(g=(0.0, 0.0, 0.0), d=(1.0, 5e-324, 0.0), near=0.0, far=math.inf)
@example(g=(3.0, 3.0, 0.5), d=(-1.0, -5e-324, 0.0), near=0.0, far=math.inf)
@example(g=(5e-324, 1.0, 1.0), d=(-1.0, 0.0, -1.0), near=0.0, far=math.inf)
def test_any_ray_of_doubles(
    g: tuple[float, float, float], d: tuple[float, float, float], near: float, far: float
) -> None:
    far = min(far, 1e30) if any(abs(x) > 1e-20 for x in d) else 1e30
    if near < far and max(abs(x) for x in d) > 1e-20:
        assert_walks((8, 7, 6), GridRay(g, d, near, far))


@settings(max_examples=80)
@given(seed=seeds)
def test_the_rational_walk_agrees_on_ordinary_rays_too(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = (8, 7, 6)
    g = tuple(float(x) for x in np.round(rng.uniform(-2.0, 10.0, 3) * 2) / 2)
    d = tuple(float(x) for x in np.round(rng.uniform(-2.0, 2.0, 3) * 2) / 2)
    if any(d):
        cells = walk_rational(g, d, 0.0, 20.0, [0, 8, 0, 7, 0, 6])
        assert cells == exact_walk(shape, GridRay(g, d, 0.0, 20.0))


def test_rays_of_a_sensor_leave_the_kernels_for_the_rational_walk_when_denormal() -> None:
    sensor = lidar((0.0, 0.5, 3.5), (0.0, 0.0, 1e-310), azimuths=[0.0, 90.0, 180.0])
    rays = grid_rays(GRIDS["unit"], sensor)
    assert any(0.0 < abs(component) < 1e-300 for ray in rays for component in ray.d)
    assert_agrees("unit", sensor)
