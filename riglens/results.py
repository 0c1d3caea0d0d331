"""Results of the Python interface: frozen, each with the whole JSON of a command, and tables for notebooks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from riglens.core.blind.zones import HEIGHTS_M, BlindMap
from riglens.core.engine.audit import RigAudit, SensorAudit, audit_document
from riglens.core.engine.engine import Evaluation
from riglens.core.errors import InputError
from riglens.core.figures.coverage import SEEN
from riglens.core.figures.documents import evaluation_document, figures_of, objects_document
from riglens.core.figures.evaluated import Evaluated
from riglens.core.figures.figure import ALL, Estimate
from riglens.core.figures.objects import ClassParts, ObjectFigure, Part, parts_by_class, parts_by_sector
from riglens.core.figures.registry import figure_named, leading_figures, object_figures
from riglens.core.figures.sentence import changes_of, sentence
from riglens.core.figures.text import estimate_text
from riglens.core.figures.weakest import Weakest, weakest_by_class
from riglens.core.footprint.ground import Footprint
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import KindScore
from riglens.core.plain import to_plain
from riglens.core.review.documents import SPREAD, blind_document
from riglens.core.review.findings import Verdict
from riglens.core.review.mounts import Mount, Violation
from riglens.core.review.redundancy import Coverage, lost_share
from riglens.core.review.tolerance import Spread, worst_rig
from riglens.core.review.tolerance import ToleranceResult as Tolerances
from riglens.core.review.verdicts import ProfileVerdict
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.pog import Pog
from riglens.core.scene.sectors import SECTORS
from riglens.core.shown_text import visible
from riglens.core.targets.counts import Counted
from riglens.core.targets.detection_range import DetectionRange
from riglens.core.targets.detection_range_table import range_document, range_lines
from riglens.core.targets.object_table import object_table

if TYPE_CHECKING:
    import pyarrow as pa

T = TypeVar("T")
Rows = list[dict[str, Any]]
SHOWN = 40
"""Rows of a table in a notebook."""


class Result(ABC):
    """Result of a function of the interface: `to_dict()` is the command's JSON, `table()` its main figures."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Return the result as JSON-able data, field by field what the command writes with --json."""

    @abstractmethod
    def rows(self) -> Rows:
        """Return the main figures, a dict per row."""

    def table(self) -> pa.Table:
        """Return the main figures as an Arrow table; `.to_pandas()` where pandas is installed."""
        import pyarrow

        rows = self.rows()
        names = columns_of(rows)  # from_pylist takes those of the first row
        return pyarrow.Table.from_pylist([{name: row.get(name) for name in names} for row in rows])

    def _repr_html_(self) -> str:
        return html_table(repr(self).strip("<>"), self.rows())


@dataclass(frozen=True, eq=False)
class Documented(Result):
    """A result that keeps the JSON of its command."""

    _document: Mapping[str, Any]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of the command."""
        return dict(self._document)


class ByName(Result, Mapping[str, T], Generic[T]):
    """A result that is a mapping too, by class of objects or by sensor."""

    @property
    @abstractmethod
    def _by_name(self) -> Mapping[str, T]: ...

    def __getitem__(self, name: str) -> T:
        return self._by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)


def columns_of(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the columns of all rows, in the order in which they occur."""
    return list(dict.fromkeys(name for row in rows for name in row))


def html_table(title: str, rows: Sequence[Mapping[str, Any]], picture: bytes | None = None) -> str:
    """Return a small table for a notebook, below a PNG picture if there is one; every text is escaped."""
    columns = columns_of(rows)
    head = "".join(f"<th>{_text(name)}</th>" for name in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{_text(row.get(name))}</td>" for name in columns) + "</tr>"
        for row in rows[:SHOWN]
    )
    more = f"<p>{len(rows) - SHOWN:,} more rows</p>" if len(rows) > SHOWN else ""
    shown = f'<img width="640" src="data:image/png;base64,{b64encode(picture).decode()}">' if picture else ""
    return f"<div><p><b>{_text(title)}</b></p>{shown}<table><tr>{head}</tr>{body}</table>{more}</div>"


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "—" if value is None else escape(visible(f"{value:,}" if type(value) is int else str(value)))


# ---------------------------------------------------------------- scores


