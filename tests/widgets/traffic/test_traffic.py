"""One frame in the 3D view: solids inside their boxes, colours by points, and nothing left behind."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.scene.boxes import CLASSES, rotations_from_yaw
from riglens.widgets.theme import DARK, LIGHT
from riglens.widgets.traffic.frame import (
    ENOUGH_COLOUR,
    FEW_COLOUR,
    MANY_COLOUR,
    MISSED_COLOUR,
    ShownFrame,
    colour_of,
)
from riglens.widgets.traffic.layer import TrafficLayer, box_colours
from riglens.widgets.traffic.shapes import shape_of

STANDING = len(CLASSES)


def frame(*points: int, cls: int = 0, pointed_out: int | None = None) -> ShownFrame:
    count = len(points)
    return ShownFrame(
        np.full(count, cls, np.uint8), np.zeros((count, 3)), np.ones((count, 3)), rotations_from_yaw(np.zeros(count)),
        np.array(points, np.int64), np.zeros((4, 3), np.float32), np.array([True, True, False, False]), 5, pointed_out,
    )  # fmt: skip


@pytest.mark.parametrize("cls", range(STANDING + 1))
def test_a_shape_is_closed_and_stays_in_its_box(cls: int) -> None:
    corners, triangles = shape_of(cls)
    assert (np.abs(corners) <= 0.5 + 1e-12).all()
    edges = Counter(
        tuple(sorted(map(int, (one[k], one[(k + 1) % 3])))) for one in triangles for k in range(3)
    )
    assert set(edges.values()) == {2}, "every edge joins two triangles"


def test_a_shape_fills_its_box_along_all_axes() -> None:
    for cls in range(STANDING + 1):
        corners, _ = shape_of(cls)
        assert np.ptp(corners[:, :2], axis=0) == pytest.approx((1.0, 1.0))
        assert corners[:, 2].max() == 0.5


@pytest.mark.parametrize(
    ("points", "colour"),
    [(0, MISSED_COLOUR), (4, FEW_COLOUR), (5, ENOUGH_COLOUR), (49, ENOUGH_COLOUR), (50, MANY_COLOUR)],
)
def test_colours_follow_the_points(points: int, colour: str) -> None:
    assert colour_of(points, enough=5) == colour


def test_what_is_pointed_out_and_what_stands_around_have_colours_of_their_own() -> None:
    assert box_colours(frame(9, 0, pointed_out=1), DARK) == [ENOUGH_COLOUR, DARK.selected]
    around = box_colours(frame(9, cls=STANDING), DARK)[0]
    assert around not in (ENOUGH_COLOUR, MANY_COLOUR, FEW_COLOUR, MISSED_COLOUR)
    assert around != box_colours(frame(9, cls=STANDING), LIGHT)[0]


def test_a_frame_takes_the_place_of_the_one_before_and_leaves_nothing() -> None:
    renderer = vtkRenderer()
    layer = TrafficLayer(renderer)
    for shown in (frame(3, 4), frame(1), frame()):
        layer.set_frame(shown, LIGHT)
        assert renderer.GetActors().GetNumberOfItems() == (2 if len(shown.cls) else 1)
    layer.set_frame(None, LIGHT)
    assert renderer.GetActors().GetNumberOfItems() == 0
