"""Map and sensor view in the window: they follow rig, selection, class and scene, and cost nothing out of sight."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

from riglens.app.window.settings import Settings
from riglens.core.blind.zones import OVERLAP_HEIGHT_M, BlindEngine, BlindSettings
from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import covered_at_least
from riglens.core.figures.lowest_heights import LowestHeight
from riglens.core.geometry import Pose
from riglens.core.rig.model import Vehicle
from riglens.core.scene.columns import pack, unpack
from riglens.core.scene.pog_store import save_pog
from riglens.core.view.camera_picture import CameraPicture
from riglens.core.view.range_image import RangeImage
from riglens.core.view.top_view import SeenBy, TopView
from riglens.core.view.top_views import TopViews
from riglens.evaluation.scenario import load_scenario
from riglens.widgets.maps.lowest_items import Lowest, lowest_colours, lowest_text
from riglens.widgets.maps.paint import argb
from riglens.widgets.theme import OVERLAP_COLOURS
from riglens.widgets.viewport.ground_map import NOTHING
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import Bench, open_bench, scene_options
from tests.waiting import TIMEOUT_MS
from tests.widgets.mouse import hover


def look_at(bench: Bench, dock: str) -> None:
    """Bring a dock to the front, as a click on its tab does."""
    bench.workbench.docks[dock].show()
    bench.workbench.docks[dock].raise_()
    bench.qtbot.waitUntil(lambda: bench.workbench.docks[dock].widget().isVisible(), timeout=TIMEOUT_MS)


@pytest.fixture(scope="module")
def at_work(file_window: Bench) -> None:
    """Begin the threads of map and sensor view, which end with the window."""
    file_window.document.select("front")
    for dock in ("Map", "Sensor view"):
        look_at(file_window, dock)
        file_window.settle()


@pytest.fixture
def bench(at_work: None, whole: Bench) -> Bench:
    whole.features.map.panel.choose("any")
    whole.features.sensor_view.panel.frame.setValue(0)
    return whole


def shown_map(bench: Bench) -> TopView:
    """The map once it is up to date."""
    look_at(bench, "Map")
    bench.settle()
    result = bench.workbench.answers.result
    assert result is not None and result.top_view is not None
    assert bench.features.map.panel.map._top is result.top_view
    return result.top_view


def expected_map(bench: Bench, cls: int, seen_by: SeenBy) -> TopView:
    """The map of the document's rig, made from scratch."""
    field = bench.scenes[-1].field
    engine, rig = Engine(field, 1), bench.document.rig
    evaluation = engine.evaluate(rig)
    camera, lidar = evaluation.seen["camera"], evaluation.seen["lidar"]
    counts = sum(
        unpack(field.grid, np.array(engine.marks_of(sensor, "exact")) & field.index.words).astype(int)
        for sensor in rig.sensors
    )
    seen = {
        "any": camera | lidar, "camera": camera, "lidar": lidar, "kinds": camera & lidar,
        "twice": pack(field.grid, np.asarray(counts >= 2)), "thrice": pack(field.grid, np.asarray(counts >= 3)),
    }[seen_by]  # fmt: skip
    return TopViews(field).view(cls, "", seen_by, seen)


def picture(bench: Bench) -> CameraPicture | RangeImage:
    """What the sensor view shows once it is up to date."""
    look_at(bench, "Sensor view")
    feature = bench.features.sensor_view
    bench.qtbot.waitUntil(lambda: feature.is_current, timeout=TIMEOUT_MS)
    panel = feature.panel
    found = panel.camera._picture if panel.page is panel.camera else panel.ranges._image
    assert panel.page is not panel.text, panel.text.text()
    assert found is not None
    return found


