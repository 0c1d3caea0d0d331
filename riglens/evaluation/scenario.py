"""From options to the scene that is scored: the one place that turns box data or a POG file into a field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.scene.boxes import DataReport, Progress
from riglens.core.scene.grid import DEFAULT_ROI_M, DEFAULT_VOXEL_M, VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.scene.pog_store import cached_pog, load_pog
from riglens.core.scene.readers import Source, bundled_source, open_boxes, parse_class_map
from riglens.core.scene.statistics import NEAR_M
from riglens.core.scene.survey import FEWEST_BOXES, LARGEST_SPREAD_M, Advice, doubtful, survey
from riglens.core.study.edge_search import search_edge
from riglens.core.study.voxel_choice import VoxelChoice
from riglens.evaluation.known_body import with_known_body
from riglens.evaluation.options import DEFAULT_TOLERANCE_PP, READING, SceneOptions, ScoreOptions

SHOWN_UNMAPPED = 5


@dataclass(frozen=True)
class Scenario:
    """A scene to score on; `choice` says how its voxel edge was picked, None when it was specified."""

    pog: Pog
    field: EntropyField
    choice: VoxelChoice | None = None


def settings_of(options: ScoreOptions) -> MetricSettings:
    """Return the metric's settings; where no body is given, each rig sets it."""
    return MetricSettings(options.method, options.reading, options.camera_weight, options.body)


def grid_of(options: SceneOptions) -> VoxelGrid:
    """Return the requested grid; InputError unless it has a whole number of voxels."""
    if options.voxel_m == "auto":
        raise InputError("must be an edge in metres here (got auto, which depends on rigs)", "voxel_m")
    voxel_m = DEFAULT_VOXEL_M if options.voxel_m is None else options.voxel_m
    return VoxelGrid(voxel_m, DEFAULT_ROI_M if options.roi_m is None else options.roi_m)


def source_of(options: SceneOptions) -> Source:
    """Return the requested box data set; by default the bundled scenario."""
    if options.boxes is None:
        for name in _said_of_boxes(options):
            raise InputError("describes a box data set; specify it with", name, "boxes")
        return bundled_source()
    return boxes_of(options, [options.boxes])


def _said_of_boxes(options: SceneOptions) -> list[str]:
    """Return the options given that name or describe a box data set."""
    return [name for name in ("boxes", *READING) if getattr(options, name) not in (None, (), False)]


def boxes_of(options: SceneOptions, paths: Sequence[Path]) -> Source:
    """Return the box data at some paths as one data set, read as the options say.

    With `find_ground` they are read once more before, which may end in an InputError about the ground.
    """
    open_as_said = partial(
        open_boxes, paths, options.origin_m, options.frames, parse_class_map(options.classes)
    )
    if not options.find_ground:
        return open_as_said()
    ground = survey(open_as_said()).ground
    if ground is None or not ground.is_certain:
        found = ground.text() if ground else f"no boxes within {NEAR_M:g} m"
        raise InputError(
            f"needs {FEWEST_BOXES} boxes or more of which half agree to {LARGEST_SPREAD_M:g} m (got {found}); else "
            "set the ground with",
            "find_ground",
            "origin_m",
        )
    return open_as_said(lift_m=ground.lift_m, notes=(f"ground: {ground.text()}; moved to z = 0",))


def load_scenario(options: SceneOptions, progress: Progress | None = None) -> Scenario:
    """Return the scene for these options; raise InputError on bad input or conflicting options.

    POGs of box data are kept in the user's cache folder; `progress` gets the fraction done, 0 to 1.
    """
    if options.pog is not None:
        pog = _stored_pog(options, options.pog)
    elif options.voxel_m == "auto" and options.rigs:
        return _auto_scenario(options, progress)
    else:
        pog = cached_pog(source_of(options), grid_of(options), progress)
    return Scenario(pog, EntropyField.from_pog(pog))


def _auto_scenario(options: SceneOptions, progress: Progress | None) -> Scenario:
    """Return the scene at the edge that suits the rigs; only the finest and the best of those tried are kept."""
    source, settings = source_of(options), settings_of(options.score)
    tolerance = (DEFAULT_TOLERANCE_PP if options.tolerance_pp is None else options.tolerance_pp) / 100
    rigs = [rig.with_body_mesh(None) for rig in options.rigs]  # a mesh is not read for this
    scored = [(rig, with_known_body(settings, rig)) for rig in rigs]
    roi_m = DEFAULT_ROI_M if options.roi_m is None else options.roi_m
    return Scenario(
        *search_edge(partial(cached_pog, source), scored, roi_m, tolerance, options.score.threads, progress)
    )


def _stored_pog(options: SceneOptions, path: Path) -> Pog:
    """Return the POG of a file; reject it when the other options contradict its content."""
    for name in _said_of_boxes(options):
        raise InputError("cannot be combined with", name, "pog")
    pog = load_pog(path)
    if options.voxel_m == "auto":
        raise InputError(f"must not be auto: {path} holds one grid, of {pog.grid.voxel_m:g} m", "voxel_m")
    if options.voxel_m is not None and options.voxel_m != pog.grid.voxel_m:
        raise InputError(
            f"must be {pog.grid.voxel_m:g}, with which {path} was built (got {options.voxel_m:g})", "voxel_m"
        )
    if options.roi_m is not None and options.roi_m != pog.grid.roi_m:
        found, held = (" ".join(f"{side:g}" for side in roi) for roi in (options.roi_m, pog.grid.roi_m))
        raise InputError(f"must be {held}, with which {path} was built (got {found})", "roi_m")
    return pog


def left_out(data: DataReport, advice: Advice) -> list[str]:
    """Describe what is implausible about the data, how they were read, and which boxes do not count."""
    lines = [*doubtful(data, advice), *data.notes]
    if data.unmapped:
        most = data.unmapped.most_common(SHOWN_UNMAPPED)
        names = ", ".join(f"{name} {number:,}" for name, number in most)
        more = f" and {len(data.unmapped) - len(most)} more classes" if len(data.unmapped) > len(most) else ""
        count = sum(data.unmapped.values())
        ending = "box belongs to no class and does" if count == 1 else "boxes belong to no class and do"
        lines.append(f"{count:,} {ending} not count: {names}{more}")
    return lines


def remarks_on(data: DataReport, advice: Advice) -> list[str]:
    """Return remarks on the data: what is implausible, boxes that do not count, classes without any box."""
    lines = left_out(data, advice)
    if data.frames == 1:
        lines.append(
            "one frame only: each voxel is certainly free or certainly occupied, without entropy; all scores are 0"
        )
    empty = [name for name, count in data.boxes.items() if count == 0]
    if empty:
        lines.append(f"no boxes of class {', '.join(empty)}: its scores are 0")
    return lines
