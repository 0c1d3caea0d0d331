"""Keys and menu entries of docks: the first press brings a panel to the front, the next one puts it away."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDockWidget

from riglens.app.window.actions import Spec


def dock_spec(title: str, number: int) -> Spec:
    """The action of the dock that was added as the `number`th."""
    tip = f"Bring the panel {title} to the front, or put it away"
    return Spec(f"dock_{title}", title, tip, f"Ctrl+{number}", menu="view/docks", is_checkable=True)


def follow_dock(action: QAction, dock: QDockWidget) -> None:
    """Have an action toggle a dock, and be ticked while the dock is not put away."""

    def toggle() -> None:
        is_behind = dock.widget().visibleRegion().isEmpty()
        dock.setVisible(is_behind)
        if is_behind:
            dock.raise_()
        action.setChecked(is_behind)

    action.triggered.connect(lambda _: toggle())
    dock.toggleViewAction().toggled.connect(action.setChecked)