@dataclass(frozen=True)
class ClassResult:
    """Score of a rig for one class: entropies in nats, shares from 0 to 1.

    `seen` is the share of the entropy `h_total` that any sensor sees, `seen_camera` and `seen_lidar` those of the
    cameras and of the LiDARs, `by_kind` the scores of each kind of sensor by name. S-MS (`s_ms`) decreases as coverage
    grows. `figures` holds every figure by key, such as "predicted", each with a `value`, a standard error `se`, a
    `state` and, where it is "none" or "outside" its domain, the `reason`; those of objects where traffic was given.
    """

    h_total: float
    seen: float
    seen_camera: float
    seen_lidar: float
    s_ms: float
    s_mig_camera: float
    s_mig_lidar: float
    by_kind: Mapping[str, KindScore]
    figures: Mapping[str, Estimate]

    @classmethod
    def of(cls, rig: Evaluated, name: str) -> ClassResult:
        """Return the figures of one class."""
        assert rig.voxels is not None
        scores = rig.voxels.scores.classes[name]
        camera, lidar = scores.camera, scores.lidar
        return cls(
            *(scores.h_total, scores.any_seen, camera.seen, lidar.seen, scores.s_ms),
            *(camera.s_mig, lidar.s_mig, scores.kinds),
            {one.key: one.of(rig, name) for one in figures_of(rig) if one.per_class},
        )


