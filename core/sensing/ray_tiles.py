"""Cut a lattice of rays without straight rows into tiles whose directions are nearly linear."""

from __future__ import annotations

from functools import singledispatch
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.rays.tiles import (
    AFTER,
    AXIS,
    BEND,
    BY_COLUMN,
    BY_ROW,
    COLUMN,
    COLUMNS,
    COSINE,
    FIELDS,
    IS_FULL,
    LONGEST,
    OWN_RAYS,
    ROW,
    ROWS,
    SINE,
    TILE_ROWS,
    TiledRays,
)
from riglens.core.rig.model import Camera, Sensor
from riglens.core.sensing.kept import RAYS
from riglens.core.sensing.rays import lattice
from riglens.core.sensors.base import unplaced

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
IMAGE_COLUMNS, PATTERN_COLUMNS = 64, 16
"""Columns of a tile of an image, and of anything else: rays of scan patterns run in narrow bends."""
_GROUPS = (2, 8), (4, 4)
"""Columns and rows of tiles in a group, and of groups in a group of these."""
_LEAST_COSINE = 0.5
"""Rays of a tile that are farther than this from its axis are no multiples of themselves."""
_WIDER = 1.0 + 1e-9
NO_TILES = np.zeros((0, FIELDS))


@singledispatch
def is_image(_: Sensor) -> bool:
    """Return whether the rays of a sensor form an image."""
    return False


@is_image.register
def _is_image(_: Camera) -> bool:
    return True


def tiled(sensor: Sensor) -> TiledRays:
    """Return the rays of a sensor in tiles."""
    return _tiled(unplaced(sensor))


@RAYS.of
def _tiled(sensor: Sensor) -> TiledRays:
    """Return the tiles of a sensor without a place, the same ones throughout a drag."""
    table, columns = lattice(sensor), sensor.resolution[0]
    known = directions = table.directions()
    numbers = np.zeros(0, np.int64)
    if table.exists is not None:
        directions = np.full((sensor.ray_count, 3), np.nan)
        directions[table.exists] = known
        numbers = np.where(table.exists, np.cumsum(table.exists) - 1, -1)
    tile_columns = IMAGE_COLUMNS if is_image(sensor) else PATTERN_COLUMNS
    return TiledRays(tiles_of(directions, columns, tile_columns), columns, numbers)


