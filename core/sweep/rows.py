"""Figures of rigs one after another as rows of a table: those of an evaluation with objects, bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.engine.evaluation_json import evaluation_document, score_figures
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.review.tolerance import NOISE_FLOOR, Spread, disturbed, errors_count, unit_draws
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.rig.yaml.file import valid_rig_sha256
from riglens.core.sweep.design import Sweep
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.scores import Groups, TargetScores
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.targets_json import target_figures, targets_document
from riglens.core.targets.traffic import Traffic

Row = dict[str, Any]
"""Values by column: texts, numbers, and nothing for figures that a rig does not have."""

FLOOR_DRAWS = 16


@dataclass(frozen=True)
class Figures:
    """Figures of each rig: settings of scores and of hits on objects, None to leave them out.

    Objects are counted in the first `frames` frames. blind_m: height of the object whose blind area is measured.
    """

    metric: MetricSettings | None = PAPER_SETTINGS
    targets: TargetSettings | None = None
    frames: int | None = None
    blind_m: float | None = None


class Sweeper:
    """Computer of rows; only the sensors that differ from the rig before are cast. For one thread.

    `reference` is the rig that changes are measured against, object by object, so that most of the sampling error
    cancels.
    """

    def __init__(
        self,
        figures: Figures,
        reference: Rig,
        field: EntropyField | None,
        traffic: Traffic | None,
        threads: int | None = None,
    ) -> None:
        self._figures, self._reference, self._threads = figures, reference, threads
        self._engine = None if field is None else Engine(field, threads)
        self._targets = None if traffic is None else TargetEngine(traffic, threads)
        self._blind: tuple[Vehicle, BlindEngine] | None = None

    def row(self, rig: Rig) -> Row:
        """Return all figures of a rig."""
        found: Row = {}
        if self._engine is not None:
            found |= _flat(score_figures(self._scored(rig)))
        if self._targets is not None:
            scores = self._counted(rig)
            found |= _flat(target_figures(scores)) | dict(self._changes(scores))
        if self._figures.blind_m is not None:
            found["blind_m2"] = self._blind_m2(rig, self._figures.blind_m)
        return found

    def rows(self, sweep: Sweep) -> Iterator[Row]:
        """Yield the rows of a sweep: rig, hash and values of the fields, then the figures."""
        for number in range(len(sweep)):
            rig = sweep.rig(number)
            values = dict(zip(sweep.names, sweep.values[number].tolist(), strict=True))
            yield {"rig": rig.name, "rig_sha256": valid_rig_sha256(rig), **values, **self.row(rig)}

    def inputs(self) -> dict[str, Any]:
        """Return data and settings of all rows as plain data, as in the JSON of `riglens evaluate`."""
        found: dict[str, Any] = {}
        if self._engine is not None and self._figures.metric is not None:
            field = self._engine.field
            found |= evaluation_document(field, self._figures.metric, [self._scored(self._reference)])
            found["data"]["source"] = field.data.short_source  # the same from any folder
        if self._targets is not None:
            traffic = self._targets.traffic
            found["targets"] = targets_document(traffic, [self._reference_counts])
            found["targets"]["data"]["source"] = traffic.data.short_source
            del found["targets"]["rigs"], found["targets"]["riglens"]
        return {name: value for name, value in found.items() if name not in ("rigs", "riglens")}

    def noise_floor(self, progress: Callable[[float], None] = lambda _: None) -> Row:
        """Return how far each figure moves by unavoidable errors of mounts, up and down: half of its range from 5 % to
        95 % of some draws for the reference."""
        units, drawn = unit_draws(FLOOR_DRAWS, errors_count(self._reference), 0), list[Row]()
        for errors in units:
            drawn.append(self.row(disturbed(self._reference, NOISE_FLOOR, errors)[0]))
            progress(len(drawn) / FLOOR_DRAWS)
        found = {}
        for name in (name for name, value in drawn[0].items() if not isinstance(value, str)):
            spread = Spread.of(0.0, [one.get(name, 0.0) for one in drawn])
            found[name] = (spread.p95 - spread.p05) / 2.0
        return found

    def _scored(self, rig: Rig) -> Evaluation:
        assert self._engine is not None and self._figures.metric is not None
        return self._engine.evaluate(rig, self._figures.metric, with_seen=False)

    def _counted(self, rig: Rig) -> TargetScores:
        assert self._targets is not None and self._figures.targets is not None
        return self._targets.evaluate(rig, self._figures.targets, self._figures.frames, with_rings=False)

    @cached_property
    def _reference_counts(self) -> TargetScores:
        return self._counted(self._reference)

    @cached_property
    def _groups(self) -> Groups:
        assert self._targets is not None
        return Groups(self._targets.traffic, self._reference_counts.frames_used)

    def _changes(self, scores: TargetScores) -> Iterator[tuple[str, float]]:
        """Yield the changes of hit coverage from the reference, with their standard errors."""
        change = scores.objects.on_target - self._reference_counts.objects.on_target
        for name, found in self._groups.means_by_class(change).items():
            yield f"{name}.lidar.on_target_change", found.value
            yield f"{name}.lidar.on_target_change_se", found.se

    def _blind_m2(self, rig: Rig, height_m: float) -> float:
        if self._blind is None or self._blind[0] != rig.vehicle:
            self._blind = rig.vehicle, BlindEngine(rig.vehicle, BlindSettings(), self._threads)
        found = self._blind[1].evaluate(rig)
        return float(found.unseen(height_m).sum() * found.column_m2)


def _flat(figures: Mapping[str, Any], prefix: str = "") -> Row:
    """Return nested figures under dotted names; those of a class begin with its name. Lists and nothing are left
    out."""
    found: Row = {}
    for name, value in figures.items():
        if isinstance(value, dict):
            found |= _flat(value, prefix if name == "classes" else f"{prefix}{name}.")
        elif value is not None and not isinstance(value, list):
            found[f"{prefix}{name}"] = value
    return found
