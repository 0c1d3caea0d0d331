"""The main views look as they did when somebody last looked at them, and drawing them leaves nothing behind.

Compared are means over blocks of pixels, with room for other drivers, fonts and small changes of the car. After a
wanted change: `python -m tests.render.pictures`, look at tests/render/golden, commit.
"""

import gc
from functools import cache

import matplotlib.image
import numpy as np
import pytest
import pyvista as pv

from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.still import render_still
from tests.render.pictures import FOLDER, PICTURES, SIZE_PX

BLOCK_PX = 20
MEAN_OFF, WORST_OFF = 5.0, 60.0


def kept(name):
    """A golden image, colours from 0 to 255."""
    return 255.0 * matplotlib.image.imread(FOLDER / f"{name}.png")


@cache
def drawn(name):
    """A picture as it is drawn now."""
    return PICTURES[name]().astype(float)


def blocks(image):
    """Mean colour of each block of pixels."""
    height, width = image.shape[0] // BLOCK_PX, image.shape[1] // BLOCK_PX
    cut = image[: height * BLOCK_PX, : width * BLOCK_PX, :3].astype(float)
    return cut.reshape(height, BLOCK_PX, width, BLOCK_PX, 3).mean(axis=(1, 3))


@pytest.mark.parametrize("name", PICTURES)
def test_a_main_view_looks_as_it_did(name, tmp_path):
    assert drawn(name).shape[:2] == kept(name).shape[:2] == SIZE_PX[::-1]
    assert looks_alike(drawn(name), kept(name)), blocks_off(drawn(name), kept(name))


def blocks_off(one, other):
    """By how much blocks differ: the mean of all, and the worst."""
    off = np.abs(blocks(one) - blocks(other))
    return off.mean(), off.max()


def looks_alike(one, other):
    """Whether two pictures are the same but for small things."""
    mean, worst = blocks_off(one, other)
    return mean < MEAN_OFF and worst < WORST_OFF


def test_the_golden_images_differ_from_each_other_by_more_than_the_tolerance():
    images = [blocks(kept(name)) for name in PICTURES if name != "gizmo"]
    for place, image in enumerate(images):
        for other in images[:place]:
            assert np.abs(image - other).mean() > 2 * MEAN_OFF


def _vtk_objects() -> int:
    gc.collect()
    return sum(str(type(thing).__module__).startswith("vtkmodules") for thing in gc.get_objects())


def test_a_picture_leaves_no_plotter_and_no_vtk_object_behind():
    def draw():
        render_still(SceneState(), (64, 64))

    def open_plotters():
        return {key for key, plotter in pv.plotting.plotter._ALL_PLOTTERS.items() if not plotter._closed}

    opened_by_others = open_plotters()
    draw()
    before = _vtk_objects()
    draw()
    draw()
    assert _vtk_objects() <= before
    assert open_plotters() <= opened_by_others
