"""The document: one truth for gizmo, tree and inspector, with undo, selection, visibility and a file."""

from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from riglens.app.session.document import MERGE_S, Document
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.edits import linked
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import load_rig
from tests.app.window_bench import CAMERA, LIDAR, RIG


@pytest.fixture
def document(qtbot: QtBot) -> Document:
    return Document(RIG)


def test_a_drag_of_many_previews_is_one_undo_step(document: Document) -> None:
    document.begin_drag(("roof",))
    for step in range(1, 6):
        document.preview({"roof": Pose((0.1, 0.2, 1.9 + step / 10))})
    document.finish_drag()
    assert document.rig.sensor("roof").position == (0.1, 0.2, 1.9 + 0.5)
    document.undo()
    assert document.rig == RIG
    document.redo()
    assert document.rig.sensor("roof").position == (0.1, 0.2, 1.9 + 0.5)


def test_previews_count_only_for_the_sensor_that_is_dragged(document: Document) -> None:
    document.preview({"roof": Pose((5.0, 0.0, 1.0))})
    document.begin_drag(("roof",))
    document.preview({"front": Pose((5.0, 0.0, 1.0))})
    assert document.rig == RIG


def test_an_edit_in_the_middle_of_a_drag_gives_up_the_drag(document: Document) -> None:
    document.begin_drag(("roof",))
    document.preview({"roof": Pose((5.0, 0.0, 1.0))})
    document.delete(("front",))
    assert document.rig.sensors == (LIDAR,)


def test_every_change_and_every_preview_has_its_own_revision(document: Document) -> None:
    revisions = [document.revision]
    document.rig_changed.connect(lambda: revisions.append(document.revision))
    document.begin_drag(("roof",))
    document.preview({"roof": Pose((1.0, 0.0, 2.0))})
    document.finish_drag()
    document.undo()
    assert revisions == sorted(set(revisions))
    assert len(revisions) == 4


def test_a_renamed_sensor_stays_selected_and_hidden(document: Document) -> None:
    document.select("roof")
    document.set_hidden(("roof",), True)
    document.rename("roof", "top")
    assert (document.selected, document.hidden) == ("top", {"top"})
    document.undo()
    assert (document.selected, document.hidden) == ("roof", {"roof"})


@pytest.mark.parametrize("mark", ["hidden", "locked"])
def test_hiding_and_locking_are_steps_that_change_no_rig(document: Document, mark: str) -> None:
    told: list[frozenset[str]] = []
    getattr(document, f"{mark}_changed").connect(lambda: told.append(getattr(document, mark)))
    labels = [document.undo_label]
    document.steps_changed.connect(lambda: labels.append(document.undo_label))
    set_mark = getattr(document, f"set_{mark}")
    set_mark(("roof", "front"), True)
    set_mark(("roof", "front"), True)  # nothing new, no step
    set_mark(("front",), False)
    assert not document.is_modified
    assert labels[-1] == document.undo_label
    document.undo()
    document.undo()
    assert document.undo_label is None
    document.redo()
    both: frozenset[str] = frozenset({"roof", "front"})
    assert told == [both, {"roof"}, both, frozenset(), both]


def test_what_was_hidden_comes_back_hidden_when_its_deletion_is_undone(document: Document) -> None:
    document.set_hidden(("roof",), True)
    document.delete(("roof",))
    document.set_hidden(("front",), True)
    document.undo()
    document.undo()
    assert document.hidden == {"roof"}
    assert document.undo_label == "hide roof"


def test_a_nudge_after_hiding_is_a_step_of_its_own(document: Document) -> None:
    document.replace_sensor("roof", LIDAR.replace(position=(1.0, 0.0, 2.0)))
    document.set_hidden(("front",), True)
    document.replace_sensor("roof", LIDAR.replace(position=(1.1, 0.0, 2.0)))
    document.undo()
    assert document.rig.sensor("roof").position == (1.0, 0.0, 2.0)
    assert document.hidden == {"front"}


