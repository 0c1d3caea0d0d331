"""Memory: W+T on a stored POG against a budget per voxel, and 20 sensors on a large region against 12 GB."""

from __future__ import annotations

from pathlib import Path

import psutil
import pytest

from riglens.core.scene.pog_store import save_pog
from tests.bench.bars import Bar
from tests.bench.peak import MEGABYTE, run_script
from tests.bench.scenes import Scenes

BYTES_PER_INFORMATIVE_VOXEL, BYTES_PER_ROI_VOXEL = 12, 2
GOAL = 1.0
REGION_BUDGET, REGION_NEED = 12e9, 8e9
"""Bytes: what the large region may take, and what must be free to try it."""


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


def test_large_region(bars: list[Bar], is_quick: bool) -> None:
    if psutil.virtual_memory().available < REGION_NEED:
        pytest.skip(f"needs {REGION_NEED / 1e9:g} GB of free memory")
    voxel_m = 0.2 if is_quick else 0.05
    used, informative, voxels = run_script("region_memory", voxel_m)
    work = (
        f"20 sensors, two of them with 128 beams, 200 x 100 x 8 m, δ {voxel_m:g} m, "
        f"{informative / 1e6:.0f} M informative of {voxels / 1e6:.0f} M voxels: "
        f"peak {used / MEGABYTE:.0f} MB, budget {REGION_BUDGET / MEGABYTE:.0f} MB"
    )
    bars.append(Bar("memory", work, None, None, used / REGION_BUDGET, GOAL, "lower"))
