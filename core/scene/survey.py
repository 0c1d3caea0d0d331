"""Survey a box data set: counts by class, direction and distance, sizes, the ground, and what is implausible."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES, BoxSource, DataReport, Progress
from riglens.core.scene.statistics import (
    AXES,
    FLOWS,
    HEIGHT_STEPS,
    LOWEST_M,
    NEAR_M,
    RINGS_M,
    ROWS,
    SECTORS,
    SIZE_STEPS,
    STEP_M,
    BoxStatistics,
)

BARE_SHARE = 0.01
FEWEST_BOXES = 20
LARGEST_SPREAD_M = 0.5
GROUND_IS_RIGHT_M = 0.2
"""Bottoms of labelled boxes are rarely nearer to the road than that; the ROI starts at z = 0."""
_PEAK_WIDTH_M, _PEAK_SHARE, _PEAK_BOXES, _VALLEY_SHARE = 0.05, 0.2, 3.0, 0.6
"""A second height: a fifth as many bottoms as at the first, smoothed by this width, and fewer of them in between."""


@dataclass(frozen=True)
class Ground:
    """The ground as estimated from the bottoms of near boxes: height_m is their median, half of them lie in between_m.

    Heights are in the frame of the boxes; `boxes` counts those of class `cls` within NEAR_M. `peaks_m`: heights around
    which they crowd; two of them mean two grounds, or two ways of labelling, and the median is neither.
    """

    height_m: float
    between_m: tuple[float, float]
    boxes: int
    cls: str
    peaks_m: tuple[float, ...] = ()

    @property
    def is_certain(self) -> bool:
        """Return whether there are enough boxes, and they agree."""
        low, high = self.between_m
        return self.boxes >= FEWEST_BOXES and high - low <= LARGEST_SPREAD_M and len(self.peaks_m) < 2

    @property
    def lift_m(self) -> float:
        """Return the shift of z that puts the ground at 0, in whole centimetres."""
        return -round(self.height_m, 2)

    def text(self) -> str:
        """Return the estimate in words."""
        low, high = self.between_m
        return (
            f"z = {self.height_m:.2f} m by the bottoms of {self.boxes:,} {self.cls} boxes within {NEAR_M:g} m, half of "
            f"them from {low:.2f} to {high:.2f}{self._crowds()}"
        )

    def _crowds(self) -> str:
        """Return the heights around which the bottoms cluster, as text, where there are several."""
        if len(self.peaks_m) < 2:
            return ""
        return f", crowded around {' and '.join(f'{peak:.2f}' for peak in self.peaks_m)}"


@dataclass(frozen=True)
class Survey:
    """Counts (class, sector, ring), median sizes (class, length width height) in metres, NaN without boxes."""

    data: DataReport
    statistics: BoxStatistics
    counts: NDArray[np.int64]
    sizes_m: NDArray[np.float64]
    ground: Ground | None

    @classmethod
    def of(cls, data: DataReport) -> Self | None:
        """Return the survey of data that were read; None without statistics of them."""
        known = data.statistics
        if known is None:
            return None
        counts = _dense(known.placed, (len(CLASSES), len(SECTORS), len(RINGS_M) - 1))
        edges = _dense(known.sizes, (len(CLASSES), 3, SIZE_STEPS))
        sizes_m = np.array([[_quantile(edge, 0.0, 0.5) for edge in one] for one in edges])
        return cls(data, known, counts, sizes_m, _ground(_dense(known.bottoms, (len(CLASSES), HEIGHT_STEPS))))

    @property
    def frames_with_boxes(self) -> int:
        """Number of frames with boxes."""
        return self.statistics.frames

    @property
    def most_in_a_frame(self) -> int:
        """Most boxes in one frame."""
        return self.statistics.most

    @property
    def boxes_per_frame(self) -> float:
        """Mapped boxes per frame, on average over all frames."""
        return float(self.counts.sum() / max(self.data.frames, 1))

    def bare_sectors(self) -> dict[str, int]:
        """Return the sectors around the car with almost no boxes while others have some, and their counts."""
        boxes = dict(zip(SECTORS, self.counts.sum(axis=(0, 2)).tolist(), strict=True))
        few = BARE_SHARE * sum(boxes.values())
        return {name: count for name, count in boxes.items() if count < few}


def survey(source: BoxSource, progress: Progress | None = None) -> Survey:
    """Read a data set once and count; memory does not grow with it. InputError on bad input."""
    for _ in source.batches(progress):
        pass
    found = Survey.of(source.report())
    assert found is not None
    return found


# ---------------------------------------------------------------- what is implausible

Advice = Callable[[str, object], str]
"""Words of a front end for a field with a value: `origin_m` with (0, 0, 1.73)."""


@dataclass(frozen=True)
class Doubt:
    """An implausible fact about box data, and values of fields any of which may mend it; nothing is mended unasked."""

    fact: str
    remedies: Mapping[str, object] = field(default_factory=dict)

    def sentence(self, advice: Advice) -> str:
        """Return fact and remedies in the words of a front end."""
        said = " or ".join(advice(name, value) for name, value in self.remedies.items())
        return f"{self.fact}: use {said}" if said else self.fact


def _off_the_ground(found: Survey) -> Doubt | None:
    """Doubt that the ground is at z = 0, where the region and every mount begin, unless the format says so."""
    ground, known = found.ground, found.statistics
    if ground is None or known.is_origin_known or not ground.is_certain:
        return None
    if abs(ground.height_m) <= GROUND_IS_RIGHT_M:
        return None
    remedies: dict[str, object] = {"find_ground": True}
    if known.origin_m is not None:
        x, y, z = known.origin_m
        remedies["origin_m"] = (x, y, float(f"{z + ground.lift_m:.4g}"))
    return Doubt(f"the ground is not at z = 0 but at {ground.height_m:.2f} m", remedies)


def _at_the_foot(found: Survey) -> Doubt | None:
    """Doubt that z is the middle of boxes: of real traffic the lower sides agree better than the middles."""
    tallies = found.statistics.centres, found.statistics.bottoms
    middle_m, bottom_m = (_dense(one, (len(CLASSES), HEIGHT_STEPS)).sum(axis=0) for one in tallies)
    if middle_m.sum() < _FEWEST_FEET:
        return None
    spread = [_quantile(one, LOWEST_M, 0.75) - _quantile(one, LOWEST_M, 0.25) for one in (middle_m, bottom_m)]
    low_m = _quantile(bottom_m, LOWEST_M, 0.5)
    if spread[0] >= _FOOT_SPREAD * spread[1] or low_m > -GROUND_IS_RIGHT_M:
        return None
    return Doubt(
        f"z seems to be the foot of the boxes, not their middle: within {NEAR_M:g} m half of all z lie within "
        f"{spread[0]:.2f} m, half of all lower sides within {spread[1]:.2f} m; add half the height to z"
    )


def _swapped(found: Survey) -> Doubt | None:
    """Doubt that length and width are what they are called."""
    length, width, _ = found.sizes_m[0].tolist()
    if found.counts[0].sum() < FEWEST_BOXES or not length * _WIDER < width:
        return None
    return Doubt(
        f"cars are wider than long (half of them {length:.2f} x {width:.2f} m or less): length and width are swapped, "
        "as nuScenes writes w l h; rename the columns"
    )


def _sizes_off(found: Survey) -> Doubt | None:
    """Doubt that sizes are whole edges in metres."""
    for cls, (name, limits) in enumerate(zip(CLASSES, USUAL_M, strict=True)):
        edges = found.sizes_m[cls].tolist()
        if found.counts[cls].sum() < FEWEST_BOXES or (cls == 0 and edges[0] < edges[1]):
            continue
        if any(not low <= edge <= high for edge, (low, high) in zip(edges, limits, strict=True)):
            shown = " x ".join(f"{edge:.2f}" for edge in edges)
            return Doubt(
                f"the middle {name} is {shown} m (length, width, height): half edges, as CARLA's extents are, another "
                "unit, or another class"
            )
    return None


def _degrees(found: Survey) -> Doubt | None:
    """Doubt that yaw is in radians."""
    yaw = found.statistics.yaw_rad
    if yaw <= _FULL_TURN_RAD:
        return None
    return Doubt(
        f"yaw reaches {yaw:g}, more than a full turn: it is read as radians; convert it if it is in degrees"
    )


def _turned(found: Survey) -> Doubt | None:
    """Doubt that x points ahead, boxes lie along their lanes, and y points left."""
    ahead_along, ahead_across, side_along, side_across, left, right, away, back = (
        found.statistics.flows[place] for place in range(ROWS.start)
    )
    ahead, side = ahead_along + ahead_across, side_along + side_across
    across = ahead_across / max(ahead, 1) + side_across / max(side, 1)
    is_ahead_turned = ahead >= FEWEST_BOXES and ahead_across > _ACROSS_ALONE * ahead
    fewer = min(ahead, side)
    if is_ahead_turned or (fewer >= _FEWEST_FLOW and across > _ACROSS + 1.0 / math.sqrt(fewer)):
        return Doubt(
            f"cars stand across the road ({ahead_across:,} of {ahead:,} in the lane ahead, {side_across:,} of {side:,} "
            "beside the car along y): x does not point ahead, or yaw is turned by 90°"
        )
    if away + back >= _FEWEST_ONCOMING and away < _AWAY * (away + back):
        return Doubt(
            f"cars in the car's own lane head back ({back:,} of {away + back:,}): x points backwards, or yaw is turned "
            "by 180°"
        )
    if left + right >= _FEWEST_ONCOMING and left < _ONCOMING_LEFT * (left + right):
        return Doubt(
            f"oncoming cars keep to the right ({right:,} of {left + right:,}): left-hand traffic, or a y axis that "
            "points right; then change the sign of y and yaw"
        )
    return None


def _aslant(found: Survey) -> Doubt | None:
    """Doubt that axes and yaw are the car's: most roads run along or across its x axis."""
    cars = [found.statistics.flows[place] for place in range(len(FLOWS))[AXES]]
    best = int(np.argmax(cars))
    angle = 10 * best
    if angle in _STRAIGHT_DEG or sum(cars) < _FEWEST_ASLANT:
        return None
    if cars[best] < _ASLANT * sum(cars) or cars[best] < 2 * cars[0]:
        return None
    return Doubt(
        f"cars stand aslant ({cars[best]:,} of {sum(cars):,} within 40 m at about {angle}° to an axis, {cars[0]:,} "
        "along the axes): x does not point ahead, or yaw is turned; yaw counts from x to the left"
    )