def test_locks_of_an_earlier_session_are_not_a_step(document: Document) -> None:
    document.keep_locked(("roof",))
    assert document.locked == {"roof"}
    assert document.undo_label is None


def test_a_copy_gets_a_free_name_a_place_beside_and_the_selection(document: Document) -> None:
    assert document.duplicate(("roof",)) == ("roof_2",)
    assert document.duplicate(("roof_2",)) == ("roof_3",)
    assert document.selected == "roof_3"
    copy = document.rig.sensor("roof_2")
    assert copy.replace(name="roof", position=LIDAR.position) == LIDAR
    assert copy.position != LIDAR.position


def test_deleting_the_selection_clears_it_and_undo_brings_the_sensor_back(document: Document) -> None:
    document.select("front")
    document.delete(("front",))
    assert document.selected is None
    assert document.rig.sensors == (LIDAR,)
    document.undo()
    assert document.rig.sensors == (LIDAR, CAMERA)


def test_undoing_an_addition_clears_its_selection(document: Document) -> None:
    document.duplicate(("front",))
    document.undo()
    assert document.selected is None


# ---------------------------------------------------------------------- several selected
TEN = Rig(sensors=tuple(LIDAR.replace(name=f"l{place}", position=(place, 1.0, 2.0)) for place in range(10)))


@pytest.fixture
def ten() -> Document:
    return Document(TEN)


def test_selecting_one_ends_a_selection_of_several(ten: Document) -> None:
    ten.choose_all()
    assert ten.chosen == tuple(sensor.name for sensor in TEN.sensors)
    ten.select("l2")
    assert (ten.selection, ten.chosen) == (("l2",), ("l2",))


def test_the_last_of_several_is_the_current_one_and_selecting_all_keeps_it(ten: Document) -> None:
    ten.choose(("l5", "l1", "nobody", "l3", "l1"))
    assert (ten.selection, ten.selected) == (("l5", "l1", "l3"), "l3")
    assert ten.chosen == ("l1", "l3", "l5")
    ten.toggle_selected("l3")
    assert (ten.selection, ten.selected) == (("l5", "l1"), "l1")
    ten.choose_all()
    assert (len(ten.selection), ten.selected) == (10, "l1")
    ten.choose(("l5", "l1"))
    ten.choose_more(("l5", "l2"))
    assert ten.selection == ("l1", "l5", "l2")
    ten.choose_fewer(("l5", "l9"))
    assert ten.selection == ("l1", "l2")


def test_a_selection_is_told_of_once_and_only_when_it_changes(ten: Document) -> None:
    told: list[tuple[str, ...]] = []
    ten.selection_changed.connect(lambda: told.append(ten.selection))
    ten.choose(("l1", "l2"))
    ten.choose(("l1", "l2"))
    ten.toggle_selected("l4")
    ten.delete(("l2",))
    ten.rename("l1", "first")
    assert told == [("l1", "l2"), ("l1", "l2", "l4"), ("l1", "l4"), ("first", "l4")]


def test_undo_and_redo_keep_a_selection_of_several(ten: Document) -> None:
    ten.choose(("l1", "l7", "l4"))
    ten.set_enabled(ten.chosen, False)
    ten.rename("l7", "seventh")
    for step, names in ((ten.undo, "l7"), (ten.undo, "l7"), (ten.redo, "l7"), (ten.redo, "seventh")):
        step()
        assert ten.selection == ("l1", names, "l4")
    ten.delete(("l4",))
    assert ten.selection == ("l1", "seventh")
    ten.undo()
    assert ten.selection == ("l1", "seventh")


def test_what_undo_brings_back_is_selected_when_nothing_else_is(ten: Document) -> None:
    ten.choose_all()
    ten.delete(ten.chosen)
    assert ten.selection == ()
    ten.undo()
    assert ten.chosen == tuple(sensor.name for sensor in TEN.sensors)


