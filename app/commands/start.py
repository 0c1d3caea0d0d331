"""Composition root: opens the window, or does the same job in the terminal where there is no display."""

from __future__ import annotations

import gc
import sys

from riglens.app.launch.interrupt import leaving_on_interrupt
from riglens.evaluation.options import DEFAULT_RIG, PAPER_RIG, SceneOptions, ScoreOptions
from riglens.rendering.display import missing_display
from riglens.rendering.system_libraries import require_system_libraries


def start(rig: str, scene: SceneOptions, score: ScoreOptions) -> int:
    """Open the window on a rig and a scene; returns the exit code."""
    problem = missing_display()
    if problem is not None:
        return _without_window(rig, scene, score, problem)
    gc.disable()  # a window that is being built holds no garbage, and looking for it takes a fifth of the time
    try:
        return _with_window(rig, scene, score)
    finally:
        gc.enable()


def _with_window(rig: str, scene: SceneOptions, score: ScoreOptions) -> int:
    from riglens.core.formats.opening import open_rig

    open_rig(rig)  # a wrong rig is told before anything large is loaded
    require_system_libraries("window")
    with leaving_on_interrupt():
        load_packages()
        from riglens.app.window.start import open_window

        return open_window(rig, scene, score)


def load_packages() -> None:
    """Load the drawing packages before Qt, whose bindings read the source of every module imported after them."""
    from riglens.widgets.drawing.packages import load_pyvista

    load_pyvista()


def _without_window(rig: str, scene: SceneOptions, score: ScoreOptions, problem: str) -> int:
    from pathlib import Path

    from riglens.core.formats.opening import open_rig
    from riglens.core.rig.presets import preset

    opened = open_rig(rig)
    print(f"no display: running headless ({problem})", file=sys.stderr)
    from riglens.app.terminal.console import note_report
    from riglens.rendering.render import score_without_window

    note_report(opened.report)
    beside = (preset(PAPER_RIG),) if rig == DEFAULT_RIG else ()
    score_without_window((opened.rig, *beside), Path(rig).parent, scene, score)
    return 0
