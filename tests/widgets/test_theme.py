"""Text in panels can be read: WCAG AA asks for a contrast of 4.5 to 1."""

import pytest

from riglens.widgets.theme import DARK_TONES, LIGHT_TONES, Tones, rgb
from tests.widgets.conftest import contrast

LEAST = 4.5


@pytest.mark.parametrize("tones", [LIGHT_TONES, DARK_TONES], ids=["light", "dark"])
def test_every_ink_can_be_read_on_every_paper(tones: Tones) -> None:
    papers = {"window": tones.window, "panel": tones.panel, "field": tones.field}
    inks = ("text", "muted", "accent", "more", "less", "error")
    found = {
        (ink, paper): contrast(rgb(getattr(tones, ink)), rgb(colour))
        for ink in inks
        for paper, colour in papers.items()
    }
    assert {pair: ratio for pair, ratio in found.items() if ratio < LEAST} == {}
    assert contrast(rgb(tones.error), rgb(tones.error_field)) >= LEAST
    assert contrast(rgb(tones.text), rgb(tones.chosen)) >= LEAST
    assert contrast(rgb("#ffffff"), rgb(tones.selection)) >= LEAST
