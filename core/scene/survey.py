"""Survey a box data set: counts by class, direction and distance, sizes, and the ground below it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES, BoxBatch, BoxSource, DataReport, Progress

SECTORS = ("front", "left", "rear", "right")
"""Quarters around the car, each 45° to both sides of its direction."""

RINGS_M = (0.0, 10.0, 20.0, 30.0, 50.0, math.inf)
"""Borders of the distances, horizontally from the car's middle to the middle of a box."""

NEAR_M = 20.0
"""Only boxes this near determine the ground: farther away the road may rise or fall."""

BARE_SHARE = 0.01
FEWEST_BOXES = 20
LARGEST_SPREAD_M = 0.5
_STEP_M = 0.01
_PEAK_WIDTH_M, _PEAK_SHARE, _PEAK_BOXES, _VALLEY_SHARE = 0.05, 0.2, 3.0, 0.6
"""A second height: a fifth as many bottoms as at the first, smoothed by this width, and fewer of them in between."""
_HEIGHT_RANGE_M = 20.0
_SIZE_RANGE_M = 40.0


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
    counts: NDArray[np.int64]
    sizes_m: NDArray[np.float64]
    frames_with_boxes: int
    most_in_a_frame: int
    ground: Ground | None

    @property
    def boxes_per_frame(self) -> float:
        """Mapped boxes per frame, on average over all frames."""
        return float(self.counts.sum() / max(self.data.frames, 1))

    def bare_sectors(self) -> dict[str, int]:
        """Return the sectors around the car with almost no boxes while others have some, and their counts."""
        boxes = dict(zip(SECTORS, self.counts.sum(axis=(0, 2)).tolist(), strict=True))
        few = BARE_SHARE * sum(boxes.values())
        return {name: count for name, count in boxes.items() if count < few}


class _Histogram:
    """Counts of values in steps of a centimetre, for quantiles with flat memory; values beyond the ends count there."""

    def __init__(self, low_m: float, high_m: float) -> None:
        self._low_m = low_m
        self._counts = np.zeros(round((high_m - low_m) / _STEP_M), np.int64)

    def add(self, values_m: NDArray[np.float64]) -> None:
        places = np.floor((values_m - self._low_m) / _STEP_M)
        places = np.clip(places, 0, self._counts.size - 1).astype(np.int64)
        self._counts += np.bincount(places, minlength=self._counts.size)

    @property
    def total(self) -> int:
        return int(self._counts.sum())

    def quantile(self, share: float) -> float:
        """Return the middle of the step in which the quantile lies; NaN without values."""
        if not self.total:
            return math.nan
        place = np.searchsorted(np.cumsum(self._counts), share * self.total)
        return round(float(self._low_m + (place + 0.5) * _STEP_M), 3)

    def peaks(self) -> tuple[float, ...]:
        """Return where the values crowd, lowest first: maxima with a clear gap between them."""
        reach = np.arange(-4 * _PEAK_WIDTH_M, 4 * _PEAK_WIDTH_M + _STEP_M / 2, _STEP_M)
        heights = np.convolve(self._counts, np.exp(-0.5 * (reach / _PEAK_WIDTH_M) ** 2), mode="same")
        least = max(_PEAK_BOXES, _PEAK_SHARE * float(heights.max()))
        kept: list[int] = []
        for place in np.flatnonzero(heights >= least).tolist():
            gap = heights[kept[-1] : place + 1].min() if kept else 0.0
            if not kept or gap <= _VALLEY_SHARE * min(heights[kept[-1]], heights[place]):
                kept.append(place)
            elif heights[place] > heights[kept[-1]]:
                kept[-1] = place
        return tuple(round(self._low_m + (place + 0.5) * _STEP_M, 2) for place in kept)


class _Tally:
    """Counters that are filled while the boxes stream by."""

    def __init__(self) -> None:
        self.counts = np.zeros((len(CLASSES), len(SECTORS), len(RINGS_M) - 1), np.int64)
        self.sizes = [[_Histogram(0.0, _SIZE_RANGE_M) for _ in range(3)] for _ in CLASSES]
        self.bottoms = [_Histogram(-_HEIGHT_RANGE_M, _HEIGHT_RANGE_M) for _ in CLASSES]
        self.frames, self.most = 0, 0

    def add(self, batch: BoxBatch) -> None:
        if not batch.frame.size:
            return
        per_frame = np.unique(batch.frame, return_counts=True)[1]
        self.frames += per_frame.size
        self.most = max(self.most, int(per_frame.max()))
        x, y = batch.centre_m[:, 0], batch.centre_m[:, 1]
        sector = np.floor((np.arctan2(y, x) + math.pi / 4) / (math.pi / 2)).astype(np.int64) % len(SECTORS)
        distance = np.hypot(x, y)
        ring = np.searchsorted(RINGS_M, distance, side="right") - 1
        np.add.at(self.counts, (batch.cls, sector, ring), 1)
        bottom = batch.centre_m[:, 2] - batch.rotation[:, 2, 2] * batch.size_m[:, 2] / 2
        for cls in range(len(CLASSES)):
            rows = batch.cls == cls
            for axis in range(3):
                self.sizes[cls][axis].add(batch.size_m[rows, axis])
            self.bottoms[cls].add(bottom[rows & (distance <= NEAR_M)])


def survey(source: BoxSource, progress: Progress | None = None) -> Survey:
    """Read a data set once and count; memory does not grow with it. InputError on bad input."""
    tally = _Tally()
    for batch in source.batches(progress):
        tally.add(batch)
    sizes = np.array([[edge.quantile(0.5) for edge in edges] for edges in tally.sizes])
    return Survey(source.report(), tally.counts, sizes, tally.frames, tally.most, _ground(tally.bottoms))


def _ground(bottoms: list[_Histogram]) -> Ground | None:
    """Return the ground from the first class with enough nearby boxes: cars are on the road, people also on kerbs and
    stairs."""
    classes = list(zip(CLASSES, bottoms, strict=True))
    enough = [pair for pair in classes if pair[1].total >= FEWEST_BOXES]
    name, heights = enough[0] if enough else max(classes, key=lambda pair: pair[1].total)
    if not heights.total:
        return None
    between = heights.quantile(0.25), heights.quantile(0.75)
    return Ground(heights.quantile(0.5), between, heights.total, name, heights.peaks())
