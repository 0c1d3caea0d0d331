"""Unsaved work survives a killed window, is offered once, and windows never take each other's."""

from __future__ import annotations

import errno
import json
import math
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtWidgets import QPushButton
from pytestqt.qtbot import QtBot

from riglens.app.session.autosave import AutosaveFile, Unsaved, orphans
from riglens.app.window.features.autosave import Autosave
from riglens.core.rig.yaml.file import load_rig, new_rig_file
from tests.app.conftest import REPOSITORY
from tests.app.window_bench import LIDAR, RIG, Bench, open_bench
from tests.waiting import TIMEOUT_MS

MOVED = RIG.with_sensor("roof", LIDAR.replace(position=(0.0, 0.0, 3.0)))


def killed_window(folder: Path, *rig: Path) -> None:
    """Run a window that edits its rig, and kill it as soon as that is on the disk."""
    command = [sys.executable, "-m", "tests.app.autosave_child", str(folder), *map(str, rig)]
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=REPOSITORY, env=environment) as child:
        try:
            assert child.stdout is not None
            assert child.stdout.readline().strip()
        finally:
            child.kill()


def orphan(folder: Path, path: Path | None = None) -> Path:
    """The file of a window that is gone."""
    file = AutosaveFile(folder)
    file.write(Unsaved(MOVED, RIG, path))
    said = json.loads(file.path.read_text(encoding="utf-8"))
    said["owner"]["started_at"] -= 1000.0
    file.remove()
    file.path.write_text(json.dumps(said), encoding="utf-8")
    return file.path


def start(bench: Bench, folder: Path) -> Autosave:
    autosave = bench.features.autosave
    autosave.start(folder)
    return autosave


def press(bench: Bench, choice: str) -> None:
    bar = bench.workbench.notes
    [button] = [found for found in bar.findChildren(QPushButton, choice) if found.isVisibleTo(bar)]
    button.click()


def files(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.json"))


def test_changes_of_a_killed_window_are_recovered_at_the_next_start(qtbot: QtBot, tmp_path: Path) -> None:
    rig = tmp_path / "my.yaml"
    rig.write_text("# mine\n" + new_rig_file(RIG).text, encoding="utf-8")
    killed_window(tmp_path, rig)
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")
        assert "my.yaml" in bench.workbench.notes.message
        press(bench, "Recover")
        assert bench.document.rig == MOVED
        assert bench.document.path == rig and bench.document.is_modified
        bench.act("save")
        assert load_rig(rig).rig == MOVED and rig.read_text(encoding="utf-8").startswith("# mine\n")
    assert files(tmp_path / "unsaved") == []


def test_a_rig_that_was_never_saved_is_recovered_too(qtbot: QtBot, tmp_path: Path) -> None:
    orphan(tmp_path / "unsaved")
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")
        press(bench, "Recover")
        assert (bench.document.rig, bench.document.saved_rig, bench.document.path) == (MOVED, RIG, None)
        assert not bench.workbench.notes.isVisible()
        bench.act("undo")
        assert bench.document.rig == RIG


def test_recovered_changes_stay_on_the_disk_until_they_are_saved_or_given_up(
    qtbot: QtBot, tmp_path: Path
) -> None:
    orphan(tmp_path / "unsaved")
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")
        press(bench, "Recover")
        assert len(files(tmp_path / "unsaved")) == 1
    assert files(tmp_path / "unsaved") == []


def test_discard_deletes_and_asks_about_the_next(qtbot: QtBot, tmp_path: Path) -> None:
    for _ in range(2):
        orphan(tmp_path / "unsaved")
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")
        assert "(1 more)" in bench.workbench.notes.message
        press(bench, "Discard")
        assert len(files(tmp_path / "unsaved")) == 1
        press(bench, "Discard")
        assert files(tmp_path / "unsaved") == [] and not bench.workbench.notes.isVisible()
        assert bench.document.rig == RIG


def test_a_running_window_keeps_its_file(qtbot: QtBot, tmp_path: Path) -> None:
    other = AutosaveFile(tmp_path / "unsaved")
    other.write(Unsaved(MOVED, RIG, None))
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")
        assert bench.workbench.notes.message == ""
    assert files(tmp_path / "unsaved") == [other.path]


def test_only_one_of_two_windows_gets_what_a_third_left_behind(qtbot: QtBot, tmp_path: Path) -> None:
    orphan(tmp_path / "unsaved")
    with open_bench(qtbot, tmp_path, data=False) as one, open_bench(qtbot, tmp_path, data=False) as other:
        for bench in (one, other):
            start(bench, tmp_path / "unsaved")
        press(one, "Recover")
        press(other, "Recover")
        assert (one.document.rig, other.document.rig) == (MOVED, RIG)
        assert "another window" in other.workbench.errors.message


def test_changes_are_written_and_the_file_goes_when_they_are_saved(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        start(bench, tmp_path / "unsaved")
        bench.document.apply(MOVED)
        qtbot.waitUntil(lambda: len(files(tmp_path / "unsaved")) == 1, timeout=TIMEOUT_MS)
        bench.dialogs.path = tmp_path / "saved.yaml"
        qtbot.waitUntil(lambda: not bench.workbench.tasks._running, timeout=TIMEOUT_MS)
        bench.act("save")
        assert files(tmp_path / "unsaved") == []


def test_a_folder_that_cannot_be_written_is_told_once_per_attempt_and_the_work_goes_on(
    qtbot: QtBot, tmp_path: Path
) -> None:
    (tmp_path / "unsaved").write_text("a file where the folder should be", encoding="utf-8")
    with open_bench(qtbot, tmp_path) as bench:
        start(bench, tmp_path / "unsaved")
        bench.document.apply(MOVED)
        qtbot.waitUntil(lambda: "unsaved" in bench.workbench.errors.message, timeout=TIMEOUT_MS)
        assert bench.document.rig == MOVED


def test_a_file_that_is_gone_meanwhile_costs_no_change(qtbot: QtBot, tmp_path: Path) -> None:
    orphan(tmp_path / "unsaved", path=tmp_path / "gone.yaml")
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")
        press(bench, "Recover")
        assert bench.document.rig == MOVED and bench.document.is_modified
        assert "gone.yaml" in bench.workbench.errors.message


@pytest.mark.parametrize(
    "content",
    [b"", b"\xff\x00", b"[]", b"{}", b'{"owner": {"pid": -1}}', b"[" * 100_000, b'{"owner": {"pid": "a"}}'],
)
def test_a_file_that_makes_no_sense_is_passed_over(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "1-1.autosave.json").write_bytes(content)
    assert orphans(tmp_path) == []


def changed(file: Path, *place: str, to: object) -> None:
    """Put another value into an autosave file."""
    said = inner = json.loads(file.read_text(encoding="utf-8"))
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = to
    file.write_text(json.dumps(said), encoding="utf-8")


WRONG: list[tuple[tuple[str, ...], object]] = [
    (("rig",), 5),
    (("base",), None),
    (("rig",), "riglens: 1\nname: {}\n"),
    (("owner", "pid"), math.inf),
    (("owner", "pid"), 10**30),
    (("owner", "pid"), -1),
    (("owner", "started_at"), math.nan),
    (("owner",), [1, 2]),
    (("saved_at",), math.inf),
    (("saved_at",), -1e300),
    (("saved_at",), "yesterday"),
    (("path",), 5),
    (("path",), "/a\0b"),
    (("path",), "/\ud800"),
    (("path",), "not/in/full.yaml"),
]


@pytest.mark.parametrize(("place", "value"), WRONG)
def test_a_file_with_one_wrong_value_is_passed_over(
    tmp_path: Path, place: tuple[str, ...], value: object
) -> None:
    changed(orphan(tmp_path), *place, to=value)
    assert orphans(tmp_path) == []


def test_what_was_left_behind_last_is_offered_first(tmp_path: Path) -> None:
    left = [orphan(tmp_path) for _ in range(3)]
    for file, saved_at in zip(left, (2e9, 3e9, 1e9), strict=True):
        changed(file, "saved_at", to=saved_at)
    assert [found.file for found in orphans(tmp_path)] == [left[1], left[0], left[2]]


def test_wrong_files_do_not_keep_the_window_from_offering_a_right_one(qtbot: QtBot, tmp_path: Path) -> None:
    for place, value in WRONG:
        changed(orphan(tmp_path / "unsaved"), *place, to=value)
    orphan(tmp_path / "unsaved")
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")
        assert "small" in bench.workbench.notes.message and "more" not in bench.workbench.notes.message


_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters(), max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=15)
@given(st.sampled_from([place for place, _ in WRONG]), _JSON)
def test_no_value_of_any_field_is_an_error(place: tuple[str, ...], value: object) -> None:
    with TemporaryDirectory() as folder:
        changed(orphan(Path(folder)), *place, to=value)
        assert len(orphans(Path(folder))) <= 1


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_of_that_name_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "1-1.autosave.json")
    assert orphans(tmp_path) == []


