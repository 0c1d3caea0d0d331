"""Figures of rigs one after another as rows of a table: those of an evaluation with objects, bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from riglens.core.engine.evaluation_json import evaluation_document, score_figures
from riglens.core.figures.documents import object_figures_json, objects_document
from riglens.core.figures.evaluated import BLIND_M, Evaluated, EvaluationSettings, Evaluator, Need
from riglens.core.figures.figure import ALL
from riglens.core.figures.registry import figures, object_figures
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.review.tolerance import NOISE_FLOOR, Spread, disturbed, errors_count, unit_draws
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import valid_rig_sha256
from riglens.core.sweep.design import Sweep
from riglens.core.targets.counts import Counted
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.targets.traffic import Traffic

Row = dict[str, Any]
"""Values by column: texts, numbers, and nothing for figures that a rig does not have."""

FLOOR_DRAWS = 16


@dataclass(frozen=True)
class SweepFigures:
    """Figures of each rig: settings of scores and of hits on objects, None to leave them out.

    Objects are counted in the first `frames` frames. blind_m: height of the object whose blind area is measured.
    """

    metric: MetricSettings | None = PAPER_SETTINGS
    targets: TargetSettings | None = None
    frames: int | None = None
    blind_m: float | None = None

    @property
    def needs(self) -> tuple[Need, ...]:
        """Parts of an evaluation that the rows take."""
        wanted: dict[Need, object] = {"voxels": self.metric, "objects": self.targets, "ground": self.blind_m}
        return tuple(need for need, asked in wanted.items() if asked is not None)


class Sweeper:
    """Computer of rows; only the sensors that differ from the rig before are cast. For one thread.

    `reference` is the rig that changes are measured against, object by object, so that most of the sampling error
    cancels.
    """

    def __init__(
        self,
        wanted: SweepFigures,
        reference: Rig,
        field: EntropyField | None,
        traffic: Traffic | None,
        threads: int | None = None,
    ) -> None:
        self._figures, self._reference = wanted, reference
        settings = EvaluationSettings(
            wanted.metric or PAPER_SETTINGS, wanted.targets or USUAL, blind_m=wanted.blind_m or BLIND_M
        )
        self._evaluate = Evaluator(field, traffic, settings, threads)

    def row(self, rig: Rig) -> Row:
        """Return all figures of a rig."""
        evaluated = self._evaluated(rig)
        found: Row = {}
        if evaluated.voxels is not None:
            found |= _flat(score_figures(evaluated.voxels))
        if evaluated.objects is not None:
            found |= _flat(object_figures_json(evaluated.objects))
            if self._of_reference.objects is not None:
                found |= dict(self._changes(evaluated.objects, self._of_reference.objects))
        if evaluated.ground is not None:
            of_ground = (figure for figure in figures() if figure.needs == "ground")
            found |= {figure.key: figure.of(evaluated, ALL).value for figure in of_ground}
        return found

    def _evaluated(self, rig: Rig) -> Evaluated:
        return self._evaluate(rig, self._figures.needs, self._figures.frames)

    @cached_property
    def _of_reference(self) -> Evaluated:
        return self._evaluated(self._reference)

    def _changes(self, now: Counted, before: Counted) -> Iterator[tuple[str, float]]:
        """Yield the changes of figures of objects that lead or are spread from the reference, with standard errors."""
        for figure in object_figures():
            if figure.leads or figure.is_spread:
                for name, (change, se) in figure.changes(now, before).items():
                    yield f"{name}.{figure.place}_change", change
                    yield f"{name}.{figure.place}_change_se", se

    def rows(self, sweep: Sweep) -> Iterator[Row]:
        """Yield the rows of a sweep: rig, hash and values of the fields, then the figures."""
        for number in range(len(sweep)):
            rig = sweep.rig(number)
            values = dict(zip(sweep.names, sweep.values[number].tolist(), strict=True))
            yield {"rig": rig.name, "rig_sha256": valid_rig_sha256(rig), **values, **self.row(rig)}

    def inputs(self) -> dict[str, Any]:
        """Return data and settings of all rows as plain data, as in the JSON of `riglens evaluate`."""
        found: dict[str, Any] = {}
        voxels, objects = self._of_reference.voxels, self._of_reference.objects
        if voxels is not None and self._figures.metric is not None:
            field = self._evaluate.voxels.field
            found |= evaluation_document(field, self._figures.metric, [voxels])
        if objects is not None:
            found["targets"] = objects_document([objects])
            del found["targets"]["rigs"], found["targets"]["riglens"]
        return {name: value for name, value in found.items() if name not in ("rigs", "riglens")}

    def noise_floor(
        self, others: Sequence[Rig] = (), progress: Callable[[float], None] = lambda _: None
    ) -> Row:
        """Return how far each figure moves by unavoidable errors of mounts, up and down: half of its range from 5 % to
        95 % of some draws for the reference; figures that it does not have, for the first of some others that does."""
        found = self._noise_floor(self._reference, progress)
        for rig in others:
            if not _numbers(self.row(rig)).keys() <= found.keys():
                found = self._noise_floor(rig) | found
        return found

    def _noise_floor(self, rig: Rig, progress: Callable[[float], None] = lambda _: None) -> Row:
        units, drawn = unit_draws(FLOOR_DRAWS, errors_count(rig), 0), list[Row]()
        for errors in units:
            drawn.append(_numbers(self.row(disturbed(rig, NOISE_FLOOR, errors)[0])))
            progress(len(drawn) / FLOOR_DRAWS)
        spreads = {name: Spread.of(0.0, [one[name] for one in drawn]) for name in drawn[0]}
        return {name: (spread.p95 - spread.p05) / 2.0 for name, spread in spreads.items()}


def _numbers(row: Row) -> Row:
    return {name: value for name, value in row.items() if not isinstance(value, str)}


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