def tiles_of(directions: Doubles, columns: int, tile_columns: int) -> Doubles:
    """Return tiles of at most `tile_columns` columns, a divisor of 64, of unit directions (rays, 3), NaN for missing
    rays, and before those of each group a tile around all of it, (t, FIELDS) as in `kernels.rays.tiles`; those
    without any ray are left out."""
    strip = TILE_ROWS * columns
    leaves = np.concatenate(
        [
            _tiles_of_strip(directions[at : at + strip].reshape(-1, columns, 3), tile_columns, at // columns)
            for at in range(0, len(directions), strip)
        ]
    )
    wide, high = tile_columns, TILE_ROWS
    keys = list[Ids]()
    for across, down in _GROUPS:
        wide, high = wide * across, high * down
        number = (leaves[:, ROW] // high) * (columns // wide + 1) + leaves[:, COLUMN] // wide
        keys.append(number.astype(np.int64))
    order = np.lexsort(keys)
    found = _nested(leaves[order], [key[order] for key in reversed(keys)])
    length, reach = np.linalg.norm(found[:, AXIS : AXIS + 3], axis=1), _reach(found) + found[:, BEND]
    found[:, SINE] = reach
    found[:, COSINE] = np.where(reach < length, np.sqrt(np.maximum(length**2 - reach**2, 0.0)), -1.0)
    return found


def _reach(tiles: Doubles) -> Doubles:
    """Return how far what is linear in row and column goes from the axis of tiles (t, FIELDS) at most, (t,)."""
    across, up = tiles[:, BY_COLUMN : BY_COLUMN + 3], tiles[:, BY_ROW : BY_ROW + 3]
    return np.asarray(
        np.linalg.norm(across, axis=1) * (tiles[:, COLUMNS] - 1.0) / 2.0
        + np.linalg.norm(up, axis=1) * (tiles[:, ROWS] - 1.0) / 2.0
    )


def _nested(leaves: Doubles, keys: list[Ids]) -> Doubles:
    """Return leaves with a tile around each group before it; keys: of groups, the largest ones first."""
    if not keys:
        leaves[:, AFTER] = np.arange(1, len(leaves) + 1)
        return leaves
    bounds = np.flatnonzero(np.diff(keys[0], prepend=-1, append=-1))
    found, filled = list[Doubles](), 0
    for first, end in pairwise(bounds.tolist()):
        inner = _nested(leaves[first:end].copy(), [key[first:end] for key in keys[1:]])
        around = _around(leaves[first:end])
        inner[:, AFTER] += filled + 1
        around[AFTER] = filled + 1 + len(inner)
        found += [around[None], inner]
        filled += 1 + len(inner)
    return np.concatenate(found) if found else leaves


def _around(leaves: Doubles) -> Doubles:
    """Return a tile without rays of its own that holds those of leaves (n, FIELDS)."""
    middle, found = leaves[:, AXIS : AXIS + 3], np.zeros(FIELDS)
    axis = middle.sum(axis=0)
    axis /= max(float(np.linalg.norm(axis)), 1e-12)
    found[AXIS : AXIS + 3] = axis
    found[BEND] = (np.linalg.norm(middle - axis, axis=1) + _reach(leaves) + leaves[:, BEND]).max() * _WIDER
    found[LONGEST] = leaves[:, LONGEST].max()
    for first, number in ((ROW, ROWS), (COLUMN, COLUMNS)):
        found[first] = leaves[:, first].min()
        found[number] = (leaves[:, first] + leaves[:, number]).max() - found[first]
    return found


def _tiles_of_strip(directions: Doubles, tile_columns: int, first_row: int) -> Doubles:
    """Return the tiles of rows (rows, columns, 3) of a lattice."""
    rows, columns, _ = directions.shape
    tiles = -(-columns // tile_columns)
    wide = np.full((rows, tiles * tile_columns, 3), np.nan)
    wide[:, :columns] = directions
    rays = wide.reshape(rows, tiles, tile_columns, 3).transpose(1, 0, 2, 3)
    found = np.zeros((tiles, FIELDS))
    found[:, ROW], found[:, ROWS] = first_row, rows
    found[:, COLUMN] = np.arange(tiles) * tile_columns
    found[:, COLUMNS] = np.minimum(columns - found[:, COLUMN], tile_columns)
    exists = ~np.isnan(rays[..., 0])
    found[:, OWN_RAYS] = exists.sum(axis=(1, 2))
    found[:, IS_FULL] = found[:, OWN_RAYS] == rows * found[:, COLUMNS]
    some = exists.any(axis=(1, 2))
    return _fitted(rays[some], found[some])


def _fitted(rays: Doubles, tiles: Doubles) -> Doubles:
    """Return tiles (t, FIELDS) with numbers linear in row and column for their rays (t, rows, columns, 3), by least
    squares."""
    exists = ~np.isnan(rays[..., 0])
    number, rays = exists.sum(axis=(1, 2)), rays.copy()
    rays[~exists] = 0.0
    axis = rays.sum(axis=(1, 2))
    axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-12)
    along = np.where(exists, (rays @ axis[:, None, :, None])[..., 0], 1.0)
    along[along.min(axis=(1, 2)) < _LEAST_COSINE] = 1.0
    rays /= along[..., None]
    row = (np.arange(rays.shape[1]) - (rays.shape[1] - 1.0) / 2.0)[:, None] * np.ones(rays.shape[2])
    column = (np.arange(rays.shape[2]) - (tiles[:, COLUMNS, None] - 1.0) / 2.0)[:, None, :]
    count, cells = len(rays), rays.shape[1] * rays.shape[2]
    places, mean = np.empty((2, count, *exists.shape[1:])), np.empty((2, count))
    places[0], places[1] = column, row
    for place, to in zip(places, mean, strict=True):
        to[:] = np.einsum("trc,trc->t", place, exists) / number
    aside = (places - mean[..., None, None]) * exists
    spread = np.maximum(np.einsum("ptrc,ptrc->pt", aside, aside), 1e-12)
    places, aside = (one.reshape(2, count, cells).swapaxes(0, 1) for one in (places, aside))
    flat = rays.reshape(count, cells, 3)
    steps = aside @ flat / spread.T[..., None]
    middle = flat.sum(axis=1) / number[:, None] - np.einsum("tpk,pt->tk", steps, mean)
    residual = flat - places.swapaxes(1, 2) @ steps
    residual -= middle[:, None]
    aside2 = np.einsum("tnk,tnk->tn", residual, residual)
    tiles[:, BY_COLUMN : BY_COLUMN + 3], tiles[:, BY_ROW : BY_ROW + 3] = steps[:, 0], steps[:, 1]
    tiles[:, AXIS : AXIS + 3], tiles[:, LONGEST] = middle, (1.0 / along).max(axis=(1, 2)) * _WIDER
    tiles[:, BEND] = np.sqrt((aside2 * exists.reshape(aside2.shape)).max(axis=1)) * _WIDER
    return tiles
