"""Build panels and features of the window, in the order of menus and toolbar; dependencies between features are set
here only."""

from __future__ import annotations

from typing import NamedTuple

from PySide6.QtCore import Qt

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
from riglens.app.window.features.frame import FrameView
from riglens.app.window.features.gain_on_car import GainOnCar
from riglens.app.window.features.heat import Heat, RaysShown
from riglens.app.window.features.help import Help
from riglens.app.window.features.keep_out import KeepOutZones
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


class Features(NamedTuple):
    """Everything that the window can do, in the order in which it was built."""

    follow: Follow
    files: Files
    recent: Recent
    exchange: Exchange
    edits: Edits
    clipboard: Clipboard
    sensors: Sensors
    locks: Locks
    failing: Failing
    mirror: Mirror
    placing: Placing
    arrange: Arrange
    view_menu: ViewMenu
    library: LibraryPanel
    views: Views
    saved_views: SavedViews
    heat: Heat
    rays: RaysShown
    picture: Picture
    scene_data: SceneData
    map: Map
    scores: ScoresShown
    preparing: Preparing
    targets: Targets
    objects: Objects
    mounts: Mounts
    detection_range: DetectionRangeShown
    marginals: Marginals
    tolerance: Tolerance
    sweep_field: SweepField
    frame: FrameView
    pick: Pick
    measure: Measure
    sensor_view: SensorView
    target_maps: TargetMaps
    standing: Standing
    audit: Audit
    compare: Compare
    propose: Propose
    gain_on_car: GainOnCar
    keep_out: KeepOutZones
    report: Report
    units: Units
    car: Car
    solid_car: SolidCar
    autosave: Autosave
    drop: Drop
    theme: Theme
    layout: Layout
    help: Help


def add_panels(bench: Workbench) -> None:
    """Put the panels shared by several features into docks; those of single features go next to them."""
    docks, panels = bench.docks, bench.panels
    docks.add("Sensors", panels.tree, AREA.LeftDockWidgetArea)
    docks.add("Inspector", panels.inspector, AREA.RightDockWidgetArea)
    docks.add("Scene", scrolled(panels.scene), AREA.RightDockWidgetArea, beside="Inspector")
    docks.add("Scores", panels.scores, AREA.BottomDockWidgetArea)
    docks.add("Checks", panels.checks, AREA.BottomDockWidgetArea, beside="Scores")


def build_features(bench: Workbench) -> Features:
    """Build every feature on a workbench.

    `Follow` comes first, so that list and view are up to date when the others receive an edit. `Layout` records the
    initial places of the docks, so it comes after all features that add docks.
    """
    return Features(
        follow=(follow := Follow(bench)),
        files=(files := Files(bench)),
        recent=Recent(bench, files),
        exchange=(exchange := Exchange(bench, files)),
        edits=Edits(bench),
        clipboard=Clipboard(bench),
        sensors=(sensors := Sensors(bench)),
        locks=Locks(bench),
        failing=Failing(bench),
        mirror=Mirror(bench),
        placing=Placing(bench),
        arrange=Arrange(bench),
        view_menu=ViewMenu(bench),
        library=LibraryPanel(bench, sensors),
        views=(views := Views(bench)),
        saved_views=SavedViews(bench, views),
        heat=(heat := Heat(bench)),
        rays=RaysShown(bench, heat),
        picture=Picture(bench),
        scene_data=(scene_data := SceneData(bench)),
        map=(map_ := Map(bench)),
        scores=ScoresShown(bench),
        preparing=Preparing(bench),
        targets=(targets := Targets(bench)),
        objects=Objects(bench),
        mounts=(mounts := Mounts(bench)),
        detection_range=DetectionRangeShown(bench),
        marginals=Marginals(bench, targets),
        tolerance=Tolerance(bench, targets),
        sweep_field=SweepField(bench, targets),
        frame=(frame := FrameView(bench, targets)),
        pick=Pick(bench, frame),
        measure=Measure(bench),
        sensor_view=SensorView(bench, frame),
        target_maps=TargetMaps(bench, heat, targets, map_),
        standing=Standing(bench),
        audit=Audit(bench),
        compare=(compare := Compare(bench, files, exchange, targets)),
        propose=(propose := Propose(bench, compare)),
        gain_on_car=GainOnCar(bench, propose),
        keep_out=KeepOutZones(bench, mounts),
        report=Report(bench, compare, propose),
        units=Units(bench),
        car=(car := Car(bench)),
        solid_car=SolidCar(bench),
        autosave=Autosave(bench, files),
        drop=Drop(bench, files, scene_data, car),
        theme=Theme(bench, follow),
        layout=Layout(bench),
        help=Help(bench),
    )
