"""Generate the occluders of the bundled town: buildings, walls, hedges, lamp posts, trees, parked rows.

Boxes in the map frame of streets.py (x east, y north, z up, ground at 0). They are behind the sidewalks, off the
streets and out of the way. Made from the streets alone, without a simulation; everything follows from SEED.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from random import Random

import numpy as np
from numpy.typing import NDArray

from tools.town.streets import (
    APPROACH,
    AVENUE,
    BOULEVARD,
    SIDE_STREET,
    Point,
    Segment,
    centre_line,
    node_positions,
    rng_for,
    town_segments,
)

STREET_CLEARANCE_M = 0.2
"""Least distance of occluders from the outer edge of every sidewalk."""
CORNER_CLEARANCE_M = 4.0
"""And so far beyond the corners of a crossing, where the kerb is round and people wait."""
LAMP_PITCH_M = 28.0
TREE_PITCH_M = 9.0
PARKED_PITCH_M = 2.6
PARKED_LENGTH_M, PARKED_WIDTH_M, PARKED_HEIGHT_M = 4.5, 1.82, 1.5
STOREY_M = 3.1
MAP = "town"


@dataclass(frozen=True)
class Standing:
    """Box on the ground: centre x, y and size in metres, yaw in radians, map frame."""

    kind: str
    x_m: float
    y_m: float
    length_m: float
    width_m: float
    height_m: float
    yaw_rad: float

    def row(self) -> str:
        """The row of the table."""
        metres = (self.x_m, self.y_m, self.height_m / 2, self.length_m, self.width_m, self.height_m)
        texts = [f"{round(value, 3) + 0.0:.3f}" for value in metres]
        return ",".join([MAP, self.kind, *texts, f"{round(self.yaw_rad, 5) + 0.0:.5f}"])

    def outline(self) -> NDArray[np.float64]:
        """Points (n, 2) on the edge of the footprint, at most 0.5 m apart."""
        along = np.linspace(-0.5, 0.5, int(self.length_m / 0.5) + 2) * self.length_m
        across = np.linspace(-0.5, 0.5, int(self.width_m / 0.5) + 2) * self.width_m
        sides = [np.column_stack([along, np.full(along.size, y)]) for y in (across[0], across[-1])]
        sides += [np.column_stack([np.full(across.size, x), across]) for x in (along[0], along[-1])]
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        turned: NDArray[np.float64] = np.vstack(sides) @ np.array([[cos, sin], [-sin, cos]])
        return np.asarray(turned + np.array([self.x_m, self.y_m]), np.float64)


class Free:
    """Places without streets: the middles of all roads with half their widths, and round places at the crossings."""

    def __init__(self, nodes: dict[tuple[int, int], Point], segments: list[Segment]) -> None:
        pieces: list[tuple[Point, Point, float]] = []
        widths: dict[tuple[int, int], list[float]] = {}
        for segment in segments:
            line = centre_line(nodes[segment.start], nodes[segment.end], segment.bend_m)
            pieces += [(a, b, segment.half_width_m) for a, b in pairwise(line)]
            for end in (segment.start, segment.end):
                widths.setdefault(end, []).append(segment.half_width_m)
        self._starts = np.array([piece[0] for piece in pieces])
        self._ends = np.array([piece[1] for piece in pieces])
        self._half_m = np.array([piece[2] for piece in pieces]) + STREET_CLEARANCE_M
        self._nodes = np.array([nodes[key] for key in widths])
        self._corner_m = np.array([math.hypot(max(w), min(w)) for w in widths.values()]) + CORNER_CLEARANCE_M

    def has_room_for(self, thing: Standing) -> bool:
        """Return whether it is on no street and on no crossing."""
        points = thing.outline()[:, None, :]
        along = self._ends - self._starts
        share = ((points - self._starts) * along).sum(2) / (along**2).sum(1)
        nearest = self._starts + np.clip(share, 0, 1)[..., None] * along
        beside = bool((np.linalg.norm(points - nearest, axis=2) > self._half_m).all())
        return beside and bool((np.linalg.norm(points - self._nodes, axis=2) > self._corner_m).all())


@dataclass(frozen=True)
class Roadside:
    """One side of one block, from its start on; `side` is 1 on the left, -1 on the right."""

    segment: Segment
    line: list[Point]
    side: int

    @property
    def length_m(self) -> float:
        """Length of the middle of the road."""
        return sum(math.dist(a, b) for a, b in pairwise(self.line))

    def place(self, along_m: float, beyond_m: float) -> tuple[float, float, float]:
        """x, y and the street's direction at a distance beyond the outer edge of the sidewalk."""
        left_m = along_m
        for a, b in pairwise(self.line):
            length_m = math.dist(a, b)
            if left_m <= length_m or b == self.line[-1]:
                break
            left_m -= length_m
        cos, sin = (b[0] - a[0]) / length_m, (b[1] - a[1]) / length_m
        aside_m = self.side * (self.segment.half_width_m + beyond_m)
        x, y = a[0] + cos * left_m - sin * aside_m, a[1] + sin * left_m + cos * aside_m
        return x, y, math.atan2(sin, cos)

    def standing(
        self, kind: str, along_m: float, beyond_m: float, size_m: tuple[float, float, float]
    ) -> Standing:
        """Return a box of this length, width and height whose near side is `beyond_m` beyond the sidewalk."""
        x, y, yaw_rad = self.place(along_m, beyond_m + size_m[1] / 2)
        return Standing(kind, x, y, *size_m, yaw_rad)


