"""Everything in the scene that is read: the heatmap's legend, title and table of a picture, numbers of a drag."""

from __future__ import annotations

from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.widgets.heatmap.legend import LegendLayer
from riglens.widgets.viewport.camera import Size
from riglens.widgets.viewport.caption_layer import CaptionLayer
from riglens.widgets.viewport.echo_layer import EchoLayer
from riglens.widgets.viewport.listener import Pixel
from riglens.widgets.viewport.scene_state import SceneState


class WordsLayer:
    """Legend, caption and echo over the scene; `arrange` puts them into their places before each frame."""

    def __init__(self, overlay: vtkRenderer) -> None:
        self._legend, self._caption, self._echo = (
            LegendLayer(overlay),
            CaptionLayer(overlay),
            EchoLayer(overlay),
        )
        self._echo_at: tuple[str, Pixel] = ("", (0.0, 0.0))

    @property
    def legend_texts(self) -> tuple[str, ...]:
        """What the legend of the heatmap says."""
        return self._legend.texts

    def show_legend(self, state: SceneState) -> None:
        """Label the heatmap of a state, or hide the legend."""
        shown = state.heatmap if state.show_legend else None
        self._legend.set_data(shown, state.heat_look, state.palette)

    def show_caption(self, state: SceneState) -> None:
        """Say what the picture of a state is called, and its scores."""
        self._caption.set_caption(state.caption, state.palette)

    def set_echo(self, text: str, pixel: Pixel) -> None:
        """Show a few numbers beside a pixel, or no longer."""
        self._echo_at = (text, pixel)

    def arrange(self, state: SceneState, drawn_cell_m: float | None, size: Size, pixel_ratio: float) -> None:
        """Fit everything to a view of this size, and say which cells of the heatmap are drawn."""
        self._legend.set_drawn(drawn_cell_m)
        self._legend.place(size, pixel_ratio, crowded=bool(state.caption.table))
        self._caption.place(size, pixel_ratio)
        self._echo.show(*self._echo_at, size, pixel_ratio, state.palette)
