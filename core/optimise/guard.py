"""Check a gain: the same comparison in other frames, with mount errors and under other assumptions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import HEIGHTS_M, BlindSettings
from riglens.core.errors import InputError, IsStale, never_stale
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.figures.figure import ALL
from riglens.core.figures.objects import ObjectFigure
from riglens.core.metric.scores import MetricSettings
from riglens.core.optimise.objectives import Objective, objective_named
from riglens.core.optimise.problem import Problem
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
HELD_OUT, EXACT = "held-out frames", "exact"
"""First cases: of a figure of objects, and of one of voxels or of the ground, which no sample makes."""
SEEDS, DRAWS, FEW = 3, 4, 250
"""Other seeds, draws of mount errors, and frames of the cases that vary an assumption."""
KEPT, STANDARD_ERRORS = 0.5, 2.0
"""Share of the gain in the frames of choice that a resolved gain keeps, and the standard errors by which it exceeds
0."""
ERRORS = "mount errors of 3 mm and 0.1°"
HALVED = "assumed range halved"
_COARSE = 2.0
"""Edge of the columns of the ground in another case, times the usual one."""


@dataclass(frozen=True)
class GuardResult:
    """Gain of a proposal over its reference in one case, positive where it is better, its standard error, and its share
    of the gain for which the proposal was chosen; decides: whether a resolved gain must be clear in it."""

    case: str
    gain: float
    se: float
    share: float
    decides: bool = False

    @property
    def is_clear(self) -> bool:
        """Return whether it is a gain of at least two standard errors."""
        return self.gain > 0.0 and self.gain >= STANDARD_ERRORS * self.se


@dataclass(frozen=True)
class Case:
    """A comparison of two rigs: its gain and standard error, measured when called."""

    name: str
    gain: Callable[[], tuple[float, float]]
    decides: bool = False


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
Pairs = Sequence[tuple[TargetSettings, Rig, Rig]]


class ObjectSampler:
    """An objective of rigs on the objects of one set of traffic; only sensors of the kinds that make it are cast."""

    def __init__(
        self,
        traffic: Traffic,
        threads: int | None = None,
        goal: Objective | None = None,
        weights: Weights = EVEN,
        is_stale: IsStale = never_stale,
    ) -> None:
        self._traffic, self.threads, self._engine = traffic, threads, TargetEngine(traffic, threads)
        self._goal, self._weights, self._is_stale = goal or objective_named("on_target"), weights, is_stale

    def on(self, traffic: Traffic) -> ObjectSampler:
        """Return the sampler of the same objective on other traffic."""
        return ObjectSampler(traffic, self.threads, self._goal, self._weights, self._is_stale)

    def __call__(self, rig: Rig, settings: TargetSettings, frames: tuple[int, int]) -> Sample:
        """Evaluate a rig; raise Cancelled when stale. Objects without the figure are left out."""
        if not self._goal.one_fails:
            return self._sample(rig, settings, frames)
        left = [without(rig, (sensor.name,)) for sensor in self._goal.sensors_of(rig)]
        return min((self._sample(one, settings, frames) for one in left or [rig]), key=lambda one: one.value)

    def _sample(self, rig: Rig, settings: TargetSettings, frames: tuple[int, int]) -> Sample:
        (first, end), figure = frames, self._goal.figure
        assert isinstance(figure, ObjectFigure)
        alone = rig.only(self._goal.sensors_of(rig))
        counted = self._engine.evaluate(alone, settings, end, cancel=self._is_stale)
        frame, values = counted.groups.frame, figure.values(counted)
        used = (frame >= first) & ~np.isnan(values)
        box = counted.objects.box[used]
        ring = self._weights.at(self._traffic.distance_m[box])
        cls = self._traffic.cls[box]
        return Sample(values[used], cls, ring, frame[used] - first, end - first, self._weights.by_class)

    def cast(self, rig: Rig, settings: TargetSettings, frames: int) -> object:
        """Cast a rig's sensors, and return what keeps their hits as long as it is held."""
        beside = self._engine.beside()
        beside.evaluate(rig, settings, frames, cancel=self._is_stale)
        return beside


