"""The shortcut sheet and what the program is about."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.actions import Actions, Spec, shortcut_rows
from app.window.feature import Feature
from widgets.panels.scores_panel import SIGN_NOTE

if TYPE_CHECKING:
    from app.window.main_window import MainWindow

MOUSE = (
    ("Left button on a sensor", "selects it"),
    ("Left button on an arrow or ring", "drags the sensor; one drag is one undo step"),
    ("Left button elsewhere", "turns the view"),
    ("Middle button, or Shift and left button", "shifts the view"),
    ("Wheel", "comes nearer to what is under the mouse, or goes away"),
    ("Double click on a sensor", "brings it into the middle of the view"),
    ("Esc during a drag", "puts the sensor back"),
)
ABOUT = (
    "<p><b>RigLens</b> shows how well LiDARs and cameras on a car look at the traffic around it, "
    "after “Influence of Camera-LiDAR Configuration on 3D Object Detection” (ICRA 2024).</p>"
    f"<p>{SIGN_NOTE}</p>"
)


class Help(Feature):
    """Texts to read."""

    specs = (
        Spec("help", "Shortcuts and mouse", "What keys and mouse buttons do", "F1", "", "help/texts"),
        Spec("about", "About RigLens", "What this program computes", "", "", "help/texts"),
    )

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(help=self.show_help, about=self.show_about)

    def show_help(self) -> None:
        """What keys and mouse buttons do."""
        self.window.dialogs.show_text(self.window, "Shortcuts and mouse", help_html(self.window.actions_))

    def show_about(self) -> None:
        """What the program computes, with the sign of S-MS said openly."""
        self.window.dialogs.show_text(self.window, "About RigLens", ABOUT)


def help_html(actions: Actions) -> str:
    """What keys and mouse buttons do, as a table."""
    rows = [*shortcut_rows(actions), *MOUSE]
    cells = "".join(f"<tr><td><b>{key}</b>&nbsp;&nbsp;&nbsp;</td><td>{what}</td></tr>" for key, what in rows)
    return f"<table>{cells}</table>"
