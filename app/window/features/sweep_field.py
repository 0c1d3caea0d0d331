"""Sweep this field: the curve of a number field of the inspector beside it; a click on it sets the value."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMenu

from riglens.app.background.field_sweep import Curve, FieldRequest, field_curve
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.feature import Feature
from riglens.app.window.features.targets import Targets
from riglens.app.window.workbench import Workbench
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sweep.fields import VEHICLE, RigField
from riglens.evaluation.known_body import with_known_body
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.inspector.field_curve import FieldCurve

ENTRY = "Sweep this field"
CHANGE = "change of {what} in pp ±{noise}, {frames} frames"
NOISE = ("2 SE", "noise floor + 2 SE")
"""Of the band before mounts off by 1 mm and 0.01° are known, and with them."""
FIGURES = {CAMERA.name: "objects at least 25 px tall", LIDAR.name: "on target"}
OTHER = "detected objects"


class SweepField(Feature):
    """An entry in the menu of each number field; the curve is computed in the background, the latest field wins."""

    def __init__(
        self,
        bench: Workbench,
        targets: Targets,
        maker: BackgroundWorker[FieldRequest, Curve] | None = None,
    ) -> None:
        super().__init__(bench)
        self._targets = targets
        self.maker = maker or BackgroundWorker("sweep of a field", field_curve, self)
        self.curve = FieldCurve(bench.window)
        self._asked: tuple[FieldRequest, NumberEdit] | None = None
        self.serve(self.maker, self._take, self._refuse)
        self.curve.chosen.connect(self._set)
        self.curve.closed.connect(self.maker.drop)
        for edit in bench.panels.inspector.findChildren(NumberEdit):
            if edit.path is not None:
                edit.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
                edit.customContextMenuRequested.connect(partial(self._open_menu, edit))

    def menu_of(self, edit: NumberEdit) -> QMenu:
        """Return the menu of a field: that of its text, and the sweep."""
        menu = edit.createStandardContextMenu()
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.addSeparator()
        add_entry(menu, ENTRY, partial(self.sweep, edit)).setEnabled(self._request(edit) is not None)
        return menu

    def sweep(self, edit: NumberEdit) -> None:
        """Open the curve of a field and ask for its points."""
        request = self._request(edit)
        if request is not None and edit.value is not None:
            self.curve.open_at(edit, request.field.name, edit.value, edit.unit)
            self._asked = request, edit
            self.maker.ask(request)

    def _open_menu(self, edit: NumberEdit, place: QPoint) -> None:
        self.menu_of(edit).popup(edit.mapToGlobal(place))

    def _request(self, edit: NumberEdit) -> FieldRequest | None:
        """Return the request for a field; None if it has no single value, or if there are no objects."""
        answer, names, path = self._targets.answer_on_scene, self.document.selection, edit.path
        if answer is None or edit.value is None or path is None or not edit.isEnabled() or len(names) > 1:
            return None
        if not edit.isVisibleTo(self.bench.panels.inspector):  # of the form of what was selected before
            return None
        rig, owner = self.session.working_rig, names[0] if names else None
        if owner is None:
            if path[0] != VEHICLE:
                return None
            path = path[1:]
        elif owner not in {sensor.name for sensor in rig.sensors}:
            return None
        field = RigField(f"{owner or VEHICLE}: {edit.accessibleName()}", owner, path)
        return FieldRequest(rig, field, with_known_body(self.session.targets, rig), answer.traffic)

    def _take(self, request: FieldRequest, found: Curve) -> None:
        if self._asked is not None and request is self._asked[0]:
            sensor = request.field.sensor
            kind = LIDAR.name if sensor is None else request.rig.sensor(sensor).kind
            frames = min(100, request.traffic.frames)
            what, noise = FIGURES.get(kind, OTHER), NOISE[found.has_floor]
            self.curve.show_points(found.points, CHANGE.format(what=what, noise=noise, frames=frames))

    def _refuse(self, reason: str) -> None:
        self.curve.show_points((), reason)

    def _set(self, value: float) -> None:
        """Set the value, as if it had been typed."""
        asked, self._asked = self._asked, None
        if asked is not None:
            asked[1].edited.emit(value)

    def forget_scene(self) -> None:
        """Forget a request, which holds the traffic before."""
        self._asked = None
