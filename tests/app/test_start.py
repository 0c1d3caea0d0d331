"""What the window loads before its first picture, and what waits until somebody needs it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
FOR_LATER = (
    *("numba", "core.kernels.jit", "scipy", "pyarrow", "pandas", "trimesh", "dask", "rich", "http.client"),
    *("app.scenario", "core.scene.readers", "core.rig.formats.exchange", "core.study.rankings"),
)


def test_what_only_few_commands_need_is_not_loaded_with_the_window() -> None:
    script = (
        "import sys\n"
        "import app.main, app.window, widgets.viewport.viewport\n"
        f"print([name for name in {FOR_LATER} if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=REPOSITORY,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("[]\n", "")
