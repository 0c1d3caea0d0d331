"""Surveys of box data as plain data, with warnings about what deserves a second look."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from riglens.core.geometry import Vec3
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.readers.opening import has_known_origin
from riglens.core.scene.survey import RINGS_M, SECTORS, Ground, Survey, survey
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import boxes_of

GROUND_IS_RIGHT_M = 0.2
"""Bottoms of labelled boxes are rarely nearer to the road than that; the ROI starts at z = 0."""


@dataclass(frozen=True)
class Described:
    """A survey of box data, their origin, and whether its height is known rather than estimated."""

    survey: Survey
    origin_m: Vec3 | None
    is_origin_known: bool

    def document(self, name: Callable[[str], str] = str) -> dict[str, Any]:
        """Return the figures; lengths in metres, boxes as counts by quarter and ring of distance. `name` is what a
        front end calls a field."""
        found, data = self.survey, self.survey.data
        return {
            "riglens": FORMAT_VERSION,
            "data": {
                "source": data.source,
                "frames": data.frames,
                "sequences": data.sequences,
                "boxes": {name: data.boxes[name] for name in CLASSES},
                "unmapped": dict(data.unmapped.most_common()),
                "sha256": data.sha256,
                "notes": list(data.notes),
                "origin_m": None if self.origin_m is None else list(self.origin_m),
            },
            "frames_with_boxes": found.frames_with_boxes,
            "boxes_per_frame": {"mean": found.boxes_per_frame, "most": found.most_in_a_frame},
            "rings_m": [limit if math.isfinite(limit) else None for limit in RINGS_M],
            "classes": {name: _class(found, cls) for cls, name in enumerate(CLASSES)},
            "ground": _ground(found.ground),
            "warnings": list(self.warnings(name)),
        }

    def warnings(self, name: Callable[[str], str] = str) -> Iterator[str]:
        """Yield warnings on directions without boxes, and on a ground that is not at z = 0, with fields as `name` calls
        them."""
        bare = self.survey.bare_sectors()
        if bare:
            listed = ", ".join(f"{name} ({count:,})" for name, count in bare.items())
            yield (
                f"almost no boxes {listed}: the data may not cover every side, and coverage there gains almost nothing"
            )
        ground = self.survey.ground
        if ground is None or self.is_origin_known or not ground.is_certain:
            return
        if abs(ground.height_m) > GROUND_IS_RIGHT_M:
            advice = f"use {name('find_ground')} auto"
            if self.origin_m is not None:
                x, y, z = self.origin_m
                advice += f" or {name('origin_m')} {x:g} {y:g} {z + ground.lift_m:.4g}"
            yield f"the ground is not at z = 0 but at {ground.height_m:.2f} m: {advice}"


def described(options: SceneOptions, paths: Sequence[Path], progress: Progress | None = None) -> Described:
    """Survey box data; raise InputError on bad input."""
    source = boxes_of(options, paths)
    is_known = options.origin_m is None and all(has_known_origin(path) for path in paths)
    return Described(survey(source, progress), source.origin_m, is_known)


def _class(found: Survey, cls: int) -> dict[str, Any]:
    sizes = [None if math.isnan(edge) else edge for edge in found.sizes_m[cls].tolist()]
    return {
        "boxes": int(found.counts[cls].sum()),
        "sectors": {name: found.counts[cls, place].tolist() for place, name in enumerate(SECTORS)},
        "median_size_m": dict(zip(("length", "width", "height"), sizes, strict=True)),
    }


def _ground(ground: Ground | None) -> dict[str, Any] | None:
    if ground is None:
        return None
    return {
        "height_m": ground.height_m,
        "half_between_m": list(ground.between_m),
        "boxes": ground.boxes,
        "class": ground.cls,
        "certain": ground.is_certain,
    }
