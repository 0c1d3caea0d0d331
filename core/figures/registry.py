"""List every figure and heatmap in the order in which it is shown: built-in ones, then those of installed packages.

Each is defined in one file of this room and named once, here; tables, pages, menus, options and charts iterate these
lists.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from riglens.core.extensions import extended
from riglens.core.figures.coverage import BLIND_GROUND, S_MS, SEEN, s_mig, seen_by
from riglens.core.figures.figure import Figure
from riglens.core.figures.heatmaps import (
    CHANGE,
    ENTROPY,
    LOST_BEHIND_CAR,
    LOST_BEHIND_TRAFFIC,
    LOST_OUTSIDE,
    MISSED_OBJECTS,
    OF_TARGETS,
    PROBABILITY,
    SEEN_BY_TWO_KINDS,
    SEEN_ENTROPY,
    SEEN_THRICE,
    SEEN_TWICE,
    SENSORS,
    UNSEEN_ENTROPY,
    HeatMap,
    ObjectHeatMap,
    VoxelHeatMap,
)
from riglens.core.figures.hits import (
    BOTH,
    ENOUGH_POINTS,
    HEIGHT,
    MISSED,
    ON_TARGET,
    POINTS,
    SEEN_BY_CAMERAS,
    SHARE_1,
    SHARE_5,
    TALL,
    by_kind,
)
from riglens.core.figures.lowest_heights import LowestHeight, lowest_heights
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import FOUND, PREDICTED
from riglens.core.figures.voxel_sets import ANY, VoxelSet
from riglens.core.figures.voxel_sets import by_kind as seen_by_kind
from riglens.core.sensors.registry import further_kinds, kinds, shown_kinds

BUILT_IN: dict[str, Figure] = {
    figure.key: figure
    for figure in (
        PREDICTED, SHARE_5, SEEN_BY_CAMERAS, MISSED, S_MS, SEEN, ON_TARGET, FOUND, SHARE_1, ENOUGH_POINTS, POINTS,
        TALL, HEIGHT, BOTH, BLIND_GROUND,
    )
}  # fmt: skip
HEAT_MAPS: dict[str, HeatMap] = {
    heat.key: heat
    for heat in (
        PROBABILITY, ENTROPY, SEEN_ENTROPY, UNSEEN_ENTROPY, SENSORS, CHANGE, SEEN_TWICE, SEEN_THRICE, SEEN_BY_TWO_KINDS,
        OF_TARGETS, MISSED_OBJECTS, LOST_OUTSIDE, LOST_BEHIND_TRAFFIC, LOST_BEHIND_CAR,
    )
}  # fmt: skip
GROUP = "riglens.figures"
"""Entry points of figures and heatmaps."""


@cache
def _figures() -> dict[str, Figure]:
    return extended(GROUP, BUILT_IN, Figure, (HeatMap,), lambda figure: figure.key)  # type: ignore[type-abstract]


@cache
def _heat_maps() -> dict[str, HeatMap]:
    return extended(GROUP, HEAT_MAPS, HeatMap, (Figure,), lambda heat: heat.key)  # type: ignore[type-abstract]


def figures(present: Iterable[str] | None = None) -> tuple[Figure, ...]:
    """Return every figure of rigs with sensors of the kinds `present`, of all kinds by default."""
    there = [kind.name for kind in kinds()] if present is None else list(present)
    found = list[Figure]()
    for figure in _figures().values():
        if figure is BOTH:  # what one kind detects stands before what several do
            found += [by_kind(kind) for kind in further_kinds(there)]
        found.append(figure)
    for kind in sorted(shown_kinds(there), key=lambda kind: kind.name):
        found += [seen_by(kind), s_mig(kind)] if kind.score_weight != 0.0 else [seen_by(kind)]
    return tuple(found)


def object_figures(present: Iterable[str] | None = None) -> tuple[ObjectFigure, ...]:
    """Return the figures of objects."""
    return tuple(figure for figure in figures(present) if isinstance(figure, ObjectFigure))


def leading_figures() -> tuple[Figure, ...]:
    """Return the figures that stand in the first tables, from left to right."""
    return tuple(figure for figure in figures() if figure.leads)


def tolerated_figures() -> tuple[Figure, ...]:
    """Return the figures that tolerances spread: the leading ones of classes that have a direction, and a few more."""
    spread = (one for one in figures() if one.leads or one.is_spread)
    return tuple(one for one in spread if one.per_class and one.better != "neither")


def figure_named(key: str) -> Figure | None:
    """Return the figure with a key, None when there is none."""
    return next((figure for figure in figures() if figure.key == key), None)


# ---------------------------------------------------------------- heatmaps and maps
def heat_maps() -> tuple[HeatMap, ...]:
    """Return every heatmap, with those of the leading figures of objects."""
    known = _heat_maps()
    leading = (one for one in leading_figures() if isinstance(one, ObjectFigure) and one.key not in known)
    return (*known.values(), *(ObjectHeatMap.of(one) for one in leading))


def heat_map_named(key: str) -> HeatMap | None:
    """Return the heatmap with a key, None when there is none."""
    return next((heat for heat in heat_maps() if heat.key == key), None)


def voxel_heat_maps() -> tuple[VoxelHeatMap, ...]:
    """Return the heatmaps of voxels."""
    return tuple(heat for heat in heat_maps() if isinstance(heat, VoxelHeatMap))


def voxel_heat_map(key: str) -> VoxelHeatMap | None:
    """Return the heatmap of voxels with a key, None when there is none."""
    return next((heat for heat in voxel_heat_maps() if heat.key == key), None)


def voxel_sets() -> tuple[VoxelSet, ...]:
    """Return the sets of voxels that a map from above can show: seen by any sensor, by those of each kind, and what
    heatmaps show besides."""
    of_heat = {heat.voxels.key: heat.voxels for heat in voxel_heat_maps() if heat.voxels is not None}
    of_kinds = {kind.name: seen_by_kind(kind) for kind in kinds()}
    return tuple(({ANY.key: ANY} | of_kinds | of_heat).values())


def voxel_set_named(key: str) -> VoxelSet:
    """Return the set of voxels with a key; KeyError when there is none."""
    return {one.key: one for one in voxel_sets()}[key]


def maps() -> tuple[VoxelSet | LowestHeight | ObjectHeatMap, ...]:
    """Return what the map can show: of voxels from above, of the ground around the car, of objects over the ground."""
    of_objects = (heat for heat in heat_maps() if isinstance(heat, ObjectHeatMap))
    return (*voxel_sets(), *lowest_heights(), *of_objects)


@contextmanager
def registered(thing: Figure | HeatMap) -> Iterator[None]:
    """Know one more figure or heatmap for a while: for tests, and for trying one out."""
    is_figure = isinstance(thing, Figure)
    known: dict[str, Any] = _figures() if is_figure else _heat_maps()
    if (figure_named(thing.key) if is_figure else heat_map_named(thing.key)) is not None:
        raise ValueError(f"{'figure' if is_figure else 'heatmap'} '{thing.key}' already exists")
    known[thing.key] = thing
    try:
        yield
    finally:
        del known[thing.key]
