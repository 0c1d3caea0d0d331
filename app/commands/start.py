"""Composition root: opens the window, or does the same job in the terminal where there is no display."""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from riglens.app.launch.interrupt import leaving_on_interrupt
from riglens.core.errors import InputError
from riglens.core.files import require_writable, write_file
from riglens.evaluation.options import DEFAULT_RIG, PAPER_RIG, CountOptions, SceneOptions, ScoreOptions
from riglens.rendering.display import missing_display, prepare_drawing
from riglens.rendering.system_libraries import require_system_libraries

if TYPE_CHECKING:
    from riglens.core.rig.model import Rig

OUT = Path("out")
"""Default output folder of a run without a window."""


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

    opened = open_rig(rig)  # a faulty rig is refused before anything large is loaded
    require_system_libraries("window")
    with leaving_on_interrupt():
        load_packages()
        from riglens.app.window.start import open_window

        return open_window(opened, scene, score)


def load_packages() -> None:
    """Load the drawing packages before Qt, whose bindings read the source of every module imported after them."""
    from riglens.widgets.drawing.packages import load_pyvista

    load_pyvista()


def _without_window(rig: str, scene: SceneOptions, score: ScoreOptions, problem: str) -> int:
    from riglens.core.formats.opening import open_rig
    from riglens.core.rig.presets import preset

    opened = open_rig(rig)
    print(f"no display: running headless ({problem})", file=sys.stderr)
    from riglens.app.terminal.console import TERMINAL, note
    from riglens.evaluation.loading import note_doubts, note_report
    from riglens.rendering.render import as_drawn

    note_report(opened.report, TERMINAL)
    note_doubts(opened.rig, TERMINAL)
    beside = (preset(PAPER_RIG),) if rig == DEFAULT_RIG else ()
    prepare_drawing()
    rigs = [as_drawn(one, Path(rig).parent, note) for one in (opened.rig, *beside)]
    _score_and_draw(rigs, scene, score)
    return 0


def _score_and_draw(rigs: Sequence[Rig], scene: SceneOptions, score: ScoreOptions) -> None:
    """Evaluate rigs, print the figures, and write them as JSON, with the first rig as a picture and as YAML."""
    from riglens.app.terminal.console import TERMINAL, results
    from riglens.app.terminal.figures import print_leading
    from riglens.app.terminal.scores import print_scene, print_scores
    from riglens.core.figures.documents import evaluation_document
    from riglens.core.figures.evaluated import EvaluationSettings
    from riglens.core.plain import to_text
    from riglens.core.rig.yaml.file import dumps
    from riglens.evaluation.loading import load_scene, load_traffic
    from riglens.evaluation.scenario import settings_of
    from riglens.jobs.evaluating import evaluated_rigs
    from riglens.rendering.render import RenderRequest, draw_evaluated

    pog, field = load_scene(scene, TERMINAL, rigs, score)
    screenshot, rig_file, scores = OUT / "screenshot.png", OUT / "rig.yaml", OUT / "scores.json"
    _make_folder(OUT)
    for path in (screenshot, rig_file, scores):
        require_writable(path)
    count = CountOptions()
    traffic = load_traffic(scene, count.within_m, TERMINAL) if scene.pog is None else None
    settings = EvaluationSettings(settings_of(score), count.settings(score.body))
    evaluated = evaluated_rigs(
        rigs, field, traffic, settings, count.sample, score.threads, TERMINAL, with_seen=True
    )
    evaluations = [one.voxels for one in evaluated if one.voxels is not None]
    print_scene(field, rigs, score)
    print_leading(evaluated)
    print_scores(evaluations, score)
    write_file(scores, to_text(evaluation_document(field, settings.metric, evaluated)))
    write_file(rig_file, dumps(rigs[0]))
    draw_evaluated(evaluations[0], pog, field, RenderRequest(screenshot), TERMINAL)
    results().print(f"Written: {screenshot}, {rig_file}, {scores}", soft_wrap=True)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: folder cannot be created ({error.strerror})") from error
