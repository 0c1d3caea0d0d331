"""The scene panel: an automatic voxel edge says what it picked and why, and a stored POG keeps its grid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtWidgets import QComboBox, QLabel, QLineEdit, QPushButton
from pytestqt.qtbot import QtBot

from riglens.app.window.features.scene_data import options_of
from riglens.core.scene.pog_store import save_pog
from riglens.evaluation.names import label_of
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import load_scenario
from riglens.evaluation.voxel_words import reason, tried_lines
from riglens.widgets.panels.controls.style import plain_tip
from riglens.widgets.panels.scene.scene_panel import SceneChoice
from tests.app.window_bench import Bench, choose_item, open_bench, scene_options, type_into
from tests.core.argoverse_log import random_columns, write_log
from tests.waiting import TIMEOUT_MS

SMALL_ROI_M = (8.0, 8.0, 4.0)


def voxel_box(bench: Bench) -> QComboBox:
    box = bench.panels.scene.findChild(QComboBox, "voxel_m")
    assert box is not None
    return box


def load(bench: Bench) -> None:
    button = bench.panels.scene.findChild(QPushButton, "load")
    assert button is not None
    scenes = len(bench.scenes)
    button.click()
    bench.qtbot.waitUntil(lambda: len(bench.scenes) > scenes, timeout=TIMEOUT_MS)
    bench.settle()


def test_auto_scores_on_the_edge_it_picked_and_says_why(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, roi_m=SMALL_ROI_M) as bench:
        panel = bench.panels.scene
        assert (panel._picked.text(), panel._picked.toolTip()) == ("", "")
        choose_item(voxel_box(bench), "Auto")
        load(bench)
        choice = bench.scenes[-1].choice
        assert choice is not None
        assert bench.scenes[-1].field.grid.voxel_m == choice.voxel_m
        assert f"δ {choice.voxel_m:g} m" in bench.workbench.status.scene.toolTip()
        sentence, table = (panel._picked.text(), panel._picked.toolTip())
        assert sentence.startswith(f"Auto picked {reason(choice)}")
        assert table == plain_tip("\n".join(tried_lines(choice)))
        assert voxel_box(bench).currentText() == "Auto"


def test_auto_goes_by_the_rig_as_it_is_when_load_is_pressed(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, roi_m=SMALL_ROI_M, voxel_m="auto", tolerance_pp=0.0) as bench:
        assert bench.scenes[0].field.grid.voxel_m == 0.05
        bench.document.apply(bench.document.rig.replace(sensors=()))
        load(bench)
        assert bench.scenes[1].field.grid.voxel_m == 0.4  # without sensors every edge says the same
        assert (bench.scenes[1].options.voxel_m, bench.scenes[1].options.tolerance_pp) == ("auto", 0.0)


def test_a_typed_edge_ends_auto(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, roi_m=SMALL_ROI_M, voxel_m="auto", tolerance_pp=100.0) as bench:
        line = voxel_box(bench).lineEdit()
        assert line is not None
        type_into(qtbot, line, "0.5")
        load(bench)
        assert bench.scenes[-1].field.grid.voxel_m == 0.5
        assert (bench.panels.scene._picked.text(), bench.panels.scene._picked.toolTip()) == ("", "")


def test_auto_needs_a_region_that_some_edge_divides(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, roi_m=(20.07, 20.07, 4.14), voxel_m=0.09) as bench:
        choose_item(voxel_box(bench), "Auto")
        assert "none of the edges" in bench.panels.scene.problem
        assert bench.panels.scene.choice.voxel_m == 0.09


def test_a_chosen_folder_brings_its_own_origin(qtbot: QtBot, tmp_path: Path) -> None:
    write_log(tmp_path / "logs" / "one", random_columns(3, 20))
    with open_bench(qtbot, tmp_path, roi_m=SMALL_ROI_M) as bench:
        bench.dialogs.path = tmp_path / "logs"
        bench.act("boxes_folder")
        assert bench.panels.scene.choice.origin_m == (-1.34, 0.0, 0.33)
        load(bench)
        assert bench.scenes[-1].field.data.frames == 3
        assert bench.panels.scene.choice.origin_m == (-1.34, 0.0, 0.33)


def test_a_folder_without_boxes_is_refused_at_once(qtbot: QtBot, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with open_bench(qtbot, tmp_path, roi_m=SMALL_ROI_M) as bench:
        before = bench.panels.scene.choice
        bench.dialogs.path = tmp_path / "empty"
        bench.act("boxes_folder")
        assert "no box data in this folder" in bench.workbench.errors.message
        assert bench.panels.scene.choice == before


def test_a_ground_off_zero_is_shown_and_mended_with_one_click(qtbot: QtBot, tmp_path: Path) -> None:
    cars = "".join(f"s,{n},car,{4 + n % 4},{n % 7 - 3},-0.9,4.5,1.9,1.6,0.{n}\n" for n in range(1, 41))
    (tmp_path / "low.csv").write_text(
        f"seq,frame,cls,x,y,z,length,width,height,yaw\n{cars}", encoding="utf-8"
    )
    with open_bench(qtbot, tmp_path, boxes=tmp_path / "low.csv", roi_m=SMALL_ROI_M) as bench:
        notes, status = bench.workbench.notes, bench.workbench.status
        assert "low.csv" in notes.message and "-1.7" in notes.message and "0 0 1.7" in notes.message
        assert "-1.7" in status.doubts.text() and not status.doubts.isHidden()
        (mend,) = notes.findChildren(QPushButton, label_of("find_ground"))
        scenes = len(bench.scenes)
        mend.click()
        qtbot.waitUntil(lambda: len(bench.scenes) > scenes, timeout=TIMEOUT_MS)
        bench.settle()
        assert bench.scenes[-1].field.index.count > bench.scenes[0].field.index.count
        assert notes.message == "" and status.doubts.isHidden()


@pytest.fixture
def stored(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    """A window on a stored POG of 0.5 m."""
    path = tmp_path / "stored.npz"
    save_pog(load_scenario(scene_options(tmp_path)).pog, path)
    with open_bench(qtbot, tmp_path, boxes=None, voxel_m=None, roi_m=None, pog=path) as bench:
        yield bench


def test_a_stored_pog_is_shown_with_its_name_and_its_grid(stored: Bench) -> None:
    name = stored.panels.scene.findChild(QLabel, "boxes")
    assert name is not None
    assert name.text() == "stored.npz"
    assert voxel_box(stored).currentText() == "0.5"
    assert stored.panels.scene.choice.roi_m == (20.0, 20.0, 4.0)
    assert "stored.npz" in name.toolTip()
    stored.panels.scene.show_subject(stored.panels.scene.choice.replace(pog=None))
    assert name.text() == "Bundled town" and "bundled simulated town" in name.toolTip()


def test_what_a_stored_pog_fixes_is_refused_and_nothing_is_loaded(stored: Bench) -> None:
    for field, text in [("voxel", "0.25"), ("voxel", "Auto"), ("frames", "9"), ("L", "40")]:
        panel = stored.panels.scene
        before = panel.choice
        names = {"frames": "frames", "L": "roi_m.L"}
        line = voxel_box(stored).lineEdit() if field == "voxel" else panel.findChild(QLineEdit, names[field])
        assert line is not None
        allowed = line.text()
        type_into(stored.qtbot, line, text)
        assert "stored.npz is a stored POG with voxels of 0.5 m" in panel.problem
        assert panel.choice == before
        button = panel.findChild(QPushButton, "load")
        assert button is not None
        assert not button.isEnabled()
        type_into(stored.qtbot, line, allowed)
        assert panel.problem == ""


def test_other_boxes_take_the_place_of_a_stored_pog(stored: Bench, tmp_path: Path) -> None:
    stored.dialogs.path = tmp_path / "boxes.csv"
    stored.act("boxes_file")
    line = voxel_box(stored).lineEdit()
    assert line is not None
    type_into(stored.qtbot, line, "1.0")
    load(stored)
    assert stored.scenes[-1].options.pog is None
    assert stored.scenes[-1].field.grid.voxel_m == 1.0


def test_options_that_the_panel_does_not_show_stay_with_their_data_set() -> None:
    boxes = Path("boxes.csv")
    occluders = (Path("occluders.csv"), Path("poses.csv"))
    before = SceneOptions(
        boxes, classes=("tram=car",), find_ground=True, surroundings=True, occluders=occluders
    )
    choice = SceneChoice(boxes, find_ground=True, voxel_m=0.2)
    assert options_of(choice, before) == replace(before, voxel_m=0.2, roi_m=choice.roi_m)
    other = SceneChoice(Path("other.csv"), voxel_m=0.2)
    assert options_of(other, before) == SceneOptions(other.boxes, voxel_m=0.2, roi_m=other.roi_m)
