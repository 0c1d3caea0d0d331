"""Pictures of the 3D view."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from app.actions import Spec
from app.window.feature import Feature
from app.window.features.files import file_name

if TYPE_CHECKING:
    from app.window.main_window import MainWindow


class Picture(Feature):
    """Saves what is shown as a PNG."""

    specs = (
        Spec(
            "screenshot", "Screenshot…", "Save the 3D view as a PNG picture", "F12", "screenshot",
            "file/export", "export",
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(screenshot=self.screenshot)

    def screenshot(self) -> None:
        """Ask where, and write the 3D view as a PNG."""
        suggestion = Path(file_name(self.document.rig.name, ".png"))
        path = self.window.dialogs.save_picture(self.window, suggestion)
        if path is not None:
            self.window.guarded(self.viewport.screenshot)(path)
