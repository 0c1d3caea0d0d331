"""Where exact scores take longer than a frame, coarse ones go ahead, marked as such, and exact ones end it."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

import riglens.core.figures.evaluated
import riglens.evaluation.scoring
from riglens.app.background.background_requests import LEARN
from riglens.app.background.queue import Priority
from riglens.core.engine.engine import Engine
from riglens.core.errors import Cancelled
from riglens.core.geometry import Pose
from riglens.core.rig.model import Lidar
from riglens.core.rig.yaml.file import load_rig
from riglens.core.scene.boxes import CLASSES
from riglens.evaluation.requests import FRAME_MS, Approximation, Result
from tests.app.window_bench import Bench, open_bench
from tests.waiting import TIMEOUT_MS, TIMEOUT_S

QUEUED = Qt.ConnectionType.QueuedConnection
FINE_M, COARSE_M = 0.5, 1.0
ALL_SLOW = 0.0
"""With this threshold whatever has to be cast counts as slow."""


class Watch:
    """Everything the window showed, in the order in which it was shown."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.shown: list[tuple[str, int]] = []
        self.states: list[str] = []
        recompute = bench.workbench.recompute  # Qt holds a method of a plain object weakly, a lambda for good
        recompute.approximated.connect(lambda first: self._note("coarse", first), QUEUED)
        recompute.evaluated.connect(lambda result: self._note("exact", result), QUEUED)

    def _note(self, kind: str, answer: Approximation | Result) -> None:
        self.shown.append((kind, answer.request.revision))
        self.states.append(self.bench.workbench.status.state.text())

    @property
    def kinds(self) -> list[str]:
        return [kind for kind, _ in self.shown]

    def wait_for(self, kind: str, revision: int) -> None:
        self.bench.qtbot.waitUntil(lambda: (kind, revision) in self.shown, timeout=TIMEOUT_MS)


Open = Callable[..., Bench]


@pytest.fixture
def opened(qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Open]:
    for name in ("WORTH", "STILL_WORTH"):  # in a tiny scene a coarse answer saves nothing
        monkeypatch.setattr(riglens.evaluation.scoring, name, math.inf)
    benches: list[AbstractContextManager[Bench]] = []

    def open_it(coarse_above_ms: float = ALL_SLOW, counted: str = "last", **scene: Any) -> Bench:
        wait = counted != "first"
        benches.append(open_bench(qtbot, tmp_path, wait=wait, coarse_above_ms=coarse_above_ms, **scene))
        bench = benches[-1].__enter__()
        recompute = bench.workbench.recompute
        if counted != "never":
            recompute.ask_in_background([LEARN])  # as after a count of all frames
        bench.settle()
        assert recompute.wait_until_idle(TIMEOUT_S, Priority.BACKGROUND)
        return bench

    yield open_it
    for bench in benches:
        bench.__exit__(None, None, None)


def move(bench: Bench, name: str, x: float) -> int:
    """One step of an open drag; returns the revision."""
    bench.viewport.drag_to(name, Pose((x, 0.2, 1.4), bench.document.rig.sensor(name).rpy_deg))
    return bench.document.revision


def know(bench: Bench, *names: str) -> None:
    """Move each sensor once and back, so that its time is known."""
    for name in names:
        bench.drag(name, (2.0, 1.0, 1.0))
        bench.settle()
        bench.act("undo")
        bench.settle()
    assert bench.workbench.recompute.wait_until_idle()


