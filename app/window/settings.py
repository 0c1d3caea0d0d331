"""Settings of the window, kept between sessions. Reading always gives a value of the right type."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QByteArray, QSettings

Kept = TypeVar("Kept", str, bool, list[Any], dict[str, Any])


class Settings:
    """Values by key, each stored as JSON in an INI file; without a path they are kept in memory only.

    A missing, old or broken file gives defaults; one that cannot be written loses what it should have kept.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._file = QSettings(str(path), QSettings.Format.IniFormat) if path is not None else None
        self._memory: dict[str, str] = {}

    def read(self, key: str, default: Kept) -> Kept:
        """Return the value of a key, or `default` when it is missing or of another type. Check the contents of lists
        and dicts."""
        try:
            found = json.loads(self._text(key))
        except (ValueError, RecursionError):
            return default
        return found if type(found) is type(default) else default

    def read_bytes(self, key: str) -> QByteArray:
        """Return bytes made by Qt, such as the state of a window; empty when there are none."""
        return QByteArray.fromBase64(self.read(key, "").encode("ascii", "ignore"))

    def write(self, key: str, value: str | bool | list[Any] | dict[str, Any]) -> None:
        """Store a value; an unchanged one costs no write."""
        text = json.dumps(value)
        if self._text(key) == text:
            return
        self._memory[key] = text
        if self._file is not None:
            self._file.setValue(key, text)

    def write_bytes(self, key: str, value: QByteArray) -> None:
        """Keep bytes that Qt made."""
        self.write(key, bytes(value.toBase64().data()).decode("ascii"))

    def sync(self) -> None:
        """Write to the disk, and see what other windows wrote."""
        if self._file is not None:
            self._file.sync()

    def _text(self, key: str) -> str:
        if self._file is None:
            return self._memory.get(key, "")
        found = self._file.value(key)
        return found if isinstance(found, str) else ""
