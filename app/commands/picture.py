"""`riglens render`: a picture of a rig."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from riglens.app.commands.options import BODY, LibraryArguments, Out, Rig, SceneArguments, whole_number
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, RayLook

if TYPE_CHECKING:
    from riglens.app.rendering.render import RenderRequest

Heat = Literal[
    "probability", "entropy", "seen", "unseen", "sensors", "change", "twice", "thrice", "kinds", "off"
]


_HEATMAP = (
    "What the heatmap shows: probability of being occupied, entropy, the entropy that the rig sees or does not see, "
    "by how many sensors a place is seen, or the change against --baseline."
)


@Parameter(name="*")
@dataclass(frozen=True)
class PictureArguments:
    """What a picture shows, and how."""

    view: Annotated[Literal["iso", "top", "front", "left", "rear"], Parameter(metavar="NAME")] = "iso"
    """Where to look from."""
    size: Annotated[str, Parameter(metavar="WxH")] = "1280x800"
    """Size of the picture in pixels."""
    scale: Annotated[int, Parameter(converter=whole_number, metavar="K")] = 1
    """Draw K times as many pixels along each side, with lines and letters as large."""
    class_name: Annotated[
        Literal["car", "bicycle", "pedestrian"], Parameter(name="--class", metavar="NAME")
    ] = "car"
    """Class of the heatmap."""
    heatmap: Annotated[Heat, Parameter(metavar="NAME", help=_HEATMAP)] = "seen"
    baseline: Annotated[str | None, Parameter(metavar="RIG")] = None
    """The rig that --heatmap change starts from."""
    slice_m: Annotated[tuple[float, float] | None, Parameter(name="--slice", metavar="FROM TO")] = None
    """Draw only cells of the heatmap between two heights, metres."""
    threshold: Annotated[float | None, Parameter(metavar="SHARE")] = None
    """Leave out cells in the lowest part of the colour scale, 0 to 1 (0.02)."""
    log: bool = False
    """Logarithmic colour scale, three powers of ten long."""
    opacity: Annotated[float | None, Parameter(metavar="SHARE")] = None
    """Opacity of the highest values, 0 to 1 (0.5)."""
    rays: Annotated[bool, Parameter(negative="--no-rays")] = True
    """The rays of the sensors."""
    ray_opacity: Annotated[float, Parameter(metavar="SHARE")] = DEFAULT_RAYS.opacity
    """Opacity of the rays, 0 to 1 (0.2)."""
    ray_density: Annotated[float, Parameter(metavar="FACTOR")] = DEFAULT_RAYS.density
    """How many times as many rays, 0.125 to 8 (1)."""
    fill: Annotated[Literal["none", "ground", "frusta"], Parameter(metavar="NAME")] = "none"
    """Fill what each sensor looks at: its footprint on open ground, or the outside of its field of view."""
    transparent: bool = False
    """No background."""
    ground: Annotated[bool, Parameter(negative="--no-ground")] = True
    """The ground with its grid and metres."""
    legend: Annotated[bool, Parameter(negative="--no-legend")] = True
    """The colour bar."""
    title: bool = False
    """Name of the rig and what it was scored on, in the upper corner."""
    scores: bool = False
    """The table of scores, in the lower corner."""
    theme: Annotated[Literal["dark", "light"], Parameter(metavar="NAME")] = "dark"
    """Dark or light background."""

    def picture(self, out: Path) -> RenderRequest:
        """Return the same as a checked request, together with the file to write."""
        from riglens.app.rendering.render import RenderRequest, parse_size

        return RenderRequest(
            out, self.view, parse_size(self.size), self.scale, self.class_name, self.heatmap,
            transparent=self.transparent, legend=self.legend, title=self.title, scores=self.scores,
            theme=self.theme, threshold=self.threshold, log=self.log, opacity=self.opacity,
            slice_m=self.slice_m, baseline=self.baseline,
            rays=RayLook(self.rays, self.ray_opacity, self.ray_density, self.fill), ground=self.ground,
        )  # fmt: skip


def render(
    rig: Rig,
    /,
    *,
    out: Out,
    look: PictureArguments = PictureArguments(),
    scene: SceneArguments = SceneArguments(),
    body: Annotated[Literal["ignored", "blocks"] | None, BODY] = None,
    libraries: LibraryArguments = LibraryArguments(),
) -> None:
    """Draw a rig, its rays and the heatmap of a class into a PNG file, without a display.

    Parameters
    ----------
    rig
        Rig file or preset name.
    out
        The picture (.png).
    body
        Whether rays pass through the car's own body or end at it, for this run (as each rig says).
    """
    libraries.use()
    options = scene.options()
    from riglens.app.rendering import render as drawing

    drawing.render(rig, options, look.picture(out), body)
