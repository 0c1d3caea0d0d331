"""View > Ground: blind areas, or how many sensors look where, as a map on the ground that follows edits."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, cast

from PySide6.QtWidgets import QMenu

from riglens.app.evaluation.requests import Result
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.settings import Settings
from riglens.app.window.workbench import Workbench

if TYPE_CHECKING:  # loads the compiler
    from riglens.app.evaluation.ground_map import GroundMode
    from riglens.core.review.blind import BlindMap

WHO = "ground"
MODES: dict[str, tuple[str, str]] = {
    "none": ("Nothing on the ground", "Ground alone"),
    "blind": (
        "Blind areas",
        "Colour the ground within 20 m of the car by how high something must be that a sensor sees there",
    ),
    "overlap": (
        "Overlap of fields of view",
        "Colour the ground within 20 m of the car by how many sensors see an object of 0.80 m there",
    ),
}


class GroundShown(Feature):
    """A choice in the View menu; what it shows costs nothing while it shows nothing."""

    specs = tuple(
        Spec(f"ground_{mode}", text, tip, menu="view", group="ground") for mode, (text, tip) in MODES.items()
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self._mode: GroundMode = "none"
        self._found: BlindMap | None = None
        menu = QMenu("Ground", bench.window)
        for mode in MODES:
            menu.addAction(self.actions[f"ground_{mode}"])
        bench.places.add_to_menu("view/shown", menu)
        self.bind(**{f"ground_{mode}": partial(self.set_mode, mode) for mode in MODES})
        self.actions["ground_none"].setChecked(True)
        bench.answers.answered.connect(self._take)

    def set_mode(self, mode: str) -> None:
        """Choose what lies on the ground: a key of MODES."""
        self._mode = cast("GroundMode", mode)
        self.actions[f"ground_{mode}"].setChecked(True)
        self.session.look_around(WHO, mode != "none")
        self._show()

    def restore(self, settings: Settings) -> None:
        mode = settings.read("ground/shown", "none")
        if mode in MODES:
            self.set_mode(mode)

    def keep(self, settings: Settings) -> None:
        settings.write("ground/shown", self._mode)

    def _take(self, result: Result) -> None:
        self._found = result.blind
        if self._mode != "none":
            self._show()

    def _show(self) -> None:
        state, shown = self.viewport.state, None
        if self._mode != "none" and self._found is not None:
            from riglens.app.evaluation.ground_map import ground_map  # the compiler, loaded by now

            shown = ground_map(self._mode, self._found)
        if shown is not state.ground_map:
            self.viewport.show_state(replace(state, ground_map=shown))
