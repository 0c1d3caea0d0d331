"""Check a rig against requirements: each figure is made by the code that shows it elsewhere, on request."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, MetricSettings, Scores
from riglens.core.review.blind import BlindEngine, BlindMap, by_names, called
from riglens.core.review.draws import Draws, chance_bounds
from riglens.core.review.findings import Finding, Verdict, amounts, missing
from riglens.core.review.measures import Measures
from riglens.core.review.mounts import violations
from riglens.core.review.outline import SECTORS
from riglens.core.review.profiles import Profile
from riglens.core.review.redundancy import (
    COVERED,
    MOST_PAIRED,
    Coverage,
    What,
    failing_of,
    halves_of,
    lost_of,
    target_counter,
    target_coverage,
    voxel_counter,
    with_halves,
)
from riglens.core.review.redundancy_json import share
from riglens.core.review.requirements import Item, Requirements
from riglens.core.review.sections import (
    STATE,
    BlindArea,
    BlindObjects,
    Covered,
    Loss,
    Mounts,
    OnTarget,
    PredictedDetection,
    Requirement,
    Seen,
    Tolerated,
    WorstCase,
    kinds_of,
)
from riglens.core.review.tolerance import Figures, standing
from riglens.core.review.verdicts import ObjectVisibility, ProfileVerdict
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.scores import Row, TargetScores
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic

NO_ROAD_USERS = "requirements ask for objects, and a stored POG has none: name a box data set"


@dataclass(frozen=True)
class Subject:
    """Subject of a check: a rig, in a scene where one is needed, by profiles of objects, with threads. `body` is that
    of traffic figures; blind zones and test objects always use a solid one."""

    rig: Rig
    body: Body
    field: EntropyField | None
    traffic: Traffic | None
    profiles: tuple[Profile, ...]
    threads: int | None = None


class Check:
    """The verdicts on one rig. Call it from the thread of the parallel kernels.

    InputError for names that neither the rig nor the program has."""

    def __init__(self, subject: Subject, asked: Requirements) -> None:
        for place, message in asked.problems([subject.rig], subject.profiles):
            raise InputError(f"{' '.join(str(part) for part in place)}: {message}")
        self._subject, self._asked = subject, asked
        self._drawn: dict[tuple[str, str], Draws] = {}

    def verdicts(self, progress: Progress | None = None) -> tuple[Verdict, ...]:
        """Return every requirement's verdict in the order of the sections."""
        items, found = self._asked.items(), []
        for item in items:
            found.append(Verdict(item, self._finding(item)))
            if progress is not None:
                progress(len(found) / len(items))
        return tuple(found)

    def _finding(self, item: Item) -> Finding:
        one = item.requirement
        lack = self._lacking(one.kinds, one.least_kinds)
        if lack is not None:
            return missing(lack)
        makers: dict[type[Requirement], Callable[[Any], Finding]] = {
            Seen: self._seen,
            OnTarget: self._on_target,
            PredictedDetection: self._predicted,
            BlindArea: self._blind_area,
            BlindObjects: self._blind_objects,
            Loss: self._lost,
            Covered: self._covered,
            Tolerated: self._chance,
            Mounts: self._mounted,
        }
        return makers[type(one)](one)

    def _lacking(self, kinds: Sequence[str], least: int = 1) -> str | None:
        """Return why the rig lacks a figure that some kinds of sensors make, or any `least` of them."""
        enabled = {sensor.kind for sensor in self._subject.rig.sensors if sensor.enabled}
        absent = [kind for kind in by_names() if kind in kinds and kind not in enabled]
        if not enabled or absent:
            return f"the rig has no enabled {called(absent[0]) if enabled else 'sensor'}"
        return "all enabled sensors of the rig are of one kind" if len(enabled) < least else None

    # ------------------------------------------------------------ what figures are made from
    @property
    def _field(self) -> EntropyField:
        assert self._subject.field is not None
        return self._subject.field

    @property
    def _traffic(self) -> Traffic:
        if self._subject.traffic is None:
            raise InputError(NO_ROAD_USERS)
        return self._subject.traffic

    @property
    def _settings(self) -> MetricSettings:
        return MetricSettings(body=self._subject.body)

    @cached_property
    def _engine(self) -> Engine:
        engine = Engine(self._field, self._subject.threads)
        engine.evaluate(self._subject.rig, self._settings, False)
        return engine

    @cached_property
    def _scores(self) -> Scores:
        return self._engine.evaluate(self._subject.rig, self._settings, False).scores

    @cached_property
    def _targets(self) -> TargetScores:
        how = TargetSettings(min_points=self._asked.min_points, body=self._subject.body)
        engine = TargetEngine(self._traffic, self._subject.threads)
        return engine.evaluate(self._subject.rig, how)

    @cached_property
    def _blind_engine(self) -> BlindEngine:
        subject = self._subject
        settings = self._asked.blind_settings
        return BlindEngine(subject.rig.vehicle, settings, subject.threads)

    @cached_property
    def _map(self) -> BlindMap:
        return self._blind_engine.evaluate(self._subject.rig)

    @cached_property
    def _visibility(self) -> ObjectVisibility:
        return self._visibility_of(self._subject.rig, Pose())

    def _designed(self, rig: Rig) -> ObjectVisibility:
        """Return the visibility in a rig on level ground, that of the rig as designed from before."""
        return self._visibility if rig is self._subject.rig else self._visibility_of(rig, Pose())

    def _visibility_of(self, rig: Rig, stance: Pose) -> ObjectVisibility:
        subject = self._subject
        return ObjectVisibility(rig, "blocks", jit.use_threads(subject.threads), stance)

    @cached_property
    def _voxels(self) -> Coverage:
        subject = self._subject
        coverage = voxel_counter(self._engine, self._settings, subject.threads)
        found = coverage(subject.rig)
        return with_halves(found, subject.rig, coverage) if self._tries_halves("voxels") else found

    @cached_property
    def _road_users(self) -> Coverage:
        rig, traffic, how = self._subject.rig, self._traffic, self._targets.settings
        found = target_coverage(traffic, rig, self._targets.objects, how.min_points)
        if not self._tries_halves("road_users"):
            return found
        return with_halves(
            found, rig, target_counter(TargetEngine(traffic, self._subject.threads), traffic, how)
        )

    def _tries_halves(self, of: str) -> bool:
        return any(one.of == of and one.failure == "half" for one in self._asked.losses)

    def _failing(self, what: What) -> list[tuple[str, Rig, tuple[str, ...]]]:
        """Return the failures of a kind that the rig's enabled sensors may have: names, the rig, and what fails in
        it."""
        rig = self._subject.rig
        if what == "half":
            return [(name, other, ()) for name, other in halves_of(rig)]
        sensors = [sensor for sensor in rig.sensors if sensor.enabled]
        return [(name, rig, members) for kind, name, members in failing_of(sensors) if kind == what]

    def _none_failing(self, what: What) -> Finding:
        enabled = sum(sensor.enabled for sensor in self._subject.rig.sensors)
        if what == "pair" and enabled > MOST_PAIRED:
            return missing(
                f"pairs are counted of up to {MOST_PAIRED} enabled sensors (the rig has {enabled})"
            )
        return missing(f"the rig has no {what} of enabled sensors")

    # ------------------------------------------------------------ what is seen
    def _seen(self, one: Seen) -> Finding:
        scores = self._scores.classes[one.cls]
        if not scores.h_total:
            return missing(f"the scene has no entropy of {one.cls}")
        kinds = {"any": scores.any_seen} | {kind: found.seen for kind, found in scores.kinds.items()}
        return Finding(kinds[one.by])

    def _rows(self, one: OnTarget) -> Sequence[Row]:
        """Return the counts in the rings of a requirement; none if objects are not counted as far out."""
        table = self._targets.classes[one.cls]
        if one.ring_m is None:
            return [table.total]
        low, high = one.ring_m
        rows = [row for row in table.rings if low <= row.from_m and row.to_m <= high]
        return rows if rows and rows[-1].to_m == high else []

    def _predicted(self, one: PredictedDetection) -> Finding:
        if self._targets.predicted_outside:
            return missing(f"outside the domain: {self._targets.predicted_outside}")
        found = [row.predicted for row in self._rows(one) if row.predicted is not None]
        domain = self._targets.calibration.domain.region
        if not found:
            return missing(f"there is no {one.cls} {domain}")
        count = sum(row.objects for row in found)
        error = float(self._targets.calibration.errors[1 + CLASSES.index(one.cls)])
        return Finding(
            sum(row.objects * row.value for row in found) / count,
            f"{one.text} ({count:,} objects {domain})",
            details=(f"± {100.0 * error:.1f} %, one standard error of the calibration",),
        )

    def _on_target(self, one: OnTarget) -> Finding:
        rows = self._rows(one)
        if not rows:
            return missing(f"objects count within {self._traffic.within_m:g} m")
        count = sum(row.objects for row in rows)
        text = f"{one.text} ({count:,} objects)"
        if not count:
            return Finding(None, text, details=(f"there is no {one.cls} there",))
        return Finding(sum(row.objects * float(getattr(row, one.figure).value) for row in rows) / count, text)

    # ------------------------------------------------------------ blind zones and objects
    def _blind_area(self, one: BlindArea) -> Finding:
        if not _in_place(self._map.ground_m2(), self._map, one):
            return missing("there is no such ground around the car")
        if one.failing is not None:
            cases = [
                (_area(self._blind_engine.evaluate(rig, members), one), f"{name} {STATE[one.failing]}")
                for name, rig, members in self._failing(one.failing)
            ]
            return _worst(cases) or self._none_failing(one.failing)
        if one.under is not None:
            return self._worst_draw(one, one.under)
        return Finding(_area(self._map, one))

    def _blind_objects(self, one: BlindObjects) -> Finding:
        profile = self._profile(one)
        lack = self._lacking(() if profile.by == "any" else (profile.by,))
        if lack is not None:
            return missing(lack)
        if one.under is not None:
            return self._worst_draw(one, one.under)
        designed = self._visibility.verdict(profile)
        if one.failing is None:
            return Finding(len(designed.failed), details=_unseen(designed))
        judged = [
            (self._designed(rig).verdict(profile).without(members), name)
            for name, rig, members in self._failing(one.failing)
        ]
        if not judged:
            return self._none_failing(one.failing)
        worst, name = max(judged, key=lambda case: len(case[0].failed))
        return Finding(len(worst.failed), details=(f"{name} {STATE[one.failing]}", *_unseen(worst)))

    def _profile(self, one: BlindObjects) -> Profile:
        return next(profile for profile in self._subject.profiles if profile.name == one.profile)

    def _worst_draw(self, one: WorstCase, profile: str) -> Finding:
        drawn = self._draws("blind", profile).first(one.draws)
        worst = _worst([(figures[_key(one)], f"draw {place}") for place, figures in enumerate(drawn)])
        assert worst is not None  # there is at least one draw
        return worst

    def _blind_figures(self, profile: str, rig: Rig, stance: Pose) -> Figures:
        """Return all figures of blind zones and objects that are required under a profile, of a rig with errors."""
        moved = standing(rig, stance)
        found: dict[str, float] = {}
        areas = [one for one in self._asked.blind_areas if one.under == profile]
        objects = [one for one in self._asked.blind_objects if one.under == profile]
        if areas:
            blind = self._blind_engine.evaluate(moved, stance=stance)
            found |= {_key(one): _area(blind, one) for one in areas}
        if objects:
            visibility = self._visibility_of(moved, stance)
            found |= {_key(one): len(visibility.verdict(self._profile(one)).failed) for one in objects}
        return found

    # ------------------------------------------------------------ redundancy
    def _coverage(self, of: str) -> Coverage:
        return self._voxels if of == "voxels" else self._road_users

    def _covered(self, one: Covered) -> Finding:
        coverage, cls, rows = self._coverage(one.of), CLASSES.index(one.cls), _rows(one.sector)
        total = int(coverage.total[rows, cls].sum())
        if not total:
            return missing(f"there is nothing of {one.cls} there")
        part = coverage.covered[rows, COVERED.index(str(one.sensors)), cls].sum()
        return Finding(share(int(part), total))

    def _lost(self, one: Loss) -> Finding:
        coverage, cls, rows = self._coverage(one.of), CLASSES.index(one.cls), _rows(one.sector)
        total, detected = int(coverage.total[rows, cls].sum()), int(coverage.covered[rows, 0, cls].sum())
        if not total:
            return missing(f"there is nothing of {one.cls} there")
        if one.share_of == "detected" and not detected:
            return missing(f"the rig detects nothing of {one.cls} there")
        named = [f for f in coverage.failures if f.what == one.failure and one.name in (None, f.name)]
        if not named:
            return self._none_failing(one.failure)
        sector = None if one.sector is None else SECTORS.index(one.sector)
        failure = max(named, key=lambda failure: lost_of(failure, cls, sector))
        lost = lost_of(failure, cls, sector)
        shares = {"all": share(lost, total), "detected": share(lost, detected)}
        other, of = ("detected", "of what the rig detects") if one.share_of == "all" else ("all", "of all")
        detail = f"{100.0 * shares[other]:.2f} % {of}"
        return Finding(shares[one.share_of], one.text_of(failure.name), details=(detail,))

    # ------------------------------------------------------------ tolerance
    def _draws(self, kind: str, profile: str) -> Draws:
        """Return the draws of a profile for the figures that tolerances are of, or for those of blind zones."""
        if (kind, profile) not in self._drawn:
            subject, asked = self._subject, self._asked
            if kind == "blind":
                self._drawn[kind, profile] = Draws(
                    subject.rig, asked.errors[profile], asked.seed,
                    lambda rig, stance: self._blind_figures(profile, rig, stance),
                )  # fmt: skip
            else:
                users = subject.traffic if any(one.figure == "on_target" for one in asked.tolerance) else None
                measure = Measures(
                    self._field, users, self._settings, asked.sample_frames, subject.threads,
                    TargetSettings(min_points=asked.min_points), subject.rig,
                )  # fmt: skip
                self._drawn[kind, profile] = Draws(subject.rig, asked.errors[profile], asked.seed, measure)
        return self._drawn[kind, profile]

    def _chance(self, one: Tolerated) -> Finding:
        if one.figure == "seen" and not self._scores.classes[one.cls].h_total:
            return missing(f"the scene has no entropy of {one.cls}")
        if one.figure == "on_target":
            lack = self._lacking(kinds_of(one.figure)) or self._no_road_users(one)
            if lack is not None:
                return missing(lack)
        last = max(one.draws, one.max_draws)
        limit = f", after {last:,} draws, the most"
        for draws in _raised(one.draws, last):
            figures = self._draws("figures", one.profile).first(draws)
            below = sum(found[f"{one.figure} {one.cls}"] < one.limit for found in figures)
            bounds = chance_bounds(below, draws)
            if bounds[1] <= one.at_most or bounds[0] > one.at_most:
                limit = ""
                break
        text = f"{one.text} ({below:,} of {draws:,} draws)"
        shown = [amounts(bound, one.at_most, "share")[0] for bound in bounds]
        detail = f"between {shown[0]} and {shown[1]}, each bound with 95 % confidence{limit}"
        return Finding(below / draws, text, bounds, (detail,))

    def _no_road_users(self, one: Tolerated) -> str | None:
        traffic = self._traffic
        boxes = slice(0, int(traffic.starts[min(self._asked.sample_frames, traffic.frames)]))
        is_there = traffic.counts[boxes] & (traffic.cls[boxes] == CLASSES.index(one.cls))
        return None if is_there.any() else f"there is no {one.cls} in the frames that are sampled"

    # ------------------------------------------------------------ mounts
    def _mounted(self, one: Mounts) -> Finding:
        found = violations(self._subject.rig, one)
        return Finding(len(found), details=tuple(f"{line.sensor}: {line.text}" for line in found))


