"""Tallies of boxes, from which a survey and every check of box data are made.

They are whole numbers by class, place, size and height, so those of the parts of a data set add up.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3

SECTORS = ("front", "left", "rear", "right")
"""Quarters around the car, each 45° to both sides of its direction."""

RINGS_M = (0.0, 10.0, 20.0, 30.0, 50.0, math.inf)
"""Borders of the distances, horizontally from the car's middle to the middle of a box."""

NEAR_M = 20.0
"""Only boxes this near determine the ground: farther away the road may rise or fall."""

STEP_M = 0.01
SIZE_STEPS, HEIGHT_STEPS, LOWEST_M = 4000, 4000, -20.0
"""Sizes from 0 and heights from LOWEST_M are tallied in steps of STEP_M; what lies beyond the ends counts there."""
PLACES = len(SECTORS) * (len(RINGS_M) - 1)
"""Sectors and rings of a class."""
FLOWS = (
    "ahead along", "ahead across", "beside along", "beside across", "oncoming left", "oncoming right",
    "lane ahead", "lane back", "row by yaw", "row by yaw reversed",
    *(f"axes at {angle}°" for angle in range(0, 90, 10)),
)  # fmt: skip
"""Cars that tell where a road runs: in the lane ahead and behind (within 4 m of the x axis) and beside the car, by
whether they head along x or across; those that head back in a neighbouring lane (2 to 12 m aside), by side; and those
in the car's own lane (within 1.5 m of the x axis), by whether they head ahead or back; neighbours that head alike, 2 to
8 m apart and turned to both axes, where the line between them runs along or across their heading as yaw has it, or with
its sign reversed; and cars within 40 m by the angle of their heading to the nearer axis on its right, in tens of
degrees."""
ROWS = slice(8, 10)
AXES = slice(10, 19)
"""Places in FLOWS."""
_LANE_M, _ROAD_M, _OWN_LANE_M = 4.0, 40.0, 1.5
_NEXT_LANE_M = (2.0, 12.0)
_IN_ROW_M, _NEIGHBOURS = (2.0, 8.0), 3
_ALIKE_RAD, _TURNED_RAD, _ON_LINE_RAD = math.radians(6.0), math.radians(10.0), math.radians(5.0)


@dataclass(frozen=True)
class BoxStatistics:
    """Numbers of boxes by flat index, the class always first.

    placed: by (class, sector, ring); sizes: by (class, edge, step), edges length, width, height; bottoms: those within
    NEAR_M by (class, step of the height of their lower side), and centres the same of their middle. flows: cars by
    FLOWS. frames: with boxes; most: boxes in one frame; repeated: frames that equal the one before. yaw_rad: the
    largest yaw as a table has it. origin_m: place of the source's origin in the vehicle frame, metres, None if
    members differ; is_origin_known: whether the format fixes it.
    """

    placed: Counter[int] = field(default_factory=Counter)
    sizes: Counter[int] = field(default_factory=Counter)
    bottoms: Counter[int] = field(default_factory=Counter)
    centres: Counter[int] = field(default_factory=Counter)
    flows: Counter[int] = field(default_factory=Counter)
    frames: int = 0
    most: int = 0
    repeated: int = 0
    yaw_rad: float = 0.0
    origin_m: Vec3 | None = None
    is_origin_known: bool = False

    @staticmethod
    def joined(parts: Iterable[BoxStatistics | None]) -> BoxStatistics | None:
        """Return those of several sets of frames together, or None if a set has none."""
        listed = list(parts)
        known = [one for one in listed if one is not None]
        if not known or len(known) < len(listed):
            return None
        places = {one.origin_m for one in known}
        placed, sizes, bottoms, centres, flows = (
            _added(getattr(one, name) for one in known) for name in TALLIES
        )
        return BoxStatistics(
            placed,
            sizes,
            bottoms,
            centres,
            flows,
            sum(one.frames for one in known),
            max(one.most for one in known),
            sum(one.repeated for one in known),
            max(one.yaw_rad for one in known),
            places.pop() if len(places) == 1 else None,
            all(one.is_origin_known for one in known),
        )


