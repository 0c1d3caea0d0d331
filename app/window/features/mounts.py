"""Study > Mounts: what is wrong with the places of the sensors, one line each, while the rig is edited."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal

from riglens.app.background.mounting import MountAnswer, MountChecker, MountRequest
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.widgets.panels.mounts_dialog import USUAL, MountsDialog

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.review.mounts import KeepOut, MountLimits


class Mounts(Feature):
    """Asks with every change while the list is in sight, and not otherwise. What has failed is still mounted."""

    specs = (
        Spec(
            "mounts", "Mounts…",
            "What is wrong with the sensors' places: heights, gaps, spacing, what sticks out, zones to keep clear",
            menu="study/rigs",
        ),
    )  # fmt: skip

    limits_changed = Signal()
    """Other limits are asked for."""

    def __init__(self, bench: Workbench, checker: MountChecker | None = None) -> None:
        super().__init__(bench)
        self.checker = checker or MountChecker(self)
        self.dialog: MountsDialog | None = None
        self._limits: MountLimits | None = None
        self._asked: MountRequest | None = None
        queued = Qt.ConnectionType.QueuedConnection
        self.checker.made.connect(self._take, queued)
        self.checker.failed.connect(bench.report_error, queued)
        bench.closing.connect(self.checker.close)
        self.bind(mounts=self.open)

    def open(self) -> None:
        """Show the list, and keep it up to date until it is put away."""
        if self.dialog is None:
            self.dialog = MountsDialog(self.bench.window)
            self.dialog.chosen.connect(self._select)
            self.dialog.put_away.connect(self._rest)
            self.dialog.file_wanted.connect(self.bench.guarded(self._choose_file))
            self.dialog.usual_wanted.connect(lambda: self._use(None, USUAL))
        if not self.dialog.isVisible():
            self.session.asked_changed.connect(self._ask)
        self.dialog.show()
        self.dialog.raise_()
        self._ask()

    def _rest(self) -> None:
        self.session.asked_changed.disconnect(self._ask)
        self._asked = None

    def _choose_file(self) -> None:
        """Take the limits of a file of requirements, as for `riglens check`; InputError when it has none."""
        folder = None if self.document.path is None else self.document.path.parent
        path = self.bench.dialogs.requirements_file(self.bench.window, folder)
        if path is not None:
            self._use(limits_in(path), path.name)

    def _use(self, limits: MountLimits | None, name: str) -> None:
        self._limits = limits
        if self.dialog is not None:
            self.dialog.show_source(name)
        self.limits_changed.emit()
        self._ask()

    @property
    def keep_out(self) -> tuple[KeepOut, ...]:
        """The zones in which no sensor is to stand, beside those that are painted."""
        from riglens.core.review.mounts import USUAL_KEEP_OUT

        asked = None if self._limits is None else self._limits.keep_out
        return USUAL_KEEP_OUT if asked is None else asked

    def _ask(self) -> None:
        rig, mesh = self.document.rig, self.session.mesh
        if rig.vehicle.has_mesh_file and mesh is None:
            return
        request = MountRequest(rig, mesh, self._limits)
        if request != self._asked:
            self._asked = request
            self.checker.ask(request)

    def _take(self, answer: MountAnswer) -> None:
        """Show an answer; one to an earlier pose too, until the next is there."""
        if self.dialog is not None and self._asked is not None:
            self.dialog.show_lines([(found.sensor, found.text) for found in answer.violations])

    def _select(self, name: str) -> None:
        if any(sensor.name == name for sensor in self.document.rig.sensors):
            self.document.select(name)


def limits_in(path: Path) -> MountLimits:
    """What a file of requirements asks of mounts; InputError when it asks nothing, or is none."""
    from riglens.core.review.requirements import read_requirements

    limits = read_requirements(path).mounts
    if limits is None:
        raise InputError(f"{path}: mounts: found nothing, accepted are limits as for riglens check")
    return limits
