"""Compare: presets, files and snapshots of the session beside the rig being edited, on the same traffic."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu

from riglens.app.background.counting import CountAnswer, CountRequest, SideCount, SideCounted
from riglens.app.background.side_jobs import SideAnswer, SideRequest
from riglens.app.evaluation.requests import LoadedScene, Result, failed_text
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.files import Exchange, Files, beside_rig
from riglens.app.window.features.targets import Targets
from riglens.app.window.settings import Settings
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.metric.scores import MetricSettings, Reading, Scores
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import PAPER_RIGS, PRESETS, preset
from riglens.core.targets.quantities import Figures, figures_of
from riglens.core.targets.settings import TargetSettings
from riglens.widgets.panels.compare.model import CompareRow, Origin
from riglens.widgets.panels.compare.panel import ComparePanel
from riglens.widgets.panels.menus import add_entry
from riglens.widgets.panels.scrolled import scrolled

GROUP = "compare"
MAX_ROWS = 200
CURRENT = "current"


class Compare(Feature):
    """Keeps the rows, has them scored when nobody edits, and opens rigs from them."""

    specs = (
        Spec(
            "snapshot", "Take snapshot", "Keep the rig as it is now in the list of the Compare panel", "Ctrl+T",
            "snapshot", "study/rigs",
        ),
        Spec(
            "compare_file", "Compare with file…", "Add a rig file to the Compare panel", "Ctrl+Alt+T",
            menu="study/rigs",
        ),
        Spec(
            "compare_paper", "Compare the paper's rigs", "Add the eight rigs of the paper to the Compare panel",
            "Ctrl+Shift+T", menu="study/rigs",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, files: Files, exchange: Exchange, targets: Targets) -> None:
        super().__init__(bench)
        self._files, self._exchange, self._targets = files, exchange, targets
        self.panel = ComparePanel()
        self._rows: dict[str, CompareRow] = {}
        self._numbers = count(1)
        self._own_figures: Figures | None = None
        self._baseline_figures: Figures | None = None
        self._baseline: tuple[Scores, Reading] | None = None
        self._scored_on: tuple[LoadedScene, MetricSettings] | None = None
        self._counted: CountAnswer | None = None
        """Of the rig being edited, in all frames: what else is counted is of the same traffic, in the same way."""
        self._given_up = False
        self._asked: set[str] = set()
        self._asked_counts: set[str] = set()
        self.bind(
            snapshot=self.take_snapshot,
            compare_file=self._choose_file,
            compare_paper=partial(self.add_presets, PAPER_RIGS),
        )
        self.dock = bench.docks.add(
            "Compare", scrolled(self.panel), Qt.DockWidgetArea.BottomDockWidgetArea, beside="Scores"
        )
        self.panel.set_add_menu(self._add_menu())
        self._connect()

    def _connect(self) -> None:
        panel, bench = self.panel, self.bench
        panel.snapshot_wanted.connect(self.take_snapshot)
        panel.open_wanted.connect(self.open)
        panel.pin_wanted.connect(lambda key: self.session.pin(self._rows[key].rig))
        panel.remove_wanted.connect(self.remove)
        panel.renamed.connect(self.rename)
        panel.score_wanted.connect(self._score_or_give_up)
        panel.export_wanted.connect(self._export)
        bench.answers.answered.connect(self._on_result)
        self.session.scene_changed.connect(lambda _: self._drop_scores())
        queued = Qt.ConnectionType.QueuedConnection
        bench.recompute.side_answered.connect(self._take, queued)
        bench.counter.counted_aside.connect(self._take_count, queued)
        self._targets.counted.connect(self._on_count)

    def _add_menu(self) -> QMenu:
        menu = QMenu(self.panel)
        presets = menu.addMenu("Preset")
        for name, found in PRESETS.items():
            add_entry(presets, found.title, partial(self.add_presets, (name,)))
        for key in ("compare_paper", "compare_file", "snapshot"):
            menu.addAction(self.actions[key])
        return menu

    @property
    def rows(self) -> tuple[CompareRow, ...]:
        """The rigs in the order in which they were added, the one being edited first."""
        return tuple(self._rows.values())

    # ------------------------------------------------------------------ rows
    def take_snapshot(self) -> None:
        """Keep the rig as it is now, under its name and a number."""
        rig = self.document.rig
        names = {row.name for row in self._rows.values()}
        name = next(text for number in count(1) if (text := f"{rig.name} #{number}") not in names)
        self._add(name, "snapshot", rig)

    def add_presets(self, names: tuple[str, ...]) -> None:
        """Add built-in rigs that are not in the list yet."""
        known = {row.where for row in self._rows.values() if row.origin == "preset"}
        for name in names:
            if name not in known:
                self._add(name, "preset", preset(name), name)

    def add_file(self, path: Path) -> None:
        """Add a rig file, also of another program; InputError when it cannot be read."""
        self._add(path.name, "file", self._exchange.rig_of(path), str(path))

    def _choose_file(self) -> None:
        folder = self.document.path.parent if self.document.path is not None else None
        path = self.bench.dialogs.open_rig(self.bench.window, folder)
        if path is not None:
            self.bench.guarded(self.add_file)(path)

    def _add(self, name: str, origin: Origin, rig: Rig, where: str = "") -> None:
        if len(self._rows) >= MAX_ROWS:
            self.bench.report_error(f"Compare: the list holds at most {MAX_ROWS} rigs; remove some first")
            return
        key = f"{origin}-{next(self._numbers)}"
        now = self._rows.get(CURRENT)
        known = (now.scores, now.figures) if now is not None and now.rig is rig else (None, None)
        self._rows[key] = CompareRow(key, name, origin, rig, where, *known)
        self._given_up = False
        self.dock.show()
        self.dock.raise_()
        self._ask()

    def remove(self, keys: tuple[str, ...]) -> None:
        """Take rigs out of the list; the one being edited stays."""
        for key in keys:
            if key != CURRENT:
                self._rows.pop(key, None)
        self._forget()
        self._ask()

    def rename(self, key: str, name: str) -> None:
        """Give a snapshot another name."""
        self._rows[key] = replace(self._rows[key], name=name)
        self._show()

    def open(self, key: str) -> None:
        """Open a rig in the window; a snapshot is restored as one step that can be undone."""
        row, files = self._rows[key], self._files
        if row.origin == "snapshot":
            self.bench.guarded(self.document.apply)(row.rig, f"restore {row.name}")
        elif row.origin == "preset":
            files.open_preset(row.where)
        elif row.origin == "file" and files.may_lose_changes():
            self.bench.guarded(self.document.open)(Path(row.where))

    # ------------------------------------------------------------------ scores
    def _on_result(self, result: Result) -> None:
        """Show the rig being edited; other traffic or settings make all other scores void."""
        scored_on = (result.scene, result.request.settings)
        if scored_on != self._scored_on:
            self._drop_scores()
            self._scored_on = scored_on
        rig = result.request.rig
        figures = None if self._counted is None or self._counted.request.rig != rig else self._own_figures
        failed = failed_text(self.document.failed)
        name = f"{rig.name}, {failed}" if failed else rig.name
        now = CompareRow(CURRENT, name, "current", rig, "", result.evaluation.scores, figures)
        self._rows = {CURRENT: now} | {key: row for key, row in self._rows.items() if key != CURRENT}
        self._baseline = (result.baseline_scores, result.request.settings.reading)
        self._show_baseline()
        self._ask()

    def _show_baseline(self) -> None:
        if self._baseline is not None:
            scores, reading = self._baseline
            self.panel.set_baseline(scores, self._baseline_figures, reading)

    def _on_count(self) -> None:
        """Take what the rig being edited gets onto road users; another way of counting makes all others void."""
        answer = self._targets.answer
        if answer is None or not self._targets.is_current:
            return
        before, self._counted = self._counted, answer
        now, request = self._rows.get(CURRENT), answer.request
        if before is None or _way(before) != _way(answer):
            self._drop_figures()
        self._own_figures = figures_of(answer.scores)
        self._baseline_figures = figures_of(answer.baseline)
        if now is not None and now.rig == request.rig:
            self._rows[CURRENT] = replace(now, figures=self._own_figures)
        self._show_baseline()
        self._ask()

    def _drop_figures(self) -> None:
        self._rows = {key: replace(row, figures=None) for key, row in self._rows.items()}
        self.bench.counter.forget_aside(GROUP)
        self._asked_counts.clear()

    def _drop_scores(self) -> None:
        self._scored_on = None
        self._rows = {key: replace(row, scores=None) for key, row in self._rows.items()}
        if self._counted is not None and self._counted.request.scene is not self.session.scene:
            self._counted, self._own_figures, self._baseline_figures = None, None, None
            self._drop_figures()
        self._forget()
        self._show()

    def _forget(self) -> None:
        self.bench.recompute.forget_aside(GROUP)
        self._asked.clear()
        self.bench.counter.forget_aside(GROUP)
        self._asked_counts.clear()

    def _missing(self) -> list[CompareRow]:
        return [row for row in self._rows.values() if row.scores is None]

    def _ask(self) -> None:
        """Ask for the scores that are missing, once the traffic and the settings are known."""
        if self._scored_on is not None and not self._given_up:
            settings = self._scored_on[1]
            new = [row for row in self._missing() if row.key not in self._asked]
            self._asked.update(row.key for row in new)
            self.bench.recompute.ask_aside([SideRequest(GROUP, row.key, row.rig, settings) for row in new])
        if self._counted is not None and not self._given_up:
            self._ask_counts(self._counted.request)
        self._show()

    def _ask_counts(self, counted: CountRequest) -> None:
        """Ask for what the other rigs get onto road users; a mesh that was not read is none of theirs."""
        body = counted.rig.vehicle.body
        new = [
            row
            for row in self._rows.values()
            if row.figures is None and row.key != CURRENT and row.key not in self._asked_counts
        ]
        self._asked_counts.update(row.key for row in new)
        self.bench.counter.ask_aside(
            [
                SideCount(
                    GROUP, row.key, row.rig, counted.settings, counted.scene,
                    counted.mesh if row.rig.vehicle.body == body else None,
                )
                for row in new
            ]
        )  # fmt: skip

    def _take_count(self, found: SideCounted) -> None:
        request, counted = found.request, self._counted
        row = self._rows.get(request.name) if request.group == GROUP else None
        if row is None or counted is None or row.rig is not request.rig:
            return
        if (request.scene, request.settings) == _way(counted):
            self._rows[row.key] = replace(row, figures=found.figures or {})
            self._show()

    def _take(self, answer: SideAnswer) -> None:
        request = answer.request
        row = self._rows.get(request.name) if request.group == GROUP else None
        if row is not None and row.rig is request.rig and (answer.scene, request.settings) == self._scored_on:
            self._rows[row.key] = replace(row, scores=answer.scores)
            self._show()

    def _score_or_give_up(self, wanted: bool) -> None:
        self._given_up = not wanted
        self._forget()
        self._ask()

    def _show(self) -> None:
        total = len(self._rows)
        self.panel.set_rows(self.rows)
        self.panel.show_progress(total - len(self._missing()), total, self._given_up)

    # ------------------------------------------------------------------ between sessions, export
    def restore(self, settings: Settings) -> None:
        self.panel.set_bars(settings.read("compare/bars", False))

    def keep(self, settings: Settings) -> None:
        settings.write("compare/bars", self.panel.bars.isChecked())

    def _export(self) -> None:
        path = self.bench.dialogs.save_table(self.bench.window, beside_rig(self.document, "rigs", ".csv"))
        if path is None:
            return
        try:
            with atomic_write(path) as stream:
                stream.write(self.panel.as_text(",").encode("utf-8"))
        except InputError as error:
            self.bench.report_error(str(error))


def _way(answer: CountAnswer) -> tuple[LoadedScene, TargetSettings]:
    """What figures side by side must have in common: the traffic, and how it is counted."""
    return answer.request.scene, answer.request.settings