def _yaw_reversed(found: Survey) -> Doubt | None:
    """Doubt the sign of yaw: cars in a row, or side by side, stand along or across their row; not if all is aslant."""
    right, reversed_ = (found.statistics.flows[place] for place in range(len(FLOWS))[ROWS])
    if reversed_ < _FEWEST_ROWS or reversed_ < 2 * right or _aslant(found) is not None:
        return None
    return Doubt(
        f"cars head against their rows ({reversed_:,} pairs of neighbours fit yaw of the other sign, {right:,} this "
        "one): yaw must count to the left; change its sign, or that of y"
    )


def _repeated(found: Survey) -> Doubt | None:
    """Doubt that every frame is a new one."""
    known = found.statistics
    if known.frames < _FEWEST_FRAMES or known.repeated <= known.frames // 2:
        return None
    return Doubt(
        f"{known.repeated:,} of {known.frames:,} frames equal the one before: they add nothing, and errors of the "
        "figures are larger than stated"
    )


def _one_sided(found: Survey) -> Doubt | None:
    """Doubt that the boxes of a data set of some size are labelled on every side."""
    return one_sided(found) if found.counts.sum() >= _FEWEST_SIDES else None


def one_sided(found: Survey) -> Doubt | None:
    """Doubt that boxes are labelled on every side, however few there are."""
    bare = found.bare_sectors()
    if not bare:
        return None
    listed = ", ".join(f"{name} ({count:,})" for name, count in bare.items())
    return Doubt(
        f"almost no boxes {listed}: the data may not cover every side, and coverage there gains almost nothing"
    )


