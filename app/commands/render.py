"""`riglens render`: a picture of a rig."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import (
    BodyArguments,
    RigArguments,
    RigName,
    SceneArguments,
    command,
    taken,
)
from riglens.app.terminal.console import TERMINAL, note, results
from riglens.core.errors import InputError
from riglens.core.files import require_writable
from riglens.core.rig.library import use_libraries
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.loading import load_rig, load_scene, load_traffic, with_choice
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import settings_of
from riglens.rendering.display import prepare_drawing
from riglens.rendering.picture_set import require_folder, write_set
from riglens.rendering.render import RenderRequest, as_drawn, draw, drawn_score, scored_state
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, RayLook

USUAL = RenderRequest(Path("picture.png"))
PictureArguments = Annotated[
    RenderRequest,
    taken(None, *(one.name for one in fields(RenderRequest) if one.name not in ("out", "rays"))),
]
RayArguments = Annotated[RayLook, taken(None, "shown", "of_all", "opacity", "density", "fill", "px_per_m")]


@command
def render(
    rig: RigName,
    /,
    *,
    out: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    set_folder: Annotated[Path | None, Parameter(name="--set", metavar="DIR")] = None,
    look: PictureArguments = USUAL,
    rays: RayArguments = DEFAULT_RAYS,
    scene: SceneArguments = SceneOptions(),
    score: BodyArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
) -> None:
    """Draw a rig, its rays and the heatmap of a class into a PNG file, without a display.

    Parameters
    ----------
    out
        The picture (.png).
    set_folder
        Write a set of pictures for a report into a folder instead, as PNG and SVG with their captions.
    """
    use_libraries(reading.libraries)
    if (out is None) == (set_folder is None):
        raise InputError("specify exactly one of --out and --set")
    picture = replace(look, out=out or USUAL.out, rays=replace(rays, lattice=rays.of_all))
    is_of_objects = picture.heat_map is not None and picture.heat_map.needs == "objects"
    if scene.pog is not None and (is_of_objects or picture.traffic):
        option = "heatmap" if is_of_objects else "plain-traffic"
        raise InputError("holds no objects, which are to be drawn: leave it out, or change", "pog", option)
    prepare_drawing()
    if out is not None:
        require_writable(out)
    if set_folder is not None:
        require_folder(set_folder)
    opened = with_choice(load_rig(rig, TERMINAL), reading.housings)
    baseline = load_rig(picture.baseline, TERMINAL) if picture.baseline is not None else None
    opened = as_drawn(opened, Path(rig).parent, note)
    score = drawn_score(opened, score.body)
    pog, field = load_scene(scene, TERMINAL, [opened], score)
    is_counted = is_of_objects or picture.traffic
    traffic = load_traffic(scene, WITHIN_M, TERMINAL) if is_counted else None
    drawn = scored_state(opened, pog, field, picture, baseline, settings_of(score), traffic, TERMINAL)
    if set_folder is not None:
        written = write_set(drawn, set_folder, picture.size_px, picture.scale, TERMINAL)
        results().print(f"{set_folder}: {len(written)} files", soft_wrap=True)
        return
    assert out is not None
    draw(drawn, picture, TERMINAL)
    width, height = (side * picture.scale for side in picture.size_px)
    results(out).print(f"{out}: {width} x {height} pixels", soft_wrap=True)
