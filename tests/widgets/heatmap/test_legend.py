"""The legend is whole in every size, density, scale and theme, also in a picture that Qt draws before our turn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from riglens.core.view.heatmap_data import HeatmapData, Scale
from riglens.widgets.drawing.label import unit_px
from riglens.widgets.drawing.stage import render_window
from riglens.widgets.theme import DARK, LIGHT, Palette
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.words_layer import car_box
from tests.widgets.viewport.test_still import wall

SIZES: dict[Scale, tuple[int, int]] = {"ramp": (600, 400), "steps": (720, 450), "change": (560, 380)}
SCALES = tuple(SIZES)


def heat(scale: Scale) -> HeatmapData:
    data = replace(wall(4.0), scale=scale)
    if scale != "steps":
        return data
    steps = np.arange(len(data.values)) % 4
    return replace(data, values=steps.astype(np.float32), labels=("0", "1", "2", "3+"), vmax=3.0)


@pytest.fixture(params=[1.0, 2.0], ids=["normal", "dense"])
def scene(request: pytest.FixtureRequest) -> Iterator[DrawnScene]:
    plotter = pv.Plotter(
        off_screen=True, window_size=[round(side * request.param) for side in (600, 400)], lighting="none"
    )
    render_window(plotter).SetMultiSamples(0)
    made = DrawnScene(plotter, DARK, request.param)
    made.show(SceneState())
    yield made
    plotter.close()


def bar(scene: DrawnScene) -> np.ndarray:
    """Pixels (n, 3) along the middle of the colour bar as the window shows it."""
    plotter = scene._stage._plotter
    render_window(plotter).Render()
    image = np.asarray(plotter.screenshot(None, return_img=True))[:, :, :3].astype(int)
    unit = unit_px(scene.size, scene.pixel_ratio)
    row, left, right = (round(unit * length) for length in (12 + 30 + 6, 12 + 284 - 24, 12 + 24))
    return image[-row, -left:-right]


def is_whole(pixels: np.ndarray, palette: Palette) -> bool:
    """Whether nine tenths of the bar are coloured."""
    paper = np.array([int(palette.background[at : at + 2], 16) for at in (1, 3, 5)])
    return bool((np.abs(pixels - paper).max(axis=1) > 12).mean() > 0.9)


@pytest.mark.parametrize("scale", SCALES[:2])
def test_the_colour_bar_is_whole_after_every_switch_of_theme(scene: DrawnScene, scale: Scale) -> None:
    render_window(scene._stage._plotter).SetSize(*(round(side * scene.pixel_ratio) for side in SIZES[scale]))
    scene.show(replace(scene.state, heatmap=heat(scale)))
    scene.prepare()
    assert is_whole(bar(scene), DARK)
    for palette in (LIGHT, DARK):
        scene.show(replace(scene.state, palette=palette))
        assert is_whole(bar(scene), palette), "before the next frame is prepared"
        scene.prepare()
        assert is_whole(bar(scene), palette)


def test_the_colour_bar_is_whole_when_another_heatmap_comes(scene: DrawnScene) -> None:
    for scale in (*SCALES, *SCALES):
        scene.show(replace(scene.state, heatmap=heat(scale)))
        if scene._words._legend.texts and scale != SCALES[0]:
            assert is_whole(bar(scene), DARK), "before the next frame is prepared"
        scene.prepare()
        assert is_whole(bar(scene), DARK)


@pytest.mark.parametrize("size", [(1280, 720), (630, 420), (440, 300), (380, 200)], ids=str)
def test_the_legend_folds_or_moves_rather_than_cover_the_car(
    scene: DrawnScene, size: tuple[int, int]
) -> None:
    pixels = tuple(round(side * scene.pixel_ratio) for side in size)
    render_window(scene._stage._plotter).SetSize(*pixels)
    scene.show(replace(scene.state, heatmap=heat("ramp")))
    scene.prepare()
    words = scene._words
    box = words._legend.box(scene.size, scene.pixel_ratio, False, words._spot)
    assert not box.meets(car_box(scene.state, scene.size))
    assert len(scene._words._legend.texts) >= (3 if words._spot.is_folded else 4)


def test_the_legend_unfolds_once_there_is_room(scene: DrawnScene) -> None:
    for size, is_folded in (((360, 200), True), ((1600, 1000), False)):
        render_window(scene._stage._plotter).SetSize(*(round(side * scene.pixel_ratio) for side in size))
        scene.show(replace(scene.state, heatmap=heat("ramp")))
        scene.prepare()
        assert scene._words._spot.is_folded == is_folded


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("size", [(1600, 1000), (440, 300)], ids=["unfolded", "folded"])
def test_numbers_and_words_stay_on_the_plate(scene: DrawnScene, scale: Scale, size: tuple[int, int]) -> None:
    stage, words = scene._stage, scene._words
    render_window(stage._plotter).SetSize(*(round(side * scene.pixel_ratio) for side in size))
    scene.show(replace(scene.state, heatmap=replace(heat(scale), vmax=40.0)))
    scene.prepare()
    box = words._legend.box(scene.size, scene.pixel_ratio, False, words._spot)
    shown = [number for number in words._legend._numbers if number.GetVisibility() and number.GetInput()]
    assert shown
    for number in shown:
        width = [0.0, 0.0]
        number.GetSize(stage._plotter.renderer, width)
        middle = number.GetPosition()[0]
        assert box.left < middle - width[0] / 2 and middle + width[0] / 2 < box.left + box.width


def test_numbers_between_the_ends_stand_at_their_marks(scene: DrawnScene) -> None:
    render_window(scene._stage._plotter).SetSize(1600, 1000)
    scene.show(replace(scene.state, heatmap=replace(heat("ramp"), vmax=40.0)))
    scene.prepare()
    legend = scene._words._legend
    marks_px = np.asarray(legend._marks_mesh.points)[8::2, 0]  # after the four sides of the frame
    inner = slice(1, len(legend._ticks) - 1)
    assert len(marks_px) == len(legend._ticks) > 2
    assert [number.GetPosition()[0] for number in legend._numbers[inner]] == pytest.approx(
        marks_px[inner].tolist(), abs=1.0
    )
