"""Choose the mode and traffic class of the heatmap, and its drawing and that of the sensors' rays."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import partial
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu, QToolButton, QWidget, QWidgetAction

from riglens.app.window.actions import Choice, Spec, menu_button
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.figures.heatmaps import OFF
from riglens.core.figures.registry import heat_map_named, heat_maps
from riglens.core.footprint.ground import checked_limits
from riglens.core.scene.boxes import CLASSES
from riglens.evaluation.requests import Result
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.panels.controls.icons import swatch
from riglens.widgets.panels.scene.look_panels import HeatPanel, RaysPanel
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, LEAST_DENSITY, MOST_DENSITY, Fill, RayLook
from riglens.widgets.theme import CLASS_COLOURS

SHAPES = {None: "", True: "ground", False: "space"}
"""Names of the choice of the heatmap's shape in the settings; none for what suits the rig."""


class Heat(Feature):
    """Two choices and a panel of sliders in the toolbar; what they choose is the session's."""

    specs = (
        Spec("heat_off", "Off", "Show no heatmap.", "Alt+0", menu="view", group="heat"),
        *(
            Spec(f"class_{name}", name, f"Show heatmap and map for {name}.", menu="view", group="class")
            for name in CLASSES
        ),
        Spec(
            "legend", "Legends", "Show the legends of heatmap, rays and ground.", menu="view/shown", is_checkable=True
        ),
        Spec(
            "heat_space", "Heatmap in space",
            "Show the heatmap as cells in space; off: all heights together on the ground.",
            "V", menu="view/shown", is_checkable=True,
        ),
        Spec(
            "next_class", "Next traffic class", "Show heatmap and map of the next traffic class.", "T",
            menu="view",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        heats = heat_maps()  # now: installed packages may add some
        self.actions.add(
            Spec(f"heat_{heat.key}", heat.title, heat.question, heat.shortcut, menu="view", group="heat")
            for heat in heats
        )
        modes = {key: self.actions[f"heat_{key}"] for key in (OFF, *(heat.key for heat in heats))}
        classes = {name: self.actions[f"class_{name}"] for name in CLASSES}
        for name, action in classes.items():
            action.setIcon(swatch(CLASS_COLOURS[name]))
        self._modes = Choice("heatmap", "Content of the heatmap.", modes)
        self._classes = Choice("class", "Traffic class of heatmap and map.", classes)
        self._classes.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.panel = HeatPanel()
        self._draped: bool | None = None
        """The user's choice; without one the paper's rigs open with cells in space."""
        self._looks = QMenu(bench.window)
        self.add_look(self.panel)
        for widget in (self._modes, self._classes, looks_button(self._looks)):
            bench.places.add_to_toolbar("heat", widget)
        bench.places.add_submenu("view/shown", "Heatmap", modes.values())
        of_class = [*classes.values(), self.actions["next_class"]]
        bench.places.add_submenu("view/shown", "Traffic class", of_class)
        self.bind(
            next_class=self.next_class,
            heat_space=lambda: self.panel.draped.setChecked(not self.actions["heat_space"].isChecked()),
            legend=lambda: self.set_legend(self.actions["legend"].isChecked()),
            **{f"heat_{mode}": partial(self.set_mode, mode) for mode in modes},
            **{f"class_{name}": partial(self.set_class, name) for name in classes},
        )
        self.panel.look_changed.connect(self._show_look)
        self.panel.draped.toggled.connect(self._choose_draped)
        self.document.opened.connect(self._show_draped)
        self._show_draped()
        self.session.heat_changed.connect(self._show)
        bench.answers.answered.connect(self._show_result)
        bench.answers.forgotten.connect(self._show_none)
        self._show()
        self.set_legend(True)
        self._modes.keep_room([heat.title for heat in heats])
        self._classes.keep_room(CLASSES)
        self.remember("heat/mode", lambda: self.session.heat.mode, self.set_mode)
        self.remember("heat/class", lambda: self.session.heat.class_name, self.set_class)
        self.remember("heat/legend", self.actions["legend"].isChecked, self.set_legend)
        self.remember("heat/shape", lambda: SHAPES[self._draped], self._take_shape)
        # a slice left over would hide what is expected
        self.remember("heat/look", lambda: asdict(replace(self.panel.look, slice_m=None)), self._take_look)

    def add_look(self, panel: QWidget) -> None:
        """Put a panel under those that open under the button with the sliders."""
        holder = QWidgetAction(self._looks)
        holder.setDefaultWidget(panel)
        self._looks.addAction(holder)

    def set_legend(self, shown: bool) -> None:
        """Show the legends of heatmap, rays and ground, or none of them."""
        self.actions["legend"].setChecked(shown)
        self.viewport.show_state(replace(self.viewport.state, show_legend=shown))

    def next_class(self) -> None:
        """Choose the class after the one that is shown, after the last the first."""
        shown = CLASSES.index(self.session.heat.class_name)
        self.set_class(CLASSES[(shown + 1) % len(CLASSES)])

    def set_mode(self, mode: str) -> None:
        """Show the heatmap with a key, or none for OFF; nothing happens for an unknown key."""
        if mode == OFF or heat_map_named(mode) is not None:
            self.session.set_heat(replace(self.session.heat, mode=mode))

    def set_class(self, name: str) -> None:
        """Choose the class of traffic that the heatmap is about; nothing happens for one that there is not."""
        if name in CLASSES:
            self.session.set_heat(replace(self.session.heat, class_name=name))

    def _take_look(self, kept: dict[str, Any]) -> None:
        if (look := look_of(kept)) is not None:
            self.panel.set_look(replace(look, draped=self.panel.look.draped))

    def _take_shape(self, kept: str) -> None:
        self._draped = next((choice for choice, name in SHAPES.items() if name == kept), None)
        self._show_draped()

    def _choose_draped(self, is_draped: bool) -> None:
        """Keep a choice; the boxes of a look that is set have their signals blocked."""
        self._draped = is_draped

    def _show_draped(self) -> None:
        """Show a rig as chosen, those of the paper in space."""
        is_draped = self.document.rig.self_occlusion if self._draped is None else self._draped
        self.panel.set_look(replace(self.panel.look, draped=is_draped))

    def _show_look(self, look: HeatLook) -> None:
        self.actions["heat_space"].setChecked(not look.draped)
        self.viewport.show_state(replace(self.viewport.state, heat_look=look))

    def _show_result(self, result: Result) -> None:
        shown = self.session.heat.map
        is_of_voxels = shown is None or shown.needs == "voxels"
        if is_of_voxels:
            self.viewport.show_state(replace(self.viewport.state, heatmap=result.heatmap))
        display = result.scene.heatmaps.display
        self.panel.set_layers(display.cell_m, result.scene.field.grid.roi_m[2])
        if is_of_voxels:
            self.panel.set_data(result.heatmap)

    def _show_none(self) -> None:
        """Show no heatmap: that of the rig before is not about this one."""
        self.viewport.show_state(replace(self.viewport.state, heatmap=None))
        self.panel.set_data(None)

    def _show(self) -> None:
        heat = self.session.heat
        self._modes.show_choice(heat.mode, "Heatmap off" if heat.map is None else heat.map.title)
        self._classes.show_choice(heat.class_name, heat.class_name, with_icon=True)


def looks_button(menu: QMenu) -> QToolButton:
    """Return the toolbar button that opens the sliders."""
    return menu_button(
        "heat_look",
        "sliders",
        "Set threshold, colours, opacity and slice of the heatmap, and the rays of the sensors.",
        menu,
    )


def look_of(kept: dict[str, Any]) -> HeatLook | None:
    """Return the look saved by an earlier session, None if it saved none."""
    threshold, opacity, log = kept.get("threshold"), kept.get("opacity"), kept.get("log")
    shares = [share for share in (threshold, opacity) if isinstance(share, float) and 0.0 <= share <= 1.0]
    return HeatLook(shares[0], log is True, shares[1]) if len(shares) == 2 else None


FILLS: tuple[Fill, ...] = ("none", "ground", "frusta")


def _fill(fill: Fill, text: str, tip: str) -> Spec:
    return Spec(f"fill_{fill}", text, tip, menu="view", group="fill")


class RaysShown(Feature):
    """A switch and a choice of fillings in the View menu, and sliders below those of the heatmap."""

    specs = (
        Spec("rays", "Rays", "Show the rays of the selected sensor.", "R", menu="view/shown", is_checkable=True),
        _fill("none", "None", "Show rays only."),
        _fill("ground", "Footprints on the ground", "Show what cameras resolve and radars reach on the ground."),
        _fill("frusta", "Frusta", "Fill the outside of each field of view, ignoring car and traffic."),
    )  # fmt: skip

    def __init__(self, bench: Workbench, heat: Heat) -> None:
        super().__init__(bench)
        self.panel = RaysPanel()
        heat.add_look(self.panel)
        fills = [self.actions[f"fill_{fill}"] for fill in FILLS]
        bench.places.add_submenu("view/shown", "Fields of view", fills)
        self.bind(
            rays=lambda: self.panel.shown.setChecked(self.actions["rays"].isChecked()),
            **{f"fill_{fill}": partial(self.set_fill, fill) for fill in FILLS},
        )
        self.panel.look_changed.connect(self._show)
        self.remember("rays/look", lambda: asdict(self.panel.look), self._take_look)
        self._show(self.panel.look)

    def set_fill(self, fill: Fill) -> None:
        """Fill the fields of view of sensors: footprints, frusta, or none."""
        self.panel.set_look(replace(self.panel.look, fill=fill))

    def _take_look(self, kept: dict[str, Any]) -> None:
        if (look := ray_look_of(kept)) is not None:
            self.panel.set_look(look)

    def _show(self, look: RayLook) -> None:
        self.actions["rays"].setChecked(look.shown)
        self.actions[f"fill_{look.fill}"].setChecked(True)
        self.viewport.show_state(replace(self.viewport.state, ray_look=look))


def ray_look_of(kept: dict[str, Any]) -> RayLook | None:
    """Return the look saved by an earlier session, None if it saved none."""
    opacity, density = kept.get("opacity"), kept.get("density")
    if not (isinstance(opacity, float) and 0.0 <= opacity <= 1.0):
        return None
    if not (isinstance(density, float) and LEAST_DENSITY <= density <= MOST_DENSITY):
        return None
    fill: Fill = next((fill for fill in FILLS if fill == kept.get("fill")), DEFAULT_RAYS.fill)
    of_all, lattice = (kept.get(name) is True for name in ("of_all", "lattice"))
    try:
        limits = checked_limits(kept.get("px_per_m", DEFAULT_RAYS.px_per_m))
    except (InputError, TypeError, ValueError):
        limits = DEFAULT_RAYS.px_per_m
    return RayLook(kept.get("shown") is not False, opacity, density, fill, of_all, lattice, limits)
