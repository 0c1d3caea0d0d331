"""Text in panels can be read: WCAG AA asks for a contrast of 4.5 to 1."""

import pytest

from riglens.widgets.theme import DARK_TONES, LIGHT_TONES, Tones, rgb

LEAST = 4.5


def luminance(colour: str) -> float:
    """Relative luminance of a `#rrggbb` colour, WCAG 2.2."""
    parts = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in rgb(colour)]
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]


def contrast(one: str, other: str) -> float:
    """Contrast ratio of two colours, 1 to 21."""
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("tones", [LIGHT_TONES, DARK_TONES], ids=["light", "dark"])
def test_every_ink_can_be_read_on_every_paper(tones: Tones) -> None:
    papers = {"window": tones.window, "panel": tones.panel, "field": tones.field}
    inks = ("text", "muted", "accent", "more", "less", "error")
    found = {
        (ink, paper): contrast(getattr(tones, ink), colour)
        for ink in inks
        for paper, colour in papers.items()
    }
    assert {pair: ratio for pair, ratio in found.items() if ratio < LEAST} == {}
    assert contrast(tones.error, tones.error_field) >= LEAST
    assert contrast(tones.text, tones.chosen) >= LEAST
    assert contrast("#ffffff", tones.selection) >= LEAST