def guard(cases: Sequence[Case]) -> Iterator[GuardResult]:
    """Compare case by case; the first one is that for which the proposal was chosen."""
    chosen, *others = cases
    gain, se = chosen.gain()
    if chosen.decides:
        yield GuardResult(chosen.name, gain, se, float(gain > 0.0), True)
    for one in others:
        more, se = one.gain()
        yield GuardResult(one.name, more, se, more / gain if gain > 0.0 else 0.0, one.decides)


def cases_of(
    problem: Problem, proposal: Rig, reference: Rig, sampler: ObjectSampler, is_stale: IsStale = never_stale
) -> list[Case]:
    """Return the cases in which a proposal is compared with a reference; sampler: of the problem's own traffic."""
    if not problem.goal.of_objects:
        return exact_cases(problem, proposal, reference, sampler.threads, is_stale)
    pair, settings, own = (proposal, reference), problem.settings, problem.traffic
    cases = sampled_cases(*pair, sampler, settings, problem.frames, problem.last, problem.goal.sign)
    for (
        name,
        traffic,
    ) in problem.checks.items():  # held-out frames in another state, or the first of other data
        is_other = (
            not own.data.sha256 or traffic.data.sha256 != own.data.sha256 or traffic.frames != own.frames
        )
        first, last = (0, traffic.frames) if is_other else (problem.frames, problem.last)
        where, usual = (first, min(last, first + FEW)), replace(settings, phase="random")
        cases.append(
            _sampled(name, sampler.on(traffic), [(usual, *pair)], where, problem.goal.sign, is_other)
        )
    return cases


def sampled_cases(
    proposal: Rig,
    reference: Rig,
    sampler: Sampler,
    settings: TargetSettings,
    frames: int,
    last: int,
    sign: float = 1.0,
) -> list[Case]:
    """Return the cases of a figure of objects.

    settings: those with which the proposal was chosen in the first `frames` frames. Held-out frames, up to `last`,
    follow them; there the phases of LiDARs are random whatever was chosen with.
    """
    if frames < 2 or last - frames < 2:
        raise InputError(f"needs 2 frames beyond the {frames} to choose by (the data has {last})", "held_out")
    usual, few = replace(settings, phase="random"), (frames, min(last, frames + FEW))
    pair, seeds = (proposal, reference), range(1, SEEDS + 1)
    varied: dict[str, Pairs] = {
        "other seeds": [(replace(usual, seed=settings.seed + more), *pair) for more in seeds],
        ERRORS: [(usual, *moved) for moved in _with_errors(proposal, reference, settings.seed)],
        "plain boxes": [(replace(usual, shape="box"), *pair)],
        "fixed phase": [(replace(usual, phase="0"), *pair)],
    }
    if halved := _with_halved_ranges(proposal, reference):
        varied[HALVED] = [(usual, *halved)]
    return [
        _sampled("frames of choice", sampler, [(settings, *pair)], (0, frames), sign),
        _sampled(HELD_OUT, sampler, [(usual, *pair)], (frames, last), sign, True),
        *(_sampled(name, sampler, pairs, few, sign) for name, pairs in varied.items()),
    ]


def _sampled(
    name: str, sampler: Sampler, pairs: Pairs, frames: tuple[int, int], sign: float, decides: bool = False
) -> Case:
    def gain() -> tuple[float, float]:
        mine, theirs = list[Sample](), list[Sample]()
        for how, better, worse in pairs:
            mine.append(sampler(better, how, frames))
            theirs.append(sampler(worse, how, frames))
        more, se = Sample.mean_of(mine).gain_over(Sample.mean_of(theirs))
        return sign * more, se

    return Case(name, gain, decides)


