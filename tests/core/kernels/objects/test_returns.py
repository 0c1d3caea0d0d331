"""Returns of a LiDAR from an object, decided for a list of rays, equal those by the formula, ray by ray."""

import numpy as np
import pytest

from riglens.core.kernels.objects.returns import (
    INVERSE,
    MOST_RAYS,
    NUMBER,
    PART,
    X,
    Y,
    Z,
    cells_of,
    cosine_of,
    is_returned,
    new_list,
)
from riglens.core.kernels.objects.unique_cells import cell_key
from riglens.core.kernels.rays.phases import mixed, unit

KEY, START = np.uint64(12345678901234567890), (3.0, -7.0, 1.5)


def random_list(rng, number):
    """Rays in any direction to parts on any side, one of them glass."""
    rays = new_list()
    along = rng.normal(size=(number, 3))
    for column, values in zip((X, Y, Z), along.T / np.linalg.norm(along, axis=1), strict=True):
        rays.hits[column : column + number] = values
    rays.hits[INVERSE : INVERSE + number] = 1.0 / rng.uniform(0.5, 60.0, number)
    rays.marks[NUMBER : NUMBER + number] = rng.permutation(100_000)[:number]
    rays.marks[PART : PART + number] = rng.integers(0, 4, number)
    rays.faces[:, :3] = rng.uniform(-3.0, 3.0, (4, 3))
    return rays


def columns_of(rays, number):
    """Directions, 1 / t, numbers, faces and cosines of the rays of a list."""
    along = np.stack([rays.hits[column : column + number] for column in (X, Y, Z)], axis=1)
    faces = rays.faces[rays.marks[PART : PART + number]]
    cosines = [cosine_of(tuple(face[:3]), tuple(d)) for face, d in zip(faces, along, strict=True)]
    return along, rays.hits[INVERSE : INVERSE + number], rays.marks[NUMBER : NUMBER + number], faces, cosines


def check(rays, number, half_m, width):
    """The cells that returning rays enter, one by one, behind those listed; how many rays return."""
    wanted, before = [-5], None
    along, inverse, numbers, faces, cosines = columns_of(rays, number)
    returning = 0
    for d, inv, ray, face, cosine in zip(along, inverse, numbers, faces, cosines, strict=True):
        word = np.uint64(mixed(KEY, np.uint64(ray)))
        is_lawful = width == 0.0 or is_returned(1.0 / inv, half_m, width, cosine, unit(word))
        if unit(np.uint64(mixed(word, np.uint64(0)))) >= face[3] and is_lawful:
            cell = cell_key(START, tuple(d), 1.0 / inv)
            wanted += [cell] if cell != before else []
            before, returning = cell, returning + 1
    cells = np.full(MOST_RAYS + 1, -5, np.int64)
    found = cells_of(KEY, START, np.eye(3), half_m, width, number, *rays, cells, 1)
    assert found == (returning, len(wanted)) and cells[: found[1]].tolist() == wanted
    return returning


@pytest.mark.parametrize("number", [0, 1, 7, 8, 9, MOST_RAYS])
@pytest.mark.parametrize("width", [0.0, 0.25, 0.004])
@pytest.mark.parametrize("glass", [0.0, 0.8])
def test_rays_return_by_the_law_and_from_glass_by_its_draws(number, width, glass):
    rng = np.random.default_rng(number)
    rays = random_list(rng, number)
    rays.faces[2, 3] = glass
    returning = check(rays, number, 25.0, width)
    assert number < MOST_RAYS or 0 < returning < number or not width + glass


@pytest.mark.parametrize("off", [0.0, 1e-16, 1e-14, 1e-11, 1e-8, 1e-5])
def test_chances_next_to_that_of_the_law_are_told_apart_as_the_formula_does(off):
    rng = np.random.default_rng(1)
    rays = random_list(rng, MOST_RAYS)
    _, inverse, numbers, _, cosines = columns_of(rays, MOST_RAYS)
    chances = np.array([unit(np.uint64(mixed(KEY, np.uint64(ray)))) for ray in numbers])
    t = 25.0 * np.sqrt(cosines) * (1.0 + 0.25 * np.log(1.0 / chances - 1.0))
    is_anywhere = t > 0.0
    inverse[is_anywhere] = 1.0 / (t * (1.0 + off * rng.choice([-1.0, 1.0], MOST_RAYS)))[is_anywhere]
    assert is_anywhere.sum() > MOST_RAYS / 2
    assert 0 < check(rays, MOST_RAYS, 25.0, 0.25) < MOST_RAYS
