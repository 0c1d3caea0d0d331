"""Keep the view and the panels in step with the document, and pass their edits to it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.rig.model import Rig
from riglens.widgets.timers import Timers, single_shot

PAUSE_MS = 100
"""While something is dragged, list and inspector show where it is at most as often: their painting costs as much as the
view's."""


class Shown(NamedTuple):
    """Parts of a document that are shown."""

    rig: Rig
    saved_rig: Rig
    selection: tuple[str, ...]
    hidden: frozenset[str]
    locked: frozenset[str]
    failed: frozenset[str]


class Follow(Feature):
    """Viewport, tree and inspector on one document: they never talk to each other, so they always agree; in a drag,
    tree and inspector come after the viewport by less than `PAUSE_MS`."""

    def __init__(self, bench: Workbench, timers: Timers = single_shot) -> None:
        super().__init__(bench)
        self._shown: Shown | None = None
        self._in_panels: Shown | None = None
        self._pause = timers(self, PAUSE_MS, self._catch_up)
        for changed in (
            self.document.rig_changed, self.document.selection_changed, self.document.hidden_changed,
            self.document.locked_changed, self.document.failed_changed,
        ):  # fmt: skip
            changed.connect(self._follow)
        self.document.opened.connect(self._forget)
        bench.refused.connect(self.show_all)
        self._connect_panels()
        self._connect_viewport()

    def _connect_panels(self) -> None:
        document, guarded = self.document, self.bench.guarded
        tree, inspector = self.bench.panels.tree, self.bench.panels.inspector
        tree.selected.connect(document.choose)
        tree.enabled_toggled.connect(guarded(document.set_enabled))
        tree.hidden_toggled.connect(document.set_hidden)
        tree.locked_toggled.connect(document.set_locked)
        tree.renamed.connect(guarded(document.rename))
        tree.refused.connect(self.bench.report_error)
        inspector.sensors_edited.connect(guarded(document.replace_sensors))
        inspector.rig_edited.connect(guarded(document.apply))

    def _connect_viewport(self) -> None:
        document, viewport = self.document, self.viewport
        viewport.sensor_picked.connect(document.select)
        viewport.sensor_toggled.connect(document.toggle_selected)
        viewport.drag_started.connect(self._begin_drag)
        viewport.drag_moved.connect(document.preview)
        viewport.sensors_boxed.connect(
            lambda names, removing: (document.choose_fewer if removing else document.choose_more)(names)
        )
        viewport.drag_finished.connect(document.finish_drag)
        viewport.drag_cancelled.connect(document.cancel_drag)

    def _begin_drag(self, names: tuple[str, ...]) -> None:
        """Begin a drag, unless a sensor is locked: then all stay, and the reason is shown."""
        document = self.document
        document.begin_drag(names)
        if not document.is_dragging:
            self.viewport.cancel_drag()
            locked = next(name for name in names if name in document.fixed)
            message = f"{locked} is locked; unlock it in the list of sensors to move it"
            self.bench.report_while(message, lambda: locked in document.fixed)

    def show_all(self) -> None:
        """Update viewport, tree and inspector from the document."""
        self._forget()
        self._follow()

    def _forget(self) -> None:
        self._shown, self._in_panels = None, None

    def _follow(self) -> None:
        """Show the document, unless it is shown already: several signals may belong to one edit."""
        document = self.document
        now = Shown(
            document.rig, document.saved_rig, document.selection, document.hidden, document.locked, document.failed
        )  # fmt: skip
        if now != self._shown:
            self._shown = now
            self._show_in_view(now)
        if not (self.document.is_dragging and self._pause.isActive()):
            self._catch_up()

    def _show_in_view(self, now: Shown) -> None:
        self.viewport.show_state(
            replace(
                self.viewport.state,
                rig=now.rig, hidden=now.hidden, failed=now.failed, selected=self.document.selected,
                also_selected=frozenset(now.selection[:-1]), fixed=self.document.fixed,
            )
        )  # fmt: skip

    def _catch_up(self) -> None:
        """Update panels that differ from the view."""
        now = self._shown
        if now is None or now == self._in_panels:
            return
        self._in_panels = now
        if self.document.is_dragging:
            self._pause.start()
        self.bench.panels.tree.set_failed(now.failed)
        self.bench.panels.tree.set_rig(now.rig, now.hidden, now.selection, now.locked)
        inspector = self.bench.panels.inspector
        inspector.set_saved(now.saved_rig)
        inspector.set_rig(now.rig, now.selection)
        inspector.set_locked(now.locked)
