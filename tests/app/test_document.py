"""The document: one truth for gizmo, tree and inspector, with undo, selection, visibility and a file."""

from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from app.document import Document
from core.errors import InputError
from core.geometry import Pose
from core.rig.yaml_file import load_rig
from tests.app.window_bench import CAMERA, LIDAR, RIG


@pytest.fixture
def document(qtbot: QtBot) -> Document:
    return Document(RIG)


def test_a_drag_of_many_previews_is_one_undo_step(document: Document) -> None:
    document.begin_drag("roof")
    for step in range(1, 6):
        document.preview("roof", Pose((0.1, 0.2, 1.9 + step / 10)))
    document.finish_drag()
    assert document.rig.sensor("roof").position == (0.1, 0.2, 1.9 + 0.5)
    document.undo()
    assert document.rig == RIG
    document.redo()
    assert document.rig.sensor("roof").position == (0.1, 0.2, 1.9 + 0.5)


def test_a_cancelled_drag_leaves_the_rig_and_no_step(document: Document) -> None:
    document.begin_drag("roof")
    document.preview("roof", Pose((5.0, 0.0, 1.0)))
    document.cancel_drag()
    assert document.rig == RIG
    assert document.undo_label is None


def test_previews_count_only_for_the_sensor_that_is_dragged(document: Document) -> None:
    document.preview("roof", Pose((5.0, 0.0, 1.0)))
    document.begin_drag("roof")
    document.preview("front", Pose((5.0, 0.0, 1.0)))
    assert document.rig == RIG


def test_undo_in_the_middle_of_a_drag_gives_up_the_drag_only(document: Document) -> None:
    document.set_enabled("front", False)
    document.begin_drag("roof")
    document.preview("roof", Pose((5.0, 0.0, 1.0)))
    document.undo()
    assert document.rig.sensor("roof") == LIDAR
    assert not document.rig.sensor("front").enabled


def test_an_edit_in_the_middle_of_a_drag_gives_up_the_drag(document: Document) -> None:
    document.begin_drag("roof")
    document.preview("roof", Pose((5.0, 0.0, 1.0)))
    document.delete("front")
    assert document.rig.sensors == (LIDAR,)


def test_every_change_and_every_preview_has_its_own_revision(document: Document) -> None:
    revisions = [document.revision]
    document.rig_changed.connect(lambda: revisions.append(document.revision))
    document.begin_drag("roof")
    document.preview("roof", Pose((1.0, 0.0, 2.0)))
    document.finish_drag()
    document.undo()
    assert revisions == sorted(set(revisions))
    assert len(revisions) == 4


def test_a_renamed_sensor_stays_selected_and_hidden(document: Document) -> None:
    document.select("roof")
    document.set_hidden("roof", True)
    document.rename("roof", "top")
    assert (document.selected, document.hidden) == ("top", {"top"})
    document.undo()
    assert document.selected == "roof"


@pytest.mark.parametrize("name", ["front", " ", ""])
def test_a_name_that_is_taken_or_empty_is_refused(document: Document, name: str) -> None:
    with pytest.raises(InputError, match="name"):
        document.rename("roof", name)
    assert document.rig == RIG


def test_a_copy_gets_a_free_name_a_place_beside_and_the_selection(document: Document) -> None:
    assert document.duplicate("roof") == "roof_2"
    assert document.duplicate("roof_2") == "roof_3"
    assert document.selected == "roof_3"
    copy = document.rig.sensor("roof_2")
    assert copy.replace(name="roof", position=LIDAR.position) == LIDAR
    assert copy.position != LIDAR.position


def test_deleting_the_selection_clears_it_and_undo_brings_the_sensor_back(document: Document) -> None:
    document.select("front")
    document.delete("front")
    assert document.selected is None
    assert document.rig.sensors == (LIDAR,)
    document.undo()
    assert document.rig.sensors == (LIDAR, CAMERA)


def test_undoing_an_addition_clears_its_selection(document: Document) -> None:
    document.duplicate("front")
    document.undo()
    assert document.selected is None


def test_saving_and_opening_gives_back_the_rig_bit_for_bit(document: Document, tmp_path: Path) -> None:
    document.begin_drag("roof")
    document.preview("roof", Pose((0.1 + 0.2, -1 / 3, 1.9), (1e-17, 2 / 3, -179.99999999999997)))
    document.finish_drag()
    assert document.is_modified
    path = tmp_path / "rig.yaml"
    document.save(path)
    assert not document.is_modified
    assert document.saved_rig == document.rig
    other = Document(RIG)
    other.open(path)
    assert other.rig == document.rig
    assert load_rig(path).rig == document.rig


def test_saving_keeps_the_comments_of_the_file(document: Document, tmp_path: Path) -> None:
    path = tmp_path / "rig.yaml"
    document.save(path)
    path.write_text("# measured on Tuesday\n" + path.read_text())
    document.open(path)
    document.set_enabled("front", False)
    document.save(path)
    assert path.read_text().startswith("# measured on Tuesday\n")
    assert not load_rig(path).rig.sensor("front").enabled


def test_what_cannot_be_saved_or_opened_changes_nothing(document: Document, tmp_path: Path) -> None:
    document.set_enabled("front", False)
    with pytest.raises(InputError):
        document.save(tmp_path / "no folder" / "rig.yaml")
    assert document.is_modified
    bad = tmp_path / "bad.yaml"
    bad.write_text("sensors: [")
    with pytest.raises(InputError, match=r"bad\.yaml"):
        document.open(bad)
    assert not document.rig.sensor("front").enabled


def test_editing_back_to_the_saved_state_is_no_modification(document: Document) -> None:
    document.set_enabled("front", False)
    assert document.is_modified
    document.undo()
    assert not document.is_modified
