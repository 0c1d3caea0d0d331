"""Composition root: opens the window, or does the same job in the terminal where there is no display."""

from __future__ import annotations

import gc
import sys

from app.display import missing_display
from app.leaving import leaving_on_interrupt
from app.options import SceneOptions, ScoreOptions
from app.system_libraries import require_system_libraries
from core.rig.opening import open_rig


def start(rig: str, scene: SceneOptions, score: ScoreOptions) -> int:
    """Open the window on a rig and a scene; returns the exit code."""
    opened = open_rig(rig)
    problem = missing_display()
    if problem is not None:
        print(f"no display: running headless ({problem})", file=sys.stderr)
        from app import headless
        from app.console import note_report

        note_report(opened.report)
        headless.run(opened.rig, scene, score)
        return 0
    require_system_libraries("window")
    gc.disable()  # a window that is being built holds no garbage, and looking for it takes a fifth of the time
    try:
        with leaving_on_interrupt():
            from app.window import open_window

            return open_window(rig, scene, score)
    finally:
        gc.enable()
