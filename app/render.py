"""Pictures of a rig without a window: the scene of the window, drawn offscreen into a PNG file."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from app.console import progress_bar, results
from app.display import missing_display
from app.jobs import load_with_progress, rig_called, score_rigs
from app.options import SceneOptions, ScoreOptions
from app.system_libraries import require_system_libraries
from core.engine.engine import Evaluation
from core.errors import InputError
from core.files import require_writable
from core.metric.entropy import EntropyField
from core.scene.display import DisplayGrid
from core.scene.pog import Pog

View = Literal["iso", "top", "front", "left", "rear"]
Heat = Literal["probability", "entropy", "seen", "off"]
MIN_SIDE_PX, MAX_SIDE_PX, MAX_SCALE = 64, 8192, 4


@dataclass(frozen=True)
class Picture:
    """What to draw and where to put it; `size_px` is width and height before `scale` enlarges all alike."""

    out: Path
    view: View = "iso"
    size_px: tuple[int, int] = (1280, 800)
    scale: int = 1
    class_name: str = "car"
    heat: Heat = "seen"

    def __post_init__(self) -> None:
        if self.out.suffix.lower() != ".png":
            raise InputError(f"--out: found {self.out}, accepted is a file name ending in .png")
        if not 1 <= self.scale <= MAX_SCALE:
            raise InputError(f"--scale: found {self.scale}, accepted is a whole number from 1 to {MAX_SCALE}")
        if not all(MIN_SIDE_PX <= side * self.scale <= MAX_SIDE_PX for side in self.size_px):
            width, height = self.size_px
            raise InputError(
                f"--size: found {width}x{height} at scale {self.scale}, accepted are sides "
                f"of {MIN_SIDE_PX} to {MAX_SIDE_PX} pixels, scale included"
            )


def parse_size(text: str) -> tuple[int, int]:
    """Width and height of a text such as "1280x800"; InputError when it is not one."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text.strip().lower())
    if match is None:
        raise InputError(f"--size: found {text}, accepted is WIDTHxHEIGHT in pixels, such as 1280x800")
    return int(match[1]), int(match[2])


def render(name: str, scene: SceneOptions, picture: Picture) -> None:
    """Score a rig on a scene and draw both."""
    prepare_drawing()
    require_writable(picture.out)
    rig = rig_called(name)
    pog, field = load_with_progress(scene.for_rigs([rig], ScoreOptions()))
    [evaluation] = score_rigs([rig], field, ScoreOptions())
    draw(pog, field, evaluation, picture)
    width, height = (side * picture.scale for side in picture.size_px)
    results().print(f"{picture.out}: {width} x {height} pixels", soft_wrap=True, markup=False)


def prepare_drawing() -> None:
    """Check the system libraries, and have VTK draw without an X server where there is none.

    Comes before anything that imports VTK: it crashes, instead of complaining, when OpenGL is absent.
    """
    require_system_libraries("offscreen")
    if sys.platform.startswith("linux") and missing_display():
        os.environ["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"


def draw(pog: Pog, field: EntropyField, evaluation: Evaluation, picture: Picture) -> None:
    """Draw an evaluated rig with its rays and the heatmap of a class; call `prepare_drawing` before."""
    from app.heatmap import heatmap
    from widgets.viewport.scene import SceneState, render_still

    with progress_bar("Drawing"):
        cells = heatmap(DisplayGrid.build(pog, field), evaluation, picture.heat, picture.class_name)
        rig = evaluation.rig
        state = SceneState(vehicle=rig.vehicle, rig=rig, grid=field.grid, heatmap=cells)
        render_still(state, picture.size_px, picture.scale, picture.out, view=picture.view)
