"""Compare: presets, files and snapshots of the session beside the rig being edited, on the same traffic."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu

from riglens.app.background.side_jobs import SideAnswer, SideRequest
from riglens.app.evaluation.requests import LoadedScene, Result
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.files import Exchange, Files, beside_rig
from riglens.app.window.settings import Settings
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import PAPER_RIGS, PRESETS, preset
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

    def __init__(self, bench: Workbench, files: Files, exchange: Exchange) -> None:
        super().__init__(bench)
        self._files, self._exchange = files, exchange
        self.panel = ComparePanel()
        self._rows: dict[str, CompareRow] = {}
        self._numbers = count(1)
        self._scored_on: tuple[LoadedScene, MetricSettings] | None = None
        self._given_up = False
        self._asked: set[str] = set()
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
        bench.recompute.side_answered.connect(self._take, Qt.ConnectionType.QueuedConnection)

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
        scores = now.scores if now is not None and now.rig is rig else None
        self._rows[key] = CompareRow(key, name, origin, rig, where, scores)
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
        now = CompareRow(CURRENT, rig.name, "current", rig, "", result.evaluation.scores)
        self._rows = {CURRENT: now} | {key: row for key, row in self._rows.items() if key != CURRENT}
        self.panel.set_baseline(result.baseline_scores, result.request.settings.reading)
        self._ask()

    def _drop_scores(self) -> None:
        self._scored_on = None
        self._rows = {key: replace(row, scores=None) for key, row in self._rows.items()}
        self._forget()
        self._show()

    def _forget(self) -> None:
        self.bench.recompute.forget_aside(GROUP)
        self._asked.clear()

    def _missing(self) -> list[CompareRow]:
        return [row for row in self._rows.values() if row.scores is None]

    def _ask(self) -> None:
        """Ask for the scores that are missing, once the traffic and the settings are known."""
        if self._scored_on is not None and not self._given_up:
            settings = self._scored_on[1]
            new = [row for row in self._missing() if row.key not in self._asked]
            self._asked.update(row.key for row in new)
            self.bench.recompute.ask_aside([SideRequest(GROUP, row.key, row.rig, settings) for row in new])
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
