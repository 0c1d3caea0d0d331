"""Several sensors brought in line or evenly spaced, and the menus of the right button in the 3D view."""

from __future__ import annotations

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.sensors import follow_marks, hold_of
from riglens.app.window.workbench import Workbench
from riglens.core.rig.groups import Alignment

ALIGNMENTS: dict[str, Alignment] = {
    "align_left": "left",
    "align_right": "right",
    "align_front": "front",
    "align_rear": "rear",
    "align_centre": "centre",
    "align_height": "height",
}


def _align(key: str, text: str, tip: str, shortcut: str = "") -> Spec:
    return Spec(key, text, f"{tip}; other coordinates and angles are unchanged.", shortcut, menu="sensor")


class Arrange(Feature):
    """Align and Space evenly, each one undo step for all that is selected."""

    specs = (
        _align("align_left", "Left", "Align the selected sensors with the leftmost one (y)"),
        _align("align_right", "Right", "Align the selected sensors with the rightmost one (y)"),
        _align("align_front", "Front", "Align the selected sensors with the foremost one (x)"),
        _align("align_rear", "Rear", "Align the selected sensors with the rearmost one (x)"),
        _align("align_centre", "Centre plane", "Move the selected sensors to the middle plane of the car (y = 0)"),
        _align("align_height", "Same height", "Align the selected sensors with the one selected last (z)"),
        Spec(
            "space", "Space evenly",
            "Space three or more selected sensors evenly between the outermost two, along the axis on which they are "
            "furthest apart.",
            menu="sensor/place",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        alignments = [self.actions[key] for key in ALIGNMENTS]
        self._menu, document = bench.places.add_submenu("sensor/place", "Align", alignments), self.document
        self.bind(
            space=bench.guarded(lambda: document.space(document.chosen)),
            **{
                key: bench.guarded(lambda how=how: document.align(document.chosen, how))
                for key, how in ALIGNMENTS.items()
            },
        )
        follow_marks(self.document, self._update)

    def _update(self) -> None:
        hold, count = hold_of(self.document), len(self.document.chosen)
        for key in ALIGNMENTS:
            is_enough = count > 1 or key == "align_centre"
            self.actions.allow(key, hold or ("" if is_enough else "Select two sensors or more."))
        self._menu.setEnabled(not hold)
        self._menu.menuAction().setToolTip(hold)
        self.actions.allow("space", hold or ("" if count > 2 else "Select three sensors or more."))


ON_NOTHING = (
    "frame_all",
    "iso",
    "top",
    "front",
    "left",
    "rear",
    "right",
    "ortho",
    "save_view",
    "",
    "select_all",
    "paste",
    "",
    "pick",
)
"""Menu entries besides all sensors; an empty key is a separator."""


class ViewMenu(Feature):
    """Context menu of the 3D view: that of the list on a sensor, the view's own elsewhere."""

    mouse = (
        ("Right button on a sensor", "opens its menu; elsewhere the menu of the view"),
        ("Right button, dragged up or down", "zooms"),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.viewport.menu_wanted.connect(self._open)

    def _open(self, name: str | None, place: QPoint) -> None:
        if name is None:
            menu = QMenu(self.bench.window)
            for key in ON_NOTHING:
                if key:
                    menu.addAction(self.actions[key])
                else:
                    menu.addSeparator()
        else:
            if name not in self.document.selection:
                self.document.select(name)
            menu = self.bench.panels.tree.context_menu()
        menu.aboutToHide.connect(menu.deleteLater)
        menu.popup(place)
