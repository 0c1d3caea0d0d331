"""A small label beside the cursor, drawn with the scene so that it never lags behind it."""

from __future__ import annotations

from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.widgets.theme import Palette, rgb
from riglens.widgets.viewport.camera import Size
from riglens.widgets.viewport.label import text_actor

_FONT_PX = 13
_OFFSET_PX = (20.0, 26.0)


class EchoLayer:
    """One text on a panel; hidden while there is nothing to say."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._actor = text_actor()
        self._actor.SetPickable(False)
        self._actor.SetVisibility(False)
        renderer.AddViewProp(self._actor)

    def show(
        self, text: str, pixel: tuple[float, float], size: Size, pixel_ratio: float, palette: Palette
    ) -> None:
        """Show a text to the right of and above a pixel (from the upper left), or where it stays in the view."""
        self._actor.SetVisibility(bool(text))
        if not text:
            return
        style = self._actor.GetTextProperty()
        style.SetFontSize(round(_FONT_PX * pixel_ratio))
        style.SetColor(*rgb(palette.text))
        style.SetBackgroundColor(*rgb(palette.background))
        style.SetBackgroundOpacity(0.88)
        style.SetLineSpacing(1.25)
        self._actor.SetInput("\n".join(f" {line} " for line in text.split("\n")))
        width, height = text_size_px(text, pixel_ratio)
        x = min(pixel[0] + _OFFSET_PX[0] * pixel_ratio, size[0] - width)
        y = min(size[1] - pixel[1] + _OFFSET_PX[1] * pixel_ratio, size[1] - height)
        self._actor.SetPosition(max(0.0, x), max(0.0, y))


def text_size_px(text: str, pixel_ratio: float) -> tuple[float, float]:
    """About the width and height of the panel: enough to keep it inside the view."""
    lines = text.split("\n")
    letter = _FONT_PX * pixel_ratio
    return letter * (0.62 * max(map(len, lines)) + 1.0), letter * (1.6 * len(lines) + 0.4)
