"""How the rays of the sensors are drawn in the view."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.heat import Heat
from riglens.app.window.settings import Settings
from riglens.widgets.panels.look_panels import RaysPanel
from riglens.widgets.sensors.ray_look import LEAST_DENSITY, MOST_DENSITY, RayLook

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Rays(Feature):
    """A switch in the View menu, and sliders below those of the heatmap."""

    specs = (
        Spec("rays", "Rays", "Show the rays of the sensors", "R", menu="view/shown", is_checkable=True),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.panel = RaysPanel()
        window.feature(Heat).add_look(self.panel)
        self.bind(rays=lambda: self.panel.shown.setChecked(window.actions_["rays"].isChecked()))
        self.panel.look_changed.connect(self._show)
        self._show(self.panel.look)

    def restore(self, settings: Settings) -> None:
        look = look_of(settings.read("rays/look", {}))
        if look is not None:
            self.panel.set_look(look)

    def keep(self, settings: Settings) -> None:
        settings.write("rays/look", asdict(self.panel.look))

    def _show(self, look: RayLook) -> None:
        self.window.actions_["rays"].setChecked(look.shown)
        self.viewport.set_ray_look(look)


def look_of(kept: dict[str, Any]) -> RayLook | None:
    """The look of an earlier session, None when it does not say one."""
    opacity, density = kept.get("opacity"), kept.get("density")
    if not (isinstance(opacity, float) and 0.0 <= opacity <= 1.0):
        return None
    if not (isinstance(density, float) and LEAST_DENSITY <= density <= MOST_DENSITY):
        return None
    return RayLook(kept.get("shown") is not False, opacity, density)
