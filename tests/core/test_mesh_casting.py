"""Cameras with lens distortion are cast by the mesh of their rays: the set is that of these, one by one and exactly."""

import math
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.engine.caster import Caster
from riglens.core.engine.meshes import make_mesh, outermost_directions, ray_mesh
from riglens.core.geometry import Pose
from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.library import default_library
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt
from riglens.core.scene.columns import unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import lattice, missing_ray_count, sensor_rays
from riglens.core.sensors.base import unplaced
from riglens.core.sensors.camera import field_of_view_deg
from riglens.core.study.reference import exact_cover
from tests.core.builders import field_of, grid_of, seen_by, seen_ray_by_ray
from tests.core.poses import any_pose
from tests.core.rooms import ROOMS, SMALL, SMALL_FIELD, field_at, seeds

LENSES = (
    BrownConrady(k1=-0.3, k2=0.08, p1=1e-3),
    BrownConrady(k1=0.4, k2=0.2),
    BrownConrady(k1=-0.6, k2=0.66, p1=0.0011, p2=-0.001, k3=-1.0),
    KannalaBrandt(k1=0.05, k2=-0.01),
)


@lru_cache(maxsize=1)
def models() -> tuple[Camera, ...]:
    """Every camera of the library with lens distortion and a mesh, with fewer rays than pixels.

    Rays of fisheyes that look sideways and farther back are walked one by one.
    """
    made = (
        entry.sensor("C", Pose((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)))
        for entry in default_library().entries("camera")
    )
    return tuple(
        sensor.replace(cast=(352, 128))
        for sensor in made
        if isinstance(sensor, Camera)
        and sensor.distortion is not None
        and field_of_view_deg(sensor)[0] < 174.0
    )


def anywhere(rng: np.random.Generator, camera: Camera, grid: VoxelGrid) -> Camera:
    """The camera in any pose."""
    pose = any_pose(rng, grid)
    return camera.replace(position=pose.position_m, rpy_deg=pose.rpy_deg)


def differs(field: EntropyField, sensor: Camera, workers: int = 1) -> str:
    """What is wrong with a camera; nothing where its mesh equals its rays."""
    caster, marks = Caster(field, workers), np.zeros_like(field.index.words)
    rays = caster.rays(sensor, "exact")
    mesh = make_mesh(sensor, rays)
    assert mesh is not None, sensor
    caster._mark_mesh(mesh, rays, caster.window(sensor), marks, lambda: False)
    seen, truth = unpack(field.grid, marks & field.index.words), seen_ray_by_ray(field, sensor)
    missing, extra = int((truth & ~seen).sum()), int((seen & ~truth).sum())
    return f"{missing} missing, {extra} extra: {sensor}" if missing or extra else ""


def bent(rng: np.random.Generator, lens: BrownConrady | KannalaBrandt, cast: tuple[int, int]) -> Camera:
    """A camera with a lens, looking narrow or wide."""
    focal = float(rng.uniform(600.0, 2000.0))
    plain = Camera(name="C", position=(0.0, 0.0, 1.0), image=(1600, 900), cast=cast, hfov_deg=90.0)
    sizes = {"fx": focal, "fy": focal, "cx": 799.5, "cy": 452.25}
    return plain.replace(hfov_deg=None, distortion=lens, **sizes)