def exact_cases(
    problem: Problem, proposal: Rig, reference: Rig, threads: int | None, is_stale: IsStale = never_stale
) -> list[Case]:
    """Return the cases of a figure of voxels or of the ground: no frames are drawn for it, so what it is worth depends
    on mounts, and on what it assumes."""
    goal, ground_m = problem.goal, problem.ground_m
    usual = EvaluationSettings(MetricSettings(body=None), blind_m=ground_m)
    evaluator = Evaluator(problem.voxels, settings=usual, threads=threads)

    def gain(better: Rig, worse: Rig, how: EvaluationSettings) -> float:
        now, before = (
            evaluator(rig.only(goal.sensors_of(rig)), (goal.figure.needs,), cancel=is_stale, settings=how)
            for rig in (better, worse)
        )
        rows = CLASSES if goal.figure.per_class and goal.tables == "voxels" else (ALL,)
        changes = {who: goal.figure.change(now, before, who) for who in rows}
        weight = {who: problem.weights.classes.get(who, 1.0) for who, one in changes.items() if one.exists}
        total = sum(weight.values())
        return goal.sign * sum(changes[who].value * one for who, one in weight.items()) / (total or 1.0)

    def case(
        name: str, pairs: Sequence[tuple[Rig, Rig]], decides: bool = False, how: EvaluationSettings = usual
    ) -> Case:
        def gains() -> tuple[float, float]:
            found = [gain(*pair, how) for pair in pairs]
            se = float(np.std(found, ddof=1) / np.sqrt(len(found))) if len(found) > 1 else 0.0
            return float(np.mean(found)), se

        return Case(name, gains, decides)

    pair = (proposal, reference)
    cases = [
        case(EXACT, [pair], True),
        case(ERRORS, _with_errors(*pair, problem.seed), True),
    ]
    if halved := _with_halved_ranges(*pair):
        cases.append(case(HALVED, [halved]))
    if goal.figure.needs == "ground":
        other_m = next((one for one in HEIGHTS_M if one > ground_m), HEIGHTS_M[0])
        coarse = BlindSettings(voxel_m=_COARSE * usual.blind.voxel_m)
        cases.append(case(f"object of {other_m:g} m", [pair], how=replace(usual, blind_m=other_m)))
        cases.append(case(f"columns of {coarse.voxel_m:g} m", [pair], how=replace(usual, blind=coarse)))
    return cases


def verdict(kept: Sequence[GuardResult], resolved: float) -> Verdict:
    """Return "resolved" where the gain in the first case is large enough to tell rigs apart and half of the gain when
    chosen, and two standard errors in all cases that decide."""
    if not kept or not kept[0].decides:
        return "not checked"
    is_resolved = kept[0].gain >= resolved and kept[0].share >= KEPT
    is_resolved &= all(one.is_clear for one in kept if one.decides)
    return "resolved" if is_resolved else "not resolved"


def assumed_ranges(proposal: Rig, reference: Rig) -> frozenset[str]:
    """Return the models with a range law that only one of two rigs has, whose maker states no range by reflectivity."""
    own = {sensor.name: sensor for sensor in reference.sensors}
    theirs = {sensor.name: sensor for sensor in proposal.sensors}
    differ = [s for s in (*own.values(), *theirs.values()) if own.get(s.name) != theirs.get(s.name)]
    models = {s.model for s in differ if s.model is not None and kind_of(s).has_range_law}
    return frozenset(name for name in models if not default_library().entry(name).range_anchors())


def _with_halved_ranges(proposal: Rig, reference: Rig) -> tuple[Rig, Rig] | None:
    """Return both rigs with half the range of the models that `assumed_ranges` names; None without any."""
    models = assumed_ranges(proposal, reference)

    def half(sensor: Sensor) -> Sensor:
        low, high = sensor.range_m
        return sensor.replace(range_m=(low, max(high / 2.0, 1.001 * low)))

    def halved(rig: Rig) -> Rig:
        sensors = tuple(half(one) if one.model in models else one for one in rig.sensors)
        return rig.model_copy(update={"sensors": sensors})

    return (halved(proposal), halved(reference)) if models else None


def _with_errors(first: Rig, second: Rig, seed: int) -> list[tuple[Rig, Rig]]:
    """Return both rigs with the same few draws of the assembly profile; sensors that both have come first."""
    profile = profile_called("assembly")
    draws = unit_draws(DRAWS, max(errors_count(first), errors_count(second)), seed)

    def moved(rig: Rig, errors: Doubles) -> Rig:
        return disturbed(rig, profile, errors[: errors_count(rig)])[0]

    return [(moved(first, one), moved(second, one)) for one in draws]
