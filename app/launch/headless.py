"""What `riglens` does where no window can be opened: the same job in the terminal, and files under out/."""

from __future__ import annotations

from pathlib import Path

from riglens.app.commands.console import results
from riglens.app.commands.jobs import load_with_progress, print_scores, score_rigs
from riglens.app.evaluation.heatmap import marks_of
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import settings_of
from riglens.app.launch.display import prepare_drawing
from riglens.app.rendering.render import Picture, draw
from riglens.core.engine import evaluation_json
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, require_writable
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import dumps

OUT = Path("out")


def run(rig: Rig, scene: SceneOptions, score: ScoreOptions) -> None:
    """Score a rig, print the scores, and write a screenshot, the rig as YAML and the scores as JSON."""
    prepare_drawing()
    pog, field = load_with_progress(scene.for_rigs([rig], score))
    screenshot, rig_file, scores = OUT / "screenshot.png", OUT / "rig.yaml", OUT / "scores.json"
    _make_folder(OUT)
    for path in (screenshot, rig_file, scores):
        require_writable(path)
    evaluations = score_rigs([rig], field, score, with_seen=True)
    print_scores(evaluations, field, score)
    document = evaluation_json.evaluation_document(field, settings_of(score), evaluations)
    with atomic_write(scores, "w") as stream:
        stream.write(evaluation_json.to_text(document))
    with atomic_write(rig_file, "w") as stream:
        stream.write(dumps(rig))
    draw(pog, field, evaluations[0], marks_of(evaluations[0]), Picture(screenshot))
    results().print(f"Written: {screenshot}, {rig_file}, {scores}", soft_wrap=True)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder ({error.strerror})") from error
