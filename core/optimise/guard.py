"""Check a gain found in a few frames: the same comparison in other frames and under other assumptions."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError, IsStale, never_stale
from riglens.core.figures.hits import RESOLVED
from riglens.core.optimise.objectives import HIT_COVERAGE, Objective, sensors_for
from riglens.core.optimise.weights import EVEN, Weights
from riglens.core.review.tolerance import disturbed, errors_count, profile_called, unit_draws
from riglens.core.rig.edits import without
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kind_of
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Verdict = Literal["resolved", "not resolved", "not checked"]
HELD_OUT = "held-out frames"
SEEDS, DRAWS, FEW = 3, 4, 250
"""Other seeds, draws of mount errors, and frames of the cases that vary an assumption."""
KEPT, STANDARD_ERRORS = 0.5, 2.0
"""Share of the gain in the frames of choice that a resolved gain keeps, and the standard errors by which it exceeds
0."""


@dataclass(frozen=True)
class GuardResult:
    """Gain of a proposal over its reference in one case, its standard error paired by frame, and its share of the gain
    in the frames in which the proposal was chosen; whether other data made it."""

    case: str
    gain: float
    se: float
    share: float
    is_other_data: bool = False

    @property
    def is_clear(self) -> bool:
        """Return whether it is a gain of at least two standard errors."""
        return self.gain > 0.0 and self.gain >= STANDARD_ERRORS * self.se


@dataclass(frozen=True)
class Sample:
    """A figure of single objects (k,) in `frames` frames, with their classes, weights within a class, and places of
    frames; and the weights of classes."""

    values: Doubles
    cls: NDArray[np.uint8]
    ring: Doubles
    frame: NDArray[np.int64]
    frames: int
    by_class: Doubles

    @classmethod
    def mean_of(cls, samples: Sequence[Sample]) -> Sample:
        """Average samples of the same objects, one by one."""
        return replace(samples[0], values=np.mean([one.values for one in samples], axis=0))

    @property
    def value(self) -> float:
        """Mean over the classes that occur of the mean over their objects."""
        return self._mean(self.values)[0]

    def gain_over(self, other: Sample) -> tuple[float, float]:
        """Return the gain over another rig on the same objects, and its standard error.

        Frames are what was drawn: a ratio of totals over frames, linearised (Cochran, Sampling Techniques, 1977,
        chapter 6), without a correction for a finite number of frames: the claim is about traffic like this.
        """
        more = self.values - other.values
        gain, misses = self._mean(more)
        by_frame = np.bincount(self.frame, misses, self.frames)
        return gain, float(np.sqrt((by_frame**2).sum() * self.frames / (self.frames - 1)))

    def _mean(self, values: Doubles) -> tuple[float, Doubles]:
        """Return the mean of the classes' means, and what each object (k,) contributes beyond it."""
        total = np.bincount(self.cls, self.ring, len(CLASSES))
        there = float(self.by_class[total > 0.0].sum()) or 1.0
        whole = np.where(total > 0.0, total, 1.0)
        means = np.bincount(self.cls, values * self.ring, len(CLASSES)) / whole
        each = (values - means[self.cls]) / whole[self.cls] / there * self.ring * self.by_class[self.cls]
        return float((means * self.by_class).sum() / there), each


Sampler = Callable[[Rig, TargetSettings, tuple[int, int]], Sample]
"""A figure of a rig in frames first..end-1 of the sampling order."""


class OtherTraffic(NamedTuple):
    """A case of the guard in frames of other traffic: the frames of choice in another state, or other data."""

    case: str
    sampler: Sampler
    frames: tuple[int, int]
    is_other_data: bool


class Evaluator:
    """An objective of rigs on the objects of one set of traffic, hit coverage in place of one that is not of objects;
    only sensors of the kind that makes it are cast."""

    def __init__(
        self,
        traffic: Traffic,
        threads: int | None = None,
        goal: Objective = HIT_COVERAGE,
        weights: Weights = EVEN,
        is_stale: IsStale = never_stale,
    ) -> None:
        self._traffic, self._engine = traffic, TargetEngine(traffic, threads)
        self._goal = goal if goal.is_guarded else HIT_COVERAGE
        self._weights, self._is_stale = weights, is_stale

    def __call__(self, rig: Rig, settings: TargetSettings, frames: tuple[int, int]) -> Sample:
        """Evaluate a rig; raise Cancelled when stale. Objects without the figure are left out."""
        (first, end), figure = frames, self._goal.figure
        assert figure is not None
        alone = rig.only(sensors_for(self._goal, rig))
        counted = self._engine.evaluate(alone, settings, end, cancel=self._is_stale)
        frame, values = counted.groups.frame, figure.values(counted)
        used = (frame >= first) & ~np.isnan(values)
        box = counted.objects.box[used]
        ring = self._weights.at(self._traffic.distance_m[box])
        cls = self._traffic.cls[box]
        return Sample(values[used], cls, ring, frame[used] - first, end - first, self._weights.by_class)


