"""While something moves the car is drawn with its light painted on: it must look like the car at rest."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.profiles import PROFILES
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.drawing.stage import render_window
from riglens.widgets.theme import DARK, LIGHT
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState

AROUND = [OrbitCamera((0.0, 0.0, 0.9), 13.0, azimuth, 18.0) for azimuth in (-50.0, 40.0, 130.0, 220.0)]


def picture(plotter: pv.Plotter, scene: DrawnScene, camera: OrbitCamera, quick: bool) -> np.ndarray:
    scene._body.set_quick(quick)
    scene.set_camera(camera)
    scene.prepare()
    render_window(plotter).Render()
    return np.asarray(plotter.screenshot(None, return_img=True))[:, :, :3].astype(int)


@pytest.mark.parametrize("body", sorted(PROFILES))
def test_a_moving_car_looks_like_the_car_at_rest_from_all_sides(plotter, body):
    scene = DrawnScene(plotter)
    for palette in (DARK, LIGHT):
        scene.show(SceneState(vehicle=Vehicle(body=body), palette=palette))
        for camera in AROUND:
            rest, moving = (picture(plotter, scene, camera, quick) for quick in (False, True))
            off = np.abs(rest - moving).max(axis=2)
            assert (off > 0).sum() > 0, "the two are drawn in different ways"
            assert (off > 60).mean() < 0.01 and off.mean() < 4.0


def test_moving_changes_what_is_seen_of_the_car_and_makes_nothing_anew(plotter):
    scene = DrawnScene(plotter)
    scene.prepare()

    def shown() -> set[str]:
        props = scene._stage.main.GetViewProps()
        return {prop.GetAddressAsString("") for prop in props if prop.GetVisibility()}

    def there() -> set[str]:
        return {prop.GetAddressAsString("") for prop in scene._stage.main.GetViewProps()}

    at_rest, everything = shown(), there()
    scene.set_quick(True)
    assert len(shown()) < len(at_rest) - 5
    scene.show(replace(scene.state, vehicle=Vehicle(length=5.0)))
    assert len(shown()) < len(at_rest) - 5, "another car comes in the middle of a drag"
    scene.show(replace(scene.state, vehicle=Vehicle()))
    moving = there()
    scene.set_quick(False)
    scene.set_quick(True)
    assert there() == moving and len(moving) == len(everything)