class TimedEngine:
    """The engine with other times on its clock (1 ms if not told), and a gate before exact answers."""

    exact_ms: Mapping[str, float] = MappingProxyType({})
    coarse_ms: Mapping[str, float] = MappingProxyType({})
    coarse_made = 0
    gate: threading.Event | None = None
    reached: threading.Event

    def __init__(self, field: Any, threads: int | None) -> None:
        self._engine, self._is_exact = Engine(field, threads), field.grid.voxel_m == FINE_M
        self._last: Any = None

    def evaluate(
        self,
        rig: Any,
        settings: Any,
        with_seen: bool = True,
        stance: Pose = Pose(),
        cancel: Any = lambda: False,
    ) -> Any:
        if self._is_exact and self.gate is not None:
            self.reached.set()
            assert self.gate.wait(TIMEOUT_MS / 1000)
            if cancel():
                raise Cancelled
        type(self).coarse_made += not self._is_exact
        found = self._engine.evaluate(rig, settings, with_seen, cancel=cancel)
        before, self._last = self._last, rig
        if before is None:
            return found
        changed = [s.name for s in rig.sensors if s not in before.sensors]
        times = self.exact_ms if self._is_exact else self.coarse_ms
        return replace(found, elapsed_ms=sum(times.get(name, 1.0) for name in changed))

    def scores_without(self, rig: Any, settings: Any) -> Any:
        return self._engine.scores_without(rig, settings)


@pytest.fixture
def timed(monkeypatch: pytest.MonkeyPatch) -> type[TimedEngine]:
    monkeypatch.setattr(TimedEngine, "exact_ms", TimedEngine.exact_ms)
    monkeypatch.setattr(TimedEngine, "coarse_ms", TimedEngine.coarse_ms)
    monkeypatch.setattr(TimedEngine, "coarse_made", 0)
    monkeypatch.setattr(TimedEngine, "gate", None)
    monkeypatch.setattr(TimedEngine, "reached", threading.Event(), raising=False)
    monkeypatch.setattr(riglens.core.figures.evaluated, "Engine", TimedEngine)
    return TimedEngine


def test_a_slow_edit_shows_coarse_scores_first_and_ends_exact_to_the_last_bit(opened: Open) -> None:
    bench = opened()
    watch = Watch(bench)
    bench.drag("roof", (3.0, 0.0, 1.0), (-4.0, 1.0, 2.0), (1 / 3, 0.1 + 0.2, 1.7))
    bench.settle()
    assert watch.kinds[0] == "coarse"
    assert watch.kinds[-1] == "exact"
    assert watch.states[0] == "coarse (δ 1 m), exact follows"
    assert watch.states[-1] == "exact"
    assert bench.exact_numbers() == bench.fresh_numbers()


def test_the_base_of_coarse_answers_waits_for_a_drag_or_until_objects_are_counted(
    opened: Open, timed: type[TimedEngine]
) -> None:
    bench = opened(counted="never")
    bench.document.set_enabled(("front",), False)
    bench.settle()
    assert timed.coarse_made == 0
    watch = Watch(bench)
    bench.viewport.press("roof")
    first = move(bench, "roof", 1.0)
    watch.wait_for("exact", first)
    watch.wait_for("coarse", move(bench, "roof", 2.0))
    assert watch.shown[0] == ("exact", first)
    bench.viewport.release("roof")
    bench.settle()
    assert bench.exact_numbers() == bench.fresh_numbers()


@pytest.mark.parametrize("counted", ["first", "last"])
def test_the_base_is_made_once_whether_scores_or_counts_end_first(
    opened: Open, timed: type[TimedEngine], counted: str
) -> None:
    bench = opened(counted=counted)
    assert timed.coarse_made == 1
    bench.document.set_enabled(("front",), False)
    bench.settle()
    assert timed.coarse_made == 2


def test_a_rig_that_was_slow_gets_its_base_even_if_the_next_edit_is_quick(
    opened: Open, timed: type[TimedEngine]
) -> None:
    bench = opened(counted="never")
    recompute = bench.workbench.recompute
    scoring = recompute._scoring
    assert scoring is not None and not scoring.has_learnt
    scoring._coarse_above_ms = math.inf
    bench.document.set_enabled(("front",), False)
    bench.settle()
    recompute.ask_in_background([LEARN])
    assert recompute.wait_until_idle(TIMEOUT_S, Priority.BACKGROUND)
    assert timed.coarse_made == 1 and scoring.has_learnt