USUAL_M: tuple[tuple[tuple[float, float], ...], ...] = (
    ((3.0, 12.0), (1.3, 3.2), (1.1, 4.2)),
    ((0.9, 3.0), (0.3, 1.3), (0.8, 2.3)),
    ((0.25, 1.6), (0.25, 1.3), (1.1, 2.2)),
)
"""Between which median length, width and height of each class lie in public data sets, with room to spare."""
_FULL_TURN_RAD = 2.0 * math.pi + 0.01
_WIDER = 1.1
_FEWEST_FEET, _FOOT_SPREAD = 200, 0.95
"""In KITTI and nuScenes the middles of near boxes spread 1.1 to 1.6 times as wide as their lower sides."""
_FEWEST_FLOW, _ACROSS_ALONE, _ACROSS = 10, 0.6, 1.0
"""Shares of cars that head across, in the lane and both directions together: KITTI 0.03, 0.13, nuScenes 0.3, 0.86. A
turn by 90° makes about 2 less the share of both together, hence the middle, and the more the fewer the cars are."""
_STRAIGHT_DEG, _FEWEST_ASLANT, _ASLANT = (0, 10, 80), 100, 0.2
"""Of cars in KITTI 74 %, in nuScenes 53 % head within 5° of an axis, at most 13 % at any other ten degrees; of single
sequences, whose road may bend, up to twice as many at 10°."""
_FEWEST_ROWS = 20
"""Of neighbours in KITTI 483 fit yaw as it is and 45 reversed, in nuScenes 414 and 23."""
_AWAY = 0.35
"""Share of cars in the own lane that head ahead: KITTI 0.93, nuScenes 0.83."""
_FEWEST_ONCOMING, _ONCOMING_LEFT = 30, 0.25
"""Of oncoming cars in KITTI and nuScenes (Boston) nine in ten are on the left."""
_FEWEST_FRAMES = 5
_FEWEST_SIDES = 200
CHECKS: tuple[Callable[[Survey], Doubt | None], ...] = (
    _off_the_ground, _at_the_foot, _swapped, _sizes_off, _degrees, _turned, _aslant, _yaw_reversed, _repeated,
    _one_sided,
)  # fmt: skip
"""Checks of plausibility; a new one is a function and its place here."""


