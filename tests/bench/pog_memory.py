"""Run as a process of its own: bytes that building a POG needs at its peak. FRAMES VOXEL_M"""

from __future__ import annotations

import sys

from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import build_pog
from tests.bench.boxes import CycledBoxes
from tests.bench.peak import peak, start_peak


def main(frames: int, voxel_m: float) -> None:
    """Load the kernels with a small grid, then build and print the peak above what was held before."""
    build_pog(CycledBoxes(10), VoxelGrid(1.0))
    source = CycledBoxes(frames)
    before = start_peak()
    build_pog(source, VoxelGrid(voxel_m))
    print(peak() - before)


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]))
