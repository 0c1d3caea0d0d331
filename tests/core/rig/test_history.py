"""Undo and redo: a drag is one step, previews leave no trace, a new edit ends what could be redone."""

import pytest

from riglens.core.geometry import Pose
from riglens.core.rig.history import History, differences_in_words
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset

START = preset("W+T")


def moved(rig: Rig, x_m: float, name: str = "LIDAR_1") -> Rig:
    return rig.with_sensor(name, rig.sensor(name).with_pose(Pose((x_m, 0.0, 2.2))))


def test_a_new_history_is_unmodified_and_has_nothing_to_undo() -> None:
    history = History(START)
    assert history.rig is START
    assert not (history.is_modified or history.undo_label or history.redo_label or history.is_dragging)
    assert not history.undo() and not history.redo() and not history.commit() and not history.cancel()
    assert history.rig is START


def test_drag_undo_redo_drag() -> None:
    history = History(START)
    history.begin("Move LIDAR_1")
    for x_m in (0.1, 0.2, 0.3):
        history.preview(moved(START, x_m))
        assert history.rig == moved(START, x_m) and history.committed is START
    assert history.commit()
    assert history.undo_label == "Move LIDAR_1"
    assert history.undo() and history.rig == START and history.redo_label == "Move LIDAR_1"
    assert history.redo() and history.rig == moved(START, 0.3) and not history.redo_label
    assert history.undo()
    history.begin("Move LIDAR_1 again")
    history.preview(moved(START, 0.9))
    assert history.commit()
    assert not history.redo_label
    assert history.undo() and history.rig == START and not history.undo_label


def test_a_new_edit_ends_what_could_be_redone() -> None:
    history = History(START)
    history.apply("one", moved(START, 1.0))
    history.apply("two", moved(START, 2.0))
    history.undo()
    history.apply("three", moved(START, 3.0))
    assert not history.redo_label and not history.redo()
    labels = []
    while history.undo_label:
        labels.append(history.undo_label)
        history.undo()
    assert labels == ["three", "one"]


@pytest.mark.parametrize("key", ["undo", "redo"])
def test_undo_or_redo_during_a_drag_only_cancels_it(key: str) -> None:
    history = History(START)
    history.apply("one", moved(START, 1.0))
    history.apply("two", moved(START, 2.0))
    history.undo()
    history.begin("drag")
    history.preview(moved(START, 5.0))
    assert getattr(history, key)()
    assert history.rig == moved(START, 1.0) and not history.is_dragging
    assert (history.undo_label, history.redo_label) == ("one", "two")


def test_a_cancelled_drag_leaves_no_step_and_keeps_redo() -> None:
    history = History(START)
    history.apply("one", moved(START, 1.0))
    history.undo()
    history.begin("drag")
    history.preview(moved(START, 5.0))
    assert history.is_modified
    assert history.cancel()
    assert history.rig is START and not history.is_modified and history.redo_label == "one"


def test_a_drag_that_goes_nowhere_is_no_step() -> None:
    history = History(START)
    history.begin("drag")
    assert not history.commit()
    history.begin("drag")
    history.preview(moved(START, 1.0))
    history.preview(START)
    assert not history.commit()
    assert not history.undo_label and not history.apply("same", preset("W+T"))


def test_an_edit_during_a_drag_commits_the_drag_first() -> None:
    history = History(START)
    history.begin("drag")
    history.preview(moved(START, 1.0))
    history.apply("rename", history.rig.replace(name="other"))
    assert history.undo() and history.rig == moved(START, 1.0)
    assert history.undo() and history.rig == START


def test_a_preview_outside_a_drag_is_a_mistake() -> None:
    with pytest.raises(RuntimeError):
        History(START).preview(START)


def test_modified_follows_the_saved_state_through_undo_and_redo() -> None:
    history = History(START)
    history.apply("one", moved(START, 1.0))
    assert history.is_modified and history.saved is START
    history.mark_saved()
    assert not history.is_modified and history.saved == moved(START, 1.0)
    history.undo()
    assert history.is_modified
    history.redo()
    assert not history.is_modified
    history.apply("two", moved(START, 2.0))
    history.apply("back by hand", moved(START, 1.0))
    assert not history.is_modified and history.undo_label


def test_a_negative_zero_is_a_modification() -> None:
    history = History(moved(START, 0.0))
    assert history.apply("sign", moved(START, -0.0)) and history.is_modified


def test_a_step_that_goes_on_takes_the_place_of_the_one_before() -> None:
    history = History(START)
    history.apply("one", moved(START, 1.0))
    assert history.apply("one", moved(START, 2.0), continues=True)
    assert history.rig == moved(START, 2.0)
    assert history.undo() and history.rig == START and not history.undo_label


def test_a_step_that_leads_back_to_its_start_is_no_step() -> None:
    history = History(START)
    history.apply("one", moved(START, 1.0))
    assert history.apply("one", START, continues=True)
    assert history.rig == START and not history.undo_label


def test_the_rig_on_the_disk_stays_a_step_of_its_own() -> None:
    history = History(START)
    history.apply("one", moved(START, 1.0))
    history.mark_saved()
    history.apply("one", moved(START, 2.0), continues=True)
    assert history.undo() and history.rig == moved(START, 1.0) and not history.is_modified
    history.apply("one", moved(START, 3.0), continues=True)
    assert history.undo() and history.rig == moved(START, 1.0)


def test_the_differences_of_two_rigs_are_in_words_sensor_by_sensor() -> None:
    before = preset("nuScenes car")
    top, rear = before.sensor("LIDAR_TOP"), before.sensor("CAM_BACK")
    x, y, z = top.position
    turned = rear.replace(rpy_deg=(rear.rpy_deg[0], rear.rpy_deg[1] + 5.0, rear.rpy_deg[2]), enabled=False)
    gone = before.with_sensor("LIDAR_TOP", top.replace(position=(x, y, z + 0.2)))
    after = gone.with_sensor("CAM_BACK", turned)
    without = after.replace(
        sensors=(*(one for one in after.sensors if one.name != "CAM_FRONT"), top.replace(name="second"))
    )
    assert (
        differences_in_words(before, before) == differences_in_words(before, before.replace(name="b")) == ()
    )
    assert set(differences_in_words(before, without)) == {
        "CAM_FRONT removed",
        "second added",
        "LIDAR_TOP moved 0.20 m higher",
        "CAM_BACK turned: pitch +5.0° and switched off",
    }
    longer = before.replace(vehicle=before.vehicle.replace(length=5.0))
    assert differences_in_words(before, longer) == ("vehicle changed",)
