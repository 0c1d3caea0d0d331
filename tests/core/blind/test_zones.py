"""Blind zones: closed forms of rings and shadows, and a plain search through every voxel."""

import numpy as np
import pytest

from riglens.core.blind.outline import Outline
from riglens.core.blind.zones import (
    BlindEngine,
    BlindMap,
    BlindSettings,
    Ground,
    by_names,
    grid_around,
    seen_by,
    unseen_by,
    whole_field,
)
from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.scene.columns import unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.sectors import SECTORS, sector_of
from tests.core.review.scenes import BOX, box_mesh, camera, dense_lidar, random_rig

SINGLE = BlindSettings(width_m=0.0, body="ignored", within_m=10.0)


def by_hand(levels: dict[tuple[float, float], int]) -> BlindMap:
    """A map in voxels of 0.5 m around a car of 1.5 by 1.5 m: levels of some columns by their centres, 0 elsewhere."""
    settings, outline = BlindSettings(0.5, 0.0, within_m=2.0), Outline(-0.75, 0.75, -0.75, 0.75)
    grid = grid_around(outline, settings)
    ground = Ground.of(grid, outline, settings.bands_m)
    found = np.zeros((1, 3, *grid.shape[:2]), np.uint16)
    for (x, y), level in levels.items():
        found[:, :, np.searchsorted(ground.x_m, x - 0.1), np.searchsorted(ground.y_m, y - 0.1)] = level
    return BlindMap(Rig(), settings, grid, ground, ("any",), found)


def test_an_object_as_tall_as_the_lowest_voxel_reaches_is_seen() -> None:
    found = by_hand({(1.25, 0.25): 1})
    assert not found.unseen(1.0).any() and found.unseen(0.99).sum() == 1


@pytest.mark.parametrize(
    ("x", "bands"),
    [(0.75, [0, 0]), (1.25, [0.25, 0]), (1.75, [0.25, 0]), (2.25, [0, 0.25]), (2.75, [0, 0.25])],
)
def test_a_band_ends_with_its_outer_edge_and_what_touches_the_car_does_not_count(
    x: float, bands: list[float]
) -> None:
    assert by_hand({(x, 0.25): 3}).area_m2(1.0)[SECTORS.index("front")].tolist() == bands


def test_the_largest_of_several_holes_is_told_with_its_middle_and_its_nearest_edge() -> None:
    first, second = [(-1.75, 0.25), (-1.25, 0.25)], [(1.25, 0.25), (1.75, 0.25), (2.25, 0.25)]
    hole = by_hand(dict.fromkeys([*first, *second, (0.25, 2.25)], 2)).largest_hole(1.0)
    assert hole is not None
    assert (hole.area_m2, hole.x_m, hole.y_m, hole.nearest_m) == pytest.approx((0.75, 1.75, 0.25, 0.5))


def along_x(found: BlindMap) -> tuple[np.ndarray, np.ndarray]:
    """Places ahead of the car beside the middle plane, and L_1 there."""
    row = int(np.argmin(np.abs(found.ground.y_m)))
    ahead = found.ground.counts[:, row] & (found.ground.x_m > 0.0)
    return found.ground.x_m[ahead], found.lowest_m()[ahead, row]


def test_a_beam_meets_the_ground_at_height_over_tangent_and_rises_towards_the_car() -> None:
    h, down = 1.5, np.radians(10.0)
    beam = dense_lidar(h, turns=3600).replace(elevations_deg=(-10.0,))
    rig = Rig(vehicle=Vehicle(length=2.0, width=2.0), sensors=(beam,))
    found = BlindEngine(rig.vehicle, SINGLE).evaluate(rig)
    x, lowest = along_x(found)
    ring = h / np.tan(down)
    z = h - x * np.tan(down)
    edge = found.grid.voxel_m
    on_way = (x > 1.2) & (x < ring - edge)
    assert np.all(lowest[on_way] >= z[on_way] - edge * np.tan(down))  # never told lower than the beam is
    assert np.all(lowest[on_way] <= z[on_way] + 2.0 * edge)
    assert np.all(np.isinf(lowest[x > ring + edge])) and ring == pytest.approx(8.507, abs=1e-3)


