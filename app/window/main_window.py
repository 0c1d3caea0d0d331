"""The main window: puts document, viewport, panels, background thread and features together."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeVar, cast

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QDockWidget, QMainWindow, QTabWidget, QToolBar, QVBoxLayout, QWidget

from riglens.app.background.recompute import Recompute
from riglens.app.background.tasks import Tasks
from riglens.app.evaluation.options import SceneOptions
from riglens.app.session.document import Document
from riglens.app.window.actions import Actions
from riglens.app.window.dialogs import Dialogs
from riglens.app.window.dock_actions import dock_spec, follow_dock
from riglens.app.window.dock_titles import DockTitles
from riglens.app.window.feature import Feature
from riglens.app.window.features.autosave import Autosave
from riglens.app.window.features.background import Background
from riglens.app.window.features.baseline import Baseline
from riglens.app.window.features.car import Car
from riglens.app.window.features.clipboard import Clipboard
from riglens.app.window.features.compare import Compare
from riglens.app.window.features.drop import Drop
from riglens.app.window.features.edits import Edits
from riglens.app.window.features.exchange import Exchange
from riglens.app.window.features.files import Files
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.heat import Heat
from riglens.app.window.features.help import Help
from riglens.app.window.features.layout import Layout
from riglens.app.window.features.library import LibraryPanel
from riglens.app.window.features.locks import Locks
from riglens.app.window.features.map import Map
from riglens.app.window.features.marginals import Marginals
from riglens.app.window.features.mirror import Mirror
from riglens.app.window.features.pick import Pick
from riglens.app.window.features.picture import Picture
from riglens.app.window.features.placing import Placing
from riglens.app.window.features.rays import Rays
from riglens.app.window.features.recent import Recent
from riglens.app.window.features.scene_data import SceneData, choice_of
from riglens.app.window.features.scores import Scores
from riglens.app.window.features.sensor_view import SensorView
from riglens.app.window.features.sensors import Sensors
from riglens.app.window.features.theme import Theme
from riglens.app.window.features.units import Units
from riglens.app.window.features.views import Views
from riglens.app.window.in_sight import focus_next_in_sight
from riglens.app.window.places import Places
from riglens.app.window.settings import Settings
from riglens.app.window.status import StatusBar
from riglens.app.window.viewport_widget import ViewportWidget
from riglens.core.errors import InputError
from riglens.core.metric.scores import MetricSettings
from riglens.widgets.panels.inspector.panel import Inspector
from riglens.widgets.panels.messages import MessageBar
from riglens.widgets.panels.scene_panel import ScenePanel
from riglens.widgets.panels.scores.panel import ScoresPanel
from riglens.widgets.panels.sensors.tree import SensorTree

FEATURES: tuple[type[Feature], ...] = (
    Files,
    Recent,
    Exchange,
    Edits,
    Clipboard,
    Sensors,
    Locks,
    Mirror,
    Placing,
    LibraryPanel,
    Views,
    Heat,
    Rays,
    Pick,
    Picture,
    SceneData,
    Map,
    SensorView,
    Baseline,
    Scores,
    Marginals,
    Compare,
    Units,
    Follow,
    Car,
    Background,
    Autosave,
    Drop,
    Theme,
    Layout,
    Help,
)
"""Everything the window can do, in the order in which it stands in menus and toolbar."""
DEFAULT_SIZE = QSize(1280, 800)
LEFT_PX, RIGHT_PX, BOTTOM_PX = 304, 320, 200
AREA = Qt.DockWidgetArea
AnyFeature = TypeVar("AnyFeature", bound=Feature)


class MainWindow(QMainWindow):
    """The window over one document. `viewport` is a QWidget with the methods of ViewportWidget.

    The window owns `recompute` and closes it; it starts loading `scene` at once. `kept` are the settings of
    earlier sessions; without them nothing is kept.
    """

    rig_shown = Signal()
    """Viewport, tree and inspector show the rig, selection and hidden sensors of the document."""
    result_shown = Signal(object)
    """An exact Result is shown; it may belong to an earlier rig while the mouse moves on."""
    approximation_shown = Signal(object)
    """An Approximation is shown until the exact scores are there."""
    scene_shown = Signal(object)
    """A LoadedScene took the place of the one before; scores on it follow."""
    settings_changed = Signal()
    """The settings of the metric, or what the heatmap shows, are others."""
    theme_changed = Signal(bool)
    """The window is dark now, or light: whoever drew with colours of the theme draws again."""
    closing = Signal()
    """The window closes for good: stop timers and threads, write what is to be kept."""

    def __init__(
        self,
        document: Document,
        viewport: QWidget,
        recompute: Recompute,
        scene: SceneOptions,
        settings: MetricSettings,
        dialogs: Dialogs | None = None,
        kept: Settings | None = None,
    ) -> None:
        super().__init__()
        self.document = document
        self.viewport = cast(ViewportWidget, viewport)
        self.recompute = recompute
        self.dialogs = dialogs or Dialogs()
        self.settings = kept or Settings()
        self.tree, self.inspector = SensorTree(), Inspector()
        self.scores, self.scene_panel = ScoresPanel(settings), ScenePanel(choice_of(scene))
        self.note_bar, self.message_bar = MessageBar(is_error=False), MessageBar()
        self.status = StatusBar()
        self.tasks = Tasks(self)
        self.docks: dict[str, QDockWidget] = {}
        self._dock_titles = DockTitles(self)
        self.places = Places(self.menuBar(), self._toolbar())
        self.actions_ = Actions(self, self.places)
        self._build_layout(viewport)
        self._features: list[Feature] = []
        for feature in FEATURES:  # a feature may ask for those before it
            self._features.append(feature(self))
        for made in self._features:
            made.restore(self.settings)
        self.feature(Follow).show_all()
        self.feature(SceneData).load(scene)
        self.feature(Scores).request()

    def feature(self, kind: type[AnyFeature]) -> AnyFeature:
        """The window's feature of a class; StopIteration when it has none."""
        return next(feature for feature in self._features if isinstance(feature, kind))

    @property
    def features(self) -> tuple[Feature, ...]:
        """All features, in their order."""
        return tuple(self._features)

    @property
    def is_exact(self) -> bool:
        """Whether everything shown belongs to the rig, scene and settings as they are now."""
        return self.feature(Scores).is_current and not self.feature(SceneData).is_loading

    # ------------------------------------------------------------------ building
    def _build_layout(self, viewport: QWidget) -> None:
        self.setWindowTitle("RigLens")
        self.resize(DEFAULT_SIZE)
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.note_bar)
        column.addWidget(self.message_bar)
        column.addWidget(viewport, 1)
        self.setCentralWidget(centre)
        self.setStatusBar(self.status)
        self.setDockOptions(self.dockOptions() | QMainWindow.DockOption.GroupedDragging)  # tabs drag out
        self.setTabPosition(AREA.AllDockWidgetAreas, QTabWidget.TabPosition.North)
        sensors = self.add_dock("Sensors", self.tree, AREA.LeftDockWidgetArea)
        inspector = self.add_dock("Inspector", self.inspector, AREA.RightDockWidgetArea)
        self.add_dock("Scene", self.scene_panel, AREA.RightDockWidgetArea, beside="Inspector")
        scores = self.add_dock("Scores", self.scores, AREA.BottomDockWidgetArea)
        self.resizeDocks([sensors, inspector], [LEFT_PX, RIGHT_PX], Qt.Orientation.Horizontal)
        self.resizeDocks([scores], [BOTTOM_PX], Qt.Orientation.Vertical)

    def _toolbar(self) -> QToolBar:
        bar = QToolBar("Toolbar", self)
        bar.setObjectName("toolbar")
        bar.setMovable(False)
        bar.setIconSize(QSize(20, 20))
        self.addToolBar(bar)
        return bar

    def add_dock(
        self, title: str, content: QWidget, area: Qt.DockWidgetArea, beside: str | None = None
    ) -> QDockWidget:
        """A dock that can be closed and comes back by the View menu; `beside` makes it a tab of another dock."""
        dock = QDockWidget(title, self)
        dock.setObjectName(title)
        dock.setWidget(content)
        self.addDockWidget(area, dock)
        self.docks[title] = dock
        self._dock_titles.follow(dock)
        spec = dock_spec(title, len(self.docks))
        self.actions_.add((spec,))
        follow_dock(self.actions_[spec.key], dock)
        if beside is not None:
            self.tabifyDockWidget(self.docks[beside], dock)
            self.docks[beside].raise_()
        return dock

    def focusNextPrevChild(self, next: bool) -> bool:
        """Tab and Shift+Tab go to what can be seen only."""
        return focus_next_in_sight(partial(super().focusNextPrevChild, next))

    # ------------------------------------------------------------------ messages
    def report_error(self, message: str, details: str = "") -> None:
        """Say what went wrong, in a bar over the view that stops nothing; details on request."""
        self.message_bar.show_message(message, details)

    def guarded(self, edit: Callable[..., object]) -> Callable[..., None]:
        """An edit whose InputError becomes a message; the panels then show again what is true."""

        def guarded(*values: object) -> None:
            self.viewport.cancel_drag()
            try:
                edit(*values)
            except InputError as error:
                self.report_error(str(error))
                self.feature(Follow).show_all()

        return guarded

    # ------------------------------------------------------------------ end
    def closeEvent(self, event: QCloseEvent) -> None:
        if not self.feature(Files).may_lose_changes():
            event.ignore()
            return
        for feature in self._features:
            feature.keep(self.settings)
        self.settings.sync()
        self.closing.emit()
        self.recompute.close()
        self.viewport.close_viewport()
        super().closeEvent(event)
