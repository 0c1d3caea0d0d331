"""The main window: wires document, viewport, panels and background thread; all follow the document."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QMainWindow,
    QMenu,
    QTabWidget,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from app.actions import VIEWS, Actions, Choice, class_actions, heat_actions
from app.dialogs import Dialogs
from app.document import Document
from app.heatmap import HEAT_TITLES, HeatMode
from app.interrupt import quit_on_interrupt
from app.options import SceneOptions, ScoreOptions
from app.recompute import Recompute
from app.scoring import Approximation, EvaluationRequest, LoadedScene, Result
from app.status import StatusBar, scene_line
from app.window_parts import (
    ABOUT,
    ViewportWidget,
    choice_of,
    file_name,
    free_place,
    help_html,
    menu_button,
    options_of,
)
from core.errors import InputError
from core.geometry import Pose
from core.metric.scores import MetricSettings
from core.rig.library import default_library, sensor_from_model
from core.rig.model import Vehicle
from core.rig.presets import PRESETS, find_rig, preset
from core.scene.boxes import CLASSES
from widgets.panels.icons import icon
from widgets.panels.inspector import Inspector
from widgets.panels.message_bar import MessageBar
from widgets.panels.scene_panel import SceneChoice, ScenePanel
from widgets.panels.scores_panel import ScoresPanel
from widgets.panels.sensor_tree import SensorTree
from widgets.panels.style import apply_style, is_dark
from widgets.theme import palette

DEFAULT_SIZE = QSize(1280, 800)
LEFT_PX, RIGHT_PX, BOTTOM_PX = 240, 300, 170


class MainWindow(QMainWindow):
    """The window over one document. `viewport` is a QWidget with the methods of ViewportWidget.

    The window owns `recompute` and closes it; it starts loading `scene` at once.
    """

    def __init__(
        self,
        document: Document,
        viewport: QWidget,
        recompute: Recompute,
        scene: SceneOptions,
        settings: MetricSettings,
        dialogs: Dialogs | None = None,
    ) -> None:
        super().__init__()
        self.document = document
        self.viewport = cast(ViewportWidget, viewport)
        self.recompute = recompute
        self.dialogs = dialogs or Dialogs()
        self.actions_ = Actions(self)
        self._scene_options = scene
        self._request: EvaluationRequest | None = None
        self._result: Result | None = None
        self._shown_revision = -1
        self._vehicle: Vehicle | None = None
        self._heat: HeatMode = "probability"
        self._heat_class = CLASSES[0]
        self.tree, self.inspector = SensorTree(), Inspector()
        self.scores, self.scene_panel = ScoresPanel(settings), ScenePanel(choice_of(scene))
        self.message_bar, self.status = MessageBar(), StatusBar()
        self._build_layout(viewport)
        self._build_menus()
        self._build_toolbar()
        self._connect()
        self.actions_["both"].setChecked(True)
        self._show_heat_choice()
        self._show_all()
        self.load(scene)
        self._request_scores()

    @property
    def is_exact(self) -> bool:
        """Whether everything shown belongs to the rig, scene and settings as they are now."""
        answered = self._result is not None and self._result.request is self._request
        return answered and not self.status.shows_progress

    # ------------------------------------------------------------------ building
    def _build_layout(self, viewport: QWidget) -> None:
        self.setWindowTitle("RigLens")
        self.resize(DEFAULT_SIZE)
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.message_bar)
        column.addWidget(viewport, 1)
        self.setCentralWidget(centre)
        self.setStatusBar(self.status)
        area = Qt.DockWidgetArea
        sensors = self._dock("Sensors", self.tree, area.LeftDockWidgetArea)
        inspector = self._dock("Inspector", self.inspector, area.RightDockWidgetArea)
        scene = self._dock("Scene", self.scene_panel, area.RightDockWidgetArea)
        scores = self._dock("Scores", self.scores, area.BottomDockWidgetArea)
        self.setTabPosition(area.AllDockWidgetAreas, QTabWidget.TabPosition.North)
        self.tabifyDockWidget(inspector, scene)
        inspector.raise_()
        self.resizeDocks([sensors, inspector], [LEFT_PX, RIGHT_PX], Qt.Orientation.Horizontal)
        self.resizeDocks([scores], [BOTTOM_PX], Qt.Orientation.Vertical)
        self.docks = (sensors, inspector, scene, scores)

    def _dock(self, title: str, content: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(title)
        dock.setWidget(content)
        self.addDockWidget(area, dock)
        return dock

    def _build_menus(self) -> None:
        bar, actions = self.menuBar(), self.actions_
        file = bar.addMenu("&File")
        actions.fill(file, "open")
        file.addMenu(self._preset_menu())
        actions.fill(file, "| save save_as | screenshot | quit")
        actions.fill(bar.addMenu("&Edit"), "undo redo | duplicate delete")
        view = bar.addMenu("&View")
        actions.fill(view, "iso top front left rear frame | move rotate both local |")
        for dock in self.docks:
            view.addAction(dock.toggleViewAction())
        sensor = bar.addMenu("&Sensor")
        self.add_menus = {kind: self._library_menu(kind) for kind in ("lidar", "camera")}
        for menu in self.add_menus.values():
            sensor.addMenu(menu)
        actions.fill(sensor, "| duplicate delete hide")
        actions.fill(bar.addMenu("S&cene"), "boxes_file boxes_folder")
        actions.fill(bar.addMenu("&Help"), "help about")

    def _preset_menu(self) -> QMenu:
        menu = QMenu("Open preset", self)
        for name in PRESETS:
            menu.addAction(name, partial(self.open_preset, name))
        return menu

    def _library_menu(self, kind: Any) -> QMenu:
        menu = QMenu("Add LiDAR" if kind == "lidar" else "Add camera", self)
        menu.setIcon(icon(kind))
        menu.setToolTipsVisible(True)
        for entry in default_library().entries(kind):
            action = menu.addAction(entry.title, partial(self.add_sensor, entry.name))
            action.setToolTip(entry.source)
            action.setObjectName(entry.name)
        return menu

    def _build_toolbar(self) -> None:
        bar = QToolBar("Toolbar", self)
        bar.setObjectName("toolbar")
        bar.setMovable(False)
        bar.setIconSize(QSize(20, 20))
        self.addToolBar(bar)
        self.actions_.fill(bar, "open save | undo redo |")
        for kind, menu in self.add_menus.items():
            bar.addWidget(menu_button(kind, menu))
        self.actions_.fill(
            bar, "duplicate delete hide | move rotate both local | iso top front left rear frame |"
        )
        self._heat_choice = Choice("heatmap", "What the heatmap shows", heat_actions(self, self.set_heat))
        self._class_choice = Choice(
            "class", "Class of traffic of the heatmap", class_actions(self, self.set_heat_class)
        )
        self._class_choice.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        bar.addWidget(self._heat_choice)
        bar.addWidget(self._class_choice)
        self.actions_.fill(bar, "| screenshot")

    def _connect(self) -> None:
        document, tree = self.document, self.tree
        self.actions_.bind(
            open=self.open,
            save=self.save,
            save_as=self.save_as,
            screenshot=self.screenshot,
            quit=self.close,
            undo=partial(self.travel, document.undo),
            redo=partial(self.travel, document.redo),
            duplicate=self.duplicate,
            delete=self.delete,
            hide=self.toggle_hidden,
            frame=self._frame,
            boxes_file=self._choose_box_file,
            boxes_folder=self._choose_box_folder,
            help=self.show_help,
            about=self.show_about,
            **dict.fromkeys(("move", "rotate", "both", "local"), self._set_gizmo),
            **{view: partial(self.viewport.set_view, view) for view in VIEWS},
        )
        document.rig_changed.connect(self._on_rig)
        document.selection_changed.connect(self._show_all)
        document.hidden_changed.connect(self._show_all)
        document.file_changed.connect(self._on_file)
        tree.selected.connect(document.select)
        tree.enabled_toggled.connect(self._guarded(document.set_enabled))
        tree.hidden_toggled.connect(document.set_hidden)
        tree.renamed.connect(self._guarded(document.rename))
        tree.refused.connect(self.report_error)
        self.inspector.sensor_edited.connect(self._guarded(document.replace_sensor))
        self.inspector.rig_edited.connect(self._guarded(document.apply))
        self._connect_viewport()
        self._connect_recompute()

    def _connect_viewport(self) -> None:
        document, viewport = self.document, self.viewport
        viewport.sensor_picked.connect(document.select)
        viewport.drag_started.connect(document.begin_drag)
        viewport.drag_moved.connect(document.preview)
        viewport.drag_finished.connect(lambda _: document.finish_drag())
        viewport.drag_cancelled.connect(lambda _: document.cancel_drag())

    def _connect_recompute(self) -> None:
        queued = Qt.ConnectionType.QueuedConnection
        self.recompute.evaluated.connect(self.show_result, queued)
        self.recompute.approximated.connect(self.show_approximation, queued)
        self.recompute.scene_loaded.connect(self._on_scene, queued)
        self.recompute.load_progress.connect(self.status.show_progress, queued)
        self.recompute.load_ended.connect(self._on_load_ended, queued)
        self.recompute.failed.connect(self.report_error, queued)
        self.status.cancelled.connect(self.recompute.cancel_load)
        self.scores.settings_changed.connect(self._request_scores)
        self.scene_panel.load_wanted.connect(self._load_choice)
        self.scene_panel.file_wanted.connect(self._choose_box_file)
        self.scene_panel.folder_wanted.connect(self._choose_box_folder)

    def _guarded(self, edit: Callable[..., object]) -> Callable[..., None]:
        """An edit whose InputError becomes a message; the panels then show again what is true."""

        def guarded(*values: object) -> None:
            self.viewport.cancel_drag()
            try:
                edit(*values)
            except InputError as error:
                self.report_error(str(error))
                self._show_all()

        return guarded

    def travel(self, step: Callable[[], None]) -> None:
        """Undo or redo; during a drag both only give up the drag."""
        if not self.viewport.cancel_drag():
            step()

    # ------------------------------------------------------------------ following the document
    def _on_rig(self) -> None:
        self._show_all()
        self._request_scores()

    def _show_all(self) -> None:
        """Bring viewport, tree, inspector and actions in line with the document."""
        document = self.document
        self.viewport.set_rig(document.rig, document.hidden, document.selected)
        self._show_vehicle()
        self.tree.set_rig(document.rig, document.hidden, document.selected)
        self.inspector.set_rig(document.rig, document.selected)
        self._update_actions()
        self._update_title()

    def _show_vehicle(self) -> None:
        """Draw another car when the vehicle is another; an unknown body leaves the one shown."""
        vehicle = self.document.rig.vehicle
        if vehicle != self._vehicle:
            self._vehicle = vehicle
            try:
                self.viewport.set_vehicle(vehicle)
            except InputError as error:
                self.report_error(str(error))

    def _update_actions(self) -> None:
        document, actions = self.document, self.actions_
        for key, label in (("undo", document.undo_label), ("redo", document.redo_label)):
            actions[key].setEnabled(label is not None)
            actions[key].setText(f"{key.capitalize()} {label}" if label else key.capitalize())
        for key in ("duplicate", "delete", "hide", "frame"):
            actions[key].setEnabled(document.selected is not None)
        hidden = document.selected in document.hidden
        actions["hide"].setIcon(icon("eye-off" if hidden else "eye"))

    def _update_title(self) -> None:
        document = self.document
        file = document.path.name if document.path is not None else "not saved yet"
        self.setWindowTitle(f"{document.rig.name}[*] ({file}) – RigLens")
        self.setWindowModified(document.is_modified)

    def _on_file(self) -> None:
        self._update_title()
        self._request_scores()

    # ------------------------------------------------------------------ scores and heatmap
    def _request_scores(self, _: object = None) -> None:
        document = self.document
        request = EvaluationRequest(
            document.revision, document.rig, document.saved_rig, self.scores.settings,
            self._heat, self._heat_class, document.is_dragging,
        )  # fmt: skip
        if self._request is not None and self._request.asks_same(request):
            return
        self._request = request
        self.scores.set_stale()
        self.status.set_updating()
        self.recompute.evaluate(request)

    def show_result(self, result: Result) -> None:
        """Show an answer unless a newer one is shown; greyed when the rig has moved on meanwhile."""
        if result.request.revision < self._shown_revision:
            return
        self._result, self._shown_revision = result, result.request.revision
        is_current = result.request is self._request
        self.scores.show_scores(result.evaluation.scores, result.saved_scores)
        if not is_current:
            self.scores.set_stale()
        self.status.show_result(result, is_current)
        self.viewport.set_heatmap(result.heatmap)

    def show_approximation(self, first: Approximation) -> None:
        """Show coarse scores, marked as such, unless something newer is shown; the heatmap waits for the exact ones."""
        if first.request.revision >= self._shown_revision:
            self._shown_revision = first.request.revision
            self.scores.show_estimate(first.scores)
            self.status.show_approximation(first)

    def set_heat(self, mode: str) -> None:
        """Choose what the heatmap shows: a key of HEAT_TITLES."""
        self._heat = cast(HeatMode, mode)
        self._show_heat_choice()
        self._request_scores()

    def set_heat_class(self, name: str) -> None:
        """Choose the class of traffic that the heatmap is about."""
        self._heat_class = name
        self._show_heat_choice()
        self._request_scores()

    def _show_heat_choice(self) -> None:
        self._heat_choice.show_choice(self._heat, f"Heatmap: {HEAT_TITLES[self._heat]}")
        self._class_choice.show_choice(self._heat_class, self._heat_class, with_icon=True)
        self._class_choice.setEnabled(self._heat != "off")

    # ------------------------------------------------------------------ box data
    def load(self, options: SceneOptions) -> None:
        """Load other box data in the background; an automatic voxel edge goes by the rig as it is now."""
        settings = self.scores.settings
        score = ScoreOptions(
            settings.method, settings.reading, settings.camera_weight, self.recompute.threads
        )
        options = options.for_rigs([self.document.rig], score)
        self._scene_options = options
        self.status.show_progress(0.0)
        self.recompute.load(options)

    def _load_choice(self, choice: SceneChoice) -> None:
        self.load(options_of(choice, self._scene_options))

    def _on_scene(self, scene: LoadedScene) -> None:
        self.viewport.set_grid(scene.field.grid)
        self.status.show_scene(scene)
        picked = tried = ""
        if scene.choice is not None:
            picked = f"Auto picked {scene.choice.reason()}. Load picks again, for the rig as it is then."
            tried = "\n".join(scene.choice.lines())
        loaded = choice_of(scene.options, scene.field.grid)
        self.scene_panel.set_loaded(loaded, f"In use: {scene_line(scene)}", picked, tried)
        self.scores.set_stale()

    def _on_load_ended(self, problem: str) -> None:
        self.status.hide_progress()
        if problem:
            self.report_error(problem)

    def _choose_box_file(self) -> None:
        self._choose_boxes(self.dialogs.box_file(self))

    def _choose_box_folder(self) -> None:
        self._choose_boxes(self.dialogs.box_folder(self))

    def _choose_boxes(self, path: Path | None) -> None:
        if path is not None:
            self.scene_panel.choose_boxes(path)
            self.docks[2].show()
            self.docks[2].raise_()

    # ------------------------------------------------------------------ files
    def open(self) -> None:
        """Ask for a rig file and open it."""
        if self._may_lose_changes():
            folder = self.document.path.parent if self.document.path is not None else None
            path = self.dialogs.open_rig(self, folder)
            if path is not None:
                self._guarded(self.document.open)(path)

    def open_preset(self, name: str) -> None:
        if self._may_lose_changes():
            self.document.show(preset(name))

    def save(self) -> bool:
        """Save to the document's file, asking where when it has none; whether it was saved."""
        return self._save_to(self.document.path) if self.document.path is not None else self.save_as()

    def save_as(self) -> bool:
        """Ask where to save; whether it was saved."""
        document = self.document
        return self._save_to(
            self.dialogs.save_rig(self, document.path or Path(file_name(document.rig.name, ".yaml")))
        )

    def _save_to(self, path: Path | None) -> bool:
        if path is None:
            return False
        try:
            self.document.save(path)
        except InputError as error:
            self.report_error(str(error))
            return False
        self.message_bar.clear()
        return True

    def screenshot(self) -> None:
        """Ask where, and write the 3D view as a PNG."""
        path = self.dialogs.save_picture(self, Path(file_name(self.document.rig.name, ".png")))
        if path is not None:
            self._guarded(self.viewport.screenshot)(path)

    def _may_lose_changes(self) -> bool:
        """Whether the rig is saved, or the user does not mind."""
        self.viewport.cancel_drag()
        if not self.document.is_modified:
            return True
        answer = self.dialogs.unsaved(self, self.document.rig.name)
        return answer == "discard" or (answer == "save" and self.save())

    # ------------------------------------------------------------------ sensors
    def add_sensor(self, model: str) -> None:
        """Add a sensor of a library model above the roof and select it."""
        kind = default_library().entry(model).kind
        pose = Pose(free_place(self.document.rig, kind))
        self._guarded(self.document.add)(sensor_from_model(model, f"{kind}_1", pose))

    def duplicate(self) -> None:
        """Add a copy of the selected sensor."""
        if self.document.selected is not None:
            self._guarded(self.document.duplicate)(self.document.selected)

    def delete(self) -> None:
        """Delete the selected sensor."""
        if self.document.selected is not None:
            self._guarded(self.document.delete)(self.document.selected)

    def toggle_hidden(self) -> None:
        """Show or hide the selected sensor."""
        name = self.document.selected
        if name is not None:
            self.document.set_hidden(name, name not in self.document.hidden)

    def _set_gizmo(self) -> None:
        mode = next(key for key in ("move", "rotate", "both") if self.actions_[key].isChecked())
        self.viewport.set_gizmo(mode, "local" if self.actions_["local"].isChecked() else "world")

    def _frame(self) -> None:
        if self.document.selected is not None:
            self.viewport.frame_sensor(self.document.selected)

    # ------------------------------------------------------------------ messages
    def report_error(self, message: str) -> None:
        """Say what went wrong, in a bar over the view that stops nothing."""
        self.message_bar.show_message(message)

    def show_help(self) -> None:
        """What keys and mouse buttons do."""
        self.dialogs.show_text(self, "Shortcuts and mouse", help_html(self.actions_))

    def show_about(self) -> None:
        """What the program computes, with the sign of S-MS said openly."""
        self.dialogs.show_text(self, "About RigLens", ABOUT)

    # ------------------------------------------------------------------ end
    def closeEvent(self, event: QCloseEvent) -> None:
        if not self._may_lose_changes():
            event.ignore()
            return
        self.recompute.close()
        self.viewport.close_viewport()
        super().closeEvent(event)


def open_window(rig: str, scene: SceneOptions, score: ScoreOptions) -> int:
    """Open the window on a rig (a file or a preset) and run it to its end; returns the exit code.

    InputError when the rig cannot be read. Boxes are loaded in the background: the window is there at once,
    and says what is wrong with them.
    """
    found, rig_file = find_rig(rig)
    app = QApplication.instance() or QApplication(["riglens"])
    assert isinstance(app, QApplication)
    apply_style(app)
    from widgets.viewport.viewport import Viewport  # loads VTK, which a check of the rig file does not need

    document = Document(found, rig_file, rig_file.path if rig_file is not None else None)
    settings = MetricSettings(score.method, score.reading, score.camera_weight)
    viewport = Viewport(palette=palette(is_dark()))
    window = MainWindow(document, viewport, Recompute(threads=score.threads), scene, settings)
    with quit_on_interrupt(app):
        window.show()
        return app.exec()
