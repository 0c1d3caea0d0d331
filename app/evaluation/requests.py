"""What the window asks the background thread, and what comes back: plain data that loads no engine."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from riglens.app.evaluation.heat_modes import HeatMode
from riglens.app.evaluation.options import SceneOptions
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES

if TYPE_CHECKING:  # made by the background thread, which loads what computes them
    from riglens.app.evaluation.heatmap import Heatmaps
    from riglens.app.evaluation.picked import PickedVoxel
    from riglens.core.engine.engine import Evaluation
    from riglens.core.metric.entropy import EntropyField
    from riglens.core.scene.top_view import SeenBy, TopView
    from riglens.core.scene.voxel import Voxel
    from riglens.core.study.voxel_choice import VoxelChoice
    from riglens.widgets.heatmap.scale import HeatmapData

FRAME_MS = 16.0
"""An exact answer that takes longer than a frame of the screen is preceded by a coarse one."""


@dataclass(frozen=True, eq=False)
class LoadedScene:
    """Box data ready for use: the entropy of every informative voxel, and a coarser grid to draw. Equal only to itself.

    `coarse` is a field of larger voxels for first answers, None where the grid allows none; `choice` says how
    the voxel edge was picked, None when it was given.
    """

    options: SceneOptions
    field: EntropyField
    heatmaps: Heatmaps
    coarse: EntropyField | None = None
    choice: VoxelChoice | None = None


@dataclass(frozen=True)
class EvaluationRequest:
    """Everything one evaluation depends on; `baseline_rig` is what the changes are counted from, `voxel` is picked."""

    revision: int
    rig: Rig
    baseline_rig: Rig
    settings: MetricSettings
    heat: HeatMode = "off"
    heat_class: str = CLASSES[0]
    is_preview: bool = False
    map_by: SeenBy | None = None
    voxel: Voxel | None = None

    def asks_same(self, other: EvaluationRequest) -> bool:
        """Whether the answer to both is the same, whatever revision they belong to."""
        return replace(self, revision=other.revision, is_preview=other.is_preview) == other


@dataclass(frozen=True)
class Result:
    """The exact answer to one request: scores now and of the baseline, heatmap and map to draw, the picked voxel."""

    request: EvaluationRequest
    scene: LoadedScene
    evaluation: Evaluation
    baseline_scores: Scores
    heatmap: HeatmapData | None
    top_view: TopView | None = None
    picked: PickedVoxel | None = None


@dataclass(frozen=True)
class Approximation:
    """A first answer to one request, from voxels of `voxel_m`; the exact one follows when nothing newer is asked.

    A type of its own, so that it can never be taken for a Result.
    """

    request: EvaluationRequest
    scores: Scores
    voxel_m: float
    elapsed_ms: float
