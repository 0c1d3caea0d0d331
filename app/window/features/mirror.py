"""Mirror pairs: two sensors, one on each side of the car, that move together while they are linked."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.core.errors import InputError
from riglens.core.rig.edits import (
    free_name,
    linked,
    mirrored_name,
    nearest_to_image,
    partner_of,
    unlinked,
    with_mirror_image,
)
from riglens.core.rig.model import Rig

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Mirror(Feature):
    """Makes, links and unlinks mirror pairs; the document keeps them in step."""

    specs = (
        Spec(
            "mirror", "Mirror", "Add the mirror image of the selected sensor; the two then move together", "M",
            "mirror", "sensor/edit",
        ),
        Spec(
            "link", "Link to mirror image",
            "Make a pair of the selected sensor and the one nearest to its mirror image, which moves there",
            "Ctrl+M", menu="sensor/edit",
        ),
        Spec(
            "unlink", "Unlink from mirror image", "Let the selected sensor and its mirror image move alone",
            "Ctrl+Shift+M", menu="sensor/edit",
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(mirror=self.mirror, link=self.link, unlink=self.unlink)
        window.rig_shown.connect(self._update)

    def mirror(self) -> None:
        """Add the mirror image of the selected sensor, linked to it, and select it."""
        name, rig = self.document.selected, self.document.rig
        if name is not None and partner_of(rig, name) is None:
            image = free_name(frozenset(sensor.name for sensor in rig.sensors), mirrored_name(name))
            self._edit(lambda: with_mirror_image(rig, name, image), f"mirror {name}")
            self.document.select(image)

    def link(self) -> None:
        """Link the selected sensor to the one nearest to its mirror image."""
        name, rig = self.document.selected, self.document.rig
        other = nearest_to_image(rig, name) if name is not None and partner_of(rig, name) is None else None
        if name is not None and other is not None:
            if other in self.document.locked:
                self.window.report_error(f"{other} is locked; unlock it in the list of sensors to move it")
                return
            self._edit(lambda: linked(rig, name, other), f"link {name} and {other}")

    def unlink(self) -> None:
        """Dissolve the pair of the selected sensor."""
        name, rig = self.document.selected, self.document.rig
        if name is not None:
            self._edit(lambda: unlinked(rig, name), f"unlink {name}")

    def _edit(self, make: Callable[[], Rig], label: str) -> None:
        def edit() -> None:
            try:
                rig = make()
            except ValueError as error:
                raise InputError(str(error)) from error
            self.document.apply(rig, label)

        self.window.guarded(edit)()

    def _update(self) -> None:
        name, rig, actions = self.document.selected, self.document.rig, self.window.actions_
        partner = partner_of(rig, name) if name is not None else None
        is_alone = name is not None and partner is None
        actions["mirror"].setEnabled(is_alone)
        actions["link"].setEnabled(name is not None and is_alone and nearest_to_image(rig, name) is not None)
        actions["unlink"].setEnabled(partner is not None)
        actions["unlink"].setText(f"Unlink from {partner}" if partner else "Unlink from mirror image")
