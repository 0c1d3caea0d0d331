"""How wrong each answer of the accuracy study is, and which points are on the Pareto fronts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from riglens.core.metric.entropy import EntropyField
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.accuracy_points import MethodName, Point, Wrong
from riglens.core.study.cases import Answer, Case, LatticeName
from riglens.core.study.plain import FLAGS

ROUNDING = 1e-12
"""Relative differences below this are the rounding of doubles, not an error."""


class Contestant(NamedTuple):
    """A method on a grid with a ray lattice, and the case that does it."""

    method: MethodName
    lattice: LatticeName
    rays: int
    threads: int
    field: EntropyField
    case: Case


def points_of(
    entrants: Sequence[Contestant],
    answers: Sequence[Answer],
    times: Sequence[Sequence[float]],
    voxel_m: float,
    finest_m: float,
) -> list[Point]:
    """A point per contestant: its times, and its errors against the exact answers among them."""
    exact = {
        entrant.field.grid.voxel_m: (entrant.field, answer)
        for entrant, answer in zip(entrants, answers, strict=True)
        if entrant.method == "exact" and entrant.lattice == "own"
    }
    own, reference = exact[voxel_m][1], exact[finest_m]
    points = []
    for entrant, answer, ms in zip(entrants, answers, times, strict=True):
        edge_m = entrant.field.grid.voxel_m
        errors = [
            _score_errors((entrant.field, answer), exact[edge_m], reference, c) for c in range(len(CLASSES))
        ]
        points.append(
            Point(
                method=entrant.method,
                voxel_m=edge_m,
                lattice=entrant.lattice,
                rays=entrant.rays,
                threads=entrant.threads,
                times_ms=tuple(ms),
                s_ms=dict(zip(CLASSES, answer.s_ms, strict=True)),
                wrong=wrong_voxels(own.seen, answer.seen) if edge_m == voxel_m else None,
                share=dict(zip(CLASSES, (error[0] for error in errors), strict=True)),
                grid_error=dict(zip(CLASSES, (error[1] for error in errors), strict=True)),
                shortcut_error=dict(zip(CLASSES, (error[2] for error in errors), strict=True)),
                raw_error=dict(zip(CLASSES, (error[3] for error in errors), strict=True)),
            )
        )
    return points


_Scored = tuple[EntropyField, Answer]
_Errors = tuple[float | None, float | None, float | None, float | None]


def _score_errors(mine: _Scored, exact: _Scored, reference: _Scored, cls: int) -> _Errors:
    """Share, grid error, shortcut error and raw error of one class."""
    share, exact_share, finest_share = (_share(scored, cls) for scored in (mine, exact, reference))
    if share is None or exact_share is None or not finest_share:
        return share, None, None, None
    in_nats = reference[1].s_ms[cls]
    raw = abs(mine[1].s_ms[cls] - in_nats) / abs(in_nats)
    grid, shortcut = abs(exact_share - finest_share), abs(share - exact_share)
    return share, _beyond_rounding(grid / finest_share), _beyond_rounding(shortcut / finest_share), raw


def _beyond_rounding(error: float) -> float:
    return error if error > ROUNDING else 0.0


def _share(scored: _Scored, cls: int) -> float | None:
    """-S-MS / H(Omega); None without any entropy."""
    field, answer = scored
    total = field.h_total_nat(cls)
    return -answer.s_ms[cls] / total if total else None


def wrong_voxels(exact: np.ndarray, found: np.ndarray) -> Wrong:
    """Missed and extra voxels of a cover (n,), bits as in FLAGS; shares of the exact ones (0 without any)."""
    counts = []
    for flag in FLAGS.values():
        right, mine = (exact & flag) != 0, (found & flag) != 0
        counts.append((int((right & ~mine).sum()), int((mine & ~right).sum()), int(right.sum())))
    (missed_c, extra_c, all_c), (missed_l, extra_l, all_l) = counts
    both = max(all_c + all_l, 1)
    missed = missed_c / max(all_c, 1), missed_l / max(all_l, 1), (missed_c + missed_l) / both
    return Wrong(*missed, extra_c / max(all_c, 1), extra_l / max(all_l, 1), (extra_c + extra_l) / both)


def pareto_front(costs: Sequence[tuple[float, float]]) -> list[bool]:
    """Whether no other pair is at most as large in both and smaller in one, per pair."""
    return [not any(_dominates(other, mine) for other in costs) for mine in costs]


def _dominates(other: tuple[float, float], mine: tuple[float, float]) -> bool:
    return other[0] <= mine[0] and other[1] <= mine[1] and other != mine


def with_fronts(points: Sequence[Point]) -> tuple[Point, ...]:
    """The points with the Pareto fronts marked, among those that cast the whole rig."""
    voxel = [p for p in points if p.from_scratch and p.voxel_error is not None]
    score = [p for p in points if p.from_scratch]
    on_voxel = pareto_front([(p.median_ms, p.voxel_error or 0.0) for p in voxel])
    on_score = pareto_front([(p.median_ms, p.score_error) for p in score])
    voxel_front = {id(p) for p, on in zip(voxel, on_voxel, strict=True) if on}
    score_front = {id(p) for p, on in zip(score, on_score, strict=True) if on}
    return tuple(
        replace(p, on_voxel_front=id(p) in voxel_front, on_score_front=id(p) in score_front) for p in points
    )