def test_any_sequence_of_edits_ends_exact_to_the_last_bit(opened: Open) -> None:
    bench = opened()
    know(bench, "roof", "front")
    bench.drag("roof", (3.0, 0.0, 1.0), (-4.0, 1.0, 2.0))
    bench.document.duplicate(("front",))
    bench.drag("front", (2.0, 0.4, 1.2))
    bench.document.set_enabled(("roof",), False)
    bench.act("undo")
    bench.act("undo")
    bench.settle()
    assert bench.exact_numbers() == bench.fresh_numbers()
    assert not bench.panels.scores.table.cell("car", "seen").is_italic


def test_a_quick_engine_never_answers_coarsely(opened: Open, timed: type[TimedEngine]) -> None:
    bench = opened(FRAME_MS)
    know(bench, "roof", "front")
    watch = Watch(bench)
    bench.drag("roof", (3.0, 0.0, 1.0), (-4.0, 1.0, 2.0))
    bench.settle()
    bench.drag("front", (3.0, 0.0, 1.0))
    bench.settle()
    assert set(watch.kinds) == {"exact"}


def test_only_the_sensor_that_is_slow_is_answered_coarsely(opened: Open, timed: type[TimedEngine]) -> None:
    timed.exact_ms = {"front": 50.0}
    bench = opened(FRAME_MS)
    know(bench, "roof", "front")
    watch = Watch(bench)
    bench.drag("roof", (3.0, 0.0, 1.0))
    bench.settle()
    assert watch.kinds == ["exact"]
    bench.drag("front", (3.0, 0.0, 1.0))
    bench.settle()
    assert watch.kinds[1:] == ["coarse", "exact"]


def test_while_the_mouse_moves_answers_are_coarse_and_the_exact_one_waits_for_its_rest(opened: Open) -> None:
    bench = opened()
    know(bench, "roof")
    watch = Watch(bench)
    bench.clock.stand_still()
    bench.viewport.press("roof")
    for step in range(1, 4):
        watch.wait_for("coarse", move(bench, "roof", 0.7 * step))
    assert set(watch.kinds) == {"coarse"}
    last = move(bench, "roof", 3.0)
    watch.wait_for("coarse", last)
    assert set(watch.kinds) == {"coarse"}
    bench.clock.leap()
    watch.wait_for("exact", last)
    assert bench.document.is_dragging
    assert watch.shown[-2:] == [("coarse", last), ("exact", last)]
    bench.settle()
    assert bench.exact_numbers() == bench.fresh_numbers()
    bench.viewport.release("roof")


def test_an_exact_answer_under_way_is_given_up_for_anything_newer(
    opened: Open, timed: type[TimedEngine]
) -> None:
    timed.exact_ms = {"roof": 50.0}
    bench = opened(FRAME_MS)
    know(bench, "roof")
    watch = Watch(bench)
    timed.gate = threading.Event()
    timed.reached.clear()
    bench.viewport.press("roof")
    first = move(bench, "roof", 1.0)
    assert timed.reached.wait(TIMEOUT_MS / 1000)
    second = move(bench, "roof", 2.0)
    timed.gate.set()
    watch.wait_for("exact", second)
    assert watch.shown == [("coarse", first), ("coarse", second), ("exact", second)]
    bench.viewport.release("roof")


@contextmanager
def coarse_shown(opened: Open, timed: type[TimedEngine]) -> Iterator[Bench]:
    """A window in the middle of a slow edit: coarse scores are shown, the exact ones are held back."""
    timed.exact_ms = {"roof": 50.0}
    bench = opened(FRAME_MS)
    know(bench, "roof")
    timed.gate = threading.Event()
    watch = Watch(bench)
    bench.viewport.press("roof")
    watch.wait_for("coarse", move(bench, "roof", 2.5))
    try:
        yield bench
    finally:
        timed.gate.set()
    bench.viewport.release("roof")
    bench.settle()
    assert bench.exact_numbers() == bench.fresh_numbers()


def cells(bench: Bench) -> dict[str, Any]:
    keys = bench.voxel_columns()
    return {f"{name} {key}": bench.panels.scores.table.cell(name, key) for name in CLASSES for key in keys}


