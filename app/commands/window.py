"""`riglens [RIG]`: the window."""

from __future__ import annotations

from riglens.app.commands.options import Libraries, Rig, Scene, Score
from riglens.app.evaluation.options import DEFAULT_RIG


def window(
    rig: Rig = DEFAULT_RIG,
    /,
    *,
    scene: Scene = Scene(),
    score: Score = Score(),
    libraries: Libraries = Libraries(),
) -> int:
    """Open the window on RIG (W+T). Without a display: the scores, and a picture, YAML and JSON in out/."""
    libraries.use()
    options, metric = scene.options(), score.options()
    from riglens.app.launch.main import start

    return start(rig, options, metric)
