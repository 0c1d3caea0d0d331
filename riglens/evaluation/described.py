"""Surveys of box data as plain data, with warnings about what deserves a second look."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.statistics import RINGS_M, SECTORS
from riglens.core.scene.survey import Advice, Ground, Survey, doubts, one_sided, survey
from riglens.evaluation.names import argument_with
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import boxes_of


@dataclass(frozen=True)
class Described:
    """A survey of box data."""

    survey: Survey

    def document(self, advice: Advice = argument_with) -> dict[str, Any]:
        """Return the figures; lengths in metres, boxes as counts by quarter and ring of distance. `advice` is what a
        front end calls a field with a value."""
        found, data = self.survey, self.survey.data
        origin_m = found.statistics.origin_m
        return {
            "riglens": FORMAT_VERSION,
            "data": {
                "source": data.short_source,
                "frames": data.frames,
                "sequences": data.sequences,
                "boxes": {name: data.boxes[name] for name in CLASSES},
                "unmapped": dict(data.unmapped.most_common()),
                "sha256": data.sha256,
                "notes": list(data.notes),
                "origin_m": None if origin_m is None else list(origin_m),
            },
            "frames_with_boxes": found.frames_with_boxes,
            "boxes_per_frame": {"mean": found.boxes_per_frame, "most": found.most_in_a_frame},
            "rings_m": [limit if math.isfinite(limit) else None for limit in RINGS_M],
            "classes": {name: _class(found, cls) for cls, name in enumerate(CLASSES)},
            "ground": _ground(found.ground),
            "warnings": list(self.warnings(advice)),
        }

    def warnings(self, advice: Advice = argument_with) -> Iterator[str]:
        """Yield what is implausible about the data, with remedies as `advice` calls them."""
        found, sides = doubts(self.survey.data), one_sided(self.survey)
        for doubt in found if sides is None or sides in found else [sides, *found]:
            yield doubt.sentence(advice)


def described(options: SceneOptions, paths: Sequence[Path], progress: Progress | None = None) -> Described:
    """Survey box data; raise InputError on bad input."""
    return Described(survey(boxes_of(options, paths), progress))


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
