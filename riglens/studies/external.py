"""`riglens study external`: published experiments with fewer beams against the figures of the same rigs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from riglens.core.engine.engine import Engine
from riglens.core.files import write_file
from riglens.core.monitor import Monitor
from riglens.core.shown_tables import Block, Styled, table
from riglens.core.study.external import (
    FIGURES,
    GROUPS,
    TOLERANCE,
    WITHIN_M,
    Outcome,
    Recording,
    mean_error,
    outcomes,
)
from riglens.evaluation.options import SceneOptions, Triple
from riglens.evaluation.scenario import load_scenario
from riglens.evaluation.traffic import load_traffic
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
) -> list[Block]:
    """Compute the figures on the boxes of both recordings, or of the bundled town; write and return them."""
    require_folder(out, (NAME,))
    found: list[Outcome] = []
    boxes: dict[Recording, Path | None] = {"nuscenes": nuscenes, "kitti": kitti}
    for recording, path in boxes.items():
        scene = SceneOptions()
        if path is not None:
            origin_m = _ORIGINS[recording] if path.is_file() else None
            scene = replace(scene, boxes=path, origin_m=origin_m)
        with monitor.stage(f"Experiments on {recording}") as progress:
            engine = Engine(load_scenario(scene).field, threads)
            traffic = load_traffic(scene, WITHIN_M[recording])
            found += outcomes(recording, traffic, engine, min(frames, traffic.frames), progress)
    write_file(out / NAME, csv_text(list(lines(found))))
    return [*shown(found), f"{out}: {NAME}"]


def shown(found: Sequence[Outcome]) -> Iterator[Block]:
    """Yield ratios to the whole LiDAR, group by group of experiments."""
    for group in GROUPS:
        mine = [one for one in found if one.experiment.group == group]
        titles = ("ratio to the whole LiDAR", "published", *FIGURES.values())
        made = table(*titles, title=group.capitalize(), wraps={0})
        for one in mine:
            ratios = (f"{one.ratios[name]:.2f}{' ' if one.passes(name) else '*'}" for name in FIGURES)
            made.add_row(one.experiment.name, f"{one.experiment.published:.2f}", *ratios)
        errors = (f"{mean_error(mine, name):.3f} " for name in FIGURES)
        made.add_row(Styled("mean error", "bold"), "", *errors)
        yield made
    yield f"* more than {TOLERANCE:g} from the published ratio."


def lines(found: Sequence[Outcome]) -> Iterator[dict[str, object]]:
    """Yield a line per experiment: the figures that its source reports, and the ratios of ours."""
    for one in found:
        of = one.experiment
        line: dict[str, object] = {
            "experiment": of.name,
            "recording": of.recording,
            "boxes": Path(one.boxes).name,
        }
        line |= {"detector": of.detector, "group": of.group, "published": round(of.published, 4)}
        yield line | {name: round(one.ratios[name], 4) for name in FIGURES} | {"source": of.source}
