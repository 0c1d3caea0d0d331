"""Rays in the window: a key and a box switch them, sliders make them more or stronger, pictures show the same."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QStyle, QStyleOptionSlider, QToolButton, QWidget
from pytestqt.qtbot import QtBot

from riglens.app.window.features.heat import ray_look_of
from riglens.app.window.settings import Settings
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, RayLook
from riglens.widgets.viewport.offscreen import OffscreenViewport
from riglens.widgets.viewport.still import render_still
from tests.app.window_bench import Bench, open_bench, type_into
from tests.widgets.mouse import hover


@pytest.fixture
def bench(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(qtbot, tmp_path, data=False) as opened:
        yield opened


def click_box(box: QWidget) -> None:
    QTest.mouseClick(box, Qt.MouseButton.LeftButton, pos=QPoint(8, box.height() // 2))


def drag_handle(slider: QWidget, by_px: int) -> None:
    """Pull the handle of a slider sideways with the mouse."""
    option = QStyleOptionSlider()
    slider.initStyleOption(option)
    part = QStyle.SubControl.SC_SliderHandle
    at = slider.style().subControlRect(QStyle.ComplexControl.CC_Slider, option, part, slider).center()
    QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=at)
    hover(slider, at + QPoint(by_px, 0), Qt.MouseButton.LeftButton)
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=at + QPoint(by_px, 0))


def open_sliders(bench: Bench) -> QWidget:
    button = bench.window.findChild(QToolButton, "heat_look")
    assert button is not None
    button.menu().popup(QPoint(0, 0))
    panel = bench.features.rays.panel
    assert panel.isVisible()
    return panel


def test_a_key_and_a_box_switch_the_rays(bench: Bench) -> None:
    assert bench.viewport.state.ray_look == DEFAULT_RAYS
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_R)
    assert bench.viewport.state.ray_look == RayLook(shown=False)
    panel = open_sliders(bench)
    assert not panel.shown.isChecked() and not panel.opacity.isEnabled()
    click_box(panel.shown)
    assert bench.viewport.state.ray_look == DEFAULT_RAYS and bench.workbench.actions["rays"].isChecked()


def test_sliders_make_rays_more_or_stronger_and_reset_takes_that_back(bench: Bench) -> None:
    panel = open_sliders(bench)
    heat = bench.features.heat.panel
    heat.opacity.setValue(20)
    drag_handle(panel.opacity, 40)
    drag_handle(panel.density, -30)
    look = bench.viewport.state.ray_look
    assert look.opacity > 0.4 and look.density < 0.6
    reset = panel.findChild(QWidget, "reset_look")
    assert reset is not None
    QTest.mouseClick(reset, Qt.MouseButton.LeftButton)
    assert bench.viewport.state.ray_look == DEFAULT_RAYS
    assert heat.opacity.value() == 20, "the heatmap stays as it is"


def test_rays_are_drawn_the_next_time_as_they_were_left(qtbot: QtBot, tmp_path: Path) -> None:
    file = tmp_path / "window.ini"
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        panel = bench.features.rays.panel
        panel.opacity.setValue(70)
        panel.density.setValue(3)
        bench.act("rays")
        left = bench.viewport.state.ray_look
        assert not left.shown
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        assert bench.viewport.state.ray_look == left
        assert not bench.workbench.actions["rays"].isChecked()


def test_fields_of_view_are_filled_from_the_menu_without_rays_too_and_kept(
    qtbot: QtBot, tmp_path: Path
) -> None:
    file = tmp_path / "window.ini"
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        for fill in ("none", "frusta"):
            bench.act(f"fill_{fill}")
            assert bench.viewport.state.ray_look == RayLook(fill=fill)
            assert [
                key
                for key in ("none", "ground", "frusta")
                if bench.workbench.actions[f"fill_{key}"].isChecked()
            ] == [fill]
        bench.act("rays")
        assert bench.viewport.state.ray_look == RayLook(shown=False, fill="frusta")
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        assert bench.viewport.state.ray_look == RayLook(shown=False, fill="frusta")
        bench.features.rays.panel.reset()
        assert (
            bench.viewport.state.ray_look == DEFAULT_RAYS
            and bench.workbench.actions["fill_ground"].isChecked()
        )


@pytest.mark.parametrize("kept", [{}, {"opacity": "x", "density": 1.0}, {"opacity": 0.5, "density": 1e9}])
def test_a_look_that_was_not_kept_well_is_forgotten(kept: dict) -> None:
    assert ray_look_of(kept) is None
    assert ray_look_of({"shown": False, "opacity": 0.5, "density": 2.0}) == RayLook(False, 0.5, 2.0)


@pytest.mark.slow
def test_a_picture_shows_the_rays_of_the_view(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, viewport=OffscreenViewport()) as bench:
        panel, pictures = bench.features.rays.panel, []
        panel.of_all.setChecked(True)
        for opacity in (10, 100):
            panel.opacity.setValue(opacity)
            pictures.append(render_still(bench.viewport.state, (160, 100)).astype(int))
        bench.act("rays")
        pictures.append(render_still(bench.viewport.state, (160, 100)).astype(int))
        faint, strong = (np.abs(picture - pictures[-1]).mean() for picture in pictures[:2])
        assert strong > 2 * faint > 0


def test_bands_of_own_limits_are_kept_and_others_are_refused(bench: Bench, tmp_path: Path) -> None:
    panel = open_sliders(bench)
    type_into(bench.qtbot, panel.limits, "200, 50")
    assert bench.viewport.state.ray_look.px_per_m == (200.0, 50.0)
    type_into(bench.qtbot, panel.limits, "50, 200")
    assert panel.limits.property("invalid") and bench.viewport.state.ray_look.px_per_m == (200.0, 50.0)
    kept = asdict(bench.viewport.state.ray_look)
    assert ray_look_of(kept) == bench.viewport.state.ray_look
    for broken in ("x", [1.0, 2.0], [None], 7):
        look = ray_look_of(kept | {"px_per_m": broken})
        assert look is not None and look.px_per_m == DEFAULT_RAYS.px_per_m
