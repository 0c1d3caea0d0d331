"""From options to the road users on which points and pixels are counted."""

from __future__ import annotations

from dataclasses import replace

from riglens.app.evaluation.options import SceneOptions
from riglens.app.evaluation.scenario import BUNDLED_NAME, source_of
from riglens.core.scene.boxes import Progress
from riglens.core.targets.traffic import Traffic, read_traffic


def load_traffic(options: SceneOptions, within_m: float, progress: Progress | None = None) -> Traffic:
    """All boxes of the data set that was asked for; InputError on bad input."""
    found = read_traffic(source_of(options), within_m, progress)
    name = BUNDLED_NAME if options.boxes is None else str(options.boxes)
    return replace(found, data=replace(found.data, source=name))
