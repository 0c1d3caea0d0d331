"""Propose panel: what may be added, the search, its proposals, and the checks of their gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_origin

from pydantic.fields import FieldInfo
from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QMenu,
    QProgressBar,
    QPushButton,
    QTabWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from riglens.core.rig.library import default_library
from riglens.core.sensors.registry import kinds
from riglens.widgets.panels.controls.scrolled import ElidedLabel
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel, plain_tip
from riglens.widgets.panels.fields.form import ChoiceBox, Form
from riglens.widgets.panels.fields.model_rows import ModelRows
from riglens.widgets.panels.figures.table import NOTHING, Figure, FigureTable, Heading
from riglens.widgets.panels.propose.chart import Plot, Plots
from riglens.widgets.panels.propose.shown import CHECKS, COLUMNS, NO_SEARCH, Offer, offer_cells

State = Literal["idle", "running", "paused"]
_LABEL_PX, _FORM_PX, _BAR_PX = 70, 156, 220
_ALWAYS = 2
"""Columns of the table that are never left out."""
_ROW_PX, _NAME_PX, _CELL_PX = 22, 132, 56
SKIN_TIP = "Colour the car by the gain of one more sensor at each place; follows the rig while it is edited."


class ProposePanel(QWidget):
    """Panel that emits requests and shows results. `columns`: the fields of the options that are shown side by side."""

    start_wanted = Signal()
    pause_wanted = Signal(bool)
    """Pause the search, or go on with it."""
    stop_wanted = Signal()
    skin_wanted = Signal(bool)
    hovered = Signal(str)
    """Key of the offer under the mouse, empty for none."""
    selected = Signal(str)
    """Key of the offer that is chosen now."""
    chosen = Signal(str)
    """Key of the offer that was clicked."""
    apply_wanted = Signal(str)
    """Key of the offer to apply."""
    search_chosen = Signal(int)
    """Place of an earlier search that is to be shown again."""
    compare_wanted = Signal(str)
    export_wanted = Signal()

    def __init__(
        self, options: Any, columns: Sequence[Mapping[str, FieldInfo]], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        as_panel(self)
        self._offers: tuple[Offer, ...] = ()
        self._key = ""
        self._models, self._model_menu = QToolButton(), QMenu(self)
        self.forms = tuple(Form() for _ in columns)
        """Forms of the options, one for each column."""
        self.start, self.pause, self.stop = QPushButton("Start"), QPushButton("Pause"), QPushButton("Stop")
        self.searches = ChoiceBox()
        self.searches.setToolTip("Searches of this session.")
        self.searches.activated.connect(self.search_chosen)
        self.bar, self.skin = QProgressBar(), QCheckBox("Gain on car")
        self.sentence, self.verdict = ElidedLabel(NO_SEARCH), ElidedLabel()
        self.plots, self.tabs = Plots(), QTabWidget()
        self.table, self.checks = FigureTable("Proposed rigs"), FigureTable("Checks of the gain")
        self.apply, self.compare = QPushButton("Apply"), QPushButton("Compare")
        self.export = QPushButton("Export…")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(MARGIN, SPACING, MARGIN, SPACING)
        layout.setSpacing(SPACING)
        head = QHBoxLayout()
        head.addWidget(self.sentence, 1)
        head.addWidget(self.searches)
        head.addWidget(self.bar)
        layout.addLayout(head)
        left, row = QVBoxLayout(), QHBoxLayout()
        left.addLayout(self._commands())
        self._add_tabs(self._options(columns))
        left.addWidget(self.tabs, 1)
        row.setSpacing(2 * SPACING)
        row.addLayout(left)
        row.addWidget(self.plots, 1)
        layout.addLayout(row, 1)
        self.show_options(options)
        self.show_state("idle")
        self.show_offers(())
        self.show_checks([], [], "")
        self.select("")

    # ------------------------------------------------------------------ building
    def _commands(self) -> QHBoxLayout:
        self._models.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._models.setMenu(self._model_menu)
        self._models.setToolTip("Library models to choose among.")
        for kind in kinds():
            for maker, entries in default_library().by_maker(kind.name).items():
                menu = self._model_menu.addMenu(f"{kind.title}: {maker}")
                for entry in entries:
                    action = menu.addAction(entry.title)
                    action.setCheckable(True)
                    action.setData(entry.name)
                    action.toggled.connect(lambda _: self._name_models())
        self.skin.setToolTip(SKIN_TIP)
        self.skin.toggled.connect(self.skin_wanted)
        self.start.clicked.connect(lambda: self.start_wanted.emit())
        self.pause.setCheckable(True)
        self.pause.clicked.connect(lambda on: self.pause_wanted.emit(on))
        self.stop.setToolTip("End the search; the best rig so far stays.")
        self.stop.clicked.connect(lambda: self.stop_wanted.emit())
        self.bar.setRange(0, 1000)
        self.bar.setFixedWidth(_BAR_PX)
        line = QHBoxLayout()
        for widget in (self._models, self.skin, self.start, self.pause, self.stop):
            line.addWidget(widget, int(widget is self._models))
        return line

    def _options(self, columns: Sequence[Mapping[str, FieldInfo]]) -> QWidget:
        options = QWidget()
        fields = QHBoxLayout(options)
        fields.setContentsMargins(0, SPACING, 0, 0)
        for form, infos in zip(self.forms, columns, strict=True):
            rows = ModelRows(form)
            for name, info in infos.items():
                rows.add_field(name, info)
            form.close_form()
            has_choice = any(get_origin(info.annotation) is Literal for info in infos.values())
            form.setFixedWidth(_FORM_PX + _LABEL_PX * has_choice)
            form.changed.connect(self._show_fields)
            fields.addWidget(form, 0, Qt.AlignmentFlag.AlignTop)
        return options

    def _add_tabs(self, options: QWidget) -> None:
        for label in (self.sentence, self.verdict):
            label.setTextFormat(Qt.TextFormat.PlainText)
        self.plots.hovered.connect(self._hover)
        self.plots.chosen.connect(self.choose)
        for table in (self.table, self.checks):
            table.give_titles(_NAME_PX, _ROW_PX, _CELL_PX)
            table.verticalHeader().setMaximumWidth(_NAME_PX)
            table.verticalHeader().setTextElideMode(Qt.TextElideMode.ElideRight)
        self.table.setMouseTracking(True)
        self.table.entered.connect(lambda index: self._hover(self._offers[index.row()].key))
        self.table.viewport().installEventFilter(self)
        self.table.clicked.connect(lambda index: self.choose(self._offers[index.row()].key))
        self.apply.setToolTip("Add the sensors of the chosen proposal to the rig, as one step.")
        self.apply.clicked.connect(lambda: self.apply_wanted.emit(self._key))
        self.compare.setToolTip("Show the chosen proposal next to the rig in the Compare panel.")
        self.compare.clicked.connect(lambda: self.compare_wanted.emit(self._key))
        self.export.setToolTip("Write the proposals as rig files, and their figures as a table.")
        self.export.clicked.connect(lambda: self.export_wanted.emit())
        buttons, checks = QWidget(), QWidget()
        line = QHBoxLayout(buttons)
        line.setContentsMargins(0, 0, 0, 0)
        line.setSpacing(SPACING - 2)
        for button in (self.apply, self.compare, self.export):
            line.addWidget(button)
        column = QVBoxLayout(checks)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addWidget(self.checks, 1)
        column.addWidget(self.verdict)
        self.tabs.setDocumentMode(True)
        self.tabs.setFixedWidth(options.sizeHint().width())
        for page, title in ((options, "Options"), (self.table, "Proposals"), (checks, "Checks")):
            self.tabs.addTab(page, title)
        self.tabs.setCornerWidget(buttons)

    # ------------------------------------------------------------------ options
    @property
    def models(self) -> tuple[str, ...]:
        """Return the ticked library models."""
        menus = [action.menu() for action in self._model_menu.actions()]
        ticked = [
            action
            for menu in menus
            if isinstance(menu, QMenu)
            for action in menu.actions()
            if action.isChecked()
        ]
        return tuple(str(action.data()) for action in ticked)

    def show_models(self, names: Sequence[str]) -> None:
        """Tick these library models."""
        for maker in self._model_menu.actions():
            menu = maker.menu()
            assert isinstance(menu, QMenu)
            for action in menu.actions():
                action.setChecked(action.data() in names)
        self._name_models()

    def _name_models(self) -> None:
        names = self.models
        words = names[0] if len(names) == 1 else f"{len(names)} models" if names else "Choose models"
        self._models.setText(words)

    @property
    def options(self) -> Any:
        """Return the options that are shown."""
        return self.forms[0].subject.replace(add=self.models)

    def show_options(self, options: Any) -> None:
        """Show what may be added, where, and for which figure."""
        self.show_models(options.add)
        self._show_fields(options)

    def _show_fields(self, options: Any) -> None:
        for form in self.forms:
            form.show_subject(options)

    # ------------------------------------------------------------------ showing
    def show_state(self, state: State) -> None:
        """Show whether a search is running; the proposals come to the front as it starts."""
        if self.start.isEnabled() and state == "running":
            self.tabs.setCurrentWidget(self.table)
        self.start.setEnabled(state == "idle")
        for button in (self.pause, self.stop):
            button.setEnabled(state != "idle")
        self.pause.setChecked(state == "paused")
        self.pause.setText("Go on" if state == "paused" else "Pause")
        self.bar.setVisible(state != "idle")
        self.searches.setVisible(state == "idle" and self.searches.count() > 1)

    def show_searches(self, titles: Sequence[str]) -> None:
        """List the searches that can be shown again, the last of which is shown."""
        self.searches.clear()
        self.searches.addItems(titles)
        self.searches.setCurrentIndex(len(titles) - 1)
        self.searches.setVisible(len(titles) > 1)

    def show_progress(self, stage: str, share: float) -> None:
        """Show the stage of the search and the share of it that is done."""
        self.bar.setFormat(stage)
        self.bar.setValue(round(1000 * share))

    def show_sentence(self, text: str) -> None:
        """Show a sentence over the charts; its tooltip has all of it."""
        self.sentence.setText(text)
        self.sentence.setToolTip(plain_tip(text))

    def show_plots(self, plots: Sequence[Plot]) -> None:
        """Show these charts."""
        self.plots.show_plots(plots)

    def show_offers(self, offers: Sequence[Offer]) -> None:
        """Show the rows of the table."""
        self._offers = tuple(offers)
        cells = offer_cells(offers)
        shown = [n for n in range(len(COLUMNS)) if n < _ALWAYS or any(row[n] is not NOTHING for row in cells)]
        self.table.figures.show(
            [Heading(one.title) for one in offers],
            [COLUMNS[n] for n in shown],
            [[row[n] for n in shown] for row in cells],
        )
        self.export.setEnabled(any(one.key for one in offers))

    def show_checks(self, titles: Sequence[Heading], cells: Sequence[Sequence[Figure]], verdict: str) -> None:
        """Show the rows of the checks, and what they say."""
        self.checks.figures.show(titles, CHECKS, cells)
        self.verdict.setText(verdict)
        self.verdict.setToolTip(plain_tip(verdict))
        self.verdict.setVisible(bool(verdict))

    # ------------------------------------------------------------------ hovering and choosing
    @property
    def key(self) -> str:
        """Return the key of the chosen offer, empty for none."""
        return self._key

    def select(self, key: str) -> None:
        """Choose an offer without asking for more."""
        self._key = key
        self._enable()
        self.selected.emit(key)

    def choose(self, key: str) -> None:
        """Choose an offer as a click does."""
        self.select(key)
        self.chosen.emit(key)

    def _enable(self) -> None:
        for button in (self.apply, self.compare):
            button.setEnabled(bool(self._key))

    def _hover(self, key: str) -> None:
        self.plots.highlight(key)
        self.hovered.emit(key)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Note that the mouse leaves the table."""
        if event.type() == QEvent.Type.Leave:
            self._hover("")
        return super().eventFilter(watched, event)