def test_the_roof_edge_throws_a_shadow_of_the_known_length() -> None:
    h_s, h_roof, dx = 2.0, 1.5, 2.0
    rig = Rig(vehicle=BOX, sensors=(dense_lidar(h_s),))
    settings = BlindSettings(width_m=0.0, within_m=8.0)
    found = BlindEngine(rig.vehicle, settings).evaluate(rig)
    x, lowest = along_x(found)
    shadow = h_s * dx / (h_s - h_roof)
    assert shadow == 8.0
    over_roof = np.maximum(h_s - x * (h_s - h_roof) / dx, 0.0)
    assert np.all(lowest >= over_roof - 1e-9)
    assert np.all(lowest[x > 2.3] <= over_roof[x > 2.3] + 2.0 * found.grid.voxel_m)
    free = BlindEngine(rig.vehicle, BlindSettings(width_m=0.0, within_m=8.0, body="ignored"))
    assert np.all(along_x(free.evaluate(rig))[1] <= 0.1 + 1e-9)


@pytest.mark.parametrize(("voxel_m", "width_m"), [(0.5, 0.0), (0.25, 0.6), (0.02, 0.1)])
def test_l_k_is_what_a_search_through_all_voxels_finds(voxel_m: float, width_m: float) -> None:
    rng = np.random.default_rng(7)
    rig = random_rig(rng).replace(vehicle=Vehicle(length=0.5, width=0.5, height=0.5))
    settings = BlindSettings(voxel_m, width_m, "ignored", within_m=1.0 if voxel_m < 0.1 else 6.0)
    engine = BlindEngine(rig.vehicle, settings)
    found = engine.evaluate(rig)
    nx, ny, nz = found.grid.shape
    assert nz == round(2.0 / voxel_m) and (nz > 64) == (voxel_m == 0.02)
    inside = Engine(whole_field(found.grid))
    inside.evaluate(rig, MetricSettings(), False)
    for by in by_names():
        lows = []
        for sensor in rig.sensors:
            if by in ("any", sensor.kind):
                seen = unpack(found.grid, np.array(inside.marks_of(sensor, "exact")))
                lowest = np.where(seen.any(axis=2), seen.argmax(axis=2) + 1.0, np.inf) * voxel_m
                lows.append(widened(lowest, width_m / 2.0 / voxel_m))
        if not lows:
            assert np.isinf(found.lowest_m(by, 1)).all()
            continue
        ordered = np.sort(np.stack(lows), axis=0)
        for k in (1, 2, 3):
            if k > len(ordered):
                assert np.isinf(found.lowest_m(by, k)).all()
                continue
            np.testing.assert_allclose(found.lowest_m(by, k), ordered[k - 1])
    for h in (0.3, 1.0):
        where = found.unseen(h)
        assert found.area_m2(h).sum() == pytest.approx(where.sum() * voxel_m**2)
    assert (nx, ny) == found.ground.counts.shape


def widened(lowest: np.ndarray, radius: float) -> np.ndarray:
    """The lowest of all columns whose centres lie within a radius."""
    reach = int(radius) + 1
    steps = range(-reach, reach + 1)
    around = np.pad(lowest, reach, constant_values=np.inf)
    return np.minimum.reduce(
        [
            np.roll(around, (x, y), (0, 1))[reach:-reach, reach:-reach]
            for x in steps
            for y in steps
            if np.hypot(x, y) <= radius + 1e-9
        ]
    )


def test_any_number_of_threads_and_any_way_to_a_rig_gives_the_same_map() -> None:
    rig = random_rig(np.random.default_rng(1), 5)
    settings = BlindSettings(0.25, within_m=5.0)
    first = BlindEngine(rig.vehicle, settings, threads=1).evaluate(rig)
    moved = BlindEngine(rig.vehicle, settings, threads=2)
    moved.evaluate(rig.with_sensor("s0", rig.sensors[0].replace(position=(1.0, 1.0, 2.0))))
    assert np.array_equal(first.levels, moved.evaluate(rig).levels)
    off = rig.with_sensor("s1", rig.sensors[1].replace(enabled=False))
    fewer = rig.replace(sensors=tuple(s for s in rig.sensors if s.name != "s1"))
    assert np.array_equal(
        moved.evaluate(off).levels, BlindEngine(rig.vehicle, settings).evaluate(fewer).levels
    )


def test_a_drag_leaves_the_map_that_is_made_from_scratch_at_each_step() -> None:
    """Sensors move, are switched off and on, copied and taken away; what stays keeps the levels found before."""
    rng = np.random.default_rng(5)
    settings, rig = BlindSettings(0.25, within_m=4.0), random_rig(rng, 4)
    engine = BlindEngine(rig.vehicle, settings)
    for step in range(8):
        name = f"s{1 + step % 3}"
        sensor = rig.sensor(name)
        if step == 5:
            rig = rig.replace(sensors=(*rig.sensors[1:], sensor.replace(name="twin", enabled=True)))
        elif step == 6:
            rig = rig.replace(sensors=rig.sensors[1:])
        else:
            place = tuple(rng.uniform([-2.0, -1.0, 0.5], [2.0, 1.0, 2.5]).tolist())
            rig = rig.with_sensor(name, sensor.replace(position=place, enabled=step != 3))
        fresh = BlindEngine(rig.vehicle, settings).evaluate(rig)
        np.testing.assert_array_equal(engine.evaluate(rig).levels, fresh.levels)


