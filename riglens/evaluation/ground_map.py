"""Draw blind zones as a map on the ground of the 3D view: the lowest visible height, and the number of sensors."""

from __future__ import annotations

import numpy as np

from riglens.core.blind.zones import HEIGHTS_M, OVERLAP_HEIGHT_M, BlindMap, By, called, overlap
from riglens.widgets.theme import BLIND_COLOURS, OVERLAP_COLOURS
from riglens.widgets.viewport.ground_map import NOTHING, GroundMap, GroundStep

_FAINT, _STRONG = 0.22, 0.62
_OPACITIES = (_STRONG, 0.55, 0.45, 0.32)
"""Opacities of the steps: well-covered cells are fainter, so that grid and metres show through."""


def ground_map(found: BlindMap, by: By, k: int) -> GroundMap:
    """Return what lies on the ground: the lowest visible height L_k by some sensors, or with k = 0 their overlap."""
    whose = "" if by == "any" else f" by {called(by, True)}"
    if k:
        steps, opacities = found.steps(by, k), (_FAINT, *(_STRONG for _ in HEIGHTS_M))
        words = [*(f"{height_m:.2f}" for height_m in HEIGHTS_M), "unseen"]
        title = f"L{'₁₂'[k - 1]}{whose}: lowest visible height, m (less is better)"
    else:
        steps, opacities = overlap(found), _OPACITIES
        words = ["0", "1", "2", "3+"]
        title = f"sensors that see an object {OVERLAP_HEIGHT_M:.2f} m tall (more is better)"
    steps = np.where(found.ground.counts, steps, np.uint8(NOTHING)).astype(np.uint8)
    meanings = tuple(map(GroundStep, words, BLIND_COLOURS if k else OVERLAP_COLOURS, opacities))
    origin_m = (found.grid.origin_m[0], found.grid.origin_m[1])
    return GroundMap(origin_m, found.grid.voxel_m, steps, meanings, title)
