"""Pictures of a rig without a window: the scene of the window, drawn offscreen into a PNG file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.errors import InputError
from riglens.core.figures.heatmaps import (
    OFF,
    UNSEEN_ENTROPY,
    HeatMap,
    Heatmaps,
    Marks,
    ObjectHeatMap,
    VoxelHeatMap,
)
from riglens.core.figures.registry import heat_map_named, heat_maps, voxel_heat_maps
from riglens.core.figures.text import in_sentence
from riglens.core.files import is_stream
from riglens.core.footprint.ground import checked_limits
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, Body, MetricSettings
from riglens.core.monitor import SILENT, Monitor
from riglens.core.option_help import OptionHelp
from riglens.core.rig.model import Rig
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.scene.readers.bundled import streets_around
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.ground import ground_view
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh_file import with_mesh_read
from riglens.core.vehicle.standing import mount_statuses
from riglens.core.view.display import DisplayGrid
from riglens.core.view.heatmap_data import HeatmapData
from riglens.evaluation.options import (
    MAX_SCALE,
    MAX_SIDE_PX,
    MIN_SIDE_PX,
    ScoreOptions,
)
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, LEAST_DENSITY, MOST_DENSITY, RayLook

if TYPE_CHECKING:  # what draws is loaded with the first picture
    from riglens.widgets.viewport.masts import Mast
    from riglens.widgets.viewport.scene_state import SceneState

STAND_IN = "a plain box of the vehicle's size replaces it"
View = Literal["iso", "top", "front", "left", "rear"]
Theme = Literal["dark", "light"]
ClassName = Literal["car", "bicycle", "pedestrian"]
_HEATMAP = (
    "Content of the heatmap: "
    + ", ".join(f"{heat.key} ({in_sentence(heat.title)})" for heat in heat_maps())
    + f", or {OFF}."
)


@dataclass(frozen=True)
class RenderRequest:
    """Request for pictures and their paths: the one form of these options, of the command and of Python.

    `threshold`, `log`, `opacity` and `slice_m` are those of HeatLook; `draped`: None for cells in space for
    rigs whose body is ignored, as the paper's. The rays have options of their own.
    """

    out: Path
    view: Annotated[View, OptionHelp("NAME", "Viewing direction.")] = "iso"
    size_px: Annotated[tuple[int, int], OptionHelp("WxH", "Size of the picture in pixels.")] = (1280, 800)
    scale: Annotated[
        int, OptionHelp("K", "Factor by which the picture is enlarged, with its lines and text.")
    ] = 1
    class_name: Annotated[ClassName, OptionHelp("NAME", "Class of the heatmap.")] = "car"
    heat: Annotated[str, OptionHelp("NAME", _HEATMAP, "heatmap")] = UNSEEN_ENTROPY.key
    baseline: Annotated[str | None, OptionHelp("RIG", "Reference rig of a heatmap of changes.")] = None
    slice_m: Annotated[
        tuple[float, float] | None,
        OptionHelp("FROM TO", "Draw only cells of the heatmap between two heights, metres."),
    ] = None
    threshold: Annotated[
        float | None,
        OptionHelp("SHARE", "Leave out cells in the lowest part of the colour scale, 0 to 1 (0.02)."),
    ] = None
    log: Annotated[bool, OptionHelp("", "Use a logarithmic colour scale of three decades.")] = False
    opacity: Annotated[float | None, OptionHelp("SHARE", "Opacity of the highest values, 0 to 1 (0.5).")] = (
        None
    )
    draped: Annotated[
        bool | None,
        OptionHelp(
            "",
            "Draw the heatmap on the ground, all heights together, or as cells in space; the latter for rigs of "
            "the paper.",
            negative="voxels",
        ),
    ] = None
    selected: Annotated[
        str | None,
        OptionHelp("SENSOR", "Show this sensor as selected, with its rays and labels.", "select"),
    ] = None
    traffic: Annotated[
        bool,
        OptionHelp("", "Draw the objects of a typical frame as plain bodies.", "plain-traffic"),
    ] = False
    transparent: Annotated[bool, OptionHelp("", "Leave background and ground transparent.")] = False
    ground: Annotated[
        bool,
        OptionHelp("", "Draw the ground with its grid and metres.", "ground-plane", "no-ground"),
    ] = True
    legend: Annotated[bool, OptionHelp("", "Draw the colour bar.", negative="no-legend")] = True
    title: Annotated[
        bool, OptionHelp("", "Write the name of the rig and its inputs in the upper corner.")
    ] = False
    scores: Annotated[bool, OptionHelp("", "Write the table of scores in the lower corner.")] = False
    theme: Annotated[Theme, OptionHelp("NAME", "Dark or light background.")] = "dark"
    rays: RayLook = DEFAULT_RAYS

    def __post_init__(self) -> None:
        if self.out.suffix.lower() != ".png" and not is_stream(self.out):
            raise InputError(f"must end in .png (got {self.out})", "out")
        if not 1 <= self.scale <= MAX_SCALE:
            raise InputError(f"must be an integer from 1 to {MAX_SCALE} (got {self.scale})", "scale")
        if not all(MIN_SIDE_PX <= side * self.scale <= MAX_SIDE_PX for side in self.size_px):
            width, height = self.size_px
            raise InputError(
                f"must have sides of {MIN_SIDE_PX} to {MAX_SIDE_PX} pixels, scale included "
                f"(got {width}x{height} at scale {self.scale})",
                "size_px",
            )
        self._check_heatmap()
        self._check_rays()

    def _check_heatmap(self) -> None:
        for name, share in (("threshold", self.threshold), ("opacity", self.opacity)):
            if share is not None and not 0.0 <= share <= 1.0:
                raise InputError(f"must be between 0 and 1 (got {share:g})", name)
        if self.slice_m is not None and not -math.inf < self.slice_m[0] < self.slice_m[1] < math.inf:
            low, high = self.slice_m
            raise InputError(
                f"must be two heights in metres, FROM below TO (got {low:g} {high:g})", "slice_m"
            )
        if self.heat_map is None and self.heat != OFF:
            known = ", ".join((*(one.key for one in heat_maps()), OFF))
            raise InputError(f"must be one of {known} (got {self.heat})", "heatmap")
        compares = isinstance(self.heat_map, VoxelHeatMap) and self.heat_map.is_against_baseline
        if compares and self.baseline is None:
            raise InputError(f"{self.heat} needs", "heatmap", "baseline")
        if not compares and self.baseline is not None:
            fitting = " or ".join(one.key for one in voxel_heat_maps() if one.is_against_baseline)
            raise InputError(f"is the reference of changes: needs {fitting} as", "baseline", "heatmap")

    @property
    def heat_map(self) -> HeatMap | None:
        """Return the heatmap, None for none."""
        return heat_map_named(self.heat)

    def _check_rays(self) -> None:
        if not 0.0 <= self.rays.opacity <= 1.0:
            raise InputError(f"must be between 0 and 1 (got {self.rays.opacity:g})", "ray_opacity")
        if not LEAST_DENSITY <= self.rays.density <= MOST_DENSITY:
            raise InputError(
                f"must be between {LEAST_DENSITY:g} and {MOST_DENSITY:g} (got {self.rays.density:g})",
                "ray_density",
            )
        checked_limits(self.rays.px_per_m)


def scored_state(
    rig: Rig,
    pog: Pog,
    field: EntropyField,
    picture: RenderRequest,
    baseline: Rig | None = None,
    settings: MetricSettings = PAPER_SETTINGS,
    traffic: Traffic | None = None,
    monitor: Monitor = SILENT,
) -> SceneState:
    """Evaluate a rig, and the baseline of a heatmap of changes, and return what `draw` draws; call `prepare_drawing`
    before. InputError for a heatmap or bodies of objects without traffic."""
    if picture.traffic and traffic is None:
        raise InputError("needs", "plain_traffic", "traffic")
    with monitor.stage("Casting rays"):
        engine = Engine(field)
        evaluation = engine.evaluate(rig, settings)
        heat, cells = picture.heat_map, None
        if isinstance(heat, VoxelHeatMap):
            marks = Marks(heat.sets(engine, evaluation))
            if baseline is not None:
                if baseline.vehicle.body == rig.vehicle.body:
                    baseline = baseline.with_body_mesh(rig.vehicle.body_mesh)
                before = engine.evaluate(baseline, settings)
                marks = replace(marks, baseline=heat.sets(engine, before), baseline_name=before.rig.name)
            cells = Heatmaps(DisplayGrid.build(pog, field)).drawn(heat, picture.class_name, marks)
        elif isinstance(heat, ObjectHeatMap):
            if traffic is None:
                raise InputError(f"{heat.key} needs", "heatmap", "traffic")
            how = TargetSettings(body=settings.body)
            counted = TargetEngine(traffic).evaluate(rig, how, with_losses=heat.with_losses)
            cells = heat.data(heat.over(ground_view(counted, picture.class_name)))
    state = _state(field, evaluation, cells, picture)
    if not picture.traffic or traffic is None:
        return state
    from riglens.widgets.traffic.frame import plain_frame

    shown = plain_frame(traffic)
    return replace(state, traffic=shown, streets=streets_around(traffic.data, shown.frame))


def draw_evaluated(
    evaluation: Evaluation, pog: Pog, field: EntropyField, picture: RenderRequest, monitor: Monitor
) -> None:
    """Draw a rig that has been evaluated with the voxels that it sees; call `prepare_drawing` before."""
    marks = Marks(evaluation.seen_by_any())
    cells = Heatmaps(DisplayGrid.build(pog, field)).drawn(UNSEEN_ENTROPY, picture.class_name, marks)
    draw(_state(field, evaluation, cells, picture), picture, monitor)


def drawn_score(rig: Rig, body: Body | None) -> ScoreOptions:
    """Return the score options of a picture: where a box replaces the car, it is ignored unless set to block."""
    return ScoreOptions(body="ignored" if rig.vehicle.lacks_mesh and body is None else body)


def as_drawn(rig: Rig, folder: Path, tell: Callable[[str], object]) -> Rig:
    """Return a rig of this folder with the mesh of its body, without it where a box has to stand in for the car.

    Problems with the file, or with the size of the car in it, are reported in a line each.
    """
    try:
        return with_mesh_read(rig, folder, tell)
    except InputError as error:
        tell(f"{error}; {STAND_IN}")
        return rig


def rig_state(rig: Rig, theme: Theme) -> SceneState:
    """Return what is drawn of a rig without a scene: its surroundings of a few metres."""
    from riglens.widgets.heatmap.scale import USUAL_LOOK
    from riglens.widgets.theme import palette
    from riglens.widgets.viewport.scene_state import SceneState

    vehicle, top_m = rig.vehicle, max([rig.vehicle.height, *(sensor.position[2] for sensor in rig.sensors)])
    near_m = (
        2.0 * math.ceil(vehicle.length / 2 + 4),
        2.0 * math.ceil(vehicle.width / 2 + 3),
        math.ceil(top_m) + 1.0,
    )
    return SceneState(
        vehicle=vehicle, rig=rig, masts=_masts(rig), grid=VoxelGrid(1.0, near_m),
        solid_body=None if vehicle.lacks_mesh or rig.body == "ignored" else vehicle,
        palette=palette(theme == "dark"), show_gizmo=False, show_selection=False, heat_look=USUAL_LOOK,
    )  # fmt: skip


def _state(
    field: EntropyField, evaluation: Evaluation, cells: HeatmapData | None, picture: RenderRequest
) -> SceneState:
    """Return what is drawn of an evaluated rig: its rays and the heatmap."""
    from riglens.rendering.picture import Findings, PictureWords, with_words
    from riglens.widgets.heatmap.scale import DEFAULT_LOOK, HeatLook

    rig = evaluation.rig
    look = HeatLook(
        DEFAULT_LOOK.threshold if picture.threshold is None else picture.threshold,
        picture.log,
        DEFAULT_LOOK.opacity if picture.opacity is None else picture.opacity,
        picture.slice_m,
        rig.self_occlusion if picture.draped is None else picture.draped,
    )
    state = replace(
        rig_state(rig, picture.theme),
        solid_body=rig.vehicle if evaluation.settings.body == "blocks" else None,
        grid=field.grid, heatmap=cells, heat_look=look, ray_look=picture.rays,
        show_ground=picture.ground, selected=picture.selected,
    )  # fmt: skip
    words = PictureWords(picture.legend, picture.title, picture.scores)
    made = with_words(state, words, Findings(rig, evaluation.scores, evaluation.settings, field))
    return replace(made, show_selection=picture.selected is not None)


def draw(state: SceneState, picture: RenderRequest, monitor: Monitor = SILENT) -> None:
    """Draw a state into the file of a picture; InputError if it cannot be written."""
    from riglens.widgets.viewport.still import render_still

    with monitor.stage("Drawing"):
        render_still(
            state, picture.size_px, picture.scale, picture.out, picture.transparent, view=picture.view
        )


def _masts(rig: Rig) -> tuple[Mast, ...]:
    """Return the masts of sensors that are not on the car's surface; none if a box replaces the car."""
    from riglens.widgets.viewport.masts import masts_of

    return () if rig.vehicle.lacks_mesh else masts_of(mount_statuses(rig))