def test_redoing_a_deletion_selects_no_sensor_that_was_not_selected(ten: Document) -> None:
    ten.delete(("l2",))
    ten.undo()
    ten.select("l2")
    ten.redo()
    assert ten.selection == ()


def test_a_rig_without_the_selected_sensors_takes_them_out_of_the_selection(ten: Document) -> None:
    ten.choose(("l1", "l7"))
    seen: list[tuple[str, ...]] = []
    ten.rig_changed.connect(lambda: seen.append(ten.selection))
    ten.apply(TEN.replace(sensors=TEN.sensors[:5]), "restore a rig")
    assert ten.selection == ("l1",)
    assert seen == [("l1",)]  # nobody is told of a rig without them while they are selected


def test_copies_of_several_are_selected(ten: Document) -> None:
    ten.choose(("l3", "l1"))
    assert ten.duplicate(ten.chosen) == ten.selection
    assert len(ten.selection) == 2 and not {"l1", "l3"} & set(ten.selection)


def test_saving_keeps_the_comments_of_the_file(document: Document, tmp_path: Path) -> None:
    path = tmp_path / "rig.yaml"
    document.save(path)
    path.write_text("# measured on Tuesday\n" + path.read_text(encoding="utf-8"), encoding="utf-8")
    document.open(path)
    document.set_enabled(("front",), False)
    document.save(path)
    assert path.read_text(encoding="utf-8").startswith("# measured on Tuesday\n")
    assert not load_rig(path).rig.sensor("front").enabled


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def nudge(document: Document, index: int, by_m: float) -> None:
    position = list(document.rig.sensor("roof").position)
    position[index] += by_m
    document.replace_sensor("roof", document.rig.sensor("roof").replace(position=tuple(position)))


def test_nudges_in_quick_succession_are_one_step(qtbot: QtBot) -> None:
    clock = Clock()
    document = Document(RIG, clock=clock)
    for _ in range(5):
        nudge(document, 0, 0.05)
        clock.now_s += MERGE_S
    assert document.undo_label == "move roof"
    document.undo()
    assert document.rig == RIG and document.undo_label is None


def test_a_pause_another_field_or_an_undo_ends_the_step(qtbot: QtBot) -> None:
    clock = Clock()
    document = Document(RIG, clock=clock)
    places = []
    for index in (0, 0, 2):
        nudge(document, index, 0.05)
        places.append(document.rig)
        clock.now_s += 2 * MERGE_S
    document.undo()
    assert document.rig == places[1]
    document.undo()
    assert document.rig == places[0]
    nudge(document, 0, 0.05)
    document.undo()
    assert document.rig == places[0]


def test_a_mirror_pair_moves_as_one_in_a_drag_and_stays_one_step(qtbot: QtBot) -> None:
    document = Document(linked(RIG.replace(sensors=(LIDAR, LIDAR.replace(name="other"))), "roof", "other"))
    start = document.rig
    document.begin_drag(("roof",))
    document.preview({"roof": Pose((1.0, 0.7, 2.0))})
    assert document.rig.sensor("other").position == (1.0, -0.7, 2.0)
    document.finish_drag()
    document.undo()
    assert document.rig == start


def test_one_of_a_mirror_pair_can_be_renamed_copied_and_deleted(qtbot: QtBot) -> None:
    document = Document(linked(RIG.replace(sensors=(LIDAR, LIDAR.replace(name="other"))), "roof", "other"))
    document.rename("roof", "top")
    assert document.rig.sensor("other").mirror_of == "top"
    (copy,) = document.duplicate(("other",))
    assert document.rig.sensor(copy).mirror_of is None
    document.delete(("top",))
    assert document.rig.sensor("other").mirror_of is None


def test_a_locked_sensor_is_neither_enabled_nor_disabled(document: Document) -> None:
    document.set_enabled(("roof",), False)
    document.set_locked(("roof",), True)
    for enabled in (True, False):
        with pytest.raises(InputError, match="roof: locked"):
            document.set_enabled(("roof",), enabled)
    assert not document.rig.sensor("roof").enabled
