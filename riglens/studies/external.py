"""`riglens study external`: published experiments with fewer beams against the figures of the same rigs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from riglens.core.engine.engine import Engine
from riglens.core.files import write_file
from riglens.core.monitor import Monitor
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.shown_tables import Block, Styled, table
from riglens.core.study.external import (
    FIGURES,
    GROUPS,
    TOLERANCE,
    WITHIN_M,
    ExperimentRatios,
    Recording,
    mean_error,
    outcomes,
)
from riglens.evaluation.loading import load_scene, load_traffic
from riglens.evaluation.options import SceneOptions, Triple
from riglens.studies.files import csv_text, require_folder

NAME = "external.csv"
FRAMES = 400
"""Sampled frames: enough for ratios to the second digit."""
_ORIGINS: dict[Recording, Triple] = {"nuscenes": (-1.35, 0.0, 0.0), "kitti": (0.4, 0.0, 1.73)}
"""Of tables of boxes: nuScenes' in the frame of the rear axle, KITTI's in that of the Velodyne."""


def study(
    nuscenes: Path | None,
    kitti: Path | None,
    threads: int | None,
    frames: int,
    out: Path,
    monitor: Monitor,
) -> list[ExperimentRatios]:
    """Compute the figures on the boxes of both recordings, or of the bundled town; write and return them."""
    require_folder(out, (NAME,))
    found: list[ExperimentRatios] = []
    boxes: dict[Recording, Path | None] = {"nuscenes": nuscenes, "kitti": kitti}
    for recording, path in boxes.items():
        scene = SceneOptions()
        if path is not None:
            origin_m = _ORIGINS[recording] if path.is_file() else None
            scene = replace(scene, boxes=path, origin_m=origin_m)
        engine = Engine(load_scene(scene, monitor)[1], threads)
        traffic = load_traffic(scene, WITHIN_M[recording], monitor)
        with monitor.stage(f"Experiments on {recording}") as progress:
            found += outcomes(recording, traffic, engine, min(frames, traffic.frames), progress)
    write_file(out / NAME, csv_text(list(lines(found))))
    return found


def document(found: Sequence[ExperimentRatios]) -> dict[str, Any]:
    """Return published and predicted ratios of average precision as plain data, group by group; None where a region
    holds no object of a class."""
    groups = [{"name": group, "tests": [_test(one) for one in _of(found, group)]} for group in GROUPS]
    return {"riglens": FORMAT_VERSION, "groups": groups}


def _of(found: Sequence[ExperimentRatios], group: str) -> list[ExperimentRatios]:
    return [one for one in found if one.experiment.group == group]


def _test(one: ExperimentRatios) -> dict[str, Any]:
    of, predicted = one.experiment, one.ratios["predicted"]
    return {
        "name": of.name,
        "objects": of.region,
        "boxes": Path(one.boxes).name,
        "published": of.published,
        "predicted": None if math.isnan(predicted) else predicted,
        "passes": one.passes("predicted"),
    }


def shown(found: Sequence[ExperimentRatios]) -> Iterator[Block]:
    """Yield ratios to the whole LiDAR, group by group of experiments."""
    for group in GROUPS:
        mine = _of(found, group)
        titles = ("ratio to the whole LiDAR", "objects", "published", *FIGURES.values())
        made = table(*titles, title=group.capitalize(), wraps={0, 1})
        for one in mine:
            ratios = (f"{one.ratios[name]:.2f}{' ' if one.passes(name) else '*'}" for name in FIGURES)
            made.add_row(
                one.experiment.name, one.experiment.region, f"{one.experiment.published:.2f}", *ratios
            )
        errors = (f"{mean_error(mine, name):.3f} " for name in FIGURES)
        made.add_row(Styled("mean error", "bold"), "", "", *errors)
        yield made
    yield f"* more than {TOLERANCE:g} from the published ratio."


def lines(found: Sequence[ExperimentRatios]) -> Iterator[dict[str, object]]:
    """Yield a line per experiment: the figures that its source reports, and the ratios of ours."""
    for one in found:
        of = one.experiment
        line: dict[str, object] = {
            "experiment": of.name,
            "recording": of.recording,
            "boxes": Path(one.boxes).name,
            "objects": of.region,
        }
        line |= {"detector": of.detector, "group": of.group, "published": round(of.published, 4)}
        yield line | {name: round(one.ratios[name], 4) for name in FIGURES} | {"source": of.source}
