"""Locks of sensors come back with their rig file: they guard against slips of the hand in every session."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from riglens.app.window.feature import Feature
from riglens.app.window.settings import Settings

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

KEY = "sensors/locked"
MOST_FILES = 100


class Locks(Feature):
    """Keeps the names of locked sensors by the path of the rig file, in the settings: a rig file holds no locks.

    A rig that was never saved has no path, so its locks end with the session.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.document.opened.connect(self._lock_again)
        self.document.locked_changed.connect(self._note)
        self.document.file_changed.connect(self._note)

    def restore(self, settings: Settings) -> None:
        self._lock_again()

    def _lock_again(self) -> None:
        """Lock what was locked when this file was open last."""
        if self.document.path is not None:
            names = self._kept().get(str(self.document.path.absolute()), [])
            self.document.keep_locked(tuple(name for name in names if isinstance(name, str)))

    def _note(self) -> None:
        path, settings = self.document.path, self.window.settings
        if path is None:
            return
        settings.sync()  # another window may have locked sensors too
        kept, key, names = self._kept(), str(path.absolute()), sorted(self.document.locked)
        if kept.get(key, []) == names:
            return
        kept.pop(key, None)
        newest = {key: names} if names else {}
        settings.write(KEY, newest | dict(list(kept.items())[: MOST_FILES - 1]))
        settings.sync()

    def _kept(self) -> dict[str, list[Any]]:
        """Names by path, the file locked last first."""
        found = self.window.settings.read(KEY, {})
        return {path: names for path, names in found.items() if isinstance(names, list)}
