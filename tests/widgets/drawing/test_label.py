"""Words in pictures are shown as they are."""

from __future__ import annotations

import pytest

from riglens.widgets.drawing.label import place_text, set_words, text_actor, text_width_px
from riglens.widgets.drawing.packages import load_pyvista


def width_px(words: str) -> float:
    load_pyvista()  # it brings VTK's fonts
    actor = text_actor()
    set_words(actor, words)
    place_text(actor, 0.0, 0.0, 20.0)
    return text_width_px(actor)


@pytest.mark.parametrize("name", ["$a_b$", "a $x$ b $", "$\\frac{1}{2}$"])
def test_dollar_signs_make_no_mathematics(name: str) -> None:
    assert width_px(name) == pytest.approx(width_px(name.replace("$", "S")), rel=0.15, abs=2.0)


def test_control_characters_are_written_out() -> None:
    actor = text_actor()
    set_words(actor, "a\x1bb\nc")
    assert actor.GetInput() == "a\\x1bb\nc"
