"""Start: `riglens` until the first picture, against importing its large packages; warm caches."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys

import pytest

from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog_store import cached_pog
from riglens.core.scene.readers.bundled import bundled_source
from tests.bench.race import Goal, Race

GOAL = 1.5
ROUNDS = 7
QT = "PySide6.QtCore, PySide6.QtGui, PySide6.QtWidgets"
IMPORTS = {
    "PySide6, pyvista, numba": f"{QT}, pyvista, numba",
    "PySide6, pyvista.plotting, pyvistaqt, numba": f"{QT}, pyvista.plotting, pyvistaqt, numba",
}


@pytest.mark.parametrize("yardstick", IMPORTS)
def test_first_picture(race: Race, xvfb: str, yardstick: str) -> None:
    cached_pog(bundled_source(), VoxelGrid())  # as after any earlier start
    imports = f"import os, {IMPORTS[yardstick]}; os._exit(0)"
    goal = Goal("start", f"`riglens` to the first picture; yardstick: importing {yardstick}", GOAL, "lower")
    race.run(
        goal,
        itertools.count(),
        lambda _: _python("-m", "tests.bench.first_picture"),
        lambda _: _python("-c", imports),
        rounds=ROUNDS,
    )


def _python(*arguments: str) -> None:
    """Run Python; it may keep the bytecode of what it imports, as any installation does."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, encoding="utf-8", timeout=120
    )
    assert done.returncode == 0, done.stderr