def surroundings() -> list[Standing]:
    """Return all occluders of the town, in the order of the streets."""
    nodes, segments = node_positions(), town_segments()
    free = Free(nodes, segments)
    found: list[Standing] = []
    for number, segment in enumerate(segments):
        line = centre_line(nodes[segment.start], nodes[segment.end], segment.bend_m)
        for side in (1, -1):
            rng = rng_for("surroundings", number, side)
            found += [
                thing for thing in _beside(Roadside(segment, line, side), rng) if free.has_room_for(thing)
            ]
    return found


def _beside(roadside: Roadside, rng: Random) -> Iterator[Standing]:
    """Posts and trees at the edge of the sidewalk, and plots behind them."""
    street = roadside.segment.street
    yield from _row(roadside, "pole", rng.uniform(0, LAMP_PITCH_M), LAMP_PITCH_M, (0.18, 0.18, 7.0))
    if street in (BOULEVARD, AVENUE, APPROACH):
        thick_m = rng.uniform(0.25, 0.5)
        yield from _row(roadside, "tree", rng.uniform(0, TREE_PITCH_M), TREE_PITCH_M, (thick_m, thick_m, 2.8))
    garden_m = rng.uniform(3.0, 5.0) if street is SIDE_STREET else rng.uniform(1.2, 2.5)
    along_m = rng.uniform(0, 4)
    while along_m < roadside.length_m:
        width_m = rng.uniform(11.0, 26.0)
        yield from _plot(roadside, along_m, width_m, garden_m, rng)
        along_m += width_m + rng.choice((0.0, 0.0, 3.5))


def _row(
    roadside: Roadside, kind: str, start_m: float, pitch_m: float, size_m: tuple[float, float, float]
) -> Iterator[Standing]:
    """Equal things at equal distances."""
    for number in range(int((roadside.length_m - start_m) / pitch_m) + 1):
        yield roadside.standing(kind, start_m + number * pitch_m, 0.3, size_m)


def _plot(
    roadside: Roadside, start_m: float, width_m: float, garden_m: float, rng: Random
) -> Iterator[Standing]:
    """One piece of ground along the sidewalk: a house, cars parked in a row, a walled yard, or nothing."""
    middle_m, outside = start_m + width_m / 2, roadside.segment.street is APPROACH
    use = rng.choices(("house", "parked", "yard", "open"), (1, 1, 3, 9) if outside else (12, 2, 3, 1))[0]
    if use == "house":
        size_m = (width_m, rng.uniform(9.0, 14.0), STOREY_M * rng.randint(2, 6) + 1.0)
        yield roadside.standing("building", middle_m, garden_m, size_m)
        if garden_m > 3.5:
            yield roadside.standing("wall", middle_m, 0.4, (width_m - 3.0, 0.25, rng.uniform(0.5, 1.2)))
    elif use == "parked":
        for number in range(int(width_m / PARKED_PITCH_M)):
            if rng.random() < 0.8:
                yield _parked(roadside, start_m + (number + 0.5) * PARKED_PITCH_M)
    elif use == "yard":
        kind, thick_m = rng.choice((("wall", 0.25), ("hedge", 0.9)))
        yield roadside.standing(kind, middle_m, 0.5, (width_m, thick_m, rng.uniform(1.2, 2.2)))


def _parked(roadside: Roadside, along_m: float) -> Standing:
    """Return a car parked across the street's direction on private ground."""
    across = roadside.standing("parked_car", along_m, 1.0, (PARKED_WIDTH_M, PARKED_LENGTH_M, PARKED_HEIGHT_M))
    turned_rad = math.remainder(across.yaw_rad + math.pi / 2, math.tau)
    return Standing(
        across.kind, across.x_m, across.y_m, PARKED_LENGTH_M, PARKED_WIDTH_M, PARKED_HEIGHT_M, turned_rad
    )


def occluder_table(standing: list[Standing]) -> str:
    """Return the text of the table of all occluders."""
    return "\n".join(["map,cls,x,y,z,length,width,height,yaw", *(thing.row() for thing in standing)]) + "\n"
