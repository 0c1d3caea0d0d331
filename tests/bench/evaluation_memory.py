"""Run as a process of its own: bytes that W+T on a stored POG needs at its peak. POG [trace]

With "trace" the peak is that of tracemalloc, which sees numpy's arrays and nothing of the compiled code.
"""

from __future__ import annotations

import sys
import tracemalloc

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import build_pog
from riglens.core.scene.pog_store import load_pog
from tests.bench.boxes import CycledBoxes
from tests.bench.peak import peak, start_peak
from tests.bench.scenes import THREADS, tilted, wide_trapezoid


def main(path: str, is_traced: bool) -> None:
    """Load all kernels on a small grid, then load and evaluate, and print the peak above what was held."""
    small = Engine(EntropyField.from_pog(build_pog(CycledBoxes(10), VoxelGrid(1.0))), THREADS)
    small.evaluate(wide_trapezoid(tilted))
    small.evaluate(wide_trapezoid())
    del small
    if is_traced:
        tracemalloc.start()
    before = start_peak()
    field = EntropyField.from_pog(load_pog(path))
    Engine(field, THREADS).evaluate(wide_trapezoid())
    print(tracemalloc.get_traced_memory()[1] if is_traced else peak() - before)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] == ["trace"])
