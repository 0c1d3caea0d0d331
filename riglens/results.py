"""Results of a score: figures by class, and the whole as JSON-able data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from riglens.core.engine.audit import RigAudit, SensorAudit, audit_document
from riglens.core.engine.engine import Evaluation
from riglens.core.engine.evaluation_json import evaluation_document
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import ClassScores, KindScore
from riglens.core.rig.model import Rig
from riglens.core.targets.object_table import object_table
from riglens.core.targets.scores import ClassTargets, TargetScores
from riglens.core.targets.targets_json import targets_document
from riglens.core.targets.traffic import Traffic

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True)
class ClassResult:
    """Score of a rig for one class: entropies in nats, shares from 0 to 1.

    `seen` is the share of the entropy `h_total` that any sensor sees, `seen_camera` and `seen_lidar` those of the
    cameras and of the LiDARs, `by_kind` the scores of each kind of sensor by name. S-MS (`s_ms`)
    falls as a rig sees more.
    """

    h_total: float
    seen: float
    seen_camera: float
    seen_lidar: float
    s_ms: float
    s_mig_camera: float
    s_mig_lidar: float
    by_kind: Mapping[str, KindScore]

    @classmethod
    def _of(cls, scores: ClassScores) -> Self:
        camera, lidar = scores.camera, scores.lidar
        return cls(
            *(scores.h_total, scores.any_seen, camera.seen, lidar.seen, scores.s_ms),
            *(camera.s_mig, lidar.s_mig, scores.kinds),
        )


class RigResult(Mapping[str, ClassResult]):
    """Scores of a rig by class: `result["car"].seen`."""

    def __init__(self, field: EntropyField, evaluation: Evaluation) -> None:
        self._field, self._evaluation = field, evaluation
        classes = evaluation.scores.classes
        self._classes = {name: ClassResult._of(scores) for name, scores in classes.items()}

    def __getitem__(self, class_name: str) -> ClassResult:
        return self._classes[class_name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._classes)

    def __len__(self) -> int:
        return len(self._classes)

    def __repr__(self) -> str:
        seen = ", ".join(f"{name} seen {found.seen:.1%}" for name, found in self.items())
        return f"<RigResult of {self.rig.name}: {seen}>"

    @property
    def rig(self) -> Rig:
        """The rig that was scored."""
        return self._evaluation.rig

    @property
    def covered_voxels(self) -> Mapping[str, int]:
        """Number of informative voxels seen by "camera", "lidar" and "any"."""
        return self._evaluation.scores.covered_voxels

    @property
    def elapsed_ms(self) -> float:
        """Return the duration of the evaluation; the first of a process includes loading the compiled code."""
        return self._evaluation.elapsed_ms

    def to_dict(self) -> dict[str, Any]:
        """The result as JSON-able data, field by field what `riglens evaluate RIG --json FILE` writes."""
        return evaluation_document(self._field, self._evaluation.settings, [self._evaluation])


class TargetResult(Mapping[str, ClassTargets]):
    """Figures of a rig for objects, by class: `result["car"].total.on_target.value`.

    `total` holds the figures of all road users of the class, `rings` those of rings of distance. A figure that is a
    mean has a `value` and, where a sample of frames was used, its standard error `se`.
    """

    def __init__(self, traffic: Traffic, scores: TargetScores) -> None:
        self._traffic, self._scores = traffic, scores

    def __getitem__(self, class_name: str) -> ClassTargets:
        return self._scores.classes[class_name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._scores.classes)

    def __len__(self) -> int:
        return len(self._scores.classes)

    def __repr__(self) -> str:
        parts = (f"{name} on target {found.total.on_target.value:.1%}" for name, found in self.items())
        return f"<TargetResult of {self.rig.name}: {', '.join(parts)}>"

    @property
    def rig(self) -> Rig:
        """The rig that was counted for."""
        return self._scores.rig

    @property
    def frames_used(self) -> int:
        """Return the number of frames in which objects were counted."""
        return self._scores.frames_used

    @property
    def elapsed_ms(self) -> float:
        """Return the duration of the counting; the first of a process includes loading the compiled code."""
        return self._scores.elapsed_ms

    def objects(self) -> pa.Table:
        """Return an Arrow table with a row per object, as `riglens targets RIG --objects FILE` writes it."""
        return object_table(self._traffic, self._scores)

    def to_dict(self) -> dict[str, Any]:
        """The result as JSON-able data, field by field what `riglens targets RIG --json FILE` writes."""
        return targets_document(self._traffic, [self._scores])


class AuditResult(Mapping[str, SensorAudit]):
    """Ray outcomes of a rig's enabled sensors, by sensor: `result["LIDAR_1"].shares["hits_car"]`.

    Each has `rays`, `counts` and `shares` by what becomes of a ray (shares add up to one),
    `lost_nat` and `lost_share` by class, the entropy that the car's body takes from the sensor on its own, and
    `stand`, where the sensor sits on the car.
    """

    def __init__(self, audit: RigAudit) -> None:
        self._audit = audit
        self._sensors = {sensor.name: sensor for sensor in audit.sensors}

    def __getitem__(self, sensor_name: str) -> SensorAudit:
        return self._sensors[sensor_name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sensors)

    def __len__(self) -> int:
        return len(self._sensors)

    def __repr__(self) -> str:
        shares = ", ".join(f"{name} {found.shares['hits_car']:.1%}" for name, found in self.items())
        return f"<AuditResult of {self.rig.name}, rays that hit the car: {shares}>"

    @property
    def rig(self) -> Rig:
        """Return the rig that was evaluated."""
        return self._audit.rig

    def to_dict(self) -> dict[str, Any]:
        """The result as JSON-able data, field by field what `riglens audit RIG --json FILE` writes."""
        return audit_document(self._audit)