def doubts(data: DataReport) -> list[Doubt]:
    """Return what is implausible about data: every front end shows it wherever it shows figures of them."""
    found = Survey.of(data)
    return [] if found is None else [doubt for check in CHECKS if (doubt := check(found)) is not None]


def doubtful(data: DataReport, advice: Advice) -> list[str]:
    """Return a line for each doubt, with the name of the data and remedies in the words of a front end."""
    return [f"{data.short_source}: {doubt.sentence(advice)}" for doubt in doubts(data)]


def notes_on(data: DataReport) -> list[str]:
    """Return how data were read, and what is implausible about them, for documents."""
    return [*data.notes, *(doubt.fact for doubt in doubts(data))]


# ---------------------------------------------------------------- from tallies


def _dense(tally: Counter[int], shape: tuple[int, ...]) -> NDArray[np.int64]:
    found = np.zeros(shape, np.int64)
    found.ravel()[list(tally.keys())] = list(tally.values())
    return found


def _quantile(counts: NDArray[np.int64], low_m: float, share: float) -> float:
    """Return the middle of the step in which the quantile lies; NaN without values."""
    if not (total := int(counts.sum())):
        return math.nan
    return round(float(low_m + (np.searchsorted(np.cumsum(counts), share * total) + 0.5) * STEP_M), 3)


def _peaks(counts: NDArray[np.int64]) -> tuple[float, ...]:
    """Return the heights around which bottoms crowd, lowest first: maxima with a clear gap between them."""
    reach = np.arange(-4 * _PEAK_WIDTH_M, 4 * _PEAK_WIDTH_M + STEP_M / 2, STEP_M)
    heights = np.convolve(counts, np.exp(-0.5 * (reach / _PEAK_WIDTH_M) ** 2), mode="same")
    least = max(_PEAK_BOXES, _PEAK_SHARE * float(heights.max()))
    kept: list[int] = []
    for place in np.flatnonzero(heights >= least).tolist():
        gap = heights[kept[-1] : place + 1].min() if kept else 0.0
        if not kept or gap <= _VALLEY_SHARE * min(heights[kept[-1]], heights[place]):
            kept.append(place)
        elif heights[place] > heights[kept[-1]]:
            kept[-1] = place
    return tuple(round(LOWEST_M + (place + 0.5) * STEP_M, 2) for place in kept)


def _ground(bottoms: NDArray[np.int64]) -> Ground | None:
    """Return the ground from the first class with enough nearby boxes: cars are on the road, people also on kerbs and
    stairs. bottoms (class, step)."""
    totals = bottoms.sum(axis=1)
    enough = np.flatnonzero(totals >= FEWEST_BOXES)
    place = int(enough[0] if enough.size else totals.argmax())
    heights = bottoms[place]
    if not totals[place]:
        return None
    low, middle, high = (_quantile(heights, LOWEST_M, share) for share in (0.25, 0.5, 0.75))
    return Ground(middle, (low, high), int(totals[place]), CLASSES[place], _peaks(heights))
