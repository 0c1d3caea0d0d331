"""The shortcut sheet and what the program is about."""

from __future__ import annotations

from riglens.app.window.actions import Actions, Spec
from riglens.app.window.feature import Feature
from riglens.app.window.places import MENUS
from riglens.app.window.workbench import Workbench
from riglens.widgets.panels.scores.text import SIGN_NOTE
from riglens.widgets.panels.shortcut_sheet import Group

ABOUT = (
    "<p><b>RigLens</b> shows how well LiDARs and cameras on a car look at the traffic around it, "
    "after “Influence of Camera-LiDAR Configuration on 3D Object Detection” (ICRA 2024).</p>"
    f"<p>{SIGN_NOTE}</p>"
)

PARTS = {
    **dict.fromkeys(("heat", "class", "view/shown"), "Heatmap"),
    **dict.fromkeys(("theme", "view/docks", "view/window"), "Panels"),
}
"""Headings of their own for parts of the View menu, by group or place."""
SHORT = 38
"""Tooltips up to this length say what an action does; of others the name is enough."""


class Help(Feature):
    """Texts to read."""

    specs = (
        Spec("help", "Shortcuts and mouse", "What keys and mouse buttons do", "?; F1", "", "help/texts"),
        Spec("about", "About RigLens", "What this program computes", "Shift+F1", "", "help/texts"),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(help=self.show_help, about=self.show_about)

    def show_help(self) -> None:
        """What keys and mouse buttons do."""
        groups = sheet(self.actions, self.bench.gestures)
        self.bench.dialogs.show_sheet(self.bench.window, "Shortcuts and mouse", groups)

    def show_about(self) -> None:
        """What the program computes, with the sign of S-MS said openly."""
        self.bench.dialogs.show_text(self.bench.window, "About RigLens", ABOUT)


def sheet(actions: Actions, gestures: list[tuple[str, str]]) -> list[Group]:
    """Every action by its menu, with its keys if it has some, then what the mouse does."""
    titles = [title.replace("&", "") for title, _ in MENUS.values()]
    place = titles.index("View") + 1
    titles[place:place] = ["Heatmap", "Panels"]
    rows: dict[str, list[tuple[str, str]]] = {title: [] for title in titles}
    for spec in actions.specs:
        words = spec.tip if len(spec.tip) <= SHORT else spec.text.removesuffix("…")
        rows[_heading(spec)].append((actions.keys(spec.key), words))
    groups = [Group(title, tuple(found)) for title, found in rows.items() if found]
    return [*groups, Group("Mouse in the 3D view", tuple(gestures))]


def _heading(spec: Spec) -> str:
    """The menu of an action; the long View menu in parts."""
    title = PARTS.get(spec.group) or PARTS.get(spec.menu)
    return title or MENUS[spec.menu.partition("/")[0]][0].replace("&", "")
