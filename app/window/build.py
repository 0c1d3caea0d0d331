"""Build panels and features of the window, in the order of menus and toolbar; dependencies between features are set
here only."""

from __future__ import annotations

from collections.abc import Iterator

from PySide6.QtCore import Qt

from riglens.app.window.feature import Feature
from riglens.app.window.features.appearance import Layout, Theme, Units
from riglens.app.window.features.arrange import Arrange, ViewMenu
from riglens.app.window.features.audit import Audit
from riglens.app.window.features.autosave import Autosave
from riglens.app.window.features.car import Car, SolidCar
from riglens.app.window.features.compare import Compare
from riglens.app.window.features.detection_range import DetectionRangeShown
from riglens.app.window.features.drop import Drop
from riglens.app.window.features.edits import Clipboard, Edits, Mirror
from riglens.app.window.features.failing import Failing
from riglens.app.window.features.files import Exchange, Files, Recent
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.footprints import Footprints
from riglens.app.window.features.frame import FrameView
from riglens.app.window.features.gain_on_car import GainOnCar
from riglens.app.window.features.heat import Heat, RaysShown
from riglens.app.window.features.help import Help
from riglens.app.window.features.maps import Map, SensorView
from riglens.app.window.features.marginals import Marginals
from riglens.app.window.features.measure import Measure
from riglens.app.window.features.mounts import Mounts
from riglens.app.window.features.objects import Objects
from riglens.app.window.features.pick import Pick
from riglens.app.window.features.picture import Picture
from riglens.app.window.features.preparing import Preparing
from riglens.app.window.features.propose import Propose
from riglens.app.window.features.report import Report
from riglens.app.window.features.scene_data import SceneData
from riglens.app.window.features.scores import ScoresShown
from riglens.app.window.features.sensors import LibraryPanel, Locks, Placing, Sensors
from riglens.app.window.features.standing import Standing
from riglens.app.window.features.sweep_field import SweepField
from riglens.app.window.features.target_maps import TargetMaps
from riglens.app.window.features.targets import Targets
from riglens.app.window.features.tolerance import Tolerance
from riglens.app.window.features.views import SavedViews, Views
from riglens.app.window.workbench import Workbench
from riglens.widgets.panels.controls.scrolled import scrolled

AREA = Qt.DockWidgetArea


def add_panels(bench: Workbench) -> None:
    """Put the panels shared by several features into docks; those of single features go next to them."""
    docks, panels = bench.docks, bench.panels
    docks.add("Sensors", panels.tree, AREA.LeftDockWidgetArea)
    docks.add("Inspector", panels.inspector, AREA.RightDockWidgetArea)
    docks.add("Scene", scrolled(panels.scene), AREA.RightDockWidgetArea, beside="Inspector")
    docks.add("Scores", panels.scores, AREA.BottomDockWidgetArea)
    docks.add("Checks", panels.checks, AREA.BottomDockWidgetArea, beside="Scores")


class Features:
    """Everything that the window can do, built on a workbench in this order.

    `Follow` comes first, so that list and view are up to date when the others receive an edit. `Layout` records the
    initial places of the docks, so it comes after all features that add docks.
    """

    def __init__(self, bench: Workbench) -> None:
        self.follow = Follow(bench)
        self.files = Files(bench)
        self.recent = Recent(bench, self.files)
        self.exchange = Exchange(bench, self.files)
        self.edits = Edits(bench)
        self.clipboard = Clipboard(bench)
        self.sensors = Sensors(bench)
        self.locks = Locks(bench)
        self.failing = Failing(bench)
        self.mirror = Mirror(bench)
        self.placing = Placing(bench)
        self.arrange = Arrange(bench)
        self.view_menu = ViewMenu(bench)
        self.library = LibraryPanel(bench, self.sensors)
        self.views = Views(bench)
        self.saved_views = SavedViews(bench, self.views)
        self.heat = Heat(bench)
        self.rays = RaysShown(bench, self.heat)
        self.scene_data = SceneData(bench)
        self.map = Map(bench)
        self.scores = ScoresShown(bench)
        self.preparing = Preparing(bench)
        self.targets = Targets(bench)
        self.picture = Picture(bench, self.targets)
        self.objects = Objects(bench)
        self.mounts = Mounts(bench)
        self.detection_range = DetectionRangeShown(bench)
        self.marginals = Marginals(bench, self.targets)
        self.tolerance = Tolerance(bench, self.targets)
        self.sweep_field = SweepField(bench, self.targets)
        self.frame = FrameView(bench, self.targets)
        self.pick = Pick(bench, self.frame)
        self.measure = Measure(bench)
        self.sensor_view = SensorView(bench, self.frame)
        self.target_maps = TargetMaps(bench, self.heat, self.targets, self.map)
        self.standing = Standing(bench)
        self.footprints = Footprints(bench)
        self.audit = Audit(bench)
        self.compare = Compare(bench, self.files, self.exchange, self.targets)
        self.propose = Propose(bench, self.compare)
        self.gain_on_car = GainOnCar(bench, self.propose)
        self.report = Report(bench, self.compare, self.propose)
        self.units = Units(bench)
        self.car = Car(bench)
        self.solid_car = SolidCar(bench)
        self.autosave = Autosave(bench, self.files)
        self.drop = Drop(bench, self.files, self.scene_data, self.car)
        self.theme = Theme(bench, self.follow)
        self.layout = Layout(bench)
        self.help = Help(bench)

    def __iter__(self) -> Iterator[Feature]:
        return iter(vars(self).values())
