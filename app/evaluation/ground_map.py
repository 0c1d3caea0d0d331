"""Blind zones as a map on the ground of the 3D view: where how small an object is seen, and by how many sensors."""

from __future__ import annotations

from typing import Literal

import numpy as np

from riglens.core.review.blind import HEIGHTS_M, BlindMap
from riglens.widgets.theme import BLIND_COLOURS, OVERLAP_COLOURS
from riglens.widgets.viewport.ground_map import NOTHING, GroundMap, GroundStep

GroundMode = Literal["none", "blind", "overlap"]
OVERLAP_HEIGHT_M = HEIGHTS_M[2]
"""Height of the object that sensors are counted for: the test cylinder of UN R158 and FMVSS 111."""
_FAINT, _STRONG = 0.22, 0.62
_OPACITIES = (_STRONG, 0.55, 0.45, 0.32)
"""What is seen well is fainter: grid and metres show through it."""


def ground_map(mode: GroundMode, found: BlindMap | None) -> GroundMap | None:
    """What lies on the ground in a mode, None for nothing."""
    if mode == "none" or found is None:
        return None
    steps, meanings, title = _blind(found) if mode == "blind" else _overlap(found)
    steps = np.where(found.ground.counts, steps, np.uint8(NOTHING)).astype(np.uint8)
    origin_m = (found.grid.origin_m[0], found.grid.origin_m[1])
    return GroundMap(origin_m, found.grid.voxel_m, steps, meanings, title)


_Parts = tuple["np.ndarray[tuple[int, ...], np.dtype[np.uint8]]", tuple[GroundStep, ...], str]


def _blind(found: BlindMap) -> _Parts:
    words = [f"{height_m:.2f}" for height_m in HEIGHTS_M] + ["unseen"]
    meanings = tuple(
        GroundStep(text, colour, _STRONG if number else _FAINT)
        for number, (text, colour) in enumerate(zip(words, BLIND_COLOURS, strict=True))
    )
    return found.steps(), meanings, "L₁: seen if at least so high, m (less is better)"


def _overlap(found: BlindMap) -> _Parts:
    counted = np.sum([found.lowest_m("any", k) <= OVERLAP_HEIGHT_M + 1e-9 for k in (1, 2, 3)], axis=0)
    words = ("0", "1", "2", "3+")
    meanings = tuple(
        GroundStep(text, colour, opacity)
        for text, colour, opacity in zip(words, OVERLAP_COLOURS, _OPACITIES, strict=True)
    )
    return (
        counted.astype(np.uint8),
        meanings,
        f"sensors that see an object of {OVERLAP_HEIGHT_M:.2f} m (more is better)",
    )
