"""The shortcut sheet and what the program is about."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.actions import Spec
from app.window.feature import Feature
from app.window.places import MENUS
from widgets.panels.scores_panel import SIGN_NOTE
from widgets.panels.shortcut_sheet import Group

if TYPE_CHECKING:
    from app.window.main_window import MainWindow

ABOUT = (
    "<p><b>RigLens</b> shows how well LiDARs and cameras on a car look at the traffic around it, "
    "after “Influence of Camera-LiDAR Configuration on 3D Object Detection” (ICRA 2024).</p>"
    f"<p>{SIGN_NOTE}</p>"
)


class Help(Feature):
    """Texts to read."""

    specs = (
        Spec("help", "Shortcuts and mouse", "What keys and mouse buttons do", "?; F1", "", "help/texts"),
        Spec("about", "About RigLens", "What this program computes", "", "", "help/texts"),
    )

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(help=self.show_help, about=self.show_about)

    def show_help(self) -> None:
        """What keys and mouse buttons do."""
        self.window.dialogs.show_sheet(self.window, "Shortcuts and mouse", sheet(self.window))

    def show_about(self) -> None:
        """What the program computes, with the sign of S-MS said openly."""
        self.window.dialogs.show_text(self.window, "About RigLens", ABOUT)


def sheet(window: MainWindow) -> list[Group]:
    """Every shortcut by the menu of its action, then what the mouse does."""
    rows: dict[str, list[tuple[str, str]]] = {}
    for spec in window.actions_.specs:
        keys = window.actions_.keys(spec.key)
        if keys:
            rows.setdefault(spec.menu.partition("/")[0], []).append((keys, spec.tip))
    groups = [
        Group(title.replace("&", ""), tuple(rows[menu])) for menu, (title, _) in MENUS.items() if menu in rows
    ]
    if "" in rows:
        groups.append(Group("More", tuple(rows[""])))
    mouse = tuple(row for feature in window.features for row in feature.mouse)
    return [*groups, Group("Mouse in the 3D view", mouse)]
