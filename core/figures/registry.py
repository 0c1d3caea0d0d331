"""List every figure in the order in which it is shown: built-in ones, then those of installed packages.

A figure is defined in one file of this room and named once, here; tables, pages, options and charts iterate this list.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache

from riglens.core.extensions import extended
from riglens.core.figures.coverage import BLIND_GROUND, S_MS, SEEN, s_mig, seen_by
from riglens.core.figures.figure import Figure
from riglens.core.figures.hits import (
    BOTH,
    ENOUGH_POINTS,
    HEIGHT,
    MISSED,
    ON_TARGET,
    POINTS,
    SHARE_1,
    SHARE_5,
    TALL,
    VISIBLE,
    by_kind,
)
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import FOUND, PREDICTED
from riglens.core.sensors.registry import further_kinds, kinds, shown_kinds

BUILT_IN: dict[str, Figure] = {
    figure.key: figure
    for figure in (
        PREDICTED, FOUND, ON_TARGET, SHARE_1, SHARE_5, ENOUGH_POINTS, POINTS, VISIBLE, TALL, HEIGHT, BOTH, MISSED,
        SEEN, S_MS, BLIND_GROUND,
    )
}  # fmt: skip


@cache
def _figures() -> dict[str, Figure]:
    return extended("riglens.figures", BUILT_IN, Figure, name_of=lambda figure: figure.key)  # type: ignore[type-abstract]


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
    """Return the figures that tolerances spread: the leading ones of classes that have a direction."""
    return tuple(one for one in leading_figures() if one.per_class and one.better != "neither")


def figure_named(key: str) -> Figure | None:
    """Return the figure with a key, None when there is none."""
    return next((figure for figure in figures() if figure.key == key), None)


@contextmanager
def registered(figure: Figure) -> Iterator[None]:
    """Know one more figure for a while: for tests, and for trying one out."""
    if figure_named(figure.key) is not None:
        raise ValueError(f"figure '{figure.key}' already exists")
    _figures()[figure.key] = figure
    try:
        yield
    finally:
        del _figures()[figure.key]