class BoxTally:
    """Statistics that grow while boxes stream by."""

    def __init__(self) -> None:
        self._placed, self._sizes, self._bottoms = Counter[int](), Counter[int](), Counter[int]()
        self._centres, self._flows = Counter[int](), Counter[int]()
        self._frames = self._most = self._repeated = 0
        self._last: tuple[int, float] | None = None
        self.yaw_rad = 0.0

    def add(
        self,
        frame: NDArray[np.int64],
        cls: NDArray[np.uint8],
        centre_m: NDArray[np.float64],
        size_m: NDArray[np.float64],
        rotation: NDArray[np.float64],
    ) -> None:
        """Add boxes of whole frames, n of them, in the vehicle frame: the columns of a BoxBatch."""
        if not frame.size:
            return
        _, first, per_frame = np.unique(frame, return_index=True, return_counts=True)
        self._note_repeated(first, per_frame, centre_m)
        self._frames += per_frame.size
        self._most = max(self._most, int(per_frame.max()))
        which = cls.astype(np.int64)
        x, y, z = centre_m.T
        sector = np.floor((np.arctan2(y, x) + math.pi / 4) / (math.pi / 2)).astype(np.int64) % len(SECTORS)
        distance_m = np.hypot(x, y)
        ring = np.searchsorted(RINGS_M, distance_m, side="right") - 1
        _count(self._placed, which * PLACES + sector * (len(RINGS_M) - 1) + ring)
        edges = which[:, None] * 3 + np.arange(3)
        _count(self._sizes, edges * SIZE_STEPS + _steps(size_m, 0.0, SIZE_STEPS))
        near = distance_m <= NEAR_M
        bottom_m = (z - rotation[:, 2, 2] * size_m[:, 2] / 2)[near]
        _count(self._bottoms, which[near] * HEIGHT_STEPS + _steps(bottom_m, LOWEST_M, HEIGHT_STEPS))
        _count(self._centres, which[near] * HEIGHT_STEPS + _steps(z[near], LOWEST_M, HEIGHT_STEPS))
        cars = which == 0
        _count(self._flows, _flows(x, y, rotation[:, :, 0])[cars].ravel())
        _count(self._flows, _rows(frame[cars], centre_m[cars], rotation[cars, :, 0]))
        self._flows.pop(_NO_FLOW, None)

    def _note_repeated(
        self, first: NDArray[np.int64], per_frame: NDArray[np.int64], centre_m: NDArray[np.float64]
    ) -> None:
        """Count frames with exactly the boxes of the frame before; `first`: rows where frames begin."""
        sums = np.add.reduceat(centre_m @ np.array([1.0, math.sqrt(2.0), math.sqrt(3.0)]), first)
        marks = list(zip(per_frame.tolist(), sums.tolist(), strict=True))
        before = [self._last, *marks[:-1]]
        self._repeated += sum(one == other for one, other in zip(before, marks, strict=True))
        self._last = marks[-1]

    def statistics(self, origin_m: Vec3 | None = None, is_origin_known: bool = False) -> BoxStatistics:
        """Return the statistics of the boxes added so far."""
        tallies = self._placed, self._sizes, self._bottoms, self._centres, self._flows
        numbers = self._frames, self._most, self._repeated, self.yaw_rad
        return BoxStatistics(*tallies, *numbers, origin_m, is_origin_known)


TALLIES = ("placed", "sizes", "bottoms", "centres", "flows")
_NO_FLOW = len(FLOWS)


def _added(tallies: Iterable[Counter[int]]) -> Counter[int]:
    total = Counter[int]()
    for tally in tallies:
        total.update(tally)
    return total


def _flows(x: NDArray[np.float64], y: NDArray[np.float64], heading: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the places of boxes in FLOWS but ROWS (n, 4), _NO_FLOW for none; heading (n, 3): along their length."""
    across = np.abs(heading[:, 1]) > np.abs(heading[:, 0])
    along_m, aside_m = np.abs(x), np.abs(y)
    ahead = (aside_m < _LANE_M) & (along_m > _LANE_M) & (along_m < _ROAD_M)
    beside = (along_m < _LANE_M) & (aside_m > _LANE_M) & (aside_m < _ROAD_M)
    near, far = _NEXT_LANE_M
    comes = ~across & (heading[:, 0] < 0.0) & (aside_m > near) & (aside_m < far) & (along_m < _ROAD_M)
    lane = np.where(ahead, across, np.where(beside, 2 + across, _NO_FLOW))
    side = np.where(comes, np.where(y > 0.0, 4, 5), _NO_FLOW)
    own = ~across & ahead & (aside_m < _OWN_LANE_M)
    way = np.where(own, np.where(heading[:, 0] > 0.0, 6, 7), _NO_FLOW)
    tens = np.rint(np.degrees(np.arctan2(heading[:, 1], heading[:, 0])) / 10.0) % 9
    axes = np.where(np.hypot(x, y) < _ROAD_M, AXES.start + tens, _NO_FLOW)
    return np.stack([lane, side, way, axes], axis=1).astype(np.int64)


def _rows(
    frame: NDArray[np.int64], centre_m: NDArray[np.float64], heading: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the places in ROWS of pairs of cars that are neighbours along x; heading (n, 3)."""
    order = np.lexsort((centre_m[:, 0], frame))
    frame, place_m = frame[order], centre_m[order, :2]
    yaw = np.arctan2(heading[order, 1], heading[order, 0])
    found = [np.zeros(0, np.int64)]
    for step in range(1, min(_NEIGHBOURS, frame.size - 1) + 1):
        between_m = place_m[step:] - place_m[:-step]
        apart_m = np.hypot(between_m[:, 0], between_m[:, 1])
        is_row = (frame[step:] == frame[:-step]) & (apart_m > _IN_ROW_M[0]) & (apart_m < _IN_ROW_M[1])
        is_row &= _off_multiples(yaw[step:] - yaw[:-step], math.pi) < _ALIKE_RAD
        is_row &= _off_multiples(yaw[step:], math.pi / 2) > _TURNED_RAD
        line = np.arctan2(between_m[:, 1], between_m[:, 0])
        for place, sign in ((ROWS.start, 1.0), (ROWS.start + 1, -1.0)):
            fits = is_row & (_off_multiples(line - sign * yaw[step:], math.pi / 2) < _ON_LINE_RAD)
            found.append(np.full(np.count_nonzero(fits), place))
    return np.concatenate(found)


def _off_multiples(angle_rad: NDArray[np.float64], of_rad: float) -> NDArray[np.float64]:
    """Return how far angles are from the nearest multiple of one."""
    return np.abs(angle_rad - of_rad * np.rint(angle_rad / of_rad))


def _steps(values_m: NDArray[np.float64], low_m: float, count: int) -> NDArray[np.int64]:
    return np.clip(np.floor((values_m - low_m) / STEP_M), 0, count - 1).astype(np.int64)


def _count(tally: Counter[int], places: NDArray[np.int64]) -> None:
    found, numbers = np.unique(places, return_counts=True)
    tally.update(dict(zip(found.tolist(), numbers.tolist(), strict=True)))