def test_out_of_sight_no_map_is_made(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.drag("roof", (0.5, 0.0, 1.9))
        bench.settle()
        result = bench.workbench.answers.result
        assert result is not None and result.top_view is None
        assert not bench.features.sensor_view.pictures._thread.is_started


def test_a_panel_pulled_out_of_the_window_is_in_sight(bench: Bench) -> None:
    bench.document.select("front")
    for name in ("Map", "Sensor view"):
        dock = bench.workbench.docks[name]
        assert not dock.isFloating()
        dock.setFloating(True)
        dock.show()
    bench.qtbot.waitUntil(lambda: bool(bench.features.map.in_sight), timeout=TIMEOUT_MS)
    bench.settle()
    result = bench.workbench.answers.result
    assert result is not None and result.top_view is not None
    feature = bench.features.sensor_view
    bench.qtbot.waitUntil(lambda: feature.panel.page is feature.panel.camera, timeout=TIMEOUT_MS)


def test_the_map_follows_every_edit_exactly(bench: Bench) -> None:
    np.testing.assert_array_equal(shown_map(bench).seen, expected_map(bench, 0, "any").seen)
    bench.drag("roof", (0.5, 0.0, 1.9), (-0.7, 0.3, 2.5))
    np.testing.assert_array_equal(shown_map(bench).seen, expected_map(bench, 0, "any").seen)
    bench.act("undo")
    np.testing.assert_array_equal(shown_map(bench).seen, expected_map(bench, 0, "any").seen)


def test_the_map_shows_the_class_and_the_sensors_that_are_chosen(bench: Bench) -> None:
    panel = bench.features.map.panel
    shown_map(bench)
    bench.features.heat.set_class("pedestrian")
    assert shown_map(bench).class_name == "pedestrian"
    assert panel.title.text() == "Pedestrian,"
    for seen_by in ("lidar", "camera", "twice", "thrice", "kinds"):
        place = panel.choice.findData(seen_by)
        panel.choice.setCurrentIndex(place)
        panel.choice.activated.emit(place)
        np.testing.assert_array_equal(shown_map(bench).levels, expected_map(bench, 2, seen_by).levels)  # type: ignore[arg-type]


def test_the_map_shows_the_lowest_heights_of_the_command_and_follows_an_edit(bench: Bench) -> None:
    """Of the kind and number that are chosen, over all ground that counts, without a class; then the share again."""
    panel = bench.features.map.panel
    shown_map(bench)
    bench.settle()
    assert bench.workbench.answers.result.blind is None
    assert np.array_equal(panel.map.plane.to_m(panel.map.plane.area.center()), (0.0, 0.0))
    for number, (by, k) in enumerate((("any", 1), ("lidar", 2)), 1):
        place = panel.choice.findData(LowestHeight(by, k).key)
        panel.choice.setCurrentIndex(place)
        panel.choice.activated.emit(place)
        bench.drag("roof", (0.5 + 0.3 * number, 0.0, 2.4))
        bench.settle()
        lowest = panel.map._lowest
        assert (lowest.by, lowest.k) == panel.lowest == (by, k) and panel.seen_by is None
        rig = bench.document.rig
        fresh = BlindEngine(rig.vehicle, BlindSettings(body=bench.session.body)).evaluate(rig)
        np.testing.assert_array_equal(lowest.found.levels, fresh.levels)
        assert panel.title.text() == "" and panel.map.message == ""
    place_px = panel.map.plane.to_px(8.0, 3.0)
    hover(panel.map, place_px.toPoint())
    assert panel.map.readout().endswith(lowest_text(lowest, panel.map.plane.to_m(panel.map._hover)))
    assert "m" in panel.map.readout().split("LiDARs")[1]
    panel.choice.setCurrentIndex(0)
    panel.choice.activated.emit(0)
    bench.settle()
    assert panel.map._lowest is None and panel.title.text() == "Car,"
    assert not bench.session.request().blind


def test_a_heatmap_of_redundancy_brings_the_voxels_that_it_shows(bench: Bench) -> None:
    bench.features.heat.set_mode("twice")
    bench.settle()
    result = bench.workbench.answers.result
    engine = Engine(result.scene.field, 1)
    engine.evaluate(bench.document.rig, bench.session.settings)
    twice = covered_at_least(engine, bench.document.rig, "exact")[1]
    assert twice.any()
    np.testing.assert_array_equal(result.marks.seen, twice)


def test_a_click_on_the_map_selects_a_sensor_or_turns_the_view_there(bench: Bench) -> None:
    shown_map(bench)
    view = bench.features.map.panel.map
    x, y, _ = bench.document.rig.sensor("front").position
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=view.plane.to_px(x, y).toPoint())
    assert bench.document.selected == "front"
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=view.plane.to_px(6.0, -5.0).toPoint())
    name, x, y = bench.viewport.told[-1]
    assert name == "look"
    assert (x, y) == pytest.approx((6.0, -5.0), abs=0.2)


