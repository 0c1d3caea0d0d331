"""Interface of a feature to the window: built by the window, handed to every feature."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QMainWindow

from riglens.app.background.counting import Counter
from riglens.app.background.recompute import Recompute
from riglens.app.background.tasks import Tasks
from riglens.app.session.result_store import ResultStore
from riglens.app.session.session import Session
from riglens.app.window.actions import Actions
from riglens.app.window.dialogs import Dialogs
from riglens.app.window.docks import Docks
from riglens.app.window.places import Places
from riglens.app.window.settings import Settings
from riglens.app.window.status import StatusBar
from riglens.core.errors import InputError
from riglens.evaluation.names import label_of
from riglens.widgets.panels.checks.panel import ChecksPanel
from riglens.widgets.panels.controls.messages import MessageBar
from riglens.widgets.panels.inspector.panel import Inspector
from riglens.widgets.panels.scene.scene_panel import ScenePanel
from riglens.widgets.panels.scores.panel import ScoresPanel
from riglens.widgets.panels.sensors.tree import SensorTree
from riglens.widgets.viewport.view import View


@dataclass(frozen=True)
class Panels:
    """The panels that several features work on; a feature's own panel is the feature's."""

    tree: SensorTree
    inspector: Inspector
    scene: ScenePanel
    scores: ScoresPanel
    checks: ChecksPanel


@dataclass(frozen=True)
class Bars:
    """Messages of the window: state at the bottom, notes and errors over the view."""

    status: StatusBar
    notes: MessageBar
    errors: MessageBar


class Workbench(QObject):
    """Requests and results, the view, the panels, and the places for a feature's actions and messages.

    `window` is there as the parent of dialogs and menus, and for its title and layout. `kept` are the settings of
    earlier sessions. `gestures` are those of all features, for the sheet of shortcuts.
    """

    theme_changed = Signal(bool)
    """The theme changed between dark and light: redraw with its colours."""
    refused = Signal()
    """An edit was rejected: show the true state again."""
    closing = Signal()
    """The window closes for good: stop timers and threads, write the settings."""

    def __init__(
        self,
        window: QMainWindow,
        session: Session,
        recompute: Recompute,
        counter: Counter,
        viewport: View,
        places: Places,
        panels: Panels,
        bars: Bars,
        dialogs: Dialogs,
        kept: Settings,
    ) -> None:
        super().__init__(window)
        self.window = window
        self.session = session
        self.recompute = recompute
        self.counter = counter
        self.answers = ResultStore(session, recompute)
        self.viewport = viewport
        self.places = places
        self.panels = panels
        self.status, self.notes, self.errors = bars.status, bars.notes, bars.errors
        self.dialogs = dialogs
        self.kept = kept
        self.actions = Actions(window, places)
        self.docks = Docks(window, self.actions, places)
        self.tasks = Tasks(self)
        self.gestures: list[tuple[str, str]] = []
        self._still_true: tuple[str, Callable[[], bool]] | None = None
        document = session.document
        for changed in (document.rig_settled, document.selection_changed, document.locked_changed):
            changed.connect(self._forget_untrue)
        self._show_tasks()

    def _show_tasks(self) -> None:
        """Show a strip for every long task and report its failures; closing the window cancels it."""
        self.tasks.started.connect(self.status.show_task)
        self.tasks.failed.connect(self.report_error)
        self.closing.connect(self.tasks.close)

    def rest(self) -> None:
        """Release what is of no use until the next edit."""
        self.recompute.rest()
        self.counter.rest()

    def report_error(self, message: str, details: str = "") -> None:
        """Report a failure in a bar over the view that blocks nothing, with details on request."""
        self.errors.show_message(message, details)

    def report_while(self, message: str, is_true: Callable[[], bool]) -> None:
        """Show a message about the rig until it is no longer true."""
        self.report_error(message)
        self._still_true = self.errors.message, is_true

    def _forget_untrue(self) -> None:
        if self._still_true is not None:
            message, is_true = self._still_true
            if self.errors.message != message:
                self._still_true = None
            elif not is_true():
                self._still_true = None
                self.errors.clear()

    def guarded(self, edit: Callable[..., object]) -> Callable[..., None]:
        """Turn the InputError of an edit into a message; the panels then show the true state again."""

        def guarded(*values: object) -> None:
            self.viewport.cancel_drag()
            try:
                edit(*values)
            except InputError as error:
                self.report_error(error.text(label_of))
                self.refused.emit()

        return guarded