@dataclass(frozen=True, eq=False)
class RigResult(ByName[ClassResult]):
    """Scores of a rig by class: `result["car"].seen`; `pog` and `field` of the scene that it was scored on."""

    pog: Pog
    field: EntropyField
    _evaluated: Evaluated

    @cached_property
    def _by_name(self) -> Mapping[str, ClassResult]:
        return {name: ClassResult.of(self._evaluated, name) for name in CLASSES}

    @property
    def _evaluation(self) -> Evaluation:
        assert self._evaluated.voxels is not None
        return self._evaluated.voxels

    def __repr__(self) -> str:
        shares = [one for one in (*leading_figures(), SEEN) if one.unit == "share"]
        found = [(one, self.means[one.key]) for one in shares if one.key in self.means]
        means = ", ".join(f"{one.title} {estimate_text(one, mean)}" for one, mean in found if mean.exists)
        return f"<RigResult of {self.rig.name}: {means}>"

    @property
    def rig(self) -> Rig:
        """The rig that was scored."""
        return self._evaluation.rig

    def against(self, other: RigResult) -> str:
        """Say in one sentence whether the rig is better than another in the same scene, by the leading figures."""
        return sentence(changes_of(self._evaluated, other._evaluated), other.rig.name)

    @cached_property
    def means(self) -> Mapping[str, Estimate]:
        """Figures of all classes together by key: the leading ones of objects are means of the classes, shares of
        entropy are weighted by it, entropies are added up."""
        return {one.key: one.of(self._evaluated, ALL) for one in figures_of(self._evaluated)}

    def weakest(self, key: str) -> Mapping[str, Weakest]:
        """Return by class, and for "all", where a figure of objects is worst: class, sector, and the distance from
        which it is worse than one half. Empty without objects."""
        figure = figure_named(key)
        if not isinstance(figure, ObjectFigure):
            raise InputError(f"must be a figure of objects (got '{key}')", "key")
        counted = self._evaluated.objects
        return {} if counted is None else weakest_by_class(figure, counted)

    @property
    def covered_voxels(self) -> Mapping[str, int]:
        """Number of informative voxels seen by each kind of sensor and by "any"."""
        return self._evaluation.scores.covered_voxels

    @property
    def elapsed_ms(self) -> float:
        """Time of the evaluation; the first of a process includes loading the compiled code."""
        return self._evaluation.elapsed_ms

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of `riglens evaluate RIG`."""
        return evaluation_document(self.field, self._evaluation.settings, [self._evaluated])

    def rows(self) -> Rows:
        """Return a row per class, and a last one for the mean of the classes: figures, the standard errors of those
        that have one, and their values with sensors of one kind alone."""
        rows = [
            {"class": name, "h_total": found.h_total} | _row_of(found.figures) for name, found in self.items()
        ]
        means = {one.key: self.means[one.key] for one in self._means_of_classes}
        return [*rows, {"class": "mean"} | _row_of(means)]

    @property
    def _means_of_classes(self) -> list[ObjectFigure]:
        return [one for one in object_figures() if one.of_classes]


def _row_of(figures: Mapping[str, Estimate]) -> dict[str, Any]:
    """Return figures by key, with their standard errors and parts where they have any."""
    found = dict[str, Any]()
    for key, one in figures.items():
        if one.exists:
            errors = {f"{key}_se": one.se} if one.se else {}
            found |= {key: one.value} | errors | {f"{key}_{kind}": part for kind, part in one.parts.items()}
    return found


@dataclass(frozen=True, eq=False)
class TargetResult(ByName[ClassParts]):
    """Figures of a rig for objects by class: `result["car"].total.on_target.value`.

    `total` holds the figures of all objects of the class by key, `rings` those of rings of distance. Each has a
    `value`, its standard error `se`, and a `state`: "exact", "sampled" where not all frames were used, "outside" the
    domain of a calibration, or "none" with the `reason`.
    """

    _counted: Counted

    @cached_property
    def _by_name(self) -> Mapping[str, ClassParts]:
        return parts_by_class(self._counted, self._figures, with_rings=True)

    @property
    def _figures(self) -> tuple[ObjectFigure, ...]:
        return object_figures(sensor.kind for sensor in self.rig.sensors if sensor.enabled)

    def __repr__(self) -> str:
        first = next(figure for figure in self._figures if figure.leads and figure.calibration is None)
        parts = (
            f"{name} {first.title.lower()} {found.total[first.key].value:.1%}" for name, found in self.items()
        )
        return f"<TargetResult of {self.rig.name}: {', '.join(parts)}>"

    @property
    def rig(self) -> Rig:
        """The rig that was counted for."""
        return self._counted.rig

    @property
    def frames_used(self) -> int:
        """Number of frames in which objects were counted."""
        return self._counted.frames_used

    @property
    def elapsed_ms(self) -> float:
        """Time of the counting; the first of a process includes loading the compiled code."""
        return self._counted.elapsed_ms

    def objects(self) -> pa.Table:
        """Return an Arrow table with a row per object, as `riglens evaluate RIG --objects FILE` writes it."""
        return object_table(self._counted)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of objects of `riglens evaluate RIG`."""
        return objects_document([self._counted])

    def rows(self) -> Rows:
        """Return a row per class and ring of distance, the first of a class for all of its objects."""
        return [
            {"class": name} | self._row(part)
            for name, found in self.items()
            for part in (found.total, *found.rings)
        ]

    def by_sector(self) -> Rows:
        """Return a row per class and sector of 45 degrees around the car, named as in `riglens check`."""
        return [
            {"class": name, "sector": sector} | self._row(part)
            for name, sectors in parts_by_sector(self._counted, self._figures).items()
            for sector, part in sectors.items()
        ]

    def _row(self, part: Part) -> dict[str, Any]:
        """Return the figures of some objects, with standard errors where they can have one."""
        found: dict[str, Any] = {"from_m": part.from_m, "to_m": part.to_m, "objects": part.objects}
        for figure in self._figures:
            estimate = part[figure.key]
            found[figure.key] = estimate.value if estimate.exists else None
            if not figure.is_median:
                found[f"{figure.key}_se"] = estimate.se
            found |= {f"{figure.key}_{kind}": value for kind, value in estimate.parts.items()}
        return found


