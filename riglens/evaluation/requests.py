"""Define the requests to the background thread, the results and their wording: plain data that loads no engine."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from riglens.core.figures.heatmaps import OFF
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible
from riglens.evaluation.options import SceneOptions, ScoreOptions

if TYPE_CHECKING:  # made by the background thread, which loads what computes them
    from riglens.core.blind.zones import BlindMap
    from riglens.core.engine.engine import Evaluation
    from riglens.core.engine.sight import Sight
    from riglens.core.figures.heatmaps import Heatmaps, Marks
    from riglens.core.metric.entropy import EntropyField
    from riglens.core.metric.voxel import Voxel, VoxelFacts
    from riglens.core.study.voxel_choice import VoxelChoice
    from riglens.core.view.heatmap_data import HeatmapData
    from riglens.core.view.outlook import Gap
    from riglens.core.view.top_view import SeenBy, TopView

FRAME_MS = 16.0
"""An exact answer that takes longer than a frame of the screen is preceded by a coarse one."""


@dataclass(frozen=True, eq=False)
class LoadedScene:
    """Box data ready for use: the entropy of every informative voxel, and a coarser grid for drawing. Equal only to
    itself.

    `coarse` is a field of larger voxels for first answers, None if the grid allows none; `choice` says how
    the voxel edge was picked, None when it was given. `gap` is where the data, which look
    one way only, hold no boxes.
    """

    options: SceneOptions
    field: EntropyField
    heatmaps: Heatmaps
    coarse: EntropyField | None = None
    choice: VoxelChoice | None = None
    gap: Gap | None = None


def fixed_options(scene: LoadedScene) -> SceneOptions:
    """Return a scene's options with the grid that is shown: an automatic voxel edge was picked once, and stays."""
    if scene.options.pog is not None:
        return scene.options
    grid = scene.field.grid
    return replace(
        scene.options,
        voxel_m=grid.voxel_m,
        roi_m=grid.roi_m,
        tolerance_pp=None,
        rigs=(),
        score=ScoreOptions(),
    )


@dataclass(frozen=True)
class EvaluationRequest:
    """Everything one evaluation depends on; `baseline_rig` is what the changes are counted from, `voxel` is picked;
    `heat`: key of a heatmap of voxels, or OFF; `map_by`: key of the set of voxels on the map; `blind`: blind zones
    around the car are wanted, too. Equal requests have the same answer."""

    revision: int = field(compare=False)
    rig: Rig
    baseline_rig: Rig
    settings: MetricSettings
    heat: str = OFF
    heat_class: str = CLASSES[0]
    is_preview: bool = field(default=False, compare=False)
    map_by: SeenBy | None = None
    voxel: Voxel | None = None
    blind: bool = False


@dataclass(frozen=True)
class PickedVoxel:
    """A voxel and how each sensor covers it; no sensor counts where the voxel is not informative."""

    facts: VoxelFacts
    sights: tuple[Sight, ...]

    @property
    def seen_by(self) -> tuple[str, ...]:
        """Names of the sensors that see it."""
        return tuple(found.sensor for found in self.sights if found.verdict == "sees")


@dataclass(frozen=True)
class Result:
    """The exact answer to one request: scores now and of the baseline, heatmap and map to draw, the picked voxel.

    `marks` are the voxels that the heatmap was made of; `blind` is from what height on the rig sees objects around
    the car.
    """

    request: EvaluationRequest
    scene: LoadedScene
    evaluation: Evaluation
    baseline_scores: Scores
    heatmap: HeatmapData | None
    top_view: TopView | None = None
    picked: PickedVoxel | None = None
    marks: Marks | None = None
    blind: BlindMap | None = None


@dataclass(frozen=True)
class Approximation:
    """First answer to one request, from voxels of `voxel_m`; the exact one follows unless a newer request arrives.

    A type of its own, so that it can never be taken for a Result. is_measured: whether the exact one is expected to be
    slow by times of the very sensors that have to be cast.
    """

    request: EvaluationRequest
    scores: Scores
    voxel_m: float
    elapsed_ms: float
    is_measured: bool


BEHIND_BODY = "behind the own car's body"


def sight_text(found: Sight) -> str:
    """Describe a sensor's view of a voxel in a few words."""
    if found.verdict == "outside" and found.miss_deg is not None:
        place = {"above": "above", "below": "below"}.get(found.side, "outside")
        return f"{place} field of view by {found.miss_deg:.1f}°"
    if found.verdict == "between" and found.miss_m is not None:
        return f"between rays, missed by {length_text(found.miss_m)}"
    texts = {"sees": "sees it", "off": "disabled", "range": "out of range", "body": BEHIND_BODY}
    texts["blocked"] = "in a blocked sector"
    return texts.get(found.verdict, "not seen")


def failed_text(names: Collection[str]) -> str:
    """Name the sensors that are taken as failed, empty for none."""
    if not names:
        return ""
    return f"{len(names)} sensor{'s' * (len(names) > 1)} failed: {visible(', '.join(sorted(names)))}"


def length_text(length_m: float) -> str:
    """Format a short length in millimetres, centimetres or metres."""
    if length_m < 0.01:
        return f"{1e3 * length_m:.1f} mm"
    return f"{100 * length_m:.1f} cm" if length_m < 1.0 else f"{length_m:.2f} m"
