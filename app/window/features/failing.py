"""Mark sensors as failed, one by one or in groups that fail together, and show the remaining figures."""

from __future__ import annotations

from functools import partial

from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.sensors import NONE_SELECTED, follow_marks
from riglens.app.window.workbench import Workbench
from riglens.core.rig.groups import groups_of
from riglens.core.shown_text import visible
from riglens.widgets.panels.controls.menus import add_entry


class Failing(Feature):
    """Failed sensors: a view of the rig that does not change it, so there is nothing to undo or save."""

    specs = (
        Spec(
            "fail", "Fail or restore",
            "Treat the selected sensors as failed: all figures ignore them; the rig is unchanged.",
            "Ctrl+Shift+E", menu="sensor/fail",
        ),
        Spec("restore_failed", "Restore all failed", "Restore all failed sensors.", menu="sensor/fail"),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(fail=self.toggle, restore_failed=self.restore_all)
        self.menu = bench.places.add_submenu("sensor/fail", "Fail a group")
        self.menu.aboutToShow.connect(lambda: self._fill(self.menu))
        bench.panels.tree.failed_toggled.connect(self.document.set_failed)
        bench.panels.tree.menu_wanted.connect(self._offer_groups)
        self.document.failed_changed.connect(self._update)
        follow_marks(self.document, self._update)

    def toggle(self) -> None:
        """Restore the selected sensors if all have failed, else mark all of them as failed."""
        chosen = self.document.chosen
        self.document.set_failed(chosen, not self.document.failed.issuperset(chosen))

    def restore_all(self) -> None:
        """Restore every sensor."""
        self.document.set_failed(tuple(self.document.failed), False)

    def _groups(self) -> dict[str, tuple[str, ...]]:
        """Return the groups that enabled sensors fail with."""
        return groups_of(sensor for sensor in self.document.rig.sensors if sensor.enabled)

    def _fill(self, menu: QMenu, of: frozenset[str] | None = None) -> None:
        """Offer the groups of the rig, or those of some of its sensors."""
        menu.clear()
        for name, members in self._groups().items():
            if of is not None and of.isdisjoint(members):
                continue
            count = f"{len(members)} sensor{'s' * (len(members) > 1)}"
            failed = self.document.failed.issuperset(members)
            fail = partial(self.document.set_failed, members, not failed)
            action = add_entry(menu, visible(f"{name}  ({count})").replace("&", "&&"), fail)
            action.setToolTip(visible(", ".join(members)))
            action.setCheckable(True)
            action.setChecked(failed)

    def _offer_groups(self, menu: QMenu) -> None:
        """Offer the groups of the selected sensors in the list's context menu."""
        groups = QMenu(self.menu.title(), menu)
        groups.setToolTipsVisible(True)
        self._fill(groups, frozenset(self.document.chosen))
        if groups.actions():
            menu.addMenu(groups)
            menu.addSeparator()

    def _update(self) -> None:
        failed = self.document.failed
        self.actions.allow("fail", "" if self.document.chosen else NONE_SELECTED)
        self.actions.allow("restore_failed", "" if failed else "No sensor is marked as failed.")
        self.menu.menuAction().setEnabled(bool(self._groups()))
        self.bench.status.show_failed(failed)