def _raised(draws: int, last: int) -> Iterator[int]:
    """Yield `draws`, doubled each time, up to `last`."""
    while draws < last:
        yield draws
        draws *= 2
    yield last


def _worst(cases: Sequence[tuple[float, str]]) -> Finding | None:
    """Return the largest figure of some cases, the first of equals, and its case; None without any."""
    if not cases:
        return None
    value, case = max(cases, key=lambda found: found[0])
    return Finding(value, details=(case,))


def _area(found: BlindMap, one: BlindArea) -> float:
    return _in_place(found.area_m2(one.height_m, one.by, one.sensors), found, one)


def _in_place(table: Any, found: BlindMap, one: BlindArea) -> float:
    """Return the entry that a requirement refers to in a table of areas by sector and band."""
    bands = found.settings.bands_m
    last = len(bands) - 1 if one.within_m is None else bands.index(one.within_m)
    return round(float(table[_rows(one.sector), :last].sum()), 9)


def _key(one: WorstCase) -> str:
    """Distinguish figures of blind zones under one profile."""
    return repr(sorted((name, repr(value)) for name, value in one.scope().items()))


def _unseen(found: ProfileVerdict) -> tuple[str, ...]:
    names = [one.target.name for one in found.failed]
    return (f"unseen: {', '.join(names)}",) if names else ()


def _rows(sector: str | None) -> slice:
    if sector is None:
        return slice(None)
    place = SECTORS.index(sector)
    return slice(place, place + 1)
