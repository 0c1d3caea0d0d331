"""`riglens render`: a picture of a rig."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from riglens.app.commands.options import (
    BodyArguments,
    RigArguments,
    RigName,
    SceneArguments,
    command,
    number,
)
from riglens.app.terminal.console import TERMINAL, note, results
from riglens.app.terminal.loading import load_rig, load_scene, load_traffic
from riglens.core.errors import InputError
from riglens.core.figures.heatmaps import OFF, SEEN_ENTROPY
from riglens.core.figures.registry import heat_maps
from riglens.core.figures.text import in_sentence
from riglens.core.files import require_writable
from riglens.core.rig.library import use_libraries
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.loading import with_choice
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import settings_of
from riglens.rendering.display import prepare_drawing
from riglens.rendering.picture_set import require_folder, write_set
from riglens.rendering.render import RenderRequest, as_drawn, draw, drawn_score, scored_state
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, RayLook

_TITLES = {heat.key: in_sentence(heat.title) for heat in heat_maps()}
_HEATMAP = (
    "Content of the heatmap: " + ", ".join(f"{key} ({title})" for key, title in _TITLES.items()) + ", or off."
)
if TYPE_CHECKING:
    HeatChoice = str
else:
    HeatChoice = Literal[(*_TITLES, OFF)]


@Parameter(name="*")
@dataclass(frozen=True)
class PictureArguments:
    """Content and size of a picture."""

    view: Annotated[Literal["iso", "top", "front", "left", "rear"], Parameter(metavar="NAME")] = "iso"
    """Viewing direction."""
    size: Annotated[str, Parameter(metavar="WxH")] = "1280x800"
    """Size of the picture in pixels."""
    scale: Annotated[int, number(metavar="K")] = 1
    """Factor by which the picture is enlarged, with its lines and text."""
    class_name: Annotated[
        Literal["car", "bicycle", "pedestrian"], Parameter(name="--class", metavar="NAME")
    ] = "car"
    """Class of the heatmap."""
    heatmap: Annotated[HeatChoice, Parameter(metavar="NAME", help=_HEATMAP, show_choices=False)] = (
        SEEN_ENTROPY.key
    )
    baseline: Annotated[str | None, Parameter(metavar="RIG")] = None
    """Reference rig of a heatmap of changes."""
    slice_m: Annotated[tuple[float, float] | None, Parameter(name="--slice", metavar="FROM TO")] = None
    """Draw only cells of the heatmap between two heights, metres."""
    threshold: Annotated[float | None, Parameter(metavar="SHARE")] = None
    """Leave out cells in the lowest part of the colour scale, 0 to 1 (0.02)."""
    log: bool = False
    """Use a logarithmic colour scale of three decades."""
    opacity: Annotated[float | None, Parameter(metavar="SHARE")] = None
    """Opacity of the highest values, 0 to 1 (0.5)."""
    draped: Annotated[bool | None, Parameter(negative="--voxels", show_default=False)] = None
    """Draw the heatmap on the ground, all heights together, or as cells in space; the latter for rigs of the paper."""
    select: Annotated[str | None, Parameter(metavar="SENSOR")] = None
    """Show this sensor as selected, with its rays and labels."""
    rays: Annotated[bool, Parameter(negative="--no-rays")] = True
    """Draw the rays of the selected sensor, or of all with --all-rays."""
    all_rays: bool = False
    """Draw the rays of every sensor."""
    ray_opacity: Annotated[float, Parameter(metavar="SHARE")] = DEFAULT_RAYS.opacity
    """Opacity of the rays, 0 to 1."""
    ray_density: Annotated[float, Parameter(metavar="FACTOR")] = DEFAULT_RAYS.density
    """Factor by which the number of rays drawn changes, 0.125 to 8."""
    fill: Annotated[Literal["none", "ground", "frusta"], Parameter(metavar="NAME")] = DEFAULT_RAYS.fill
    """Show fields of view: footprints on the ground, or the outside of the field."""
    transparent: bool = False
    """Leave background and ground transparent."""
    ground: Annotated[bool, Parameter(name="--ground-plane", negative="--no-ground")] = True
    """Draw the ground with its grid and metres."""
    legend: Annotated[bool, Parameter(negative="--no-legend")] = True
    """Draw the colour bar."""
    title: bool = False
    """Write the name of the rig and its inputs in the upper corner."""
    scores: bool = False
    """Write the table of scores in the lower corner."""
    theme: Annotated[Literal["dark", "light"], Parameter(metavar="NAME")] = "dark"
    """Dark or light background."""

    def picture(self, out: Path) -> RenderRequest:
        """Return the same as a checked request, together with the file to write."""
        return RenderRequest(
            out, self.view, _parse_size(self.size), self.scale, self.class_name, self.heatmap,
            transparent=self.transparent, legend=self.legend, title=self.title, scores=self.scores,
            theme=self.theme, threshold=self.threshold, log=self.log, opacity=self.opacity,
            slice_m=self.slice_m, baseline=self.baseline,
            rays=RayLook(
                self.rays, self.ray_opacity, self.ray_density, self.fill, self.all_rays, lattice=self.all_rays
            ),
            ground=self.ground, draped=self.draped, selected=self.select,
        )  # fmt: skip


@command
def render(
    rig: RigName,
    /,
    *,
    out: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    set_folder: Annotated[Path | None, Parameter(name="--set", metavar="DIR")] = None,
    look: PictureArguments = PictureArguments(),
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
    picture = look.picture(Path("picture.png") if out is None else out)
    is_of_objects = picture.heat_map is not None and picture.heat_map.needs == "objects"
    if is_of_objects and scene.pog is not None:
        raise InputError(
            f"holds no objects, which {picture.heat} shows: leave it out, or choose another", "pog", "heatmap"
        )
    prepare_drawing()
    if out is not None:
        require_writable(out)
    if set_folder is not None:
        require_folder(set_folder)
    opened = with_choice(load_rig(rig), reading.housings)
    baseline = load_rig(picture.baseline) if picture.baseline is not None else None
    opened = as_drawn(opened, Path(rig).parent, note)
    score = drawn_score(opened, score.body)
    pog, field = load_scene(scene, [opened], score)
    traffic = load_traffic(scene, WITHIN_M) if is_of_objects else None
    drawn = scored_state(opened, pog, field, picture, baseline, settings_of(score), traffic, TERMINAL)
    if set_folder is not None:
        written = write_set(drawn, set_folder, picture.size_px, picture.scale, TERMINAL)
        results().print(f"{set_folder}: {len(written)} files", soft_wrap=True)
        return
    assert out is not None
    draw(drawn, picture, TERMINAL)
    width, height = (side * picture.scale for side in picture.size_px)
    results(out).print(f"{out}: {width} x {height} pixels", soft_wrap=True)


def _parse_size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text.strip().lower())
    if match is None:
        raise InputError(f"must be WIDTHxHEIGHT in pixels, such as 1280x800 (got {text})", "size_px")
    return int(match[1]), int(match[2])
