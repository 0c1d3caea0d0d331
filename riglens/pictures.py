"""Pictures of rigs and scenes: PNG files, what notebooks show, and a view to turn."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from riglens.arguments import ClassName, StrPath, warn
from riglens.core.figures.text import in_sentence, value_text
from riglens.core.files import write_file
from riglens.core.metric.scores import Body
from riglens.core.optimise.results import OptimiseResult
from riglens.core.rig.model import Rig
from riglens.evaluation.scenario import settings_of
from riglens.results import RigResult, Rows, html_table
from riglens.scenes import Scene
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, Fill, RayLook

if TYPE_CHECKING:
    from riglens.core.targets.traffic import Traffic
    from riglens.rendering.render import Theme, View
    from riglens.widgets.viewport.scene_state import SceneState

SIZE_PX = (960, 600)
"""Of pictures in notebooks."""


def render(
    rig: Rig,
    scene: Scene,
    out: StrPath,
    *,
    view: View = "iso",
    size_px: tuple[int, int] = (1280, 800),
    scale: int = 1,
    class_name: ClassName = "car",
    heatmap: str = "unseen",
    baseline: Rig | None = None,
    traffic: Traffic | None = None,
    theme: Theme = "dark",
    transparent: bool = False,
    title: bool = False,
    scores: bool = False,
    slice_m: tuple[float, float] | None = None,
    threshold: float | None = None,
    log: bool = False,
    opacity: float | None = None,
    rays: bool = True,
    ray_opacity: float = DEFAULT_RAYS.opacity,
    ray_density: float = DEFAULT_RAYS.density,
    fill: Fill = DEFAULT_RAYS.fill,
    px_per_m: Sequence[float] = DEFAULT_RAYS.px_per_m,
    all_rays: bool = False,
    plain_traffic: bool = False,
    draped: bool | None = None,
    select: str | None = None,
    ground: bool = True,
    legend: bool = True,
    mesh_folder: StrPath = ".",
    body: Body | None = None,
) -> None:
    """Draw a rig, its rays and the heatmap of a class into a PNG file; it takes no display.

    Raises InputError when a value is not accepted or the file cannot be written.

    Parameters
    ----------
    out
        The picture (.png).
    view
        Where to look from: "iso", "top", "front", "left" or "rear".
    size_px, scale
        Width and height in pixels, and how many times as many pixels to draw along each side.
    class_name, heatmap
        What the heatmap shows: the key of a heatmap (docs/heatmap.md), or "off".
    baseline, traffic
        The rig that a heatmap of changes starts from, and the objects that a heatmap of objects counts and
        `plain_traffic` draws.
    theme, transparent
        "dark" or "light"; no background at all.
    title, scores
        Write the rig's name, and the table of its scores, into the picture.
    slice_m, threshold, log, opacity
        Cells of the heatmap: between two heights; above a share of the colour scale (0.02); on a logarithmic scale;
        opacity of the highest values (0.5).
    rays, ray_opacity, ray_density, fill, px_per_m
        Draw the rays, how strongly, and how many of them (0.125 to 8 times); fields of view: footprints on the
        "ground", "frusta" or "none"; limits of the bands in footprints of cameras, falling.
    all_rays, select
        Draw the rays of every sensor; the name of the sensor that is shown as selected, with its rays.
    plain_traffic
        Draw the objects of a typical frame of `traffic` as plain bodies.
    draped
        Draw the heatmap on the ground, all heights together, or as cells in space; None: in space for rigs whose
        body is ignored, as those of the paper.
    ground, legend
        Draw the ground, and the colour bar.
    mesh_folder
        As for `score`; a mesh that cannot be read is warned of, and a plain box is drawn instead.
    """
    from riglens.core.files import require_writable
    from riglens.rendering.display import prepare_drawing
    from riglens.rendering.render import RenderRequest, as_drawn, draw, drawn_score, scored_state

    picture = RenderRequest(
        Path(out), view, size_px, scale, class_name, heatmap, transparent=transparent, title=title,
        scores=scores, theme=theme, baseline=baseline.name if baseline else None, slice_m=slice_m,
        threshold=threshold, log=log, opacity=opacity, ground=ground, legend=legend,
        rays=RayLook(rays, ray_opacity, ray_density, fill, all_rays, all_rays, tuple(px_per_m)), draped=draped,
        selected=select, traffic=plain_traffic,
    )  # fmt: skip
    require_writable(out)
    prepare_drawing()
    rig = as_drawn(rig, Path(mesh_folder), warn)
    settings = settings_of(drawn_score(rig, body))
    draw(scored_state(rig, scene.pog, scene.field, picture, baseline, settings, traffic), picture)


# ---------------------------------------------------------------- notebooks


@dataclass(frozen=True)
class Picture:
    """A picture as a PNG file in memory; notebooks show it."""

    png: bytes

    def save(self, path: StrPath) -> None:
        """Write the PNG file."""
        write_file(path, self.png)

    def _repr_png_(self) -> bytes:
        return self.png


def show(
    rig: Rig,
    scene: Scene | None = None,
    *,
    heatmap: str = "unseen",
    class_name: ClassName = "car",
    traffic: Traffic | None = None,
    view: View = "iso",
    theme: Theme = "light",
    mesh_folder: StrPath = ".",
) -> Any:
    """Show a rig, with a scene also the heatmap of a class.

    In a notebook by pyvista's Jupyter backend, which can be turned where trame is installed; elsewhere in a window;
    without a display it returns a `Picture`.
    """
    from riglens.rendering.display import missing_display, prepare_drawing

    prepare_drawing()
    from riglens.widgets.viewport.still import png_of, render_still, staged

    state = _state(rig, scene, heatmap, class_name, theme, mesh_folder, traffic)
    is_notebook = "ipykernel" in sys.modules
    if missing_display() is not None and not is_notebook:
        return Picture(png_of(render_still(state, SIZE_PX, view=view)))
    plotter = staged(state, SIZE_PX, view=view, off_screen=is_notebook, notebook=is_notebook)
    return plotter.show(return_viewer=is_notebook)


def _state(
    rig: Rig,
    scene: Scene | None,
    heatmap: str,
    class_name: ClassName,
    theme: Theme,
    mesh_folder: StrPath,
    traffic: Traffic | None = None,
) -> SceneState:
    from riglens.rendering.render import RenderRequest, as_drawn, drawn_score, rig_state, scored_state

    rig = as_drawn(rig, Path(mesh_folder), warn)
    if scene is None:
        return rig_state(rig, theme)
    picture = RenderRequest(Path("picture.png"), class_name=class_name, heat=heatmap, theme=theme)
    settings = settings_of(drawn_score(rig, None))
    return scored_state(rig, scene.pog, scene.field, picture, settings=settings, traffic=traffic)


def _png(rig: Rig, scene: Scene | None, heatmap: str) -> bytes | None:
    """Return a picture for a notebook, None if the libraries that draw are missing."""
    from riglens.rendering.display import prepare_drawing
    from riglens.rendering.system_libraries import MissingLibraries

    try:
        prepare_drawing()
    except MissingLibraries:
        return None
    from riglens.widgets.viewport.still import png_of, render_still

    return png_of(render_still(_state(rig, scene, heatmap, "car", "light", "."), SIZE_PX, view="iso"))


@lru_cache(maxsize=8)
def _rig_png(rig: Rig) -> bytes | None:
    return _png(rig, None, "off")


def _rig_html(rig: Rig) -> str:
    rows = [
        {
            "sensor": one.name,
            "kind": one.kind,
            "model": one.model,
            "position_m": ", ".join(f"{value:g}" for value in one.position),
            "rpy_deg": ", ".join(f"{value:g}" for value in one.rpy_deg),
            "rays": one.ray_count,
            "enabled": one.enabled,
        }
        for one in rig.sensors
    ]
    return html_table(f"{rig.name}: {rig.vehicle.body}, {len(rig.sensors)} sensors", rows, _rig_png(rig))


def _scene_png(scene: Scene) -> bytes | None:
    return _drawn_once(scene, Rig(), scene, "entropy")


def _drawn_once(shown: object, rig: Rig, scene: Scene, heatmap: str) -> bytes | None:
    """Return the picture of a scene or a result, kept with it: a notebook asks for it as PNG and within HTML."""
    if "_png" not in vars(shown):
        vars(shown)["_png"] = _png(rig, scene, heatmap)
    found: bytes | None = vars(shown)["_png"]
    return found


def _scene_html(scene: Scene) -> str:
    rows: Rows = [{"class": name, "boxes": count} for name, count in scene.data.boxes.items()]
    return html_table(repr(scene).strip("<>"), rows, _scene_png(scene))


def _result_png(result: RigResult) -> bytes | None:
    return _drawn_once(result, result.rig, Scene(result.pog, result.field), "seen")


def _result_html(result: RigResult) -> str:
    return html_table(repr(result).strip("<>"), result.rows(), _result_png(result))


def _proposals_png(found: OptimiseResult) -> bytes | None:
    return _rig_png(found.best.rig)


def _proposals_html(found: OptimiseResult) -> str:
    rows = [
        {"proposal": one.rig.name, "value": one.value, "cost": one.cost, "verdict": one.verdict}
        for one in found.proposals
    ]
    before = f"{in_sentence(found.problem.goal.title)} {value_text(found.figure, found.before)}"
    title = f"{found.problem.rig.name}: {before}; {found.sentence()}"
    return html_table(title, rows, _proposals_png(found))


for _type, _html, _picture in (
    (Rig, _rig_html, _rig_png),
    (Scene, _scene_html, _scene_png),
    (RigResult, _result_html, _result_png),
    (OptimiseResult, _proposals_html, _proposals_png),
):  # what draws is above them, so they cannot have these methods by themselves
    for _name, _method in (("_repr_html_", _html), ("_repr_png_", _picture)):
        setattr(_type, _name, _method)
