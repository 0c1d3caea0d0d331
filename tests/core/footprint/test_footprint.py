"""Footprints by hand and against brute force: places on the ground projected one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.footprint import ground
from riglens.core.footprint.detail import focal_mm, pixels_on, px_per_deg, px_per_m
from riglens.core.footprint.ground import EN_62676_4, Band, Footprint, KeptFootprints, footprint
from riglens.core.footprint.overlap import bearings, overlaps
from riglens.core.rig.library import default_library
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, LinearAngles, Rig, Vehicle
from riglens.core.sensing.body_ends import barrier_of, listed_ends
from riglens.core.sensors.base import Sensor
from riglens.core.sensors.camera import project_px
from riglens.core.sensors.kind import Echo
from riglens.core.sensors.radar import Radar, RadarScan, in_field
from riglens.core.sensors.registry import kind_of
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.core.targets.detection_range import SIZES_M
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Barrier, solid_of

LEVEL = Camera(name="c", position=(1.0, 0.0, 2.0), image=(1000, 800), fx=500, fy=500, cx=500, cy=400)
PITCHED = LEVEL.replace(
    position=(0.3, -0.4, 1.6), rpy_deg=(12.0, 8.0, 70.0), image=(1600, 900), cx=700, cy=500
)
BROWN = LEVEL.replace(
    rpy_deg=(0.0, 10.0, -20.0), distortion=BrownConrady(k1=-0.2, k2=0.03, p1=0.002, p2=-0.001)
)
FISHEYE = Camera(
    name="f", position=(0.0, 1.0, 1.0), rpy_deg=(0.0, 35.0, 90.0), image=(1280, 960), fx=320, fy=320, cx=640,
    cy=480, distortion=KannalaBrandt(k1=-0.02, k2=0.001),
)  # fmt: skip
RADAR = Radar(
    name="r", position=(2.3, 0.3, 0.6), rpy_deg=(0.0, 2.0, 30.0),
    scans=(
        RadarScan(azimuth_deg=(-10.0, 10.0), elevation_deg=(-5.0, 5.0), range_m=150.0),
        RadarScan(azimuth_deg=(-50.0, 40.0), elevation_deg=(-8.0, 8.0), range_m=60.0),
    ),
)  # fmt: skip


def holds(patch: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return which places (n, 2) are inside an outline, by crossings of a ray to the right."""
    inside = np.zeros(len(places), bool)
    for (x0, y0), (x1, y1) in zip(patch, np.roll(patch, -1, axis=0), strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            crossed = x0 + (places[:, 1] - y0) * (x1 - x0) / (y1 - y0) > places[:, 0]
        inside ^= ((y0 <= places[:, 1]) != (y1 <= places[:, 1])) & crossed
    return inside


def level_at(found: Footprint, places: np.ndarray) -> np.ndarray:
    """Return which band holds each place, counted from the last, 0 for none; at most one does."""
    level = np.zeros(len(places), int)
    for number, band in enumerate(found.bands):
        for patch in band.patches:
            inside = holds(patch, places)
            assert not level[inside].any()
            level[inside] = len(found.bands) - number
    return level


def places_around(reach_m: float, count: int = 4000) -> np.ndarray:
    rng = np.random.default_rng(5)
    angle, radius = rng.uniform(-math.pi, math.pi, count), reach_m * rng.uniform(0.005, 1.0, count) ** 1.5
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def board_px_per_m(camera: Camera, local: np.ndarray) -> float:
    """Return the pixels that a board of 1 mm there is wide, turned to where it looks smallest."""
    size_m, middle = 1e-3, project_px(camera, local[None])[0]
    sight = local / np.linalg.norm(local) if camera.distortion is not None else np.array([1.0, 0.0, 0.0])
    side = np.cross(sight, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    turn = np.linspace(0.0, math.pi, 721)[:, None]
    ends = local + size_m * (np.cos(turn) * side + np.sin(turn) * np.cross(sight, side))
    return float(np.linalg.norm(project_px(camera, ends) - middle, axis=1).min() / size_m)


def brute_levels(camera: Camera, limits: tuple[float, ...], places: np.ndarray) -> np.ndarray:
    levels = []
    for x, y in places:
        local = (np.array([x, y, 0.0]) - camera.position) @ camera.pose.rotation()
        (pixel,) = project_px(camera, local[None])
        is_imaged = np.isfinite(pixel).all() and (pixel >= 0.0).all() and (pixel <= camera.image).all()
        levels.append(sum(board_px_per_m(camera, local) >= limit for limit in limits) if is_imaged else 0)
    return np.array(levels)


def test_bands_of_a_level_pinhole_begin_and_end_at_their_depths_exactly() -> None:
    found = footprint(LEVEL)
    assert [band.limit for band in found.bands] == list(EN_62676_4)
    from_m = 2.0 * 500 / 400  # where the last row meets the ground
    nears = [from_m, from_m, 4.0, 500 / 63]
    for band, near_m, far_m in zip(found.bands[1:], nears[1:], [4.0, 500 / 63, 20.0], strict=True):
        (patch,) = band.patches
        assert set((patch[:, 0] - 1.0).round(12)) == {round(near_m, 12), round(far_m, 12)}
        assert np.abs(patch[:, 1]) == pytest.approx(patch[:, 0] - 1.0)
        assert band.area_m2 == pytest.approx(far_m**2 - near_m**2)
    assert found.bands[0].patches == ()  # 250 px/m end at 2 m, nearer than the picture begins
    assert found.reach_m == pytest.approx((from_m, 20.0 * math.sqrt(2.0)))


@pytest.mark.parametrize(
    "camera", [LEVEL, PITCHED, BROWN, FISHEYE], ids=["level", "pitched", "brown", "fisheye"]
)
def test_every_place_lies_in_the_band_that_a_board_there_has(camera: Camera) -> None:
    limits = (200.0, 80.0, 30.0)
    places = places_around(30.0) + camera.position[:2]
    places = places[:1200]
    expected, found = brute_levels(camera, limits, places), level_at(footprint(camera, limits), places)
    assert set(expected) >= {0, 1, 2}
    right = float(np.mean(expected == found))
    assert right == 1.0 if camera.distortion is None else right > 0.99  # bearings 2° apart cut corners


@pytest.mark.parametrize("camera", [PITCHED, BROWN, FISHEYE])
def test_density_is_that_of_a_small_board(camera: Camera) -> None:
    local = np.array([[4.0, 1.0, -0.5], [2.0, -1.0, 0.3], [9.0, 0.0, 0.0], [1.5, 0.8, -0.9]])
    boards = [board_px_per_m(camera, place) for place in local]
    assert px_per_m(camera, local) == pytest.approx(boards, rel=2e-3)
    per_deg = px_per_m(camera, local) * np.linalg.norm(local, axis=1) * math.pi / 180
    assert px_per_deg(camera, local) == pytest.approx(per_deg)


def test_points_have_the_density_of_their_depth_and_none_out_of_the_picture() -> None:
    found = footprint(LEVEL)
    points = np.array([[6.0, 0.0, 0.0], [6.0, 3.0, 1.0], [-6.0, 0.0, 0.0], [6.0, 9.0, 0.0]])
    assert found.px_per_m(points)[:2] == pytest.approx([100.0, 100.0])
    assert np.isnan(found.px_per_m(points)[2:]).all()
    assert found.px_per_deg(points[1:2]) == pytest.approx(100.0 * math.sqrt(35.0) * math.pi / 180)


def test_what_the_body_hides_is_left_out_and_nothing_else() -> None:
    solid = solid_of(Vehicle())
    roof = LEVEL.replace(position=(0.0, 0.0, 1.8), rpy_deg=(0.0, 20.0, 0.0))
    free, cut = footprint(roof), footprint(roof, solid=solid)
    assert 0.5 < cut.area_m2 / free.area_m2 < 0.97
    places = places_around(12.0)
    offset = np.column_stack([places, np.full(len(places), -1.8)])
    distance = np.linalg.norm(offset, axis=1)
    is_hidden = listed_ends(roof, offset / distance[:, None], barrier_of(roof, solid)) < distance
    expected = np.where(is_hidden, 0, level_at(free, places))
    assert np.mean(level_at(cut, places) == expected) > 0.99


def test_a_sector_that_is_blocked_and_a_range_are_left_out() -> None:
    half = LEVEL.replace(blocked=({"azimuth_deg": (0.0, 180.0)},))
    near = LEVEL.replace(range_m=(0.0, 10.0))
    places = places_around(20.0) + np.array([1.0, 0.0])
    whole = level_at(footprint(LEVEL), places)
    left, away_m = places[:, 1] > 0.0, np.hypot(*(places - (1.0, 0.0)).T)
    assert np.mean(level_at(footprint(half), places) == np.where(left, 0, whole)) > 0.995
    beyond = np.hypot(away_m, 2.0) > 10.0
    assert np.mean(level_at(footprint(near), places) == np.where(beyond, 0, whole)) > 0.995


def test_a_radar_reaches_classes_as_far_as_its_scans_do() -> None:
    found = footprint(RADAR)
    assert [band.title for band in found.bands] == ["pedestrian", "bicycle", "car"]
    places = places_around(160.0) + RADAR.position[:2]
    expected = np.zeros(len(places), int)
    for cls, size in SIZES_M.items():
        seen = np.zeros(len(places), bool)
        for height in np.linspace(0.0, size[2], 60):
            local = (np.column_stack([places, np.full(len(places), height)]) - RADAR.position) @ (
                RADAR.pose.rotation()
            )
            seen |= in_field(RADAR, local, np.linalg.norm(local, axis=1), Echo(cls, min(size[:2])))
        expected += seen
    assert set(expected) == {0, 1, 2, 3}
    assert np.mean(level_at(found, places) == expected) > 0.99


def slow_levels(sensor: Sensor, echoes: Sequence[Echo], barrier: Barrier | None) -> Callable[..., np.ndarray]:
    """Return what `_wave_levels` returns, class by class and height by height."""
    reaches = kind_of(sensor).in_field
    assert reaches is not None

    def levels(places: np.ndarray) -> np.ndarray:
        found, within = np.zeros(len(places), int), np.ones(len(places), bool)
        for echo in reversed(echoes):
            seen, top_m = np.zeros(len(places), bool), SIZES_M[echo.cls][2]
            for height_m in (min(sensor.position[2], top_m), *np.linspace(0.0, top_m, 5)):
                offset = np.column_stack([places, np.full(len(places), height_m)]) - sensor.position
                local, distance = offset @ sensor.pose.rotation(), np.linalg.norm(offset, axis=1)
                inside = reaches(sensor, local, distance, echo) & ~sensor.blocked_rays(local)
                inside &= distance <= sensor.range_m[1]
                if barrier is not None:
                    inside &= ~(listed_ends(sensor, offset / distance[:, None], barrier) < distance)
                seen |= inside
            within &= seen
            found += within
        return found

    return levels


SIDE = Ultrasonic(name="u", position=(-0.3, 0.9, 0.5), rpy_deg=(5.0, -20.0, 70.0))


@pytest.mark.parametrize(
    "sensor",
    [
        RADAR,
        SIDE.replace(range_m=(0.0, 3.0), blocked=({"azimuth_deg": (0.0, 20.0)},)),
        SIDE.replace(rpy_deg=(0.0, 85.0, 10.0)),
        SIDE.replace(azimuth_deg=(-120.0, 100.0)),
    ],
    ids=["radar", "tilted", "looks down", "wide"],
)
@pytest.mark.parametrize("car", [None, Vehicle()], ids=["free", "car"])
def test_skipped_bearings_and_shared_work_change_no_bit(
    sensor: Sensor, car: Vehicle | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    solid = None if car is None else solid_of(car)
    quick = footprint(sensor, solid=solid, step_deg=5.0)
    monkeypatch.setattr(ground, "_is_faced", lambda _, along: np.ones(len(along), bool))
    monkeypatch.setattr(ground, "_wave_levels", slow_levels)
    slow = footprint(sensor, solid=solid, step_deg=5.0)
    assert slow.area_m2 > 0.0
    for one, other in zip(quick.bands, slow.bands, strict=True):
        assert [patch.tobytes() for patch in one.patches] == [patch.tobytes() for patch in other.patches]


def test_bearings_out_of_view_are_skipped() -> None:
    along = np.stack([np.cos(np.radians([70, 10, -110])), np.sin(np.radians([70, 10, -110]))], axis=1)
    assert ground._is_faced(SIDE, along).tolist() == [True, True, False]


def test_an_ultrasonic_sensor_has_a_sector() -> None:
    sensor = Ultrasonic(name="u", position=(2.3, 0.0, 0.5), azimuth_deg=(-45.0, 45.0))
    reach = footprint(sensor).reach_m
    assert reach is not None and reach[1] == pytest.approx(sensor.wall_range_m, rel=0.01)
    assert footprint(sensor).area_m2 == pytest.approx(math.pi / 4 * sensor.wall_range_m**2, rel=0.03)


def test_a_sensor_below_the_ground_or_that_looks_up_covers_none() -> None:
    for camera in (LEVEL.replace(position=(0, 0, -1)), LEVEL.replace(rpy_deg=(0.0, -60.0, 0.0))):
        assert footprint(camera).reach_m is None
    assert footprint(FISHEYE.replace(position=(0, 0, -1))).area_m2 == 0.0


def test_a_fisheye_that_looks_straight_down_sees_all_round() -> None:
    down = FISHEYE.replace(position=(0.0, 0.0, 2.0), rpy_deg=(0.0, 90.0, 0.0))
    angles = np.linspace(-math.pi, math.pi, 60)
    places = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    levels = level_at(footprint(down, (50.0,)), places)
    assert (levels == 1).all()


def test_wrong_limits_and_sensors_are_refused() -> None:
    for limits in ((), (25.0, 63.0), (25.0, 25.0), (math.inf,), (0.0,), (math.nan,)):
        with pytest.raises(InputError, match="px_per_m"):
            footprint(LEVEL, limits)
    lidar = Lidar(
        name="l",
        position=(0, 0, 2),
        elevations_deg=(0.0,),
        azimuths_deg=LinearAngles(from_=0, to=90, count=4),
    )
    with pytest.raises(InputError, match="LiDARs have no footprint"):
        footprint(lidar)
    with pytest.raises(InputError, match="no pixels"):
        footprint(RADAR).px_per_m(np.zeros((1, 3)))


def test_objects_on_the_axis_have_the_pixels_of_a_pinhole() -> None:
    near, far = pixels_on(LEVEL, "pedestrian", (10.0, 50.0))
    assert (near.width_px, near.height_px) == pytest.approx((30.0, 86.0))
    assert far.height_px == pytest.approx(86.0 / 5)
    (bent,) = pixels_on(FISHEYE, "car", (10.0,))
    half = FISHEYE.distortion
    assert isinstance(half, KannalaBrandt)
    theta = math.atan(SIZES_M["car"][2] / 2 / 10)
    assert bent.height_px == pytest.approx(2 * 320 * (theta + half.k1 * theta**3 + half.k2 * theta**5))


def test_the_lens_has_millimetres_where_the_library_knows_the_pixel() -> None:
    entry = next(one for one in default_library().entries("camera") if one.pixel_um is not None)
    camera = entry.example
    assert isinstance(camera, Camera) and entry.pixel_um is not None
    assert focal_mm(camera) == camera.intrinsics_px()[0] * entry.pixel_um / 1000.0
    assert focal_mm(LEVEL) is None


def turned(name: str, yaw_deg: float, hfov_deg: float = 90.0) -> Camera:
    return Camera(
        name=name, position=(0, 0, 1), rpy_deg=(0.0, 0.0, yaw_deg), image=(800, 800), hfov_deg=hfov_deg
    )


def test_neighbours_share_what_their_views_have_in_common() -> None:
    four = [turned(str(yaw), yaw, 100.0) for yaw in (0.0, 90.0, 180.0, -90.0)]
    assert [one.overlap_deg for one in overlaps(four)] == pytest.approx([10.0] * 4)
    three = [turned("a", 0.0), turned("b", 80.0), turned("c", 200.0)]
    shared = {(one.right, one.left): one.overlap_deg for one in overlaps(three)}
    assert shared == pytest.approx({("a", "b"): 10.0, ("b", "c"): -30.0, ("c", "a"): -70.0})
    (pair,) = overlaps([turned("a", 0.0), turned("b", 60.0)])
    assert (pair.right, pair.left, pair.overlap_deg) == ("a", "b", pytest.approx(30.0))
    (within,) = overlaps([turned("wide", 0.0, 120.0), turned("narrow", 10.0, 30.0)])
    assert within.overlap_deg == pytest.approx(30.0)
    assert overlaps([turned("a", 0.0)]) == ()


def test_bearings_run_from_right_to_left_across_the_rear() -> None:
    rear = bearings(turned("rear", 180.0))
    assert rear is not None
    assert (rear.from_deg, rear.to_deg) == pytest.approx((135.0, 225.0))
    down = LEVEL.replace(rpy_deg=(0.0, 80.0, 0.0))
    assert bearings(down) is None


def test_the_area_of_a_band_is_that_of_its_outlines() -> None:
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]])
    assert Band("x", 1.0, (square, square + 10.0)).area_m2 == pytest.approx(12.0)


