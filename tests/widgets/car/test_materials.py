"""Light and reflections are painted on the car: at rest for the eye that looks, and left alone while it moves."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from riglens.core.rig.model import PARAMETRIC_BODIES, Vehicle
from riglens.core.vehicle.profile import profile_of
from riglens.core.vehicle.wheels import axles_x
from riglens.widgets.car.materials import painted
from riglens.widgets.car.parts import drawn_parts
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


@pytest.mark.parametrize("body", sorted(PARAMETRIC_BODIES))
def test_a_car_at_rest_mirrors_what_its_viewer_sees_in_it(plotter, body):
    scene = DrawnScene(plotter)
    for palette in (DARK, LIGHT):
        scene.show(SceneState(vehicle=Vehicle(body=body), palette=palette))
        picture(plotter, scene, AROUND[0], quick=False)
        for camera in AROUND[1:]:
            moving = picture(plotter, scene, camera, quick=True)
            rest = picture(plotter, scene, camera, quick=False)
            off = np.abs(rest - moving).max(axis=2)
            assert (off > 3).mean() > 0.005, "what was mirrored before is not what is mirrored here"
            assert off.mean() < 6.0, "and it is the same car"
            assert np.array_equal(rest, picture(plotter, scene, camera, quick=True))


@pytest.mark.parametrize("body", sorted(PARAMETRIC_BODIES))
def test_no_look_past_a_wheel_goes_through_the_car(plotter, body):
    vehicle = Vehicle(body=body)
    actors = [part.actor for part in painted(drawn_parts(vehicle), vehicle, LIGHT)]
    for actor in actors:
        plotter.add_actor(actor)
    plotter.set_background("magenta")

    def paper() -> np.ndarray:
        plotter.render()
        return (np.asarray(plotter.screenshot(None, return_img=True)) == (255, 0, 255)).all(axis=2)

    culling = [actor.prop.culling for actor in actors]
    size = plotter.window_size = [640, 400]
    profile = profile_of(body)
    scale = vehicle.height / profile.height_m
    arch_m, middle_m = scale * profile.arch_radius_m, scale * profile.wheel_radius_m
    for azimuth in (-150.0, -30.0, 30.0, 150.0):
        orbit = OrbitCamera((0.0, 0.0, 0.6), 11.0, azimuth, 8.0)
        plotter.camera_position = [orbit.position_m(), orbit.focal_m, (0.0, 0.0, 1.0)]
        plotter.camera.view_angle = orbit.view_angle_deg
        for actor, usual in zip(actors, culling, strict=True):
            actor.prop.culling = usual
        shown = paper()
        for actor in actors:
            actor.prop.culling = "none"
        holes = shown & ~paper()
        for x in axles_x(profile, vehicle):
            side = np.sign(orbit.position_m()[1]) * vehicle.width / 2
            corners = [(x + way * arch_m, side, middle_m + up) for way in (-1, 1) for up in (-0.1, arch_m)]
            pixels = orbit.project(np.array(corners), tuple(size))[:, :2]
            (left, top), (right, bottom) = np.array([pixels.min(axis=0), pixels.max(axis=0)], int)
            assert holes[top:bottom, left:right].sum() <= 4, f"a hole at {x:g} m, seen from {azimuth:g}"


def test_moving_makes_nothing_anew(plotter):
    scene = DrawnScene(plotter)
    scene.prepare()

    def there() -> set[str]:
        return {prop.GetAddressAsString("") for prop in scene._stage.main.GetViewProps()}

    before = there()
    scene.set_quick(True)
    assert there() == before
    scene.show(replace(scene.state, vehicle=Vehicle(length=5.0)))
    assert len(there()) == len(before), "another car comes in the middle of a drag"


def test_glass_is_seen_through_and_mirrors_more_at_a_glancing_angle(plotter):
    scene = DrawnScene(plotter)
    scene.show(SceneState())
    scene.set_camera(AROUND[0])
    scene.prepare()
    clear = [part for part in scene._body._painted if part.is_clear]
    assert len(clear) == 1
    alpha = np.asarray(clear[0].mesh["rgb"])[:, 3]
    assert 150 < alpha.min() < 190 and alpha.max() > 200
