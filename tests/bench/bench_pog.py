"""POG: from boxes to probabilities, against numpy box by box; and whether more frames need more memory."""

from __future__ import annotations

import itertools

import numpy as np

from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import build_pog
from tests.bench.bars import Bar
from tests.bench.boxes import CycledBoxes, PickedFrames
from tests.bench.peak import MEGABYTE, run_script
from tests.bench.race import Goal, Race
from tests.bench.yardsticks import NumpyFill

FRAMES, FEW_FRAMES = 38_000, 2_500
SAMPLE_STEP = 25
GOAL = 10.0
MEMORY_GOAL = 1.05
ROUNDS = 7


def _edge_m(is_quick: bool) -> float:
    return 0.20 if is_quick else 0.10


def test_time(race: Race, is_quick: bool) -> None:
    grid = VoxelGrid(_edge_m(is_quick))
    frames = FEW_FRAMES if is_quick else FRAMES
    source, sample = CycledBoxes(frames), PickedFrames(SAMPLE_STEP)
    _require_same_counts(sample, grid)

    def ours(_: int) -> None:
        pog = build_pog(source, grid)
        for cls in range(len(CLASSES)):
            pog.probability(cls)

    work = f"{frames:,} frames, δ {grid.voxel_m:g} m; yardstick: {sample.frames} frames, scaled"
    fill = _new_fill(grid)
    goal = Goal("POG", work, GOAL)
    scale = frames / sample.frames
    race.run(goal, itertools.count(), ours, lambda n: _fill(fill, sample, n), scale=scale, rounds=ROUNDS)


def test_memory(bars: list[Bar], is_quick: bool) -> None:
    edge_m = _edge_m(is_quick)
    few, many = (run_script("pog_memory", frames, edge_m)[0] for frames in (FEW_FRAMES, FRAMES))
    work = (
        f"{FRAMES:,} frames need {many / MEGABYTE:.0f} MB at the peak, {FEW_FRAMES:,} frames "
        f"{few / MEGABYTE:.0f} MB, δ {edge_m:g} m"
    )
    bars.append(Bar("POG memory", work, None, None, many / few, MEMORY_GOAL, "lower"))


def _new_fill(grid: VoxelGrid) -> NumpyFill:
    return NumpyFill(grid.shape, grid.origin_m, grid.voxel_m)


def _fill(fill: NumpyFill, sample: PickedFrames, number: int = 0) -> None:
    """Add all boxes of the sample as frames that were not there before."""
    for b in sample.batches_:
        frames = (b.frame + number * (1 << 20)).tolist()
        for frame, cls, centre, size, rotation in zip(
            frames, b.cls.tolist(), b.centre_m, b.size_m, b.rotation, strict=True
        ):
            fill.fill(frame, cls, centre, size, rotation)


def _require_same_counts(sample: PickedFrames, grid: VoxelGrid) -> None:
    """Fail when numpy and the product do not count the same."""
    pog, fill = build_pog(sample, grid), _new_fill(grid)
    _fill(fill, sample)
    i, j, k = pog.index.ijk().T
    assert np.array_equal(fill.counts[:, i, j, k].T, pog.counts)
    assert fill.counts.sum() == pog.counts.sum(dtype=np.int64)
