"""Heatmap and map show what the rig gets onto road users, of all frames, and say so while an edit is counted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QImage, QPainter
from PySide6.QtWidgets import QComboBox

from riglens.app.window.features.target_maps import COUNTING
from riglens.core.figures.heatmaps import LOST_BEHIND_TRAFFIC, MISSED_OBJECTS, OF_TARGETS
from riglens.core.figures.registry import heat_map_named
from riglens.widgets.heatmap.scale import bar_ticks
from riglens.widgets.maps.ground_items import draw_ground_legend, ground_text, summary_of
from riglens.widgets.theme import LIGHT_TONES
from tests.app.window.counts import count
from tests.app.window.desk import FullDesk
from tests.app.window_bench import choose_item


def test_voxels_are_asked_for_only_while_the_heatmap_shows_them(desk: FullDesk) -> None:
    desk.features.heat.set_mode("on_target")
    assert desk.recompute.requests[-1].heat == "off" and desk.session.heat.mode == "on_target"
    desk.features.heat.set_mode("seen")
    assert desk.recompute.requests[-1].heat == "seen"


@pytest.mark.parametrize(("mode", "unit", "way"), [("on_target", "%", "more"), ("missed", "objects", "less")])
def test_the_heatmap_is_that_of_all_frames_with_unit_and_direction(
    desk: FullDesk, mode: str, unit: str, way: str
) -> None:
    desk.features.heat.set_mode(mode)
    assert desk.viewport.state.heatmap is None
    count(desk, 3)
    assert desk.viewport.state.heatmap is None
    count(desk)
    data = desk.viewport.state.heatmap
    ground = desk.features.targets.answer.ground[0]
    assert data.unit == unit and data.note.startswith(f"{way} is better") and data.title.endswith(", car")
    over = heat_map_named(mode).over(ground)
    assert np.array_equal(data.values, over.values[over.objects > 0].astype(np.float32))
    look = desk.viewport.state.heat_look
    ends = [tick.text for tick in bar_ticks(data, look)]
    assert look.draped and (ends[0] == "0" if mode == "on_target" else ends == ["low", "high"])
    assert bar_ticks(data, replace(look, draped=False))[0].text == "0"
    desk.features.heat.set_class("pedestrian")
    assert desk.viewport.state.heatmap.title.endswith(", pedestrian")


def test_a_new_score_leaves_the_heatmap_of_road_users(desk: FullDesk) -> None:
    desk.features.heat.set_mode("on_target")
    count(desk)
    before = desk.viewport.state.heatmap
    desk.answer(0.7)
    assert before is not None and desk.viewport.state.heatmap is before


def test_while_an_edit_is_counted_the_legend_says_so(desk: FullDesk) -> None:
    desk.features.heat.set_mode("on_target")
    count(desk)
    assert "recounting" not in desk.viewport.state.heatmap.note
    desk.drag("roof", (0.3, 0.0, 2.0))
    count(desk, 3)
    assert "recounting" in desk.viewport.state.heatmap.note
    count(desk)
    assert "recounting" not in desk.viewport.state.heatmap.note


def test_what_hides_objects_is_counted_while_a_heatmap_or_map_in_sight_shows_it(desk: FullDesk) -> None:
    count(desk)
    assert not desk.counter.requests[-1].with_losses
    desk.features.heat.set_mode("lost_traffic")
    assert desk.counter.requests[-1].with_losses and desk.viewport.state.heatmap is None
    count(desk)
    data = desk.viewport.state.heatmap
    losses = desk.features.targets.answer.counted.losses
    assert data.unit == "%" and data.note.startswith("less is better") and losses.traffic.any()
    over = LOST_BEHIND_TRAFFIC.over(desk.features.targets.answer.ground[0])
    assert np.array_equal(data.values, over.values[over.objects > 0].astype(np.float32))
    desk.features.heat.set_mode("seen")
    desk.drag("roof", (0.3, 0.0, 2.0))
    assert not desk.counter.requests[-1].with_losses


def test_other_traffic_takes_it_away(desk: FullDesk) -> None:
    desk.features.heat.set_mode("missed")
    count(desk)
    desk.load()
    assert desk.viewport.state.heatmap is None


def test_the_map_shows_road_users_and_goes_back(desk: FullDesk) -> None:
    panel = desk.features.map.panel
    combo = panel.findChild(QComboBox)
    assert combo is not None
    choose_item(combo, "on target")
    assert panel.map.message == COUNTING and panel.seen_by is None
    count(desk)
    ground = desk.features.targets.answer.ground[0]
    assert panel.map.message == "" and panel.map._ground.ground is ground
    assert panel.map._ground.heat is OF_TARGETS and panel.map.readout() == summary_of(panel.map._ground)
    choose_item(combo, "entropy seen by any sensor")
    assert panel.map._ground is None and panel.seen_by == "any"


@pytest.mark.parametrize("mode", ["on_target", "missed"])
def test_the_map_of_road_users_has_a_legend(desk: FullDesk, mode: str) -> None:
    count(desk)
    image = QImage(300, 30, QImage.Format.Format_RGB32)
    image.fill(QColor(LIGHT_TONES.panel))
    blank, painter = image.copy(), QPainter(image)
    over = heat_map_named(mode).over(desk.features.targets.answer.ground[0])
    draw_ground_legend(painter, QRectF(8.0, 4.0, 284.0, 22.0), over, LIGHT_TONES)
    painter.end()
    assert image != blank


def test_a_place_of_the_map_is_told_in_words(desk: FullDesk) -> None:
    count(desk)
    ground = desk.features.targets.answer.ground[0]
    means, missed = OF_TARGETS.over(ground), MISSED_OBJECTS.over(ground)
    ix, iy = (int(i) for i in np.argwhere(means.objects > 0)[0])
    place_m = (ground.origin_m[0] + ix + 0.5, ground.origin_m[1] + iy + 0.5)
    number = int(means.objects[ix, iy])
    assert f"% on target, mean of {number:,} within 2 m" in ground_text(means, place_m)
    assert f"of {number:,} within 2 m: missed objects" in ground_text(missed, place_m)
    assert ground_text(missed, (900.0, 0.0)) == "no car within 2 m"