def with_worst_failure(sampler: Sampler) -> Sampler:
    """Return the sampler of rigs with the one LiDAR failed that they miss most."""

    def sample(rig: Rig, settings: TargetSettings, frames: tuple[int, int]) -> Sample:
        left = [without(rig, (lidar.name,)) for lidar in rig.enabled_lidars()]
        return min((sampler(one, settings, frames) for one in left or [rig]), key=lambda one: one.value)

    return sample


def guard(
    proposal: Rig,
    reference: Rig,
    sampler: Sampler,
    settings: TargetSettings,
    frames: int,
    last: int,
    others: Sequence[OtherTraffic] = (),
) -> Generator[GuardResult, None, float]:
    """Compare a proposal with a reference case by case, and return the gain in the first `frames` frames.

    settings: those with which the proposal was chosen. Held-out frames, up to `last`, follow the frames of choice;
    there the phases of LiDARs are random whatever was chosen with. others: further traffic to
    compare them in.
    """

    def gain(
        cases: Iterable[tuple[TargetSettings, Rig, Rig]], where: tuple[int, int], by: Sampler = sampler
    ) -> tuple[float, float]:
        mine, theirs = list[Sample](), list[Sample]()
        for how, better, worse in cases:
            mine.append(by(better, how, where))
            theirs.append(by(worse, how, where))
        return Sample.mean_of(mine).gain_over(Sample.mean_of(theirs))

    if frames < 2 or last - frames < 2:
        raise InputError(f"needs 2 frames beyond the {frames} to choose by (the data has {last})", "held_out")
    in_sample, _ = gain([(settings, proposal, reference)], (0, frames))
    usual, few = replace(settings, phase="random"), (frames, min(last, frames + FEW))
    cases = [(HELD_OUT, [(usual, proposal, reference)], (frames, last))]
    seeds = [(replace(usual, seed=settings.seed + 1 + more), proposal, reference) for more in range(SEEDS)]
    cases.append(("other seeds", seeds, few))
    moved = [(usual, *pair) for pair in _with_errors(proposal, reference, settings.seed)]
    cases.append(("mount errors of 3 mm and 0.1°", moved, few))
    cases.append(("plain boxes", [(replace(usual, shape="box"), proposal, reference)], few))
    cases.append(("fixed phase", [(replace(usual, phase="0"), proposal, reference)], few))
    assumed = assumed_ranges(proposal, reference)
    if assumed:
        cases.append(
            ("assumed range halved", [(usual, _halved(proposal, assumed), _halved(reference, assumed))], few)
        )
    checks = [(OtherTraffic(name, sampler, where, False), pairs) for name, pairs, where in cases]
    checks += [(other, [(usual, proposal, reference)]) for other in others]
    for one, pairs in checks:
        more, se = gain(pairs, one.frames, one.sampler)
        yield GuardResult(one.case, more, se, more / in_sample if in_sample > 0.0 else 0.0, one.is_other_data)
    return in_sample


def verdict(kept: Sequence[GuardResult]) -> Verdict:
    """Return "resolved" where the gain in held-out frames is large enough to tell rigs apart, two standard errors and
    half of the gain when chosen, and two standard errors in all other data."""
    held_out = next((one for one in kept if one.case == HELD_OUT), None)
    if held_out is None:
        return "not checked"
    is_resolved = held_out.gain >= RESOLVED and held_out.is_clear and held_out.share >= KEPT
    is_resolved &= all(one.is_clear for one in kept if one.is_other_data)
    return "resolved" if is_resolved else "not resolved"


def weak_cases(kept: Sequence[GuardResult]) -> tuple[GuardResult, ...]:
    """Return the cases that keep less than half of the gain."""
    return tuple(one for one in kept if one.share < KEPT)


def assumed_ranges(proposal: Rig, reference: Rig) -> frozenset[str]:
    """Return the models with a range law that only one of two rigs has, whose maker states no range by reflectivity."""
    own = {sensor.name: sensor for sensor in reference.sensors}
    theirs = {sensor.name: sensor for sensor in proposal.sensors}
    differ = [s for s in (*own.values(), *theirs.values()) if own.get(s.name) != theirs.get(s.name)]
    models = {s.model for s in differ if s.model is not None and kind_of(s).has_range_law}
    return frozenset(name for name in models if not default_library().entry(name).range_anchors())


def _halved(rig: Rig, models: frozenset[str]) -> Rig:
    def halved(sensor: Sensor) -> Sensor:
        if sensor.model not in models:
            return sensor
        low, high = sensor.range_m
        return sensor.replace(range_m=(low, max(high / 2.0, 1.001 * low)))

    return rig.model_copy(update={"sensors": tuple(map(halved, rig.sensors))})


def _with_errors(first: Rig, second: Rig, seed: int) -> list[tuple[Rig, Rig]]:
    """Return both rigs with the same few draws of the assembly profile; sensors that both have come first."""
    profile = profile_called("assembly")
    draws = unit_draws(DRAWS, max(errors_count(first), errors_count(second)), seed)

    def moved(rig: Rig, errors: Doubles) -> Rig:
        return disturbed(rig, profile, errors[: errors_count(rig)])[0]

    return [(moved(first, one), moved(second, one)) for one in draws]
