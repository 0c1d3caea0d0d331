"""Rig files opened or saved lately, for File > Open recent."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QMenu

from riglens.app.window.feature import Feature
from riglens.app.window.features.files import Files

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

KEY = "files/recent"
MOST = 10


class Recent(Feature):
    """The list is shared by all windows; files that are gone stay in it, greyed, until it is cleared."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.menu = QMenu("Open recent", window)
        self.menu.setToolTipsVisible(True)
        self.menu.aboutToShow.connect(self.fill)
        window.places.add_to_menu("file/open", self.menu)
        self.document.file_changed.connect(self._note)
        self._note()

    @property
    def paths(self) -> list[Path]:
        """The files, the last one first."""
        return [Path(name) for name in self.window.settings.read(KEY, []) if isinstance(name, str) and name][
            :MOST
        ]

    def _note(self) -> None:
        path = self.document.path
        if path is None:
            return
        self.window.settings.sync()  # another window may have opened files too
        newest = path.absolute()
        names = [str(newest), *(str(other) for other in self.paths if other != newest)]
        self.window.settings.write(KEY, names[:MOST])
        self.window.settings.sync()

    def fill(self) -> None:
        """Make the menu say what the list holds now."""
        self.window.settings.sync()
        self.menu.clear()
        for number, path in enumerate(self.paths, 1):
            title = f"{path.name}  –  {path.parent}".replace("&", "&&")
            action = self.menu.addAction(f"&{number % 10}  {title}", partial(self._open, path))
            is_there = path.is_file()
            action.setEnabled(is_there)
            action.setToolTip(str(path) if is_there else f"{path} is not there any more")
        self.menu.addSeparator()
        clear = self.menu.addAction("Clear list", self.clear)
        clear.setEnabled(bool(self.paths))

    def _open(self, path: Path) -> None:
        self.window.feature(Files).open_path(path)

    def clear(self) -> None:
        """Forget all files."""
        self.window.settings.write(KEY, [])
        self.window.settings.sync()
