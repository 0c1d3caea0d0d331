"""Planes of which some rays are stopped: the runs of free rays, and that they mark what each of them marks alone."""

from itertools import pairwise

import numpy as np
import pytest

from riglens.core.kernels.fans.fan import LAID, lay_plane
from riglens.core.kernels.fans.planes import LeftoverRays, work_for
from riglens.core.kernels.fans.spans import _climb_of, _lay_ray, _trace, find_spans, limits_for
from tests.core.kernels.tiny import SIDE, fan_of, heading, rays_in_planes, seen_by_fan, seen_ray_by_ray


def spans_of(stopped: list[str], row_of: list[int]) -> list[list[tuple[int, int]]]:
    """Runs by plane; one text a row, `x` for a stopped ray."""
    table = np.array([[letter == "x" for letter in row] for row in stopped])
    starts = np.zeros(table.shape[1] + 1, np.int64)
    spans = find_spans(table.ravel(), table.any(axis=1), np.array(row_of), table.shape[1], starts)
    return [[tuple(map(int, spans[k])) for k in range(a, b)] for a, b in pairwise(starts)]


def test_runs_are_told_plane_by_plane_in_the_order_of_the_slopes() -> None:
    stopped = ["..x", ".xx", "..x", "x.x"]
    assert spans_of(stopped, [0, 1, 2, 3]) == [[(0, 2)], [(0, 0), (2, 3)], []]
    assert spans_of(stopped, [3, 1, 0]) == [[(1, 2)], [(0, 0), (2, 2)], []]


def test_nothing_stopped_is_one_run() -> None:
    assert spans_of(["..", "..", ".."], [2, 0, 1]) == [[(0, 2)], [(0, 2)]]


@pytest.mark.parametrize("seed", range(10))
def test_free_rays_mark_what_each_of_them_marks_alone(seed: int) -> None:
    """From inside and outside of the grid, at round places too, up and down, with any rays stopped."""
    rng = np.random.default_rng(seed)
    origin = rng.uniform(-1.5, 5.5, 3)
    origin = np.round(origin, int(rng.choice([0, 1, 12])))
    slopes = np.round(rng.uniform(-2.0, 2.0, int(rng.integers(1, 9))), int(rng.choice([1, 12])))
    headings = [heading(float(a)) for a in np.round(rng.uniform(0, 360, 3), int(rng.choice([-1, 12])))]
    rays = rays_in_planes(tuple(origin), tuple(slopes), headings)
    stopped = rng.random(len(slopes) * len(headings)) < rng.choice([0.2, 0.5, 0.9])
    rays = rays._replace(is_stopped=stopped)
    expected = seen_ray_by_ray(rays)
    for slabs in ([(0, 4)], [(0, 2), (2, 4)]):
        assert seen_by_fan(rays, slabs) == expected


def test_a_ray_laid_from_level_to_level_reaches_what_it_reaches_when_walked() -> None:
    """From generic places nearly always; from round ones it is left to the walk where a change is at a face."""
    laid_rays = walked = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        origin, slopes, angle = rng.uniform(-1.5, 5.5, 3), rng.uniform(-3.0, 3.0, 5), rng.uniform(0, 360)
        if seed % 4 == 0:
            origin, slopes, angle = np.floor(origin) + 0.5, np.round(slopes), 90.0 * np.floor(angle / 90.0)
        fan, rays, profile = fan_of(rays_in_planes(tuple(origin), np.sort(slopes), [heading(float(angle))]))
        work, leftover = (
            work_for(rays, profile),
            LeftoverRays(np.empty((99, 6), np.int32), np.zeros(1, np.int64)),
        )
        laid = lay_plane(fan, rays, profile, 0, rays.box, work, leftover)
        if laid.outcome != LAID:
            continue
        limits, count = limits_for(1, work.ways), laid.columns
        for row in fan.row_of:
            for side in range(2):
                around = (laid.start, count, laid.near)
                assert _trace(rays, 0, row, side, *around, rays.box, limits)
                expected, found = limits.limits[side, :count].copy(), np.full(count, -9, np.int32)
                climb = _climb_of(fan, rays, 0, row, laid.start, laid.near)
                if _lay_ray(climb, side, count, rays.box, found):
                    inside = (
                        (0, SIDE) if side == 0 else (-1, SIDE - 1)
                    )  # a lowest level below the box is its floor
                    np.testing.assert_array_equal(
                        found.clip(*inside), expected.clip(*inside), f"{seed} {row}"
                    )
                    laid_rays += 1
                else:
                    walked += 1
    assert laid_rays > 4 * walked > 0