@dataclass(frozen=True, eq=False)
class AuditResult(ByName[SensorAudit]):
    """Outcomes of the rays of a rig's enabled sensors, by sensor: `result["LIDAR_1"].shares["hits_car"]`.

    Each has `rays`, `counts` and `shares` by outcome (shares add up to one), `lost_nat` and `lost_share`
    by class, the entropy that the car's body takes from the sensor on its own, and `stand`, how it is mounted.
    """

    _audit: RigAudit

    @cached_property
    def _by_name(self) -> Mapping[str, SensorAudit]:
        return {sensor.name: sensor for sensor in self._audit.sensors}

    def __repr__(self) -> str:
        shares = ", ".join(f"{name} {found.shares['hits_car']:.1%}" for name, found in self.items())
        return f"<AuditResult of {self.rig.name}, rays that hit the car: {shares}>"

    @property
    def rig(self) -> Rig:
        """The rig whose rays were followed."""
        return self._audit.rig

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of the part `audit` of `riglens review`."""
        return audit_document(self._audit)

    def rows(self) -> Rows:
        """Return a row per sensor: its rays, and their shares by outcome."""
        return [
            {"sensor": name, "kind": found.kind, "rays": found.rays, **found.shares}
            for name, found in self.items()
        ]


# ---------------------------------------------------------------- reviews


@dataclass(frozen=True, eq=False)
class BlindResult(Result):
    """Near-field blind zones of a rig: `zones` with areas and maps, `profiles` the verdicts on test objects.

    `zones.lowest_m(by, k)` is the height (nx, ny) from which on k sensors see an object in each column,
    `zones.ground.x_m` and `zones.ground.y_m` are the columns' places; `zones.area_m2(height_m)` is by sector and band.
    """

    zones: BlindMap
    profiles: tuple[ProfileVerdict, ...]

    def __repr__(self) -> str:
        unseen = ", ".join(f"{self.zones.area_m2(h).sum():.1f} m² at {h:g} m" for h in HEIGHTS_M)
        return f"<BlindResult of {self.zones.rig.name}, unseen ground by height of object: {unseen}>"

    def _repr_png_(self) -> bytes:
        from riglens.studies.blind_chart import blind_figure
        from riglens.studies.pictures import picture

        return picture(blind_figure(self.zones, "any", 1))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of the part `blind` of `riglens review`."""
        return blind_document(self.zones, self.profiles)

    def rows(self) -> Rows:
        """Return a row per height of object: the ground where no sensor sees it, in m², by sector."""
        found = []
        for height in HEIGHTS_M:
            areas = np.round(self.zones.area_m2(height).sum(axis=1), 9).tolist()
            found.append({"height_m": height, **dict(zip(SECTORS, areas, strict=True)), "all": sum(areas)})
        return found


@dataclass(frozen=True, eq=False)
class RangeResult(Result):
    """Detection range of a rig by class, heading and direction: `ranges.rows`."""

    ranges: DetectionRange

    def __repr__(self) -> str:
        found = self.ranges
        return f"<RangeResult of {found.rig.name}: {len(found.rows)} cases up to {found.plan.to_m:g} m>"

    def _repr_png_(self) -> bytes:
        from riglens.studies.detection_range_chart import range_figure
        from riglens.studies.pictures import picture

        return picture(range_figure(self.ranges))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of the part `range` of `riglens review`."""
        return range_document(self.ranges)

    def rows(self) -> Rows:
        """Return a row per class, heading, direction and kind of sensor; None: detected at the farthest distance."""
        return [
            {name: None if cell == "" else cell for name, cell in line.items()}
            for line in range_lines(self.ranges)
        ]


@dataclass(frozen=True, eq=False)
class RedundancyResult(Documented):
    """Coverage by one, two and three sensors of a rig, and what is lost when sensors fail: `voxels`, `targets`."""

    rig: Rig
    voxels: Coverage
    targets: Coverage | None

    def __repr__(self) -> str:
        return f"<RedundancyResult of {self.rig.name}: {len(self.voxels.failures)} failures>"

    def rows(self) -> Rows:
        """Return a row per failure: the share of the entropy, and of the objects, that is lost, by class."""
        found: Rows = []
        for number, failure in enumerate(self.voxels.failures):
            row: dict[str, Any] = {"what": failure.what, "name": failure.name}
            for place, name in enumerate(CLASSES):
                row[f"lost_{name}"] = lost_share(self.voxels, failure, place)
                if self.targets is not None:
                    row[f"lost_{name}_objects"] = lost_share(
                        self.targets, self.targets.failures[number], place
                    )
            found.append(row)
        return found


@dataclass(frozen=True, eq=False)
class ToleranceResult(Documented):
    """Spread of a rig's figures under errors of its mounts or of the car's stance: `spreads`, `floor` by figure."""

    tolerances: Tolerances

    def __repr__(self) -> str:
        found = self.tolerances
        return f"<ToleranceResult of {found.rig.name}: {found.draws} draws of {found.profile.name}>"

    @property
    def spreads(self) -> Mapping[str, Spread]:
        """Spread of each figure over the draws."""
        return self.tolerances.spreads

    @property
    def floor(self) -> Mapping[str, Spread]:
        """Spread of each figure under errors of 1 mm and 0.01°: the noise floor."""
        return self.tolerances.floor

    def worst_rig(self, figure: str = "seen car") -> Rig:
        """Return the rig of the draw in which a figure is worst."""
        return worst_rig(self.tolerances, figure)

    def rows(self) -> Rows:
        """Return a row per figure."""
        return [{"figure": name} | to_plain(spread, *SPREAD) for name, spread in self.spreads.items()]


@dataclass(frozen=True, eq=False)
class MountsResult(Documented):
    """Mounts of a rig's enabled sensors, and `violations` of the usual limits: that part of `riglens review` alone."""

    rig: Rig
    mounts: tuple[Mount, ...]
    violations: tuple[Violation, ...]

    def __repr__(self) -> str:
        return (
            f"<MountsResult of {self.rig.name}: {len(self.mounts)} mounts, {len(self.violations)} violations>"
        )

    def rows(self) -> Rows:
        """Return a row per sensor."""
        wrong = {one.sensor: one.text for one in reversed(self.violations)}
        return [
            {
                "sensor": mount.name,
                "height_m": mount.height_m,
                "gap_m": mount.status.gap_m,
                "nearest_sensor": mount.neighbour,
                "nearest_sensor_m": mount.neighbour_m,
                "problem": wrong.get(mount.name),
            }
            for mount in self.mounts
        ]


