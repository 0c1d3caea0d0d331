"""Base of all features of the window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from PySide6.QtCore import QObject, Qt

from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.actions import Spec
from riglens.app.window.settings import Kept, Settings
from riglens.app.window.workbench import Workbench


class Feature(QObject):
    """One thing that the window can do: its actions and its work. A child of the workbench, gone with it."""

    specs: ClassVar[tuple[Spec, ...]] = ()
    """The actions of this feature, in the order of menu and toolbar."""
    mouse: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Gestures in the 3D view and what they do, for the sheet of shortcuts."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bench = bench
        self.session = bench.session
        self.document = bench.session.document
        self.viewport = bench.viewport
        self.actions = bench.actions
        bench.actions.add(self.specs)
        bench.gestures.extend(self.mouse)
        self._remembered: list[tuple[str, Callable[[], Any], Callable[[Any], object]]] = []
        self.session.scene_changed.connect(self.forget_scene)

    def forget_scene(self) -> None:
        """Release what is held of the scene before: requests, answers; called once there is another scene."""

    def remember(self, key: str, get: Callable[[], Kept], put: Callable[[Kept], object]) -> None:
        """Keep a value between sessions under a key of the settings. `get` must be quick; `put` gets any value of that
        type, the present one where none was kept."""
        self._remembered.append((key, get, put))

    def restore(self, settings: Settings) -> None:
        """Apply the settings of an earlier session; called once all features exist. Expect any value."""
        for key, get, put in self._remembered:
            put(settings.read(key, get()))

    def keep(self, settings: Settings) -> None:
        """Write the settings for the next session; called after changes and at the end, so it must be quick."""
        for key, get, _ in self._remembered:
            settings.write(key, get())

    def serve(
        self,
        worker: BackgroundWorker[Any, Any],
        taken: Callable[..., None],
        refused: Callable[[str], None] | None = None,
    ) -> None:
        """Take the answers of a worker, and its failures, which are messages otherwise; it ends with the window."""
        queued = Qt.ConnectionType.QueuedConnection
        worker.answered.connect(taken, queued)
        worker.failed.connect(refused or self.bench.report_error, queued)
        self.bench.closing.connect(worker.close)

    def bind(self, **slots: Callable[[], object]) -> None:
        """Connect the actions to their functions, by key."""
        self.actions.bind(**slots)
