"""The main window: puts session, view, panels, background thread and features together."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QSize
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QMainWindow, QTabWidget, QToolBar, QVBoxLayout, QWidget

from riglens.app.background.counting import Counter
from riglens.app.background.recompute import Recompute
from riglens.app.session.document import Document
from riglens.app.session.session import Session
from riglens.app.window.build import AREA, Features, add_panels
from riglens.app.window.dialogs import Dialogs
from riglens.app.window.docks import focus_next_in_sight
from riglens.app.window.features.appearance import fitting_size
from riglens.app.window.features.scene_data import choice_of
from riglens.app.window.keeping import Keeping
from riglens.app.window.places import Places
from riglens.app.window.settings import Settings
from riglens.app.window.status import StatusBar
from riglens.app.window.workbench import Bars, Panels, Workbench
from riglens.core.metric.scores import MetricSettings
from riglens.evaluation.options import SceneOptions
from riglens.widgets.panels.checks.panel import ChecksPanel
from riglens.widgets.panels.controls.building import filled, room_around
from riglens.widgets.panels.controls.messages import MessageBar
from riglens.widgets.panels.inspector.panel import Inspector
from riglens.widgets.panels.scene.scene_panel import ScenePanel
from riglens.widgets.panels.scores.panel import ScoresPanel
from riglens.widgets.panels.sensors.tree import SensorTree
from riglens.widgets.viewport.view import View

DEFAULT_SIZE = QSize(1280, 800)


class MainWindow(QMainWindow):
    """The window over one document.

    The window owns `recompute` and `counter` and closes them; it starts loading `scene` at once. `kept` are the
    settings of earlier sessions; without them nothing is kept. What the features share is in `bench`, the features
    themselves are in `features`: the window knows no single feature's work.
    """

    def __init__(
        self,
        document: Document,
        viewport: View,
        recompute: Recompute,
        counter: Counter,
        scene: SceneOptions,
        settings: MetricSettings,
        dialogs: Dialogs | None = None,
        kept: Settings | None = None,
    ) -> None:
        super().__init__()
        self.setWindowTitle("RigLens")
        self.resize(fitting_size(DEFAULT_SIZE, room_around(self).size()))
        self.session = Session(document, settings)
        panels = Panels(
            SensorTree(), Inspector(), ScenePanel(choice_of(scene)), ScoresPanel(settings), ChecksPanel()
        )
        bars = Bars(StatusBar(), MessageBar(is_error=False), MessageBar())
        self._put_in_middle(bars, viewport)
        self.bench = Workbench(
            self, self.session, recompute, counter, viewport, Places(self.menuBar(), self._toolbar()), panels, bars,
            dialogs or Dialogs(), kept or Settings(),
        )  # fmt: skip
        add_panels(self.bench)
        self.features = Features(self.bench)
        for feature in self.features:
            feature.restore(self.bench.kept)
        self._keeping = Keeping(self.bench, self.features)
        self.features.follow.show_all()
        self.features.scene_data.load(scene)
        self.bench.answers.ask()

    @property
    def is_exact(self) -> bool:
        """Return whether everything shown belongs to the rig, scene and settings as they are now."""
        return self.bench.answers.is_current and not self.features.scene_data.is_loading

    # ------------------------------------------------------------------ building
    def _put_in_middle(self, bars: Bars, viewport: View) -> None:
        centre = QWidget()
        filled(QVBoxLayout(centre), bars.notes, bars.errors, viewport, 1, spacing=0)
        self.setCentralWidget(centre)
        self.setStatusBar(bars.status)
        self.setDockOptions(self.dockOptions() | QMainWindow.DockOption.GroupedDragging)  # tabs drag out
        self.setTabPosition(AREA.AllDockWidgetAreas, QTabWidget.TabPosition.North)

    def _toolbar(self) -> QToolBar:
        bar = QToolBar("Toolbar", self)
        bar.setObjectName("toolbar")
        bar.setMovable(False)
        bar.setIconSize(QSize(20, 20))
        self.addToolBar(bar)
        return bar

    def focusNextPrevChild(self, next: bool) -> bool:
        """Move the focus with Tab and Shift+Tab, to visible widgets only."""
        return focus_next_in_sight(partial(super().focusNextPrevChild, next))

    # ------------------------------------------------------------------ end
    def closeEvent(self, event: QCloseEvent) -> None:
        if not self.features.files.may_lose_changes():
            event.ignore()
            return
        self._keeping.keep()
        self.bench.closing.emit()
        self.bench.recompute.close()
        self.bench.counter.close()
        self.bench.viewport.close_viewport()
        super().closeEvent(event)