def test_the_sensor_view_shows_the_selected_sensor(bench: Bench) -> None:
    bench.document.select("front")
    shown = picture(bench)
    assert isinstance(shown, CameraPicture) and shown.camera.name == "front"
    assert shown.boxes_seen == {"car": 1, "bicycle": 0, "pedestrian": 0}  # the bicycle is far to the right
    bench.document.select("roof")
    shown = picture(bench)
    assert isinstance(shown, RangeImage) and shown.range_m.shape == (8, 36)
    assert (shown.what >= 0).any()


def test_the_sensor_view_follows_a_drag(bench: Bench) -> None:
    bench.document.select("front")
    before = picture(bench)
    bench.viewport.press("front")
    bench.viewport.drag_to("front", Pose((1.0, 0.0, 1.4), (0.0, 0.0, 180.0)))
    during = picture(bench)
    bench.viewport.release("front")
    assert isinstance(before, CameraPicture) and isinstance(during, CameraPicture)
    assert during.camera.rpy_deg == (0.0, 0.0, 180.0)
    assert during.boxes_seen != before.boxes_seen


def test_the_frame_is_kept_when_another_sensor_is_selected(bench: Bench) -> None:
    bench.document.select("front")
    picture(bench)
    panel = bench.features.sensor_view.panel
    assert panel.frame.maximum() == 2
    panel.frame.setValue(1)
    shown = picture(bench)
    assert isinstance(shown, CameraPicture) and shown.boxes_seen["car"] == 0  # it stands behind
    bench.document.select("roof")
    picture(bench)
    assert panel.chosen_frame == 1


def test_the_car_itself_is_in_the_picture(bench: Bench) -> None:
    bench.document.select("front")
    bench.viewport.press("front")
    bench.viewport.drag_to("front", Pose((0.0, 0.0, 2.5), (0.0, 60.0, 0.0)))
    bench.viewport.release("front")
    shown = picture(bench)
    assert isinstance(shown, CameraPicture)
    assert shown.body_share > 0.3
    vehicle = Vehicle(length=1.0, width=0.4, height=0.4, rear_axle_x=-0.3)
    bench.document.apply(bench.document.rig.replace(vehicle=vehicle))
    smaller = picture(bench)
    assert isinstance(smaller, CameraPicture)
    assert smaller.body_share < 0.5 * shown.body_share


def test_a_stored_pog_has_no_boxes_to_show_and_says_so(qtbot: QtBot, tmp_path: Path) -> None:
    path = tmp_path / "small.pog"
    save_pog(load_scenario(scene_options(tmp_path)).pog, path)
    with open_bench(qtbot, tmp_path, boxes=None, voxel_m=None, roi_m=None, pog=path) as bench:
        bench.document.select("front")
        shown = picture(bench)
        panel = bench.features.sensor_view.panel
        assert isinstance(shown, CameraPicture) and not shown.faces
        assert "stored POG holds no boxes" in panel.note.text() and panel.note.isVisible()
        assert not panel.frame.isEnabled()


def test_a_switched_off_sensor_is_shown_and_said_not_to_count(bench: Bench) -> None:
    bench.document.select("front")
    bench.document.set_enabled(("front",), False)
    picture(bench)
    assert "not included" in bench.features.sensor_view.panel.note.text()


def test_another_data_set_brings_its_own_frames(bench: Bench, tmp_path: Path) -> None:
    bench.document.select("front")
    picture(bench)
    other = tmp_path / "other.csv"
    other.write_text(
        "seq,frame,cls,x,y,z,length,width,height,yaw\n"
        + "".join(f"s,{n},pedestrian,8,0,0.9,0.6,0.6,1.8,0\n" for n in range(9)),
        encoding="utf-8",
    )
    bench.features.scene_data.load(scene_options(tmp_path, boxes=other))
    bench.settle()
    bench.qtbot.waitUntil(lambda: bench.scenes[-1].options.boxes == other, timeout=TIMEOUT_MS)
    shown = picture(bench)
    assert isinstance(shown, CameraPicture)
    assert shown.boxes_seen == {"car": 0, "bicycle": 0, "pedestrian": 1}
    assert bench.features.sensor_view.panel.frame.maximum() == 8


