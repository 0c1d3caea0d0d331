"""Undo and redo."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Edits(Feature):
    """Undo and redo, with the name of the step in the menu."""

    specs = (
        Spec("undo", "Undo", "Take back the last change", "Ctrl+Z", "undo", "edit/history", "history"),
        Spec(
            "redo", "Redo", "Do again what was taken back", "Ctrl+Shift+Z", "redo", "edit/history", "history"
        ),
    )

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(
            undo=partial(self.travel, self.document.undo),
            redo=partial(self.travel, self.document.redo),
        )
        window.rig_shown.connect(self._update)

    def travel(self, step: Callable[[], None]) -> None:
        """Undo or redo; during a drag both only give up the drag."""
        if not self.viewport.cancel_drag():
            step()

    def _update(self) -> None:
        for key, label in (("undo", self.document.undo_label), ("redo", self.document.redo_label)):
            action = self.window.actions_[key]
            action.setEnabled(label is not None)
            action.setText(f"{key.capitalize()} {label}" if label else key.capitalize())
