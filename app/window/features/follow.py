"""The panels and the view follow the document, and their edits go to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from riglens.app.window.feature import Feature
from riglens.widgets.viewport.scene_state import ShownRig

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Follow(Feature):
    """Viewport, tree and inspector on one document: they never talk to each other, so they always agree."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        for changed in (
            self.document.rig_changed, self.document.selection_changed, self.document.hidden_changed,
            self.document.locked_changed,
        ):  # fmt: skip
            changed.connect(self.show_all)
        self._connect_panels()
        self._connect_viewport()

    def _connect_panels(self) -> None:
        window, document, guarded = self.window, self.document, self.window.guarded
        window.tree.selected.connect(document.select)
        window.tree.enabled_toggled.connect(guarded(document.set_enabled))
        window.tree.hidden_toggled.connect(document.set_hidden)
        window.tree.locked_toggled.connect(document.set_locked)
        window.tree.renamed.connect(guarded(document.rename))
        window.tree.refused.connect(window.report_error)
        window.inspector.sensor_edited.connect(guarded(document.replace_sensor))
        window.inspector.rig_edited.connect(guarded(document.apply))

    def _connect_viewport(self) -> None:
        document, viewport = self.document, self.viewport
        viewport.sensor_picked.connect(document.select)
        viewport.drag_started.connect(self._begin_drag)
        viewport.drag_moved.connect(document.preview)
        viewport.drag_finished.connect(lambda _: document.finish_drag())
        viewport.drag_cancelled.connect(lambda _: document.cancel_drag())

    def _begin_drag(self, name: str) -> None:
        """Open a drag, unless the sensor is locked: then it stays where it is, and the user hears why."""
        self.document.begin_drag(name)
        if not self.document.is_dragging:
            self.viewport.cancel_drag()
            self.window.report_error(f"{name} is locked; unlock it in the list of sensors to move it")

    def show_all(self) -> None:
        """Bring viewport, tree and inspector in line with the document; the other features follow."""
        document = self.document
        self.viewport.set_rig(ShownRig(document.rig, document.hidden, document.selected, document.fixed))
        self.window.tree.set_rig(document.rig, document.hidden, document.selected, document.locked)
        self.window.inspector.set_saved(document.saved_rig)
        self.window.inspector.set_rig(document.rig, document.selected)
        self.window.inspector.set_locked(document.locked)
        self.window.rig_shown.emit()