def test_a_clock_that_is_set_leaves_a_running_window_its_file(tmp_path: Path) -> None:
    other = AutosaveFile(tmp_path)
    other.write(Unsaved(MOVED, RIG, None))
    said = json.loads(other.path.read_text(encoding="utf-8"))
    changed(other.path, "owner", "started_at", to=said["owner"]["started_at"] - 1.5)
    assert orphans(tmp_path) == []


def test_a_window_that_got_the_number_of_one_that_is_gone_hides_nothing(tmp_path: Path) -> None:
    left = orphan(tmp_path / "unsaved")
    left.with_suffix(".lock").touch()  # as a killed process leaves it
    changed(left, "owner", "pid", to=os.getpid())
    changed(left, "owner", "started_at", to=psutil.Process().create_time())
    assert [orphan.file for orphan in orphans(tmp_path / "unsaved")] == [left]


def test_nothing_is_left_beside_a_file_that_is_gone(tmp_path: Path) -> None:
    file = AutosaveFile(tmp_path)
    for _ in range(2):
        for _ in range(2):
            file.write(Unsaved(MOVED, RIG, None))
            assert len(list(tmp_path.iterdir())) == 2, "a file and its lock"
        file.remove()
        assert list(tmp_path.iterdir()) == []


def test_two_windows_of_one_process_number_keep_apart(tmp_path: Path) -> None:
    assert AutosaveFile(tmp_path).path != AutosaveFile(tmp_path).path


def test_what_cannot_be_discarded_is_told(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    orphan(tmp_path / "unsaved")
    with open_bench(qtbot, tmp_path, data=False) as bench:
        start(bench, tmp_path / "unsaved")

        def refuse(path: Path, missing_ok: bool = False) -> None:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))

        with monkeypatch.context() as patch:
            patch.setattr(Path, "unlink", refuse)
            press(bench, "Discard")
        assert "cannot be deleted: Permission denied" in bench.workbench.errors.message