def test_footprints_that_were_asked_for_last_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("riglens.core.footprint.ground._MOST_KEPT", 2)
    kept, (a, b, c) = KeptFootprints(), (turned("x", yaw) for yaw in (0.0, 10.0, 20.0))
    limits = (50.0,)
    assert kept.known(a, limits, None) is None
    first = kept.found(a, limits, None)
    for camera in (b, a, c):
        kept.found(camera, limits, None)
    assert [kept.known(camera, limits, None) is not None for camera in (a, b, c)] == [True, False, True]
    assert kept.known(a.replace(name="y"), limits, None) is first, "names decide nothing"
    assert kept.known(a, (60.0,), None) is None


def test_footprints_beside_housings_are_known_without_waiting_for_a_table_of_rays() -> None:
    kept, limits = KeptFootprints(), (50.0,)
    bent = FISHEYE.replace(fx=321.0)
    rig = Rig(sensors=(bent, turned("other", 0.0).replace(position=(0.0, 1.4, 0.8))), housings="blocks")
    assert kept.known(bent, limits, car_of(rig)) is None
    found = kept.found(bent, limits, car_of(rig))
    assert kept.known(bent, limits, car_of(rig)) is found
    assert found.area_m2 == footprint(bent, limits, car_of(rig)).area_m2
    nearer = rig.with_sensor("other", rig.sensor("other").replace(position=(0.0, 1.3, 0.8)))
    assert kept.known(bent, limits, car_of(nearer)) is None


def test_coarse_footprints_follow_fewer_bearings() -> None:
    bent = LEVEL.replace(range_m=(0.0, 30.0))
    coarse, fine = KeptFootprints(step_deg=8.0).found(bent, EN_62676_4, None), footprint(bent)
    assert sum(len(patch) for band in coarse.bands for patch in band.patches) < 0.5 * sum(
        len(patch) for band in fine.bands for patch in band.patches
    )
