"""Search the voxel edge that suits some rigs: scores at each edge of the ladder; the coarsest that agrees is kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from riglens.core.engine.engine import Engine
from riglens.core.geometry import Vec3
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.study.voxel_choice import DEFAULT_TOLERANCE, EdgeScores, VoxelChoice, choose, ladder_grids


def search_edge(
    pog_of: Callable[[VoxelGrid, Progress], Pog],
    rigs: Sequence[tuple[Rig, MetricSettings]],
    roi_m: Vec3,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress | None = None,
) -> tuple[Pog, EntropyField, VoxelChoice]:
    """Return the scene at the edge that suits the rigs; only the finest and the best of those tried are kept.

    pog_of: the POG on a grid, which may call its Progress. InputError when no edge can be used.
    """
    grids, left_out = ladder_grids(roi_m)
    tried: list[EdgeScores] = []
    kept: tuple[Pog, EntropyField] | None = None
    for grid, report in zip(grids, _shared(progress, [grid.voxel_count for grid in grids]), strict=True):
        pog = pog_of(grid, report)
        field = EntropyField.from_pog(pog)
        tried.append(_scores_at(field, rigs, threads, report))
        if choose(tried, tolerance).voxel_m == grid.voxel_m:
            kept = pog, field
    assert kept is not None
    return *kept, choose(tried, tolerance, left_out)


def _shared(progress: Progress | None, work: Sequence[int]) -> Iterator[Progress]:
    """Yield a progress callback for each piece of work; together they cover the whole range from 0 to 1."""

    def report(fraction: float, start: int, piece: int) -> None:
        if progress is not None:
            progress((start + fraction * piece) / sum(work))

    for place, piece in enumerate(work):
        yield partial(report, start=sum(work[:place]), piece=piece)


def _scores_at(
    field: EntropyField, rigs: Sequence[tuple[Rig, MetricSettings]], threads: int | None, report: Progress
) -> EdgeScores:
    """Return the scores of the rigs at one edge; call `report` between chunks of rays, which may raise to cancel."""

    def never() -> bool:
        report(1.0)
        return False

    engine = Engine(field, threads)
    found = [(rig.name, engine.evaluate(rig, settings, cancel=never).scores) for rig, settings in rigs]
    return EdgeScores(field.grid.voxel_m, tuple(found))
