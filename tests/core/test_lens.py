"""Lens distortion: OpenCV's equations, their inverse, and where a lens stops having pixels or directions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt
from riglens.core.sensing.rays import local_directions, missing_ray_count, sensor_rays
from riglens.core.sensors.camera import cast_px, pixel_directions, project_px
from riglens.core.sensors.lens import distorted, undistorted
from tests.core.builders import camera

WAYMO = BrownConrady(k1=0.04239, k2=-0.34165, p1=0.0019, p2=-0.0004)
RATIONAL = BrownConrady(k1=8.5, k2=3.2, p1=1e-4, p2=-2e-4, k3=0.1, k4=8.9, k5=6.1, k6=0.9)
BARREL = BrownConrady(k1=-0.35, k2=0.1, p1=1e-3, p2=1e-3)
FISHEYE = KannalaBrandt(k1=0.02, k2=-0.006, k3=0.001, k4=-2e-4)
LENSES = {"waymo": WAYMO, "rational": RATIONAL, "barrel": BARREL, "fisheye": FISHEYE}


def behind(lens: BrownConrady | KannalaBrandt | None, focal_px: float = 900.0, **changes: object) -> Camera:
    """A 1280 x 960 camera with that lens."""
    fields = {"fx": focal_px, "fy": 1.01 * focal_px, "cx": 633.4, "cy": 488.1} | changes
    size = {"image": (1280, 960), "cast": (160, 120)}
    return Camera(name="C", position=(0.0, 0.0, 1.0), **(size | fields), distortion=lens)


def opencv_pixel(camera: Camera, x: float, y: float, z: float) -> tuple[float, float]:
    """OpenCV's documentation written out for one point in optical axes (calib3d, and calib3d's fisheye)."""
    lens = camera.distortion
    a, b = x / z, y / z
    r = math.hypot(a, b)
    if isinstance(lens, KannalaBrandt):
        theta = math.atan(r) if z > 0 else math.pi - math.atan(-r)
        bent = theta * (1 + lens.k1 * theta**2 + lens.k2 * theta**4 + lens.k3 * theta**6 + lens.k4 * theta**8)
        a, b = bent / math.hypot(x, y) * x, bent / math.hypot(x, y) * y
    else:
        growth = (1 + lens.k1 * r**2 + lens.k2 * r**4 + lens.k3 * r**6) / (
            1 + lens.k4 * r**2 + lens.k5 * r**4 + lens.k6 * r**6
        )
        a, b = (
            a * growth + 2 * lens.p1 * a * b + lens.p2 * (r**2 + 2 * a**2),
            b * growth + lens.p1 * (r**2 + 2 * b**2) + 2 * lens.p2 * a * b,
        )
    return camera.fx * a + camera.cx, camera.fy * b + camera.cy


@pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES)
def test_points_fall_on_the_pixels_of_the_published_equations(lens) -> None:
    sensor, rng = behind(lens), np.random.default_rng(1)
    for _ in range(50):
        x, y, z = rng.uniform(-0.4, 0.4), rng.uniform(-0.3, 0.3), rng.uniform(0.5, 2.0)
        found = project_px(sensor, np.array([[z, -x, -y]]))[0]
        assert found == pytest.approx(opencv_pixel(sensor, x, y, z), abs=1e-9)


def test_a_fisheye_sees_what_is_behind_it_where_the_published_equations_say() -> None:
    sensor = behind(KannalaBrandt(k1=-0.01), focal_px=200.0)
    x, y, z = 1.0, 0.5, -0.3
    found = project_px(sensor, np.array([[z, -x, -y]]))[0]
    theta = math.acos(z / math.sqrt(x * x + y * y + z * z))
    radius = 200.0 * theta * (1 - 0.01 * theta**2)
    assert found == pytest.approx(
        [633.4 + radius * x / math.hypot(x, y), 488.1 + 1.01 * radius * y / math.hypot(x, y)]
    )


@pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES)
@pytest.mark.parametrize("focal_px", [300.0, 900.0])
def test_every_pixel_with_a_direction_is_hit_again_by_it(lens, focal_px: float) -> None:
    sensor = behind(lens, focal_px)
    pixels = cast_px(sensor, np.arange(sensor.ray_count))
    directions = pixel_directions(sensor, pixels)
    there = np.isfinite(directions[:, 0])
    assert there.mean() > 0.1
    assert np.abs(project_px(sensor, directions[there]) - pixels[there]).max() < 1e-12
    assert np.abs(np.linalg.norm(directions[there], axis=1) - 1.0).max() < 1e-15


def test_a_rational_lens_with_a_pole_keeps_its_rays() -> None:
    """Its limit was rounded to behind the pole, and no pixel had a direction."""
    for k1, k4, k6 in ((0.1, 0.02, -0.003), (0.05, -0.1, 0.0), (-0.01, 0.1, -0.02)):
        sensor = behind(BrownConrady(k1=k1, k4=k4, k6=k6))
        pixels = cast_px(sensor, np.arange(sensor.ray_count))
        directions = pixel_directions(sensor, pixels)
        assert np.isfinite(directions).all()
        assert np.abs(project_px(sensor, directions) - pixels).max() < 1e-9


def test_a_lens_far_out_of_its_centre_keeps_its_rays() -> None:
    """Newton's steps lead away from many of its pixels unless they are halved again and again."""
    lens = BrownConrady(k1=0.2, k2=0.05, k3=0.04, p1=-0.11, p2=0.25)
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-1.2, 1.2, 21), np.linspace(-1.2, 1.2, 21)))
    np.testing.assert_allclose(distorted(lens, undistorted(lens, x, y)), np.stack([x, y], axis=1), atol=1e-11)


