"""The main views look as they did when somebody last looked at them, and drawing them leaves nothing behind.

Compared are means over blocks of pixels, with room for other drivers, fonts and small changes of the car; and, where
letters and handles matter, every pixel of some crops, with room for one pixel of shift and other smoothing. After a
wanted change: `python -m tests.render.pictures`, look at tests/render/golden, commit.
"""

import gc
from functools import cache

import matplotlib.image
import numpy as np
import pytest
import pyvista as pv
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.still import render_still
from tests.render.pictures import CROPS, FOLDER, PICTURES, SIZE_PX, handles

BLOCK_PX = 20
MEAN_OFF, WORST_OFF = 5.0, 60.0
PIXEL_OFF, SPOT_PX, MOST_PER_SPOT = 40.0, 9, 9
"""A pixel is off by more than this beyond all neighbours; in a spot of so many pixels square so many may be.

Other smoothing of the edges makes up to 8 of a spot's pixels be off, a digit that is missing 18.
"""


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


# ---------------------------------------------------------------------- at full resolution
def most_off_in_a_spot(one, other):
    """How many pixels of a small spot of one crop are like nothing near them in the other, at most."""
    off = np.maximum(_beyond_neighbours(one, other), _beyond_neighbours(other, one)) > PIXEL_OFF
    return round(float(uniform_filter(off.astype(float), SPOT_PX, mode="constant").max()) * SPOT_PX**2)


def spot_off(name, image):
    """The same of a crop of an image and of the golden one."""
    crop = CROPS[name]
    return most_off_in_a_spot(crop.of(image), crop.of(kept(crop.picture)))


def _beyond_neighbours(image, other):
    lowest, highest = minimum_filter(other, (3, 3, 1)), maximum_filter(other, (3, 3, 1))
    return np.maximum(image - highest, lowest - image).max(axis=2)


@pytest.mark.parametrize("name", CROPS)
def test_letters_and_handles_are_where_they_were(name):
    assert spot_off(name, drawn(CROPS[name].picture)) <= MOST_PER_SPOT


@pytest.mark.parametrize("name", CROPS)
def test_a_crop_notices_what_has_moved_by_three_pixels_but_not_by_one(name):
    part = CROPS[name].of(kept(CROPS[name].picture))
    assert most_off_in_a_spot(part, np.roll(part, 1, axis=1)) <= MOST_PER_SPOT
    for axis in (0, 1):
        assert most_off_in_a_spot(part, np.roll(part, 3, axis=axis)) > MOST_PER_SPOT


def changed(picture, rows, columns, by_px):
    """A golden image with a part of it pasted again, so much to the right."""
    image = kept(picture)
    image[rows, columns.start + by_px : columns.stop + by_px] = kept(picture)[rows, columns]
    return image


def test_a_number_that_moved_and_a_digit_that_is_missing_are_seen_by_the_crop_alone():
    row, number, blank = slice(241, 252), slice(176, 202), slice(203, 210)
    for spoilt in (changed("seen", row, number, 3), changed("seen", row, blank, -9)):
        assert looks_alike(spoilt, kept("seen"))
        assert spot_off("score table", spoilt) > MOST_PER_SPOT


@pytest.mark.parametrize("mode", ["move", "rotate"])
def test_handles_that_are_missing_are_seen_by_the_crop_alone(mode):
    spoilt = handles(mode).astype(float)
    assert looks_alike(spoilt, kept("gizmo"))
    assert spot_off("handles", spoilt) > MOST_PER_SPOT


def _vtk_objects() -> int:
    gc.collect()
    return sum(str(type(thing).__module__).startswith("vtkmodules") for thing in gc.get_objects())


def test_a_picture_leaves_no_plotter_and_no_vtk_object_behind():
    def draw():
        render_still(SceneState(), (64, 64))

    draw()
    before = _vtk_objects()
    draw()
    draw()
    assert _vtk_objects() <= before
    assert not [plotter for plotter in pv.plotting.plotter._ALL_PLOTTERS.values() if not plotter._closed]
