"""Check a gain found in a few frames: the same comparison in other frames and under other assumptions."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.review.tolerance import disturbed, errors_count, profile_called, unit_draws
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.engine import TargetEngine, never_stale
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
IsStale = Callable[[], bool]
Verdict = Literal["resolved", "not resolved", "not checked"]
HELD_OUT = "held-out frames"
SEEDS, DRAWS, FEW = 3, 4, 250
"""Other seeds, draws of mount errors, and frames of the cases that vary an assumption."""
KEPT, STANDARD_ERRORS = 0.5, 2.0
"""Share of the gain in the frames of choice that a resolved gain keeps, and the standard errors by which it exceeds
0."""


@dataclass(frozen=True)
class Kept:
    """Gain of a proposal over its reference in one case, its standard error paired by frame, and its share of the gain
    in the frames in which the proposal was chosen."""

    case: str
    gain: float
    se: float
    share: float


@dataclass(frozen=True)
class Sample:
    """Hit coverage of single objects (k,) in `frames` frames, with their classes and places of frames."""

    on_target: Doubles
    cls: NDArray[np.uint8]
    frame: NDArray[np.int64]
    frames: int

    @classmethod
    def mean_of(cls, samples: Sequence[Sample]) -> Sample:
        """Average samples of the same objects, one by one."""
        return replace(samples[0], on_target=np.mean([one.on_target for one in samples], axis=0))

    @property
    def value(self) -> float:
        """Mean over the classes that occur of the mean over their objects."""
        return _mean(self.on_target, self.cls)[0]

    def gain_over(self, other: Sample) -> tuple[float, float]:
        """Gain over another rig on the same objects, and its standard error.

        Frames are what was drawn: a ratio of totals over frames, linearised (Cochran, Sampling Techniques, 1977,
        chapter 6), without a correction for a finite number of frames: the claim is about traffic like this.
        """
        more = self.on_target - other.on_target
        gain, misses = _mean(more, self.cls)
        by_frame = np.bincount(self.frame, misses, self.frames)
        return gain, float(np.sqrt((by_frame**2).sum() * self.frames / (self.frames - 1)))


def _mean(values: Doubles, cls: NDArray[np.uint8]) -> tuple[float, Doubles]:
    """Mean of the classes' means, and what each object (k,) contributes beyond it."""
    objects = np.bincount(cls, minlength=len(CLASSES))
    there = max(1, int((objects > 0).sum()))
    means = np.bincount(cls, values, len(CLASSES)) / np.maximum(objects, 1)
    return float(means.sum() / there), (values - means[cls]) / objects[cls] / there


class Evaluator:
    """Hit coverage of rigs in ranges of frames of one set of traffic."""

    def __init__(self, traffic: Traffic, threads: int | None = None) -> None:
        self._traffic, self._engine = traffic, TargetEngine(traffic, threads)

    def sample(
        self, rig: Rig, settings: TargetSettings, frames: tuple[int, int], is_stale: IsStale = never_stale
    ) -> Sample:
        """Evaluate the LiDARs of a rig in frames first..end-1 of the sampling order; raise Cancelled when stale."""
        first, end = frames
        objects = self._engine.evaluate(rig.with_lidars_alone(), settings, end, cancel=is_stale).objects
        frame = self._traffic.frame_of_box[objects.box]
        used = frame >= first
        box = objects.box[used]
        return Sample(objects.on_target[used], self._traffic.cls[box], frame[used] - first, end - first)


def guard(
    proposal: Rig,
    reference: Rig,
    traffic: Traffic,
    settings: TargetSettings,
    frames: int,
    held_out: int,
    threads: int | None = None,
    is_stale: IsStale = never_stale,
) -> Generator[Kept, None, float]:
    """Compare a proposal with a reference case by case, and return the gain in the first `frames` frames.

    settings: those with which the proposal was chosen. Held-out frames follow the frames of choice; there the phases
    of LiDARs are random whatever was chosen with.
    """
    evaluator = Evaluator(traffic, threads)

    def gain(cases: Iterable[tuple[TargetSettings, Rig, Rig]], where: tuple[int, int]) -> tuple[float, float]:
        mine, theirs = list[Sample](), list[Sample]()
        for how, better, worse in cases:
            mine.append(evaluator.sample(better, how, where, is_stale))
            theirs.append(evaluator.sample(worse, how, where, is_stale))
        return Sample.mean_of(mine).gain_over(Sample.mean_of(theirs))

    last = min(frames + held_out, traffic.frames)
    if frames < 2 or last - frames < 2:
        raise InputError(
            f"needs 2 frames beyond the {frames} to choose by (the data has {traffic.frames})", "held_out"
        )
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
    for name, pairs, where in cases:
        more, se = gain(pairs, where)
        yield Kept(name, more, se, more / in_sample if in_sample > 0.0 else 0.0)
    return in_sample


def verdict(kept: Sequence[Kept]) -> Verdict:
    """Return "resolved" where the gain in held-out frames is two standard errors and half of the gain when chosen."""
    held_out = next((one for one in kept if one.case == HELD_OUT), None)
    if held_out is None:
        return "not checked"
    is_resolved = held_out.gain >= STANDARD_ERRORS * held_out.se and held_out.share >= KEPT
    return "resolved" if is_resolved and held_out.gain > 0.0 else "not resolved"


def weak_cases(kept: Sequence[Kept]) -> tuple[Kept, ...]:
    """Return the cases that keep less than half of the gain."""
    return tuple(one for one in kept if one.share < KEPT)


def assumed_ranges(proposal: Rig, reference: Rig) -> frozenset[str]:
    """Return the models of sensors that only one of two rigs has and whose maker states no range by reflectivity."""
    own = {sensor.name: sensor for sensor in reference.sensors}
    theirs = {sensor.name: sensor for sensor in proposal.sensors}
    differ = [s for s in (*own.values(), *theirs.values()) if own.get(s.name) != theirs.get(s.name)]
    models = {sensor.model for sensor in differ if sensor.model is not None}
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