def test_moving_another_sensor_makes_no_new_picture(bench: Bench) -> None:
    bench.document.select("front")
    before = picture(bench)
    roof = bench.document.rig.sensor("roof")
    bench.document.replace_sensor("roof", roof.replace(position=(0.4, 0.0, 2.0)))
    assert picture(bench) is before
    front = bench.document.rig.sensor("front")
    bench.document.replace_sensor("front", front.replace(position=(0.4, 0.0, 1.5)))
    assert picture(bench) is not before


def test_the_sensor_view_says_that_its_sensor_is_taken_as_failed(bench: Bench) -> None:
    bench.document.select("roof")
    picture(bench)
    note = bench.features.sensor_view.panel.note
    assert "failed" not in note.text()
    bench.document.set_failed(("roof",), True)
    assert "Failed" in note.text() and note.isVisible()
    bench.document.set_failed(("roof",), False)
    assert "failed" not in note.text()


def test_what_the_map_shows_is_kept_for_the_next_session(qtbot: QtBot) -> None:
    kept = Settings()
    with full_desk(qtbot, kept=kept) as desk:
        desk.features.map.panel.choose("lowest_2_camera")
        desk.features.map.keep(kept)
    with full_desk(qtbot, kept=kept) as again:
        assert again.features.map.panel.lowest == ("camera", 2)
        kept.write("map/shown", "nonsense")
        again.features.map.restore(kept)
        assert again.features.map.panel.lowest == ("camera", 2)


COARSE = BlindSettings(0.5, within_m=5.0)


@pytest.fixture
def scored(qtbot: QtBot) -> Iterator[FullDesk]:
    with full_desk(qtbot) as opened:
        opened.load()
        opened.answer()
        yield opened


@pytest.mark.parametrize("shown", ["lowest_1_any", "lowest_2_lidar", "overlap"])
def test_what_lies_on_the_ground_is_what_the_map_shows_and_follows_answers(
    scored: FullDesk, shown: str
) -> None:
    panel = scored.features.map.panel
    assert not scored.recompute.requests[-1].blind and panel.on_ground.isHidden()
    panel.choose(shown)
    assert not panel.on_ground.isHidden() and not scored.session.request().blind
    panel.on_ground.setChecked(True)
    assert scored.recompute.requests[-1].blind and scored.viewport.state.ground_map is None
    for place in ((0.0, 0.0, 2.0), (1.0, 0.5, 3.0)):
        scored.drag("roof", place)
        found = BlindEngine(scored.document.rig.vehicle, COARSE, threads=1).evaluate(scored.document.rig)
        scored.answer(blind=found)
        ground = scored.viewport.state.ground_map
        assert ground is not None and panel.lowest is not None
        by, k = panel.lowest
        seen = [found.lowest_m(by, number) <= OVERLAP_HEIGHT_M + 1e-9 for number in (1, 2, 3)]
        wanted = found.steps(by, k) if k else np.sum(seen, axis=0)
        np.testing.assert_array_equal(ground.steps, np.where(found.ground.counts, wanted, NOTHING))
        assert ground.steps[ground.steps != NOTHING].max() < len(ground.meanings)
        assert "is better" in ground.title
    panel.choose("any")
    assert scored.viewport.state.ground_map is None and not scored.session.request().blind


def test_the_overlap_is_on_the_map_with_its_own_colours_and_words(scored: FullDesk) -> None:
    found = BlindEngine(scored.document.rig.vehicle, COARSE, threads=1).evaluate(scored.document.rig)
    shown = Lowest(found, "any", 0)
    colours = set(np.unique(lowest_colours(shown))) & {int(argb(colour)) for colour in OVERLAP_COLOURS}
    assert colours == {
        int(argb(OVERLAP_COLOURS[step])) for step in np.unique(shown.steps[found.ground.counts])
    }
    assert "sensors see an object 0.80 m tall" in lowest_text(shown, (4.0, 0.0))


def test_what_lies_on_the_ground_is_kept(qtbot: QtBot) -> None:
    kept = Settings()
    with full_desk(qtbot, kept=kept) as desk:
        desk.features.map.panel.choose("overlap")
        desk.features.map.panel.on_ground.setChecked(True)
        desk.features.map.keep(kept)
    with full_desk(qtbot, kept=kept) as again:
        assert again.features.map.panel.ground == ("any", 0) and again.recompute.requests[-1].blind
