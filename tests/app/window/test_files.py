"""Opening, saving and closing: nothing is lost without a question, and errors never stop the work."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from riglens.app.window.dialogs import Unsaved
from riglens.core.rig.plausible import implausible
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import load_rig, new_rig_file
from tests.app.window.desk import FullDesk
from tests.app.window_bench import RIG, Bench, open_bench


def modify(bench: FullDesk) -> None:
    bench.drag("roof", (1 / 3, 0.1 + 0.2, 2.0))


@pytest.fixture
def whole(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    """A window that may be closed."""
    with open_bench(qtbot, tmp_path) as opened:
        yield opened


def test_a_dragged_rig_is_saved_and_opened_again_bit_for_bit(bench: FullDesk, tmp_path: Path) -> None:
    modify(bench)
    assert bench.workbench.window.isWindowModified()
    dragged = bench.document.rig
    bench.dialogs.path = tmp_path / "mine.yaml"
    bench.act("save")
    assert not bench.workbench.window.isWindowModified()
    assert "mine.yaml" in bench.workbench.window.windowTitle()
    bench.document.show(RIG)
    bench.act("open")
    assert bench.document.rig == dragged
    assert load_rig(tmp_path / "mine.yaml").rig == dragged


def test_what_is_implausible_about_a_rig_is_shown_until_another_is_opened(
    bench: FullDesk, tmp_path: Path
) -> None:
    deep = RIG.replace(sensors=(RIG.sensors[0].replace(position=(0.0, 0.0, -1.0)),))
    for rig, path in ((deep, tmp_path / "deep.yaml"), (RIG, tmp_path / "good.yaml")):
        new_rig_file(rig).save(path)
        bench.dialogs.path = path
        bench.act("open")
        assert bench.workbench.notes.message == "\n".join(implausible(rig))
    assert implausible(deep) and not implausible(RIG)


def test_saving_again_asks_no_second_time_and_save_as_does(bench: FullDesk, tmp_path: Path) -> None:
    bench.dialogs.path = tmp_path / "one.yaml"
    bench.act("save")
    bench.dialogs.path = tmp_path / "two.yaml"
    modify(bench)
    bench.act("save")
    assert not (tmp_path / "two.yaml").exists()
    assert load_rig(tmp_path / "one.yaml").rig == bench.document.rig
    bench.act("save_as")
    assert bench.document.path == tmp_path / "two.yaml"


def test_a_file_that_cannot_be_read_is_reported_and_the_rig_stays(bench: FullDesk, tmp_path: Path) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text("riglens: 1\nname: bad\ncolour: red\n", encoding="utf-8")
    bench.dialogs.path = bad
    bench.act("open")
    assert bench.document.rig == RIG
    assert "bad.yaml" in bench.workbench.errors.message
    assert "colour" in bench.workbench.errors.message
    assert bench.workbench.errors.isVisible()


def test_a_place_that_cannot_be_written_is_reported_and_nothing_counts_as_saved(
    bench: FullDesk, tmp_path: Path
) -> None:
    modify(bench)
    bench.dialogs.path = tmp_path / "missing" / "rig.yaml"
    bench.act("save")
    assert bench.workbench.window.isWindowModified()
    assert "missing" in bench.workbench.errors.message


@pytest.mark.parametrize(("answer", "lost"), [("cancel", False), ("discard", True), ("save", True)])
def test_opening_over_unsaved_changes_asks_first(
    bench: FullDesk, tmp_path: Path, answer: Unsaved, lost: bool
) -> None:
    target = tmp_path / "rig.yaml"
    new_rig_file(RIG).save(target)
    bench.document.open(target)
    modify(bench)
    changed = bench.document.rig
    bench.dialogs.answer = answer
    bench.features.files.open_preset("N+P")
    assert bench.dialogs.asked == 1
    assert (bench.document.rig == preset("N+P")) is lost
    assert (load_rig(target).rig == changed) is (answer == "save")


def test_closing_with_unsaved_changes_asks_and_stays_on_cancel(whole: Bench) -> None:
    modify(whole)
    whole.dialogs.answer = "cancel"
    assert not whole.workbench.window.close()
    assert whole.workbench.window.isVisible()
    whole.dialogs.answer = "discard"
    assert whole.workbench.window.close()


def test_closing_without_changes_asks_nothing_and_ends_the_thread(whole: Bench) -> None:
    assert whole.workbench.window.close()
    assert whole.dialogs.asked == 0
    assert whole.viewport.told[-1] == ("closed",)
    assert not any(thread.name == "recompute" for thread in threading.enumerate())


def test_closing_while_boxes_are_loaded_ends_the_thread(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, wait=False) as bench:
        assert bench.workbench.window.close()
    assert not any(thread.name == "recompute" for thread in threading.enumerate())
