"""Places of actions: the sections of the menus and of the toolbar, which features fill in any order."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QMenuBar, QToolBar, QWidget

MENUS = {
    "file": ("&File", "new | open | save | export | end"),
    "edit": ("&Edit", "history | clipboard | sensor"),
    "view": ("&View", "looks | gizmo | shown | docks | window"),
    "sensor": ("&Sensor", "add | edit | fail | place"),
    "scene": ("S&cene", "boxes | body | frames"),
    "study": ("S&tudy", "rigs | checks"),
    "help": ("&Help", "texts"),
}
"""Title and sections by menu; | is a separator. A place is "menu/section"."""
TOOLS = "file | history | add place | gizmo | heat | views picture export"


class Sections:
    """A menu or a toolbar in named sections, each before a separator of its own that is seen where the list has "|".

    Menus leave out separators with nothing between them; in the toolbar every part has something.
    """

    def __init__(self, bar: QMenu | QToolBar, sections: str) -> None:
        self._bar = bar
        self._ends: dict[str, QAction] = {}
        for part in sections.split("|"):
            for name in part.split():
                self._ends[name] = bar.addSeparator()
                self._ends[name].setVisible(False)
            self._ends[name].setVisible(True)
        self._ends[name].setVisible(False)

    def add(self, section: str, action: QAction) -> None:
        """Put an action at the end of a section; KeyError for a section that does not exist."""
        self._bar.insertAction(self._ends[section], action)


class Places:
    """Every place for an action: "file/open" in a menu, "history" in the toolbar."""

    def __init__(self, bar: QMenuBar, toolbar: QToolBar) -> None:
        self._toolbar = toolbar
        self._tools = Sections(toolbar, TOOLS)
        self._menus: dict[str, Sections] = {}
        self._bar = bar
        self._menu_widgets: dict[str, QMenu] = {}
        for key, (title, sections) in MENUS.items():
            menu = QMenu(title, bar)
            menu.setToolTipsVisible(True)
            bar.addMenu(menu).setVisible(False)
            self._menu_widgets[key] = menu
            self._menus[key] = Sections(menu, sections)

    def add_to_menu(self, place: str, entry: QAction | QMenu) -> None:
        """Put an action or a submenu at the end of a section, "menu/section"; the menu is seen from then on."""
        menu, section = place.split("/")
        self._menus[menu].add(section, entry.menuAction() if isinstance(entry, QMenu) else entry)
        self._menu_widgets[menu].menuAction().setVisible(True)

    def add_submenu(self, place: str, title: str, actions: Iterable[QAction] = ()) -> QMenu:
        """Put a submenu with these actions at the end of a section, and return it."""
        menu = QMenu(title, self._bar)
        menu.setToolTipsVisible(True)
        menu.addActions(list(actions))
        self.add_to_menu(place, menu)
        return menu

    def add_to_toolbar(self, section: str, entry: QAction | QWidget) -> None:
        """Put an action or a widget at the end of a section of the toolbar."""
        if isinstance(entry, QAction):
            self._tools.add(section, entry)
        else:
            placed = self._toolbar.addWidget(entry)
            self._toolbar.removeAction(placed)
            self._tools.add(section, placed)

    def menu(self, name: str) -> QMenu:
        """Return a whole menu, for inspection."""
        return self._menu_widgets[name]
