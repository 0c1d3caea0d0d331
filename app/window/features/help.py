"""Help: guide, the shortcut sheet, every command by its name, and the purpose of the program."""

from __future__ import annotations

import platform
from contextlib import suppress
from html import escape
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from riglens import core
from riglens.app.window.actions import Actions, Spec, shortcut_text
from riglens.app.window.feature import Feature
from riglens.app.window.places import MENUS, Places
from riglens.app.window.status import TOLD_MS
from riglens.app.window.workbench import Workbench
from riglens.version import installed_version
from riglens.widgets.panels.help.command_palette import Command, CommandPalette
from riglens.widgets.panels.help.shortcut_sheet import Group
from riglens.widgets.panels.scores.text import SIGN_NOTE

ABOUT = (
    "<p><b>RigLens</b> shows how well LiDARs and cameras on a car cover the traffic around it, "
    "after “Influence of Camera-LiDAR Configuration on 3D Object Detection” (ICRA 2024).</p>"
    f"<p>{SIGN_NOTE}</p>"
)

PARTS = {
    **dict.fromkeys(("heat", "class", "view/shown"), "Heatmap"),
    **dict.fromkeys(("theme", "view/window"), "Panels"),
}
"""Headings of their own for parts of the View menu, by group or place."""
SHORT = 38
"""Tooltips up to this length say what an action does; of others the name is enough."""


GREETING = "F1 opens the guide, ? lists keys and mouse, Ctrl+K finds every command."
GREETED_KEY = "tips/closed"
PARTS_NAMED = ("PySide6-Essentials", "vtk", "numba", "numpy")
"""Packages whose versions a problem report should name."""


class Help(Feature):
    """Texts to read, and every command by its name."""

    specs = (
        Spec(
            "commands", "Find a command…", "Type a few letters of any command, model, preset or view.", "Ctrl+K",
            "search", "help/texts",
        ),
        Spec("guide", "Guide", "Read the first five minutes, and the pages linked from there.", "F1", "", "help/texts"),
        Spec("help", "Shortcuts and mouse", "List the keys and mouse buttons.", "?", "", "help/texts"),
        Spec("about", "About RigLens", "Show the version and what is computed.", "Shift+F1", "", "help/texts"),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(
            commands=self.show_commands,
            guide=self.show_guide,
            help=self.show_help,
            about=self.show_about,
        )

    def start(self) -> None:
        """Say where help is, at the first start."""
        if not self.bench.kept.read(GREETED_KEY, False):
            self.bench.kept.write(GREETED_KEY, True)
            self.bench.status.showMessage(GREETING, TOLD_MS)

    def show_commands(self) -> None:
        """Show every command in a list that can be searched by name."""
        CommandPalette(commands_of(self.bench.places, self.actions["commands"]), self.bench.window).show()

    def show_guide(self) -> None:
        """Show the page for beginners."""
        page = guide_page()
        if page is None:
            self.bench.report_error(
                "The guide is not part of this installation; it is docs/first-five-minutes.md."
            )
        else:
            self.bench.dialogs.show_guide(self.bench.window, page)

    def show_help(self) -> None:
        """Show the keys and mouse buttons."""
        groups = sheet(self.actions, self.bench.gestures)
        self.bench.dialogs.show_sheet(self.bench.window, "Shortcuts and mouse", groups)

    def show_about(self) -> None:
        """Show what the program computes, including the sign of S-MS, and its version."""
        self.bench.dialogs.show_text(self.bench.window, "About RigLens", ABOUT + versions_html())


def versions_html() -> str:
    """Return this version, and those of its packages, to be copied into a problem report."""
    found = [f"Python {platform.python_version()}"]
    for name in PARTS_NAMED:
        with suppress(PackageNotFoundError):
            found.append(f"{name} {version(name)}")
    lines = (f"RigLens {installed_version()}", ", ".join(found), platform.platform())
    return f"<p>{'<br>'.join(escape(line) for line in lines)}</p>"


def guide_page() -> Path | None:
    """Return the page for beginners; it is next to the code in a checkout and in an installation."""
    page = Path(core.__file__).resolve().parents[1] / "docs" / "first-five-minutes.md"
    return page if page.is_file() else None


def commands_of(places: Places, itself: QAction) -> list[Command]:
    """Return every action in the menus, including submenus that are filled when opened."""
    found: list[Command] = []
    for key, (title, _) in MENUS.items():
        found += _commands_in(places.menu(key), (_plain(title),), itself)
    return found


def _commands_in(menu: QMenu, way: tuple[str, ...], itself: QAction) -> list[Command]:
    found: list[Command] = []
    for action in menu.actions():
        inner = action.menu()
        if isinstance(inner, QMenu):
            inner.aboutToShow.emit()
            found += _commands_in(inner, (*way, _plain(action.text())), itself)
        elif action.text() and action.isVisible() and not action.isSeparator() and action is not itself:
            found.append(Command(_plain(action.text()), way, shortcut_text(action), action))
    return found


def _plain(text: str) -> str:
    """Return the text of a menu entry without its mnemonic marks."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&").removesuffix("…")


def sheet(actions: Actions, gestures: list[tuple[str, str]]) -> list[Group]:
    """Return every action by its menu, with its keys if any, then the mouse gestures."""
    titles = [title.replace("&", "") for title, _ in MENUS.values()]
    place = titles.index("View") + 1
    titles[place:place] = ["Heatmap", "Panels"]
    rows: dict[str, list[tuple[str, str]]] = {title: [] for title in titles}
    for spec in actions.specs:
        words = spec.tip if len(spec.tip) <= SHORT else _in_its_submenu(actions, spec)
        rows[_heading(spec)].append((actions.keys(spec.key), words))
    groups = [Group(title, tuple(found)) for title, found in rows.items() if found]
    return [*groups, Group("Mouse in the 3D view", tuple(gestures))]


def _in_its_submenu(actions: Actions, spec: Spec) -> str:
    """Return the text of an action after the name of its submenu, without which it would be ambiguous."""
    bars = [title for title, _ in MENUS.values()]
    menus = [menu for menu in actions[spec.key].associatedObjects() if isinstance(menu, QMenu)]
    names = [_plain(menu.title()) for menu in menus if menu.title() and menu.title() not in bars]
    return ": ".join([*names[:1], _plain(spec.text)])


def _heading(spec: Spec) -> str:
    """Return the menu of an action; the long View menu is split into parts."""
    title = "Panels" if spec.key.startswith("dock_") else PARTS.get(spec.group) or PARTS.get(spec.menu)
    return title or MENUS[spec.menu.partition("/")[0]][0].replace("&", "")
