"""Compare presets, files and snapshots of the session with the rig being edited, on the same traffic."""

from __future__ import annotations

from functools import partial
from itertools import count
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.compared import ComparedRigs
from riglens.app.window.features.files import Exchange, Files, beside_rig
from riglens.app.window.features.targets import Targets
from riglens.app.window.workbench import Workbench
from riglens.core.figures.values import Values
from riglens.core.files import write_file
from riglens.core.metric.scores import Reading, Scores
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import PAPER_RIGS, PRESETS, preset
from riglens.evaluation.requests import Result, failed_text
from riglens.widgets.panels.compare.model import CompareRow, Origin
from riglens.widgets.panels.compare.panel import ComparePanel
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.controls.scrolled import scrolled

MAX_ROWS = 200


class Compare(Feature):
    """List of compared rigs: fills it, shows their known figures, and opens rigs from it."""

    specs = (
        Spec(
            "snapshot", "Take snapshot", "Add the current rig to the list of the Compare panel.", "Ctrl+T",
            "snapshot", "study/rigs",
        ),
        Spec(
            "pin", "Snapshot as baseline", "Take a snapshot and show all changes from it.", "Ctrl+B", "pin",
            "study/rigs",
        ),
        Spec(
            "unpin", "Last saved rig as baseline", "Show all changes from the last saved rig.", "Ctrl+Shift+B",
            menu="study/rigs",
        ),
        Spec(
            "compare_file", "Compare with file…", "Add a rig file to the Compare panel.", "Ctrl+Alt+T",
            menu="study/rigs",
        ),
        Spec(
            "compare_paper", "Compare the paper's rigs", "Add the eight rigs of the paper to the Compare panel.",
            "Ctrl+Shift+T", menu="study/rigs",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, files: Files, exchange: Exchange, targets: Targets) -> None:
        super().__init__(bench)
        self._files, self._exchange, self._targets = files, exchange, targets
        self.panel = ComparePanel()
        self._rigs = ComparedRigs(bench)
        self._baseline: tuple[Scores, Reading] | None = None
        self._baseline_counted: Values | None = None
        self.bind(
            snapshot=self.take_snapshot,
            pin=self.pin_snapshot,
            unpin=partial(self.session.pin, None),
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
        panel.table.pin_wanted.connect(lambda key: self.session.pin(self._rigs[key].rig))
        panel.table.remove_wanted.connect(self._rigs.remove)
        panel.model.renamed.connect(self._rigs.rename)
        panel.score_wanted.connect(self._rigs.go_on)
        panel.export_wanted.connect(bench.guarded(self._export))
        bench.answers.answered.connect(self._on_result)
        self._targets.counted.connect(self._on_count)
        self._rigs.changed.connect(self._show)
        self.session.baseline_changed.connect(self._show_pinned)
        self.remember("compare/bars", panel.bars.isChecked, panel.set_bars)
        self._show_pinned()

    def _show_pinned(self) -> None:
        self.actions.allow("unpin", "" if self.session.pinned is not None else "No baseline is set.")

    def _add_menu(self) -> QMenu:
        menu = QMenu(self.panel)
        presets = menu.addMenu("Preset")
        for name, found in PRESETS.items():
            add_entry(presets, found.title, partial(self.add_presets, (name,)))
        for key in ("compare_paper", "compare_file", "snapshot", "pin", "unpin"):
            menu.addAction(self.actions[key])
        return menu

    @property
    def rows(self) -> tuple[CompareRow, ...]:
        """The rigs in the order in which they were added, the one being edited first."""
        return self._rigs.rows

    # ------------------------------------------------------------------ rows
    def take_snapshot(self) -> None:
        """Keep the current rig, under its name and a number."""
        self._snapshot()
        self.bench.docks.bring_up("Compare")

    def pin_snapshot(self) -> None:
        """Keep the current rig as the baseline; the front panel stays."""
        self._snapshot()
        self.session.pin(self.document.rig)

    def _snapshot(self) -> None:
        rig = self.document.rig
        names = {row.name for row in self.rows}
        name = next(text for number in count(1) if (text := f"{rig.name} #{number}") not in names)
        self._add(name, "snapshot", rig)

    def add_presets(self, names: tuple[str, ...]) -> None:
        """Add built-in rigs that are not in the list yet."""
        known = {row.where for row in self.rows if row.origin == "preset"}
        for name in names:
            if name not in known:
                self._add(name, "preset", preset(name), name)
        self.bench.docks.bring_up("Compare")

    def add_file(self, path: Path) -> None:
        """Add a rig file, also of another program; InputError when it cannot be read."""
        self._add(path.name, "file", self._exchange.rig_of(path), str(path))
        self.bench.docks.bring_up("Compare")

    def add_rig(self, name: str, rig: Rig) -> None:
        """Add a rig of another panel, unless the list has it under that name; the front panel stays."""
        if not any((row.name, row.rig.sensors) == (name, rig.sensors) for row in self.rows):
            self._add(name, "snapshot", rig)

    def _choose_file(self) -> None:
        path = self.bench.dialogs.open_rig(self.bench.window, self.document.folder)
        if path is not None:
            self.bench.guarded(self.add_file)(path)

    def _add(self, name: str, origin: Origin, rig: Rig, where: str = "") -> None:
        if len(self.rows) >= MAX_ROWS:
            self.bench.report_error(f"Compare: the list holds at most {MAX_ROWS} rigs; remove some first")
            return
        self._rigs.add(name, origin, rig, where)

    def open(self, key: str) -> None:
        """Open a rig in the window; a snapshot is restored as one step that can be undone."""
        row, files = self._rigs[key], self._files
        if row.origin == "snapshot":
            self.bench.guarded(self.document.apply)(row.rig, f"restore {row.name}")
        elif row.origin == "preset":
            files.open_preset(row.where)
        elif row.origin == "file" and files.may_lose_changes():
            self.bench.guarded(self.document.open)(Path(row.where))

    # ------------------------------------------------------------------ scores
    def _on_result(self, result: Result) -> None:
        failed = failed_text(self.document.failed)
        name = result.request.rig.name
        self._baseline = (result.baseline_scores, result.request.settings.reading)
        self._show_baseline()
        self._rigs.take_result(result, f"{name}, {failed}" if failed else name)

    def _on_count(self) -> None:
        answer = self._targets.answer
        if answer is not None and self._targets.is_current:
            self._baseline_counted = answer.baseline_figures
            self._show_baseline()
            self._rigs.take_count(answer)

    def forget_scene(self) -> None:
        """Forget the scores and counts of earlier traffic."""
        self._baseline_counted = None
        self._rigs.drop_scores(self.session.scene)

    def _show_baseline(self) -> None:
        if self._baseline is not None:
            scores, reading = self._baseline
            self.panel.model.set_baseline(scores, self._baseline_counted, reading)

    def _show(self) -> None:
        total = len(self.rows)
        self.panel.model.set_rows(self.rows)
        self.panel.show_progress(total - len(self._rigs.missing), total, self._rigs.is_given_up)

    # ------------------------------------------------------------------ export
    def _export(self) -> None:
        path = self.bench.dialogs.save_table(self.bench.window, beside_rig(self.document, "rigs", ".csv"))
        if path is not None:
            write_file(path, self.panel.as_text(","))