def test_what_cameras_are_set_to_cast_moves_no_blind_zone() -> None:
    vehicle, eye = Vehicle(length=2.0, width=2.0), camera((0.9, 0.0, 1.0), 0.0, 20.0)
    engine = BlindEngine(vehicle, BlindSettings(0.1, 0.0, within_m=5.0))
    native, sparse, whole = (
        engine.evaluate(Rig(vehicle=vehicle, sensors=(eye.replace(cast=cast),)))
        for cast in (None, (8, 6), eye.image)
    )
    assert np.array_equal(native.levels, sparse.levels) and np.array_equal(native.levels, whole.levels)
    assert 0.0 < native.area_m2(0.15).sum() < native.ground_m2().sum()


def test_objects_in_the_last_ring_are_looked_for_in_all_their_width() -> None:
    rig = random_rig(np.random.default_rng(3)).replace(vehicle=Vehicle(length=2.0, width=1.0))
    near, far = (
        BlindEngine(rig.vehicle, BlindSettings(0.1, 0.8, "ignored", within_m)).evaluate(rig)
        for within_m in (3.0, 6.0)
    )
    assert np.array_equal(
        near.lowest_m()[near.ground.counts],
        far.lowest_m()[far.ground.counts & (far.ground.distance_m <= 3.0)],
    )


def test_words_on_who_sees_suit_their_number() -> None:
    assert [seen_by("any", k) for k in (1, 2)] == ["1 sensor", "2 sensors"]
    assert unseen_by("camera", 1) == "unseen by any camera"
    assert unseen_by("lidar", 2) == "seen by fewer than 2 LiDARs"


def test_sectors_and_bands_share_out_the_ground_beside_the_car_and_a_rig_without_sensors_sees_none() -> None:
    vehicle = Vehicle(length=4.6, width=1.9)
    empty = BlindEngine(vehicle, BlindSettings(0.1, within_m=5.0)).evaluate(Rig(vehicle=vehicle))
    around = (4.6 + 1.9) * 2 * 5.0 + np.pi * 25.0
    assert empty.ground_m2().sum() == pytest.approx(around, rel=0.01)
    assert np.array_equal(empty.area_m2(1.8), empty.ground_m2())
    hole = empty.largest_hole(0.3)
    assert hole is not None and hole.area_m2 == pytest.approx(around, rel=0.01) and hole.nearest_m < 0.1
    places = sector_of(
        np.array([9.0, 9.0, 0.0, -9.0, -9.0, -9.0, 0.0, 9.0]), np.array([0, 9, 9, 9, 0, -9, -9, -9.0])
    )
    assert [SECTORS[place] for place in places] == list(SECTORS)
    turn = np.radians([20.0, 25.0, -20.0, 180.0 - 20.0])
    beside = sector_of(np.cos(turn), np.sin(turn))
    assert [SECTORS[place] for place in beside] == ["front", "front-left", "front", "rear"]


def test_the_largest_hole_is_the_larger_of_two() -> None:
    rig = Rig(
        vehicle=Vehicle(length=2.0, width=2.0),
        sensors=(camera((1.0, 0.0, 1.0)), camera((-1.0, 0.0, 1.0), 180.0)),
    )
    found = BlindEngine(rig.vehicle, BlindSettings(0.1, 0.3, "ignored", 5.0)).evaluate(rig)
    hole = found.largest_hole(1.15)
    areas = found.area_m2(1.15)
    assert hole is not None and 0.0 < hole.area_m2 <= areas.sum() and found.largest_hole(2.5) is not None
    left, right = areas[SECTORS.index("left")].sum(), areas[SECTORS.index("right")].sum()
    assert left == pytest.approx(right, rel=0.05) and areas[SECTORS.index("front")].sum() < 0.5 * left


def test_the_outline_of_a_mesh_is_what_it_spans_and_grids_hold_whole_voxels() -> None:
    assert Outline.of(BOX.with_body_mesh(box_mesh(5.0, 3.0))) == Outline(-2.5, 2.5, -1.5, 1.5)
    grid = BlindEngine(BOX, BlindSettings(0.3)).grid
    assert isinstance(grid, VoxelGrid) and grid.roi_m[0] >= 44.0