def test_coarse_numbers_are_marked_have_no_change_and_cannot_be_copied(
    opened: Open, timed: type[TimedEngine]
) -> None:
    with coarse_shown(opened, timed) as bench:
        for key, cell in cells(bench).items():
            assert cell.is_italic, key
            assert cell.text == "…" if key.endswith("change") else cell.text.startswith("≈ "), key
            assert "exact number follows" in cell.tip
        assert bench.workbench.status.state.text() == "coarse (δ 1 m), exact follows"
        assert not bench.window.is_exact
        assert all(cell.values == (None,) for cell in cells(bench).values())


def test_saving_in_between_writes_the_rig_and_the_change_counts_from_exact_scores(
    opened: Open, timed: type[TimedEngine], tmp_path: Path
) -> None:
    with coarse_shown(opened, timed) as bench:
        bench.dialogs.path = tmp_path / "rig.yaml"
        bench.act("save")
        assert load_rig(tmp_path / "rig.yaml").rig == bench.document.rig
    assert bench.shown("car", "s_ms change") == "—"


def test_the_heatmap_shows_what_is_exact_only(opened: Open) -> None:
    bench = opened()
    bench.features.heat.set_mode("seen")
    bench.settle()
    know(bench, "roof")
    before = bench.viewport.state.heatmap
    told: list[Any] = []
    bench.workbench.recompute.approximated.connect(
        lambda _: told.append(bench.viewport.state.heatmap), QUEUED
    )
    bench.drag("roof", (3.0, 0.0, 1.0))
    bench.settle()
    assert told
    assert all(shown is before for shown in told)
    assert bench.viewport.state.heatmap is not before


def test_an_approximation_older_than_what_is_shown_is_dropped(opened: Open) -> None:
    bench = opened()
    old: list[Approximation] = []
    bench.workbench.recompute.approximated.connect(old.append, QUEUED)
    bench.drag("roof", (3.0, 0.0, 1.0))
    bench.settle()
    bench.document.set_enabled(("roof",), False)
    bench.settle()
    bench.workbench.answers.take_approximation(old[0])
    assert not bench.panels.scores.table.cell("car", "seen").is_italic
    assert bench.workbench.status.state.text() == "exact"


def test_without_a_coarser_copy_there_are_exact_answers_only(opened: Open) -> None:
    odd = opened(voxel_m=0.8)
    watch = Watch(odd)
    odd.drag("roof", (3.0, 0.0, 1.0))
    odd.settle()
    assert set(watch.kinds) == {"exact"}


def test_the_first_sensor_of_a_kind_is_answered_exactly_as_there_is_nothing_to_estimate_from(
    opened: Open,
) -> None:
    bench = opened()
    bench.document.delete(("roof",))
    bench.settle()
    watch = Watch(bench)
    lidar = bench.document.saved_rig.sensor("roof")
    assert isinstance(lidar, Lidar)
    bench.document.add(lidar)
    bench.settle()
    assert watch.kinds == ["exact"]
    assert bench.exact_numbers() == bench.fresh_numbers()


def test_a_coarse_answer_that_saves_no_time_is_not_given(
    opened: Open, timed: type[TimedEngine], monkeypatch: pytest.MonkeyPatch
) -> None:
    timed.exact_ms, timed.coarse_ms = {"roof": 50.0, "front": 50.0}, {"roof": 45.0, "front": 5.0}
    bench = opened(FRAME_MS)
    monkeypatch.setattr(riglens.evaluation.scoring, "WORTH", 0.5)
    monkeypatch.setattr(riglens.evaluation.scoring, "STILL_WORTH", 0.8)
    know(bench, "roof", "front")
    watch = Watch(bench)
    bench.drag("roof", (3.0, 0.0, 1.0))
    bench.settle()
    assert watch.kinds == ["exact"]
    bench.drag("front", (3.0, 0.0, 1.0))
    bench.settle()
    assert watch.kinds == ["exact", "coarse", "exact"]


def test_no_threshold_no_coarse_answers(opened: Open) -> None:
    bench = opened(math.inf)
    watch = Watch(bench)
    bench.drag("roof", (3.0, 0.0, 1.0))
    bench.settle()
    assert set(watch.kinds) == {"exact"}
