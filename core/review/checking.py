"""Check a rig against requirements: each figure is made by the code that shows it elsewhere, on request."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeVar

from riglens.core.blind.zones import BlindEngine, BlindMap, by_names, called
from riglens.core.errors import InputError
from riglens.core.figures.evaluated import Evaluated, EvaluationSettings, Evaluator
from riglens.core.figures.figure import SE_FACTOR
from riglens.core.figures.objects import ObjectFigure, Part, parts_by_class, parts_by_sector
from riglens.core.geometry import Pose
from riglens.core.kernels.runtime import jit
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.review.findings import Finding, Verdict, amounts, missing
from riglens.core.review.measures import Measures, measured_name
from riglens.core.review.mounts import UNNAMED_KEEP_OUT, USUAL_KEEP_OUT, mounts_of, violations
from riglens.core.review.profiles import Profile
from riglens.core.review.redundancy import (
    COVERED,
    MOST_PAIRED,
    Coverage,
    What,
    coverage_of,
    failing_of,
    halves_of,
    lost_of,
    share,
)
from riglens.core.review.requirements import Item, Requirements
from riglens.core.review.sections import (
    STATE,
    BlindArea,
    BlindObjects,
    Covered,
    FigureLimit,
    Loss,
    Mounts,
    OnTarget,
    PredictedDetection,
    Requirement,
    Seen,
    Tolerated,
    WorstCase,
)
from riglens.core.review.tolerance import Draws, Figures, chance_bounds, moves, standing
from riglens.core.review.verdicts import ObjectVisibility, ProfileVerdict
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.sectors import SECTORS
from riglens.core.shown_text import counted
from riglens.core.targets.counts import Counted
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import solid_of

T = TypeVar("T")
NOTHING_MOVES = "errors of '{}' move nothing of this rig"
NO_ROAD_USERS = "requirements ask for objects, and a stored POG has none: name a box data set"


@dataclass(frozen=True)
class Subject:
    """Subject of a check: a rig, what evaluates it, in a scene where one is needed, and profiles of objects. The body
    of its settings is that of traffic figures; blind zones and test objects always use a solid one."""

    rig: Rig
    evaluate: Evaluator
    profiles: tuple[Profile, ...]


@dataclass(frozen=True)
class _Around:
    """View of a rig around its solid car, in a stance of it; objects of profiles once each."""

    engine: BlindEngine
    rig: Rig
    stance: Pose
    threads: int | None

    def blind(self, failed: tuple[str, ...] = ()) -> BlindMap:
        """Return the blind zones without the sensors that have failed."""
        return self.engine.evaluate(self.rig, failed, self.stance)

    def verdict(self, profile: Profile) -> ProfileVerdict:
        """Return which objects of a profile the rig sees."""
        if profile.name not in self._verdicts:
            self._verdicts[profile.name] = self._visibility.verdict(profile)
        return self._verdicts[profile.name]

    @cached_property
    def _visibility(self) -> ObjectVisibility:
        return ObjectVisibility(self.rig, "blocks", jit.use_threads(self.threads), self.stance)

    @cached_property
    def _verdicts(self) -> dict[str, ProfileVerdict]:
        return {}


class Check:
    """The verdicts on one rig. Call it from the thread of the parallel kernels.

    InputError for names that neither the rig nor the program has."""

    def __init__(self, subject: Subject, asked: Requirements) -> None:
        for place, message in asked.problems([subject.rig], subject.profiles):
            raise InputError(f"{' '.join(str(part) for part in place)}: {message}")
        asked.settings.require(subject.evaluate.field, subject.evaluate.traffic)
        self._subject, self._asked = subject, asked
        self._drawn: dict[str, Draws[Figures]] = {}
        self._drawn_around: dict[str, Draws[dict[str, Finding]]] = {}

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
        if self._impossible and not isinstance(one, Mounts):
            return Finding(None, details=self._impossible, is_impossible=True)
        lack = self._lacking(one.kinds)
        if lack is not None:
            is_blind = not any(sensor.enabled for sensor in self._subject.rig.sensors)
            return Finding(None, details=(lack,), is_impossible=is_blind)
        makers: dict[type[Requirement], Callable[[Any], Finding]] = {
            Seen: self._seen,
            FigureLimit: self._figure,
            OnTarget: self._figure,
            PredictedDetection: self._figure,
            BlindArea: self._blind_area,
            BlindObjects: self._blind_objects,
            Loss: self._lost,
            Covered: self._covered,
            Tolerated: self._chance,
            Mounts: self._mounted,
        }
        return makers[type(one)](one)

    def _lacking(self, kinds: Sequence[str]) -> str | None:
        """Return why the rig lacks a figure that some kinds of sensors make, or any of them."""
        enabled = {sensor.kind for sensor in self._subject.rig.sensors if sensor.enabled}
        absent = [kind for kind in by_names() if kind in kinds and kind not in enabled]
        if not enabled or absent:
            return f"the rig has no enabled {called(absent[0]) if enabled else 'sensor'}"
        return None

    @cached_property
    def _impossible(self) -> tuple[str, ...]:
        """Return which sensors are where none can be, below the ground or two in one place: whatever they see proves
        nothing."""
        mounts = mounts_of(self._subject.rig, ())
        wrong = {
            "below the ground": [mount.name for mount in mounts if mount.is_below_ground],
            "in one place": [mount.name for mount in mounts if mount.is_in_one_place],
        }
        return tuple(f"{what}: {', '.join(names)}" for what, names in wrong.items() if names)

    # ------------------------------------------------------------ what figures are made from
    @property
    def _traffic(self) -> Traffic:
        if self._evaluate.traffic is None:
            raise InputError(NO_ROAD_USERS)
        return self._evaluate.traffic

    @cached_property
    def _evaluate(self) -> Evaluator:
        given, asked = self._subject.evaluate, self._asked
        body = given.settings.metric.body
        how = TargetSettings(min_points=asked.settings.min_points, body=body)
        return given.by(EvaluationSettings(MetricSettings(body=body), how, asked.blind_settings))

    @cached_property
    def _evaluated(self) -> Evaluated:
        return self._evaluate(self._subject.rig, ("voxels",))

    @property
    def _scores(self) -> Scores:
        assert self._evaluated.voxels is not None
        return self._evaluated.voxels.scores

    @cached_property
    def _targets(self) -> Counted:
        assert self._traffic is not None
        found = self._evaluate(self._subject.rig, ("objects",)).objects
        assert found is not None
        return found

    @cached_property
    def _blind_engine(self) -> BlindEngine:
        return self._evaluate.ground_of(self._subject.rig, self._asked.blind_settings)

    @cached_property
    def _around(self) -> _Around:
        return _Around(self._blind_engine, self._subject.rig, Pose(), self._evaluate.threads)

    @cached_property
    def _voxels(self) -> Coverage:
        return coverage_of(self._evaluate, self._subject.rig, "voxels", self._tries_halves("voxels"))

    @cached_property
    def _objects(self) -> Coverage:
        assert self._traffic is not None
        return coverage_of(self._evaluate, self._subject.rig, "objects", self._tries_halves("objects"))

    def _tries_halves(self, of: str) -> bool:
        return any(one.of == of and one.failure == "half" for one in self._asked.losses)

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

    def _parts(self, one: FigureLimit, figure: ObjectFigure) -> Sequence[Part]:
        """Return the counts in the rings or the sector of a requirement; none if objects are not counted as far out."""
        counted = self._targets
        if one.sector is not None:
            return [parts_by_sector(counted, [figure])[one.cls][one.sector]]
        table = parts_by_class(counted, [figure], with_rings=one.ring_m is not None)[one.cls]
        if one.ring_m is None:
            return [table.total]
        low, high = one.ring_m
        rows = [row for row in table.rings if low <= row.from_m and row.to_m <= high]
        return rows if rows and rows[-1].to_m == high else []

    def _figure(self, one: FigureLimit) -> Finding:
        """Return a figure of a class: of objects in rings of distance, in a sector, or all around, or of voxels."""
        figure = one.of
        if not isinstance(figure, ObjectFigure):
            found = figure.of(self._evaluated, one.cls)
            return Finding(found.value) if found.exists else missing(found.reason)
        counted = self._targets
        if lack := figure.lacks(counted):
            return missing(lack)
        calibration = figure.calibrated(counted)
        if figure.calibration is not None and calibration is None:
            return missing("the calibration predicts AP, not recall")
        if calibration is not None and (outside := counted.outside(calibration)):
            return missing(f"outside the domain: {outside}")
        parts = self._parts(one, figure)
        if not parts and calibration is None:
            return missing(f"objects count within {self._traffic.within_m:g} m")
        found_in = [part[one.figure] for part in parts if part[one.figure].objects]
        count, details, domain = sum(each.objects for each in found_in), tuple[str, ...](), ""
        if calibration is not None:
            error = float(calibration.errors[1 + CLASSES.index(one.cls)])
            details = (f"±{100.0 * SE_FACTOR * error:.1f} %, two standard errors of the calibration",)
            domain = f" {calibration.domain.region}" if figure.in_domain else ""
        if not count:
            return missing(f"there is no {one.cls}{domain or ' there'}")
        text = f"{one.text} ({count:,} objects{domain})"
        if figure.is_median and len(found_in) > 1:
            return missing("medians have no limit over several rings: name one")
        return Finding(sum(each.objects * each.value for each in found_in) / count, text, details=details)

    # ------------------------------------------------------------ blind zones and objects
    def _blind_area(self, one: BlindArea) -> Finding:
        found = self._around.blind()
        if not _in_place(found.ground_m2(), found, one):
            return missing("there is no such ground around the car")
        return self._in_worst_case(one)

    def _blind_objects(self, one: BlindObjects) -> Finding:
        by = self._profile(one).by
        lack = self._lacking(() if by == "any" else (by,))
        return self._in_worst_case(one) if lack is None else missing(lack)

    def _profile(self, one: BlindObjects) -> Profile:
        return next(profile for profile in self._subject.profiles if profile.name == one.profile)

    def _in_worst_case(self, one: WorstCase) -> Finding:
        """Return the figure of the rig as designed, or the worst of its failures, of its draws, or of both."""
        if one.failing is not None and not _failing(self._subject.rig, one.failing):
            return self._none_failing(one.failing)
        if one.under is None:
            return self._around_finding(one, self._around)
        if not moves(self._asked.errors[one.under], self._subject.rig):
            return missing(NOTHING_MOVES.format(one.under))
        around = self._draws(one.under, partial(self._findings_around, one.under))
        draws = self._drawn_around.setdefault(one.under, around)
        drawn = [found[_key(one)] for found in draws.first(one.draws)]
        place, worst = max(enumerate(drawn), key=lambda case: _value(case[1]))
        most = chance_bounds(0, one.draws)[1]
        details = (f"draw {place}", *worst.details)
        if most <= one.chance_at_most or _value(worst) > one.accepted:
            return replace(worst, details=details)
        few = f"{counted(one.draws, 'draw')} within the limit: up to {100.0 * most:.1f} % may exceed it, with 95 %"
        few += f" confidence; more draws must show at most {100.0 * one.chance_at_most:g} %"
        return replace(worst, details=(few, *details), is_shown=False)

    def _findings_around(self, profile: str, rig: Rig, stance: Pose) -> dict[str, Finding]:
        """Return the figures required under a profile of errors, of a rig with such errors."""
        asked = [*self._asked.blind_areas, *self._asked.blind_objects]
        around = _Around(self._blind_engine, standing(rig, stance), stance, self._evaluate.threads)
        return {_key(one): self._around_finding(one, around) for one in asked if one.under == profile}

    def _around_finding(self, one: WorstCase, around: _Around) -> Finding:
        """Return the figure of a rig, or the worst of its failures."""
        if one.failing is None:
            return self._around_case(one, around, ())
        state, findings = STATE[one.failing], []
        for name, rig, members in _failing(around.rig, one.failing):
            there = around if rig is around.rig else replace(around, rig=rig)
            found = self._around_case(one, there, members)
            findings.append(replace(found, details=(f"{name} {state}", *found.details)))
        return max(findings, key=_value)

    def _around_case(self, one: WorstCase, around: _Around, failed: tuple[str, ...]) -> Finding:
        if isinstance(one, BlindArea):
            found = around.blind(failed)
            return Finding(_in_place(found.area_m2(one.height_m, one.by, one.sensors), found, one))
        assert isinstance(one, BlindObjects)
        unseen = around.verdict(self._profile(one)).without(failed).failed
        names = ", ".join(each.target.name for each in unseen)
        return Finding(len(unseen), details=(f"unseen: {names}",) if names else ())

    # ------------------------------------------------------------ redundancy
    def _coverage(self, of: str) -> Coverage:
        return self._voxels if of == "voxels" else self._objects

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
        if not detected or detected < one.least_detected * total:
            little = f"{100.0 * detected / total:.2f} %" if detected else "nothing"
            return missing(f"the rig detects {little} of {one.cls} there, too little to lose")
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
    def _draws(self, profile: str, measure: Callable[[Rig, Pose], T]) -> Draws[T]:
        return Draws(self._subject.rig, self._asked.errors[profile], self._asked.settings.seed, measure)

    @cached_property
    def _measures(self) -> Measures:
        asked = self._asked
        frames = (
            asked.settings.sample_frames if any(one.of.needs == "objects" for one in asked.tolerance) else 0
        )
        return Measures(self._evaluate, frames, self._subject.rig)

    def _chance(self, one: Tolerated) -> Finding:
        if one.of.needs == "voxels" and not self._scores.classes[one.cls].h_total:
            return missing(f"the scene has no entropy of {one.cls}")
        if isinstance(one.of, ObjectFigure):
            lack = one.of.lacks(self._targets) or self._no_objects(one)
            if lack is not None:
                return missing(lack)
        if not moves(self._asked.errors[one.profile], self._subject.rig):
            return missing(NOTHING_MOVES.format(one.profile))
        drawn = self._drawn.setdefault(one.profile, self._draws(one.profile, self._measures))
        last = max(one.draws, one.max_draws)
        limit = f", after {last:,} draws, the most"
        for draws in _raised(one.draws, last):
            figures = drawn.first(draws)
            values = [found[measured_name(one.of, one.cls)].value for found in figures]
            below = sum(
                value > one.limit if one.of.better == "less" else value < one.limit for value in values
            )
            bounds = chance_bounds(below, draws)
            if bounds[1] <= one.at_most or bounds[0] > one.at_most:
                limit = ""
                break
        text = f"{one.text} ({below:,} of {draws:,} draws)"
        shown = [amounts(bound, one.at_most, "share")[0] for bound in bounds]
        detail = f"between {shown[0]} and {shown[1]}, each bound with 95 % confidence{limit}"
        return Finding(below / draws, text, bounds, (detail,))

    def _no_objects(self, one: Tolerated) -> str | None:
        traffic = self._traffic
        boxes = slice(0, int(traffic.starts[min(self._asked.settings.sample_frames, traffic.frames)]))
        is_there = traffic.counts[boxes] & (traffic.cls[boxes] == CLASSES.index(one.cls))
        return None if is_there.any() else f"there is no {one.cls} in the frames that are sampled"

    # ------------------------------------------------------------ mounts
    def _mounted(self, one: Mounts) -> Finding:
        rig = self._subject.rig
        violated = violations(rig, one)
        lines = tuple(f"{line.sensor}: {line.text}" for line in violated)
        zones = USUAL_KEEP_OUT if one.keep_out is None else one.keep_out
        lacks_parts = not solid_of(rig.vehicle).names_parts
        judged = [zone.name for zone in UNNAMED_KEEP_OUT if one.keep_out is None]
        lacking = [z.name for z in zones if z.part is not None and lacks_parts and z.name not in judged]
        lacking += [z.name for z in zones if z.material is not None and rig.vehicle.has_mesh_file]
        if one.keep_out is not None and not any(zone.allows == () for zone in one.keep_out):
            lines = (*lines, "the file keeps no place free of all sensors")
        if not lacking:
            return Finding(len(violated), details=lines)
        note = f"not judged, as the mesh file names no such parts: {', '.join(lacking)}"
        if one.keep_out is not None and not violated:
            return missing(note)
        return Finding(len(violated), details=(*lines, note))


def _raised(draws: int, last: int) -> Iterator[int]:
    """Yield `draws`, doubled each time, up to `last`."""
    while draws < last:
        yield draws
        draws *= 2
    yield last


def _failing(rig: Rig, what: What) -> list[tuple[str, Rig, tuple[str, ...]]]:
    """Return the failures of a kind that a rig's enabled sensors may have: names, the rig, and what fails in it."""
    if what == "half":
        return [(name, other, ()) for name, other in halves_of(rig)]
    sensors = [sensor for sensor in rig.sensors if sensor.enabled]
    return [(name, rig, members) for kind, name, members in failing_of(sensors) if kind == what]


def _value(found: Finding) -> float:
    assert found.value is not None
    return found.value


def _in_place(table: Any, found: BlindMap, one: BlindArea) -> float:
    """Return the entry that a requirement refers to in a table of areas by sector and band."""
    bands = found.settings.bands_m
    last = len(bands) - 1 if one.within_m is None else bands.index(one.within_m)
    return round(float(table[_rows(one.sector), :last].sum()), 9)


def _key(one: WorstCase) -> str:
    """Distinguish figures of blind zones under one profile."""
    return repr(sorted((name, repr(value)) for name, value in one.scope().items()))


def _rows(sector: str | None) -> slice:
    if sector is None:
        return slice(None)
    place = SECTORS.index(sector)
    return slice(place, place + 1)
