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

from riglens.core.figures.figure import Figure
from riglens.core.figures.hits import ON_TARGET
from riglens.core.rig.library import default_library
from riglens.core.sensors.registry import kinds
from riglens.widgets.panels.controls.building import button, filled
from riglens.widgets.panels.controls.scrolled import ElidedLabel
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel, plain_tip
from riglens.widgets.panels.fields.form import ChoiceBox, Form
from riglens.widgets.panels.fields.model_rows import ModelRows
from riglens.widgets.panels.figures.table import NOTHING, Cell, FigureTable, Heading
from riglens.widgets.panels.propose.chart import Plot, Plots
from riglens.widgets.panels.propose.shown import CHECKS, COLUMNS, NO_SEARCH, Offer, offer_cells

State = Literal["idle", "running", "paused"]
_FIELD_PX, _CHOICE_PX, _FORM_PX, _BAR_PX = 140, 300, 220, 220
_ALWAYS = 2
"""Columns of the table that are never left out."""
_ROW_PX, _NAME_PX, _CELL_PX = 22, 132, 56
SKIN_TIP = "Colour the car by the gain of one more sensor at each place; follows the rig while it is edited."


class ProposePanel(QWidget):
    """Panel that emits requests and shows results. in_sight, more: the fields of the options that stand beside the
    models, and those under *More*, column by column."""

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
        self,
        options: Any,
        in_sight: Mapping[str, FieldInfo],
        more: Sequence[Mapping[str, FieldInfo]],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        as_panel(self)
        self._offers: tuple[Offer, ...] = ()
        self._key = ""
        self.forms = list[Form]()
        """Forms of the options, one for each field in sight, then one for each column of the others."""
        self.searches = ChoiceBox()
        self.searches.setToolTip("Searches of this session.")
        self.searches.activated.connect(self.search_chosen)
        self.bar = QProgressBar()
        self.bar.setRange(0, 1000)
        self.bar.setFixedWidth(_BAR_PX)
        self.sentence, self.verdict = ElidedLabel(NO_SEARCH), ElidedLabel()
        self.plots = Plots()
        self.plots.hovered.connect(self._hover)
        self.plots.chosen.connect(self.choose)
        commands = self._commands()
        head = filled(QHBoxLayout(), self._models, *self._fields(in_sight), spacing=SPACING)
        head.addStretch(1)
        filled(head, *commands)
        status = filled(QHBoxLayout(), self.sentence, 1, self.searches, self.bar)
        body = filled(QHBoxLayout(), self._tabs(self._options(more)), self.plots, 1, spacing=2 * SPACING)
        rows = filled(QVBoxLayout(self), head, status, body, 1)
        rows.setContentsMargins(MARGIN, SPACING, MARGIN, SPACING)
        rows.setSpacing(SPACING)
        self.show_options(options)
        self.show_state("idle")
        self.show_offers((), ON_TARGET)
        self.show_checks([], [], "")
        self.select("")

    # ------------------------------------------------------------------ building
    def _commands(self) -> tuple[QWidget, ...]:
        self._model_menu = QMenu(self)
        for kind in kinds():
            for maker, entries in default_library().by_maker(kind.name).items():
                menu = self._model_menu.addMenu(f"{kind.title}: {maker}")
                for entry in entries:
                    action = menu.addAction(entry.title)
                    action.setCheckable(True)
                    action.setData(entry.name)
                    action.toggled.connect(lambda _: self._name_models())
        self._models = button(QToolButton(), tip="Library models to choose among.")
        self._models.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._models.setMenu(self._model_menu)
        self.skin = QCheckBox("Gain on car")
        self.skin.setToolTip(SKIN_TIP)
        self.skin.toggled.connect(self.skin_wanted)
        self.start = button(QPushButton("Start"), self.start_wanted)
        self.pause = QPushButton("Pause")
        self.pause.setCheckable(True)
        self.pause.clicked.connect(self.pause_wanted)
        tip = "End the search; the best rig so far stays."
        self.stop = button(QPushButton("Stop"), self.stop_wanted, tip)
        return self.skin, self.start, self.pause, self.stop

    def _fields(self, infos: Mapping[str, FieldInfo]) -> list[Form]:
        found = []
        for name, info in infos.items():
            form = self._form({name: info})
            layout = form.layout()
            assert layout is not None
            layout.setContentsMargins(SPACING, 0, 0, 0)
            form.setFixedWidth(_CHOICE_PX if get_origin(info.annotation) is Literal else _FIELD_PX)
            found.append(form)
        return found

    def _options(self, columns: Sequence[Mapping[str, FieldInfo]]) -> QWidget:
        options = QWidget()
        fields = filled(QHBoxLayout(options), margins=(0, SPACING, 0, 0))
        for infos in columns:
            form = self._form(infos)
            form.setFixedWidth(_FORM_PX)
            fields.addWidget(form, 0, Qt.AlignmentFlag.AlignTop)
        return options

    def _form(self, infos: Mapping[str, FieldInfo]) -> Form:
        form = Form()
        rows = ModelRows(form)
        for name, info in infos.items():
            rows.add_field(name, info)
        form.close_form()
        form.changed.connect(self._show_fields)
        self.forms.append(form)
        return form

    def _tabs(self, options: QWidget) -> QTabWidget:
        self.table, self.checks = FigureTable("Proposed rigs"), FigureTable("Checks of the gain")
        for table in (self.table, self.checks):
            table.give_titles(_NAME_PX, _ROW_PX, _CELL_PX)
            table.verticalHeader().setMaximumWidth(_NAME_PX)
            table.verticalHeader().setTextElideMode(Qt.TextElideMode.ElideRight)
        self.table.setMouseTracking(True)
        self.table.entered.connect(lambda index: self._hover(self._offers[index.row()].key))
        self.table.viewport().installEventFilter(self)
        self.table.clicked.connect(lambda index: self.choose(self._offers[index.row()].key))
        titles = self.table.verticalHeader()
        titles.sectionClicked.connect(lambda row: self.choose(self._offers[row].key))
        tip = "Add the sensors of the chosen proposal to the rig, as one step."
        self.apply = button(QPushButton("Apply"), lambda: self.apply_wanted.emit(self._key), tip)
        tip = "Show the chosen proposal next to the rig in the Compare panel."
        self.compare = button(QPushButton("Compare"), lambda: self.compare_wanted.emit(self._key), tip)
        tip = "Write the proposals as rig files, and their figures as a table."
        self.export = button(QPushButton("Export…"), self.export_wanted, tip)
        buttons, checks = QWidget(), QWidget()
        filled(QHBoxLayout(buttons), self.apply, self.compare, self.export, spacing=SPACING - 2)
        filled(QVBoxLayout(checks), self.checks, 1, self.verdict, spacing=2)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.tabs.setFixedWidth(options.sizeHint().width())
        for page, title in ((self.table, "Proposals"), (checks, "Checks"), (options, "More")):
            self.tabs.addTab(page, title)
        self.tabs.setCornerWidget(buttons)
        return self.tabs

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
        for made in (self.pause, self.stop):
            made.setEnabled(state != "idle")
        self.pause.setChecked(state == "paused")
        self.pause.setText("Resume" if state == "paused" else "Pause")
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

    def show_offers(self, offers: Sequence[Offer], figure: Figure) -> None:
        """Show the rows of the table, with values of a figure."""
        self._offers = tuple(offers)
        cells = offer_cells(offers, figure)
        shown = [n for n in range(len(COLUMNS)) if n < _ALWAYS or any(row[n] is not NOTHING for row in cells)]
        self.table.figures.show(
            [Heading(one.title) for one in offers],
            [COLUMNS[n] for n in shown],
            [[row[n] for n in shown] for row in cells],
        )
        self.export.setEnabled(any(one.key for one in offers))

    def show_checks(self, titles: Sequence[Heading], cells: Sequence[Sequence[Cell]], verdict: str) -> None:
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
        for made in (self.apply, self.compare):
            made.setEnabled(bool(self._key))

    def _hover(self, key: str) -> None:
        self.plots.highlight(key)
        self.hovered.emit(key)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Note that the mouse leaves the table."""
        if event.type() == QEvent.Type.Leave:
            self._hover("")
        return super().eventFilter(watched, event)