@dataclass(frozen=True, eq=False)
class FootprintResult(Documented):
    """Footprints of a rig's enabled cameras, radars and ultrasonic sensors: that part of `riglens review` alone."""

    rig: Rig
    footprints: tuple[Footprint, ...]

    def __repr__(self) -> str:
        return f"<FootprintResult of {self.rig.name}: {len(self.footprints)} sensors>"

    def rows(self) -> Rows:
        """Return a row per sensor and band."""
        return [
            {"sensor": one.sensor.name, "band": band.title, "area_m2": band.area_m2}
            for one in self.footprints
            for band in one.bands
        ]


@dataclass(frozen=True, eq=False)
class CheckResult(Documented):
    """Verdicts on rigs by a file of requirements: `passes`, and the `verdicts` by name of the rig."""

    verdicts: Mapping[str, tuple[Verdict, ...]]

    def __repr__(self) -> str:
        return f"<CheckResult of {', '.join(self.verdicts)}: {'passes' if self.passes else 'does not pass'}>"

    @property
    def passes(self) -> bool:
        """Return whether every requirement is met or waived today."""
        return bool(self._document["passes"])

    def rows(self) -> Rows:
        """Return a row per rig and requirement."""
        return [
            {
                "rig": name,
                "id": one.item.id,
                "requirement": one.text,
                "found": one.found_text,
                "accepted": one.accepted_text,
                "status": one.status,
            }
            for name, verdicts in self.verdicts.items()
            for one in verdicts
        ]


@dataclass(frozen=True, eq=False)
class ReviewResult(ByName[Result]):
    """Parts of a review by name: "blind", "range", "redundancy", "tolerance", "audit", "mounts"."""

    rig: Rig
    parts: Mapping[str, Result]

    @property
    def _by_name(self) -> Mapping[str, Result]:
        return self.parts

    def __repr__(self) -> str:
        return f"<ReviewResult of {self.rig.name}: {', '.join(self.parts)}>"

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of `riglens review RIG`."""
        return {"riglens": FORMAT_VERSION} | {name: part.to_dict() for name, part in self.parts.items()}

    def rows(self) -> Rows:
        """Return a row per part."""
        return [{"part": name, "result": repr(part).strip("<>")} for name, part in self.parts.items()]

    def _repr_html_(self) -> str:
        return "".join(part._repr_html_() for part in self.parts.values())


# ---------------------------------------------------------------- data and models


@dataclass(frozen=True, eq=False)
class Listing(Result):
    """Figures of box data or of sensor models: `document` as JSON has them, a row each in `table()`."""

    title: str
    document: Mapping[str, Any]
    _rows: Sequence[Mapping[str, Any]]

    def __repr__(self) -> str:
        return f"<{self.title}>"

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON of `riglens data show BOXES` or `riglens list sensors`."""
        return dict(self.document)

    def rows(self) -> Rows:
        """Return a row per class of objects, or per model."""
        return [dict(row) for row in self._rows]
