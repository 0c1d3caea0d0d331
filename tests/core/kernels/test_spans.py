"""Planes of which some rays are stopped: the runs of free rays, and that they mark what each of them marks alone."""

from itertools import pairwise

import numpy as np
import pytest

from riglens.core.kernels.spans import find_spans
from tests.core.kernels.tiny import heading, rays_in_planes, seen_by_fan, seen_ray_by_ray


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
