"""The pictures that are kept as golden images: few, of a small scene, each with much to see.

`python -m tests.render.pictures` draws them anew; look at them before they are committed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.engine.engine import Engine
from riglens.core.figures.heatmaps import Heatmaps, Marks
from riglens.core.figures.registry import voxel_heat_map
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.view.display import DisplayGrid
from riglens.evaluation.ground_map import ground_map
from riglens.rendering.picture import Findings, PictureWords, with_words
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.theme import palette
from riglens.widgets.viewport.scene_state import Marker, SceneState
from riglens.widgets.viewport.still import png_of, render_still
from tests.core.builders import synthetic_pog

FOLDER = Path(__file__).with_name("golden")
SIZE_PX = (480, 300)
GRID = VoxelGrid(0.5, (24.0, 16.0, 4.0))
FRAMES = 100
LIDAR = Lidar(
    name="roof",
    position=(0.0, 0.0, 1.9),
    elevations_deg=LinearAngles(from_=-25.0, to=15.0, count=12),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=120),
)
CAMERA = Camera(name="front", position=(1.2, 0.0, 1.4), hfov_deg=80.0, cast=(64, 36))
REAR = CAMERA.replace(name="rear", position=(-1.5, 0.0, 1.4), rpy_deg=(0.0, 0.0, 180.0))
RIG, BEFORE = Rig(name="golden", sensors=(LIDAR, CAMERA)), Rig(name="before", sensors=(LIDAR, REAR))


@cache
def scene() -> tuple[Pog, EntropyField]:
    """Two lanes of traffic: p falls with the distance from their middle and with height."""
    x, y, z = np.meshgrid(*(GRID.centres_m(axis) for axis in range(3)), indexing="ij")
    p = 0.5 * np.exp(-(((np.abs(y) - 4.0) / 1.5) ** 2)) * np.exp(-z / 2.0) * (0.6 + 0.4 * np.cos(x / 3.0))
    counts = np.repeat(np.floor(FRAMES * p).astype(np.int64)[..., None], 3, axis=-1)
    pog = synthetic_pog(GRID, counts, FRAMES)
    return pog, EntropyField.from_pog(pog)


def state(mode: str, dark: bool, words: PictureWords, look: HeatLook | None = None) -> SceneState:
    """The scene of a picture, evaluated anew."""
    pog, field = scene()
    engine = Engine(field, 1)
    evaluation = engine.evaluate(RIG)
    heat = voxel_heat_map(mode)
    assert heat is not None
    marks = Marks(heat.sets(engine, evaluation))
    before = engine.evaluate(BEFORE)
    marks = replace(marks, baseline=heat.sets(engine, before), baseline_name="before")
    cells = Heatmaps(DisplayGrid.build(pog, field)).drawn(heat, "car", marks)
    shown = SceneState(
        rig=RIG,
        grid=GRID,
        heatmap=cells,
        heat_look=look or HeatLook(),
        palette=palette(dark),
        selected="roof",
    )
    return with_words(shown, words, Findings(RIG, evaluation.scores, PAPER_SETTINGS, field))


def _seen() -> NDArray[np.uint8]:
    return render_still(state("seen", True, PictureWords(True, True, True)), SIZE_PX, view="iso")


def _sensors() -> NDArray[np.uint8]:
    return render_still(state("sensors", False, PictureWords()), SIZE_PX, view="top")


def _change() -> NDArray[np.uint8]:
    shown = state("change", True, PictureWords(), HeatLook(opacity=0.8, slice_m=(0.5, 1.5)))
    marked = replace(shown, marker=Marker((4.25, 4.25, 0.75), GRID.voxel_m))
    return render_still(marked, SIZE_PX, view="iso")


def _handles() -> NDArray[np.uint8]:
    """The gizmo of the selected sensor, with nothing but car and ground around it."""
    shown = state("seen", True, PictureWords())
    bare = replace(shown, heatmap=None, ray_look=RayLook(shown=False), show_gizmo=True)
    return render_still(bare, SIZE_PX, view="iso")


def _ground(k: int, dark: bool) -> NDArray[np.uint8]:
    """Blind areas or overlap around the car, body and key included, from above."""
    settings = BlindSettings(voxel_m=0.25, width_m=0.3, within_m=5.0)
    found = BlindEngine(RIG.vehicle, settings, threads=1).evaluate(RIG)
    shown = SceneState(
        rig=RIG,
        grid=GRID,
        ground_map=ground_map(found, "any", k),
        ray_look=RayLook(shown=False),
        palette=palette(dark),
    )
    return render_still(shown, SIZE_PX, view="top" if k else "iso")


def _first(dark: bool) -> NDArray[np.uint8]:
    """The first view: heatmap and footprints on the ground, a camera selected."""
    shown = state("seen", dark, PictureWords(), HeatLook(draped=True))
    return render_still(replace(shown, selected="front", show_selection=True), SIZE_PX, view="iso")


PICTURES: dict[str, Callable[[], NDArray[np.uint8]]] = {
    "first-dark": lambda: _first(True),
    "first-light": lambda: _first(False),
    "seen": _seen,
    "sensors": _sensors,
    "change": _change,
    "gizmo": _handles,
    "blind": lambda: _ground(1, False),
    "overlap": lambda: _ground(0, True),
}


def main() -> None:
    """Draw all golden images anew."""
    FOLDER.mkdir(exist_ok=True)
    for name, draw in PICTURES.items():
        (FOLDER / f"{name}.png").write_bytes(png_of(draw()))


if __name__ == "__main__":
    main()
