"""Composition root: opens the window, or does the same job in the terminal where there is no display."""

from __future__ import annotations

import sys

from app.display import missing_display
from app.options import SceneOptions, ScoreOptions
from app.system_libraries import require_system_libraries
from core.rig.presets import find_rig


def start(rig: str, scene: SceneOptions, score: ScoreOptions) -> int:
    """Open the window on a rig and a scene; returns the exit code."""
    found, _ = find_rig(rig)
    problem = missing_display()
    if problem is not None:
        print(f"no display: running headless ({problem})", file=sys.stderr)
        from app import headless

        headless.run(found, scene, score)
        return 0
    require_system_libraries("window")
    from app.window import open_window

    return open_window(rig, scene, score)
