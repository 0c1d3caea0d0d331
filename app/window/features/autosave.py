"""Keep unsaved changes through a crash: written in the background, offered at the next start."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

from PySide6.QtCore import QTimer

from riglens.app.background.tasks import Task
from riglens.app.session.autosave import AutosaveFile, Orphan, Unsaved, discard, orphans
from riglens.app.window.feature import Feature
from riglens.app.window.features.files import Files
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.widgets.panels.controls.messages import duration_text

DELAY_MS = 1000


class Autosave(Feature):
    """Autosave that writes the rig a second after the first change that is not written yet, never on the interface
    thread."""

    def __init__(self, bench: Workbench, files: Files) -> None:
        super().__init__(bench)
        self._files = files
        self._file: AutosaveFile | None = None
        self._writing: Task | None = None
        self._folder: Path | None = None
        self._is_recovering = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(DELAY_MS)
        self._timer.timeout.connect(self._write)
        for changed in (
            self.document.rig_settled, self.document.modified_changed, self.document.file_changed,
        ):  # fmt: skip
            changed.connect(self._on_change)
        bench.closing.connect(self._close)

    def start(self, folder: Path) -> None:
        """Keep unsaved changes in this folder from now on, and offer what others left there."""
        self._folder, self._file = folder, AutosaveFile(folder)
        self.offer()

    # ------------------------------------------------------------------ writing
    def _on_change(self) -> None:
        if self._file is None or self._is_recovering:
            return
        if not self.document.is_modified:
            self._timer.stop()
            self._forget()
        elif not self._timer.isActive():
            self._timer.start()

    def _write(self) -> None:
        if self._file is None or not self.document.is_modified:
            return
        if self._writing is not None or self.document.is_dragging:
            self._timer.start()
            return
        file, state = self._file, Unsaved(self.document.rig, self.document.saved_rig, self.document.path)
        self._writing = self.bench.tasks.run(
            "Autosave", lambda _: file.write(state), lambda _: None, self._written
        )

    def _written(self) -> None:
        self._writing = None
        if not self.document.is_modified:
            self._forget()

    def _forget(self) -> None:
        if self._file is not None and self._writing is None:
            self._file.remove()

    def _close(self) -> None:
        """Discard the recovery file after the user saved or discarded the changes."""
        self._timer.stop()
        if self._writing is not None:
            self._writing.join()
        if self._file is not None:
            self._file.remove()

    # ------------------------------------------------------------------ recovery
    def offer(self) -> None:
        """Ask about the newest rig that a window left behind, if there is any."""
        assert self._folder is not None
        found = orphans(self._folder)
        if not found:
            return
        more = f" ({len(found) - 1} more)" if len(found) > 1 else ""
        self.bench.notes.show_message(
            f"RigLens ended without saving {_title(found[0])}.{more}",
            choices={
                "Recover": partial(self.recover, found[0]),
                "Discard": partial(self.bench.guarded(self.discard), found[0]),
            },
        )

    def recover(self, orphan: Orphan) -> None:
        """Open the rig with its unsaved changes; they are one undo step, and still unsaved."""
        assert self._file is not None
        if not self._files.may_lose_changes():
            self.offer()
            return
        if not self._file.take(orphan):
            self.bench.report_error(f"{_title(orphan)}: already recovered or discarded by another window")
            return
        self._is_recovering = True  # what was taken over stays on the disk until it is written anew
        self._show(orphan.unsaved)
        self._is_recovering = False
        self._on_change()
        self.offer()

    def _show(self, unsaved: Unsaved) -> None:
        try:
            if unsaved.path is None:
                self.document.show(unsaved.base)
            else:
                self.document.open(unsaved.path)
        except InputError as error:
            self.document.show(unsaved.base)
            self.bench.report_error(f"{error}; the changes are recovered without the file")
        self.document.apply(unsaved.rig, "recover unsaved changes")

    def discard(self, orphan: Orphan) -> None:
        """Delete the autosave of a window, and ask about the next; InputError when it cannot be deleted."""
        discard(orphan)
        self.offer()


def _title(orphan: Orphan) -> str:
    path = orphan.unsaved.path
    file = f"{path.name}, " if path is not None else ""
    return f"“{orphan.unsaved.rig.name}” ({file}{duration_text(max(0.0, time.time() - orphan.saved_at))} ago)"
