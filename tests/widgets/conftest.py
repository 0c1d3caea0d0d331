"""A plotter without a window, and contrasts of colours."""

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
import pyvista as pv

from riglens.widgets.drawing.stage import render_window

SIZES_PX = {"even": (320, 200), "odd": (323, 199)}
"""The haze is drawn smaller and stretched, by a whole number or not."""
BOTH_SIZES = pytest.mark.parametrize("plotter", SIZES_PX.values(), ids=SIZES_PX, indirect=True)


@pytest.fixture
def plotter(request: pytest.FixtureRequest) -> Iterator[pv.Plotter]:
    """A small plotter without light and with rough edges."""
    size_px = getattr(request, "param", SIZES_PX["odd"])
    made = pv.Plotter(off_screen=True, window_size=list(size_px), lighting="none")
    render_window(made).SetMultiSamples(0)
    yield made
    made.close()


def contrast(one: Sequence[float], other: Sequence[float]) -> float:
    """Contrast ratio of two colours of red, green and blue up to 1, from 1 to 21 (WCAG 2.2)."""
    dark, light = sorted((_luminance(one), _luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def _luminance(colour: Sequence[float]) -> float:
    parts = np.asarray(colour)
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])
