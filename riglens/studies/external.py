"""`riglens study external`: published experiments with other sensors against the figures of the same rigs."""

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
from riglens.core.shown_tables import Block, Paragraph, Styled, table
from riglens.core.study.anchors import FAILS, GROUPS, NARROW, WITHIN_M, Recording
from riglens.core.study.external import (
    FIGURES,
    INSIDE,
    PERCEPTION,
    TOLERANCE,
    AnchorRatios,
    mean_error,
    outcomes,
)
from riglens.core.targets.groups import RUNS
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
) -> list[AnchorRatios]:
    """Compute the figures on the boxes of both recordings, or of the bundled town; write and return them, group by
    group."""
    require_folder(out, (NAME,))
    found: list[AnchorRatios] = []
    boxes: dict[Recording, Path | None] = {"nuscenes": nuscenes, "kitti": kitti}
    for recording, path in boxes.items():
        scene = SceneOptions()
        if path is not None:
            origin_m = _ORIGINS[recording] if path.is_file() else None
            scene = replace(scene, boxes=path, origin_m=origin_m)
        engine = Engine(load_scene(scene, monitor)[1], threads)
        traffic = load_traffic(scene, WITHIN_M[recording], monitor)
        with monitor.stage(f"Anchors on {recording}") as progress:
            found += outcomes(recording, traffic, engine, min(frames, traffic.frames), progress)
    found.sort(key=lambda one: GROUPS.index(one.anchor.group))
    write_file(out / NAME, csv_text(list(lines(found))))
    return found


def document(found: Sequence[AnchorRatios]) -> dict[str, Any]:
    """Return published and predicted ratios of average precision as plain data, group by group; None where a region
    holds no object of a class."""
    groups = [
        {
            "name": group,
            "passes": sum(one.passes(one.anchor.figure) for one in _of(found, group)),
            "tests": [_test(one) for one in _of(found, group)],
        }
        for group in GROUPS
    ]
    return {"riglens": FORMAT_VERSION, "tolerance": TOLERANCE, "groups": groups}


def _of(found: Sequence[AnchorRatios], group: str) -> list[AnchorRatios]:
    return [one for one in found if one.anchor.group == group]


def _test(one: AnchorRatios) -> dict[str, Any]:
    of = one.anchor
    return {
        "name": of.name,
        "objects": of.region,
        "boxes": Path(one.boxes).name,
        "published": of.published,
        "figure": of.figure,
        "predicted": None if math.isnan(one.judged) else one.judged,
        "traffic_sd": None if math.isnan(one.traffic_sd) else one.traffic_sd,
        "passes": one.passes(of.figure),
        "known_fail": of.fails or None,
        "source": of.source,
    }


def shown(found: Sequence[AnchorRatios]) -> Iterator[Block]:
    """Yield the ratios, group by group of anchors."""
    for group in GROUPS:
        mine = _of(found, group)
        if not mine:
            continue
        titles = (
            "ratio of AP after to before",
            "published",
            *(f"{title}" for title in FIGURES.values()),
            "±",
        )
        made = table(
            *titles, title=Styled(f"{group[:1].upper()}{group[1:]}: {_passes(mine)}", "bold"), wraps={0}
        )
        for one in mine:
            words = f"{one.anchor.name}{' (known)' if one.anchor.fails and group != FAILS else ''}"
            ratios = (_ratio(one, name) for name in FIGURES)
            made.add_row(words, f"{one.anchor.published:.2f}", *ratios, f"{one.traffic_sd:.2f}")
        errors = (_error(mine, name) for name in FIGURES)
        made.add_row(Styled("mean error", "bold"), "", *errors, "")
        yield made
        alike = sum(one.passes(PERCEPTION) for one in mine)
        yield (
            f"Perception entropy (Ma et al. 2021): passes {alike} of {len(mine)}, mean error "
            f"{_error(mine, PERCEPTION).strip()}"
        )
        if group == NARROW:
            shares = ", ".join(f"{one.ratios[INSIDE]:.2f}" for one in mine)
            yield Paragraph(
                f"Seen by cameras without the edge of the picture (the visible share of what lies inside): {shares}, "
                f"passes {sum(one.passes(INSIDE) for one in mine)} of {len(mine)}"
            )
    yield Paragraph(
        f"* more than {TOLERANCE:g} from the published ratio. Predicted AP is judged, of narrow and wide cameras seen "
        f"by cameras. ±: standard deviation of the judged ratio over {RUNS} runs of frames drawn with replacement: "
        "traffic alone moves it so far."
    )
    known = {one.anchor.name: one.anchor.fails for one in found if one.anchor.fails}
    yield "Known not to hold:"
    for reason in dict.fromkeys(known.values()):
        names = ", ".join(name for name, why in known.items() if why == reason)
        yield Paragraph(f"  {reason}: {names}")


def _passes(mine: Sequence[AnchorRatios]) -> str:
    count = sum(one.passes(one.anchor.figure) for one in mine)
    judged = " and ".join(dict.fromkeys(FIGURES[one.anchor.figure] for one in mine))
    return f"{judged} passes {count} of {len(mine)}"


def _ratio(one: AnchorRatios, name: str) -> str:
    if math.isnan(one.ratios[name]):
        return "– "
    return f"{one.ratios[name]:.2f}{' ' if one.passes(name) else '*'}"


def _error(mine: Sequence[AnchorRatios], name: str) -> str:
    error = mean_error(mine, name)
    return "– " if math.isnan(error) else f"{error:.3f} "


def lines(found: Sequence[AnchorRatios]) -> Iterator[dict[str, object]]:
    """Yield a line per anchor: the ratio that its source reports, and those of our figures."""
    for one in found:
        of = one.anchor
        line: dict[str, object] = {
            "test": of.name,
            "group": of.group,
            "recording": of.recording,
            "boxes": Path(one.boxes).name,
            "objects": of.region,
            "detector": of.detector,
            "published": round(of.published, 4),
            "judged": of.figure,
            "passes": one.passes(of.figure),
            "traffic_sd": _short(one.traffic_sd),
        }
        ratios = {name: _short(one.ratios[name]) for name in (*FIGURES, PERCEPTION, INSIDE)}
        yield line | ratios | {"known_fail": of.fails, "source": of.source}


def _short(value: float) -> float | str:
    return "" if math.isnan(value) else round(value, 4)