@settings(max_examples=60, deadline=None)
@given(
    k=st.tuples(*[st.floats(-0.4, 0.4)] * 3),
    p=st.tuples(*[st.floats(-0.003, 0.003)] * 2),
    is_fisheye=st.booleans(),
)
def test_pixels_and_directions_are_each_others_inverse(k, p, is_fisheye: bool) -> None:
    brown = BrownConrady(k1=k[0], k2=k[1], k3=k[2], p1=p[0], p2=p[1])
    sensor = behind(KannalaBrandt(k1=k[0], k2=k[1], k3=k[2]) if is_fisheye else brown, 400.0, cast=(23, 17))
    pixels = cast_px(sensor, np.arange(sensor.ray_count))
    directions = pixel_directions(sensor, pixels)
    there = np.isfinite(directions[:, 0])
    again = project_px(sensor, directions[there])
    assert np.nanmax(np.abs(again - pixels[there]), initial=0.0) < 1e-10
    assert np.isnan(again).any(axis=1).sum() <= 2  # on the very edge of what the lens can do


@settings(max_examples=100, deadline=None)
@given(k=st.tuples(*[st.floats(-1e9, 1e9)] * 8), is_fisheye=st.booleans())
def test_absurd_coefficients_give_unit_directions_or_none(k, is_fisheye: bool) -> None:
    names = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
    brown = BrownConrady(**dict(zip(names, k, strict=True)))
    fisheye = KannalaBrandt(**dict(zip(("k1", "k2", "k3", "k4"), k[:4], strict=True)))
    pixels = cast_px(behind(None, cast=(9, 7)), np.arange(63))
    x, y = ((pixels - [633.4, 488.1]) / 900.0).T
    directions = undistorted(fisheye if is_fisheye else brown, x, y)
    there = np.isfinite(directions).all(axis=1)
    assert np.isnan(directions[~there]).all()
    assert np.abs(np.linalg.norm(directions[there], axis=1) - 1.0).max(initial=0.0) < 1e-12


def test_no_distortion_gives_the_rays_of_a_pinhole_bit_for_bit() -> None:
    assert np.array_equal(
        sensor_rays(behind(BrownConrady())).directions, sensor_rays(behind(None)).directions
    )


def test_a_fisheye_without_coefficients_is_equidistant() -> None:
    sensor = behind(KannalaBrandt(), focal_px=200.0, cx=640.0, cy=480.0, fy=200.0)
    right = pixel_directions(sensor, np.array([[640.0 + 200.0 * math.radians(100.0), 480.0]]))[0]
    assert right == pytest.approx([math.cos(math.radians(100)), -math.sin(math.radians(100)), 0.0])
    ahead, left_behind = project_px(sensor, np.array([[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0]]))
    assert ahead.tolist() == [640.0, 480.0]
    assert left_behind == pytest.approx([640.0 - 200.0 * math.radians(135.0), 480.0])


def test_pixels_beyond_the_fold_of_a_lens_have_no_ray_and_are_counted() -> None:
    fold = math.sqrt(1 / (3 * 0.35))
    edge_px = 300.0 * fold * (1 - 0.35 * fold**2)
    sensor = behind(BrownConrady(k1=-0.35), focal_px=300.0, fy=300.0)
    pixels = cast_px(sensor, np.arange(sensor.ray_count))
    inside = np.hypot(pixels[:, 0] - 633.4, pixels[:, 1] - 488.1) < edge_px
    assert np.array_equal(np.isfinite(local_directions(sensor, np.arange(19200))[:, 0]), inside)
    assert missing_ray_count(sensor) == (~inside).sum() > 1_000
    assert len(sensor_rays(sensor).directions) == inside.sum()


@pytest.mark.parametrize("lens", [KannalaBrandt(k1=-0.05), BrownConrady(k1=-0.35)])
def test_a_lens_without_a_ray_on_the_image_is_refused_with_a_hint_at_units(lens) -> None:
    """A focal length in millimetres leaves a few rays, one in metres none."""
    assert 0 < len(sensor_rays(behind(lens, 1.4, cast=None, cx=640.5, cy=480.5)).directions) < 30
    with pytest.raises(
        ValidationError, match=r"fx 0.0014 and fy 0.001414 px .* no ray .* pixels: divide milli"
    ):
        behind(lens, 0.0014)
    assert len(sensor_rays(behind(None, 0.0014)).directions) == 160 * 120


def test_a_point_beyond_the_fold_falls_on_no_pixel_though_the_equations_would_place_it() -> None:
    sensor = behind(BrownConrady(k1=-0.35), focal_px=300.0)
    near, far = project_px(sensor, np.array([[1.0, -0.9, 0.0], [1.0, -1.2, 0.0]]))
    assert np.isfinite(near).all() and np.isnan(far).all()
    assert 0 < opencv_pixel(sensor, 1.2, 0.0, 1.0)[0] < 1280


def test_a_pinhole_sees_nothing_behind_it() -> None:
    ahead, behind_it = project_px(
        camera((0, 0, 0), hfov_deg=90.0), np.array([[2.0, 1.0, 0.0], [-2.0, 1.0, 0.0]])
    )
    assert ahead == pytest.approx([400.0, 450.0]) and np.isnan(behind_it).all()


@pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES)
def test_some_rays_by_number_are_those_of_the_whole_lattice_bit_for_bit(lens) -> None:
    sensor = behind(lens, 500.0)
    every = local_directions(sensor, np.arange(sensor.ray_count))
    some = np.random.default_rng(2).permutation(sensor.ray_count)[:777]
    assert np.array_equal(local_directions(sensor, some), every[some], equal_nan=True)
    cast = sensor_rays(sensor.replace(rpy_deg=(0.0, 0.0, 0.0))).directions
    assert np.array_equal(cast, every[np.isfinite(every[:, 0])])