@settings(max_examples=12)
@given(seed=seeds)
def test_library_cameras_in_any_pose_see_what_their_rays_see(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field = field_at(*ROOMS[rng.integers(len(ROOMS))], float(rng.choice([1.0, 0.3])))
    camera = anywhere(rng, models()[rng.integers(len(models()))], field.grid)
    assert not differs(field, camera, int(rng.integers(1, 4)))


@settings(max_examples=20)
@given(seed=seeds, lens=st.sampled_from(LENSES), cast=st.sampled_from([(200, 113), (320, 90), (90, 160)]))
def test_lenses_of_any_kind_in_any_pose_see_what_their_rays_see(
    seed: int, lens: BrownConrady | KannalaBrandt, cast: tuple[int, int]
) -> None:
    rng = np.random.default_rng(seed)
    camera = anywhere(rng, bent(rng, lens, cast), SMALL)
    if make_mesh(camera, Caster(SMALL_FIELD).rays(camera, "exact")) is not None:
        assert not differs(SMALL_FIELD, camera)


@settings(max_examples=5)
@given(seed=seeds)
def test_a_mesh_covers_what_the_definition_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    camera = anywhere(rng, bent(rng, LENSES[0], (96, 60)).replace(fx=1500.0, fy=1500.0), SMALL)
    assert make_mesh(camera, Caster(SMALL_FIELD).rays(camera, "exact")) is not None
    assert np.array_equal(seen_by(SMALL_FIELD, camera), exact_cover(SMALL, [camera]))


@pytest.mark.parametrize(
    "rpy_deg",
    [
        (2.0, -3.0, 8.0),
        *(
            pytest.param(turn, marks=pytest.mark.slow)
            for turn in ((0.0, 0.0, 8.0), (0.0, 90.0, 0.0), (90.0, 0.0, 30.0))
        ),
    ],
)
def test_all_pixels_of_library_cameras_see_what_their_rays_see(rpy_deg: tuple[float, float, float]) -> None:
    """Some models stand for all in the quick run."""
    field, place = field_at(0.37, (44.4, 29.6, 3.7), 1.0), (0.31, -0.4, 1.73)
    for camera in models()[::4] if rpy_deg == (2.0, -3.0, 8.0) else models():
        assert not differs(field, camera.replace(cast=camera.image, position=place, rpy_deg=rpy_deg))


def test_beyond_the_limit_of_its_mesh_a_camera_is_cast_ray_by_ray() -> None:
    field = field_of(grid_of(60, 12, 12))
    eye = Camera(
        name="C", position=(-29.5, 0.1, 6.1), rpy_deg=(1.0, 0.5, 0.3), image=(640, 480), cast=(24, 18), fx=880.0,
        fy=880.0, cx=320.0, cy=240.0, distortion=BrownConrady(k1=-0.1),
    )  # fmt: skip
    mesh = make_mesh(eye, Caster(field).rays(eye, "exact"))
    assert mesh is not None and mesh.view.limit < 40.0
    assert np.array_equal(seen_by(field, eye), seen_ray_by_ray(field, eye))


def test_a_camera_at_corners_and_faces_of_voxels() -> None:
    for cells in ((5, 5, 5), (5.5, 5, 5), (5, 5.5, 5.5), (0, 0, 0), (24, 20, 11), (5.01, 4.99, 5.02)):
        position = tuple(float(v) for v in np.array(SMALL.origin_m) + np.array(cells) * SMALL.voxel_m)
        for rpy_deg in ((0.0, 0.0, 0.0), (0.0, 3.0, 45.0), (10.0, -80.0, 0.0)):
            assert not differs(SMALL_FIELD, models()[0].replace(position=position, rpy_deg=rpy_deg))


def test_rays_that_a_lens_leaves_out_leave_holes_in_the_mesh() -> None:
    front = next(camera for camera in models() if missing_ray_count(camera) > 0)
    mesh = ray_mesh(unplaced(front))
    assert mesh is not None
    columns, rows = front.resolution
    assert len(mesh.border) != 2 * (rows + columns) - 4
    starts, ends = np.sort(mesh.border[:, 0]), np.sort(mesh.border[:, 1])
    assert np.array_equal(starts, ends)  # it is closed


def test_a_whole_mesh_has_the_outermost_rays_as_its_border() -> None:
    camera = bent(np.random.default_rng(1), LENSES[0], (40, 30)).replace(fx=1500.0, fy=1500.0)
    mesh = ray_mesh(unplaced(camera))
    assert mesh is not None and mesh.loose.size == 0
    outer = {v * 40 + u for v in range(30) for u in range(40) if v in (0, 29) or u in (0, 39)}
    assert set(mesh.border.ravel().tolist()) == outer and len(mesh.border) == len(outer)


def test_no_place_in_a_mesh_is_farther_from_a_ray_than_it_says() -> None:
    rng = np.random.default_rng(2)
    for camera in models():
        mesh, rows = ray_mesh(unplaced(camera)), lattice(camera).rows
        assert mesh is not None
        for _ in range(50):
            middle = rows[rng.integers(len(rows))]
            near = rows[np.argsort(-(rows @ middle))[:4]]
            place = rng.dirichlet(np.ones(3)) @ near[:3]
            assert np.linalg.norm(rows - place, axis=1).min() <= 2.0 * mesh.radius
        assert mesh.radius < 0.02
        if missing_ray_count(camera) == 0:
            steps = np.abs(np.diff(rows[: camera.resolution[0]], axis=0)).max(axis=0)
            assert (mesh.steps >= 0.5 * steps).all()


def test_the_outermost_directions_hold_all_rays() -> None:
    for camera in models():
        turned = camera.replace(rpy_deg=(3.0, -20.0, 100.0))
        every, outer = sensor_rays(turned).directions, outermost_directions(turned)
        assert np.array_equal((every > 0.0).all(axis=0), (outer > 0.0).all(axis=0))
        assert np.array_equal((every < 0.0).all(axis=0), (outer < 0.0).all(axis=0))


@pytest.mark.parametrize(
    "change",
    [
        {"range_m": (0.0, 2.0)},
        {"cast": (6, 4)},
        {"distortion": KannalaBrandt(), "fx": 350.0, "fy": 350.0, "cast": (160, 90)},
    ],
)
def test_ranges_sparse_rays_and_wide_fisheyes_are_walked_ray_by_ray(change: dict[str, object]) -> None:
    camera = bent(np.random.default_rng(3), LENSES[0], (120, 68)).replace(position=(0.1, 0.2, 1.0), **change)
    assert make_mesh(camera, Caster(SMALL_FIELD).rays(camera, "exact")) is None
    assert np.array_equal(seen_by(SMALL_FIELD, camera), seen_ray_by_ray(SMALL_FIELD, camera))


def test_a_camera_above_sees_through_a_whole_turn_of_bearings() -> None:
    """Straight down, the mesh holds the vertical, and its border goes all the way round it."""
    camera = models()[1].replace(position=(0.1, 0.2, 2.6), rpy_deg=(0.0, 90.0, 0.0))
    assert not differs(SMALL_FIELD, camera)
    directions = outermost_directions(camera)
    assert np.ptp(np.degrees(np.arctan2(directions[:, 1], directions[:, 0]))) > 300.0
    assert math.isclose(float(directions[:, 2].max()), -0.5, abs_tol=0.5)


def test_an_edge_of_the_mesh_that_passes_close_to_the_vertical() -> None:
    """Straight below, a part of the border that goes round a hole comes so close to the vertical that one edge turns by
    more than a quarter: beyond it there is nothing of the mesh."""
    field = field_at(0.10, (30.0, 3.0, 1.0), 1.0)
    front = next(camera for camera in models() if missing_ray_count(camera) > 0)
    turn = 123.82941505469843
    pose = {"position": (-9.1683, -0.55, 0.95), "rpy_deg": (-turn, turn, 0.0)}
    assert not differs(field, front.replace(**pose))


def test_voxels_above_level_64_are_seen_where_nothing_is_below_them() -> None:
    grid = grid_of(24, 20, 80, 0.25)
    high = np.zeros(grid.shape, np.bool_)
    high[:, :, 64:] = True
    field, camera = (
        field_of(grid, high),
        models()[0].replace(position=(0.1, 0.2, 14.3), rpy_deg=(1.0, -40.0, 8.0)),
    )
    assert seen_ray_by_ray(field, camera).any() and not differs(field, camera)
