"""Where the rays of the selected sensor go: followed by the engine's thread while nobody edits, when asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.background.background_requests import AuditRequest
from riglens.app.background.queue import BackgroundRequest
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.rig.model import Rig
from riglens.widgets.panels.inspector.audit_view import ASKED, NOT_COUNTED

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.engine.audit import RigAudit

GROUP = "audit"


class Audit(Feature):
    """Shows the audit of the rig that was followed last; after an edit greyed, until rays are followed again."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.answer: tuple[AuditRequest, RigAudit] | None = None
        self._asked: AuditRequest | None = None
        inspector = bench.panels.inspector
        inspector.audit_wanted.connect(self.follow_rays)
        bench.recompute.answered_in_background.connect(self._take, Qt.ConnectionType.QueuedConnection)
        self.document.selection_changed.connect(self._show)
        self.document.rig_settled.connect(self._show)
        self.document.failed_changed.connect(self._show)
        self.session.settings_changed.connect(self._show)
        self.session.scene_changed.connect(lambda _: self._forget())
        self._show()

    def follow_rays(self) -> None:
        """Have the rays of the rig as it is now followed."""
        session = self.session
        if session.scene is None:
            return
        rig = self.document.working_rig
        self._asked = AuditRequest(GROUP, "", rig, session.settings, session.scene, session.mesh)
        self.bench.recompute.ask_in_background([self._asked])
        self._show()

    def _take(self, request: BackgroundRequest, found: RigAudit | None) -> None:
        if isinstance(request, AuditRequest) and request is self._asked:
            self._asked = None
            self.answer = (request, found) if found is not None else None
            self._show()

    def _forget(self) -> None:
        self.answer, self._asked = None, None
        self._show()

    def _show(self) -> None:
        """Show the selected sensor's part of what is known."""
        name, inspector = self.document.selected, self.bench.panels.inspector
        if name is None:
            return
        request, audit = self.answer or (None, None)
        found = None if audit is None else audit.of(name)
        if not self.document.working_rig.sensor(name).enabled:
            inspector.show_no_audit(NOT_COUNTED)
        elif found is None or request is None:
            inspector.show_no_audit(ASKED if self._asked is not None else "")
        else:
            inspector.show_audit(found, "blocks", self._is_current(request))

    def _is_current(self, request: AuditRequest) -> bool:
        session = self.session
        same = request.settings == session.settings and request.mesh is session.mesh
        return same and _same_rays(request.rig, self.document.working_rig)


def _same_rays(one: Rig, other: Rig) -> bool:
    return one is other or (one.sensors == other.sensors and one.vehicle == other.vehicle)
