"""Pictures of a scene without a window: pixels of any size, and PNG files of them."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from riglens.core.files import atomic_write
from riglens.widgets.drawing.camera import Size
from riglens.widgets.drawing.stage import render_window
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState

_SAMPLES = 8


def render_still(
    state: SceneState,
    size: Size,
    scale: float = 1.0,
    path: Path | None = None,
    transparent: bool = False,
    view: str | None = None,
) -> NDArray[np.uint8]:
    """Draw a state offscreen with smooth edges: pixels (height * scale, width * scale, 3 or 4) uint8.

    `size` is width and height; `scale` enlarges everything alike, or makes it smaller. With `path` a PNG is
    written there. `view` picks a named view (InputError for an unknown one), that from the corner of the whole
    ROI if cells are in space; else the state's camera is kept.
    """
    plotter = staged(state, size, scale, view, transparent)
    try:
        plotter.show(auto_close=False)
        image = np.asarray(plotter.screenshot(None, transparent_background=transparent, return_img=True))
        if transparent:
            image = _unmixed(image)
        if path is not None:
            write_png(image, path)
        return image
    finally:
        plotter.close()


def staged(
    state: SceneState,
    size: Size,
    scale: float = 1.0,
    view: str | None = None,
    transparent: bool = False,
    off_screen: bool = True,
    notebook: bool = False,
) -> pv.Plotter:
    """Return a plotter that shows a state, ready to be drawn; for a notebook or a window of its own on request."""
    plotter = pv.Plotter(
        off_screen=off_screen,
        notebook=notebook,
        window_size=[max(1, round(side * scale)) for side in size],
        lighting="none",
    )
    try:
        render_window(plotter).SetMultiSamples(_SAMPLES)
        scene = DrawnScene(plotter, state.palette, pixel_ratio=scale)
        ground = state.show_ground and not transparent  # it reaches to the horizon: nothing would be clear
        scene.show(replace(state, show_ground=ground))
        if view is not None:
            scene.set_view(view, wide=not state.heat_look.draped and state.heatmap is not None)
        if transparent:
            plotter.renderer.GradientBackgroundOff()
            plotter.renderer.SetBackground(0.0, 0.0, 0.0)
        scene.prepare()
    except BaseException:
        plotter.close()
        raise
    return plotter


def _unmixed(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return pixels (h, w, 4) drawn over black with the colours that they have over any background."""
    alpha = np.maximum(image[..., 3:].astype(np.float64), 1.0) / 255.0
    colours = np.clip(np.round(image[..., :3] / alpha), 0, 255).astype(np.uint8)
    return np.concatenate([colours, image[..., 3:]], axis=-1)


def png_of(image: NDArray[np.uint8]) -> bytes:
    """Return pixels (h, w, 3 or 4) as a PNG file."""
    file = io.BytesIO()
    matplotlib.image.imsave(file, image, format="png")
    return file.getvalue()


def write_png(image: NDArray[np.uint8], path: Path) -> None:
    """Write pixels (h, w, 3 or 4) as a PNG, completely or not at all; InputError if it cannot be written."""
    with atomic_write(path) as file:
        file.write(png_of(image))
