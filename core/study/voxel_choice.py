"""Choose the voxel edge: the coarsest of a ladder at which the scores of the rigs stay the same.

The reference is the finest edge that fits. S-MIG and S-MS in nat cannot be compared between edges, because
the number of voxels grows with edge^-3; what is compared is `seen`, the share of H(Omega), of cameras, of
LiDARs and of any sensor, for each class and rig, and the order of the rigs by S-MS for each class.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.metric.scores import Scores
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid

LADDER_M = (0.4, 0.2, 0.1, 0.05)
DEFAULT_TOLERANCE = 0.01
BYTES_PER_VOXEL = 32.0
"""Memory for building and scoring a POG in which every voxel is informative; usually a third is needed."""
SEEN_BY = ("cameras", "LiDARs", "any sensor")


@dataclass(frozen=True)
class EdgeScores:
    """One voxel edge with the scores of all rigs, as (name, scores), in the same order for every edge."""

    voxel_m: float
    scores: tuple[tuple[str, Scores], ...]


class Change(NamedTuple):
    """Largest change of a `seen` (0..1) from that at the finest edge: its amount, class and rig."""

    seen: float
    by: str
    cls: str
    rig: str


class Swap(NamedTuple):
    """Two rigs with another order by S-MS of a class than at the finest edge."""

    first: str
    second: str
    cls: str


@dataclass(frozen=True)
class EdgeResult:
    """One voxel edge against the finest: the largest change of a `seen` and the first swap, None without any.

    `agrees` is about this edge alone.
    """

    voxel_m: float
    change: Change | None
    swap: Swap | None
    agrees: bool


@dataclass(frozen=True)
class VoxelChoice:
    """Chosen edge, and every edge tried, from the finest to the coarsest.

    `rigs` is how many rigs were scored on each; `left_out` holds (edge, reason) of edges that could not be tried;
    `tolerance` is a fraction of H(Omega).
    """

    voxel_m: float
    tolerance: float
    edges: tuple[EdgeResult, ...]
    rigs: int
    left_out: tuple[tuple[float, str], ...] = ()

    @property
    def finest_m(self) -> float:
        """The edge that the others were compared with."""
        return self.edges[0].voxel_m


def ladder_grids(roi_m: Vec3) -> tuple[tuple[VoxelGrid, ...], tuple[tuple[float, str], ...]]:
    """Return grids to try, the finest first, and (edge, reason) of those that do not divide the ROI or do not fit.

    InputError when none is left.
    """
    grids, left_out = [], []
    for voxel_m in sorted(LADDER_M):
        try:
            grid = VoxelGrid(voxel_m, roi_m)
            grid.require_memory(BYTES_PER_VOXEL, "scoring")
        except InputError as error:
            left_out.append((voxel_m, error.message))
        else:
            grids.append(grid)
    if not grids:
        edges = ", ".join(f"{edge:g}" for edge in LADDER_M)
        first = left_out[-1][1]
        raise InputError(f"voxel auto: none of the edges {edges} m can be used ({first}); give one in metres")
    return tuple(grids), tuple(left_out)


def choose(
    tried: Sequence[EdgeScores],
    tolerance: float = DEFAULT_TOLERANCE,
    left_out: tuple[tuple[float, str], ...] = (),
) -> VoxelChoice:
    """Return the coarsest edge that agrees with the finest, together with all edges in between.

    An edge agrees when no `seen` of any rig and class differs by more than `tolerance` and every two rigs
    have the same order of S-MS, for every class. Edges may come in any order; at least one is needed.
    """
    finest, *coarser = sorted(tried, key=lambda one: one.voxel_m)
    edges = [EdgeResult(finest.voxel_m, None, None, True)]
    edges += [_compare(one, finest, tolerance) for one in coarser]
    picked = finest.voxel_m
    for result in edges:
        if not result.agrees:
            break
        picked = result.voxel_m
    return VoxelChoice(picked, tolerance, tuple(edges), len(finest.scores), left_out)


def _compare(one: EdgeScores, finest: EdgeScores, tolerance: float) -> EdgeResult:
    change = max(_changes(one, finest), key=lambda found: found.seen, default=None)
    swap = next(_swaps(one, finest), None)
    agrees = swap is None and (change is None or change.seen <= tolerance)
    return EdgeResult(one.voxel_m, change, swap, agrees)


def _changes(one: EdgeScores, finest: EdgeScores) -> Iterator[Change]:
    """Return the change of each `seen`."""
    for (name, here), (_, there) in zip(one.scores, finest.scores, strict=True):
        for cls in CLASSES:
            for by, now, then in zip(SEEN_BY, _seen(here, cls), _seen(there, cls), strict=True):
                yield Change(abs(now - then), by, cls, name)


def _seen(scores: Scores, cls: str) -> tuple[float, float, float]:
    found = scores.classes[cls]
    return found.camera.seen, found.lidar.seen, found.any_seen


def _swaps(one: EdgeScores, finest: EdgeScores) -> Iterator[Swap]:
    """Yield pairs of rigs with another order by S-MS."""
    for a, b in combinations(range(len(one.scores)), 2):
        for cls in CLASSES:
            if _order(one, a, b, cls) != _order(finest, a, b, cls):
                yield Swap(one.scores[a][0], one.scores[b][0], cls)


def _order(tried: EdgeScores, a: int, b: int, cls: str) -> int:
    """Return -1, 0 or 1 as the S-MS of rig a is below, equal to or above that of rig b."""
    first, second = (tried.scores[i][1].classes[cls].s_ms for i in (a, b))
    return (first > second) - (first < second)
