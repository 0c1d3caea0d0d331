"""Checks > Audit: the ray outcomes of each sensor, traced in the background on request."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.background.background_requests import AuditRequest
from riglens.app.background.queue import BackgroundRequest
from riglens.app.window.feature import Feature
from riglens.app.window.features.checks import add_check, check_spec
from riglens.app.window.workbench import Workbench
from riglens.widgets.panels.checks.audit import ASKED, OUTDATED, AuditPanel

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.engine.audit import RigAudit

GROUP = "audit"


class Audit(Feature):
    """Audit of the rig that was followed last; after an edit greyed, until rays are followed again."""

    specs = (
        check_spec(
            "audit",
            "Audit",
            "Show where every ray ends: at the car, past the region, in newly covered space.",
        ),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.panel = AuditPanel()
        add_check(bench, "audit", self.panel)
        self.answer: tuple[AuditRequest, RigAudit] | None = None
        self._asked: AuditRequest | None = None
        self.panel.wanted.connect(self.follow_rays)
        self.panel.table.chosen.connect(self.document.select)
        bench.recompute.answered_in_background.connect(self._take, Qt.ConnectionType.QueuedConnection)
        self.document.rig_settled.connect(self._show)
        self.document.failed_changed.connect(self._show)
        self.session.settings_changed.connect(self._show)
        self._show()

    def follow_rays(self) -> None:
        """Trace the rays of the current rig."""
        session = self.session
        if session.scene is None:
            return
        self._asked = AuditRequest(GROUP, "", session.working_rig, session.settings, session.scene)
        self.bench.recompute.ask_in_background([self._asked])
        self._show()

    def _take(self, request: BackgroundRequest, found: RigAudit | None) -> None:
        if isinstance(request, AuditRequest) and request is self._asked:
            self._asked = None
            self.answer = (request, found) if found is not None else None
            self._show()

    def forget_scene(self) -> None:
        """Forget the audit of earlier traffic."""
        self.answer, self._asked = None, None
        self._show()

    def _show(self) -> None:
        if self.answer is None:
            self.panel.show_audits({}, ASKED if self._asked is not None else "", False)
            return
        request, audit = self.answer
        rig, settings = self.session.working_rig, self.session.settings
        is_same_rig = (request.rig.sensors, request.rig.vehicle) == (rig.sensors, rig.vehicle)
        is_current = is_same_rig and request.settings == settings
        note = ASKED if self._asked is not None else "" if is_current else OUTDATED
        self.panel.show_audits({found.name: found for found in audit.sensors}, note, is_current)
