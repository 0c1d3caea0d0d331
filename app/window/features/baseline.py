"""The baseline: the rig that changes of the scores are counted from, the last saved one unless another is pinned."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.exchange import Exchange
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import PRESETS, preset

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Baseline(Feature):
    """Pins rigs; `rig` is what everything is compared with."""

    specs = (
        Spec(
            "pin", "Pin as baseline", "Count all changes of the scores from the rig as it is now", "Ctrl+B", "pin",
            "study/rigs",
        ),
        Spec("pin_file", "Baseline from file…", "Count all changes from a rig file", "Ctrl+Alt+B", menu="study/rigs"),
        Spec(
            "unpin", "Unpin the baseline", "Count all changes from the rig as last saved again",
            "Ctrl+Shift+B", "", "study/rigs",
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._pinned: Rig | None = None
        self.bind(pin=self.pin, pin_file=self._choose_file, unpin=self.unpin)
        presets = self._preset_menu()
        window.places.add_to_menu("study/rigs", presets)
        menu = QMenu(window.scores)
        for entry in (window.actions_["pin"], window.actions_["pin_file"], window.actions_["unpin"]):
            menu.addAction(entry)
        menu.addMenu(presets)
        window.scores.set_pin_menu(menu)
        window.scores.pin_wanted.connect(lambda wanted: self.pin() if wanted else self.unpin())
        self._show()

    @property
    def rig(self) -> Rig:
        """The pinned rig, else the one that was last saved or opened."""
        return self.document.saved_rig if self._pinned is None else self._pinned

    @property
    def is_pinned(self) -> bool:
        """Whether a rig is pinned."""
        return self._pinned is not None

    def pin(self, rig: Rig | None = None) -> None:
        """Make a rig the baseline, the one being edited when none is given."""
        self._pinned = self.document.rig if rig is None else rig
        self._show()

    def unpin(self) -> None:
        """Make the last saved rig the baseline again."""
        self._pinned = None
        self._show()

    def _show(self) -> None:
        name = self._pinned.name if self._pinned is not None else None
        self.window.scores.set_baseline(name)
        self.window.actions_["unpin"].setEnabled(name is not None)
        self.window.settings_changed.emit()

    def _choose_file(self) -> None:
        folder = self.document.path.parent if self.document.path is not None else None
        path = self.window.dialogs.open_rig(self.window, folder)
        if path is not None:
            self.window.guarded(lambda: self.pin(self.window.feature(Exchange).rig_of(path)))()

    def _preset_menu(self) -> QMenu:
        menu = QMenu("Baseline from preset", self.window)
        for name in PRESETS:
            menu.addAction(name, partial(self._pin_preset, name))
        return menu

    def _pin_preset(self, name: str) -> None:
        self.pin(preset(name))
