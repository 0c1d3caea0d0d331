"""A test object in the view: an upright cylinder where it stands, in the colour of its verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from riglens.core.rig.model import Rig
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.viewport.scene_state import Post, SceneState
from riglens.widgets.viewport.still import render_still

SIZE = (240, 200)


def test_a_post_stands_on_the_ground_and_its_colour_says_whether_it_is_seen() -> None:
    camera = OrbitCamera(focal_m=(-4.0, 0.5, 0.5), distance_m=6.0, azimuth_deg=180.0, elevation_deg=20.0)
    state = SceneState(rig=Rig(), camera=camera, show_legend=False)
    bare = render_still(state, SIZE).astype(int)
    within = camera.project(np.array([(-4.0, 0.5, 0.2), (-4.0, 0.5, 0.9)]), SIZE)[:, :2].round().astype(int)
    above = camera.project(np.array([(-4.0, 0.5, 1.3)]), SIZE)[0, :2].round().astype(int)
    for is_seen, strong, weak in ((False, 0, 1), (True, 1, 0)):
        shown = render_still(replace(state, post=Post(-4.0, 0.5, 0.15, 1.0, is_seen)), SIZE).astype(int)
        for column, row in within:
            assert shown[row, column, strong] > shown[row, column, weak] + 60
        assert np.abs(shown[above[1], above[0]] - bare[above[1], above[0]]).max() <= 3
