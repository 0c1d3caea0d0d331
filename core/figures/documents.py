"""Return rigs' figures as plain data: those of objects part by part, and every figure by class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from riglens.core.engine.evaluation_json import evaluation_document as voxels_document
from riglens.core.figures.evaluated import Evaluated
from riglens.core.figures.figure import ALL, Estimate, Figure
from riglens.core.figures.objects import ObjectFigure, Part, parts_by_class, parts_by_sector
from riglens.core.figures.predicted import PREDICTED
from riglens.core.figures.registry import figures, leading_figures, object_figures
from riglens.core.figures.sentence import changes_of, sentence
from riglens.core.figures.weakest import weakest_by_class
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, MetricSettings, common_body
from riglens.core.plain import to_plain
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.survey import notes_on
from riglens.core.shown_text import numbered
from riglens.core.targets.counts import Counted


def evaluation_document(
    field: EntropyField, settings: MetricSettings, rigs: Sequence[Evaluated]
) -> dict[str, Any]:
    """Return the scores of evaluated rigs as plain data, with every figure of each class under its key, and the objects
    on which figures rest where they were counted."""
    voxels = [one.voxels for one in rigs if one.voxels is not None]
    document = voxels_document(field, settings, voxels)
    first = numbered([one.rig.name for one in rigs])[0]
    for written, one in zip(document["rigs"], rigs, strict=True):
        if one is not rigs[0]:
            written["against_first"] = sentence(changes_of(one, rigs[0]), first)
        written["figures"] = _written(one, ALL, figures_of(one))
        of_class = [each for each in figures_of(one) if each.per_class]
        for name in CLASSES:
            written["classes"][name]["figures"] = _written(one, name, of_class)
        _add_weakest(one, written)
    counted = [one.objects for one in rigs if one.objects is not None]
    return document | ({"targets": objects_document(counted)} if counted else {})


def figures_of(rig: Evaluated) -> tuple[Figure, ...]:
    """Return the figures of the kinds of sensors that a rig has."""
    return figures(_kinds(rig.rig))


def _add_weakest(rig: Evaluated, written: Mapping[str, Any]) -> None:
    """Add where the leading figures of objects are worst to those of the rig and of its classes."""
    if rig.objects is None:
        return
    rooms = {ALL: written["figures"]} | {name: written["classes"][name]["figures"] for name in CLASSES}
    for figure in leading_figures():
        if isinstance(figure, ObjectFigure):
            for who, found in weakest_by_class(figure, rig.objects).items():
                rooms[who][figure.key]["weakest"] = found.as_dict()


def _written(rig: Evaluated, who: str, wanted: Sequence[Figure]) -> dict[str, Any]:
    """Return figures by key: value, error, state and reason; null for no value."""
    return {one.key: estimate_document(one.of(rig, who)) for one in wanted}


def estimate_document(found: Estimate) -> dict[str, Any]:
    """Return an estimate as plain data: value, error, state, reason and parts; null for no value."""
    written: dict[str, Any] = {
        "value": found.value if found.exists else None,
        "se": found.se,
        "state": found.state,
        "reason": found.reason or None,
    }
    return written | ({"parts": dict(found.parts)} if found.parts else {})


def _kinds(rig: Rig) -> list[str]:
    return [sensor.kind for sensor in rig.sensors if sensor.enabled]


def objects_document(counted: Sequence[Counted]) -> dict[str, Any]:
    """Return figures of some rigs, at least one, in the same traffic and with the same settings; shares as fractions.

    `body` is null where rigs differ, and then said of each.
    """
    first, traffic = counted[0], counted[0].traffic
    data = traffic.data
    body = common_body(one.settings.body for one in counted)
    objects = np.bincount(traffic.cls[first.objects.box], minlength=len(CLASSES))
    return {
        "riglens": FORMAT_VERSION,
        **(first.settings.as_dict() | {"body": body}),
        "within_m": traffic.within_m,
        "surroundings": "block" if traffic.surroundings_sha256 else "ignored",
        "data": {
            "source": data.short_source,
            "frames": data.frames,
            "frames_used": first.frames_used,
            "objects": {name: int(number) for name, number in zip(CLASSES, objects, strict=True)},
            "sha256": data.sha256,
            "surroundings_sha256": traffic.surroundings_sha256,
            "notes": notes_on(data),
        },
        "calibration": to_plain(first.calibration),
        "recall_calibration": to_plain(recall) if (recall := first.settings.recall) else None,
        "rigs": [_rig(one, body) for one in counted],
    }


def _rig(counted: Counted, body: Body | None) -> dict[str, Any]:
    of_kinds = object_figures(_kinds(counted.rig))
    sectors, found = parts_by_sector(counted, of_kinds), object_figures_json(counted, with_rings=True)
    for name, parts in sectors.items():
        found["classes"][name]["sectors"] = [
            {"sector": sector} | _part(part, of_kinds) for sector, part in parts.items()
        ]
    return {
        **identity_of(counted.rig),
        **({} if body else {"body": counted.settings.body}),
        "elapsed_ms": counted.elapsed_ms,
        **found,
    }


def object_figures_json(counted: Counted, with_rings: bool = False) -> dict[str, Any]:
    """Return a rig's figures for objects as plain data, of each class and, if requested, ring by ring."""
    of_kinds, recall = object_figures(_kinds(counted.rig)), counted.settings.recall
    mean, classes = PREDICTED.estimates(counted, "all", (ALL,), in_detail=False)[ALL][0], dict[str, Any]()
    for name, found in parts_by_class(counted, of_kinds, with_rings, in_detail=False).items():
        classes[name] = _class(found.total, of_kinds)
        if with_rings:
            classes[name]["rings"] = [
                {"from_m": ring.from_m, "to_m": ring.to_m} | _part(ring, of_kinds) for ring in found.rings
            ]
    return {
        "predicted_mean": _calibrated(mean),
        "predicted_outside": counted.outside(counted.calibration),
        "found_outside": "" if recall is None else counted.outside(recall),
        "classes": classes,
    }


def _class(total: Part, of_kinds: Sequence[ObjectFigure]) -> dict[str, Any]:
    """Return the figures of a class, each at its place."""
    found: dict[str, Any] = {"objects": total.objects}
    for figure in of_kinds:
        *rooms, name = figure.place.split(".")
        room = found
        for one in rooms:
            room = room.setdefault(one, {})
        room |= _values(figure, name, total[figure.key])
    return found


def _part(part: Part, of_kinds: Sequence[ObjectFigure]) -> dict[str, Any]:
    """Return the figures of a ring or sector, each by its name alone unless another kind has one of that name."""
    found: dict[str, Any] = {"objects": part.objects}
    for figure in of_kinds:
        *rooms, name = figure.place.split(".")
        values = _values(figure, name, part[figure.key])
        found |= {rooms[-1]: values} if name == "share" else values
    return found


def _values(figure: ObjectFigure, name: str, found: Estimate) -> Mapping[str, Any]:
    if figure.calibration is not None:
        return {name: _calibrated(found)}
    return {name: found.value} if figure.is_median else {name: found.value, f"{name}_se": found.se}


def _calibrated(found: Estimate) -> dict[str, Any] | None:
    return to_plain(found, "value", "se", "sample_se", "objects") if found.exists else None
