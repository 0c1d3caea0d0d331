"""`riglens study predicted`: the shipped calibration of predicted detection from a study's average precision."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.files import write_file
from riglens.core.monitor import Monitor
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_tables import Block, Paragraph, ShownTable, table
from riglens.core.shown_text import visible
from riglens.core.study.detection.published import PROTOCOL, published_rigs
from riglens.core.study.detection.second import PROTOCOLS, second_rigs
from riglens.core.study.predicted import (
    UNITS,
    Prediction,
    calibrate_recall,
    calibrate_rigs,
    objects_by_number,
    read_precision,
)
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.traffic import load_traffic
from riglens.studies.files import csv_text, require_folder

NAMES = ("predicted-detection.csv", "predicted-detection-cells.csv", "study.yaml", "recall.yaml")
_DIGITS = 4
CHANGES = (0.0, 1.0, 2.0, 3.0, 5.0, 10.0)
"""Sizes by which changes are grouped, points of mAP."""


def study(detection: Path, recall: Path | None, out: Path, monitor: Monitor) -> list[Block]:
    """Fit curves to the rigs of the published study, return how far they miss rigs left out, and write the files;
    recall: table of the second study, to fit the curves of recall too."""
    rigs = published_rigs()
    observed = read_precision(detection, rigs)
    found_by = None if recall is None else calibrate_recall(recall, second_rigs(), PROTOCOLS["one-sweep"])
    require_folder(out, NAMES)
    traffic = load_traffic(SceneOptions(), WITHIN_M)
    with monitor.stage("Casting rays") as progress:
        objects = objects_by_number(rigs, traffic, PROTOCOL, progress)
    rays = {rig.name: sum(lidar.ray_count for lidar in rig.enabled_lidars()) for rig in rigs}
    found = [calibrate_rigs(rays, objects[unit], observed, unit, PROTOCOL) for unit in UNITS]
    write_file(out / NAMES[0], csv_text(list(rig_lines(found[0]))))
    write_file(out / NAMES[1], csv_text(list(count_lines(found[0].rigs, objects["cells"]))))
    write_file(out / NAMES[2], found[0].calibration.text())
    if found_by is not None:
        write_file(out / NAMES[3], found_by.text())
    said: list[Block] = [_rig_table(found[0]), _error_table(found), _change_table(found[0])]
    if found_by is not None:
        errors = ", ".join(
            f"{name} {100.0 * error:.1f}" for name, error in zip(CLASSES, found_by.errors[1:], strict=True)
        )
        said.append(Paragraph(f"Error of recall on rigs or sequences left out, points: {errors}."))
    return [*said, f"{out}: {', '.join(NAMES[: 3 if found_by is None else 4])}"]


def rig_lines(found: Prediction) -> Iterator[dict[str, object]]:
    """Yield one line per rig and class: AP, and as predicted by the curve of the other rigs, in percent."""
    for rig, observed, left_out in zip(found.rigs, found.observed, found.left_out, strict=True):
        for name, one, other in zip(
            (*CLASSES, "mean"), (*observed, observed.mean()), (*left_out, left_out.mean()), strict=True
        ):
            yield {
                "rig": rig,
                "class": name,
                "ap": round(100.0 * one, _DIGITS),
                "predicted": round(100.0 * other, _DIGITS),
            }


def count_lines(rigs: Sequence[str], objects: NDArray[np.int64]) -> Iterator[dict[str, object]]:
    """Yield how many objects have how many cells, by rig and class."""
    for rig, by_class in zip(rigs, objects, strict=True):
        for name, numbers in zip(CLASSES, by_class, strict=True):
            for n in np.flatnonzero(numbers).tolist():
                yield {"rig": rig, "class": name, "cells": n, "objects": int(numbers[n])}


def _rig_table(found: Prediction) -> ShownTable:
    shown = table("AP, predicted by other rigs", *CLASSES, "mAP", wraps={0})
    observed, predicted = (
        100.0 * np.column_stack([one, one.mean(axis=1)]) for one in (found.observed, found.left_out)
    )
    for place in np.argsort(-observed[:, -1], kind="stable").tolist():
        pairs = zip(observed[place], predicted[place], strict=True)
        shown.add_row(visible(found.rigs[place]), *(f"{one:.1f}, {other:.1f}" for one, other in pairs))
    return shown


def _error_table(found: Sequence[Prediction]) -> ShownTable:
    shown = table("rigs left out, by", *CLASSES, "mAP", "rank", "rank, equal rays")
    for one in found:
        errors = [f"{100.0 * error:.2f}" for error in one.errors()]
        shown.add_row(one.calibration.unit, *errors, f"{one.rank():.3f}", f"{one.rank(equal_rays=True):.3f}")
    return shown


def _change_table(found: Prediction) -> ShownTable:
    """Return how far predicted changes of mAP miss the measured ones, and how often their signs agree, by size."""
    shown = table("predicted change of mAP, points", "pairs", "same sign", "error")
    measured, predicted = found.changes()
    size = 100.0 * np.abs(predicted)
    for least, most in pairwise((*CHANGES, np.inf)):
        mine = (size >= least) & (size < most)
        if mine.any():
            agree = np.sign(measured[mine]) == np.sign(predicted[mine])
            error = 100.0 * np.sqrt(np.mean((predicted[mine] - measured[mine]) ** 2))
            words = f"{least:g} to {most:g}" if np.isfinite(most) else f"{least:g} or more"
            shown.add_row(words, f"{mine.sum()}", f"{100.0 * agree.mean():.0f} %", f"{error:.1f}")
    return shown
