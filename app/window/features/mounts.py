"""Checks > Mounts: violated limits of the sensors' places, one line each, while the rig is edited."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from riglens.app.background.rig_questions import RigRequest, mount_violations
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.features.checks import LiveCheck, check_spec
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.widgets.panels.checks.mounts import USUAL, MountsPanel

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.review.mounts import MountLimits, Violation


class Mounts(LiveCheck[MountsPanel, "RigRequest[MountLimits | None]", "tuple[Violation, ...]"]):
    """Mounts of all sensors; failed ones are still mounted."""

    specs = (
        check_spec(
            "mounts", "Mounts",
            "Check the mounts: heights, gaps, spacing, overhang, keep-out zones.",
        ),
    )  # fmt: skip

    def __init__(
        self,
        bench: Workbench,
        worker: BackgroundWorker[RigRequest[MountLimits | None], tuple[Violation, ...]] | None = None,
    ) -> None:
        self._limits: MountLimits | None = None
        page = MountsPanel()
        super().__init__(bench, "mounts", page, worker or BackgroundWorker("mounts", mount_violations, bench))
        page.chosen.connect(self._select)
        page.file_wanted.connect(self.bench.guarded(self._choose_file))
        page.usual_wanted.connect(lambda: self._use(None, USUAL))

    def _choose_file(self) -> None:
        """Load the limits of a file of requirements, as for `riglens check`; InputError when it has none."""
        path = self.bench.dialogs.requirements_file(self.bench.window, self.document.folder)
        if path is not None:
            self._use(limits_in(path), path.name)

    def _use(self, limits: MountLimits | None, name: str) -> None:
        self._limits = limits
        self.page.show_source(name)
        self._ask()

    def _request(self) -> RigRequest[MountLimits | None]:
        return RigRequest(self.session.rig, self._limits)

    def _show(self, answer: tuple[Violation, ...]) -> None:
        self.page.show_lines([(found.sensor, found.text) for found in answer])

    def _select(self, name: str) -> None:
        if any(sensor.name == name for sensor in self.document.rig.sensors):
            self.document.select(name)


def limits_in(path: Path) -> MountLimits:
    """Return the mount limits of a requirements file; InputError if it has none or cannot be read."""
    from riglens.core.review.requirements import read_requirements

    limits = read_requirements(path).mounts
    if limits is None:
        raise InputError(f"{path}: needs a section 'mounts', as for riglens check")
    return limits
