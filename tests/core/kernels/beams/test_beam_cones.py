"""A LiDAR with a sector of close rays beside a grid of 4 x 4 x 4 voxels: what core and sheets call certain, what is
tested, and what is left to the ray walk, against each ray and each voxel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.engine import sheets as engine
from riglens.core.engine.sheets import Sheets, make_sheets
from riglens.core.kernels.beams import beam_cones, cones, crossings, tiles
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.rays.walk import Ray, hits_cell
from riglens.core.kernels.runtime.codes import LISTED
from riglens.core.kernels.voxels import bits
from riglens.core.rig.model import Lidar
from riglens.core.sensing.rays import lattice
from tests.core.kernels.tiny import BOX, ENDLESS, SHAPE, SIDE, Voxel, no_voxels, voxels_of

EVERYTHING = np.full(SIDE * SIDE, 0b1111, np.uint64)
HIGH_UP = np.full(SIDE * SIDE, 1 << 63, np.uint64)
"""Something worth a test in every column, but not where any beam is."""
GRID = [(x, y, z) for x in range(SIDE) for y in range(SIDE) for z in range(SIDE)]
BESIDE = (-9.3, 1.7, 2.2)
SECTOR = tuple(range(-18, 19))
BEAMS = (-9.0, -7.0, -6.0, -5.0, 1.0, 8.0)


def lidar(
    place: Sequence[float] = BESIDE,
    rpy_deg: Sequence[float] = (0.0, 0.0, 0.0),
    beams: Sequence[float] = BEAMS,
    azimuths: Sequence[float] = SECTOR,
    offsets: Sequence[float] | None = None,
) -> Lidar:
    """A LiDAR; its place is in grid coordinates."""
    return Lidar(
        name="L",
        position=tuple(place),
        rpy_deg=tuple(rpy_deg),
        elevations_deg=tuple(beams),
        azimuths_deg=tuple(azimuths),
        azimuth_offsets_deg=None if offsets is None else tuple(offsets),
    )


def rays_of(sensor: Lidar, reach: tuple[float, float] = ENDLESS) -> Cast:
    """Its rays in grid coordinates."""
    table = lattice(sensor)
    origin, rotation = np.array(sensor.position), sensor.pose.rotation()
    return Cast(
        table.kind,
        table.rows,
        table.planes,
        origin,
        rotation,
        np.array(reach),
        BOX,
        SHAPE,
        False,
        np.empty(0),
    )


def sheets_of(sensor: Lidar, reach: tuple[float, float] = ENDLESS, most: float = math.inf) -> Sheets:
    """Its cones, as far as the rays are close or as far as told."""
    made = make_sheets(sensor, rays_of(sensor, reach), shortest=1.0, worth=math.inf, fewest=0)
    assert made is not None
    return made._replace(radius=min(made.radius, most))


def seen_by(made: Sheets, keep: NDArray[np.uint64] = EVERYTHING, workers: int = 1) -> set[Voxel]:
    """The voxels that core, sheets and tests mark."""
    marks = no_voxels()
    beam_cones.mark_sheets(made.spinner, made.beams, made.shells, made.radius, 0, SIDE, keep, workers, marks)
    return voxels_of(marks)


def hit(rays: Cast) -> set[Voxel]:
    """The voxels that any ray hits which is not stopped, each ray against each voxel."""
    turns = len(rays.planes)
    local = (
        rays.rows
        if rays.kind == LISTED
        else np.array([(c * x, c * y, s) for c, s in rays.rows for x, y in rays.planes])
    )
    assert rays.kind == LISTED or len(local) == turns * len(rays.rows)
    local = local[~rays.is_stopped] if rays.is_stopped.size else local
    found: set[Voxel] = set()
    place, (near, far) = tuple(rays.origin.tolist()), rays.reach.tolist()
    for d in local:
        x, y, z = (float((row[0] * d[0] + row[1] * d[1]) + row[2] * d[2]) for row in rays.rotation)
        times = (np.array(GRID) - rays.origin) / (x or 1e-300, y or 1e-300, z or 1e-300)
        more = times + 1.0 / np.array((x or 1e-300, y or 1e-300, z or 1e-300))
        may = (
            np.maximum(np.minimum(times, more).max(axis=1), near)
            < np.minimum(np.maximum(times, more).min(axis=1), far) + 1e-6
        )
        for number in np.flatnonzero(may):
            if GRID[number] not in found and hits_cell(Ray(place, (x, y, z), near, far), GRID[number]):
                found.add(GRID[number])
    return found


POSES = [
    (BESIDE, (0.0, 0.0, 0.0)),
    (BESIDE, (3.0, -4.0, 5.0)),
    ((-9.0, 2.0, 2.0), (0.0, 0.0, 0.0)),
    ((-8.4, 1.1, 3.0), (-20.0, 10.0, 0.0)),
    ((1.7, 12.6, 1.2), (5.0, 2.0, -90.0)),
    ((2.0, 2.0, 1.6), (2.0, 1.0, 0.0)),
    ((-9.3, 1.7, 1.7), (180.0, 3.0, 0.0)),
    ((-30.2, 2.1, 2.4), (1.0, -2.0, 0.0)),
    ((-8.5, -0.3, 7.0), (20.0, 34.0, -6.0)),
]


@pytest.mark.parametrize(("place", "rpy_deg"), POSES)
def test_what_is_marked_and_tested_one_by_one_is_what_a_ray_hits(
    place: tuple[float, float, float], rpy_deg: tuple[float, float, float]
) -> None:
    sensor = lidar(place, rpy_deg)
    made, found = sheets_of(sensor), hit(rays_of(sensor))
    assert seen_by(made) == found
    assert {cell for cell in GRID if cones.any_ray_hits(made.spinner, made.beams, cell)} == found


@pytest.mark.parametrize(
    ("reach", "offsets"), [((10.2, 11.4), None), (ENDLESS, (-170.0, 95.0, 3.0, 40.3, 0.0, -60.7))]
)
def test_voxels_are_tested_within_the_range_and_by_the_azimuths_of_each_beam(
    reach: tuple[float, float], offsets: tuple[float, ...] | None
) -> None:
    sensor = lidar(rpy_deg=(3.0, -4.0, 5.0), azimuths=range(-180, 180, 2), offsets=offsets)
    made = sheets_of(sensor, reach)
    found = {cell for cell in GRID if cones.any_ray_hits(made.spinner, made.beams, cell)}
    assert found and found == hit(rays_of(sensor, reach))


@pytest.mark.parametrize("reach", [ENDLESS, (10.2, 11.4)])
@pytest.mark.parametrize(("place", "rpy_deg"), [pose for pose in POSES if pose[0] != (2.0, 2.0, 1.6)])
def test_columns_are_tested_beam_by_beam(
    place: tuple[float, float, float], rpy_deg: tuple[float, float, float], reach: tuple[float, float]
) -> None:
    sensor = lidar(place, rpy_deg)
    made = sheets_of(sensor, reach)
    for beam in range(len(BEAMS)):
        found = {
            (x, y, z)
            for x in range(SIDE)
            for y in range(SIDE)
            for z in levels_by_test(made, beam, x, y)
            if z < SIDE
        }
        alone = lidar(place, rpy_deg, beams=(sensor.elevations()[made.beams.number[beam]],))
        assert found == hit(rays_of(alone, reach))


@pytest.mark.parametrize("count", [1, 2, 5])
def test_all_rays_of_a_narrow_sector_may_pass_one_column(count: int) -> None:
    """The search then comes back to the ray that it began with."""
    for first_deg in (-0.45, 0.1, 3.0):
        sensor = lidar((-9.0, 2.4, 2.2), beams=(1.0,), azimuths=first_deg + 0.1 * np.arange(count))
        made = sheets_of(sensor)
        found = {(x, y, z) for x in range(SIDE) for y in range(SIDE) for z in levels_by_test(made, 0, x, y)}
        assert found == hit(rays_of(sensor))


def levels_by_test(made: Sheets, beam: int, x: int, y: int) -> list[int]:
    """The levels of a column that rays of a beam traverse, by a test of all of its levels."""
    tile, work = tiles.tile_at(made.spinner, 0, 0), tiles.work_space(len(BEAMS), 1)
    place = tiles.TILE * x + y
    work.sure[:], work.listed[:, 0] = 0, (place, beam, 0, SIDE - 1)
    crossings.test_listed(made.spinner, made.beams, tile, 1, EVERYTHING, no_voxels(), work)
    return [level for level in range(64) if int(work.sure[0, place]) >> level & 1]


@pytest.mark.parametrize("offsets", [(0.0,) * 6, (-3.0, 0.4, 2.0, 0.0, -1.3, 5.0)])
def test_every_beam_has_azimuths_of_its_own(offsets: tuple[float, ...]) -> None:
    sensor = lidar(azimuths=range(-9, 4), rpy_deg=(1.0, 2.0, 3.0), offsets=offsets)
    assert seen_by(sheets_of(sensor)) == hit(rays_of(sensor))


@pytest.mark.parametrize("reach", [(0.0, 10.9), (10.2, 30.0), (9.9, 11.4), (40.0, 50.0), (1.0, 2.0)])
def test_rays_begin_and_end_with_their_range(reach: tuple[float, float]) -> None:
    sensor = lidar(rpy_deg=(3.0, -4.0, 5.0))
    assert seen_by(sheets_of(sensor, reach)) == hit(rays_of(sensor, reach))


@pytest.mark.parametrize("azimuths", [range(-3, 2), range(4, 40), range(-170, 171, 2), range(-180, 180, 2)])
def test_a_sector_ends_where_its_rays_end(azimuths: range) -> None:
    sensor = lidar(rpy_deg=(2.0, -3.0, 0.0), azimuths=azimuths, beams=(-8.0, -4.0, 0.0, 4.0))
    assert seen_by(sheets_of(sensor)) == hit(rays_of(sensor))
    for yaw_deg in (178.0, 90.0):
        turned = lidar(rpy_deg=(2.0, -3.0, yaw_deg), azimuths=azimuths, beams=(-8.0, -4.0, 0.0, 4.0))
        assert seen_by(sheets_of(turned)) == hit(rays_of(turned))


@pytest.mark.parametrize("pattern", ["some", "most", "a block", "a beam"])
def test_rays_that_are_stopped_hit_nothing(pattern: str) -> None:
    rng, stopped = np.random.default_rng(4), np.zeros((len(BEAMS), 19), np.bool_)
    if pattern in ("some", "most"):
        stopped[:] = rng.random(stopped.shape) < (0.2 if pattern == "some" else 0.8)
    else:
        stopped[(slice(1, 5), slice(5, 15)) if pattern == "a block" else (4, slice(None))] = True
    sensor = lidar(rpy_deg=(3.0, -4.0, 5.0), azimuths=range(-18, 19, 2))
    rays = rays_of(sensor)._replace(is_stopped=stopped.ravel())
    made = make_sheets(sensor, rays, shortest=1.0, worth=math.inf, fewest=0)
    assert made is not None and hit(rays) < hit(rays_of(sensor))
    assert seen_by(made) == hit(rays)


@pytest.mark.parametrize(
    ("place", "rpy_deg"), [((-9.0, 2.0, 2.2), (0.0, 0.0, 0.0)), (BESIDE, (3.0, -4.0, 5.0))]
)
def test_of_each_azimuth_alone_all_is_marked_along_faces_and_over_corners(
    place: tuple[float, float, float], rpy_deg: tuple[float, float, float]
) -> None:
    """All other rays are stopped, so nothing else marks what one ray clips or runs along."""
    sensor = lidar(place, rpy_deg, azimuths=range(-18, 19, 3))
    for free in range(13):
        stopped = np.ones((len(BEAMS), 13), np.bool_)
        stopped[:, free] = False
        rays = rays_of(sensor)._replace(is_stopped=stopped.ravel())
        made = make_sheets(sensor, rays, shortest=1.0, worth=math.inf, fewest=0)
        assert made is not None and seen_by(made) == hit(rays)


def test_offsets_may_turn_beams_anywhere() -> None:
    sensor = lidar(azimuths=range(-180, 180, 2), offsets=(-170.0, 95.0, 3.0, 40.3, 0.0, -60.7))
    assert seen_by(sheets_of(sensor)) == hit(rays_of(sensor))


@pytest.mark.parametrize("up", [1.0, -1.0])
@pytest.mark.parametrize("turn", range(8))
def test_rays_nearly_a_voxel_apart_are_not_called_certain_too_early(turn: int, up: float) -> None:
    sensor = lidar(
        (-7.3, 1.7, 2.0 + up * (0.2 + 0.13 * turn)),
        (3.0 * up, -4.0 * up, 1.3 * turn),
        tuple(up * beam for beam in (-9.0, -5.0, 0.0, 4.0)),
        np.arange(-20.0, 21.0, 4.0),
    )
    assert seen_by(sheets_of(sensor)) == hit(rays_of(sensor))


@pytest.mark.parametrize("gap_deg", [0.5, 2.0, 4.0])
def test_a_core_ends_with_its_beams_and_its_radius(gap_deg: float) -> None:
    sensor = lidar(
        (-7.3, 2.0, 3.2), (0.0, 0.0, 0.0), np.arange(-12.0, -3.0, gap_deg), np.arange(-40.0, 40.0, gap_deg)
    )
    made, truth = sheets_of(sensor), hit(rays_of(sensor))
    core = seen_by(made, HIGH_UP)
    assert truth < set(GRID)
    assert core <= truth
    assert seen_by(made) == truth


@pytest.mark.parametrize(
    ("low", "high"), [(3, 2), (0, 63), (5, 5), (60, 70), (64, 64), (70, 75), (-9, -1), (-3, 1)]
)
@pytest.mark.parametrize("part", [0, 1])
def test_levels_become_bits_of_their_word(low: int, high: int, part: int) -> None:
    levels = {level - 64 * part for level in range(low, high + 1)} & set(range(64))
    assert int(bits.mask_of(low, high, part)) == sum(1 << level for level in levels)


def test_beams_that_are_as_steep_as_they_can_be_are_sheets_too() -> None:
    sensor = lidar((-3.0, 1.7, -9.0), (4.0, -5.0, 0.0), beams=(52.0, 55.5, 57.0, 63.0))
    made = sheets_of(sensor)
    assert np.isfinite(made.beams.bend).tolist() == [True, True, True, False]
    flat = lidar((-3.0, 1.7, -9.0), (4.0, -5.0, 0.0), beams=(52.0, 55.5, 57.0))
    assert seen_by(made) >= hit(rays_of(flat))
    assert [len(rest.rows) for rest in made.rest] == [1]


def test_one_dense_beam_is_a_sheet_without_a_gap() -> None:
    """Level with the sensor: the level in which it is, all over the grid."""
    sensor = lidar(beams=(0.0,), azimuths=np.arange(-30.0, 31.0))
    assert seen_by(sheets_of(sensor)) == {(x, y, 2) for x, y, _ in GRID}


def test_close_beams_have_a_core_without_a_test() -> None:
    """Nothing that a beam meets is worth a test: what is marked is the core, all that lies well between the beams."""
    sensor = lidar((-9.3, 2.0, 2.0), beams=np.arange(-8.0, 8.5, 0.5), azimuths=np.arange(-40.0, 40.0, 0.5))
    made = sheets_of(sensor)
    assert made.shells.squared[0] == pytest.approx(
        (0.499 / math.sin(math.hypot(0.25, 0.25) * math.pi / 180)) ** 2, rel=5e-3
    )
    core = seen_by(made, HIGH_UP)
    assert {(x, y, z) for x, y, z in GRID if x > 2} <= core <= hit(rays_of(sensor))


def close_all_around() -> Lidar:
    """One that looks up and has a core over a whole tile."""
    return lidar((-6.3, 2.0, 2.0), beams=range(9), azimuths=range(-180, 180))


def test_what_only_the_outermost_beam_of_a_core_meets_is_tested() -> None:
    """Beam 8 passes the voxel below its middle, which is 9.7 degrees up."""
    made = sheets_of(close_all_around())
    assert (2, 2, 3) in seen_by(made) and seen_by(made) == hit(rays_of(close_all_around()))


@pytest.mark.parametrize(("reach", "beyond"), [((7.9, math.inf), (0, 2, 2)), ((0.0, 8.0), (3, 2, 2))])
def test_a_core_is_marked_where_all_of_its_tile_is_within_the_range(
    reach: tuple[float, float], beyond: Voxel
) -> None:
    made, truth = sheets_of(close_all_around(), reach), hit(rays_of(close_all_around(), reach))
    assert beyond not in truth and beyond in hit(rays_of(close_all_around()))
    assert seen_by(made, HIGH_UP) <= truth == seen_by(made)


def test_a_core_is_a_ball_below_its_sensor_too() -> None:
    place = np.array([-3.2, 2.0, 7.0])
    sensor = lidar(place.tolist(), beams=np.arange(-60.0, -29.0, 5.0), azimuths=range(-180, 180, 5))
    made = sheets_of(sensor)
    core = seen_by(made, HIGH_UP)
    away = [float(np.linalg.norm(np.array(voxel) + 0.5 - place)) for voxel in core]
    assert core and max(away) <= math.sqrt(made.shells.squared[0]) < 9.0


def test_beyond_the_radius_nothing_is_marked() -> None:
    sensor = lidar((-9.5, 2.0, 2.2), beams=(0.0,), azimuths=np.arange(-30.0, 31.0))
    assert {x for x, _, _ in seen_by(sheets_of(sensor, most=11.9))} == {0, 1}
    assert {x for x, _, _ in seen_by(sheets_of(sensor, most=9.0))} == set()


def test_the_rays_that_are_walked_begin_where_the_tiles_may_end() -> None:
    sensor = lidar(azimuths=np.arange(-20.0, 21.0, 10.0), beams=(-1.0, 0.0, 1.0, 62.0))
    made = sheets_of(sensor)
    assert made.radius < 12.0
    assert [len(rest.rows) for rest in made.rest] == [3]
    assert made.rest[0].reach[0] == pytest.approx(made.radius - 1.4144, abs=1e-3)
    assert made.rest[0].reach[0] < made.radius - math.sqrt(2.0)


@pytest.mark.parametrize(("height", "beams"), [(12.0, (-12.0, 20.0, 62.0)), (-9.0, (-62.0, -20.0, 12.0))])
def test_rays_that_reach_a_lower_or_higher_grid_only_far_away_go_on(
    height: float, beams: tuple[float, ...]
) -> None:
    """Where the tiles end they are not yet as low, or as high, as the grid."""
    sensor = lidar((-40.0, 1.7, height), beams=beams, azimuths=np.arange(-20.0, 21.0, 2.0))
    assert [len(rest.rows) for rest in sheets_of(sensor).rest] == [1]


def test_voxels_that_are_not_informative_are_not_tested() -> None:
    assert seen_by(sheets_of(lidar(beams=(-40.0, 40.0))), HIGH_UP) == set()


def test_workers_mark_together_what_one_marks_alone() -> None:
    made = sheets_of(lidar(rpy_deg=(3.0, -4.0, 5.0)))
    assert seen_by(made, workers=3) == seen_by(made)


@pytest.mark.parametrize("elevation_deg", [-35.0, -3.0, 0.0, 12.0, 50.0])
@pytest.mark.parametrize("rpy_deg", [(0.0, 0.0, 0.0), (3.0, -4.0, 30.0), (170.0, 5.0, 0.0)])
def test_a_height_is_that_of_the_cone(rpy_deg: tuple[float, float, float], elevation_deg: float) -> None:
    made = sheets_of(lidar(rpy_deg=rpy_deg, beams=(elevation_deg, elevation_deg + 0.5, elevation_deg + 1.0)))
    for beam in range(3):
        for x, y in ((3.0, 1.0), (-2.0, 4.0), (0.5, -6.0)):
            z = cones.height(made.spinner.axis, made.beams, beam, x, y)
            sine = made.spinner.axis @ (x, y, z) / math.sqrt(x * x + y * y + z * z)
            assert math.asin(sine) == pytest.approx(made.beams.elevation[beam], abs=1e-12)
            assert abs(math.hypot(*_gradient(made, beam, x, y))) <= made.beams.slope[beam] + 1e-6
            assert _bend(made, beam, x, y) * math.hypot(x, y) <= made.beams.bend[beam] + 1e-4


def _gradient(made: Sheets, beam: int, x: float, y: float, h: float = 1e-5) -> tuple[float, float]:
    def at(a: float, b: float) -> float:
        return float(cones.height(made.spinner.axis, made.beams, beam, a, b))

    return (at(x + h, y) - at(x - h, y)) / (2 * h), (at(x, y + h) - at(x, y - h)) / (2 * h)


def _bend(made: Sheets, beam: int, x: float, y: float, h: float = 1e-4) -> float:
    """The largest curvature, from differences of gradients."""
    here = np.array([_gradient(made, beam, x + h, y), _gradient(made, beam, x, y + h)])
    back = np.array([_gradient(made, beam, x - h, y), _gradient(made, beam, x, y - h)])
    return float(np.abs(np.linalg.eigvalsh((here - back) / (2 * h))).max())


def test_an_azimuth_is_known_well_enough_to_find_its_rays() -> None:
    for a in np.linspace(-math.pi, math.pi, 1001):
        u, v = math.cos(a), math.sin(a)
        assert abs(cones.azimuth_of(3.0 * u, 3.0 * v) - math.atan2(v, u)) < cones.BEARING


@pytest.mark.parametrize("sine", [-1.0, -0.9, -0.5, -1e-9, 0.0, 0.1, 0.7, 1.0])
def test_the_first_beam_in_question_is_found(sine: float) -> None:
    made = sheets_of(lidar(beams=(-60.0, -30.0, -1.0, 0.0, 1.0, 44.0, 89.0)))
    assert cones._first_beam(made.beams, sine) == int((made.beams.sine < sine).sum())


def test_rays_within_an_angle_of_a_direction_are_found() -> None:
    """Against every azimuth of a beam: none that is close enough is left out, and few others come along."""
    beams = sheets_of(lidar(beams=(-40.0, -10.0, 0.0, 30.0, 60.0))).beams
    azimuths = np.linspace(-math.pi, math.pi, 4001)
    for beam in range(5):
        for elevation in (-1.2, -0.7, -0.17, 0.02, 0.5):
            for angle in (0.01, 0.2, 0.9, 1.5):
                sine, cosine = math.sin(elevation), math.cos(elevation)
                closeness = sine * beams.sine[beam] + cosine * beams.cosine[beam] * np.cos(azimuths)
                near = np.abs(azimuths[closeness >= math.cos(angle)])
                width = cones._half_width(beams, beam, sine, cosine, math.cos(angle))
                assert width >= (near.max() if near.size else -2.0)
                assert width <= (near.max() * 1.05 + 0.005 if near.size else -1.0 + 1.1)


def test_azimuths_ascend_from_behind_their_widest_gap() -> None:
    ordered, turns, step, is_sector = engine._azimuths(np.radians([170.0, -170.0, 180.0, 175.0, -175.0]))
    assert np.degrees(ordered) == pytest.approx([170.0, 175.0, 180.0, 185.0, 190.0])
    assert turns.tolist() == [0, 3, 2, 4, 1]
    assert math.degrees(step) == pytest.approx(5.0)
    assert is_sector
    ordered, _, step, is_sector = engine._azimuths(np.radians(np.arange(-180.0, 180.0, 2.0)))
    assert (math.degrees(step), is_sector) == (pytest.approx(2.0), False)


def test_where_rays_drift_apart_and_no_core_is_they_are_walked() -> None:
    """Beams 2 degrees apart have no core to speak of: each ends where it is no longer worth it."""
    sensor = lidar((-300.0, 1.7, 2.2), beams=2.0 * np.arange(-4, 5), azimuths=np.arange(-18.0, 18.0, 0.2))
    made = make_sheets(sensor, rays_of(sensor), fewest=0)
    assert made is not None
    assert made.radius == pytest.approx(engine.WORTH / math.radians(0.2), rel=2e-3)
    assert (made.beams.radius == made.radius).all()
    assert [rays.reach[0] for rays in made.rest] == [pytest.approx(made.radius - 1.4144, abs=1e-3)]


def test_beams_that_a_core_holds_are_walked_beyond_it_and_those_at_its_border_before() -> None:
    """Of beams a quarter of a degree apart the core reaches 177 voxels; but for the two on either side, all that a beam
    meets is in it long before."""
    beams = 0.25 * np.arange(-5, 6)
    sensor = lidar((-300.0, 1.7, 2.2), beams=beams, azimuths=np.arange(-18.0, 18.0, 0.2))
    made = make_sheets(sensor, rays_of(sensor), fewest=0)
    assert made is not None
    near, far = engine.WORTH / math.radians(0.2), 0.499 / math.radians(0.16) - 0.88
    assert made.radius == pytest.approx(far, rel=2e-3)
    assert made.beams.radius == pytest.approx([near, near, *[far] * 7, near, near], rel=2e-3)
    walked = {
        round(float(rays.reach[0])): sorted(np.degrees(np.arcsin(rays.rows[:, 1]))) for rays in made.rest
    }
    assert list(walked) == [round(near - 1.4144), round(far - 1.4144)]
    assert walked[round(near - 1.4144)] == pytest.approx([-1.25, -1.0, 1.0, 1.25])
    assert walked[round(far - 1.4144)] == pytest.approx(beams[2:-2])


@pytest.mark.parametrize("radius", [8.7, 9.5, 11.0, 13.0])
def test_each_beam_is_looked_at_within_its_own_radius(radius: float) -> None:
    """In tiles that begin beyond it nothing of a beam is marked; within it all of it is, wherever the others end."""
    sensor = lidar(rpy_deg=(3.0, -4.0, 5.0))
    made = sheets_of(sensor)
    made.beams.radius[::2] = radius
    nearest = float(tiles.tile_at(made.spinner, 0, 0).nearest)
    names = made.beams.number[1::2] if radius <= nearest else made.beams.number
    elevations = sensor.elevations()[np.sort(names)]
    assert seen_by(made) == hit(rays_of(lidar(rpy_deg=(3.0, -4.0, 5.0), beams=elevations)))


def test_a_grid_too_far_away_or_rays_too_far_apart_are_walked() -> None:
    assert make_sheets(lidar((-6000.0, 0.0, 0.0)), rays_of(lidar((-6000.0, 0.0, 0.0)))) is None
    assert make_sheets(lidar(), rays_of(lidar()), fewest=0) is None
    close = lidar(azimuths=np.arange(-5.0, 5.0, 0.2))
    assert make_sheets(close, rays_of(close), fewest=0) is not None


def test_a_sector_of_few_azimuths_is_walked_and_a_turn_is_not() -> None:
    for azimuths, by_sheets in (
        (np.arange(engine.FEWEST_AZIMUTHS - 1) * 0.2, False),
        (np.arange(engine.FEWEST_AZIMUTHS) * 0.2, True),
        (np.arange(360), True),
    ):
        sensor = lidar((-9.0, 2.0, 2.0), azimuths=azimuths)
        assert (make_sheets(sensor, rays_of(sensor), shortest=1.0) is not None) == by_sheets
