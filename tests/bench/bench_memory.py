"""Memory: W+T and three classes on a stored POG, peak without the interpreter, against a budget per voxel."""

from __future__ import annotations

from pathlib import Path

from riglens.core.scene.pog_store import save_pog
from tests.bench.bars import Bar
from tests.bench.peak import MEGABYTE, run_script
from tests.bench.scenes import Scenes

BYTES_PER_INFORMATIVE_VOXEL, BYTES_PER_ROI_VOXEL = 12, 2
GOAL = 1.0


def test_evaluation(bars: list[Bar], scenes: Scenes, tmp_path: Path) -> None:
    scene = scenes.at(0.05)
    path = tmp_path / "pog.npz"
    save_pog(scene.pog, path)
    [used] = run_script("evaluation_memory", path)
    [traced] = run_script("evaluation_memory", path, "trace")
    informative, roi = scene.field.index.count, scene.field.grid.voxel_count
    budget = BYTES_PER_INFORMATIVE_VOXEL * informative + BYTES_PER_ROI_VOXEL * roi
    work = (
        f"W+T, {scene.edge}, {informative / 1e6:.1f} M informative of {roi / 1e6:.1f} M voxels: "
        f"peak {used / MEGABYTE:.0f} MB (tracemalloc: {traced / MEGABYTE:.0f} MB), "
        f"budget {budget / MEGABYTE:.0f} MB"
    )
    bars.append(Bar("memory", work, None, None, used / budget, GOAL, "lower"))
