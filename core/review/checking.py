"""Checking a rig against requirements: each figure is made by the code that shows it elsewhere, if it is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, MetricSettings, Scores
from riglens.core.review.blind import BlindEngine, BlindMap, unseen_by
from riglens.core.review.measures import Measures
from riglens.core.review.mounts import violations
from riglens.core.review.outline import SECTORS
from riglens.core.review.profiles import Profile
from riglens.core.review.redundancy import COVERED, Coverage, target_coverage, voxel_coverage
from riglens.core.review.redundancy_json import lost_share, share
from riglens.core.review.requirements import (
    BlindArea,
    Covered,
    Loss,
    OnTarget,
    Requirements,
    Tolerated,
    Verdict,
)
from riglens.core.review.tolerance import ToleranceResult, tolerance
from riglens.core.review.verdicts import Onlooker
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.scores import Row, TargetScores
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh import BodyMesh


@dataclass(frozen=True)
class Subject:
    """What is checked: a rig, in a scene where one is needed, by profiles of objects, with threads. `body` is that of
    figures of the traffic; blind zones and test objects are always behind a solid one."""

    rig: Rig
    body: Body
    mesh: BodyMesh | None
    field: EntropyField | None
    traffic: Traffic | None
    profiles: tuple[Profile, ...]
    threads: int | None = None


class Check:
    """The verdicts on one rig. Call it from the thread of the parallel kernels."""

    def __init__(self, subject: Subject, asked: Requirements) -> None:
        self._subject, self._asked = subject, asked
        self._tolerances: dict[tuple[str, int], ToleranceResult] = {}

    def verdicts(self) -> tuple[Verdict, ...]:
        """Every requirement in the order of the sections; InputError where one asks for what there is not."""
        parts = (self._seen(), self._on_target(), self._blind(), self._objects(), self._redundant())
        return tuple(verdict for part in (*parts, self._tolerated(), self._mounted()) for verdict in part)

    # ------------------------------------------------------------ what figures are made from
    @property
    def _field(self) -> EntropyField:
        assert self._subject.field is not None
        return self._subject.field

    @property
    def _traffic(self) -> Traffic:
        if self._subject.traffic is None:
            raise InputError(
                "requirements ask for road users; a stored POG has none: name boxes with --boxes"
            )
        return self._subject.traffic

    @property
    def _settings(self) -> MetricSettings:
        return MetricSettings(body=self._subject.body)

    @cached_property
    def _engine(self) -> Engine:
        engine = Engine(self._field, self._subject.threads)
        engine.evaluate(self._subject.rig, self._settings, False, self._subject.mesh)
        return engine

    @cached_property
    def _scores(self) -> Scores:
        return self._engine.evaluate(self._subject.rig, self._settings, False, self._subject.mesh).scores

    @cached_property
    def _targets(self) -> TargetScores:
        how = TargetSettings(min_points=self._asked.min_points, body=self._subject.body)
        engine = TargetEngine(self._traffic, self._subject.threads)
        return engine.evaluate(self._subject.rig, how, mesh=self._subject.mesh)

    @cached_property
    def _map(self) -> BlindMap:
        subject = self._subject
        settings = self._asked.blind_settings
        return BlindEngine(subject.rig.vehicle, settings, subject.mesh, subject.threads).evaluate(subject.rig)

    @cached_property
    def _voxels(self) -> Coverage:
        return voxel_coverage(self._engine, self._subject.rig, "exact", self._subject.threads)

    @cached_property
    def _road_users(self) -> Coverage:
        objects = self._targets.objects
        return target_coverage(self._traffic, self._subject.rig, objects, self._asked.min_points)

    def _tolerance(self, name: str, draws: int) -> ToleranceResult:
        if (name, draws) not in self._tolerances:
            subject, asked = self._subject, self._asked
            users = subject.traffic if any(one.figure == "on_target" for one in asked.tolerance) else None
            measure = Measures(
                self._field, users, self._settings, subject.mesh, asked.sample_frames, subject.threads,
                TargetSettings(min_points=asked.min_points),
            )  # fmt: skip
            self._tolerances[name, draws] = tolerance(
                subject.rig, asked.errors[name], measure, draws, asked.seed, with_sensitivities=False
            )
        return self._tolerances[name, draws]

    # ------------------------------------------------------------ sections
    def _seen(self) -> Iterator[Verdict]:
        for one in self._asked.seen:
            scores = self._scores.classes[one.cls]
            kinds = {"any": scores.any_seen, "camera": scores.camera.seen, "lidar": scores.lidar.seen}
            text = f"seen of {one.cls} by {one.by}"
            yield Verdict("seen", text, kinds[one.by], "at least", one.at_least, "share")

    def _on_target(self) -> Iterator[Verdict]:
        for one in self._asked.on_target:
            where = "" if one.ring_m is None else f", {one.ring_m[0]:g} to {one.ring_m[1]:g} m"
            rows = self._rows(one)
            count = sum(row.objects for row in rows)
            text = f"{one.figure} of {one.cls}{where} ({count:,} road users)"
            found = _figure_of(rows, one.figure)
            yield Verdict("on_target", text, found, "at least", one.at_least, "share")

    def _rows(self, one: OnTarget) -> Sequence[Row]:
        table = self._targets.classes[one.cls]
        if one.ring_m is None:
            return [table.total]
        low, high = one.ring_m
        rows = [row for row in table.rings if low <= row.from_m and row.to_m <= high]
        if not rows or rows[-1].to_m != high:
            raise InputError(
                f"on_target: ring_m to {high:g}: road users count within {self._traffic.within_m:g} m"
            )
        return rows

    def _blind(self) -> Iterator[Verdict]:
        for one in self._asked.blind_areas:
            yield Verdict("blind_areas", _blind_text(one), self._area(one), "at most", one.at_most_m2, "m²")

    def _area(self, one: BlindArea) -> float:
        table = self._map.area_m2(one.height_m, one.by, one.sensors)
        bands = self._map.settings.bands_m
        last = len(bands) - 1 if one.within_m is None else bands.index(one.within_m)
        rows = slice(None) if one.sector is None else slice(*_place(one.sector))
        return round(float(table[rows, :last].sum()), 9)

    def _objects(self) -> Iterator[Verdict]:
        if not self._asked.blind_objects:
            return
        subject = self._subject
        workers = jit.use_threads(subject.threads)
        onlooker = Onlooker(subject.rig, "blocks", subject.mesh, workers)
        by_name = {profile.name: profile for profile in subject.profiles}
        for one in self._asked.blind_objects:
            if one.profile not in by_name:
                known = ", ".join(by_name)
                raise InputError(f"blind_objects: found profile '{one.profile}', accepted is one of {known}")
            unseen = len(onlooker.verdict(by_name[one.profile]).failed)
            text = f"objects of {one.profile} unseen"
            yield Verdict("blind_objects", text, unseen, "at most", one.at_most_unseen, "objects")

    def _coverage(self, of: str) -> Coverage:
        return self._voxels if of == "voxels" else self._road_users

    def _redundant(self) -> Iterator[Verdict]:
        for loss in self._asked.losses:
            found, text = self._lost(loss)
            yield Verdict("losses", text, found, "at most", loss.at_most, "share")
        for one in self._asked.covered:
            name = str(one.sensors)
            text = f"{one.of} of {one.cls} covered by {name}{_where(one.sector)}"
            yield Verdict("covered", text, self._covered(one, name), "at least", one.at_least, "share")

    def _covered(self, one: Covered, name: str) -> float:
        coverage, cls = self._coverage(one.of), CLASSES.index(one.cls)
        rows = slice(None) if one.sector is None else slice(*_place(one.sector))
        part = coverage.covered[rows, COVERED.index(name), cls].sum()
        return share(int(part), int(coverage.total[rows, cls].sum()))

    def _lost(self, one: Loss) -> tuple[float, str]:
        coverage, cls = self._coverage(one.of), CLASSES.index(one.cls)
        sector = None if one.sector is None else SECTORS.index(one.sector)
        failure = coverage.worst(one.failure, cls, sector)
        if one.name is not None:
            named = {f.name: f for f in coverage.failures if f.what == one.failure}
            if one.name not in named:
                accepted = ", ".join(named) or "none, for the rig has none (groups are named by fails_with)"
                found = f"{one.failure} '{shortened(one.name)}'"
                raise InputError(
                    f"losses: found no {found} in the rig, accepted is {shortened(accepted, 300)}"
                )
            failure = named[one.name]
        if failure is None:
            return 0.0, f"{one.of} of {one.cls} lost: the rig has no {one.failure}{_where(one.sector)}"
        text = f"{one.of} of {one.cls} lost when {failure.name} fails{_where(one.sector)}"
        return lost_share(coverage, failure, cls, sector), text

    def _tolerated(self) -> Iterator[Verdict]:
        for one in self._asked.tolerance:
            found, error = self._below(one)
            text = (
                f"chance of {one.figure} of {one.cls} below {one.limit:g} under {one.profile} (± {error:.2g})"
            )
            yield Verdict("tolerance", text, found, "at most", one.at_most, "share")

    def _below(self, one: Tolerated) -> tuple[float, float]:
        result = self._tolerance(one.profile, one.draws)
        return result.spreads[f"{one.figure} {one.cls}"].below(one.limit)

    def _mounted(self) -> Iterator[Verdict]:
        if self._asked.mounts is None:
            return
        found = violations(self._subject.rig, self._asked.mounts, self._subject.mesh)
        for one in found:
            yield Verdict("mounts", f"{one.sensor}: {one.text}", 1.0, "at most", 0.0, "violations")
        if not found:
            yield Verdict("mounts", "all mounts", 0.0, "at most", 0.0, "violations")


def _figure_of(rows: Sequence[Row], figure: str) -> float:
    """A mean over the road users of some rings; 0 where there are none."""
    objects = sum(row.objects for row in rows)
    return sum(row.objects * float(getattr(row, figure).value) for row in rows) / max(1, objects)


def _place(sector: str) -> tuple[int, int]:
    place = SECTORS.index(sector)
    return place, place + 1


def _where(sector: str | None) -> str:
    return "" if sector is None else f", {sector}"


def _blind_text(one: BlindArea) -> str:
    near = "" if one.within_m is None else f" within {one.within_m:g} m"
    return f"ground where {one.height_m:g} m is {unseen_by(one.by, one.sensors)}{near}{_where(one.sector)}"
